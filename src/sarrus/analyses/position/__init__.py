"""Assembly: coordinates and velocities that satisfy the constraints, their derivatives; initial states of analyses."""
