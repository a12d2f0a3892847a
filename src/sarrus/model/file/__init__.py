"""The model file: YAML or JSON, checked against one layout. Loads pydantic and yaml only when used."""

from .load import load as load
from .schema import print_schema as print_schema
from .schema import schema as schema
from .schema import schema_text as schema_text
