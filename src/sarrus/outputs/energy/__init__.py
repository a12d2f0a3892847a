"""Energies and powers along a motion."""

from ...registration import import_modules

import_modules(__name__, __path__)  # each registers its outputs
