"""``sarrus statics MODEL``: where a mechanism comes to rest, and what its joints bear there."""

from __future__ import annotations

import argparse


def arguments(parser: argparse.ArgumentParser) -> None:
    """The model file, and which equilibrium is wanted."""
    parser.add_argument("model", help="a .yaml or .json model file")
    parser.add_argument("--time", type=float, default=0.0, help="time at which drivers are held [s] (0)")
    parser.add_argument("--nearest", action="store_true", help="the nearest equilibrium, be it stable or not")


def run(chosen: argparse.Namespace) -> int:
    """Print the equilibrium, its poses and reactions; 1 if there is none."""
    import numpy as np

    from ..analyses import equilibrium
    from ..model import load
    from ..system import System

    system = System(load(chosen.model))
    found = equilibrium(system, t=chosen.time, stable=not chosen.nearest)
    print(found.message)
    for body in system.bodies:
        x, y, z = found.q[system.coordinates_of(body)][:3]
        print(f"  {body:<24} x = {x:+.9f}  y = {y:+.9f}  z = {z:+.9f} m")
    for joint in system.rows if found.success else ():
        action = system.reaction(joint, found.q, found.lam, chosen.time)
        force, torque = np.linalg.norm(action.force), np.linalg.norm(action.torque)
        print(f"  {joint:<24} force {force:.6g} N, torque {torque:.6g} N m")
    return 0 if found.success else 1
