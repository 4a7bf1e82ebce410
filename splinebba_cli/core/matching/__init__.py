"""Correspondence: image points to curves, curves to shapes, images to the block (Lee 4.3)."""
