"""Small analyses use one thread of linear algebra, and leave the setting as they found it."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest
import scipy.linalg  # noqa: F401  its library must be loaded before threads are counted
from tests.analyses.driven import turned
from tests.system.mechanisms import slider_crank
from threadpoolctl import ThreadpoolController

import sarrus as sr
from sarrus.linalg.threads import _libraries, one_thread_if_small


def threads() -> set[int]:
    return {one["num_threads"] for one in ThreadpoolController().select(user_api="blas").info()}


@pytest.fixture(autouse=True)
def two_threads() -> Iterator[None]:
    _libraries.cache_clear()  # a test before may have loaded another one
    with ThreadpoolController().limit(limits=2, user_api="blas"):
        if threads() != {2}:
            pytest.skip("this library of linear algebra has no threads")
        yield


def test_an_analysis_of_a_small_system_has_one_thread() -> None:
    seen: list[set[int]] = []
    sr.kinematics(turned(1.0, 0.0), [0.0, 0.1, 0.2], progress=lambda t: seen.append(threads()))
    sr.simulate(slider_crank(), until=0.01, progress=lambda t: seen.append(threads()))
    assert len(seen) >= 2
    assert all(one == {1} for one in seen)
    assert threads() == {2}


def test_the_setting_comes_back_after_errors_and_from_analyses_side_by_side() -> None:
    with pytest.raises(ValueError, match="rising"):
        sr.kinematics(turned(1.0, 0.0), [1.0, 0.0])
    assert threads() == {2}

    def run(n: int) -> bool:
        return sr.simulate(slider_crank(), until=0.01 * (1 + n % 3)).success

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(run, range(12)))
    assert threads() == {2}


def test_large_systems_keep_their_threads() -> None:
    class Large:
        nq = 10_000

    seen = one_thread_if_small(lambda system: threads())(Large())
    assert seen == {2}
