"""Results that are a tuple, a list or an array carry warnings, too; kernels that are not compiled are not announced."""

import pickle
from typing import Any

import numpy as np
import pytest

import sarrus as sr
from sarrus.model.announcement import announce, reports_warnings
from sarrus.results import Product, ResultList, Singularities


@pytest.mark.parametrize(
    "found",
    [Singularities(()), ResultList([1, 2]), Product.of(np.array([1.0, 2.0]))],
    ids=lambda x: type(x).__name__,
)
def test_such_a_result_keeps_the_warnings_of_its_analysis(found: Any) -> None:
    @reports_warnings
    def analysis() -> Any:
        announce(["m: something is odd."])
        return found

    with pytest.warns(sr.SarrusWarning, match="something is odd"):
        result = analysis()
    assert result.warnings == ("m: something is odd.",)
    assert found.warnings == ()
    assert list(result) == list(found)
    assert len(pickle.loads(pickle.dumps(result))) == len(found)
    assert isinstance(result, tuple | list | np.ndarray)


def test_arithmetic_with_such_an_array_is_plain() -> None:
    found = Product.of(np.array([1.0, 2.0]))
    assert type(2 * found) is np.ndarray
    assert float(found @ found) == 5.0
    assert np.array_equal(found, [1.0, 2.0])
