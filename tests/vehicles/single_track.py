"""A vehicle with one track: a body that only moves in the plane, with two wheels on brush tyres without trail."""

from __future__ import annotations

import numpy as np

import sarrus as sr
from sarrus.algebra import Array

MASS, INERTIA, FRONT, REAR, RADIUS = 1200.0, 1500.0, 1.1, 1.4, 0.3
C_FRONT, C_REAR, RELAXATION = 90e3, 110e3, 0.4
LINEAR = 1e4  # friction with which the brush is linear
WHEEL = 2.0  # [kg] mass of a wheel
SPIN = (0.005, 0.01, 0.005)  # [kg m²] its moments of inertia
SERVO = (500.0, 2.0)  # [N m/rad], [N m s/rad]
NAMES = sr.VehicleNames(speed="")


def tyre(name: str, wheel: sr.Body, c_alpha: float, mu: float) -> sr.BrushTyre:
    """A tyre without trail; its slip stiffness forwards is that to the side."""
    numbers = {"radius": RADIUS, "k": 2e5, "c": 2e3, "c_kappa": c_alpha, "mu": mu, "half_length": 1e-9}
    return sr.BrushTyre(name, wheel.point(0, 0, 0), c_alpha=c_alpha, relaxation_y=RELAXATION, **numbers)


def single_track(
    brakes: float = 0.0, mu: float = LINEAR, servo: bool = False, pressure: float = 0.0
) -> sr.System:
    """The vehicle, whose front fork turns by the input ``steer``, exactly or by a servo; brakes may have a lag [s]."""
    height = RADIUS - MASS * 9.81 / 2 / 2e5
    chassis = sr.Body("chassis", MASS, (500, 1500, INERTIA), position=(0, 0, height))
    fork = sr.Body("fork", 0, (0, 0, 0), position=(FRONT, 0, height))
    front = sr.Body("front", WHEEL, SPIN, position=(FRONT, 0, height))
    rear = sr.Body("rear", WHEEL, SPIN, position=(-REAR, 0, height))
    joints = [
        sr.Planar("plane", sr.ground, chassis, point=(0, 0, height), axis=(0, 0, 1)),
        sr.Revolute("kingpin", chassis, fork, point=fork.position, axis=(0, 0, 1)),
        sr.Revolute("hub_front", fork, front, point=front.position, axis=(0, 1, 0)),
        sr.Revolute("hub_rear", chassis, rear, point=rear.position, axis=(0, 1, 0)),
    ]
    lag = [sr.FirstOrderLag("pressure", input="brake", time=pressure)] if pressure else []
    level = "pressure" if pressure else "brake"
    forces = [
        sr.Input("steer", 0.0, unit="rad"), sr.Input("brake", 0.0), sr.Input("drive", 0.0),
        tyre("tyre_front", front, C_FRONT, mu), tyre("tyre_rear", rear, C_REAR, mu),
        *(sr.Brake(f"brake_{one}", f"hub_{one}", f"{brakes}*{level}") for one in ("front", "rear")),
        *lag,
    ]  # fmt: skip
    drivers = [] if servo else [sr.AngleDriver("turn", "kingpin", "steer")]
    if servo:
        forces.append(sr.Torque("servo", joint="kingpin", value=f"-{SERVO[0]}*(x - steer) - {SERVO[1]}*v"))
    return sr.System(
        sr.Model(
            "single track",
            [chassis, fork, front, rear],
            joints,
            forces,
            drivers=drivers,
            gravity=(0, 0, -9.81),
        )
    )


def whole(chassis: float = MASS) -> tuple[float, float, float, float]:
    """Mass, moment of inertia about the vertical axis, and distances of the axles from the centre of mass."""
    mass = chassis + 2 * WHEEL
    x = WHEEL * (FRONT - REAR) / mass
    inertia = INERTIA + chassis * x**2 + 2 * SPIN[2] + WHEEL * ((FRONT - x) ** 2 + (REAR + x) ** 2)
    return mass, inertia, FRONT - x, REAR + x


def state_matrix(speed: float, chassis: float = MASS) -> tuple[Array, Array]:
    """A and B of (v_y, ψ̇, v_f, v_r), with the deflections v of the tyres: v̇ = V_sy − V v/σ, F_y = −C v/σ."""
    mass, inertia, l_f, l_r = whole(chassis)
    f, r, back = C_FRONT / RELAXATION, C_REAR / RELAXATION, speed / RELAXATION
    matrix = [
        [0, -speed, -f / mass, -r / mass],
        [0, 0, -l_f * f / inertia, l_r * r / inertia],
        [1, l_f, -back, 0],
        [1, -l_r, 0, -back],
    ]
    return np.array(matrix, dtype=float), np.array([0, 0, -speed, 0], dtype=float)


def steered(speed: float, s: complex, chassis: float = MASS) -> Array:
    """Yaw rate and lateral acceleration of the chassis over the input of the servo, at a complex frequency."""
    mass, inertia, _, _ = whole(chassis)
    k, c = SERVO
    A = np.zeros((6, 6))  # of v_y, ψ̇, v_f, v_r, δ, δ̇
    tyres, by_angle = state_matrix(speed, chassis)
    A[:4, :4], A[:4, 4], A[4, 5] = tyres, by_angle, 1.0
    wheel = SPIN[2]  # (inertia - wheel) ψ̈ = tyres + k (δ - u) + c δ̇, wheel (ψ̈ + δ̈) = -k (δ - u) - c δ̇
    A[1, :4] *= inertia / (inertia - wheel)
    A[1, 4:] = np.array([k, c]) / (inertia - wheel)
    A[5] = -A[1]
    A[5, 4:] -= np.array([k, c]) / wheel
    B = np.zeros(6)
    B[1], B[5] = -k / (inertia - wheel), k / wheel + k / (inertia - wheel)
    x = np.linalg.solve(s * np.eye(6) - A, B)
    return np.array([x[1], s * x[0] + speed * x[1] - s * x[1] * WHEEL * (FRONT - REAR) / mass])


def understeer(chassis: float = MASS) -> float:
    """K of the yaw gain V/(L + K V²): (m/L) (l_r/C_f − l_f/C_r)."""
    mass, _, l_f, l_r = whole(chassis)
    return mass / (l_f + l_r) * (l_r / C_FRONT - l_f / C_REAR)
