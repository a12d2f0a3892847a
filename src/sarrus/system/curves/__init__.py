"""Derivatives of the operators along curves of states, for many times at once."""
