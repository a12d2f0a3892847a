"""The forces. A file of this folder is found without a list: its classes register themselves when they are made."""

from ...registration import import_modules
from .force import Force as Force

import_modules(__name__, __path__)
