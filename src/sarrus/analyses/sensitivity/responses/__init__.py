"""Responses of a motion: what they are, and how they are evaluated with their gradients."""
