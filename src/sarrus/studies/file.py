"""A study in a file, and the checked entries and units of such files; every error with file and line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

from ..model import Model, ModelError, SarrusError
from ..model.file.load import read
from ..model.file.text.document import Document
from ..model.show import suggest
from ..system import System
from .conduct import Request, ask
from .parameters import parameter_of, refuse_other_units, seconds
from .responses import responses_of
from .runs import run_of
from .samples import sample_of

KEYS = ("name", "model", "parameters", "responses", "analysis", "sample", "time_limit")
EXAMPLES = {
    "model": "model: crank.yaml",
    "parameters": "parameters: {spring.k: {from: 5, to: 20}}",
    "responses": "responses: {end: slider.x}",
    "analysis": "analysis: {type: simulate, until: 2}",
}
NEEDED = tuple(EXAMPLES)
Read = Callable[[Path], Model]


def read_study_file(path: str | Path, load: Read) -> Request:
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
    name = data.get("name", place.stem)
    limit = file.part(seconds, "time_limit") if "time_limit" in data else inf
    formulas = {response.name: response.of for response in responses}

    def request(_: Any) -> Request:
        return ask(model, parameters, formulas, analysis=run, sample=sample, name=name, time_limit=limit)

    for changed in parameters:
        file.part(partial(refuse_other_units, model, changed), "parameters", changed)
    study: Request = file.part(request, "parameters")
    return study


@dataclass(frozen=True)
class Entries:
    """The content of a file.

    Attributes
    ----------
    document : as it was read
    what : is described by it, "a study"
    kind : precedes the names of keys in errors, "study, "
    """

    document: Document
    what: str
    kind: str = ""

    def part(self, reader: Callable[[Any], Any], *path: str | int) -> Any:
        """Return the object of an entry; errors name the file and the line."""
        entry: Any = self.document.data
        for step in path:
            entry = entry[step]
        try:
            return reader(entry)
        except (SarrusError, ValueError) as wrong:
            where, part = self.document.origin.where(path), ".".join(map(str, path))
            raise ModelError(str(wrong), where=where, part=self.kind + part) from None

    def refused(self, message: str, *path: str | int) -> ModelError:
        """An error with the line of an entry, or the name of the file."""
        origin = self.document.origin
        return ModelError(message, where=origin.where(path) if path else origin.file)

    def check_keys(self, keys: Sequence[str], needed: Sequence[str]) -> None:
        """Refuse unknown and missing keys."""
        data: Any = self.document.data
        if not isinstance(data, dict):
            raise self.refused("the file is a mapping with the keys " + ", ".join(keys))
        for key in data:
            if key not in keys:
                raise self.refused(f"{self.what} has no key {key!r}. {suggest(str(key), keys)}", key)
        for key in needed:
            if key not in data:
                raise self.refused(f"the file lacks the key {key!r}. Add it, as in {EXAMPLES[key]!r}.")

    def check_kind(self, key: str, kind: type, wanted: str) -> None:
        """Refuse an entry of another kind."""
        if key in self.document.data and not isinstance(self.document.data[key], kind):
            raise self.refused(f"{key} must be {wanted}", key)
