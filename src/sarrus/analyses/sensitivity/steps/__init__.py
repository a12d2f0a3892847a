"""Derivatives of the steps of a run, derived from the description of its method: tangent, adjoint, second order.

`equations`: how each kind of equation depends on a stage, `tables` what follows for one operation of a method and
one system, `record` what a run adds. `blocks` and the loops know no method.
"""
