"""The result of a study: a table with a row for each case."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ..deferred import renderer
from ..model import SarrusError
from ..model.announcement import announce
from ..model.checks.arguments import checked, refuse_place
from ..model.deprecated import with_former_names
from ..model.read_only import read_only
from ..results.motion.tables import INSTALL
from ..results.result import Result
from ..results.saving.exported_file import write_table
from .ledger import read_cases, read_study
from .parameters import Array

MOST = 3  # messages of a summary, the most frequent ones


@with_former_names
@dataclass(frozen=True, eq=False)
class StudyTable(Result):
    """Results of a study: parameters and responses of all cases.

    Attributes
    ----------
    name : of the study
    parameters, responses : names of the columns
    values : (n, p) of the parameters
    found : (n, r) values of the responses, NaN if a case failed or was not run
    success : (n,) whether the case succeeded
    messages : a message for each failed case, an empty text for the others
    seconds : (n,) duration of each case
    facts : description of the study: model, sample with its seed, analysis, responses, versions
    status : "finished", "time limit", "stopped" or "not saved", and "unfinished" where the folder lacks cases; cases
        that were not run have no success and no message
    execution : number of processes, and the reason
    case_warnings : the warnings of the cases that have any, by number; ``warnings`` counts the most frequent ones
    """

    name: str
    parameters: tuple[str, ...]
    responses: tuple[str, ...]
    values: Array = field(repr=False)
    found: Array = field(repr=False)
    success: Array = field(repr=False)
    messages: tuple[str, ...] = field(repr=False)
    seconds: Array = field(repr=False)
    facts: Mapping[str, object] = field(default_factory=dict, repr=False)
    case_warnings: Mapping[int, tuple[str, ...]] = field(default_factory=dict, repr=False)
    status: str = "finished"
    execution: str = field(default="", repr=False)

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, name: str) -> Array:
        """A column: a parameter or a response (n,).

        Raises
        ------
        KeyError
            If there is no such column.
        """
        names = (*self.parameters, *self.responses)
        if name not in names:
            raise KeyError(
                f"no column {name!r} in the study {self.name}. Its columns are {', '.join(names)}."
            )
        both = np.column_stack([self.values, self.found])
        column: Array = read_only(both[:, names.index(name)])
        return column

    def _ipython_key_completions_(self) -> list[str]:
        return [*self.parameters, *self.responses]

    @property
    def units(self) -> Mapping[str, str]:
        """The units of parameters and responses by name, if known."""
        units: Any = self.facts.get("units", {})
        return dict(units)

    @property
    def columns(self) -> dict[str, Any]:
        """All columns by name, with ``success``, ``message`` and ``seconds``."""
        numbers = {name: self[name] for name in (*self.parameters, *self.responses)}
        texts = np.array(self.messages, dtype=object)
        return {**numbers, "success": self.success, "message": texts, "seconds": self.seconds}

    @property
    def failures(self) -> dict[int, str]:
        """The message of every failed case by its number."""
        return {
            case: message for case, message in enumerate(self.messages) if not self.success[case] and message
        }

    def best(self, response: str, count: int = 1, *, largest: bool = False) -> list[dict[str, float]]:
        """Return the cases with the smallest (or largest) response: parameters and responses by name."""
        column = self[response] * (-1.0 if largest else 1.0)
        order = [int(case) for case in np.argsort(column, kind="stable") if np.isfinite(column[case])]
        return [self.case(case) for case in order[:count]]

    def case(self, number: int) -> dict[str, float]:
        """Return one case: parameters and responses by name."""
        refuse_place("number", number, len(self.values))
        both = np.concatenate([self.values[number], self.found[number]])
        return {n: float(x) for n, x in zip((*self.parameters, *self.responses), both, strict=True)}

    def distinct(self, *responses: str, tolerance: float = 1e-6) -> list[tuple[int, int]]:
        """Return the different results among the cases, each with its number of cases.

        Two cases are alike if their responses differ by less than `tolerance`, in proportion where they exceed 1.

        Parameters
        ----------
        responses : which to compare; by default all
        """
        names = responses or self.responses
        ends = np.column_stack([self[name] for name in names]) if names else np.zeros((len(self), 0))
        kinds: dict[int, int] = {}
        for case in np.flatnonzero(self.success):
            alike = (other for other in kinds if _close(ends[other], ends[case], tolerance))
            key = next(alike, int(case))
            kinds[key] = kinds.get(key, 0) + 1
        return sorted(kinds.items(), key=lambda kind: -kind[1])

    def statistics(self) -> dict[str, dict[str, float]]:
        """Return mean, standard deviation, minimum, median and maximum of every response over the successful cases."""
        values = {name: self[name][np.asarray(self.success, dtype=bool)] for name in self.responses}
        return {
            name: {word: float(of(x)) if len(x) else np.nan for word, of in STATISTICS.items()}
            for name, x in values.items()
        }

    def to_array(self) -> np.ndarray[Any, Any]:
        """Return a structured NumPy array with all columns except the messages."""
        numbers = {name: column for name, column in self.columns.items() if name != "message"}
        kinds = [(name, np.asarray(column).dtype) for name, column in numbers.items()]
        rows = np.zeros(len(self), dtype=kinds)
        for name, column in numbers.items():
            rows[name] = column
        return rows

    def to_frame(self) -> Any:
        """Return the table as a pandas DataFrame, units in ``frame.attrs["units"]``; needs the extra `tables`.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        try:
            frame = import_module("pandas").DataFrame(self.columns)
        except ImportError:
            raise ImportError(f"to_frame needs pandas. Install it with: {INSTALL}") from None
        frame.attrs["units"] = self.units
        return frame

    def to_csv(self, path: str | Path) -> None:
        """Write all columns, numbers with all their digits."""
        rows = enumerate(zip(*self.columns.values(), strict=True))
        table = ((case, *map(_written, row)) for case, row in rows)
        write_table(path, ["case", *self.columns], table)

    def plot(self, *responses: str, ax: Any = None) -> Any:
        """Draw responses over the parameters that change, two as a contour; see `sarrus.views.plot_study`."""
        return renderer().plot_study(self, *responses, ax=ax)

    def summary(self) -> str:
        """The result in words."""
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        failed, missing = len(self.failures), len(self) - int(np.sum(self.success)) - len(self.failures)
        message = f", {failed} without a result" if failed else ""
        message += f", {missing} not run" if missing else ""
        yield f"{self.name}: {len(self)} cases{message}, {self.seconds.sum():.3g} s of computing"
        width = max([8, *(len(name) for name in self.responses)])
        yield f"{'response':<{width}}" + "".join(f"{word:>14}" for word in STATISTICS)
        for name, numbers in self.statistics().items():
            yield f"{name:<{width}}" + "".join(f"{x:>14.6g}" for x in numbers.values())
        for message, count in Counter(self.failures.values()).most_common(MOST):
            yield f"{count} failed: {message}"


STATISTICS: dict[str, Callable[[Array], Any]] = {
    "mean": np.mean,
    "std": lambda x: x.std(ddof=1) if len(x) > 1 else 0.0,
    "least": np.min,
    "median": np.median,
    "largest": np.max,
}


def _close(a: Array, b: Array, tolerance: float) -> bool:
    return bool(np.all(abs(a - b) <= tolerance * np.maximum(1.0, np.maximum(abs(a), abs(b)))))


def _written(entry: Any) -> Any:
    return repr(float(entry)) if isinstance(entry, float | np.floating) else entry


@checked
def open_study(folder: str | Path) -> StudyTable:
    """Read the results of a study from its folder, also while it runs or after an interruption.

    Raises
    ------
    SarrusError
        If the folder holds no study, or one that is damaged or in another format.
    """
    facts = read_study(Path(folder))
    outcomes = dict(read_cases(Path(folder), facts))
    table = table_of(facts, outcomes)
    if len(outcomes) == len(table):
        return table
    message = (
        f"{table.name}: {len(outcomes)} of {len(table)} cases are done, and statistics are of these alone. "
        "Repeat the call of the study with this folder to run the others."
    )
    return replace(table, status="unfinished", warnings=(*announce([message]), *table.warnings))


def table_of(facts: Mapping[str, Any], outcomes: Mapping[int, Any]) -> StudyTable:
    """The table of the outcomes so far."""
    values = np.array(facts["cases"], dtype=float)
    responses = tuple(facts["responses"])
    n, r = len(values), len(responses)
    results, success, seconds = np.full((n, r), np.nan), np.zeros(n, dtype=bool), np.zeros(n)
    messages = [""] * n
    for case, outcome in outcomes.items():
        if not case < n:
            raise SarrusError(
                f"{facts['name']}: the results hold a case {case}, but there are {n}. "
                "Repeat the study in another folder."
            )
        results[case], success[case] = outcome.responses, outcome.success
        seconds[case], messages[case] = outcome.seconds, outcome.message
    warned = {case: outcome.warnings for case, outcome in sorted(outcomes.items()) if outcome.warnings}
    names = tuple(facts["parameters"])
    columns = values.reshape(n, len(names)), results, success, tuple(messages), seconds
    warnings = tuple(_warnings(warned, n))
    return StudyTable(facts["name"], names, responses, *columns, facts, warned, warnings=warnings)


def _warnings(warned: Mapping[int, tuple[str, ...]], cases: int) -> Iterator[str]:
    """The most frequent warnings of the cases, and how many others there are."""
    counts = Counter(message for messages in warned.values() for message in messages)
    for message, count in counts.most_common(MOST):
        yield f"{message} ({count} of {cases} cases)"
    if (others := len(counts) - MOST) > 0:
        yield f"{others} other warnings in {len(warned)} of {cases} cases. See `case_warnings`."
