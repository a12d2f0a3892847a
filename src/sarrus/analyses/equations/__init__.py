"""Equations of a system at one state: motion, constraints and projections, and the sizes that they are compared with.

Analyses of whole motions are in the other folders.
"""
