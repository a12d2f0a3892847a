"""Energies and powers along a motion."""
