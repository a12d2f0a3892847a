"""Whether a motion may be fast, for one fast body among many, by closed forms."""

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.sensitivity.accuracy.stiff_steps import fast_motions
from sarrus.analyses.sensitivity.chain.start import Start
from sarrus.system.curves.curve_derivatives import CurveDerivatives

OMEGA = 1e3


def one_among_many(k: float, c: float, length: float, mass: float = 1e-3) -> sr.System:
    """Thirty free bodies at rest in a row, and a light one on a spring-damper between them."""
    free = [sr.Body(f"b{n}", 1.0, (length**2,) * 3, position=(n * length, 0, 0)) for n in range(30)]
    light = sr.Body("light", mass, (mass * length**2,) * 3, position=(0, length, 0))
    spring = sr.TSDA("spring", sr.ground.point(0, 0, 0), light.point(0, 0, 0), k=k, c=c, length=length)
    return sr.System(sr.Model("many", [*free, light], forces=[spring]))


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize(("k", "c"), [(1e-3 * OMEGA**2, 0.0), (0.0, 1e-3 * OMEGA)], ids=["spring", "damper"])
def test_one_fast_body_among_many(k: float, c: float, length: float) -> None:
    system = one_among_many(k, c, length)
    run = sr.simulate(system, until=1e-3, store_steps=True)
    start = Start(system, run.steps, CurveDerivatives(system))
    found = [fast_motions(start, part * OMEGA) for part in (np.sqrt(0.1), 10.0)]
    assert found == [True, False]
