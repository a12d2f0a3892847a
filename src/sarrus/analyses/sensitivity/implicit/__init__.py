"""Derivatives of results that equations determine: driven motions, inverse dynamics, equilibria, modes, linearizations.

An analysis solves F(y, b) = 0 for its states y, or derives modes or matrices from them. The derivatives of its
responses g(y, b) follow from the implicit function theorem: y' = -F_y⁻¹ F_b b' forward (direct),
∂g/∂b - F_bᵀ F_y⁻ᵀ ∂g/∂y backward (adjoint).
`responses` does this for all analyses; a file for each analysis has its equations.
"""
