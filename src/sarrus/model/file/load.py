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
from ..expansion.expand import expand
from ..expansion.mappings import RATES, check_units
from ..expression import Expression, Name, parse
from ..expression.formula_value import FormulaValue
from ..forces import Force
from ..geometry.points import GROUND, ground
from ..joints import Joint
from ..laws.formulas import Formulas
from ..mirror_image import Image, other_side
from ..model import Model
from ..preparation.named_parameters import formulas_of
from ..quantity import number
from ..written import with_parameters
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
        A file whose name ends in ``.yaml``, ``.yml`` or ``.json``, see docs/model-file.md; or ``"slider_crank"``,
        ``"hmmwv"``, ``"hmmwv_driving"`` or ``"car"``, which come with the package; or a file that `load_any` reads. If
        the ending and the content are of different formats, the content counts.
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
    from .hardpoints import refuse_second_meaning, with_unit
    from .include import with_included
    from .numbers import Numbers
    from .sides import with_sides

    document = with_included(with_sides(with_unit(document)))
    of_parts = exchange(document, parameters or {})
    numbers = Numbers(document.data)
    entry = validate(document, numbers)
    refuse_second_meaning(document)
    model = build_model(entry, document, numbers)
    if of_parts:
        model = with_parameters(model, of_parts)
    check_units(expand(model), _written_rates(model), model.origin, model.formulas.definitions)
    return model


def shipped(path: str | os.PathLike[str]) -> Path:
    """The path itself, or that of a mechanism of the package if a name of one is given and there is no such file."""
    plain = str(path).isidentifier() and not Path(path).exists()
    return next(SHIPPED.rglob(f"{path}.yaml"), Path(path)) if plain else Path(path)


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
        if name.partition(".")[0] in document.mirrored:  # the file has the number of both sides
            left[name] = value
            continue
        if _moved_hardpoint(data.get("hardpoints"), group, inner, value):
            continue
        sections = [data.get("parameters"), *(data.get(section) for section in KINDS if group)]
        holders = [reduce(_entry_of, group, section) for section in sections]
        holder = next((one for one in holders if isinstance(one, dict) and inner in one), None)
        if holder is None or isinstance(holder[inner], dict | list):
            left[name] = value
        else:
            holder[inner] = value if isinstance(value, str) else number(value, name)
    return left


def _moved_hardpoint(table: Any, group: list[str], axis: str, value: float | str) -> bool:
    """Replace a coordinate of a hardpoint; return whether there is one."""
    place = table.get(group[0]) if isinstance(table, dict) and len(group) == 1 else None
    if not isinstance(place, list) or len(place) != 3 or axis not in ("x", "y", "z"):
        return False
    place["xyz".index(axis)] = value if isinstance(value, str) else number(value, f"{group[0]}.{axis}")
    return True


def _entry_of(data: Any, key: str) -> Any:
    return data.get(key) if isinstance(data, dict) else None


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
    from .sides import images

    with Findings(document.origin) as findings:
        image = Image({name: other_side(name) for name in document.mirrored}, complete=True)
        bodies = build_parts(entry.bodies, "bodies", {"": Body}, {}, findings)
        image.add(bodies)
        of_bodies = images(image, bodies, "bodies", findings)
        names = [name for one in entry.bodies for name in (one, image.names.get(one, one))]
        refused = {name: Body(name, 1.0, (1.0, 1.0, 1.0)) for name in names}  # which others may connect
        solids = {GROUND: ground, **refused, **{body.name: body for body in (*bodies, *of_bodies)}}
        joints = build_parts(entry.joints, "joints", Joint.kinds, solids, findings)
        drivers = build_parts(entry.drivers, "drivers", Driver.kinds, solids, findings)
        forces = build_parts(entry.forces, "forces", Force.kinds, solids, findings)
        given = {"joints": joints, "drivers": drivers, "forces": forces}
        image.add((*joints, *drivers, *forces))
        mirrored = {"bodies": of_bodies} | {
            section: images(image, own, section, findings) for section, own in given.items()
        }
    parameters, hardpoints = numbers.parameters(), {name: numbers.unit_of(name) for name in entry.hardpoints}
    trees = {path: tree for path, tree in formulas(entry) if path[0] != "hardpoints"}
    trees |= {path: x.expression for path, x in formulas_of(mirrored) if isinstance(x, FormulaValue)}
    file_formulas = Formulas(parameters, trees, numbers.trees, dict(entry.points), hardpoints)
    bodies, joints, forces, drivers = (
        [*own, *mirrored[section]]
        for section, own in (("bodies", bodies), ("joints", joints), ("forces", forces), ("drivers", drivers))
    )
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
