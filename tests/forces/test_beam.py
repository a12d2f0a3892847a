"""Beams between bodies, against Timoshenko's matrix, elliptic integrals, frequencies and sections in closed form."""

import mpmath as mp
import numpy as np
import pytest

import sarrus as sr
from sarrus.elements import Pair
from sarrus.euler import G
from sarrus.model.forces import beam_element
from sarrus.model.forces.beam import i_section, rectangle, tube

STEEL = {"E": 210e9, "nu": 0.3}


def chain(n: int, length: float, *, force=None, torque=None, gravity=(0, 0, 0), **section) -> sr.Model:
    """A cantilever of n beams along x, whose nodes have no mass of their own, with a load at its tip."""
    nodes = [
        sr.Body(f"n{k}", mass=0, inertia=(0, 0, 0), position=(length * k / n, 0, 0)) for k in range(1, n + 1)
    ]
    ends = [sr.ground.point(0, 0, 0), *(node.point(0, 0, 0) for node in nodes)]
    beams = [sr.Beam(f"beam{k}", ends[k], ends[k + 1], **section) for k in range(n)]
    loads = [] if force is None else [sr.PointForce("tip", ends[-1], force=force)]
    loads += [] if torque is None else [sr.Torque("tip", body=nodes[-1], torque=torque)]
    return sr.Model("cantilever", nodes, [], [*beams, *loads], gravity=gravity)


def timoshenko(L: float, EA, GJ, EI_y, EI_z, GA_y, GA_z) -> np.ndarray:
    """The matrix of a beam's ends (u, θ)_i, (u, θ)_j by superposition: the flexibility of the end j with i held."""
    flexibility = np.zeros((6, 6))
    flexibility[0, 0], flexibility[3, 3] = L / EA, L / GJ
    for u, turn, EI, GA, sign in ((1, 5, EI_z, GA_y, 1), (2, 4, EI_y, GA_z, -1)):
        flexibility[u, u] = L**3 / (3 * EI) + L / GA
        flexibility[turn, turn] = L / EI
        flexibility[u, turn] = flexibility[turn, u] = sign * L**2 / (2 * EI)
    carried = np.eye(6)  # loads of the end j, moved to i
    carried[4, 2], carried[5, 1] = -L, L
    both = np.vstack([-carried, np.eye(6)])
    return both @ np.linalg.inv(flexibility) @ both.T


def test_small_deformations_are_timoshenkos() -> None:
    L, E, shear = 0.7, 70e9, 27e9
    area, I_y, I_z, J, k = 4e-4, 3e-8, 5e-9, 7e-9, (0.8, 0.6)
    beam = sr.Beam(*("b", (0, 0, 0), (L, 0, 0)), E=E, G=shear, area=area, I_y=I_y, I_z=I_z, J=J, shear=k)
    frame = (np.zeros(3), 1.0, np.zeros(3))
    element = beam_element.Beam(*frame, *frame, L, np.array(beam.stiffness(L)), np.zeros(6))
    one = np.array([1.0, 0, 0, 0])

    def force(u: np.ndarray) -> np.ndarray:
        """Forces and torques on both ends, of small displacements u and rotations."""
        x = Pair(
            u[:3], np.array([1, *(u[3:6] / 2)]), u[6:9] + np.array([L, 0, 0]), np.array([1, *(u[9:] / 2)])
        )
        r_i, p_i, r_j, p_j = element.Q(x, None, 0.0)
        return np.concatenate([r_i, G(one) @ p_i / 2, r_j, G(one) @ p_j / 2])

    K = np.column_stack([-force(1e-30j * row).imag / 1e-30 for row in np.eye(12)])
    wanted = timoshenko(L, E * area, shear * J, E * I_y, E * I_z, k[0] * shear * area, k[1] * shear * area)
    scale = np.sqrt(np.diag(wanted))
    assert abs((K - wanted) / np.outer(scale, scale)).max() < 1e-13


@mp.workdps(30)
def elastica(load: float) -> tuple[float, float]:
    """Tip of a clamped rod of length 1 under a force across it, P L²/EI = load (Bisshopp and Drucker, 1945)."""

    def slack(k):  # k² = (1 + sin θ)/2
        return mp.ellipk(k * k) - mp.ellipf(mp.asin(1 / (k * mp.sqrt(2))), k * k) - mp.sqrt(load)

    k = mp.findroot(slack, (0.8, 0.999), solver="anderson")
    phi = mp.asin(1 / (k * mp.sqrt(2)))
    deflection = 1 - 2 / mp.sqrt(load) * (mp.ellipe(k * k) - mp.ellipe(phi, k * k))
    return float(mp.sqrt(2 * (2 * k * k - 1) / load)), float(deflection)


THIN = {
    "density": 1.0,
    "E": 1e6,
    "G": 5e5,
    "area": 1.0,
    "I_y": 1e-3,
    "I_z": 1e-6,
    "J": 1e-6,
}  # EA L²/EI_z = 1e6


def test_elastica_converges_with_order_four() -> None:
    load = 10.0
    x, y = elastica(load)
    errors = []
    for n in (4, 8, 16):
        system = sr.System(chain(n, 1.0, force=(0, load, 0), **THIN))
        found = sr.equilibrium(system)
        assert found.success
        at = found.q[system.coordinates_of(f"n{n}")]
        errors.append(max(abs(at[0] - x), abs(at[1] - y)))
    assert errors[0] < 5e-4
    assert errors[0] / errors[1] > 10
    assert errors[2] < 1.5e-5  # of this, 1e-5 is the axial strain


def test_rolled_up_to_a_quarter_circle() -> None:
    moment = np.pi / 2
    system = sr.System(chain(4, 1.0, torque=(0, 0, moment), **THIN))
    found = sr.equilibrium(system)
    at = found.q[system.coordinates_of("n4")]
    assert at[:2] == pytest.approx([2 / np.pi, 2 / np.pi], abs=3e-5)
    assert sr.simulate(system, found, until=1e-6)["beam2.moment.z"][0] == pytest.approx(moment, rel=1e-5)


@pytest.mark.parametrize(("n", "limits"), [(2, (6e-4, 9e-3)), (4, (4e-5, 1.2e-3)), (8, (3e-6, 9e-5))])
def test_frequencies_of_a_cantilever(n: int, limits: tuple[float, float]) -> None:
    """Bending about z; the section is so thin that rotary inertia and shear are below 1e-6."""
    section = {"E": 2e11, "G": 8e10, "density": 8000.0, "area": 1e-4, "I_y": 1e-10, "I_z": 1e-14, "J": 1e-10}
    system = sr.System(chain(n, 1.0, **section))
    found = sr.modes(system, sr.equilibrium(system))
    unit = np.sqrt(2e11 * 1e-14 / (8000 * 1e-4))
    for root, limit in zip((1.8751040687119611, 4.694091132974175), limits, strict=True):
        wanted = root**2 * unit / (2 * np.pi)
        near = min(abs(found.natural_frequencies / wanted - 1))
        assert near < limit


def test_weight_is_nodally_exact() -> None:
    section = {"E": 2e11, "G": 8e10, "density": 8000.0, "area": 1e-4, "I_y": 1e-8, "I_z": 1e-8, "J": 1e-8}
    w, L, EI = 8000 * 1e-4 * 9.81e-3, 1.0, 2e11 * 1e-8  # little of it: deflections stay small
    system = sr.System(chain(2, L, gravity=(0, 0, -9.81e-3), **section))
    at = sr.equilibrium(system).q
    for k, x in ((1, L / 2), (2, L)):
        deflection = w * x**2 * (6 * L**2 - 4 * L * x + x**2) / (24 * EI)
        assert at[system.coordinates_of(f"n{k}")][2] == pytest.approx(-deflection, rel=1e-7)


def test_a_curved_beam_is_at_rest_where_it_is_designed() -> None:
    """Quarter of an arc of radius 1 in two beams, on bodies that are turned."""
    s = np.sqrt(0.5)
    middle = sr.Body("m", 1.0, (1, 1, 1), position=(s, 1 - s, 0), orientation=[0.5, 0.5, 0.5, 0.5])
    end = sr.Body("e", 1.0, (1, 1, 1), position=(1, 1, 0), orientation=[s, 0, s, 0])
    beams = [
        sr.Beam(
            *("a", sr.ground.point(0, 0, 0), middle.point(0, 0, 0)), tangent_i=(1, 0, 0), tangent_j=(s, s, 0),
            rectangle=(0.02, 0.01), **STEEL,
        ),
        sr.Beam(
            *("b", middle.point(0, 0, 0), end.point(0, 0, 0)), tangent_i=(s, s, 0), tangent_j=(0, 1, 0),
            rectangle=(0.02, 0.01), **STEEL,
        ),
    ]  # fmt: skip
    system = sr.System(sr.Model("arc", [middle, end], [], beams))
    assert abs(system.Q(system.q0, 0 * system.q0)).max() < 1e-6  # of EA = 4e7
    assert sr.modes(system, sr.equilibrium(system)).stability == "marginal"
    run = sr.simulate(system, until=1e-6)
    assert run["a.curvature.z"][0] == pytest.approx(1.0, rel=1e-3)  # of the arc: π/4 over its length


def test_damping_ratio() -> None:
    tau = 1e-4
    system = sr.System(chain(1, 0.5, rectangle=(0.02, 0.01), density=7850.0, damping=tau, **STEEL))
    found = sr.modes(system, sr.equilibrium(system))
    omega = 2 * np.pi * found.natural_frequencies[:3]
    assert found.damping_ratios[:3] == pytest.approx(omega * tau / 2, rel=1e-6)


def test_derivatives_energy_and_gradients() -> None:
    section = {"E": 2e8, "nu": 0.3, "rectangle": (0.03, 0.02), "density": 1500.0, "damping": 1e-4}
    model = chain(2, 1.0, gravity=(0.3, 0.2, -9.81), **section)
    system = sr.System(model)
    assert system.check_derivatives()
    run = sr.simulate(system, until=0.2, method=sr.Radau(rtol=1e-9, atol=1e-11), store="steps")
    names = ["beam0.E", "beam1.nu", "beam1.rectangle.y", "beam0.density", "beam1.damping"]
    forward = sr.sensitivity(run, [sr.Final("n2.z"), sr.Maximum("beam0.moment.y")], names)
    direct = sr.sensitivity(run, [sr.Final("n2.z"), sr.Maximum("beam0.moment.y")], names, method="direct")
    assert forward.matrix == pytest.approx(direct.matrix, rel=1e-8)


def test_deflection_by_modulus() -> None:
    force = 1.0
    system = sr.System(
        chain(2, 1.0, force=(0, 0, force), density=1.0, rectangle=(0.03, 0.02), shear=(1e6, 1e6), **STEEL)
    )
    rest = sr.equilibrium(system)
    deflection = force / (3 * 210e9 * 0.03 * 0.02**3 / 12)
    assert rest["n2.z"] == pytest.approx(deflection, rel=1e-7)
    by_modulus = sr.sensitivity(rest, "n2.z", ["beam0.E", "beam1.E"]).matrix.sum()
    assert by_modulus == pytest.approx(-deflection / 210e9, rel=1e-6)


def test_sections() -> None:
    square = rectangle(0.2, 0.2, 0.3)
    assert square.J == pytest.approx(0.1405770149 * 0.2**4, rel=1e-9)
    flat = rectangle(0.4, 0.1, 0.3)
    series = mp.nsum(lambda n: mp.tanh((2 * n + 1) * mp.pi * 2) / (2 * n + 1) ** 5, [0, mp.inf])
    assert flat.J == pytest.approx(float(0.4 * 0.1**3 * (1 - 48 / mp.pi**5 * series) / 3), rel=1e-14)
    assert flat.J == rectangle(0.1, 0.4, 0.3).J
    assert tube(0.1, 0.0, 0.3).shear[0] == pytest.approx(6 * 1.3 / (7 + 6 * 0.3))
    thin = tube(0.1, 0.0999, 0.3)
    assert thin.shear[0] == pytest.approx(2 * 1.3 / (4 + 3 * 0.3), rel=1e-5)
    assert thin.J == 2 * thin.I_y
    profile = i_section(0.1, 0.2, 0.01, 0.006, 0.3)
    parts = 2 * (0.1 * 0.01**3 / 12 + 0.1 * 0.01 * 0.095**2) + 0.006 * 0.18**3 / 12
    assert profile.I_y == pytest.approx(parts)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"E": 1e9, "circle": 0.1}, "needs one of nu and G"),
        ({"E": 1e9, "nu": 0.8, "circle": 0.1}, "Poisson's ratio is between -1 and 0.5"),
        ({"E": 1e9, "nu": 0.3}, "its section is missing. Give one of rectangle"),
        ({"E": 1e9, "nu": 0.3, "circle": 0.1, "area": 1.0}, "has circle and area"),
        ({"E": 1e9, "nu": 0.3, "tube": (0.1, 0.2)}, "Give the outer sizes first"),
        ({"E": 1e9, "nu": 0.3, "circle": 0.1, "up": (1, 0, 0)}, "up is along the beam"),
        (
            {"E": 1e9, "nu": 0.3, "circle": 0.1, "tangent_i": (-1, 0, 0)},
            "tangent_i points away from the beam",
        ),
        ({"E": 1e9, "nu": 0.3, "circle": 0.1, "density": -1.0}, "density"),
    ],
)
def test_wrong_beams_are_refused(values: dict, message: str) -> None:
    body = sr.Body("a", 1.0, (1, 1, 1), position=(1, 0, 0))
    with pytest.raises(sr.ModelError, match=message):
        sr.System(
            sr.Model(
                "m", [body], forces=[sr.Beam("b", sr.ground.point(0, 0, 0), body.point(0, 0, 0), **values)]
            )
        )
