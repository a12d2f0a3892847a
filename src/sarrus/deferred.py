"""Functions of higher layers that lower ones call without importing them.

The package registers each when it is imported; it is loaded when it is first needed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class Deferred:
    """A function or a module, by a function that loads it."""

    def __init__(self) -> None:
        self._loaders: list[Callable[[], Any]] = []

    def register(self, load: Callable[[], Any]) -> None:
        """Let what this loads be used from now on."""
        self._loaders.append(load)

    def __call__(self) -> Any:
        """Load and return the function that was registered last."""
        return self._loaders[-1]()


importer = Deferred()  # `sarrus.io.load_any`
exporter = Deferred()  # `sarrus.io.export`
renderer = Deferred()  # a module with the functions of `sarrus.views`
estimator = Deferred()  # a function of a run and of responses that estimates their errors
accumulator = Deferred()  # a function that integrates the named outputs of a system along a run
saver = Deferred()  # a function that writes a run to a folder
equilibrium = Deferred()  # a function of a system and a time: its equilibrium
forward = Deferred()  # a class of functions of a system's state: forward dynamics
sharers = Deferred()  # a function of a system, its result and names of outputs: the joints that share them
# a function of a system: its parameters, with rounded data of redundant joints corrected
corrector = Deferred()
