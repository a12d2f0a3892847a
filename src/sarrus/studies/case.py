"""One case of a study, computed in any process: system, analysis and responses."""

from __future__ import annotations

import pickle
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..model import SarrusError
from ..model.announcement import collecting
from .responses import Response
from .runs import Run
from .source import Source


class Outcome(NamedTuple):
    """The outcome of a case: the responses in their order, or a message; its time in seconds; and its warnings."""

    success: bool
    message: str
    responses: tuple[float, ...]
    seconds: float
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Task:
    """All that is the same in every case."""

    source: Source
    run: Run
    responses: tuple[Response, ...]
    time_limit: float = np.inf

    def packed(self) -> bytes:
        """Return the case in the form for another process.

        Raises
        ------
        SarrusError
            If it holds a function that no other process can import.
        """
        try:
            return pickle.dumps(self)
        except (pickle.PicklingError, AttributeError, TypeError) as wrong:
            message = f"this study cannot be sent to another process ({wrong})"
            raise SarrusError(
                f"{message}. Define its functions at the top of a module, or take workers=1."
            ) from None

    def outcome(self, values: Mapping[str, float]) -> Outcome:
        """Run one case; any failure is a message."""
        with collecting() as warnings:
            outcome = self._tried(values)
        return outcome._replace(warnings=warnings.messages)

    def _tried(self, values: Mapping[str, float]) -> Outcome:
        began = time.perf_counter()
        try:
            return Outcome(True, "", self._responses(values), time.perf_counter() - began)
        except SarrusError as error:
            message = self.source.readable(str(error))
        except Exception as wrong:
            message = f"{type(wrong).__name__}: {wrong}"
        nothing = (float("nan"),) * len(self.responses)
        return Outcome(False, message, nothing, time.perf_counter() - began)

    def _responses(self, values: Mapping[str, float]) -> tuple[float, ...]:
        system, start = self.source.made(values)
        times = tuple(t for response in self.responses for t in response.times())
        result = self.run.found(system, start, times, self.time_limit)
        cache: dict[str, Any] = {}

        def lookup(name: str) -> Any:
            if name not in cache:
                cache[name] = values[name] if name in values else result.lookup(name)
            return cache[name]

        return tuple(response.value(result.result, result.t, lookup) for response in self.responses)

    def prepare(self) -> None:
        """Compile all that cases need, so that worker processes find it in the cache; what fails here fails there."""
        short = self.run.short()
        if short is not None:
            replace(self, run=short).outcome({})


@lru_cache(maxsize=4)
def _task(packed: bytes) -> Task:
    task: Task = pickle.loads(packed)
    return task


def outcome_of(packed: bytes, values: Mapping[str, float]) -> Outcome:
    """Run one case of a task that was packed: what worker processes are asked for."""
    return _task(packed).outcome(values)
