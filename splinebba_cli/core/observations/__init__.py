"""Observations: whitened residuals with Jacobians over a few parameter blocks; one file per kind."""
