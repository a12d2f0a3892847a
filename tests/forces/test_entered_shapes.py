"""Warnings of runs in which an end or the side of a segment enters the shape that it wraps."""

import warnings
from typing import Any

import numpy as np
import pytest

import sarrus as sr


def falling(**wrap: Any) -> tuple[sr.Body, sr.Wrap]:
    """A weight that falls from z = 0 by 0.45 m within 0.3 s, through a shape 0.2 m below it."""
    weight = sr.Body("weight", 1.0, (0.1, 0.1, 0.1))
    return weight, sr.Wrap(sr.ground.point(0, 0, -0.2), 0.1, **wrap)


def run_of(weight: sr.Body, tendon: sr.Tendon | sr.Muscle) -> sr.Trajectory:
    guide = sr.Translational("guide", sr.ground, weight, point=(0, 0, 0), axis=(0, 0, 1))
    model = sr.Model("fall", [weight], [guide], [tendon], gravity=(0, 0, -10))
    return sr.simulate(sr.System(model), until=0.3, t_eval=np.linspace(0, 0.3, 31))


WRAPS: dict[str, Any] = {
    "sphere": {},
    "cylinder": {"axis": (0, 1, 0)},
    "cylinder with a side": {"axis": (0, 1, 0), "side": (0.5, 0, -0.2)},
}


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", WRAPS)
def test_an_end_that_enters_the_shape(name: str) -> None:
    """By t = √(2·0.1/10) = 0.1414 s, that is before the output at 0.15 s."""
    weight, wheel = falling(**WRAPS[name])
    points = [sr.ground.point(0.3, 0, 0.5), weight.point(0, 0, 0), sr.ground.point(0.3, 0, -0.6)]
    rope = sr.Tendon("rope", points, around=[None, wheel], value=0.0)
    with pytest.warns(sr.SarrusWarning) as seen:
        run = run_of(weight, rope)
    shape = "cylinder" if "axis" in WRAPS[name] else "sphere"
    expected = f"rope: its end on weight enters the {shape} on ground, which it wraps, before t = 0.15 s"
    assert [str(one.message).partition(", where")[0] for one in seen] == [expected]
    assert run.warnings == (str(seen[0].message),)


def test_a_side_that_leaves_the_shape() -> None:
    """It starts in the centre, 0.1 m from the surface, with a muscle in place of a tendon."""
    weight = sr.Body("weight", 1.0, (0.1, 0.1, 0.1))
    wheel = sr.Wrap(sr.ground.point(0, 0, 0), 0.1, side=weight.point(0, 0, 0))
    ends = [sr.ground.point(-0.5, 0, 0.3), sr.ground.point(0.5, 0, 0.3)]
    muscle = sr.Muscle("muscle", ends, around=[wheel], activation=0.5, peak_force=1.0, optimal_length=1.0)
    with pytest.warns(
        sr.SarrusWarning, match="muscle: its side on weight leaves the sphere on ground"
    ) as seen:
        run_of(weight, muscle)
    assert "before t = 0.15 s, where its length may jump. Move" in str(seen[0].message)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", ["through", "beside", "along"])
def test_no_warning(name: str) -> None:
    """Through a ring an end may enter, and a cylinder has no ends; other segments stay outside."""
    weight, wheel = falling(**({"side": (0, 0, -0.2)} if name == "through" else {"axis": (0, 0, 1)}))
    end = weight.point(0.15 if name == "beside" else 0.05 * (name == "along"), 0, 0)
    rope = sr.Tendon("rope", [end, sr.ground.point(0.3, 0, -0.6)], around=[wheel], value=0.0)
    assert run_of(weight, rope).warnings == ()


@pytest.mark.parametrize(("push", "jumps"), [(-0.5, True), (0.5, False)])
def test_a_length_that_jumps(push: float, jumps: bool) -> None:
    """The end passes behind a drum with a side, as seen from the other end: the way around changes there."""
    weight = sr.Body("weight", 2.0, (1, 1, 1), position=(0.1, 0, 0.7), velocity=(push, 0, 0))
    drum = sr.Wrap(sr.ground.point(0, 0, 2), 0.3, axis=(0, 1, 0), side=(0, 0, 3))
    rope = sr.Tendon("rope", [sr.ground.point(-1, 0, 1), weight.point(0, 0, 0)], around=[drum], value=0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", sr.SarrusWarning)
        run = sr.simulate(sr.System(sr.Model("drum", [weight], [], [rope])), until=2.0)
    assert abs(np.diff(run["rope.length"])).max() > 1 or not jumps
    found = [one for one in run.warnings if one.startswith("rope: its length jumps by")]
    assert len(found) == len(run.warnings) == jumps
