"""Which cases a study runs, and what a parameter may be."""

import numpy as np
import pytest

from sarrus.model import SarrusError
from sarrus.studies import Distribution, Grid, LatinHypercube, Listed, MonteCarlo, Range, Sobol, Values
from sarrus.studies.parameters import parameter_of
from sarrus.studies.samples import sample_of

NORMAL = Distribution("norm", {"loc": 10.0, "scale": 2.0})


def test_grid_is_every_combination() -> None:
    found = Grid().cases({"a": Values((1.0, 2.0)), "b": Range(0, 1, 3)})
    assert found.tolist() == [[1, 0], [1, 0.5], [1, 1], [2, 0], [2, 0.5], [2, 1]]


def test_logarithmic_range() -> None:
    assert Range(1, 100, 3, log=True).grid() == pytest.approx([1, 10, 100], rel=1e-14)


def test_latin_hypercube_has_one_case_in_every_part() -> None:
    u = LatinHypercube(50, seed=3).points(2)
    for column in u.T:
        assert sorted((column * 50).astype(int)) == list(range(50))


def test_sobol_integrates_better_than_chance() -> None:
    wanted = 1 / 9
    errors = [
        abs(np.prod(way(1024, 5).points(2) ** 2, axis=1).mean() - wanted) for way in (Sobol, MonteCarlo)
    ]
    assert errors[0] < 0.05 * errors[1]


@pytest.mark.parametrize("way", [LatinHypercube, Sobol, MonteCarlo])
def test_a_seed_gives_the_same_cases(way: type) -> None:
    parameters = {"a": NORMAL, "b": Range(0, 1)}
    cases = [way(32, seed).cases(parameters) for seed in (1, 1, 2)]
    assert np.array_equal(cases[0], cases[1])
    assert not np.array_equal(cases[0], cases[2])


def test_distribution_has_its_moments() -> None:
    x = Sobol(2048, 0).cases({"a": NORMAL})[:, 0]
    assert (x.mean(), x.std()) == (pytest.approx(10, rel=1e-3), pytest.approx(2, rel=1e-2))


def test_listed_values_are_equally_probable() -> None:
    x = Sobol(64, 0).cases({"a": Values((1.0, 2.0, 5.0, 7.0))})[:, 0]
    assert [int(np.sum(x == value)) for value in (1, 2, 5, 7)] == [16, 16, 16, 16]


def test_what_a_file_may_say() -> None:
    assert parameter_of({"from": "5 mm", "to": 0.02, "count": 4}) == Range(0.005, 0.02, 4)
    assert parameter_of({"distribution": "norm", "loc": "1 kN/m", "scale": 2}) == Distribution(
        "norm", {"loc": 1000.0, "scale": 2.0}
    )
    assert parameter_of([1, "2 cm"]) == Values((1.0, 0.02))
    assert sample_of({"type": "sobol", "count": 8, "seed": 3}) == Sobol(8, 3)
    assert sample_of(None) == Grid()
    assert sample_of({"type": "listed", "rows": [[1, 2]]}) == Listed(((1.0, 2.0),))


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"from": 2, "to": 1}, "a range must rise"),
        ({"from": 2}, "Give from and to"),
        ({"from": -1, "to": 1, "log": True}, "must be positive"),
        ({"from": 1, "to": 2, "count": 1}, "two values at least"),
        ({"distribution": "normal"}, "there is no distribution 'normal'. Did you mean"),
        ({"distribution": "norm", "lok": 1}, "lok"),
        ({"distribution": "norm", "scale": -1}, "has no values"),
        ({"distribution": "norm", "loc": 1, "scale": 1e308}, "some that are not finite"),
        ([], "one at least"),
        ("5 florins", "florins"),
        (True, "a number is expected"),
    ],
)
def test_wrong_parameters(given: object, told: str) -> None:
    with pytest.raises(SarrusError, match=told):
        parameter_of(given)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"type": "sobel", "count": 8}, "there is no sample 'sobel'. Did you mean"),
        ({"type": "sobol", "count": 100}, "Take 128"),
        ({"type": "sobol"}, "needs a count"),
        ({"type": "grid", "count": 3}, "has no key 'count'"),
        ({"type": "monte_carlo", "count": 0}, "at least 1"),
        ({"type": "monte_carlo", "count": 2, "seed": -1}, "at least 0"),
        (3, "is a mapping with a type"),
    ],
)
def test_wrong_samples(given: object, told: str) -> None:
    with pytest.raises(SarrusError, match=told):
        sample_of(given)
