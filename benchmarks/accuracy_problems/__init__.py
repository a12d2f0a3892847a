"""Mechanisms whose motion is known: in closed form, from the literature, or from equations written by hand and SciPy.

One file for each kind of mechanism. `problem` says what a problem is; none of the others contains an algorithm.
"""

from .contacts import CONTACTS
from .driven import DRIVEN
from .examples import EXAMPLES
from .loads import LOADS
from .oscillators import OSCILLATORS
from .pendulums import PENDULUMS
from .problem import Known, Problem
from .rotations import ROTATIONS

PROBLEMS: tuple[Problem, ...] = (
    *OSCILLATORS,
    *LOADS,
    *PENDULUMS,
    *ROTATIONS,
    *DRIVEN,
    *CONTACTS,
    *EXAMPLES,
)
__all__ = ["PROBLEMS", "Known", "Problem"]
