"""Controllers and filters: blocks whose inputs and outputs are signals, and the systems that they are made of."""

from ....registration import import_modules

import_modules(__name__, __path__)
