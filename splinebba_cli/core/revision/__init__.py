"""Observations rejected, weighted anew and brought back: what changes the weights and solves again."""
