"""Motion in samples: the stepper, sampled controllers, and environments for reinforcement learning."""
