"""Expansion of a model into bodies, coordinates and elements, with checks of the whole model."""
