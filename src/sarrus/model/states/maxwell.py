"""Maxwell element: a spring in series with a damper."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Annotated

from ..forces.force import Force
from ..forces.formula_element import load_primitive
from ..forces.two_points import OnLine
from ..laws.recorded import Recording
from ..measure import In
from ..primitive import Primitive
from ..quantity import number, positive
from ..signals import Signals
from .block import StateValue
from .rate_load import rate_loads
from .with_nominal import WithNominal


@dataclass(frozen=True, eq=False)
class Maxwell(OnLine, WithNominal, Force):
    """A spring in series with a damper, whose tension F relaxes: Ḟ/k + F/c = v, v the rate of its length.

    The tension is the state ``name.tension`` [N]. The force that pushes its points apart, or increases the displacement
    of its joint, is ``name.value`` = -F.

    Parameters
    ----------
    point_i, point_j
        The ends, which must not coincide. Or instead of both the name of a joint, ``Maxwell("buffer", "slide", ...)``.
    joint
        Instead of points, a joint by name, whose displacement is the length.
    k
        Stiffness of the spring [N/m].
    c
        Coefficient of the damper [N s/m]; c/k is the time of relaxation.
    initial
        Tension at the start of a run [N].
    """

    k: Annotated[float, In("N/m")] = field(kw_only=True)
    c: Annotated[float, In("N s/m")] = field(kw_only=True)
    initial: Annotated[float, In("N")] = field(default=0.0, kw_only=True)

    def states(self) -> Iterator[StateValue]:
        """Yield the tension."""
        yield StateValue(f"{self.name}.tension", number(self.initial, "initial"), "N", self.state_size())

    def relations(self, signals: Signals) -> Iterator[Primitive]:
        """Yield the load of the tension's rate, and the force."""
        target, _, v = self.line(signals)
        tension, signals = f"{self.name}.tension", signals.extended({"v": v})
        r = Recording("k", {}, {})
        k = r.number(positive(self.k, "k", "Give a stiffness in N/m."))
        c = r.number(positive(self.c, "c", "Give a coefficient in N s/m."))
        yield from rate_loads([tension], [k * (r.named("v") - r.named(tension) / c)], r, signals, "N/s")
        r = Recording("k", {}, {})
        yield load_primitive(target, [-r.named(tension)], r, signals.of(r), "N")
