"""Estimates of the global error of responses: the defect of the motion between nodes, weighted by the adjoint.

Errors of their derivatives are in `derivatives`. How the size of steps is controlled while a run goes on is in
`dynamics.stepping`.
"""
