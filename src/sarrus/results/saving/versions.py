"""Versions of all that numbers depend on, as saved runs and studies record them."""

import platform
from importlib.metadata import PackageNotFoundError, version

from ... import __version__


def versions() -> dict[str, str]:
    """Versions of Python, Sarrus and the packages that compute, by name."""
    return {
        "python": platform.python_version(),
        "sarrus": __version__,  # of the code that runs; an editable installation may be of an earlier one
        **{name: of(name) for name in ("numpy", "numba", "scipy")},
    }


def of(package: str) -> str:
    """Version of an installed package."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"
