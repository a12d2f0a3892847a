"""Errors of derivatives: by those of states, by changes of the steps, by growth, vibrations, samples and round-off."""
