"""Random mechanisms against workspaces known by inverse kinematics: what is called mapped must hold.

    python benchmarks/workspace_attack.py [--seconds 600] [--seed 0] [--kinds arms five_bars platforms volumes]

Arms of two and three links with limits (some at 0 or pi), five-bars, and 3-RPR platforms: random places that the map
contains are compared with closed inverse kinematics; volumes of three hinges in space with the integral of sections in
closed form. A case is wrong if its status is "mapped" and a place or the stated error does not hold; it is unknown if
a warning was given. It ends with status 1 if any case was wrong.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np

TURN = 2 * np.pi
PLACES = 4000  # random ones of every case
SLACK = 0.01  # by which limits of the sampled oracles are widened before a place counts as out of reach
LONGEST = 100  # s of the clock for a map, four times as much for a volume


def within(angle: Any, limits: tuple[float, float], slack: float) -> Any:
    """Where an angle or one that differs by whole revolutions is between limits."""
    low = limits[0] - slack
    return angle + TURN * np.ceil((low - angle) / TURN) <= limits[1] + slack


def two_links(x: Any, base: float, lengths: Any, limits: Any, slack: float) -> Any:
    """Whether two links reach places (n, 2), seen from their base, which is turned by an angle."""
    cosine = ((x**2).sum(axis=1) - (lengths**2).sum()) / (2 * lengths[0] * lengths[1])
    found = np.zeros(len(x), dtype=bool)
    for bend in (1, -1):
        q2 = bend * np.arccos(np.clip(cosine, -1, 1))
        across = np.arctan2(lengths[1] * np.sin(q2), lengths[0] + lengths[1] * np.cos(q2))
        q1 = np.arctan2(x[:, 1], x[:, 0]) - across - base
        found |= (abs(cosine) <= 1 + slack) & within(q2, limits[1], slack) & within(q1, limits[0], slack)
    return found


def arms(random: Any) -> tuple[Any, Any]:
    """A planar arm of two or three links; a third of the limits are at 0, pi or -pi."""
    from tests.workspace.mechanisms import arm

    count = int(random.integers(2, 4))
    lengths, limits = random.uniform(0.3, 2.0, count), []
    for _ in range(count):
        low = random.choice([-np.pi, 0.0]) if random.random() < 0.3 else random.uniform(-3.0, 0.5)
        high = random.choice([0.0, np.pi]) if random.random() < 0.3 else low + random.uniform(0.3, 3.0)
        limits.append((low, high if high > low + 0.1 else low + 1.0))
    system, tip = arm(lengths.tolist())
    named = {f"q{n + 1}": pair for n, pair in enumerate(limits)}

    def reached(x: Any, slack: float) -> Any:
        if count == 2:
            return two_links(x, 0.0, lengths, limits, slack)
        found = np.zeros(len(x), dtype=bool)
        for q1 in np.linspace(*limits[0], 1200):
            elbow = lengths[0] * np.array([np.cos(q1), np.sin(q1)])
            found |= two_links(x - elbow, q1, lengths[1:], limits[1:], slack)
        return found

    return (system, tip["x", "y"], named), reached


def five_bars(random: Any) -> tuple[Any, Any]:
    """Two cranks and two rods without limits: the intersection of two annuli."""
    from tests.workspace.mechanisms import _bar, _corner, _hinge

    import sarrus as sr

    while True:
        feet = np.array([[-0.5, 0.0], [0.5, 0.0]]) * random.uniform(0.5, 3.0)
        cranks, rods, p = random.uniform(0.5, 2, 2), random.uniform(0.5, 2, 2), random.uniform(-2, 2, 2)
        away = np.linalg.norm(p - feet, axis=1)
        if np.all((abs(cranks - rods) + 0.1 < away) & (away < cranks + rods - 0.1)):
            break
    one, other = _corner(feet[0], cranks[0], p, rods[0]), _corner(p, rods[1], feet[1], cranks[1])
    bodies = [
        _bar("crank_1", feet[0], one),
        _bar("crank_2", feet[1], other),
        _bar("rod_1", one, p),
        _bar("rod_2", other, p),
    ]
    joints = [
        _hinge("a1", sr.ground, bodies[0], feet[0]),
        _hinge("a2", sr.ground, bodies[1], feet[1]),
        _hinge("b1", bodies[0], bodies[2], one),
        _hinge("b2", bodies[1], bodies[3], other),
        _hinge("p", bodies[2], bodies[3], p),
    ]
    system = sr.System(sr.Model("five-bar", bodies=bodies, joints=joints))

    def reached(x: Any, slack: float) -> Any:
        r = np.linalg.norm(x[:, None] - feet, axis=2)
        return np.all((r >= abs(cranks - rods) - slack) & (r <= cranks + rods + slack), axis=1)

    return (system, bodies[2].point(float(rods[0]), 0, 0)["x", "y"], {}), reached


def platforms(random: Any) -> tuple[Any, Any]:
    """A 3-RPR platform with limited legs and any orientation."""
    from tests.workspace.mechanisms import platform

    feet = np.array([(0, 0), (3, 0), (1.5, 2.6)]) + random.uniform(-0.5, 0.5, (3, 2))
    corners = np.array([(-0.5, -0.3), (0.5, -0.3), (0, 0.6)]) + random.uniform(-0.2, 0.2, (3, 2))
    low = random.uniform(0.5, 1.2, 3)
    limits = np.stack([low, low + random.uniform(0.5, 1.5, 3)], axis=1)
    system, output, legs = platform([tuple(one) for one in feet], [tuple(one) for one in corners])

    def reached(x: Any, slack: float) -> Any:
        found = np.zeros(len(x), dtype=bool)
        for phi in np.linspace(0, TURN, 1500):
            c, s = np.cos(phi), np.sin(phi)
            r = np.linalg.norm(x[:, None] + corners @ np.array([[c, s], [-s, c]]) - feet, axis=2)
            found |= np.all((r >= limits[:, 0] - slack) & (r <= limits[:, 1] + slack), axis=1)
        return found

    return (system, output, {leg: tuple(pair) for leg, pair in zip(legs, limits, strict=True)}), reached


def mapped(case: Any, reached: Any, random: Any) -> tuple[str, str]:
    """The verdict on a map, and what is wrong or unknown."""
    import sarrus as sr

    system, output, limits = case
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = sr.workspace(system, output, limits=limits, time_limit=LONGEST)
    if not found.success:
        return ("unknown", found.message) if caught else ("WRONG", "no warning")
    corners = np.concatenate([loop for part in found.components for loop in part.loops])
    low, high = corners.min(axis=0), corners.max(axis=0)
    x = random.uniform(low - 0.1 * (high - low), high + 0.1 * (high - low), (PLACES, 2))
    inside = found.contains(x)
    lost, false = x[reached(x, -1e-6) & ~inside], x[inside & ~reached(x, SLACK)]
    if len(lost) or len(false):
        return "WRONG", f"{len(lost)} places lost, {len(false)} out of reach, of {PLACES}"
    return "mapped", ""


class Hinges:
    """Three hinges in space: the first one's axis is z, the second's and third's are tilted."""

    def __init__(self, places: Any, axes: Any, tip: Any) -> None:
        self.places, self.axes, self.tip = places, axes, tip

    @classmethod
    def drawn(cls, random: Any) -> Hinges:
        """Every other one orthogonal."""
        d, r = random.uniform(0.2, 2.0, 3), random.uniform(0, 1, 1)
        if random.random() < 0.5:
            axes = np.array([(0, 0, 1), (0, 1, 0), (0, 0, 1)], dtype=float)
        else:
            axes = np.array([(0, 0, 1), (0, *_tilted(random)), (0, *_tilted(random))], dtype=float)
        places = np.array([(0, 0, 0), (d[0], 0, 0), (d[0] + d[1], r[0], 0)])
        return cls(places, axes, places[2] + (d[2], 0, 0))

    def area(self, z: float, heights: Any, radii: Any) -> float:
        """Of the section at a height: the union of the intervals of rho², over q3 and both solutions for q2."""
        middle, size, phase = heights
        cosine = (z - middle) / size
        can = abs(cosine) <= 1
        half = np.arccos(np.clip(cosine, -1, 1))
        rho2 = np.array([radii(phase + half), radii(phase - half)])
        places = np.flatnonzero(can)
        intervals = []
        for run in np.split(places, np.flatnonzero(np.diff(places) > 1) + 1) if len(places) else []:
            low, high = rho2[:, run].min(axis=1), rho2[:, run].max(axis=1)
            both = [(low.min(), high.max())] if len(run) < len(can) else list(zip(low, high, strict=True))
            intervals += both
        total, end = 0.0, -np.inf
        for a, b in sorted(intervals):
            total, end = total + max(0.0, b - max(a, end)), max(end, b)
        return float(np.pi * total)

    def volume(self, count: int = 600, steps: int = 8001) -> float:
        """By the substitution z = mid - half cos(theta)."""
        q3 = np.linspace(-np.pi, np.pi, steps)
        v = self.places[2] + _turned(self.tip - self.places[2], self.axes[2], q3) - self.places[1]
        n, first = self.axes[1], self.places[1]
        along = v @ n
        across, side = v - along[:, None] * n, np.cross(n, v)
        size, phase = np.hypot(across[:, 2], side[:, 2]), np.arctan2(side[:, 2], across[:, 2])
        middle = first[2] + along * n[2]

        def radii(q2: Any) -> Any:
            p = first + along[:, None] * n + np.cos(q2)[:, None] * across + np.sin(q2)[:, None] * side
            return p[:, 0] ** 2 + p[:, 1] ** 2

        low, high = float((middle - size).min()), float((middle + size).max())
        theta = (np.arange(count) + 0.5) / count * np.pi
        z = 0.5 * (low + high) - 0.5 * (high - low) * np.cos(theta)
        areas = np.array([self.area(one, (middle, size, phase), radii) for one in z])
        return float(areas @ np.sin(theta) * 0.5 * (high - low) * np.pi / count)


def _tilted(random: Any) -> tuple[float, float]:
    angle = random.uniform(0.3, np.pi / 2)
    return float(np.sin(angle)), float(np.cos(angle))


def _turned(v: Any, axis: Any, q: Any) -> Any:
    along = (v @ axis) * axis
    return along + np.cos(q)[:, None] * (v - along) + np.sin(q)[:, None] * np.cross(axis, v)


def volumes(random: Any, rtol: float = 1e-2, samples: int = 20) -> tuple[str, str]:
    """The verdict on a volume, and what is wrong or unknown."""
    from tests.workspace.mechanisms import spatial_arm

    import sarrus as sr

    hinges = Hinges.drawn(random)
    lists = [[tuple(one) for one in rows.tolist()] for rows in (hinges.places, hinges.axes)]
    system, output, _ = spatial_arm(*lists, tuple(hinges.tip.tolist()))
    exact, coarse = hinges.volume(), hinges.volume(300)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = sr.workspace_volume(system, output, rtol=rtol, samples=samples, time_limit=4 * LONGEST)
    if not found.success:
        return ("unknown", found.message) if caught else ("WRONG", "no warning")
    error = abs(found.volume - exact)
    told = f"{error / exact:.1e} with {found.volume_error / exact:.1e} stated, {len(found.slices)} slices"
    holds = error <= found.volume_error + 2 * abs(exact - coarse) or bool(caught)
    return ("mapped", told) if holds else ("WRONG", told)


def one(kind: str, seed: int) -> tuple[str, str]:
    random = np.random.default_rng([seed, len(kind)])
    if kind == "volumes":
        return volumes(random)
    case, reached = {"arms": arms, "five_bars": five_bars, "platforms": platforms}[kind](random)
    return mapped(case, reached, random)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    kinds = ["arms", "five_bars", "platforms", "volumes"]
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kinds", nargs="+", choices=kinds, default=kinds)
    chosen = parser.parse_args()
    end, counts, seed = time.monotonic() + chosen.seconds, Counter[str](), chosen.seed
    while time.monotonic() < end:
        for kind in chosen.kinds:
            began = time.monotonic()
            try:
                verdict, told = one(kind, seed)
            except Exception as trouble:  # of any kind: it is what is looked for
                verdict, told = "WRONG", f"{type(trouble).__name__}: {trouble}"
            counts[f"{kind}: {verdict}"] += 1
            if told:
                print(f"{kind} {seed}: {verdict}, {told} ({time.monotonic() - began:.0f} s)", flush=True)
        seed += 1
    for name, count in sorted(counts.items()):
        print(f"{name:<24} {count}")
    sys.exit(any("WRONG" in name for name in counts))


if __name__ == "__main__":
    main()
