"""Where laws over time change: the times at which steps must end."""
