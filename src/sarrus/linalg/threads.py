"""One thread of linear algebra for small systems: starting others takes longer than all that they could do."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import cache, wraps
from threading import Lock
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

SMALL = 500  # coordinates: below it the dense factorizations of an analysis gain nothing by threads


def one_thread_if_small(analysis: Callable[P, R]) -> Callable[P, R]:
    """Decorate an analysis, whose first argument is a system or knows one."""

    @wraps(analysis)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        first = args[0] if args else next(iter(kwargs.values()), None)
        system = first if hasattr(first, "nq") else getattr(first, "system", None)
        with one_thread.held() if getattr(system, "nq", SMALL) < SMALL else nullcontext():
            return analysis(*args, **kwargs)

    return limited


class _Limit:
    """Threads are a setting of the whole process: the first analysis to begin sets it, the last to end restores it."""

    def __init__(self) -> None:
        self._lock, self._count = Lock(), 0
        self._limiter: Any = None

    @contextmanager
    def held(self) -> Iterator[None]:
        with self._lock:
            if self._count == 0:
                self._limiter = _libraries().limit(limits=1, user_api="blas")
            self._count += 1
        try:
            yield
        finally:
            with self._lock:
                self._count -= 1
                if self._count == 0 and self._limiter:
                    self._limiter.restore_original_limits()


one_thread = _Limit()


@cache
def _libraries() -> Any:
    """The libraries of linear algebra: SciPy's is loaded with its module."""
    import scipy.linalg  # noqa: F401
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
