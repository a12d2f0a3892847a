"""Projection of states onto the constraints, with its metric and tolerances."""
