"""From which sides a candidate curve can be crossed: the second-order form on the directions that leave the outputs.

With s_i >= 0 the distance from an active limit and sigma_i = +1 at its lowest, -1 at its highest value, neighbouring
admissible positions have c·du = -Σ lam_i sigma_i s_i + ½ etaᵀ H eta, eta in the null space of all gradients. Where all
terms have one sign, the outputs stay on that side: a barrier.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...algebra import Array
from .explore import Branch
from .newton import NoPoint, Tally, correct, plane
from .step import Step
from .stratum import Stratum
from .svd import singular

REACHED = 1e-8  # of a limit, free of units
VANISHES = 1e-9  # of a term, relative to the largest


class Crossing(NamedTuple):
    """What a curve is for the motion that arrives at it.

    Attributes
    ----------
    x : unknowns of the point that was examined
    side : +1 or -1: the outputs stay on the side of c or -c, a barrier; 0: they can go to both sides
    terms : -lam_i sigma_i of the active limits, then the eigenvalues of the form
    sure : false where further limits are reached by coincidence, which are not in the terms, or where some terms
        vanish, as for a freedom that moves none of the outputs; the others then tell the side
    """

    x: Array
    side: int
    terms: Array
    sure: bool = True


def crossing(branch: Branch, tally: Tally) -> Crossing:
    """Examine a curve in its middle; along it the signs do not change."""
    x = _middle(branch, tally)
    return examine(branch.stratum, x)


def _middle(branch: Branch, tally: Tally) -> Array:
    k = (len(branch.points) - 1) // 2
    step = Step(branch.points[k], branch.points[k + 1])
    guess = step.x(0.5)
    try:
        return correct(branch.stratum, guess, plane(guess, step.a.t), tally)[0]
    except NoPoint:
        return guess


def _alone(stratum: Stratum, q: Array) -> bool:
    """Whether no limit is reached but the active ones."""
    margins = stratum.problem.margins(stratum.problem.values(q))
    others = [margins[i] for i in range(len(margins)) if not {(i, 0), (i, 1)} & stratum.key]
    return bool(np.min(others, initial=np.inf) > REACHED)


def examine(stratum: Stratum, x: Array) -> Crossing:
    """The terms of the second-order form at one point."""
    q, lam, _ = stratum.parts(x)
    J = stratum.problem.jacobian(q)
    gradients = np.concatenate([J[stratum.rows], J[stratum.normal]])
    free = stratum.n - len(gradients) + 1
    Z = singular(gradients)[2][stratum.n - free :].T
    form = Z.T @ stratum.problem.curvature(q, stratum.weights(x)) @ Z
    pushes = -lam[len(lam) - len(stratum.active) :] * stratum.signs
    terms = np.concatenate([pushes, np.linalg.eigvalsh(form)])
    small = VANISHES * abs(terms).max(initial=0.0)
    telling = terms[abs(terms) > small]
    side = 0 if not len(telling) else 1 if np.all(telling > 0) else -1 if np.all(telling < 0) else 0
    return Crossing(x, side, terms, _alone(stratum, q) and (side == 0 or len(telling) == len(terms)))
