"""Rolling tyres: the contact, and laws of the tyre, one file each."""

from .brush import Brush as Brush
from .contact import tyre_element as tyre_element
from .fiala import Fiala as Fiala
from .large_angles import LargeAngles52 as LargeAngles52
from .large_angles import LargeAngles61 as LargeAngles61
from .large_angles import LargeAnglesTurnSlip as LargeAnglesTurnSlip
from .law import Slip as Slip
from .law import TyreLaw as TyreLaw
from .law import Wrench as Wrench
from .magic_formula_52 import MagicFormula52 as MagicFormula52
from .magic_formula_61 import MagicFormula61 as MagicFormula61
from .sampling import sampled as sampled
from .tmeasy import TMeasy as TMeasy
from .turn_slip import TurnSlip as TurnSlip
