"""Versions of all that numbers depend on, as saved runs and studies record them."""

import platform
from importlib.metadata import PackageNotFoundError, version


def versions() -> dict[str, str]:
    """Versions of Python, Sarrus and the packages that compute, by name."""
    return {
        "python": platform.python_version(),
        **{name: of(name) for name in ("sarrus", "numpy", "numba", "scipy")},
    }


def of(package: str) -> str:
    """Version of an installed package."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"
