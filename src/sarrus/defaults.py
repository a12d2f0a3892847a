"""Default tolerances of simulations, in Python, in the shell and in studies alike."""

RTOL = 1e-6  # [-] relative, of the local error
ATOL = 1e-8  # [m, -] absolute
