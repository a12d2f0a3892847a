"""A study in a file: the model, what is varied, how, and what is asked; every error with file and line."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

from ..model import Model
from ..model.file.load import read
from ..system import System
from .conduct import Asked, ask
from .entries import Entries
from .parameters import parameter_of, seconds
from .responses import responses_of
from .runs import run_of
from .samples import sample_of
from .units import refuse_other_units

KEYS = ("name", "model", "parameters", "responses", "analysis", "sample", "time_limit")
NEEDED = ("model", "parameters", "responses", "analysis")
Read = Callable[[Path], Model]


def read_study_file(path: str | Path, load: Read) -> Asked:
    """Read a study from a YAML or JSON file and check all of it.

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
    file = Entries(read(place), "a study", "study, ")
    file.check_keys(KEYS, NEEDED)
    file.check_kind("parameters", dict, "a mapping of names to values")
    data = file.document.data
    parameters = {name: file.part(parameter_of, "parameters", name) for name in data["parameters"]}
    responses = file.part(responses_of, "responses")
    run = file.part(partial(run_of, folder=place.parent), "analysis")
    sample = file.part(sample_of, "sample") if "sample" in data else None
    file.check_kind("model", str, "the name of a file")
    file.check_kind("name", str, "a text")
    model = load(place.parent / data["model"])
    run = file.part(lambda _: run.started(System(model)), "analysis")
    name, limit = (
        data.get("name", place.stem),
        file.part(seconds, "time_limit") if "time_limit" in data else inf,
    )
    wanted = {one.name: one.of for one in responses}

    def asked(_: Any) -> Asked:
        return ask(model, parameters, wanted, analysis=run, sample=sample, name=name, time_limit=limit)

    found: Asked = file.part(asked, "parameters")
    for changed in parameters:
        file.part(partial(refuse_other_units, model, changed), "parameters", changed)
    return found
