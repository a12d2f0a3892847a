"""Many redundant constraints in one mechanism: ranks and null spaces against dense singular values, and motions."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.sparse import csr_array, random_array, vstack
from tests.analyses.walker import RODS, Walker, points

import sarrus as sr
from sarrus.linalg.rank import rank_of, unit_rows, zero_below

Z = (0, 0, 1)


def some_rows(random: np.random.Generator, shape: tuple[int, int], each: int) -> csr_array:
    """Return a sparse matrix with numbers in every row."""
    density = min(1.0, each / shape[1])
    return csr_array(random_array(shape, density=density, rng=random, data_sampler=random.standard_normal))


@pytest.mark.parametrize(
    ("rows", "redundant", "columns"),
    [
        (10, 0, 14),
        (10, 5, 10),
        (230, 20, 260),
        (260, 0, 260),
        (251, 40, 280),
        (200, 300, 210),
        pytest.param(1000, 300, 1100, marks=pytest.mark.slow),
        pytest.param(1900, 100, 1900, marks=pytest.mark.slow),
        pytest.param(1700, 300, 2500, marks=pytest.mark.slow),
    ],
)
def test_rank_and_null_space_are_those_of_singular_values(rows: int, redundant: int, columns: int) -> None:
    random = np.random.default_rng(rows + redundant)
    own = csr_array(some_rows(random, (rows, columns), 5) + np.sqrt(3) * csr_array(np.eye(rows, columns)))
    sums = csr_array(some_rows(random, (redundant, rows), 4) @ own)
    J = csr_array(vstack([own, sums]))[random.permutation(rows + redundant)]
    unit = unit_rows(J).toarray()
    values = np.linalg.svd(unit, compute_uv=False)
    rank = np.count_nonzero(values > zero_below(len(unit)) * values[0])
    found = rank_of(J)
    assert found.rank == rank
    assert found.null.shape[1] == len(unit) - rank
    assert found.smallest == pytest.approx(values[rank - 1], rel=0.02)
    assert found.null.T @ found.null == pytest.approx(np.eye(len(unit) - rank), abs=1e-12)
    assert abs(unit.T @ found.null).max(initial=0.0) < 1e-13


def four_bars(count: int) -> sr.System:
    """Return parallel cranks on the ground, each connected to the next by a rod, all by revolute joints."""
    bodies, joints = [], []
    for n in range(count + 1):
        crank = sr.Body.rod(f"crank_{n}", (n, 0, 0), (n, 1, 0), radius=1e-6, mass=1.0)
        joints.append(sr.Revolute(f"pin_{n}", sr.ground, crank, point=(n, 0, 0), axis=Z))
        if n:
            rod = sr.Body.rod(f"rod_{n}", (n - 1, 1, 0), (n, 1, 0), radius=1e-6, mass=1.0)
            joints.append(sr.Revolute(f"left_{n}", bodies[-1], rod, point=(n - 1, 1, 0), axis=Z))
            joints.append(sr.Revolute(f"right_{n}", rod, crank, point=(n, 1, 0), axis=Z))
            bodies.append(rod)
        bodies.append(crank)
    return sr.System(sr.Model("four-bars", bodies, joints, gravity=(0, -9.81, 0)))


def scissor(stages: int) -> sr.System:
    """Return a scissor lift of unit arms at 45° with a slider at its foot, all by revolute joints."""
    h, bodies, joints = np.sqrt(0.5), [], []
    for n in range(stages):
        low, high = n * h, (n + 1) * h
        up = sr.Body.rod(f"up_{n}", (0, low, 0), (h, high, 0), radius=0.01, mass=1.0)
        down = sr.Body.rod(f"down_{n}", (0, high, 0), (h, low, 0), radius=0.01, mass=1.0)
        joints.append(sr.Revolute(f"middle_{n}", up, down, point=(h / 2, low + h / 2, 0), axis=Z))
        if n:
            joints.append(sr.Revolute(f"left_{n}", bodies[-1], up, point=(0, low, 0), axis=Z))
            joints.append(sr.Revolute(f"right_{n}", bodies[-2], down, point=(h, low, 0), axis=Z))
        bodies += [up, down]
    foot = sr.Body("foot", 1.0, (0.01, 0.01, 0.01), position=(h, 0, 0))
    joints.append(sr.Revolute("base", sr.ground, bodies[0], point=(0, 0, 0), axis=Z))
    joints.append(sr.Revolute("heel", foot, bodies[1], point=(h, 0, 0), axis=Z))
    joints.append(sr.Translational("slide", sr.ground, foot, point=(h, 0, 0), axis=(1, 0, 0)))
    return sr.System(sr.Model("scissor lift", [*bodies, foot], joints, gravity=(0, -9.81, 0)))


@pytest.mark.parametrize("build", [four_bars, scissor])
def test_mobility_of_many_planar_loops(build: Callable[[int], sr.System]) -> None:
    system = build(17)
    found = sr.mobility(system)
    loops = len(system.model.joints) - len(system.bodies)
    assert found.degrees_of_freedom == 1
    assert len(found.independent_rows) == system.nq - 1
    assert system.m - found.rank == 3 * loops  # every planar loop has three equations too many


@pytest.mark.slow
@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()], ids=["radau", "hht"])
def test_motion_of_many_four_bars_is_that_of_one_pendulum(method: object) -> None:
    count = 17
    system = four_bars(count)
    inertia, weight = (count + 1) / 3 + count, ((count + 1) * 0.5 + count) * 9.81
    pendulum = solve_ivp(
        lambda _, y: [y[1], weight / inertia * np.sin(y[0])], (0, 0.2), (0, 1.0), rtol=1e-11, atol=1e-12
    )
    run = sr.simulate(system, sr.assemble(system, rates={"pin_0": -1.0}), until=0.2, method=method)
    assert run.success, run.message
    assert -run["pin_0.angle"][-1] == pytest.approx(pendulum.y[0, -1], rel=1e-4)
    hanging = np.sqrt(weight / inertia) / (2 * np.pi)
    rest = sr.equilibrium(system)
    assert rest.success, rest.message
    assert sr.modes(system, rest).natural_frequencies == pytest.approx([hanging], rel=1e-5)


LEGS = [2, pytest.param(14, marks=pytest.mark.slow)]  # 6 and 42 loops


@pytest.mark.parametrize("legs", LEGS)
def test_statics_modes_and_mobility_of_walking_legs(legs: int) -> None:
    walker = Walker(legs)
    found = sr.mobility(walker.system)
    assert found.degrees_of_freedom == 1
    assert walker.system.m - found.rank == 9 * legs
    rest = sr.equilibrium(walker.system)
    assert rest.success, rest.message
    angle = walker.start + float(walker.system.joint("axle").angle(rest.q))
    assert abs(walker.slope(angle)) < 1e-9
    stiffness = (walker.slope(angle + 1e-5) - walker.slope(angle - 1e-5)) / 2e-5
    square = stiffness / walker.energies(angle)[0]
    assert sr.modes(walker.system, rest).natural_frequencies == pytest.approx([np.sqrt(square) / (2 * np.pi)])
    assert sr.linearize(walker.system, rest).A == pytest.approx(np.array([[0, 1], [-square, 0]]), rel=1e-6)


@pytest.mark.parametrize("legs", LEGS)
def test_driven_walking_legs_are_where_circles_intersect(legs: int) -> None:
    walker = Walker(legs, driver="3*t")
    motion = sr.kinematics(walker.system, until=2.0, steps=20)
    assert motion.success, motion.message
    for n, leg in enumerate(walker.legs):
        pins = [points(walker.start + 3 * t, *leg) for t in motion.t]
        foot = [np.mean([at[pin][0].real for pin in RODS["lower"]]) for at in pins]
        assert motion[f"lower_{n}.x"] == pytest.approx(foot, abs=1e-9)


@pytest.mark.parametrize("legs", LEGS)
@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()], ids=["radau", "hht"])
def test_motion_of_walking_legs_conserves_energy(legs: int, method: object) -> None:
    walker, rate = Walker(legs), 2.0
    start = sr.assemble(walker.system, rates={"axle": rate})
    run = sr.simulate(walker.system, start, until=0.3, method=method, t_eval=[0, 0.3])
    assert run.success, run.message
    inertia, potential = walker.energies(walker.start)
    energy = 0.5 * inertia * rate**2 + potential.real

    def slowness(angle: float) -> float:
        inertia, potential = walker.energies(angle)
        return float(np.sqrt(inertia / (2 * (energy - potential.real))))

    end = walker.start + run["axle.angle"][-1] - run["axle.angle"][0]
    assert quad(slowness, walker.start, end)[0] == pytest.approx(0.3, rel=1e-4)
    assert max(run.violation) < 1e-9


@pytest.mark.slow
def test_statics_of_a_long_scissor_lift() -> None:
    """All arms turn by the same angle: k (cos φ - cos φ₀) sin φ = m g N² cos φ with a spring at the foot."""
    stages, weight = 17, 9.81 * 17**2
    free = scissor(stages).model
    ends = sr.ground.point(-1, 0, 0), free.bodies[-1].point(0, 0, 0)
    spring = sr.TSDA("spring", *ends, k=20 * weight, length=1 + np.sqrt(0.5))
    system = sr.System(free.adding(spring))
    rest = sr.equilibrium(system)
    assert rest.success, rest.message
    x = rest.q[system.coordinates_of("foot")][0]
    assert 20 * (x - np.sqrt(0.5)) * np.sqrt(1 - x * x) == pytest.approx(x, rel=1e-8)


STAGES = [3, pytest.param(24, marks=pytest.mark.slow)]


def lift(angle: float, stages: int) -> tuple[float, float]:
    """Twice the kinetic energy of a scissor lift for a rate of 1 rad/s of its arms, and its slope by their angle."""
    sine, cosine, heights = np.sin(angle), np.cos(angle), sum((n + 0.5) ** 2 for n in range(stages))
    arms = 2 * stages * (sine**2 / 4 + 1 / 12 + 0.01**2 / 4) + 2 * heights * cosine**2
    return arms + sine**2, sine * cosine * (stages + 2 - 4 * heights)


@pytest.mark.parametrize("stages", STAGES)
@pytest.mark.parametrize("method", [sr.Radau(), sr.HHT()], ids=["radau", "hht"])
def test_motion_of_a_scissor_lift_that_falls(stages: int, method: object) -> None:
    """m φ̈ + ½ m' φ̇² + m g N² cos φ = 0 for N stages."""

    def by_hand(_: float, y: np.ndarray) -> list[float]:
        inertia, slope = lift(y[0], stages)
        return [y[1], -(0.5 * slope * y[1] ** 2 + 9.81 * stages**2 * np.cos(y[0])) / inertia]

    fall = solve_ivp(by_hand, (0, 0.2), (np.pi / 4, 0.0), rtol=1e-11, atol=1e-12).y[0, -1]
    run = sr.simulate(scissor(stages), until=0.2, method=method, t_eval=[0, 0.2])
    assert run.success, run.message
    assert run["foot.x"][-1] == pytest.approx(np.cos(fall), abs=1e-5)
    assert run[f"up_{stages - 1}.y"][-1] == pytest.approx((stages - 0.5) * np.sin(fall), abs=1e-5 * stages)


@pytest.mark.parametrize("stages", STAGES)
def test_a_driven_scissor_lift_and_its_vibration(stages: int) -> None:
    model = scissor(stages).model
    motor = sr.DisplacementDriver("motor", "slide", "0.2*sin(t)")
    motion = sr.kinematics(sr.System(model.adding(motor)), np.linspace(0, 2, 5))
    angle = np.arccos(np.sqrt(0.5) + 0.2 * np.sin(motion.t))
    assert motion[f"down_{stages - 1}.y"] == pytest.approx((stages - 0.5) * np.sin(angle), abs=1e-9)
    weight, k = 9.81 * stages**2, 20 * 9.81 * stages**2
    ends = sr.ground.point(-1, 0, 0), model.bodies[-1].point(0, 0, 0)
    system = sr.System(model.adding(sr.TSDA("spring", *ends, k=k, length=1 + np.sqrt(0.5))))
    rest = sr.equilibrium(system)
    x = rest.q[system.coordinates_of("foot")][0]
    sine = np.sqrt(1 - x * x)
    stiffness = -weight * sine + k * sine**2 - k * (x - np.sqrt(0.5)) * x
    square = stiffness / lift(np.arccos(x), stages)[0]
    values = np.linalg.eigvals(sr.linearize(system, rest).A)
    assert np.sort(values.imag) == pytest.approx(np.sqrt(square) * np.array([-1, 1]), rel=1e-7)
    assert sr.modes(system, rest).natural_frequencies == pytest.approx([np.sqrt(square) / (2 * np.pi)])
