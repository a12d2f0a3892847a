"""A mechanism as an environment of Gymnasium, for reinforcement learning."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..algebra import Array
from ..analyses import Radau, Stepper
from ..model import SarrusError
from ..system import System

try:
    import gymnasium
except ImportError:
    raise ImportError("this bridge needs Gymnasium. Install it with: pip install sarrus[gym]") from None


class MechanismEnv(gymnasium.Env[Array, Array]):
    """Actions are inputs of a system, observations its outputs; a `Stepper` integrates from sample to sample.

    Parameters
    ----------
    system : System
    step : length of a sample [s]
    inputs : name -> limits, ``{"u": (-5, 5)}``; actions beyond them are cut
    outputs : names of the observations, see `Stepper`
    reward : f(observation, action) after a sample
    terminated : f(observation), whether an episode ends; by default never
    start : f(random) -> start of a `Stepper`, such as ``{"rates": {"pin": random.normal()}}``; by default that of the
        model
    samples : of an episode at most, after which it is truncated
    rtol : relative tolerance

    Notes
    -----
    A motion that cannot go on ends the episode; the message is in ``info["message"]``.
    """

    def __init__(
        self,
        system: System,
        *,
        step: float,
        inputs: Mapping[str, tuple[float, float]],
        outputs: Sequence[str],
        reward: Callable[[Array, Array], float],
        terminated: Callable[[Array], bool] | None = None,
        start: Callable[[np.random.Generator], Any] | None = None,
        samples: int = 1000,
        rtol: float = 1e-6,
    ) -> None:
        self._system = system
        method = Radau(rtol=rtol)
        self._options: dict[str, Any] = {
            "step": step, "inputs": [*inputs], "outputs": outputs, "method": method
        }  # fmt: skip
        self._reward, self._terminated, self._start, self._samples = reward, terminated, start, samples
        self._low, self._high = (np.array([limits[n] for limits in inputs.values()]) for n in (0, 1))
        self.action_space = gymnasium.spaces.Box(self._low, self._high, dtype=np.float64)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (len(outputs),), np.float64)
        self.stepper = Stepper(system, None, **self._options)
        self._first, self._count = self.stepper.state(), 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin an episode; returns the observation and an empty mapping."""
        super().reset(seed=seed)
        self._count = 0
        if self._start is None:
            self.stepper.restore(self._first)
        else:
            self.stepper = Stepper(self._system, self._start(self.np_random), **self._options)
        return self.stepper.values, {}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Take one sample; returns observation, reward, terminated, truncated, info."""
        u = np.clip(action, self._low, self._high)
        info: dict[str, Any] = {}
        try:
            seen = self.stepper.advance(u)
        except SarrusError as failure:
            seen, info = self.stepper.values, {"message": str(failure)}
        self._count += 1
        ended = bool(info) or bool(self._terminated and self._terminated(seen))
        return seen, float(self._reward(seen, u)), ended, self._count >= self._samples, info
