"""Examination of functions of time and state before and during a run: the times at which steps must end."""
