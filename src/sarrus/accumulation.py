"""Integrals of powers along a run, registered by the analysis that computes them; outputs do not import it.

The package registers it when it is imported; it is loaded when the first energy since the start is asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

Accumulator = Callable[[Any, Any, Sequence[str]], Any]
_loaders: list[Callable[[], Accumulator]] = []


def register(load: Callable[[], Accumulator]) -> None:
    """Let a function of a system, a run and names of outputs, loaded when it is needed, integrate from now on."""
    _loaders.append(load)


def accumulator() -> Accumulator:
    """The function that was registered last, loaded."""
    return _loaders[-1]()
