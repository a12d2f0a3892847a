"""`mobility` of couplings that repeat each other everywhere: gears given twice, in rings, differentials."""

import numpy as np
import pytest
from tests.verdicts.random_mechanisms import unit

import sarrus as sr

X, Y = (1, 0, 0), (0, 1, 0)


def train(
    seed: int, ratios: list[float], gears: list[tuple[int, int]], length: float, mass: float
) -> sr.System:
    """Wheels on parallel shafts; their angles go as their ratios, so that any gears between them agree."""
    random = np.random.default_rng(seed)
    axis, bodies, joints = unit(random), [], []
    for n in range(len(ratios)):
        at = tuple(length * random.normal(size=3))
        bodies.append(sr.Body(f"w{n}", mass=mass, inertia=(mass * length**2,) * 3, position=at))
        joints.append(sr.Revolute(f"s{n}", sr.ground, bodies[-1], point=at, axis=tuple(axis)))
    couplings = [
        sr.Gear(f"g{k}", f"s{i}", f"s{j}", ratio=ratios[j] / ratios[i]) for k, (i, j) in enumerate(gears)
    ]
    return sr.System(sr.Model("train", bodies, joints + couplings))


@pytest.mark.one_in(8)
@pytest.mark.parametrize("block", range(8))
def test_gears(block: int) -> None:
    """As many degrees of freedom as there are parts of the graph of gears, before and after some motion."""
    for seed in range(8 * block, 8 * block + 8):
        random = np.random.default_rng(seed)
        count = int(random.integers(2, 6))
        ratios = (random.choice([-1, 1], size=count) * random.uniform(0.3, 3, size=count)).tolist()
        gears = [
            tuple(random.choice(count, size=2, replace=False).tolist()) for _ in range(random.integers(1, 9))
        ]
        parts = np.arange(count)
        for i, j in gears:
            parts[parts == parts[i]] = parts[j]
        freedom = len(set(parts.tolist()))
        repeated = len(gears) - (count - freedom)
        for length, mass in ((1.0, 1.0), (1e-6, 1e-9), (1e4, 1e6)):
            system = train(seed, ratios, gears, length, mass)
            motions = sr.mobility(system).motions
            v = motions @ random.normal(size=motions.shape[1])
            run = sr.simulate(system, sr.assemble(system, v=v), until=0.3, t_eval=[0.0, 0.3])
            for q in run.q:
                found = sr.mobility(system, q)
                told = (seed, length, str(found))
                assert (found.degrees_of_freedom, found.finite, found.redundant) == (
                    freedom,
                    freedom,
                    repeated,
                ), told
                assert found.kind == ("redundant" if repeated else "regular"), told
            assert {text.split(":")[1][:24] for text in run.warnings} == (
                {" its radius of gyration "} if length == 1e4 else set()
            )


@pytest.mark.slow
@pytest.mark.parametrize("planets", [1, 2, 3])
@pytest.mark.parametrize(("length", "mass"), [(1.0, 1.0), (1e-6, 1e-9), (1e4, 1e6)])
def test_a_bevel_differential(planets: int, length: float, mass: float) -> None:
    """A carrier turns and the side gears turn against each other: two degrees of freedom, whatever is repeated."""

    def wheel(name: str, *at: float) -> sr.Body:
        position = tuple(length * np.array(at))
        return sr.Body(name, mass=mass, inertia=(mass * length**2,) * 3, position=position)

    carrier, sides = wheel("carrier", 0, 0, 0), (wheel("side1", 0.5, 0, 0), wheel("side2", -0.5, 0, 0))
    joints = [sr.Revolute("c", sr.ground, carrier, point=(0, 0, 0), axis=X)]
    for n, side in enumerate(sides):
        joints.append(sr.Revolute(f"a{n}", carrier, side, point=tuple(side.position), axis=X))
    pins, gears = [], []
    for k in range(planets):
        a = 2 * np.pi * k / planets
        pins.append(wheel(f"planet{k}", 0, 0.5 * np.cos(a), 0.5 * np.sin(a)))
        axis = (0, np.cos(a), np.sin(a))
        joints.append(sr.Revolute(f"p{k}", carrier, pins[-1], point=tuple(pins[-1].position), axis=axis))
        gears += [sr.Gear(f"m{n}{k}", f"a{n}", f"p{k}", ratio=1.5 * (1 - 2 * n)) for n in (0, 1)]
    system = sr.System(sr.Model("differential", [carrier, *sides, *pins], joints + gears))
    motions = sr.mobility(system).motions
    start = sr.assemble(system, v=motions @ np.array([1.0, -0.6]))
    run = sr.simulate(system, start, until=1.0, t_eval=[0.0, 0.5, 1.0])
    for q in run.q:
        found = sr.mobility(system, q)
        assert (found.degrees_of_freedom, found.finite) == (2, 2), str(found)
        assert found.kind == ("redundant" if planets > 1 else "regular")
    assert all(
        length > 1e3 and text.endswith(("lengths are in m.", "inertia is in kg m².")) for text in run.warnings
    ), run.warnings
