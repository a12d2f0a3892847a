"""Maps that end early: time limits, interruptions, critical values; none of them tells a number as if it held."""

from collections.abc import Callable

import numpy as np
import pytest
from tests.patience import within, within_by_the_clock

import sarrus as sr
from sarrus import activity
from sarrus.analyses.workspace.problem.watch import SLICES, STARTS, expected, reached, watched
from sarrus.analyses.workspace.regions.crossing import crossing
from sarrus.analyses.workspace.regions.mapping import WorkspaceMap

from .mechanisms import arm_2r, arm_3r, five_bar, orthogonal_arm


def interrupt_at(least: float) -> Callable[[float], None]:
    """A progress function that is interrupted as if by Ctrl-C."""

    def progress(reached: float) -> None:
        if reached >= least:
            raise KeyboardInterrupt

    return progress


def test_a_map_ends_at_its_time_limit_and_goes_on() -> None:
    system, output, limits = arm_3r()
    with within_by_the_clock(30), pytest.warns(sr.SarrusWarning, match="the time limit of 0.05 s has passed"):
        found = sr.workspace(system, output, limits=limits, time_limit=0.05)
    assert (found.status, found.success) == ("time limit", False)
    assert np.isnan([found.area, found.perimeter, found.area_error]).all()
    assert "can reach is not known" in str(found)
    with pytest.warns(sr.SarrusWarning, match="places may be classified wrongly"):
        found.contains([1.0, 1.0])
    with pytest.raises(sr.SarrusError, match="no derivatives"):
        sr.area_gradient(found, ["q2.point.x"])
    whole = found.map.tried().result()
    assert whole.success
    assert whole.area == pytest.approx(31.497510350119, rel=1e-6)


def test_an_interrupted_map_goes_on_where_it_was() -> None:
    """The curve that was being followed is followed again."""
    system, output, limits = arm_2r()
    with pytest.warns(sr.SarrusWarning, match="stopped by the user"):
        found = sr.workspace(system, output, limits=limits, progress=interrupt_at(20))
    assert found.status == "stopped"
    assert len(found.map.branches) >= 1
    with pytest.raises(sr.SarrusError, match="nothing can be reached, so there is no field"):
        sr.workspace_field(found)  # no curve is closed
    whole = found.map.run().result()
    assert whole.success
    assert whole.area == pytest.approx(3.970981336311, rel=1e-6)


def test_progress_counts() -> None:
    seen: list[float] = []
    system, output, limits = arm_2r()
    assert sr.workspace(system, output, limits=limits, samples=50, rays=4, progress=seen.append).success
    assert seen == sorted(seen)
    assert seen[-1] > 50


def test_slices_that_are_known_to_be_needed_give_a_remaining_time(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = list[activity.Line]()
    monkeypatch.setattr(activity, "_wanted", lambda: True)
    monkeypatch.setattr(activity, "_watch", lambda line, over: lines.append(line))
    with watched(None, done="made", unit=SLICES):
        reached(34, SLICES)
        assert lines[0](17.0) == "made 34 slices, 17 s"
        expected(68, SLICES)
        expected(5, STARTS)  # of the range of heights, before
        assert lines[0](17.0).endswith(" made 34 of 68 slices, 17 s to go")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("how", "message"),
    [({"time_limit": 0.01}, "time limit"), ({"progress": interrupt_at(1)}, "stopped by the user")],
    ids=["time limit", "Ctrl-C"],
)
def test_the_other_analyses_end_early(how: dict[str, object], message: str) -> None:
    system, output, limits = five_bar()
    whole = sr.workspace(system, output, limits=limits, verify=False)
    arm, tip = orthogonal_arm()
    analyses = {
        "range": lambda: sr.workspace_range(arm, tip["z"], **how),
        "volume": lambda: sr.workspace_volume(arm, tip["x", "y", "z"], samples=5, **how),
        "field": lambda: sr.workspace_field(whole, ("a1", "a2"), cells=12, **how),
        "singularities": lambda: sr.input_singularities(system, output, ("a1", "a2"), **how),
    }
    for name, analysis in analyses.items():
        with pytest.warns(sr.SarrusWarning, match=message):
            found = analysis()
        assert not found.success, name
        assert found.status in ("time limit", "stopped"), name
        assert found.warnings, name
    with pytest.raises(sr.StrictError, match=message), sr.strict():
        sr.workspace_range(arm, tip["z"], **how)


@pytest.mark.slow
def test_a_section_at_a_critical_height_is_told_at_once() -> None:
    """At z = 0.5 the singular curve crosses itself all around the first axis: curves never ended."""
    system, tip = orthogonal_arm()
    critical = "link_3.*z = 0.5 is a critical value. Fix it beside"
    with within(20), pytest.warns(sr.SarrusWarning, match=critical):
        found = sr.workspace(system, tip["x", "y"], fixed={tip["z"][0]: 0.5}, time_limit=100.0)
    assert not found.success
    assert np.isnan(found.area)
    beside = sr.workspace(system, tip["x", "y"], fixed={tip["z"][0]: 0.50005}, verify=False)
    assert beside.success


def test_curves_that_contradict_each_other_make_no_area() -> None:
    """One barrier turned round tells that the outside can be reached."""
    system, output, limits = arm_2r()
    map_ = WorkspaceMap(system, output, limits=limits).run()
    wrong = map_.branches[0]
    turned = crossing(wrong)
    map_._crossed, map_._region = [(wrong, turned._replace(side=-turned.side))], None
    found = map_.result()
    assert found.status == "incomplete"
    assert "inconsistent" in found.message
    assert np.isnan(found.area)
    assert all(np.isnan(part.area) for part in found.components)
