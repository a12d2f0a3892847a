"""Steps share the references of angles that count the same revolutions, so that they are linearized together."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.elements.own import Strained
from tests.elements.states import COMPLEX, fields, state

import sarrus as sr
from sarrus.analyses.sensitivity.steps.record import Record
from sarrus.analyses.sensitivity.steps.references import remembers_angles
from sarrus.elements import BUILT_IN
from sarrus.elements.evaluation import partition

AXIS = {"point": (0, 0, 0), "axis": (0, 0, 1)}
SPEED, STIFFNESS, INERTIA, UNTIL = 30.0, 0.9, 0.1, 1.9  # ω = 3 rad/s, amplitude 10 rad
DISK = sr.Body("disk", 1.0, (INERTIA, INERTIA, INERTIA), angular_velocity=(0, 0, SPEED))
SPRINGS = {
    "spring.k": sr.RSDA("spring", sr.ground, DISK, k=STIFFNESS, **AXIS),
    "spring.factor": sr.Torque("spring", "hinge", value="-hinge.angle", factor=STIFFNESS),
}

REMEMBER = [kind for kind in BUILT_IN if "Memory" in kind.fields.values()]


def swung(spring: sr.RSDA | sr.Torque) -> sr.Trajectory:
    hinge = sr.Revolute("hinge", sr.ground, DISK, **AXIS)
    system = sr.System(sr.Model("pendulum", [DISK], [hinge], [spring]))
    return sr.simulate(system, until=UNTIL, method=sr.Radau(rtol=1e-9, atol=1e-11), store="steps")


@pytest.mark.parametrize("spring", SPRINGS.values(), ids=SPRINGS)
def test_a_reference_is_shared_by_steps_within_half_a_revolution_of_it(spring: sr.RSDA | sr.Torque) -> None:
    """The angle is 10 sin 3 t."""
    run = swung(spring)
    assert isinstance(run.steps, sr.results.StepsTaken)
    record, w = Record(run.system, run.steps), np.sqrt(STIFFNESS / INERTIA)
    shared, angle = record.state_variables[:, 0], SPEED / w * np.sin(w * run.steps.t)
    assert abs(run.steps.memory[:, 0] - angle[:-1]).max() < 1e-5
    assert max(abs(shared - angle[:-1]).max(), abs(shared - angle[1:]).max()) < np.pi
    turned = abs(np.diff(angle)).sum()
    assert turned / (2 * np.pi) < len(np.unique(shared)) < 2 * turned / np.pi
    assert len(np.unique(run.steps.memory)) == len(run.steps)


@pytest.mark.parametrize("stiffness", SPRINGS)
def test_a_gradient_over_some_revolutions(stiffness: str) -> None:
    """Of θ = ω₀/ω sin ω t, with ω = √(k/J), by k, in closed form."""
    found = sr.sensitivity(swung(SPRINGS[stiffness]), sr.Final("hinge.angle"), [stiffness])
    w = np.sqrt(STIFFNESS / INERTIA)
    by_w = SPEED * (UNTIL * np.cos(w * UNTIL) / w - np.sin(w * UNTIL) / w**2)
    assert found[stiffness] == pytest.approx(by_w / (2 * w * INERTIA), rel=1e-6)


def test_what_elements_of_users_remember_may_be_more_than_an_angle() -> None:
    assert not remembers_angles(Strained)


@pytest.mark.parametrize("kind", REMEMBER, ids=lambda kind: kind.__name__)
def test_a_reference_enters_built_in_elements_by_the_angle_alone(kind: Any) -> None:
    """A reference that is 1 rad off gives the same angle, and so the same numbers of all operators."""
    of = state(kind, COMPLEX)
    x = partition(kind, of.operands["q"])
    (place,) = np.flatnonzero(fields(kind) == "Memory")

    def at(reference: float) -> Any:
        return replace(of, numbers=np.array([*of.numbers[:place], reference, *of.numbers[place + 1 :]]))

    (angle,) = at(0.0).element.remember(x)
    for reference in (angle, angle + 1.0, angle - 1.0):
        assert at(reference).element.remember(x) == pytest.approx([angle], abs=1e-12)
        for operator in kind.family:
            found, wanted = (np.array(at(n)(operator.name), dtype=float) for n in (reference, angle))
            assert found == pytest.approx(wanted, rel=1e-12, abs=1e-12), operator.name
    assert at(angle + 2 * np.pi).element.remember(x) == pytest.approx([angle + 2 * np.pi])
