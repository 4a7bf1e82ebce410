"""Projects to start from: small blocks that adjust at once, with notes on what to replace by own data."""
