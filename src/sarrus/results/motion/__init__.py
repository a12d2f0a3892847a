"""Results over time: trajectories, the steps that integrators took, events, motions and reactions of parts."""
