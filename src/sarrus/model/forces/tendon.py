"""Tendon: a force along the length of a path through points, or along a combination of coordinates of joints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from ..errors import ModelError
from ..laws.recorded import Recording
from ..measure import In
from ..primitive import Primitive
from ..quantity import not_negative
from ..signals import Measure, Signals
from .by_formula import ByFormula, with_full
from .force import Force
from .formula_element import Target, load_primitive
from .paths.inertia import path_inertia
from .paths.on_path import OnPath
from .paths.path import Pull


@dataclass(frozen=True, eq=False)
class Tendon(OnPath, ByFormula, Force):
    """A force along x, the length of a path from point to point, or a sum of factors times coordinates of joints.

    A positive ``value`` increases x: it does work at the rate value · v, as that of a `Force`. A spring with a damper
    is ``value="-k*(x - L0) - c*v"``, a rope ``value="-k*max(x - L0, 0)"``.

    Parameters
    ----------
    inertia
        [kg] of what moves along with the length, such as the rotor of a winch divided by the square of its radius: its
        kinetic energy is ½ inertia · v². For angles of joints in kg m², without the unit.
    value
        As of a `Force`; x and v are the length and its rate.
    """

    inertia: Annotated[float, In("kg")] = 0.0

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load and the inertia."""
        inertia = not_negative(self.inertia, "inertia", "Give it in kg.")
        if self.value is None and not inertia:
            raise ModelError("value is missing. Give a formula, a function or a table.", field="value")
        path = self.path(signals)
        if self.value is not None:
            yield self._load(path, signals)
        if inertia:
            yield path_inertia(inertia, path)

    def _load(self, path: Measure, signals: Signals) -> Primitive:
        x, v = self.coordinates(path)
        own = {"x": x, "length": x, "v": v, "rate": v}
        r = Recording("value", with_full(own, self), self.checked_parameters(), variables=signals.variables)
        value = r.law(self.value, self.over)
        laws = [value, value, r.named("x"), r.named("v")]
        signals.refuse_hidden(r)
        pairs = zip(r.signals, r.fields, strict=True)
        found = [own[name] if name in own else signals.find(name, field) for name, field in pairs]
        outputs = ("value", "N" if self.points else ""), ("length", x.unit), ("rate", v.unit)
        return load_primitive(Target(path, Pull(outputs)), laws, r, found)
