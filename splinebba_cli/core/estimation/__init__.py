"""Gauss-Markov estimation: parameters, elimination, sparse factorisation, datum, rank diagnosis."""
