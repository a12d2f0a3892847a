"""Simulations in other programs: JAX, PyTorch, and OpenMDAO components, each imported by its own name."""
