"""The user's project file: reading, validating, diagnosing, building the network."""
