"""Saved runs and exported files: checksums, locks, array formats. What is saved is defined by the results."""
