"""``sarrus modes MODEL``: vibration modes about the equilibrium in which a mechanism comes to rest."""

from __future__ import annotations

import argparse
import sys


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, which equilibrium is wanted, and what to write."""
    parser.add_argument("model", help="a .yaml or .json model file")
    parser.add_argument("--time", type=float, default=0.0, help="time at which drivers are held [s] (0)")
    parser.add_argument("--nearest", action="store_true", help="the nearest equilibrium, be it stable or not")
    parser.add_argument("--figure", help="file for the eigenvalues in the complex plane, .png or .svg")


def run(chosen: argparse.Namespace) -> int:
    """Find the equilibrium and print the modes; 1 if there is none."""
    from ..analyses import equilibrium, modes
    from ..model import load
    from ..system import System

    system = System(load(chosen.model))
    rest = equilibrium(system, t=chosen.time, stable=not chosen.nearest)
    print(rest.message)
    if not rest.success:
        return 1
    found = modes(system, rest.q, t=chosen.time)
    print(found)
    if chosen.figure:
        found.plot().figure.savefig(chosen.figure, dpi=150)
        print(f"wrote {chosen.figure}", file=sys.stderr)
    return 0 if found.success else 1
