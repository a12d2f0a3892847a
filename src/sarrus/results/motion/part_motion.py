"""The outputs of one joint, driver, force or point over the times of a trajectory, as attributes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ...algebra import Array
from ...model.show import suggest
from ...outputs import Output
from ...outputs.motion import several
from ...outputs.output import labelled
from ..result import values_of

COMPONENTS = ("x", "y", "z")
POSITION = "position"  # of a point, whose components have no other word before them


class PartMotion:
    """Outputs of a part at every time: ``run["spring"].tension`` (nt,), ``run["tyre"].force`` (nt, 3).

    Its outputs are attributes, see `units`; vectors have a column for each component, in global axes. Points within
    names are underscores: ``run["pin"].angle_rate`` is the output ``pin.angle.rate``.

    Attributes
    ----------
    name : of the part
    units : of its attributes, by name
    """

    def __init__(self, run: Any, name: str, outputs: Iterable[Output]) -> None:
        self._run, self.name = run, name
        self._outputs: dict[str, list[Output]] = {}
        for one in outputs:
            *words, last = one.name.removeprefix(name)[1:].split(".")
            component = last in COMPONENTS or last.isdigit()
            word = "_".join(words if component else [*words, last]) or POSITION
            self._outputs.setdefault(word, []).append(one)
        for word, found in self._outputs.items():  # what several elements have together
            whole = [one for one in found if one.name == f"{name}.{word}"]
            vector = [one for one in found if one.name[-1] in COMPONENTS]
            self._outputs[word] = whole or vector or found
        self.units = {word: found[0].unit for word, found in self._outputs.items()}

    def __getattr__(self, word: str) -> Array:
        if word.startswith("_") or word not in self._outputs:
            message = f"{self.name} has no {word!r}. {suggest(word, self._outputs)}"
            raise AttributeError(message, name=word, obj=self)
        names = [one.name for one in self._outputs[word]]
        columns = [one.values for one in several(self._run.system, self._run, names)]
        values: Array = columns[0] if len(columns) == 1 else np.column_stack(columns)
        return values_of(self._run, values)

    def __getitem__(self, word: str) -> Any:
        """An output of the part, ``run["pin"]["angle.rate"]``."""
        return self._run[f"{self.name}.{word}"]

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._outputs]

    def __repr__(self) -> str:
        parts = (labelled(word, unit) for word, unit in self.units.items())
        return f"{type(self).__name__}({self.name!r}: {', '.join(parts)})"
