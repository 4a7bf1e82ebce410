"""Whole jobs, from the project file to the result folder, without a console."""
