"""Which operators do sweeps evaluate together, and what do their compiled drivers take?"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..._jit.pointer import run

GROUPS: dict[str, tuple[tuple[str, ...], int, int]] = {  # operators; scalars and arrays of their driver
    "velocity": (("Phi_q_xi", "Phi_t"), 1, 4),
    "jacobian": (("Phi_q", "Phi_qT_lam_q"), 1, 4),
    "inertia": (("M", "M_a_q", "S_q", "S_v"), 0, 7),
    "stiffness": (("Q_q", "Q_v"), 1, 4),
    "gamma_v": (("gamma_v",), 1, 3),
    "gamma_q_v": (("gamma_q", "gamma_v"), 1, 4),
    "Phi_q_xi_q": (("Phi_q_xi_q",), 1, 3),
    "Phi_b": (("Phi_b",), 1, 2),
    "Phi_qT_lam_b": (("Phi_qT_lam_b",), 1, 3),
    "Phi_q_xi_b": (("Phi_q_xi_b",), 1, 3),
    "Phi_t_b": (("Phi_t_b",), 1, 2),
    "M_a_b": (("M_a_b",), 0, 3),
    "S_b": (("S_b",), 0, 3),
    "Q_b": (("Q_b",), 1, 3),
    "gamma_b": (("gamma_b",), 1, 3),
}


def calls(names: Iterable[str]) -> dict[str, Any]:
    """What calls the drivers of groups by their address, by the names under which loops know them."""
    return {name.upper(): run(*GROUPS[name][1:]) for name in names}
