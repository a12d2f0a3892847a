"""The errors that volumes state, beside true ones: arms of yaw, pitch and reach, known in closed form."""

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

import sarrus as sr
from sarrus.analyses.workspace.volumes.quadrature import Integral

from .mechanisms import Case


class Arm(NamedTuple):
    """Shoulder beside the axis by `beside`; ranges of the pitch within a quarter turn and of the reach; yaw's range."""

    beside: float
    pitch: tuple[float, float]
    reach: tuple[float, float]
    yaw: float

    @property
    def volume(self) -> float:
        """By Pappus' theorem."""
        (low, high), (near, far) = self.pitch, self.reach
        beside = self.beside * (high - low) * (far**2 - near**2) / 2
        return float(self.yaw * (beside + (np.sin(high) - np.sin(low)) * (far**3 - near**3) / 3))

    @property
    def heights(self) -> tuple[float, float]:
        (low, high), ends = np.sin(self.pitch), self.reach
        return min(low * r for r in ends), max(high * r for r in ends)

    def section(self, z: float) -> tuple[float, float]:
        """The nearest and farthest reach at a height."""
        near, far = max(self.reach[0], abs(z)), self.reach[1]
        flat, steep = sorted(np.sin(self.pitch) * (1 if z > 0 else -1))
        return max(near, abs(z) / steep), min(far, abs(z) / flat) if flat > 0 else far

    def area(self, z: float) -> float:
        inner, outer = (self.beside + np.sqrt(r * r - z * z) for r in self.section(z))
        return float(self.yaw * (outer**2 - inner**2) / 2)

    def case(self) -> Case:
        at, x, y, z = (self.beside, 0.0, 0.0), (1, 0, 0), (0, -1, 0), (0, 0, 1)
        yaw, pitch, reach = (
            sr.Body(name, mass=1, inertia=(1, 1, 1), position=at) for name in ("a", "b", "c")
        )
        joints = [
            sr.Revolute("yaw", sr.ground, yaw, point=(0, 0, 0), axis=z),
            sr.Revolute("pitch", yaw, pitch, point=at, axis=y),
            sr.Translational("reach", pitch, reach, point=at, axis=x),
        ]
        system = sr.System(sr.Model("arm", bodies=[yaw, pitch, reach], joints=joints))
        limits = {"yaw": (-self.yaw / 2, self.yaw / 2), "pitch": self.pitch, "reach": self.reach}
        return system, reach.point(0, 0, 0)["x", "y", "z"], limits


def random_arm(rng: np.random.Generator) -> Arm:
    """Some with a pitch that ends upright, where the area ends like a root inside the range."""
    low, high = rng.uniform(-1.5, -0.1), rng.uniform(0.1, 1.5)
    high = np.pi / 2 if rng.random() < 0.4 else high
    near = rng.uniform(0.1, 0.8)
    return Arm(rng.uniform(0.05, 1), (low, high), (near, near + rng.uniform(0.2, 1)), rng.uniform(1, 5))


class Sections:
    """In place of a slicer: slices in closed form."""

    def __init__(self, arm: Arm) -> None:
        self.arm, self.known = arm, dict[float, Any]()

    def at(self, heights: Any) -> list[Any]:
        found = [self.known.get(z) or self._slice(z) for z in heights]
        self.known |= {one.height: one for one in found}
        return found

    def _slice(self, z: float) -> Any:
        return SimpleNamespace(
            height=z, area=self.arm.area(z), area_error=0.0, success=True, rates=None, kinked=0.0
        )

    def reconcile(self) -> bool:
        return False


@pytest.mark.one_in(8)
@pytest.mark.parametrize("rtol", [1e-3, 1e-4, 1e-5])
@pytest.mark.parametrize("known", [True, False], ids=["critical heights known", "kinks not seen"])
def test_true_errors_are_within_stated_ones(rtol: float, known: bool) -> None:
    """Kinks of the area are met by halving alone where no critical height is known before."""
    rng = np.random.default_rng(5)
    for arm in [random_arm(rng) for _ in range(40)]:
        critical = sorted({s * r for s in np.sin(arm.pitch) for r in arm.reach}) if known else []
        found = Integral(Sections(arm), [arm.heights], critical, rtol, 600)  # type: ignore[arg-type]
        found.run()
        assert abs(found.value - arm.volume) <= found.error <= rtol * arm.volume


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_true_errors_of_real_arms_are_within_stated_ones(seed: int) -> None:
    arm = random_arm(np.random.default_rng(seed))
    system, output, limits = arm.case()
    found = sr.workspace_volume(system, output, limits=limits, rtol=1e-2, samples=20)
    assert abs(found.volume - arm.volume) <= found.volume_error <= 1e-2 * arm.volume
