"""Outputs along a motion by name, such as "slider.x", "pin.force.z", "spring.tension" or "energy.total".

Every analysis, study, plot, table and the shell take their names from here. Formulas of mechanics are in the elements;
what is made of outputs, such as responses and events, is in the analyses.
"""

from ..registration import import_modules
from .output import Level, Output, UnknownOutput, find_output, outputs_of, provides
from .outputs import Outputs

__all__ = ["Level", "Output", "Outputs", "UnknownOutput", "find_output", "outputs_of", "provides"]

import_modules(__name__, __path__)  # each registers its outputs
