"""Simulations in other programs: JAX, PyTorch, OpenMDAO and Gymnasium, each imported by its own name."""
