"""Synthetic blocks with truth: geometry, features, noise."""
