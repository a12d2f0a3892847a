"""Gradients of runs that store no steps."""

from typing import Any

import sarrus as sr

OPTIONS = ("memory", "progress", "time_limit", "design", "formula")


def by_checkpoints(
    system: sr.System, responses: Any, wrt: Any = None, *, until: Any, memory: Any = 100e6, **settings: Any
) -> sr.Gradient:
    """That of a run, which is repeated with its steps, in a given memory."""
    own = {name: settings.pop(name) for name in OPTIONS if name in settings}
    run = sr.simulate(system, until=until, **settings)
    return sr.sensitivity(run, responses, wrt, memory=memory, **own)
