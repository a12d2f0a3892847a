"""A model whose bodies hang in a tree, and what each branch's motions are: its joint space."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..geometry.motion import Motion, Twist, compose
from ..geometry.points import GROUND
from ..geometry.pose import GROUND_POSE, Pose
from ..model import Model
from ..quantity import Array


@dataclass(frozen=True, eq=False)
class Branch:
    """Connection of a body with its parent in the tree.

    Parameters
    ----------
    parent, body
        Names of the two bodies; the parent may be the ground.
    pose
        The body's frame in the parent's axes while nothing has moved.
    motions
        In their order from the parent; none if the body is fixed to the parent.
    """

    parent: str
    body: str
    pose: Pose
    motions: tuple[Motion, ...] = ()


@dataclass(frozen=True, eq=False, kw_only=True)
class TreeModel(Model):
    """A model with a tree of branches, each after the branch of its parent; further joints close loops."""

    branches: tuple[Branch, ...] = ()


class Step(NamedTuple):
    """A branch in a configuration: where its body is, and the twist of each of its freedoms."""

    branch: Branch
    pose: Pose
    twists: list[Twist]


def walk(branches: Sequence[Branch], values: Mapping[str, Array]) -> Iterator[Step]:
    """Yield every branch with its pose and twists, for the values of motions by name (zero if left out)."""
    poses = {GROUND: GROUND_POSE}
    for branch in branches:
        frame, twists = compose(poses[branch.parent], branch.pose), []
        for motion in branch.motions:
            given = values.get(motion.name, np.array(motion.zero))
            twists += motion.twists(frame, given)
            frame = motion.moved(frame, given)
        poses[branch.body] = frame
        yield Step(branch, frame, twists)
