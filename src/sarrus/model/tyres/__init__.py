"""Tyres that roll, one law in a file. A file of this folder is found without a list."""

from ...registration import import_modules

import_modules(__name__, __path__)
