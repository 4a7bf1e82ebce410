"""What the adjusted network is worth: dispersion, tests, redundancy, checks."""
