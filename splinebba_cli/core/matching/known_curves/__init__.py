"""Matching against curves that the network has, with the adjustment in the loop."""
