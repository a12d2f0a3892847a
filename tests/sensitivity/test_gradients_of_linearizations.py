"""Gradients of linearizations and frequency responses, against differences of whole analyses and closed forms."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.analyses.driven import parallelogram
from tests.sensitivity.test_other_analyses import agrees
from tests.states.motors import motor

import sarrus as sr
from sarrus.analyses import NoDerivative
from sarrus.analyses.position.coordinate_set import of_names
from sarrus.model.written import with_numbers, written_numbers
from sarrus.studies import Distribution

pytestmark = pytest.mark.filterwarnings("ignore:.*assembly changed")
BASE = sr.load("slider_crank")
NAMES = ["spring.k", "spring.c", "rod.mass", "pin.point.z", "spring.length", "gravity.z"]
OUTPUTS = ["slider.x", "pin.force.z", "slider.acceleration.x"]
ENTRIES = [
    "A[pin.angle.rate, pin.angle]",
    "A[pin.rate,pin.rate]",
    "C[slider.x, pin.angle]",
    "C[pin.force.z, pin.angle]",
    "C[slider.acceleration.x, pin.angle.rate]",
]


def check(
    system: sr.System, linearized: Callable[[sr.System], Any], entries: Sequence[str], names: Sequence[str]
) -> sr.Gradient:
    """Gradients of entries are those of differences."""
    return agrees(system, linearized, entries, names, lambda plant: [plant[name] for name in entries])


def test_through_an_equilibrium() -> None:
    found = check(
        sr.System(BASE),
        lambda s: sr.linearize(s, sr.equilibrium(s), outputs=OUTPUTS),
        [*ENTRIES, "pin.force.z"],
        NAMES,
    )
    assert found.response_units == ("1/s²", "1/s", "m/rad", "N/rad", "m/(rad s)", "N")
    assert found["final of A[pin.angle.rate, pin.angle]", "rod.mass"] == found.matrix[0, 2]


@pytest.mark.slow
def test_through_an_assembly() -> None:
    def linearized(system: sr.System) -> sr.StateSpace:
        return sr.linearize(system, sr.assemble(system, rates={"pin": 2.0}), outputs=OUTPUTS)

    names = [*NAMES, "pin.axis.y"]
    check(sr.System(BASE), linearized, [*ENTRIES, "pin.force.z", "slider.acceleration.x"], names)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", ["pin.angle", "diagonal.length", "rod(0.1, 0, 0.2).z"])
def test_a_state_of_a_run_keeps_its_coordinates(name: str) -> None:
    """Other designs are assembled with the same coordinate and its rate."""
    rod = next(body for body in BASE.bodies if body.name == "rod")
    ends = sr.ground.point(0.3, 2, 1), rod.point(0.1, 0, 0.2)
    diagonal = sr.TSDA("diagonal", *ends, k=3.0, c=0.2, length=2.0)
    system = sr.System(replace(BASE, forces=[*BASE.forces, diagonal]))
    state = sr.simulate(system, until=0.7).final
    plant = sr.linearize(system, state, coordinates=[name], outputs=OUTPUTS)

    def linearized(other: sr.System) -> sr.StateSpace:
        q, none, of = state.q.copy(), np.zeros(other.nq), of_names(other, (name,))
        for _ in range(12):  # Newton's method
            rows = np.vstack([other.Phi_q(q, 0.0).toarray(), of.gradients(q)])
            gap = np.concatenate([other.Phi(q, 0.0), of.values(q, none)[0] - plant.x0[:1]])
            q = q - np.linalg.lstsq(rows, gap, rcond=None)[0]
        rows = np.vstack([other.Phi_q(q, 0.0).toarray(), of.gradients(q)])
        v = np.linalg.lstsq(rows, np.append(np.zeros(other.m), plant.x0[1]), rcond=None)[0]
        return sr.linearize(other, q, v, coordinates=[name], outputs=OUTPUTS)

    assert linearized(system).A == pytest.approx(plant.A, rel=1e-9)
    entries = [f"A[{name}.rate, {name}]", f"A[{name}.rate, {name}.rate]", f"C[pin.force.z, {name}]"]
    names = ["rod.mass", "diagonal.point_i.z", "pin.axis.y", "pin.point.z", "spring.c"]
    check(system, linearized, [*entries, "pin.force.z", "slider.acceleration.x"], names)


def oscillator() -> sr.System:
    """A cart of 2 kg on a rail with a spring of 50 N/m, a damper of 3 N s/m, and a force by an input."""
    cart = sr.Body("cart", 2.0, (1, 1, 1))
    rail = sr.Prismatic("rail", sr.ground, cart, point=(0, 0, 0), axis=(1, 0, 0))
    spring = sr.TSDA("spring", sr.ground.point(-1, 0, 0), cart.point(0, 0, 0), k=50.0, c=3.0, length=1.0)
    push = sr.Force("push", "rail", value="u")
    return sr.System(sr.Model("oscillator", [cart], [rail], [sr.Input("u", 0.0, unit="N"), spring, push]))


def test_a_mass_on_a_spring_in_closed_form() -> None:
    """A = [0 1; -k/m -c/m], B = [0; 1/m], G = 1/(k - m ω² + i c ω) at the frequency ω/2π."""
    system, f = oscillator(), 0.9
    m, c, k, omega = 2.0, 3.0, 50.0, 2 * np.pi * f
    plant = sr.linearize(system, sr.equilibrium(system), outputs=["rail.displacement"])
    x, entry = "rail.displacement", "A[rail.displacement.rate, rail.displacement]"
    parts = [f"{word}[{x}, u, {f}]" for word in ("magnitude", "phase", "real", "imaginary")]
    names = ["spring.k", "spring.c", "cart.mass"]
    G, Z = 1 / (k - m * omega**2 + 1j * c * omega), np.array([1, 1j * omega, -(omega**2)])
    G_b = -G * G * Z
    size, angle = (np.conj(G) * G_b).real / abs(G), (np.conj(G) * G_b).imag / abs(G) ** 2
    exact = [[-1 / m, 0, k / m**2], [0, 0, -1 / m**2], size, angle, G_b.real, G_b.imag]
    for method in ("adjoint", "direct"):
        found = sr.sensitivity(plant, [entry, f"B[{x}.rate, u]", *parts], names, method=method)  # type: ignore[arg-type]
        assert found.values == pytest.approx([-k / m, 1 / m, abs(G), np.angle(G), G.real, G.imag], rel=1e-12)
        assert found.matrix == pytest.approx(np.array(exact), rel=1e-11, abs=1e-14)
    assert found.response_units == ("1/s²", "1/kg", "m/N", "rad", "m/N", "m/N")


def test_first_order_states_and_inputs() -> None:
    system = sr.System(motor("(5 - R*current - k*pin.rate)/L", initial=0.0))
    names = [
        "current.parameters.R",
        "current.parameters.k",
        "current.parameters.L",
        "arm.mass",
        "current.rate.1",
    ]
    entries = ["A[current, pin.angle.rate]", "A[pin.angle.rate, current]", "A[pin.angle.rate, pin.angle]"]
    rest = sr.equilibrium(system)
    check(system, lambda s: sr.linearize(s, sr.equilibrium(s, rest.q)), entries, names)
    start = sr.assemble(system)
    check(system, lambda s: sr.linearize(s, start.q, start.v), entries, [*names[:3], "arm.mass"])


@pytest.mark.slow
def test_frequency_responses_of_a_loop() -> None:
    model = replace(
        BASE,
        forces=[*BASE.forces, sr.Input("u", 0.5), sr.Torque("motor", "pin", value="u*(1 + 0.3*pin.angle)")],
    )
    responses = [f"{word}[slider.x, u, 0.6]" for word in ("magnitude", "phase")]
    responses += ["B[pin.angle.rate, u]", "D[pin.force.z, u]", "C[motor.value, pin.angle]"]

    def linearized(system: sr.System) -> sr.StateSpace:
        return sr.linearize(
            system, sr.equilibrium(system), outputs=["slider.x", "pin.force.z", "motor.value"]
        )

    check(sr.System(model), linearized, responses, NAMES)


@pytest.mark.slow
def test_redundant_constraints_and_a_table() -> None:
    """Mass and stiffness of a parallelogram, three of whose equations are redundant."""
    model = replace(parallelogram().model, drivers=[], gravity=(0, -9.81, 0))
    law = [[-1, 260], [-0.5, 245], [0, 240], [0.5, 250], [1, 270], [1.5, 300]]
    coupler, rocker = model.bodies[1:]
    spring = sr.TSDA("spring", sr.ground.point(0.1, 2, 0), coupler.point(0, 0, 0), k=law, c=2.0, length=1.0)
    system = sr.System(replace(model, forces=[spring]))
    names = [
        "coupler.mass",
        "rocker.mass",
        "spring.c",
        *(n for n in written_numbers(system.model) if n.startswith("spring.k")),
    ]

    def linearized(other: sr.System) -> sr.StateSpace:
        return sr.linearize(other, sr.equilibrium(other), coordinates=["A.angle"], outputs=["rocker.x"])

    entries = ["A[A.angle.rate, A.angle]", "A[A.angle.rate, A.angle.rate]", "C[rocker.x, A.angle]"]
    check(system, linearized, entries, names)


@pytest.mark.slow
def test_along_a_driven_motion() -> None:
    """A pendulum on a cart with a prescribed motion: γ, Φ_t and a are not zero."""
    cart, bob = (
        sr.Body("cart", 1.0, (1, 1, 1)),
        sr.Body("bob", 0.5, (0.01, 0.02, 0.02), position=(0.3, 0, -0.8)),
    )
    rail = sr.Prismatic("rail", sr.ground, cart, point=(0, 0, 0), axis=(1, 0, 0))
    pin = sr.Revolute("pin", cart, bob, point=(0, 0, 0), axis=(0, 1, 0))
    motion = sr.DisplacementDriver("motion", "rail", "0.2*sin(3*t)")
    damper = sr.Torque("damper", "pin", value="-0.3*pin.angle - c*pin.rate", parameters={"c": 0.1})
    system = sr.System(
        sr.Model("shaken", [cart, bob], [rail, pin], [damper], drivers=[motion], gravity=(0, 0, -9.81))
    )

    def linearized(other: sr.System) -> sr.StateSpace:
        start = sr.assemble(other, t=0.4, rates={"pin": 1.0})
        return sr.linearize(other, start, outputs=["rail.force.x", "motion.force.x"])

    entries = [
        "A[pin.angle.rate, pin.angle]",
        "A[pin.rate, pin.rate]",
        "C[motion.force.x, pin]",
        "C[motion.force.x, pin.rate]",
    ]
    check(
        system,
        linearized,
        entries,
        ["bob.mass", "damper.parameters.c", "pin.point.z", "motion.motion.2", "gravity.z"],
    )


def test_poles_are_placed_by_optimization() -> None:
    """A damper of a tenth of the critical damping: c = 2 m ω 0.1."""
    goal = sr.Combined(lambda a, b: (a + 40.0) ** 2 + (b + 2 * np.sqrt(40.0) * 0.1) ** 2, [POSITION, DAMPING])
    found = sr.optimize(
        oscillator(),
        goal,
        ["spring.k", "spring.c"],
        analysis=sr.Linearization(),
        bounds={"spring.k": (1, 200), "spring.c": (0, 9)},
    )
    assert found.success
    assert found.x == pytest.approx([80.0, 4 * np.sqrt(40.0) * 0.1], rel=1e-4)


POSITION, DAMPING = (f"A[rail.displacement.rate, rail.displacement{end}]" for end in ("", ".rate"))
PEAK = "magnitude[rail.displacement, u, 0.9]"


@pytest.mark.slow
def test_a_measured_frequency_response_is_fitted() -> None:
    """Stiffness and damping from magnitude and phase at two frequencies."""
    words = [f"{word}[rail.displacement, u, {f}]" for word in ("real", "imaginary") for f in (0.5, 0.9)]
    plant = sr.linearize(oscillator(), sr.equilibrium(oscillator()))
    misfits = [sr.Misfit(word, at=[0.0], data=[plant[word]], sigma=1e-6) for word in words]
    begin = sr.System(with_numbers(oscillator().model, {"spring.k": 47.0, "spring.c": 2.0}))
    found = sr.fit(begin, misfits, ["spring.k", "spring.c"], analysis=sr.Linearization())
    assert found.x == pytest.approx([50.0, 3.0], rel=1e-8)


def test_uncertainty_and_studies_agree() -> None:
    model = oscillator().model
    responses = {"stiffness": POSITION, "peak": f"1000*{PEAK}"}
    spread = {
        "spring.k": Distribution("norm", {"loc": 50, "scale": 0.1}),
        "cart.mass": Distribution("norm", {"loc": 2, "scale": 0.01}),
    }
    found = sr.uncertainty(model, spread, responses, analysis=sr.Linearization())
    sides = sr.study(
        model, {"spring.k": [49.99, 50.01]}, responses, analysis={"type": "linearization"}, workers=1
    )
    assert found.matrix[:, 0] == pytest.approx((sides.found[1] - sides.found[0]) / 0.02, rel=1e-6)
    assert found.units == ("1/s²", "m/N")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("A[pin.angle]", r"has 1 entries in brackets. Write A\[row, column\]"),
        ("A[pin.angle, slider.y]", "slider.y is none of the states of the linearization"),
        ("A[pin.angle, slider.w]", "has no output 'slider.w'"),
        ("B[pin.angle, v]", 'no input "v"'),
        ("magnitude[slider.x, u, fast]", 'needs a frequency in Hz, got "fast". Give a number.'),
        ("phase[slider.x, u]", r"Write phase\[output, input, frequency in Hz\]"),
    ],
)
def test_wrong_entries_are_refused(name: str, message: str) -> None:
    system = sr.System(replace(BASE, forces=[*BASE.forces, sr.Input("u", 0.5)]))
    plant = sr.linearize(system, sr.equilibrium(system))
    with pytest.raises(sr.SarrusError, match=message):
        sr.sensitivity(plant, name, ["spring.k"])
    with pytest.raises(sr.SarrusError, match=message):
        plant[name]


def test_entries_of_results_without_matrices_are_refused() -> None:
    rest = sr.equilibrium(sr.System(BASE))
    with pytest.raises(
        sr.SarrusError, match=r"A\[pin.angle.rate, pin.angle\]: this result has no matrices. Use sr.linearize"
    ):
        sr.sensitivity(rest, ENTRIES[0], ["spring.k"])
    with pytest.raises(sr.SarrusError, match=r"is an output of linearization alone. Use Linearization\(\)"):
        sr.study(BASE, {"spring.k": [10]}, ENTRIES[0], analysis=sr.Statics(), workers=1)
    with pytest.raises(ValueError, match="only first derivatives of this analysis"):
        sr.hessian(sr.linearize(sr.System(BASE), rest), ENTRIES[0], ["spring.k"])


POLES = ["pole1.real", "pole1.imaginary", "pole1.frequency", "pole1.natural_frequency", "pole1.damping_ratio"]


@pytest.mark.slow
def test_poles_along_a_motion() -> None:
    """Also where there are no modes, as the state is no equilibrium."""
    check(
        sr.System(BASE),
        lambda s: sr.linearize(s, sr.assemble(s, rates={"pin": 0.5}), coordinates=["pin.angle"]),
        POLES, NAMES,
    )  # fmt: skip


def test_a_pole_in_closed_form() -> None:
    """s = -c/2m ± i √(k/m - c²/4m²): of m = 2, c = 3, k = 50."""
    system = oscillator()
    plant = sr.linearize(system, sr.equilibrium(system))
    found = sr.sensitivity(plant, POLES[:2], ["spring.k", "spring.c", "cart.mass"])
    m, c, k = 2.0, 3.0, 50.0
    w = np.sqrt(k / m - (c / m) ** 2 / 4)
    exact = [
        [0, -1 / (2 * m), c / (2 * m**2)],
        np.array([1 / m, -c / (2 * m**2), -k / m**2 + c**2 / (2 * m**3)]) / (2 * w),
    ]
    assert found.values == pytest.approx([-c / (2 * m), w], rel=1e-12)
    assert found.matrix == pytest.approx(np.array(exact), rel=1e-11, abs=1e-14)
    assert found.response_units == ("1/s", "1/s")
    assert plant["pole1.frequency"] == pytest.approx(w / (2 * np.pi))
    same = sr.modes(system, sr.equilibrium(system))
    assert sr.sensitivity(same, "mode1.damping_ratio", ["spring.c"]).matrix == pytest.approx(
        sr.sensitivity(plant, "pole1.damping_ratio", ["spring.c"]).matrix, rel=1e-10
    )


@pytest.mark.one_in(4)
@pytest.mark.parametrize("time", [1e-3, 1e-6, 1e-7])
def test_a_slow_pole_beside_a_fast_one(time: float) -> None:
    """The pole of a lag, which is fast, hides no difference of the slow ones: s² m + s c + k = 0."""
    model, lag = oscillator().model, sr.FirstOrderLag("lag", input="rail.displacement", time=time)
    slow = with_numbers(replace(model, forces=[*model.forces, lag]), {"spring.k": 0.1, "spring.c": 0.2})
    plant = sr.linearize(sr.System(slow), sr.equilibrium(sr.System(slow)))
    found = sr.sensitivity(plant, ["pole1.real", "pole2.real", "pole2.imaginary"], ["spring.k"])
    w = np.sqrt(0.1 / 2 - 0.05**2)
    assert found.values == pytest.approx([-1 / time, -0.05, w], rel=1e-8)
    assert found.matrix[:, 0] == pytest.approx([0, 0, 1 / (4 * w)], rel=1e-8, abs=1e-8)


def test_poles_without_derivatives_are_refused() -> None:
    critical = sr.System(with_numbers(oscillator().model, {"spring.c": 20.0}))
    plant = sr.linearize(critical, sr.equilibrium(critical))
    with pytest.raises(NoDerivative, match="pole1 is the same as another pole"):
        sr.sensitivity(plant, "pole1.real", ["spring.k"])
    for name, message in (
        ("pole0.real", r"Poles are numbered from 1: pole1\.real"),
        ("pole4.real", r"has no pole4\. Choose a number from 1 to 2"),
    ):
        with pytest.raises(sr.SarrusError, match=message):
            plant[name]
    with pytest.raises(sr.SarrusError, match=r"pole1: this result has no matrices\. Use sr\.linearize"):
        sr.sensitivity(sr.equilibrium(critical), "pole1.real", ["spring.k"])


@pytest.mark.slow
def test_other_coordinates() -> None:
    """Coordinates of bodies, of points and of springs."""
    system = sr.System(BASE)
    for name, rate in (
        ("slider.x", "d(slider.x)/dt"),
        ("spring.length", "spring.length.rate"),
        ("rod(0.1, 0, 0.2).z", "rod(0.1, 0, 0.2).z.rate"),
    ):

        def linearized(other: sr.System, name: str = name) -> sr.StateSpace:
            return sr.linearize(other, sr.assemble(other, rates={"pin": 1.5}), coordinates=[name])

        check(system, linearized, [f"A[{rate}, {name}]", f"A[{rate}, {rate}]"], NAMES)
