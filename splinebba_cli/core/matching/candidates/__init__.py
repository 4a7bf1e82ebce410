"""Which curves pass near a measured point: every nearest place inside a radius, for a million points."""
