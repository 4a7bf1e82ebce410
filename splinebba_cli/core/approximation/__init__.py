"""Approximate values: resection, intersection and curve shapes from measurements."""
