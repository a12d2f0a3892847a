"""Formulas as values: parsed safely, evaluated for any kind of number, differentiated exactly."""

from .functions import FUNCTIONS as FUNCTIONS
from .parser import parse as parse
from .parser import parse_expression as parse_expression
from .tree import Call as Call
from .tree import Expression as Expression
from .tree import Name as Name
from .tree import Number as Number
