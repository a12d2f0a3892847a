"""Ellipsoids in a fluid: drag, lift and added mass beside closed forms, and their derivatives of all orders."""

from itertools import permutations
from typing import Any

import numpy as np
import pytest
from scipy.special import elliprd

import sarrus as sr
from sarrus.analyses.sensitivity.parameters.parameters import UnknownParameter
from sarrus.model.forces.fluids import added_masses

LAW = {"density": 100.0, "viscosity": 0.5}
MOTION = {"velocity": (1, 2, 3), "angular_velocity": (3, 2, 1)}
NO_DRAG = {"blunt_drag": 0.0, "slender_drag": 0.0, "angular_drag": 0.0}


def body_in_fluid(
    *, wind: Any = (0.3, 0.2, 0.1), velocity: Any = MOTION["velocity"], **law: Any
) -> sr.System:
    """A free body with an ellipsoid that is not at its centre of mass."""
    body = sr.Body("a", 2.0, (0.1, 0.2, 0.25), **(MOTION | {"velocity": velocity}))
    given = {"semiaxes": (0.1, 0.2, 0.3), **LAW, **law}
    frame = body.frame((0.1, 0.2, 0.3), z=(1, 2, 2))
    return sr.System(sr.Model("m", [body], forces=[sr.EllipsoidDrag("drag", frame, wind=wind, **given)]))


@pytest.mark.slow
def test_every_operator() -> None:
    """In motion; near rest, where squares of velocities are rounded; and without drag of rotations."""
    assert body_in_fluid().check_derivatives()
    assert body_in_fluid(creep=3.0, semiaxes=(0.2, 0.1, 0.1), kutta_lift=-2.0).check_derivatives()
    assert body_in_fluid(**NO_DRAG).check_derivatives()
    assert body_in_fluid(semiaxes=(0.2, 0.2, 0.2), blunt_drag=0.0, angular_drag=0.0).check_derivatives()


@pytest.mark.slow
def test_derivatives_of_a_run_by_all_parameters() -> None:
    """Also by semi-axes, of which areas, moments and added masses are functions."""
    options = {"until": 0.3, "store": "steps", "method": sr.Radau(rtol=1e-10)}
    given = {**LAW, "blunt_drag": 0.5, "slender_drag": 0.25, "angular_drag": 1.5, "kutta_lift": 1.0}
    given |= {"magnus_lift": 1.0, "semiaxes": (0.1, 0.2, 0.3)}
    names = [*(f"drag.{name}" for name in given if name != "semiaxes"), "drag.semiaxes.x", "drag.semiaxes.y"]
    run = sr.simulate(body_in_fluid(**given), **options)
    gradient = sr.sensitivity(run, sr.Final("a.x"), names)
    for name in names:
        values, axis = [], "xyz".find(name[-1])
        for sign in (-1, 1):
            changed = dict(given)
            if name.startswith("drag.semiaxes"):
                axes = np.array(given["semiaxes"])
                axes[axis] *= 1 + 1e-3 * sign
                changed["semiaxes"], step = tuple(axes), 1e-3 * given["semiaxes"][axis]
            else:
                key = name.removeprefix("drag.")
                changed[key], step = given[key] * (1 + 1e-3 * sign), 1e-3 * given[key]
            values.append(sr.simulate(body_in_fluid(**changed), **options)["a.x"][-1])
        assert gradient[name] == pytest.approx((values[1] - values[0]) / (2 * step), rel=2e-5), name


def test_added_masses_are_parameters_where_they_are_given() -> None:
    run = sr.simulate(body_in_fluid(), until=0.01, store="steps")
    with pytest.raises(UnknownParameter, match="Give added_mass to differentiate by it"):
        sr.sensitivity(run, sr.Final("a.x"), ["drag.added_mass.x"])
    for field in ("added_mass", "added_inertia"):
        with pytest.raises(sr.ModelError, match=f"{field} must not be negative, but is -1"):
            body_in_fluid(**{field: (0, -1, 0)})


def test_a_sphere_that_falls() -> None:
    """Its weight is 6π β r v + ρ C π r² v²; the power of the weight is dissipated."""
    m, r, rho, beta, blunt = 3.0, 0.1, 50.0, 4.0, 0.4
    body = sr.Body("ball", m, (1, 1, 1))
    law = {"density": rho, "viscosity": beta, "blunt_drag": blunt}
    force = sr.EllipsoidDrag("drag", body.frame((0, 0, 0)), (r, r, r), **law)
    run = sr.simulate(sr.System(sr.Model("m", [body], forces=[force], gravity=(0, 0, -9.81))), until=10.0)
    square, linear = rho * blunt * np.pi * r**2, 6 * np.pi * beta * r
    speed = (np.sqrt(linear**2 + 4 * square * m * 9.81) - linear) / (2 * square)
    assert run["ball.velocity.z"][-1] == pytest.approx(-speed, rel=1e-6)
    assert run["drag.dissipated_power"][-1] == pytest.approx(m * 9.81 * speed, rel=1e-6)


def test_lift_and_added_mass_do_no_work() -> None:
    """Without drag the kinetic energy of a body that tumbles is constant, and a wind only carries it along."""
    run = sr.simulate(
        body_in_fluid(wind=(0, 0, 0), viscosity=0.0, **NO_DRAG), until=2.0, method=sr.Radau(rtol=1e-9)
    )
    energy = run["energy.kinetic"]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-7)
    assert np.ptp(run["a.velocity.x"]) > 0.5  # it does not move on a straight line
    assert abs(run["drag.dissipated_power"]).max() < 1e-12 * energy[0]


def test_a_wind_is_a_motion_of_the_observer() -> None:
    """With the velocities of the wind added, positions differ by the way of the wind."""
    wind = np.array([0.3, -0.2, 0.1])
    given = {"until": 1.0, "method": sr.Radau(rtol=1e-9)}
    still = sr.simulate(body_in_fluid(wind=(0, 0, 0)), **given)
    blown = sr.simulate(
        body_in_fluid(wind=tuple(wind), velocity=tuple(np.add(MOTION["velocity"], wind))), **given
    )
    moved = blown["a"].position[-1] - still["a"].position[-1]
    np.testing.assert_allclose(moved, wind, atol=1e-6)


def test_added_masses_of_spheres_discs_and_spheroids() -> None:
    """Half of the displaced mass; 8/3 ρ r³ for a thin disc; Lamb's formula for a prolate spheroid."""
    masses, inertias = added_masses((0.2, 0.2, 0.2), 1000.0)
    np.testing.assert_allclose(masses, 500 * 4 / 3 * np.pi * 0.2**3, rtol=1e-13)
    np.testing.assert_allclose(inertias, 0, atol=1e-13)
    masses, inertias = added_masses((0.2, 0.2, 1e-7), 1000.0)
    assert masses[2] == pytest.approx(8 / 3 * 1000 * 0.2**3, rel=1e-5)
    assert inertias[0] == pytest.approx(16 / 45 * 1000 * 0.2**5, rel=1e-5)
    b, a = 0.1, 0.4
    e = np.sqrt(1 - (b / a) ** 2)
    alpha = 2 * (1 - e**2) / e**3 * (np.arctanh(e) - e)
    masses, _ = added_masses((b, b, a), 1.0)
    assert masses[2] == pytest.approx(4 / 3 * np.pi * a * b * b * alpha / (2 - alpha), rel=1e-13)


@pytest.mark.parametrize("semiaxes", [(0.1, 0.2, 0.3), (1e-3, 0.5, 2.0), (3.0, 2.0, 2.0 + 1e-9)])
def test_added_masses_of_other_ellipsoids(semiaxes: tuple[float, float, float]) -> None:
    """Beside SciPy's elliptic integral, and by any order of the axes."""
    a, b, c = semiaxes
    volume = 4 / 3 * np.pi * a * b * c
    masses, inertias = added_masses(semiaxes, 1.0)
    for n, (x, y, z) in enumerate(((a, b, c), (b, c, a), (c, a, b))):
        factor = 2 / 3 * a * b * c * elliprd(y * y, z * z, x * x)
        assert masses[n] == pytest.approx(volume * factor / (2 - factor), rel=1e-12)
    for order in permutations(range(3)):
        again = added_masses(tuple(semiaxes[n] for n in order), 1.0)  # type: ignore[arg-type]
        np.testing.assert_allclose(again[0], [masses[n] for n in order], rtol=1e-12)
        np.testing.assert_allclose(again[1], [inertias[n] for n in order], rtol=1e-6, atol=1e-12 * volume)


def test_added_masses_can_be_given() -> None:
    """Those of the ellipsoid are the default."""
    masses, inertias = added_masses((0.1, 0.2, 0.3), LAW["density"])
    systems = [
        body_in_fluid(),
        body_in_fluid(added_mass=masses, added_inertia=inertias),
        body_in_fluid(added_mass=(0, 0, 0)),
    ]
    forces = [one.Q(one.q0, one.v0, 0.0) for one in systems]
    np.testing.assert_allclose(forces[0], forces[1], rtol=1e-14)
    assert abs(forces[0] - forces[2]).max() > 0.1


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"semiaxes": (0.1, 0.0, 0.2)}, "semiaxes must be greater than 0"),
        (
            {"semiaxes": (1e-120, 1e-120, 1e-120)},
            r"semiaxes are too small, they are 1e-120, 1e-120, 1e-120 m",
        ),
        ({"semiaxes": (1e12, 1e12, 1e12)}, r"semiaxes are too large, they are 1e\+12, 1e\+12, 1e\+12 m"),
        ({"creep": 1e-200}, "creep is too small, it is 1e-200"),
        ({"blunt_drag": -1.0}, "blunt_drag must not be negative"),
        ({"density": -1.0}, "density must not be negative"),
        ({"creep": 0.0}, "creep must be greater than 0"),
        ({"added_mass": (1, 2)}, "added_mass must have 3 numbers"),
    ],
)
def test_wrong_values_are_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(sr.ModelError, match=message):
        body_in_fluid(**given)


@pytest.mark.parametrize("size", [1e-40, 1e-20, 1e-9, 1e6])
def test_loads_of_all_sizes_are_those_of_another_unit(size: float) -> None:
    """Drag without viscosity grows with the area, added masses with the volume."""
    law = {
        "viscosity": 0.0,
        "kutta_lift": 0.7,
        "magnus_lift": 0.0,
        "added_mass": (0, 0, 0),
        "angular_drag": 0.0,
    }
    law |= {"slender_drag": 0.2, "added_inertia": (0, 0, 0)}

    def force(factor: float) -> Any:
        system = body_in_fluid(semiaxes=tuple(factor * x for x in (0.1, 0.2, 0.3)), **law)
        return system.Q(system.q0, system.v0, 0.0)[:3] / factor**2

    np.testing.assert_allclose(force(size), force(1.0), rtol=1e-12)


@pytest.mark.parametrize("kind", ["box", "ellipsoid"])
def test_rounding_of_rotations_has_a_speed_of_its_own(kind: str) -> None:
    """At an angular velocity far below its own creep the torque is linear with it; forces do not depend on it."""
    body = sr.Body("a", 1.0, (0.1, 0.1, 0.1), velocity=(1, 0, 0), angular_velocity=(0, 0, 1e-3))

    def wrench(**creep: float) -> np.ndarray:
        frame = body.frame((0, 0, 0))
        sides = (
            {"box": (0.2, 0.3, 0.4)} if kind == "box" else {"semiaxes": (0.2, 0.3, 0.4), "kutta_lift": 0.0}
        )
        if kind == "ellipsoid":
            sides |= {"magnus_lift": 0.0, "added_mass": (0, 0, 0), "added_inertia": (0, 0, 0)}
        drag = (sr.BoxDrag if kind == "box" else sr.EllipsoidDrag)(
            "d", frame, density=1000.0, **sides, **creep
        )
        system = sr.System(sr.Model("m", [body], [], [drag]))
        return system.Q(system.q0, system.v0)

    same, wide = wrench(creep=1e-5), wrench(creep=1e-5, angular_creep=1.0)
    assert wrench(creep=1e-5, angular_creep=1e-5) == pytest.approx(same, rel=1e-14)
    assert wide[:3] == pytest.approx(same[:3], rel=1e-14)
    assert wide[6] / same[6] > 500
    if kind == "box":
        assert wide[6] / same[6] == pytest.approx(np.sqrt(1 + 1e-6) / np.sqrt(1e-6 + 1e-10), rel=1e-9)
    with pytest.raises(sr.ModelError, match="angular_creep"):
        wrench(angular_creep=-1.0)
