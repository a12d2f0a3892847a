"""Forces of a fluid on bodies: drag at a point, and on shapes with a size."""

from ....registration import import_modules

import_modules(__name__, __path__)
