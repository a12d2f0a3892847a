"""Degrees of freedom, redundant equations by joint and direction, and what second order tells."""

import numpy as np
import pytest
from tests.analyses import linkages
from tests.analyses.linkages import X, Y, Z, chain
from tests.system.mechanisms import hmmwv, slider_crank

import sarrus as sr
from sarrus.analyses.redundancy.degrees_of_freedom import normalizations
from sarrus.linalg import rank

LINKAGES = {
    slider_crank: (1, 0, "regular"),
    hmmwv: (11, 0, "regular"),
    linkages.door: (1, 5, "redundant"),
    linkages.sarrus: (1, 1, "redundant"),
    linkages.bennett: (1, 3, "redundant"),
    linkages.bricard: (1, 1, "redundant"),
    linkages.parallelogram: (1, 3, "redundant"),
    linkages.slider_crank_in_line: (1, 3, "redundant"),
}


@pytest.mark.parametrize("make", LINKAGES, ids=lambda make: make.__name__)
def test_degrees_of_freedom(make: object) -> None:
    system = make()  # type: ignore[operator]
    found = sr.mobility(system)
    assert (found.degrees_of_freedom, found.redundant, found.kind) == LINKAGES[make]  # type: ignore[index]
    assert found.finite == found.degrees_of_freedom
    J = system.Phi_q(system.q0)
    assert np.allclose(J @ found.motions, 0, atol=1e-10)
    assert np.allclose(J.T @ found.null_vectors, 0, atol=1e-10)
    kept = np.linalg.svd(rank.unit_rows(J)[found.independent_rows].toarray(), compute_uv=False)
    assert len(kept) == found.rank
    assert kept[-1] > 0.2 * found.smallest
    assert set(np.flatnonzero(normalizations(system))) <= set(found.independent_rows)


def test_redundancies_in_words() -> None:
    told = str(sr.mobility(linkages.door()))
    assert told.splitlines() == [
        "door: 1 degree of freedom",
        "7 coordinates, 11 equations (Euler parameters' unit lengths included), 5 of them redundant",
        "hinge_2 repeats hinge_1: all that it restrains, displacement along x, y and z, rotation about x and y",
    ]
    told = str(sr.mobility(linkages.sarrus()))
    assert "b_3 repeats a_1, a_2, a_3, b_1 and b_2: rotation about z" in told
    told = str(sr.mobility(linkages.parallelogram()))
    assert (
        "hinge_4 repeats hinge_1, hinge_2 and hinge_3: displacement along z, rotation about x and y" in told
    )
    assert "all independent" in str(sr.mobility(slider_crank()))


def test_motions_cross_in_the_flat_parallelogram() -> None:
    found = sr.mobility(linkages.parallelogram(0.0))
    assert (found.degrees_of_freedom, found.redundant, found.kind) == (2, 4, "branching")
    assert found.finite is None
    assert "motions cross" in str(found)


def test_a_stretched_chain_is_shaky() -> None:
    """Two rods in one line between fixed hinges: free for an instant, and yet a stiff structure."""
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], dtype=float)
    found = sr.mobility(chain("stretched", points, np.tile(Z, (3, 1))))
    assert (found.degrees_of_freedom, found.kind, found.finite) == (1, "shaky", 0)
    assert "for an instant only" in str(found)


def test_two_equal_welds() -> None:
    box = sr.Body("box", mass=1.0, inertia=(1, 1, 1))
    welds = [sr.Fixed(name, sr.ground, box, point=(0, 0, 0)) for name in ("first", "second")]
    found = sr.mobility(sr.System(sr.Model("welded twice", bodies=[box], joints=welds)))
    assert (found.degrees_of_freedom, found.redundant) == (0, 6)
    assert "second repeats first: all that it restrains" in str(found)


def test_oblique_directions_are_told_by_components() -> None:
    axis = (X + Y) / np.sqrt(2)
    panel = sr.Body("panel", mass=1.0, inertia=(1, 1, 1))
    hinges = [linkages.hinge(f"hinge_{n}", sr.ground, panel, n * axis, axis) for n in (1, 2)]
    told = str(sr.mobility(linkages.system("oblique", [panel], hinges)))
    assert "rotation about z and (" in told


def test_inverse_iteration_agrees_with_singular_values(monkeypatch: pytest.MonkeyPatch) -> None:
    system = linkages.parallelogram()
    J = system.Phi_q(system.q0)
    dense = rank.rank_of(J)
    monkeypatch.setattr(rank, "DENSE_UP_TO", 5)
    sparse = rank.rank_of(J)
    assert sparse.rank == dense.rank
    assert np.allclose(sparse.null @ sparse.null.T, dense.null @ dense.null.T, atol=1e-8)


def test_a_model_that_cannot_be_assembled_has_no_mobility() -> None:
    with pytest.raises(ValueError, match="could not be assembled"):
        sr.mobility(linkages.contradictory_door())
