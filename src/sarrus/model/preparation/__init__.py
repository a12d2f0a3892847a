"""Preparation of a model that is created: texts become numbers, and moving points of the ground points of bodies."""
