"""Responses of a motion, and their evaluation with gradients."""
