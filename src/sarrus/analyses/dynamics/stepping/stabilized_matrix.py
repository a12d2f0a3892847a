"""The Newton matrix of Radau on the stabilized index-2 equations: where operators stand, and their weights.

    [ W               -W             0     Φ_qᵀ] [ δq    ]
    [ β' (...)_q      M + γ' (...)_v  Φ_qᵀ  0  ] [ β' δa ]
    [ Φ_q              0             0     0   ] [ β' δλ ]
    [ β'/γ' (Φ_q v + Φ_t)_q   Φ_q    0     0   ] [ δη    ],    δv = γ' δa,

β' = 1/s² and γ' = 1/s. Its condition does not depend on the step.
"""

from __future__ import annotations

from ...._jit.linking.link import compiled
from ....algebra import Array
from ...equations.block_matrix import LEFT_OUT, UNIT, Part

MATRICES = ("Phi_q", "Phi_qT_lam_q", "M", "M_a_q", "S_q", "S_v", "Q_q", "Q_v", "gamma_v")


def newton_parts(nq: int, m: int) -> list[Part]:
    """Where operators stand in the Newton matrix; (Φ_q v + Φ_t)_q is -½ γ_v. `weigh` has their weights."""
    v, lam, mu = nq, 2 * nq, 2 * nq + m
    return [
        Part(UNIT, 0, 0),
        Part(UNIT, 0, v),
        Part("Phi_q", 0, mu, transposed=True),
        Part("Phi_q", v, lam, transposed=True),
        Part("M_a_q", v, 0),
        Part("Phi_qT_lam_q", v, 0),
        Part("S_q", v, 0),
        Part("Q_q", v, 0),
        Part("M", v, v),
        Part("S_v", v, v),
        Part("Q_v", v, v),
        Part("Phi_q", lam, 0),
        Part("Phi_q", mu, v),
        Part("gamma_v", mu, 0),
        Part(LEFT_OUT, lam, lam),
        Part(LEFT_OUT, mu, mu),
    ]


@compiled
def weigh(weights: Array, beta: complex, gamma: complex) -> None:
    """The weights of the parts of a Newton matrix, in the order of `newton_parts`."""
    weights[1] = -1.0
    weights[4], weights[5], weights[6], weights[7] = beta, beta, -beta, -beta
    weights[9], weights[10] = -gamma, -gamma
    weights[13] = -0.5 * beta / gamma
