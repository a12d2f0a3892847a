"""All operators of a system in one place, so that completion of the system itself is short."""

from __future__ import annotations

from typing import Any

from ..elements import OPERATORS
from ..model.show import quote, suggest
from .operators.constraints import ConstraintOperators
from .operators.forces import ForceOperators
from .operators.inertia import InertiaOperators
from .operators.operators import Operators

MAIN = ("M", "Phi", "Phi_q", "Q", "gamma")  # those that a system itself completes
SUPPORT = (
    *(name for name in vars(Operators) if name[0] != "_" and name != "compile"),
    "memory_places",
)
STATE = ("populations", "potentials", "remember", "remembered", "structure", "with_memory")  # of analyses
HIDDEN = {*OPERATORS, *SUPPORT, *STATE} - {*MAIN}  # found when they are typed, but not completed


class AllOperators(ConstraintOperators, InertiaOperators, ForceOperators):
    """The operators of a system's equations of motion by name, ``system.operators.Phi_qT_lam_q_xi_q(q, lam, xi)``.

    Parameters
    ----------
    system : a system; it has the same methods
    """

    def __init__(self, system: Operators) -> None:
        self.populations, self.structure = system.populations, system.structure
        self.nq, self.m, self.b = system.nq, system.m, system.b

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"There is no operator {quote(name)}. {suggest(name, OPERATORS)}")

    def __dir__(self) -> list[str]:
        return [*OPERATORS]

    def __repr__(self) -> str:
        return f"<operators {', '.join(OPERATORS)}>"
