"""`modes` against NumPy's eigenvalues of the linearized equations, in any units; shares of kinetic energy."""

import numpy as np
import pytest
from tests.verdicts.random_mechanisms import KINDS, mechanism

import sarrus as sr

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*is in no (equilibrium|steady motion)"
)  # the states are random

EPS = np.finfo(float).eps


def matched(found: np.ndarray, want: np.ndarray) -> np.ndarray:
    """The distance of every wanted eigenvalue from the nearest one found that is not taken yet."""
    left, far = list(found), []
    for s in want:
        n = int(np.argmin([abs(s - other) for other in left]))
        far.append(abs(s - left.pop(n)))
    return np.array(far)


def all_of(found: sr.Modes) -> np.ndarray:
    """The whole plane: conjugates beside what is told, and two zeros for each free motion but perhaps one."""
    s = found.eigenvalues
    pairs = s[s.imag > 0].conj()
    return np.concatenate([s, pairs, np.zeros(len(found.matrix) - len(s) - len(pairs))])


@pytest.mark.one_in(6)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("block", range(2))
def test_random_mechanisms(kind: str, block: int) -> None:
    """About any position, as if it were an equilibrium: what is told of eigenvalues does not depend on it."""
    for seed in range(25 * block, 25 * block + 25):
        made = mechanism(seed, kind, c=(0.0, 1.0, 1e3)[seed % 3])
        system = made.system()
        q = sr.assemble(system).q
        found = sr.modes(system, q)
        A = found.matrix
        want, right = np.linalg.eig(A)
        condition = np.linalg.norm(np.linalg.inv(right), axis=1)
        error = 1e4 * EPS * np.linalg.norm(A, 2) * condition
        assert np.all(matched(all_of(found), want) <= error), (kind, seed)
        zeros = np.sort(abs(want))[: np.count_nonzero(all_of(found) == 0)]
        assert np.all(zeros <= np.sqrt(1e4 * EPS) * np.linalg.norm(A, 2)), (kind, seed)
        assert (found.stability == "unstable") == np.any(want.real > error), (kind, seed)
        assert np.allclose(found.energy_shares.sum(axis=0), 1)
        length, mass = [(1e-6, 1e-9), (1e4, 1e6), (1e-6, 1e6), (1e4, 1e-9)][seed % 4]
        other = mechanism(seed, kind, length=length, mass=mass, c=(0.0, 1.0, 1e3)[seed % 3]).system()
        scaled = sr.modes(other, sr.assemble(other).q)
        assert np.all(matched(all_of(scaled), want) <= 100 * error), (kind, seed)
        assert (scaled.stability, scaled.success) == (found.stability, found.success), (kind, seed)


def slides(*stiffness: float, c: float = 0.0) -> sr.System:
    """Bodies of 1 kg, each on its own slide with a spring, or pushed away with -1 N/m where k is negative."""
    bodies, joints, forces = [], [], []
    for n, k in enumerate(stiffness):
        body = sr.Body(f"b{n}", mass=1.0, inertia=(1, 1, 1), position=(0, n, 0))
        joints.append(sr.Translational(f"j{n}", sr.ground, body, point=(0, n, 0), axis=(1, 0, 0)))
        ends = (sr.ground.point(-2, n, 0), body.point(0, 0, 0))
        forces.append(sr.TSDA(f"s{n}", *ends, k=k if k >= 0 else lambda x: -1.0, c=c, length=2.0))
        bodies.append(body)
    return sr.System(sr.Model("slides", bodies, joints, forces))


@pytest.mark.parametrize("stiff", [1e4, 1e8, 1e12])
def test_slow_modes_beside_fast_ones(stiff: float) -> None:
    """An unstable slide stays unstable, a soft one vibrates, and a free one is free, whatever is beside them."""
    system = slides(-1.0, 4.0, stiff)
    found = sr.modes(system, system.q0)
    assert found.stability == "unstable"
    assert np.allclose(np.sort_complex(found.eigenvalues[:3]), [-1, 2j, 1], atol=1e-6)
    assert found.eigenvalues[3] == pytest.approx(1j * np.sqrt(stiff))
    assert "with 1 free motion" in sr.modes(slides(1e-30 * stiff, stiff), system.q0[:14]).message


def test_a_critically_damped_mode_is_not_free() -> None:
    """Its double eigenvalue has no condition number, and is not zero."""
    system = slides(1.0, 1.0, c=2.0)
    assert np.allclose(sr.modes(system, system.q0).eigenvalues, -1, atol=1e-7)


def test_moves_most_is_by_kinetic_energy() -> None:
    """A chassis of 350 kg on springs bounces; its arms of 3 kg turn by more radians than it moves metres."""
    chassis = sr.Body("chassis", mass=350.0, inertia=(100, 100, 100), position=(0, 0, 0.5))
    arm = sr.Body("arm", mass=3.0, inertia=(0.05, 0.05, 0.05), position=(0.2, 0, 0.5))
    joints = [
        sr.Translational("slide", sr.ground, chassis, point=(0, 0, 0.5), axis=(0, 0, 1)),
        sr.Revolute("pivot", chassis, arm, point=(0, 0, 0.5), axis=(0, 1, 0)),
        sr.PointOnPlane("wheel", sr.ground, arm, point=(0.4, 0, 0.5), axis=(0, 0, 1)),
    ]
    spring = sr.TSDA("spring", sr.ground.point(0, 0, -0.5), chassis.point(0, 0, 0), k=2e4, length=1.0)
    system = sr.System(sr.Model("corner", [chassis, arm], joints, [spring]))
    found = sr.modes(system, system.q0)
    assert "moves most\n" in str(found)
    assert str(found).splitlines()[1].split()[-1] == "chassis"
    turn, bounce = found.shape(0, "arm").rotation[1], found.shape(0, "chassis").translation[2]
    assert abs(turn) > 2 * abs(bounce)
    arm_energy = 3.0 * abs(bounce / 2) ** 2 + 0.05 * abs(turn) ** 2
    share = arm_energy / (arm_energy + 350 * abs(bounce) ** 2)
    assert found.energy_shares[1, 0] == pytest.approx(share)
