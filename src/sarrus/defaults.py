"""Default tolerances of simulations, in Python, in the shell, in files, studies and searches alike.

The default method is Radau IIA, see `analyses.dynamics.simulation.differentiable`.
"""

RTOL = 1e-9  # [-] of the local error, over the size of the motion
RTOL_OF_ORDER_2 = 1e-6  # [-] the same for HHT and generalized-α, whose steps would become too many
ATOL = None  # absolute tolerances follow the size of the motion, see `stepping.motion_scale`
