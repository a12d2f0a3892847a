"""Degrees of freedom and redundant constraints at a configuration."""
