"""Equilibrium at rest, linearization about it and vibration modes."""
