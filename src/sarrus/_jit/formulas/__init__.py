"""Formulas: recorded, differentiated, replayed, with curves of values."""
