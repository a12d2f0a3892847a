"""An optimization or a fit in a file: model, variables and objective; errors name the file and the line."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any

from ..analyses import Misfit, Within, fit, optimize
from ..analyses.optimization.solvers import SOLVERS
from ..analyses.sensitivity.combined import Composite, Part
from ..model import Model, SarrusError
from ..model.file.load import read
from ..model.show import suggest
from ..results import Optimum
from ..system import System
from .file import Entries
from .parameters import number, refuse_other_units, seconds, whole
from .responses import Response, differentiable
from .runs import Run, Simulation, run_of
from .source import Source

KEYS = (
    "name", "model", "parameters", "minimize", "fit", "noise", "constraints", "analysis", "solver", "starts", "seed",
    "iterations", "time_limit", "second_order",
)  # fmt: skip
ONLY = {"minimize": ("constraints", "solver", "starts", "seed", "second_order"), "fit": ("noise",)}
Read = Callable[[Path], Model]


@dataclass(frozen=True)
class DesignTask:
    """An optimization or a fit that was checked.

    Attributes
    ----------
    name, system : of what
    bounds : limits by name of the number
    run : the analysis of a design
    objective : what is made least; none for a fit
    constraints : of an optimization
    misfits : of a fit
    options : of `optimize` or `fit`
    """

    name: str
    system: System
    bounds: Mapping[str, tuple[float, float]]
    run: Run
    objective: Part | None = None
    constraints: Sequence[Within] = ()
    misfits: Sequence[Misfit] = ()
    options: Mapping[str, Any] = field(default_factory=dict)

    def solved(
        self, progress: Callable[[int, float], None] | None = None, total_time_limit: float | None = None
    ) -> Optimum:
        """The optimum, or the best design by a time limit."""
        run, analysis = self.run, dict[str, Any](analysis=self.run)
        if isinstance(run, Simulation):
            analysis = {"method": run.method, "until": run.until, "start": run.start}
        limits = {"bounds": self.bounds, "progress": progress, "total_time_limit": total_time_limit}
        options: dict[str, Any] = {**analysis, **self.options, **limits}
        if self.objective is None:
            return fit(self.system, self.misfits, list(self.bounds), **options)
        options["constraints"] = self.constraints
        return optimize(self.system, self.objective, list(self.bounds), **options)


def read_optimization_file(path: str | Path, load: Read) -> DesignTask:
    """Read an optimization or a fit from a YAML or JSON file and check all of it.

    Parameters
    ----------
    path : of the file
    load : reads the model, whose name is relative to the file

    Raises
    ------
    ModelError
        For anything that is wrong: file and line, what, and what to do.
    """
    place = Path(path)
    file = Entries(read(place), "an optimization")
    _check(file)
    data = file.document.data
    run = file.part(partial(run_of, folder=place.parent), "analysis")
    model = load(place.parent / data["model"])
    changes = {name: file.part(_change, "parameters", name) for name in data["parameters"]}
    source = Source.of(model)
    file.part(lambda _: source.check(changes), "parameters")
    for name in changes:
        file.part(partial(refuse_other_units, model, name), "parameters", name)
    begin = {name: start for name, (_, start) in changes.items() if start is not None}
    system = source.made(begin)[0] if begin else System(model)
    run = file.part(lambda _: run.started(system), "analysis")
    options = {key: file.part(reader, key) for key, reader in OPTIONS.items() if key in data}
    sought = {"name": data.get("name", place.stem), "system": system, "run": run, "options": options}
    bounds = {name: limits for name, (limits, _) in changes.items()}
    if "fit" in data:
        misfit = partial(_misfit, folder=place.parent)
        misfits = [file.part(misfit, "fit", k) for k in range(len(data["fit"]))]
        return DesignTask(bounds=bounds, misfits=misfits, **sought)
    known = partial(_differentiable, run, system)
    objective = file.part(lambda text: known(Response("objective", str(text))), "minimize")
    within = partial(_within, known=known)
    names = data.get("constraints", {})
    constraints = [file.part(partial(within, name), "constraints", name) for name in names]
    return DesignTask(bounds=bounds, objective=objective, constraints=constraints, **sought)


def _check(file: Entries) -> None:
    """Refuse unknown, missing and contradictory keys."""
    file.check_keys(KEYS, ("model", "parameters", "analysis"))
    data = file.document.data
    if ("minimize" in data) == ("fit" in data):
        raise file.refused("one of minimize and fit is needed. Give one of them.")
    other = "fit" if "minimize" in data else "minimize"
    for key in ONLY[other]:
        if key in data:
            raise file.refused(f"{key!r} belongs to {other!r}. Leave it out.", key)
    file.check_kind("model", str, "the name of a file")
    file.check_kind("name", str, "a text")
    for key in ("parameters", "constraints"):
        file.check_kind(key, dict, "a mapping of names")
    file.check_kind("fit", list, "a list of measurements")


def _differentiable(run: Run, system: System, response: Response) -> Part:
    """A response of an analysis with its derivatives; one that the analysis does not have is refused."""
    run.check(system, [response], ())
    until: float = getattr(run, "until", run.begin)
    differentiated = differentiable(response)
    histories = [part.title for part in Composite([differentiated]).parts if not part.pointwise]
    if histories and until == run.begin:
        about = f"{histories[0]}: the analysis {run.kind} has one state without a history"
        raise SarrusError(f"{about}. Use final(...).")
    return differentiated


def _known(mapping: Any, keys: tuple[str, ...], entry: str) -> dict[str, Any]:
    if not isinstance(mapping, dict):
        raise SarrusError(f"{entry} is a mapping with the keys {', '.join(keys)}. Write it as one.")
    for key in mapping:
        if key not in keys:
            raise SarrusError(f"{entry} has no key {key!r}. {suggest(str(key), keys)}")
    return mapping


def _change(entry: Any) -> tuple[tuple[float, float], float | None]:
    """Limits and start of ``{from: 1, to: 60, start: 10}``; any of them may be missing."""
    mapping = _known(entry or {}, ("from", "to", "start"), "a number that may change")
    low, high = number(mapping.get("from", float("-inf"))), number(mapping.get("to", float("inf")))
    if not low < high:
        raise SarrusError(f"its limits must rise, but are {low:g} and {high:g}")
    start = number(mapping["start"]) if "start" in mapping else None
    if start is not None and not low <= start <= high:
        raise SarrusError(f"its start {start:g} is not between {low:g} and {high:g}")
    return (low, high), start


def _within(name: str, entry: Any, *, known: Callable[[Response], Part]) -> Within:
    mapping = _known(entry, ("of", "lower", "upper"), "a constraint")
    if "of" not in mapping:
        raise SarrusError("a constraint lacks its formula. Add the key of.")
    limits = {key: number(mapping[key]) for key in ("lower", "upper") if key in mapping}
    return Within(known(Response(str(name), str(mapping["of"]))), **limits)


def _misfit(entry: Any, folder: Path) -> Misfit:
    mapping = _known(entry, ("of", "file", "time", "column", "sigma"), "a measurement")
    for key in ("of", "file", "sigma"):
        if key not in mapping:
            raise SarrusError(f"a measurement lacks the key {key!r}. Add it.")
    output = str(mapping["of"])
    names = str(mapping.get("time", "t")), str(mapping.get("column", output))
    t, measured = _columns(folder / str(mapping["file"]), *names)
    sigma = number(mapping["sigma"])
    if not sigma > 0:
        raise SarrusError(
            f"sigma must be greater than 0, but is {sigma:g}. Give the standard deviation of the data."
        )
    return Misfit(output, name=output, at=tuple(t), data=tuple(measured), sigma=sigma)


def _columns(path: Path, *names: str) -> list[list[float]]:
    """Two columns of a table with a head, in SI units."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            table = list(csv.DictReader(file))
    except OSError:
        raise SarrusError(f"{path}: cannot be read. Check the path.") from None
    known = {name.partition(" [")[0]: name for name in (table[0] if table else ())}  # "t" is "t [s]", too
    known |= {name: name for name in known.values()}
    for name in names:
        if name not in known:
            raise SarrusError(
                f"{path}: has no column {name!r}. {suggest(name, known) if known else 'It is empty.'}"
            )
    return [[_cell(path, row[known[name]]) for row in table] for name in names]


def _cell(path: Path, text: str) -> float:
    try:
        value = float(text)
    except (TypeError, ValueError):
        value = float("nan")
    if not isfinite(value):
        raise SarrusError(f"{path}: holds {text!r}, which is no number. Correct it.")
    return value


def _solver(name: Any) -> str:
    if not isinstance(name, str) or name not in SOLVERS:
        raise SarrusError(f"there is no solver {name!r}. {suggest(str(name), SOLVERS)}")
    return str(name)


def _second_order(value: Any) -> bool:
    if not isinstance(value, bool):
        raise SarrusError(f"second_order is true or false, but not {value!r}. Write one of both.")
    return value


def _noise(value: Any) -> str:
    if value not in ("given", "estimated"):
        raise SarrusError(f"noise is given or estimated, but not {value!r}. Write one of both.")
    return str(value)


OPTIONS: dict[str, Callable[[Any], Any]] = {
    "noise": _noise,
    "solver": _solver,
    "second_order": _second_order,
    "starts": lambda value: whole(value, "starts"),
    "seed": lambda value: whole(value, "seed", least=0),
    "iterations": lambda value: whole(value, "iterations"),
    "time_limit": seconds,
}
