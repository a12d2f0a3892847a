"""A study in a file: the model, what is varied, how, and what is asked; every error with file and line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..model import Model, ModelError, SarrusError
from ..model.file.document import Document
from ..model.file.load import read
from ..model.show import suggest
from .conduct import Asked, ask
from .parameters import parameter_of
from .responses import responses_of
from .runs import run_of
from .samples import sample_of

KEYS = ("name", "model", "parameters", "responses", "analysis", "sample", "time_limit")
NEEDED = ("model", "parameters", "responses", "analysis")
Read = Callable[[Path], Model]


@dataclass(frozen=True)
class _Part:
    """What stands under a key of the file."""

    document: Document
    path: tuple[str | int, ...]

    def read(self, reader: Callable[[Any], Any]) -> Any:
        """What the reader makes of it; errors name the file and the line."""
        given = self.document.data
        for step in self.path:
            given = given[step]
        try:
            return reader(given)
        except SarrusError as wrong:
            where = self.document.origin.where(self.path)
            raise ModelError(
                str(wrong), where=where, part=f"study, {'.'.join(map(str, self.path))}"
            ) from None


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
    document = read(place)
    _check_keys(document)
    data = document.data
    parameters = {
        name: _Part(document, ("parameters", name)).read(parameter_of) for name in data["parameters"]
    }
    responses = _Part(document, ("responses",)).read(responses_of)
    run = _Part(document, ("analysis",)).read(run_of)
    sample = _Part(document, ("sample",)).read(sample_of) if "sample" in data else None
    model = load(place.parent / str(data["model"]))
    name, limit = str(data.get("name", place.stem)), float(data.get("time_limit", "inf"))
    wanted = {one.name: one.of for one in responses}
    whole = _Part(document, ("parameters",))
    found: Asked = whole.read(
        lambda _: ask(model, parameters, wanted, analysis=run, sample=sample, name=name, time_limit=limit)
    )
    return found


def _check_keys(document: Document) -> None:
    data: Any = document.data
    if not isinstance(data, dict):
        raise ModelError(
            "a study file is a mapping with the keys " + ", ".join(KEYS), where=document.origin.file
        )
    for key in data:
        if key not in KEYS:
            where = document.origin.where((key,))
            raise ModelError(f"a study has no key {key!r}; {suggest(str(key), KEYS)}", where=where)
    for key in NEEDED:
        if key not in data:
            raise ModelError(f"the study lacks the key {key!r}; give it", where=document.origin.file)
    if not isinstance(data["parameters"], dict):
        where = document.origin.where(("parameters",))
        raise ModelError("parameters must be a mapping of names to values", where=where)
