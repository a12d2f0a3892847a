"""The published JSON Schema of the model file."""

from __future__ import annotations

import json
from typing import Any


def schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a model file with the joints and forces registered now."""
    from pydantic.json_schema import GenerateJsonSchema

    from .layout import layout

    class UntitledSchema(GenerateJsonSchema):
        def field_title_should_be_set(self, schema: Any) -> bool:
            return False

    head = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    whole = layout().model_json_schema(by_alias=True, schema_generator=UntitledSchema)
    whole["required"].remove("bodies")  # which may come from included files, or be on a side
    return head | whole | {"anyOf": [{"required": [key]} for key in ("bodies", "include", "left", "right")]}


def schema_text() -> str:
    """Return the JSON Schema as text, as in ``schema.json`` beside this file."""
    return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"


def print_schema() -> None:
    """Print the JSON Schema; redirect it to ``schema.json`` after a change of a joint or force."""
    print(schema_text(), end="")
