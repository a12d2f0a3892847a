"""Outputs: what a name such as "slider.x", "pin.force.z", "spring.tension" or "energy.total" is along a motion.

Every analysis, study, plot, table and the shell take their names from here. Formulas of mechanics are in the elements;
what is made of outputs, such as responses and events, is in the analyses.
"""

from . import bodies, elements, joints, totals  # each registers its outputs
from .output import Level, Output, UnknownOutput, find_output, outputs_of, provides
from .outputs import Outputs

__all__ = [
    "Level",
    "Output",
    "Outputs",
    "UnknownOutput",
    "bodies",
    "elements",
    "find_output",
    "joints",
    "outputs_of",
    "provides",
    "totals",
]
