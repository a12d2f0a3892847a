"""Formula coupler: the coordinate of a joint is a function of coordinates of others, as of a cam. 1 equation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated

from ..coordinate import Known, chosen
from ..errors import ModelError
from ..forces.by_formula import WithParameters
from ..forces.formula_element import constraint_primitive
from ..laws.jumps import TIME
from ..laws.law import Law
from ..laws.recorded import Recording
from ..measure import In
from ..primitive import Primitive
from ..show import quote
from ..signals import Signals
from .couplings import Coupling


@dataclass(frozen=True, eq=False)
class FormulaCoupler(WithParameters, Coupling):
    """Coordinate of ``joint`` = ``value``, a formula of coordinates of other joints, as numbers in m and rad.

    Its reaction is that of a `Coupler`: the torque or force along the coordinate of ``joint``, on its second body.

    Parameters
    ----------
    joint
        The joint that follows, by name, or one of its coordinates, ``hook.angle_i``.
    value
        A formula such as ``"0.01*sin(3*crank) + 0.5*slide"``, a function, or a table over what ``over`` names, as of a
        cam.
    over
        For a table: a coordinate, or a formula.
    """

    joint: str
    value: Annotated[Law | None, In("", outputs=True)] = field(default=None, kw_only=True)
    over: str = field(default="", kw_only=True)

    @property
    def follower(self) -> str:
        """The joint whose coordinate the formula gives."""
        return self.joint

    def relations(self, known: Known) -> Iterator[Primitive]:
        """Yield the coordinate - value."""
        if self.value is None:
            raise ModelError("value is missing. Give a formula, a function or a table.", field="value")
        own, _, _ = self.joint.partition(".")
        coordinate = chosen(self.joint, None, known, "joint")
        recording = Recording("value", {}, self.checked_parameters())
        law = recording.named(f"{own}.{coordinate.name}") - recording.law(self.value, self.over)
        found = Signals({}, known, {}).of(recording)
        wrong = [name for name, one in zip(recording.signals, found, strict=True) if one.arguments > 1]
        wrong += [TIME for node in recording.graph.nodes if node.value == (TIME,)]
        if wrong:
            message = f"value uses {quote(wrong[0])}, but a coupler depends on positions only"
            raise ModelError(f"{message}. Use coordinates of joints.", field="value")
        yield constraint_primitive(law, recording, found)
