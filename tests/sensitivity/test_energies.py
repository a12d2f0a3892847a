"""Energies of all elements along a motion: by the operators, and differentiated beside the tape and complex numbers."""

from functools import cache

import numpy as np
import pytest
from tests.sensitivity.zoo import zoo

from sarrus._jit.formulas.replay import replay
from sarrus.functions import atan2
from sarrus.model.tape import Tape, whole
from sarrus.outputs import Outputs
from sarrus.outputs.energy import MotionEnergy, members, plain, recorded
from sarrus.outputs.recording import Angles, States
from sarrus.system.curves.curve_derivatives import MANY

TIMES = 11  # more than there are lanes, and no multiple of them
ENERGIES = ("kinetic", "potential")


@cache
def states() -> States:
    """Any states: energies do not ask for consistent ones."""
    draw, system = np.random.default_rng(5).normal, zoo()
    q, v = (system.q0 + 0.1 * draw(size=(TIMES, system.nq)), draw(size=(TIMES, system.nq)))
    return States(np.linspace(0, 1, TIMES), q, v, 0 * v, np.zeros((TIMES, system.m)))


def outputs() -> Outputs:
    nodes = states()._replace(q=np.tile(zoo().q0, (TIMES, 1)))
    return Outputs(zoo(), states(), zoo().b, None, Angles(zoo(), nodes))


def directions(energy: str) -> tuple[MotionEnergy, np.ndarray, np.ndarray, np.ndarray]:
    """An energy, and a direction in its coordinates, rates and numbers."""
    s, draw = states(), np.random.default_rng(6).normal
    along = MotionEnergy(zoo(), energy, zoo().b, s.t, s.q, s.v)
    q_dot, v_dot, b_dot = (np.zeros(x.shape) for x in (s.q, s.v, zoo().b))
    q_dot[:, along.coordinates] = draw(size=(TIMES, len(along.coordinates)))
    v_dot[:, along.coordinates] = draw(size=(TIMES, len(along.coordinates)))
    b_dot[along.numbers] = draw(size=len(along.numbers))
    return along, q_dot, v_dot, b_dot


def contracted(
    along: MotionEnergy, slopes: np.ndarray, q_dot: np.ndarray, v_dot: np.ndarray, b_dot: np.ndarray
) -> np.ndarray:
    """What slopes make of a direction (nt,)."""
    parts = [
        q_dot.T[along.coordinates],
        v_dot.T[along.coordinates],
        np.tile(b_dot[along.numbers], (TIMES, 1)).T,
    ]
    return np.sum(slopes * np.concatenate(parts), axis=0)


def by_complex_numbers(energy: str, x: np.ndarray, y: np.ndarray, b: np.ndarray) -> complex:
    """The energy of the elements, from their formulas with complex numbers."""
    total = 0.0j
    for p in members(zoo(), energy):
        for k in range(p.count if plain(p) else 0):
            one = recorded(p.variant, energy)
            inputs = {("t",): 0.0}
            inputs |= {("numbers", n): b[p.at + k * p.kind.size() + n] for n in range(p.kind.size())}
            for i, first in enumerate(p.bodies[k]):
                inputs |= {("q", i, n): x[first + n] for n in range(7)} | {
                    ("v", i, n): y[first + n] for n in range(7)
                }
            total += replay(one.graph, [one.value], inputs, MANY | {"atan2": atan2})[0]
    return total


@pytest.mark.parametrize("name", ENERGIES)
def test_an_output_is_the_energy_that_the_system_tells(name: str) -> None:
    s, found = states(), outputs()(f"energy.{name}").value
    for q, v, value in zip(s.q, s.v, found, strict=True):
        wanted = 0.5 * v @ (zoo().M(q) @ v) if name == "kinetic" else zoo().potential_energy(q, 0.0)
        assert value == pytest.approx(wanted, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("energy", ENERGIES)
def test_slopes_are_those_of_complex_steps(energy: str) -> None:
    along, q_dot, v_dot, b_dot = directions(energy)
    found, s = contracted(along, along.slopes, q_dot, v_dot, b_dot), states()
    for t in range(TIMES):
        step = 1e-30j
        moved = by_complex_numbers(
            energy, s.q[t] + step * q_dot[t], s.v[t] + step * v_dot[t], zoo().b + step * b_dot
        )
        assert found[t] == pytest.approx(moved.imag / 1e-30, rel=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("energy", ENERGIES)
def test_slopes_change_as_those_of_the_moved_motion(energy: str) -> None:
    """By central differences of the fourth order of exact slopes."""
    along, q_dot, v_dot, b_dot = directions(energy)
    s, h = states(), 1e-4

    def slopes(step: float) -> np.ndarray:
        return MotionEnergy(
            zoo(), energy, zoo().b + step * b_dot, s.t, s.q + step * q_dot, s.v + step * v_dot
        ).slopes

    wanted = (8 * (slopes(h) - slopes(-h)) - (slopes(2 * h) - slopes(-2 * h))) / (12 * h)
    found = along.turned(q_dot, v_dot, b_dot)
    assert abs(found - wanted).max() < 1e-9 * abs(wanted).max()


def test_derivatives_on_the_tape_are_those_of_elements_recorded_one_by_one() -> None:
    """Gradient and its change, of the potential: also of elements that remember their turns."""
    one, other = outputs(), outputs()
    each = [
        x
        for p in members(zoo(), "potential")
        for k in range(p.count)
        for x in other.scalars(p, k, "potential", 1)
    ]
    assert any(not plain(p) for p in members(zoo(), "potential"))
    found, wanted = one("energy.potential"), sum(each)
    assert found.value == pytest.approx(wanted.value, rel=1e-12)
    draw = np.random.default_rng(7).normal
    weights, keys = draw(size=TIMES), sorted(one.inputs.keys() & other.inputs.keys())
    assert set(other.inputs) <= set(one.inputs)
    change = {key: draw(size=np.shape(one.inputs[key].value)) for key in keys}
    bars = []
    for o, total in ((one, found), (other, wanted)):
        dots = o.tape.along({o.inputs[key].at: change[key] for key in keys})
        both = o.tape.gradient_along({total.at: weights}, {total.at: weights**2}, dots)
        bars.append([np.concatenate([np.ravel(x[o.inputs[key].at]) for key in keys]) for x in both])
    for a, b in zip(*bars, strict=True):
        assert abs(a - b).max() < 1e-11 * abs(b).max()


def test_an_operation_given_whole_bends_as_it_turns() -> None:
    """½ xᵀ A x, whose slopes are A x."""
    matrix, x = np.array([[2.0, 1.0], [1.0, 3.0]]), np.array([0.5, -2.0])
    tape = Tape()
    places = tuple(tape.variable(value).at for value in x)
    operation = whole(0.5 * x @ matrix @ x, matrix @ x, lambda dots: matrix @ np.asarray(dots))
    found = tape.add(operation, places, operation.value())
    assert operation.bends() == ((2.0, 1.0), (1.0, 3.0))
    assert tape.gradient({found.at: 2.0})[:2] == pytest.approx(2 * matrix @ x)
    along = tape.along({0: 1.0, 1: -1.0})
    assert along[found.at] == pytest.approx(matrix @ x @ [1, -1])
    assert tape.gradient_along({found.at: 1.0}, {}, along)[1][:2] == pytest.approx(matrix @ [1, -1])
