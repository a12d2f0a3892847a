"""Lagrangians of an operation's equations, recorded element by element: their gradients, and the changes of these.

`elements` records what one element adds; `by_parameters` is its gradient by parameters, `changes` and `curves` are the
contracted second derivatives. No sweep is here.
"""
