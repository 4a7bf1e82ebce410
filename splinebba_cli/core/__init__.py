"""The numerical core: numpy and scipy only; knows no file, no pydantic and no console."""
