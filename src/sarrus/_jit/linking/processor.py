"""Levels of processors, and the processor that kernels are compiled for.

A level is a set of features that many processors have in common. Kernels of a wheel are compiled for a level; kernels
that are compiled on the user's machine are compiled for its own processor, or for the one that Numba's settings
``NUMBA_CPU_NAME`` and ``NUMBA_CPU_FEATURES`` name.
"""

from __future__ import annotations

import os
from typing import Any, NamedTuple

import llvmlite.binding as llvm
from numba.core import config as numba_config

CONFIG: Any = numba_config
LANES = "SARRUS_LANES"  # with which the layout of other processors is tested
V3 = (
    *("avx", "avx2", "bmi", "bmi2", "cx16", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sahf"),
    *("sse3", "sse4.1", "sse4.2", "ssse3", "xsave"),
)
V4 = (*V3, "avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl")


class Level(NamedTuple):
    """Processors for which kernels are compiled together.

    Attributes
    ----------
    name : also LLVM's name of a processor that has these features and no others
    triple : how the names of its machines begin
    needs : features
    lanes : numbers in a SIMD register of kernels in lanes
    """

    name: str
    triple: str
    needs: tuple[str, ...]
    lanes: int


LEVELS = (  # best first
    Level("x86-64-v4", "x86_64", V4, 8),
    Level("x86-64-v3", "x86_64", V3, 4),
    Level("apple-m1", "arm64-apple", (), 4),
    Level("generic", "aarch64", (), 4),
)


def triple() -> str:
    """Architecture, vendor and system, as LLVM names them."""
    return str(llvm.get_process_triple())


def levels() -> list[Level]:
    """The levels that this processor has, best first."""
    found = llvm.get_host_cpu_features()
    return [
        level
        for level in LEVELS
        if triple().startswith(level.triple) and all(found.get(x) for x in level.needs)
    ]


def target() -> tuple[str, str]:
    """Name and features of the processor that Numba compiles for."""
    name, features = CONFIG.CPU_NAME, CONFIG.CPU_FEATURES
    return (
        llvm.get_host_cpu_name() if name is None else name,
        llvm.get_host_cpu_features().flatten() if features is None else features,
    )


def lanes_of_target() -> int:
    """How many lanes kernels have that are compiled here: ``SARRUS_LANES``, or 8 with AVX-512, or 4."""
    if chosen := os.environ.get(LANES):
        return int(chosen)
    name, features = target()
    known = {level.name: level.lanes for level in LEVELS}
    return 8 if "+avx512f" in features.split(",") else known.get(name, 4)
