"""The power of every force is what it supplies, less what it dissipates, less the rate of what it stores."""

import importlib
import pkgutil

import numpy as np
import pytest

from sarrus.elements import Element, Force
from sarrus.elements.element import Pair, Single
from sarrus.elements.forces.laws import contact_energy, contact_force
from sarrus.model import forces

STEP = 1e-200
for _module in pkgutil.walk_packages(
    forces.__path__, f"{forces.__name__}."
):  # some forces have elements of their own
    importlib.import_module(_module.name)
KINDS = {name: kind for name, kind in Element.registry.items() if issubclass(kind, Force)}
KINDS = {name: kind for name, kind in KINDS.items() if kind.__module__.startswith("sarrus.")}
LOADS = [name for name in KINDS if name.endswith(("Force", "Torque")) or "Gravity" in name]
SIGNS = {
    "k": 1,
    "c": 1,
    "c_turn": 1,
    "friction": 1,
    "box": 1,
    "density": 1,
    "viscosity": 1,
    "width": 1,
    "mu": 1,
    "mu_static": 1,
    "creep": 1,
    "stribeck": 1,
    "viscous": 1,
    "load": 1,
    "semiaxes": 1,
    "blunt_drag": 1,
    "slender_drag": 1,
    "moment": 1,
    "turning": 1,
}
SIZES = {"width": 0.2, "radius": 0.8, "damping": 0.3}


class Cubic:
    """A curve that any number can be put into."""

    def __init__(self, numbers: np.ndarray) -> None:
        self._c = numbers

    def __call__(self, x):
        return 2 + self._c[0] * x + self._c[1] * x * x

    def slope(self, x):
        return self._c[0] + 2 * self._c[1] * x

    def moment(self, a, b):
        """The integral of the curve times x - a, by its antiderivative."""

        def part(x):
            c0, c1, c2, c3 = -2 * a, 2 - a * self._c[0], self._c[0] - a * self._c[1], self._c[1]
            return c0 * x + c1 * x**2 / 2 + c2 * x**3 / 3 + c3 * x**4 / 4

        return part(b) - part(a)


class Saddle:
    """The surface z = a x + b y + c x y of any numbers."""

    def __init__(self, numbers: np.ndarray) -> None:
        self._a, self._b, self._c = numbers

    def derivative(self, x, y, i, j):
        a, b, c = self._a, self._b, self._c
        return {(0, 0): a * x + b * y + c * x * y, (1, 0): a + c * y, (0, 1): b + c * x}[i, j]


def element_of(kind, random):
    values = []
    for name, field in kind.fields.items():
        if field == "Curve":
            values.append(Cubic(0.2 * random.uniform(size=2)))
        elif field == "Surface":
            values.append(Saddle(random.normal(size=3)))
        elif field == "Mat66":
            half = random.normal(size=(6, 6))
            values.append((half @ half.T + random.normal(size=(6, 6)) * (name == "K")).ravel())
        elif field in ("Vec3", "Vec6", "Inertia"):
            several = random.normal(size={"Vec3": 3}.get(field, 6))
            values.append(abs(several) if name in SIGNS else several)
        elif name in ("exponent", "sign"):
            values.append(
                {"exponent": random.choice([1.0, 1.5, 3.0]), "sign": random.choice([-1.0, 1.0])}[name]
            )
        else:
            size = random.normal() * SIZES.get(name, 1.0)
            values.append(abs(size) if name in SIGNS or name in SIZES else size)
    made = dict(zip(kind.fields, values, strict=True))
    if "length" in made and "C" in made:  # of beams
        made.update({name: abs(made[name]) for name in ("length", "C", "time") if name in made})
    axes, _ = np.linalg.qr(random.normal(size=(3, 3)))
    axes[:, 2] *= np.linalg.det(axes)
    for n, axis in enumerate("fgh"):
        for own in (axis, f"{axis}_i", f"{axis}_j"):
            if own in made:
                made[own] = axes[:, n]
    if "e_0" in made:
        made["e_0"], *e = (unit := np.array([made["e_0"], *made["e"]])) / np.linalg.norm(unit)
        made["e"] = np.array(e)
    if "semiaxes" in made:
        made["area"] = np.pi * np.prod(np.sort(made["semiaxes"])[1:])
    if "n_j" in made:
        made["n_j"] = axes[:, 0]
    return kind(**made)


def states_of(element, random):
    """Unit Euler parameters, with rates that keep them so; h is the same in both bodies of one with a common axis."""
    bodies = []
    for _ in range(element.bodies):
        p = random.normal(size=4)
        p /= np.linalg.norm(p)
        rate = random.normal(size=4)
        bodies += [0.5 * random.normal(size=3), p, random.normal(size=3), rate - (rate @ p) * p]
    if "h_j" in element.fields:  # h is the same in both bodies
        angle, speed, h = random.uniform(-2, 2), random.normal(), element.h_i
        (p, rate), turned = bodies[1:4:2], np.append(np.cos(angle / 2), np.sin(angle / 2) * h)
        turning = 0.5 * speed * np.append(-np.sin(angle / 2), np.cos(angle / 2) * h)
        bodies[5], bodies[7] = product(p, turned), product(rate, turned) + product(p, turning)
    kind = Single if element.bodies == 1 else Pair
    return kind(*sum(zip(bodies[0::4], bodies[1::4], strict=True), ())), kind(
        *sum(zip(bodies[2::4], bodies[3::4], strict=True), ())
    )


def product(a, b):
    """Of quaternions, scalar first."""
    return np.append(a[0] * b[0] - a[1:] @ b[1:], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))


def balance(name: str, seed: int):
    random = np.random.default_rng([seed, *map(ord, name)])
    element = element_of(KINDS[name], random)
    (x, v), t = states_of(element, random), 0.3
    moved = type(x)(*(a + 1j * STEP * b for a, b in zip(x, v, strict=True)))
    stored = complex(element.stored_energy(moved, v, t + 1j * STEP)).imag / STEP
    parts = [element.power(x, v, t), element.supplied_power(x, v, t), element.dissipated_power(x, v, t)]
    return [float(part) for part in (*parts, stored)]


@pytest.mark.parametrize("name", KINDS)
def test_the_power_is_split_without_rest(name: str) -> None:
    some = np.array([balance(name, seed) for seed in range(40)])
    power, supplied, dissipated, stored = some.T
    scale = abs(some).max(axis=1)
    assert np.all(abs(power - (supplied - dissipated - stored)) <= 1e-12 * scale + 1e-13)
    if "Nonlinear" not in name:  # a curve may give what a number may not
        assert np.all(dissipated >= -1e-12 * scale)
    if "Gravity" not in name:
        assert np.count_nonzero(power) > 5
    if name in LOADS and "Gravity" not in name:
        assert np.array_equal(power, supplied)
    elif not any(word in name for word in ("SDA", "Bushing", "Road", "Surface", "Drag", "Fluid", *LOADS)):
        assert not supplied.any()


def test_all_elements_are_here() -> None:
    some = {"TSDA", "RSDA", "Bushing", "Tyre", "RoadTyre", "SphereContact", "LengthStop", "Drag"}
    assert some | {"BoxInFluid", "EllipsoidInFluid", "RotationSpring"} <= set(KINDS)


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.2, 3.0])
@pytest.mark.parametrize("depth", [-0.06, -0.02, 0.03, 0.05, 0.4])
def test_the_energy_of_a_contact_is_the_integral_of_its_force(exponent: float, depth: float) -> None:
    from scipy.integrate import quad

    k, width = 7.0, 0.1
    force = lambda d: contact_force(d, 0.0, k, exponent, 0.3, width)  # noqa: E731
    wanted = quad(force, -0.05, depth, points=[0.05], epsabs=1e-15, epsrel=1e-13)[0] if depth > -0.05 else 0.0
    assert contact_energy(depth, k, exponent, width) == pytest.approx(wanted, rel=1e-11, abs=1e-16)
