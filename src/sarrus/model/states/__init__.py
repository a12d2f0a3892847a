"""First-order states x' = f(x, outputs, t, parameters): their place in q and v, and the parts that have them."""

from ...registration import import_modules

import_modules(__name__, __path__)
