"""Curves of candidates for the boundary: where they start, how they are traced and what happens along them."""
