"""Loading of a model file: from the text to a checked model."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...deferred import importer
from ..bodies.body import Body
from ..checks.arguments import checked
from ..checks.findings import KINDS, Findings
from ..checks.other_programs import with_own_types
from ..drivers import Driver
from ..errors import ModelError
from ..expansion.expand import expand
from ..expansion.mappings import RATES, check_units
from ..expression import Expression, Name, parse
from ..forces import Force
from ..geometry.points import GROUND, ground
from ..joints import Joint
from ..laws.formulas import Formulas
from ..model import Model
from ..quantity import number
from ..show import quote, suggest
from ..written import with_numbers, written_numbers
from .scope import Text, full_name
from .text.source import SHIPPED, SUFFIXES, root_tag

if TYPE_CHECKING:
    from .fields import Solids
    from .numbers import Numbers
    from .stated import Entry
    from .text.document import Document


@checked
def load(
    path: str | os.PathLike[str], *, parameters: Mapping[str, float | str] | None = None, **options: Any
) -> Model:
    """Read and check a model file (YAML or JSON), or a file of another program (URDF, SDF, MJCF).

    Parameters
    ----------
    path
        A file whose name ends in ``.yaml``, ``.yml`` or ``.json``, see docs/model-file.md; or ``"slider_crank"`` or
        ``"hmmwv"``, which come with the package; or a file that `load_any` reads. If the ending and the content are of
        different formats, the content counts.
    parameters
        New values for parameters of a model file: numbers in SI units, or texts as in the file.
    options
        Those of `load_urdf`, `load_sdf` or `load_mjcf`, for such a file.

    Returns
    -------
    Model
        With its ``origin``, so that later errors can name file and line too.

    Raises
    ------
    ModelError
        For anything that is wrong with the file or the model, in one message that names
        file, line, part and remedy.
    """
    file = shipped(path)
    if file.suffix.lower() in SUFFIXES and not options and not root_tag(file):
        return loaded(read(file), parameters)
    given = {} if parameters is None else {"parameters": parameters}
    model: Model = importer()(file, **given, **options)
    return model


def loaded(document: Document, parameters: Mapping[str, float | str] | None = None) -> Model:
    """Return the checked model of a document, with the files that it includes; see `load`."""
    from .include import with_included
    from .numbers import Numbers

    document = with_included(document)
    of_parts = exchange(document, parameters or {})
    numbers = Numbers(document.data)
    model = build_model(validate(document, numbers), document, numbers)
    if of_parts:
        model = _with_numbers(model, of_parts)
    check_units(expand(model), _written_rates(model), model.origin, model.formulas.definitions)
    return model


def shipped(path: str | os.PathLike[str]) -> Path:
    """The path itself, or that of a mechanism of the package if a name of one is given and there is no such file."""
    own = SHIPPED / f"{path}.yaml"
    plain = str(path).isidentifier() and not Path(path).exists()
    return own if plain and own.is_file() else Path(path)


def _written_rates(model: Model) -> dict[str, Expression]:
    """The initial rates that were written as formulas."""
    return {
        str(path[1]): tree for path, tree in model.expressions.items() if path[0] == RATES and len(path) == 2
    }


def read(path: Path) -> Document:
    """Return the plain data of a model file."""
    from .text.source import read_text

    return parsed(read_text(path), path)


def parsed(text: str, path: Path) -> Document:
    """Return the plain data of the text of a model file."""
    from .text.json_document import read_json
    from .text.yaml_document import read_yaml

    return read_json(text, str(path)) if path.suffix.lower() == ".json" else read_yaml(text, str(path))


def exchange(document: Document, new: Mapping[str, float | str]) -> dict[str, float | str]:
    """Replace values of parameters in the document; return those that it has in no place of their own."""
    left: dict[str, float | str] = {}
    data = document.data if isinstance(document.data, dict) else {}
    for name, value in new.items():
        *group, inner = name.split(".")
        sections = [data.get("parameters"), *(data.get(section) for section in KINDS if group)]
        holders = [reduce(_entry_of, group, section) for section in sections]
        holder = next((one for one in holders if isinstance(one, dict) and inner in one), None)
        if holder is None or isinstance(holder[inner], dict | list):
            left[name] = value
        else:
            holder[inner] = value if isinstance(value, str) else number(value, name)
    return left


def _entry_of(data: Any, key: str) -> Any:
    return data.get(key) if isinstance(data, dict) else None


def _with_numbers(model: Model, new: Mapping[str, float | str]) -> Model:
    known = [*model.parameters, *written_numbers(model)]
    for name, value in new.items():
        if name not in known:
            raise ModelError(f"there is no parameter {quote(name)}. {suggest(name, known)}", part="model")
        number(value, name, "Give a number in SI units.")
    return with_numbers(model, new)


def validate(document: Document, numbers: Numbers) -> Entry:
    """Return the document's data in the layout of a model file."""
    from pydantic import ValidationError

    from .layout import layout
    from .validation_messages import first_error

    with_own_types(document.data, {*Joint.kinds, *Driver.kinds, *Force.kinds})
    try:
        return layout(document.data).model_validate(document.data, context=numbers)
    except ValidationError as error:
        raise first_error(error, document) from None


def build_model(entry: Any, document: Document, numbers: Numbers) -> Model:
    """Return the model that a validated file describes."""
    from .forms import formulas

    with Findings(document.origin) as findings:
        bodies = build_parts(entry.bodies, "bodies", {"": Body}, {}, findings)
        refused = {
            name: Body(name, 1.0, (1.0, 1.0, 1.0)) for name in entry.bodies
        }  # which others may connect
        solids = {GROUND: ground, **refused, **{body.name: body for body in bodies}}
        joints = build_parts(entry.joints, "joints", Joint.kinds, solids, findings)
        drivers = build_parts(entry.drivers, "drivers", Driver.kinds, solids, findings)
        forces = build_parts(entry.forces, "forces", Force.kinds, solids, findings)
    file_formulas = Formulas(numbers.parameters(), dict(formulas(entry)), numbers.trees, dict(entry.points))
    parts = bodies, joints, forces, entry.gravity, drivers
    name = Path(document.origin.file).stem if entry.name is None else entry.name
    outputs = _outputs(document.data.get("outputs", {}))
    return Model(
        name, *parts, origin=document.origin, formulas=file_formulas, rates=dict(entry.rates), outputs=outputs
    )


def _outputs(given: Mapping[str, str]) -> dict[str, str]:
    """Formulas of outputs, with the full names of parts of included files."""

    def full(text: str) -> str:
        tree = parse(text)
        return str(tree.replaced({name: Name(full_name(text, name)) for name in tree.names()}))

    return {name: full(text) if isinstance(text, Text) else text for name, text in given.items()}


def build_parts(
    entries: Any, section: str, kinds: Mapping[str, Any], solids: Solids, findings: Findings
) -> list[Any]:
    """Return the parts of a section that its validated entries describe, but those with an error."""
    from .forms import build

    built = []
    for name, entry in entries.items():
        with findings.about(section, name):
            built.append(build(kinds[getattr(entry, "type", "")], name, entry, solids))
    return built
