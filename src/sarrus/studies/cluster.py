"""A Dask cluster as an executor."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from ..model import SarrusError

WAIT = 30.0  # s for the scheduler to answer, and for the first worker


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """The executor of the cluster whose scheduler is at an address, ``tcp://10.0.0.7:8786``.

    The workers need the same version of Sarrus.

    Raises
    ------
    SarrusError
        If Dask is not installed, or nobody answers there.
    """
    try:
        from distributed import Client
    except ImportError:
        raise SarrusError("a Dask cluster needs Dask; install it with: pip install 'sarrus[dask]'") from None
    try:
        client: Any = Client(address, timeout=WAIT, set_as_default=False)
    except (OSError, ValueError) as wrong:
        message = f"no Dask scheduler answers at {address} ({type(wrong).__name__})"
        raise SarrusError(f"{message}; start one with: dask scheduler") from None
    with client:
        _wait_for_workers(client, address)
        yield client.get_executor(pure=False)


def _wait_for_workers(client: Any, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=WAIT)
    except TimeoutError:
        message = f"the Dask scheduler at {address} has no worker"
        raise SarrusError(f"{message}; start some with: dask worker {address}") from None
