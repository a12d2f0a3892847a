"""Every built-in element, between moving bodies at random: forward, backward, and differences of whole simulations.

Kernels of all elements take a minute of compilation. `test_recorded_elements` evaluates their records without it.
"""

from functools import cache

import numpy as np
import pytest
from tests.prescribed_steps import run_of
from tests.sensitivity.frozen import solved
from tests.sensitivity.zoo import zoo

import sarrus as sr
from sarrus.analyses.sensitivity.chain.chain import Nodes
from sarrus.analyses.sensitivity.run_chain import RunChain
from sarrus.elements import BUILT_IN
from sarrus.model.written import with_numbers

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")  # states here are drawn roughly

MEASURES = {"Angle", "Heading", "Displacement"}  # they measure joints, and are no part of the equations
KINDS = ("q", "v", "a", "lam")


def even(seed: int) -> sr.Trajectory:
    """Another random mechanism with all elements, by twenty steps of 10 ms."""
    settings = {"rtol": 1e-4, "atol": 1e-5, "store_steps": True, "given": np.full(20, 0.01)}
    return run_of(sr.HHT(), zoo(seed), sr.assemble(zoo(seed)), np.array([0.0, 0.2]), **settings)


@cache
def swung() -> sr.Trajectory:
    settings = {"rtol": 1e-4, "atol": 1e-5, "store_steps": True}
    run = run_of(sr.HHT(), zoo(), sr.assemble(zoo()), np.array([0.0, 0.2]), **settings)
    return solved(run, sr.HHT())


def test_the_zoo_is_complete() -> None:
    present = {p.kind.__name__ for p in zoo().populations if p.count}
    assert {kind.__name__ for kind in BUILT_IN} - present == MEASURES


def changes(run: sr.Trajectory, columns: int) -> tuple[np.ndarray, ...]:
    """Random changes of all numbers that are no places of tables, and of the guess."""
    system = run.system
    random = np.random.default_rng(1)
    db = random.normal(size=(len(system.b), columns))
    db[system.memory_places], db[system.nb :] = 0, 0
    for p in system.populations:
        starts = np.cumsum([0, *p.kind.widths()])
        for n, kind in enumerate(p.kind.fields.values()):
            if kind in ("Curve", "Surface"):
                db[p.at + starts[n] + p.kind.size() * np.arange(p.count)] = 0
    dq, dv = (random.normal(size=(system.nq, columns)) for _ in range(2))
    for n in range(3, system.nq, 7):  # Euler parameters of a guess are brought to unit length
        p = run.steps.start.asked.q[n : n + 4]
        dq[n : n + 4] -= np.outer(p, p @ dq[n : n + 4]) / (p @ p)
    return db, dq, dv


def disagreement(run: sr.Trajectory, kinds: tuple[str, ...]) -> float:
    """Between forward and backward sweep, of random sums of all values of some kinds, relative to the largest sum."""
    chain, bars = RunChain(run.system, run.steps), Nodes.zeros(run.steps, 3)
    random = np.random.default_rng(2)
    for kind in kinds:
        getattr(bars, kind)[:] = random.normal(size=getattr(bars, kind).shape)
    db, dq, dv = changes(run, 4)
    forward, back = chain.weighed(bars, db, dq, dv), chain.gradients(bars)
    backward = back.b.T @ db + back.q.T @ dq + back.v.T @ dv
    return float(abs(forward - backward).max() / abs(forward).max())


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_forward_and_backward_agree_for_every_number_of_every_element(seed: int) -> None:
    """Rounding is divided by h² for accelerations and multipliers: with steps of 10 ms 2e-11 is left, at most."""
    run = even(seed)
    for kinds in (*((kind,) for kind in KINDS), KINDS):
        assert disagreement(run, kinds) < 1e-10, kinds


@pytest.mark.slow
def test_they_agree_where_steps_grow() -> None:
    """Rounding over h² in the first steps is multiplied by every longer one."""
    assert disagreement(swung(), ("q",)) < 1e-13
    assert disagreement(swung(), KINDS) < 1e-8


@pytest.mark.slow
def test_derivatives_are_those_of_differenced_simulations() -> None:
    system, steps, start = zoo(), swung().steps, swung().steps.start
    db, dq, dv = changes(swung(), 1)
    found = RunChain(system, steps).along(db, dq, dv)

    def moved(e: float) -> object:
        other = sr.System(with_numbers(system.model, {}))
        other.b[:] = system.b + e * db[:, 0]
        begin = sr.assemble(other, start.asked.q + e * dq[:, 0], start.asked.v + e * dv[:, 0])
        settings = {"rtol": 1e-4, "atol": 1e-5, "store_steps": True, "given": steps.h}
        return run_of(sr.HHT(), other, begin, np.array([0.0, 0.2]), **settings).steps

    e = 2e-4
    ends = {d: moved(d) for d in (e, -e, e / 2, -e / 2)}
    for kind in KINDS:
        coarse, fine = ((getattr(ends[d], kind) - getattr(ends[-d], kind)) / (2 * d) for d in (e, e / 2))
        wanted = (4 * fine - coarse) / 3
        limit = 1e-6 if kind in ("q", "v") else 1e-4
        assert abs(getattr(found, kind)[:, :, 0] - wanted).max() < limit * abs(wanted).max(), kind


@pytest.mark.slow
def test_every_angle_and_displacement_of_a_joint_is_an_output() -> None:
    names = [f"{name}{end}" for name in zoo().joint_coordinates.names for end in ("", ".rate")]
    run = swung()
    found = sr.sensitivity(run, names, ["gravity.z"])
    values, rates = zoo().joint_coordinates.along(run.t, run.q, run.v)
    assert np.allclose(found.values[::2], values[-1])
    assert np.allclose(found.values[1::2], rates[-1])
