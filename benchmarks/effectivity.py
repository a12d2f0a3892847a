"""How good estimates of errors are: estimated over true error of every known output at the end of the motion."""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from accuracy_problems.problem import KINDS, Problem, as_column

import sarrus as sr

PATIENCE = 60.0  # s for a run
CALLS = 5  # of which the quickest counts
# Effectivities that are good: of smooth problems, of the others
WITHIN = {True: (0.3, 3.0), False: (0.1, 10.0)}


class Estimated(NamedTuple):
    """An output of a problem."""

    smooth: bool
    name: str
    true: float
    estimate: float
    cost: float  # of the estimate over that of a gradient

    @property
    def known(self) -> bool:
        """Whether the true error can be told from errors of what is known and from round-off."""
        return np.isfinite(self.true)

    @property
    def good(self) -> bool:
        """Whether the effectivity is."""
        low, high = WITHIN[self.smooth]
        return low <= self.estimate / self.true <= high


def estimates(problem: Problem, **settings: Any) -> Iterator[Estimated]:
    """Of one problem with some settings; nothing for a run that fails."""
    known, (system, start) = problem.solution(), problem.make()
    given = {"events": problem.events, "limits": sr.Limits(time=PATIENCE), "store": "steps", **settings}
    run = sr.simulate(system, start, until=known.t[-1], t_eval=known.t, **given)
    if not run.success:
        print(f"{problem.name}: {run.status}")
        return
    kinds = [kind for kind in KINDS if kind in problem.read]
    columns = [as_column(one) for kind in kinds for one in problem.read[kind]]
    names = list(dict.fromkeys(name for column in columns for name in column.outputs))
    exact = np.concatenate([getattr(known, kind) for kind in kinds], axis=1)
    found = dict(zip(names, run.error(names), strict=True))
    cost = _cost(run, names[0])
    for (parts, start), last, size in zip(columns, exact[-1], np.abs(exact).max(axis=0), strict=True):
        true = start + sum(k * found[name].value for name, k in parts.items()) - last
        estimate, round_off = (
            sum(k * getattr(found[name], field) for name, k in parts.items())
            for field in ("estimate", "round_off")
        )
        resolved = abs(true) > max(problem.exact * size, 10 * abs(round_off))
        yield Estimated(problem.smooth, " ".join(parts), true if resolved else np.nan, estimate, cost)


def _cost(run: sr.Trajectory, name: str) -> float:
    """Processor time of an estimate over that of a gradient: the least of alternating calls."""
    calls = run.error, partial(sr.sensitivity, run)
    least = [np.inf, np.inf]
    for _ in range(CALLS):
        for n, call in enumerate(calls):
            begun = time.process_time()
            call(name)
            least[n] = min(least[n], time.process_time() - begun)
    return least[0] / least[1]


def effectivities(problems: Sequence[Problem], **settings: Any) -> str:
    """Print all of them; how many are good, in words."""
    rows = list[Estimated]()
    print(f"{'problem':40s}{'output':32s}{'true':>11s}{'estimate':>11s}{'ratio':>8s}{'cost':>7s}")
    for problem in problems:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for row in estimates(problem, **settings):
                print(
                    f"{problem.name:40s}{row.name:32s}{row.true:11.2e}{row.estimate:11.2e}"
                    f"{row.estimate / row.true:8.2f}{row.cost:7.2f}",
                    flush=True,
                )
                rows.append(row)
    return "\n".join(_shares(rows, smooth) for smooth in (True, False))


def _shares(rows: Sequence[Estimated], smooth: bool) -> str:
    known = [row for row in rows if row.known and row.smooth == smooth]
    good, (low, high) = sum(row.good for row in known), WITHIN[smooth]
    kind = "smooth" if smooth else "other"
    return f"{good} of {len(known)} outputs of {kind} problems between {low} and {high}"
