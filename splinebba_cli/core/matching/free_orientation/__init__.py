"""Orientations of images of which nothing is known."""
