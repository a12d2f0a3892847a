"""The paper's experiments: differences fall with the perturbation down to round-off; exact beats differenced by far."""

import pytest
from tests.system.mechanisms import slider_crank

from sarrus.analyses.paper import STEPS, experiment

QUADRATIC = 1e-9  # at the best step, round-off


@pytest.fixture(scope="module")
def found() -> object:
    return experiment(slider_crank())


def test_forward_differences_fall_with_the_step(found: object) -> None:
    for name, errors in found.differences["forward"].items():  # type: ignore[attr-defined]
        if errors[0] < 1e-10:
            continue  # linear in what is varied: no error but round-off
        for step in range(1, 5):
            assert errors[step] == pytest.approx(0.1 * errors[step - 1], rel=0.3), (name, STEPS[step])


def test_the_best_central_difference_agrees(found: object) -> None:
    for name, errors in found.differences["central"].items():  # type: ignore[attr-defined]
        assert min(errors) < QUADRATIC, name


def test_exact_is_faster(found: object) -> None:
    for name, times in found.times.items():  # type: ignore[attr-defined]
        assert times.speedup > 4, name


def test_json(found: object) -> None:
    plain = found.as_json()  # type: ignore[attr-defined]
    assert set(plain) >= {"counts", "differences", "speedup"}
    assert set(plain["speedup"]) == {"kinematic", "force", "inertia"}
    assert plain["counts"]["coordinates"] == 21
