"""Pieces of tie curves found from image chains: places in space with their dispersion and the points they explain."""
