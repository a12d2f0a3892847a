"""A sample of the mutation run (`python -m tests.mutation.run` does all)."""

import random
from functools import cache

import pytest
from tests.mutation.mutants import CHECKS, Mutant, applied, killer, modules, mutants

pytestmark = pytest.mark.slow

SAMPLE = 25


@cache
def sample() -> list[Mutant]:
    """The same mutants every time, of all modules, as long as the formulas stay."""
    chooser = random.Random(7)
    every = [mutant for module in modules() for mutant in mutants(module)]
    return chooser.sample(every, SAMPLE)


@pytest.mark.parametrize(
    "check", CHECKS, ids=lambda c: f"{c.kind.__name__ if c.kind else 'functions'}-{c.name}"
)
def test_right_formulas_pass(check):
    """Otherwise every mutant would seem to be caught."""
    check.run()


def test_each_mutant_of_the_sample_is_caught():
    survivors = [str(mutant) for mutant in sample() if killer(mutant) is None]
    assert not survivors


def test_a_mutant_is_taken_back():
    mutant = sample()[0]
    with applied(mutant):
        pass
    for check in CHECKS:
        check.run()


def test_every_module_with_formulas_has_mutants():
    assert all(any(mutants(module)) for module in modules())
