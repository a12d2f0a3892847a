"""Mechanisms in other programs: layers of JAX and PyTorch, components of OpenMDAO. Each is imported by its own name."""
