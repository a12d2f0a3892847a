"""From a model file to a checked model."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..body import Body
from ..expand import expand
from ..findings import Findings
from ..forces import Force
from ..joints import Joint
from ..model import Model
from ..solid import GROUND, ground

if TYPE_CHECKING:
    from .document import Document
    from .entry import Entry
    from .fields import Solids


def load(path: str | os.PathLike[str]) -> Model:
    """Read a model from a YAML or JSON file and check all of it.

    Parameters
    ----------
    path
        A file whose name ends in ``.yaml``, ``.yml`` or ``.json``; see docs/model-file.md.

    Returns
    -------
    Model
        With its ``origin``, so that later errors can name file and line too.

    Raises
    ------
    ModelError
        For anything that is wrong with the file or the model, in one sentence that names
        file, line, part and remedy.
    """
    document = read(Path(path))
    model = build_model(validate(document), document)
    expand(model)
    return model


def read(path: Path) -> Document:
    """Return the plain data of a model file."""
    from .json_document import read_json
    from .source import read_text
    from .yaml_document import read_yaml

    text = read_text(path)
    return read_json(text, str(path)) if path.suffix.lower() == ".json" else read_yaml(text, str(path))


def validate(document: Document) -> Entry:
    """Return the document's data in the layout of a model file."""
    from pydantic import ValidationError

    from .layout import layout
    from .sentences import first_error

    try:
        return layout().model_validate(document.data)
    except ValidationError as error:
        raise first_error(error, document) from None


def build_model(entry: Any, document: Document) -> Model:
    """Return the model that a validated file describes."""
    findings = Findings(document.origin)
    bodies = _build(entry.bodies, "bodies", {"": Body}, {}, findings)
    solids = {GROUND: ground, **{body.name: body for body in bodies}}
    joints = _build(entry.joints, "joints", Joint.kinds, solids, findings)
    forces = _build(entry.forces, "forces", Force.kinds, solids, findings)
    findings.raise_first()
    return Model(entry.name, bodies, joints, forces, entry.gravity, origin=document.origin)


def _build(
    entries: Any, section: str, kinds: dict[str, Any], solids: Solids, findings: Findings
) -> list[Any]:
    from .forms import build

    built = []
    for name, entry in entries.items():
        with findings.about(section, name):
            built.append(build(kinds[getattr(entry, "type", "")], name, entry, solids))
    return built
