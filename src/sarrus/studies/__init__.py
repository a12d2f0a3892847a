"""Studies: one analysis for many values of a model's parameters, on one machine or many.

Files of studies and of optimizations are read here too, and formulas of responses. The analyses themselves, and the
search for an optimum, are in `sarrus.analyses`; pictures are in `sarrus.views`.
"""

from .conduct import study as study
from .first_order import Uncertainty as Uncertainty
from .first_order import uncertainty as uncertainty
from .parameters import Distribution as Distribution
from .parameters import Range as Range
from .parameters import Values as Values
from .runs import InverseDynamics as InverseDynamics
from .runs import Kinematics as Kinematics
from .runs import Linearization as Linearization
from .runs import Simulation as Simulation
from .runs import Statics as Statics
from .runs import Vibration as Vibration
from .samples import Grid as Grid
from .samples import LatinHypercube as LatinHypercube
from .samples import Listed as Listed
from .samples import MonteCarlo as MonteCarlo
from .samples import Sobol as Sobol
from .table import StudyTable as StudyTable
from .table import open_study as open_study
