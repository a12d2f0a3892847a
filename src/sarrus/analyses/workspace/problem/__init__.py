"""The workspace problem: outputs and constraints as one set of equations, their checks, and random positions."""
