"""The joints. A file of this folder is found without a list: its classes register themselves when they are made."""

from ...registration import import_modules
from .joint import Joint as Joint

import_modules(__name__, __path__)
