"""Curves as a basis times coefficients; one file per family."""
