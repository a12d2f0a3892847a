"""Tests of maps: nothing outside, rays end on known curves, the boundary is reached; what was missed is traced."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
from benchmarks.workspace_attack import five_bars

import sarrus as sr
from sarrus.analyses.workspace.analysis import checked_workspace

from .mechanisms import arm_2r, arm_3r, five_bar, platform_haug


@pytest.mark.one_in(4)
@pytest.mark.parametrize("case", [arm_3r, five_bar])
def test_maps_pass_their_tests(case: object) -> None:
    system, output, limits = case()
    found = sr.workspace(system, output, limits=limits, samples=400, rays=12)
    tests = found.verification
    assert tests is not None
    assert tests.success
    assert tests.samples == 400
    assert tests.rays > 5
    assert f"{tests.samples} random admissible positions are outside" in str(found)


def test_a_map_is_verified_by_a_finer_one() -> None:
    """That of two links is known: 2.4 m² of rings between angles. Without a curve, the areas differ."""
    system, output, limits = arm_2r()
    map_ = sr.WorkspaceMap(system, output, limits=limits).run()
    for found in (map_.result(), sr.workspace(system, output, limits=limits, samples=100, rays=4)):
        assert sr.verify(found).agree
    with pytest.raises(ValueError, match="a workspace has no responses"):
        sr.verify(found, "link_1.x")


def test_the_old_name_of_tests_is_deprecated() -> None:
    system, output, limits = arm_2r()
    found = sr.workspace(system, output, limits=limits, verify=False)
    with pytest.warns(DeprecationWarning, match=r"verify_workspace is deprecated. Use verify."):
        assert sr.verify_workspace(found, samples=100, rays=4).verification is not None


@pytest.mark.slow
def test_a_void_much_smaller_than_the_mechanism_passes_the_tests() -> None:
    """Crank and rod differ by 1.7e-3 m."""
    (system, output, _), _ = five_bars(np.random.default_rng([8, len("five_bars")]))
    found = sr.workspace(system, output, samples=100, rays=4)
    assert found.success, found.message


@pytest.mark.slow
def test_parts_that_were_missed_are_traced() -> None:
    """A map that was stopped after the first of four parts."""
    system, output, limits = platform_haug()
    map_ = sr.WorkspaceMap(system, output, limits=limits)
    while not map_.branches or map_.explorer.open:
        next(map_)
    first = map_.result()
    assert len(first.components) < 4
    map_.in_a_row = map_.repeats
    found = checked_workspace(first, samples=300, rays=10)
    assert len(found.components) == 4
    assert found.verification is not None
    assert found.verification.found_late > 10
    assert found.verification.success


def dropped(case: tuple, which: object) -> sr.Workspace:
    """A map that says it is complete, without the curves of which a test of their outputs says so."""
    system, output, limits = case
    map_ = sr.WorkspaceMap(system, output, limits=limits).run()
    lost = [branch for branch in map_.branches if which(np.array([point.u for point in branch.points]) * 1.0)]
    assert lost
    ends = {id(vertex) for branch in lost for vertex in (branch.start, branch.end)}
    map_.explorer.branches = [branch for branch in map_.branches if branch not in lost]
    map_.explorer.vertices = [vertex for vertex in map_.explorer.vertices if id(vertex) not in ends]
    return map_.result()


@pytest.mark.slow
def test_a_void_that_was_missed_is_traced() -> None:
    """Without the curves around one of the pivots it seems that everything there can be reached."""
    system, _, _ = case = five_bar()
    size = sr.WorkspaceMap(*case[:2]).problem.size
    first = dropped(case, lambda u: abs(np.hypot(u[:, 0] * size + 1, u[:, 1] * size) - 0.3).max() < 1e-6)
    assert first.success
    assert first.area == pytest.approx(11.788984798867766 + np.pi * 0.09, rel=1e-6)
    found = checked_workspace(first, samples=200, rays=40)
    assert found.verification is not None
    assert found.verification.found_late > 0
    assert found.verification.success
    assert found.area == pytest.approx(11.788984798867766, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("pool", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_tests_run_on_an_executor(pool: type) -> None:
    """Random positions and rays that lead to the parts of a map that was stopped; the same curves as without it."""
    found = []
    with pool(2) as executor:
        for how in (None, executor):
            system, output, limits = platform_haug()
            map_ = sr.WorkspaceMap(system, output, limits=limits)
            next(map_)
            map_.in_a_row = map_.repeats
            found.append(checked_workspace(map_.result(), samples=300, rays=30, executor=how))
    here, there = found
    assert here.verification is not None
    assert here.verification.found_late > 10
    assert (there.area, there.verification) == (here.area, here.verification)
    assert np.array_equal(there.curves[0].u, here.curves[0].u)


@pytest.mark.slow
def test_contains_agrees_with_distances() -> None:
    system, output, limits = five_bar()
    found = sr.workspace(system, output, limits=limits, verify=False)
    points = np.random.default_rng(0).uniform(-3, 3, size=(3000, 2))
    d1, d2 = (np.hypot(points[:, 0] - x, points[:, 1]) for x in (-1, 1))
    margin = np.min([2.7 - d1, 2.7 - d2, d1 - 0.3, d2 - 0.3], axis=0)
    clear = abs(margin) > 1e-3
    assert np.array_equal(found.contains(points)[clear], margin[clear] > 0)
