"""Positions at which inputs lose control of a mechanism, or outputs a direction, as curves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from ...algebra import Array
from ...deferred import renderer
from ..saving.exported_file import write_table
from .workspace import MapResult, Status

Lost = Literal["inputs", "outputs"]


@dataclass(frozen=True)
class SingularCurve:
    """A curve of positions at which the mechanism can move while its inputs, or its outputs, stand still.

    Attributes
    ----------
    u : (k, 2) outputs along it; `line` (m, 2) the same more densely
    v : (k, inputs) values of the inputs, `input_line` (m, inputs) more densely; angles go on from each other
    q : (k, nq) positions
    closed : whether it comes back to its start
    """

    u: Array = field(repr=False)
    line: Array = field(repr=False)
    v: Array = field(repr=False)
    input_line: Array = field(repr=False)
    q: Array = field(repr=False)
    closed: bool


@dataclass(frozen=True)
class InputSingularities(MapResult):
    """Result of `input_singularities`: curves of singular configurations.

    Attributes
    ----------
    name : of the system
    outputs, inputs : names of the functions, with `units` and `input_units` "m" or "rad"
    lost : which functions lose a direction
    input_limits : (lowest, highest) of each input, infinite if not given
    """

    name: str
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    curves: tuple[SingularCurve, ...] = field(repr=False)
    status: Status
    message: str
    lost: Lost
    units: tuple[str, ...]
    input_units: tuple[str, ...]
    input_limits: tuple[tuple[float, float], ...]

    def to_csv(self, path: Any) -> None:
        """Write all curves as a table: curve, what is lost, outputs, inputs."""
        rows = (
            (n, self.lost, *u, *v)
            for n, curve in enumerate(self.curves)
            for u, v in zip(curve.line.tolist(), curve.input_line.tolist(), strict=True)
        )
        write_table(path, ["curve", "lost", *self.outputs, *self.inputs], rows)

    def plot(self, ax: Any = None, **options: Any) -> Any:
        """Draw the curves over the outputs or the inputs; see `sarrus.views.plot_input_singularities`."""
        return renderer().plot_input_singularities(self, ax, **options)

    def summary(self) -> str:
        """The result in words."""
        names, what = (
            (self.inputs, "lose control") if self.lost == "inputs" else (self.outputs, "lose a direction")
        )
        closed = sum(curve.closed for curve in self.curves)
        count = f"{len(self.curves)} curve{'s' * (len(self.curves) != 1)}, {closed} of them closed"
        message = self.message.removeprefix(f"{self.name}: ")
        lost = f"{self.name}: {' and '.join(names)} {what} on {count if self.curves else 'no curve'}"
        return f"{lost}. {message[0].upper()}{message[1:]}."
