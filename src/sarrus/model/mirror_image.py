"""Parts of the left and the right side of a model: mirror images about the plane y = 0.

The frame of a mirrored body is the mirror image of the body's frame with its second axis reversed, so that it is
right-handed: A becomes S A S with S = diag(1, -1, 1), and a point s′ of the body becomes S s′.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from typing import Any, Literal, TypeAlias, get_args

from .bodies.body import Body
from .drivers import Driver
from .drivers.driver import DisplacementDriver
from .errors import ModelError, restated
from .expression import Expression, Name
from .expression.formula_value import FormulaValue, negative
from .forces import Force
from .forces.by_formula import Force as ForceByFormula
from .forces.by_formula import has_outputs
from .forces.paths.wrapping import Wrap
from .geometry.orientation import AxisAngle, EulerAngles
from .geometry.points import Frame, Point, Solid, frame_axes
from .joints import Joint
from .laws.curve import Formula, Tree
from .laws.recorded import parsed
from .measure import In, directed_fields, measures_of
from .mirrored_outputs import EvenOutputs
from .parity import SIGNS, Parity
from .preparation.moving_points import moves
from .quantity import has_rows, is_list
from .show import quote, show
from .states.input import OWN
from .text_numbers import with_numbers_of_texts

Part: TypeAlias = Body | Joint | Driver | Force
SIDES = ("left", "right")
TEXTS = ("name", "unit", "axes")  # fields whose texts are no names of parts


def both_sides(
    *parts: Part, given: Literal["left", "right"] = "left", beside: Iterable[Part] = ()
) -> list[Part]:
    """Return parts of one side of a model with their mirror images about the plane y = 0.

    Parameters
    ----------
    parts : bodies, joints, drivers and forces; other parts that they connect, such as a chassis, are on no side
    given : the side of these parts, the left one if y is positive
    beside : parts on no side whose coordinates or outputs these read, such as the guide of a rack

    Returns
    -------
    list of parts : ``arm_left``, ``arm_right`` and so on, for ``Model(...).adding(*both_sides(arm, ...))``

    Raises
    ------
    ModelError
        For a part that cannot be mirrored, or that reads a part which is not given.

    Notes
    -----
    Coordinates of hardpoints are parameters of both sides. Angles and displacements of joints have the same values in
    mirrored positions, and inputs have the same values. Bodies with a mesh are drawn without it on the other side.
    """
    if given not in SIDES:
        raise ModelError(f'given must be "left" or "right", but is {show(given)}. Choose one of them.')
    for part in parts:
        _check_part(part)
    names = {part.name: f"{part.name}_{given}" for part in parts}
    images = Image(names, mirrored=False), Image({name: other_side(own) for name, own in names.items()})
    known = [*beside, *parts]
    for image in images:
        image.add(known)
    return [image(part) for part in parts for image in images]


def other_side(name: str) -> str:
    """Return the name of a part on the other side: ``arm_right`` for ``arm_left``."""
    stem, _, side = name.rpartition("_")
    return f"{stem}_{SIDES[side == SIDES[0]]}"


def _check_part(part: Any) -> None:
    if not isinstance(part, get_args(Part)):
        message = f"both_sides takes bodies, joints, drivers and forces, but got {show(part)}"
        raise ModelError(f"{message}. Write both_sides(arm, hinge), with the objects.")
    name: str = part.name
    if name in OWN:
        message = (
            f"a part of a side may not have the name {quote(name)}, which formulas use for something else"
        )
        raise ModelError(f"{message}. Rename it.")
    for one in fields(part):
        value = getattr(part, one.name, None)
        if one.name == "point" and moves(value.coordinates if isinstance(value, Point) else value):
            message = "has a moving point, which both_sides cannot mirror. Write the parts of both sides"
            raise ModelError(f"{message}, or a model file.", part=quote(name), field=one.name)


class Image:
    """Images of parts under other names.

    Parameters
    ----------
    names : the new name for each part
    mirrored : whether they are mirror images
    complete : whether all parts of the model will be added, so that other names are those of parameters
    """

    def __init__(self, names: Mapping[str, str], mirrored: bool = True, complete: bool = False) -> None:
        self.names, self.mirrored, self.complete = dict(names), mirrored, complete
        self._parts: dict[str, Part] = {}
        self._bodies: dict[str, Body] = {}

    def add(self, parts: Iterable[Part]) -> None:
        """Let parts be known, which others refer to by name."""
        self._parts |= {part.name: part for part in parts}

    def __call__(self, part: Part) -> Any:
        """Return the image of a part.

        Raises
        ------
        ModelError
            If it cannot be mirrored.
        """
        with restated(part=quote(part.name)):
            return self._body(part) if isinstance(part, Body) else self._changed(with_numbers_of_texts(part))

    def _body(self, body: Body) -> Body:
        if body.name not in self._bodies:
            new: dict[str, Any] = {"name": self.names[body.name]}
            if self.mirrored:
                new |= {
                    "shape": None,
                    "inertia": _inertia(body.inertia),
                    "orientation": _orientation(body.orientation),
                }
                if body.initial_orientation is not None:
                    new["initial_orientation"] = _orientation(body.initial_orientation)
                names = ("position", "initial_position", "center_of_mass", "velocity")
                polar = {one: getattr(body, one) for one in names}
                new |= {one: _vector(value, "polar") for one, value in polar.items() if value is not None}
                if body.angular_velocity is not None:
                    new["angular_velocity"] = _vector(body.angular_velocity, "axial")
            self._bodies[body.name] = replace(body, **new)
        return self._bodies[body.name]

    def _changed(self, part: Any) -> Any:
        taken = [name for name in getattr(part, "parameters", ()) if name in self.names]
        if taken:
            message = f"its parameter {quote(taken[0])} has the name of a part. Rename one of them."
            raise ModelError(message, field="parameters")
        new = {
            one.name: self._field(part, one.name) for one in fields(part) if one.init and one.name != "name"
        }
        return replace(part, name=self.names[part.name], **new)

    def _field(self, part: Any, field: str) -> Any:
        """The value of a field in the image."""
        value, measure = getattr(part, field), measures_of(part).get(field, In(""))
        if value is None or isinstance(value, bool):
            return value
        if field == "parameters":
            return value
        is_law = measure.over != "1" or measure.outputs
        parity = self._parity(part, field, measure)
        if isinstance(value, str) and not is_law:
            return value if field in TEXTS else self._reference(part, value)
        if parity == "terms" and self.mirrored:
            return {
                part.exchanged_terms.get(name, name): negative(x) if name in part.odd_terms else x
                for name, x in value.items()
            }
        if is_law:
            return self._laws(value, parity, field)
        if isinstance(value, Mapping):
            refers = field == "joints"
            return {self._reference(part, key) if refers else key: entry for key, entry in value.items()}
        return self._placed(value, parity)

    def _parity(self, part: Joint | Driver | Force, field: str, measure: In) -> Parity:
        """How a field changes, as its class declares; that of global points is known."""
        found: Parity | None = part.parity.get(field)
        if found is None and measure.named:
            found = "polar"
        if self.mirrored and (
            found == "refused" or (found is None and field in directed_fields(part.__class__))
        ):
            message = f"has no mirror image, because its class does not declare that of {field}"
            raise ModelError(f"{message}. Write the parts of both sides.", field=field)
        return found or "even"

    def _placed(self, value: Any, parity: Parity) -> Any:
        """Bodies, points, frames and numbers."""
        if isinstance(value, Solid):
            return self._body(value) if isinstance(value, Body) and value.name in self.names else value
        if isinstance(value, Point):
            coordinates = self._signed(value.coordinates, "polar")
            return replace(value, body=self._placed(value.body, "even"), coordinates=coordinates)
        if isinstance(value, Frame):
            return self._frame(value, parity)
        if isinstance(value, Wrap):
            own = {one: getattr(value, one) for one in ("center", "axis", "side")}
            new: Any = {one: self._placed(x, "polar") for one, x in own.items() if x is not None}
            return replace(value, **new)
        if is_list(value) and any(isinstance(one, Point | Wrap) for one in value):
            return [self._placed(one, parity) for one in value]
        return self._signed(value, parity)

    def _signed(self, value: Any, parity: Parity) -> Any:
        return _vector(value, parity) if self.mirrored and parity != "even" else value

    def _frame(self, frame: Frame, parity: Parity) -> Frame:
        """The axes of an image are those of the frame mirrored, also those that are not given."""
        x, z = frame.x, frame.z
        if self.mirrored and x is None and z is None and parity == "axial":
            x, z = (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)
        elif self.mirrored and not (x is None and z is None):
            if x is None or z is None:
                _refuse_formulas(frame)
                axes = frame_axes(x, z, "z")
                x, z = (axes[:, 0].tolist(), z) if x is None else (x, axes[:, 2].tolist())
            x, z = self._signed(x, "polar"), self._signed(z, parity)
        return Frame(self._placed(frame.point, "even"), x=x, z=z)

    def _reference(self, part: Any, text: str) -> str:
        """The name of a part, or of a joint's coordinate, in the image."""
        if self.mirrored and text:
            known: Any = self._parts.get(text)
            along = isinstance(part, DisplacementDriver | ForceByFormula)
            if along and "displacement" in getattr(known, "free", ()):
                self._refuse_odd(f"{text}.displacement")
            else:
                self._refuse_odd(text)
        return self._name(text)

    def _name(self, name: str) -> str:
        first, dot, rest = name.partition(".")
        return f"{self.names.get(first, first)}{dot}{rest}"

    def _refuse_odd(self, name: str) -> None:
        """Refuse an output or a coordinate of a joint that is not known to be the same in the mirror image."""
        first = name.partition(".")[0]
        sides = {*self.names.values(), *map(other_side, self.names.values())}
        if first in sides - {*self.names}:
            message = f"has no mirror image, because it reads {quote(name)} of the other side"
            raise ModelError(f"{message}. Write the parts of both sides.")
        if first not in self._parts:
            if self.complete:
                return
            message = f"has no mirror image, because it reads {quote(name)} of a part that is not given"
            raise ModelError(f"{message}. Give the part in beside, or write the parts of both sides.")
        if not EvenOutputs(self._parts, self.names, sides | {*self.names})(name):
            message = f"has no mirror image, because {quote(name)} has another value there"
            raise ModelError(f"{message}. Write the parts of both sides.")

    def _laws(self, value: Any, parity: Parity, field: str) -> Any:
        signs = SIGNS.get(parity)
        if signs and is_list(value) and len(value) == len(signs):
            return [self._law(one, sign < 0, field) for one, sign in zip(value, signs, strict=True)]
        if is_list(value) and not any(is_list(row) for row in value):
            return [self._law(one, False, field) for one in value]
        return self._law(value, parity == "odd", field)

    def _law(self, law: Any, odd: bool, field: str) -> Any:
        """A law with the names of the image, with the other sign if it is odd."""
        law = parsed(law, field) if isinstance(law, str) else law
        reverse = odd and self.mirrored
        if isinstance(law, Expression):
            return -self._tree(law) if reverse else self._tree(law)
        if isinstance(law, Formula) and isinstance(law.function, Tree):
            return Formula(replace(law.function, tree=self._law(law.function.tree, odd, field)))
        if isinstance(law, float | int):
            return negative(law) if reverse else law
        if has_outputs(law) or reverse:
            raise ModelError(f"{field} has no mirror image. Give a formula as a text.", field=field)
        return law

    def _tree(self, tree: Expression) -> Expression:
        own = [name for name in tree.names() if name.partition(".")[0] in self.names]
        for name in tree.names() if self.mirrored else ():
            if "." in name or name in self._parts:
                self._refuse_odd(name)
        return tree.replaced({name: Name(self._name(name)) for name in own})


def _refuse_formulas(frame: Frame) -> None:
    """Refuse a frame with one axis that follows parameters: no formula for the other would mirror it."""
    given, left = ("z", "x") if frame.x is None else ("x", "z")
    values: Any = getattr(frame, given)
    if any(isinstance(one, FormulaValue | Expression) for one in values):
        message = f"has no mirror image, because its frame has a formula in {given}, and no {left}"
        raise ModelError(f"{message}. Give {left}, too.")


def _reversed(value: Any) -> Any:
    """A number or a moving coordinate with the other sign."""
    if isinstance(value, Formula) and isinstance(value.function, Tree):
        return Formula(replace(value.function, tree=-value.function.tree))
    return negative(value)


def _vector(value: Any, parity: Parity) -> Any:
    """Numbers in the mirror image: a vector, a number, or the components of a matrix."""
    if parity == "odd":
        return _reversed(value)
    signs = SIGNS[parity]
    if is_list(value[0]):
        rows = [
            [x if sign > 0 else _reversed(x) for x, sign in zip(row, signs, strict=True)] for row in value
        ]
        return [row if s > 0 else [_reversed(x) for x in row] for row, s in zip(rows, signs, strict=True)]
    if parity == "matrix":
        return value
    return [x if sign > 0 else _reversed(x) for x, sign in zip(value, signs, strict=True)]


def _inertia(inertia: Any) -> Any:
    """S J S: the products of inertia with y change their signs."""
    if isinstance(inertia, Mapping):
        return {name: negative(x) if name in ("xy", "yz") else x for name, x in inertia.items()}
    return _vector(inertia, "polar") if has_rows(inertia) else inertia


def _orientation(orientation: Any) -> Any:
    """S A S: rotations about y remain, others change their signs."""
    if isinstance(orientation, AxisAngle):
        return AxisAngle(_vector(orientation.axis, "axial"), orientation.angle)
    if isinstance(orientation, EulerAngles):
        turns = zip(orientation.angles, orientation.sequence, strict=True)
        return EulerAngles([x if axis == "y" else negative(x) for x, axis in turns], orientation.sequence)
    if has_rows(orientation):
        return _vector(orientation, "polar")
    e0, *e = orientation
    return [e0, *_vector(e, "axial")]
