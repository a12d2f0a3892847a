"""A model taken apart into primitives. Every check of a model happens on the way."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import fields
from functools import cache
from types import NoneType
from typing import Any, NamedTuple, get_args, get_origin, get_type_hints

from ... import elements
from ...elements.element import RIGID
from ..bodies.body import MassProperties
from ..checks.findings import Findings
from ..checks.names import check_name
from ..coordinate import Coordinate, Known
from ..coordinates import CoordinateBlock
from ..drivers.of_states import driven_by_states, followed_states, motions_of, with_state_motions
from ..errors import ModelError
from ..forces.by_formula import RESERVED
from ..geometry.points import GROUND, Frame, Point, Solid
from ..geometry.pose import GROUND_POSE, Pose, Poses
from ..laws.curve import Formula, Tree
from ..laws.jumps import TIME
from ..laws.recorded import arguments, has_all_outputs
from ..laws.text_units import check_texts
from ..measure import In, measures_of
from ..model import KINDS, Model
from ..preparation.prepare import refuse_unprepared
from ..primitive import Primitive
from ..quantity import Array, Vec3, is_list, numbers, vector
from ..show import quote, show
from ..signals import Signals
from ..states.block import Block, StateValue, blocks_of
from ..states.input import OWN, Input, refuse_lost, with_inputs
from .mappings import check_outputs, check_rates

ORIGIN: Vec3 = (0.0, 0.0, 0.0)
WANTED: dict[type, tuple[str, str]] = {
    Solid: ("a body", "the Body object (or sarrus.ground)"),
    Point: ("a point of a body", "body.point(x, y, z)"),
    Frame: ("a frame of a body", "body.frame(point, z=...)"),
}


class BodyState(NamedTuple):
    """A body with its checked numbers: its pose in the design position, and that at the start."""

    name: str
    pose: Pose
    start: Pose
    rates: Array
    given: tuple[bool, ...]
    mass: MassProperties


class Piece(NamedTuple):
    """A primitive and the name of the part it belongs to."""

    owner: str
    primitive: Primitive


class ExpandedModel(NamedTuple):
    """The checked model.

    Attributes
    ----------
    bodies
        Without the blocks of states.
    pieces
        In the order joints, drivers, inertia, gravity, states, forces.
    coordinates
        Those of the joints.
    others
        Blocks of coordinates of parts, which come behind those of bodies.
    blocks
        The first-order states, which come last.
    """

    bodies: tuple[BodyState, ...]
    pieces: tuple[Piece, ...]
    coordinates: tuple[Piece, ...]
    others: tuple[CoordinateBlock, ...]
    blocks: tuple[Block, ...]


def expand(model: Model) -> ExpandedModel:
    """Return the checked bodies and primitives of a model.

    Raises
    ------
    ModelError
        For the first thing that is wrong, in the order names, gravity, bodies, joints, drivers, forces.
    """
    given: object = model
    if not isinstance(given, Model):
        is_system = isinstance(getattr(given, "model", None), Model)
        remedy = "Pass its model" if is_system else "Read a file with sarrus.load(path)"
        raise ModelError(f"a system is made of a Model, but this is {show(given)}. {remedy}.")
    _check_lists(model)
    _check_names(model)
    with Findings(model.origin) as findings:
        refuse_unprepared(model, findings)
    gravity = _gravity(model)
    bodies = _bodies(model)
    findings = Findings(model.origin)
    poses = {GROUND: GROUND_POSE, **{body.name: body.pose for body in bodies}}
    known: dict[str, tuple[Coordinate, ...]] = {}
    joints = _joints(model, poses, findings, known)
    others, states = _others(model, findings), _states(model, findings)
    drivers = _drivers(model, poses, findings, known, states)
    blocks, signals, own = _signals(model, poses, findings, known, states, drivers, bodies)
    constraints = (*joints, *_driven(model, drivers, findings, signals))
    forces = _forces(model, findings, own, signals)
    if not findings.errors:
        check_rates(model, known, findings)
    findings.raise_first()
    coordinates = (Piece(joint, one.measure) for joint, found in known.items() for one in found)
    hidden = (Piece("", piece) for block in blocks for piece in block.primitives())
    pieces = (*constraints, *_loads(bodies, gravity), *hidden, *forces)
    return ExpandedModel(bodies, pieces, tuple(coordinates), others, blocks)


def _check_names(model: Model) -> None:
    seen: dict[str, str] = {GROUND: "the ground"}
    with Findings(model.origin) as findings:
        with findings.about():
            _check_title(model)
        for section, parts in model.sections().items():
            for part in parts:
                with findings.about(section, str(getattr(part, "name", ""))):
                    _check_kind(part, section)
                    check_name(part.name)
                    _check_new(part.name, seen, section)
        for name in model.formulas.hardpoints:
            with findings.about("hardpoints", name):
                _check_new(name, seen, "hardpoints")
        check_outputs(model, seen, findings)


def _check_lists(model: Model) -> None:
    with Findings(model.origin) as findings:
        for section, parts in model.sections().items():
            with findings.about():
                given: Any = parts
                if not isinstance(given, Collection) or isinstance(given, str | Mapping):
                    message = f"{section} must be a list, but is {kind_of(given)}. Write [...] around it."
                    raise ModelError(message, field=section)


def _check_title(model: Model) -> None:
    title: Any = model.name
    if not (isinstance(title, str) and title.strip() and title.isprintable()):
        raise ModelError(f"name must be a text on one line, but is {show(title)}. Name it.", field="name")
    if not model.bodies:
        raise ModelError("has no bodies. Give at least one.", field="bodies")


def _check_kind(part: Any, section: str) -> None:
    kind = KINDS[section]
    if not isinstance(part, kind):
        homes = [name for name, other in KINDS.items() if isinstance(part, other)]
        remedy = f"Move it to {homes[0]}." if homes else f"List only {kind.__name__} objects there."
        raise ModelError(f"is among the {section}, but its type is {type(part).__name__}. {remedy}")


def _check_new(name: str, seen: dict[str, str], section: str) -> None:
    if name in seen:
        raise ModelError(f"the name {quote(name)} is taken by {seen[name]}. Rename one of them.")
    seen[name] = f"another of the {section}"


def _gravity(model: Model) -> Vec3:
    gravity = ORIGIN
    with Findings(model.origin) as findings, findings.about():
        gravity = vector(model.gravity, "gravity", "Give three numbers in m/s², such as (0, 0, -9.81).")
    return gravity


def _bodies(model: Model) -> tuple[BodyState, ...]:
    return tuple(
        BodyState(
            body.name,
            body.pose(),
            body.initial_pose(),
            body.rates(),
            body.given_rates(),
            body.mass_properties(),
        )
        for body in model.bodies
    )


def _joints(
    model: Model, poses: Poses, findings: Findings, known: dict[str, tuple[Coordinate, ...]]
) -> list[Piece]:
    """The pieces of the joints, those of couplings in their places; `known` is filled with all coordinates."""
    pieces: dict[str, list[Piece]] = {}
    for joint in model.joints:
        with findings.about("joints", joint.name):
            check_connections(joint)
            check_texts(joint)
            pieces[joint.name] = [Piece(joint.name, primitive) for primitive in joint.primitives(poses)]
            known[joint.name] = tuple(joint.coordinates(poses))
    for joint in model.joints if not findings.errors else ():
        with findings.about("joints", joint.name):
            pieces[joint.name] += [Piece(joint.name, primitive) for primitive in joint.relations(known)]
    return [piece for own in pieces.values() for piece in own]


def _drivers(
    model: Model, poses: Poses, findings: Findings, known: Known, states: Sequence[StateValue]
) -> list[Piece]:
    """The pieces of the drivers; those that follow states have a `StateMotion` in place of a law."""
    pieces: list[Piece] = []
    inputs = _inputs(model)
    kinds = _kinds(states, inputs)
    followed = {one.name for one in states} | (_variables(model).keys() - inputs.keys() if states else set())
    for driver in model.drivers if not findings.errors else ():
        with findings.about("drivers", driver.name):
            _check_arguments(driver, kinds)
            own = _primitives(with_state_motions(driver, followed), inputs, poses, known)
            pieces += [Piece(driver.name, primitive) for primitive in own]
    return pieces


def _driven(model: Model, drivers: Sequence[Piece], findings: Findings, signals: Signals) -> list[Piece]:
    """The pieces of the drivers with their laws of states."""
    pieces: list[Piece] = []
    units = {name: getattr(one, "unit", "") for one in model.forces for name, _ in one.variables()}
    for piece in drivers if not findings.errors else ():
        with findings.about("drivers", piece.owner):
            pieces.append(Piece(piece.owner, driven_by_states(piece.primitive, signals, units)))
    return pieces


def _variables(model: Model) -> dict[str, Any]:
    """Outputs of forces that are formulas."""
    return dict(pair for force in model.forces for pair in force.variables())


def _inputs(model: Model) -> dict[str, Input]:
    """The inputs by name."""
    return {force.name: force for force in model.forces if isinstance(force, Input)}


def _kinds(states: Sequence[StateValue], inputs: Mapping[str, Input]) -> dict[str, str]:
    """The names of states and inputs, each with what it is."""
    return {one.name: "a state" for one in states} | dict.fromkeys(inputs, "an input")


def _others(model: Model, findings: Findings) -> tuple[CoordinateBlock, ...]:
    """The blocks of coordinates of all parts."""
    found: list[CoordinateBlock] = []
    taken = {GROUND: "the ground", **{body.name: "a body" for body in model.bodies}}
    for force in model.forces:
        with findings.about("forces", force.name):
            for block in force.blocks():
                _check_new(block.name, taken, "blocks")
                if block.name.partition(".")[0] != force.name:
                    message = f"the name {quote(block.name)} of its block must begin with its own. "
                    raise ModelError(
                        f"{message}Write {quote(force.name)}, or {quote(force.name + '.modes')}."
                    )
                if not block.kinds or set(block.kinds) & set(RIGID):
                    message = f"Blocks of {block.name} must be amplitudes. Give (modal(n),) as its kinds."
                    raise ModelError(message, field="blocks")
                size = sum(len(kind.parts) for kind in block.kinds)
                for field in ("q", "v"):
                    numbers(getattr(block, field), size, field, f"Give {size} numbers for {block.name}.")
                found.append(block)
    return tuple(found)


def _states(model: Model, findings: Findings) -> list[StateValue]:
    """The first-order states of all parts."""
    states: list[StateValue] = []
    for force in model.forces:
        with findings.about("forces", force.name):
            own = list(force.states())
            refuse_reserved(own)
            states += own
    return states


def refuse_reserved(states: Sequence[StateValue]) -> None:
    """Raise a ModelError if formulas would take the name of a state for something else."""
    for state in states:
        if state.name in RESERVED:
            raise ModelError(f"formulas use {quote(state.name)} for something else than a state. Rename it.")


def _forces(
    model: Model, findings: Findings, own: dict[str, list[Primitive]], signals: Signals
) -> list[Piece]:
    """The pieces of the forces, those by formulas of outputs in their places. Constraints of states have no owner."""
    for force in model.forces if not findings.errors else ():
        with findings.about("forces", force.name):
            own[force.name] += force.relations(signals)
    return [
        Piece("" if primitive.element.rows else name, primitive)
        for name, found in own.items() for primitive in found
    ]  # fmt: skip


def _signals(
    model: Model,
    poses: Poses,
    findings: Findings,
    known: Known,
    states: Sequence[StateValue],
    drivers: Sequence[Piece],
    bodies: Sequence[BodyState],
) -> tuple[tuple[Block, ...], Signals, dict[str, list[Primitive]]]:
    """The blocks of states, what formulas may contain, and the primitives of the forces without those by formulas."""
    own = _own_forces(model, poses, findings, states)
    primitives = {name: tuple(found) for name, found in own.items()}
    variables, names = _variables(model), {one.name for one in states}
    followed: dict[str, str] = {}
    for piece in drivers:
        with findings.about("drivers", piece.owner):
            for motion in motions_of(piece.primitive):
                followed |= dict.fromkeys(followed_states(motion, names, variables), piece.owner)
    masses = [body.mass.mass for body in bodies]

    def made() -> tuple[tuple[Block, ...], Signals]:
        blocks = blocks_of(states, masses, followed)
        own_signals = {name: one for block in blocks for name, one in block.signals().items()}
        return blocks, Signals(poses, known, primitives, own_signals, variables, followed)

    if followed and not findings.errors:
        _add_used(model, findings, followed, names, made)
    return (*made(), own)


def _add_used(
    model: Model,
    findings: Findings,
    followed: dict[str, str],
    states: Collection[str],
    made: Callable[[], tuple[tuple[Block, ...], Signals]],
) -> None:
    """Add the states that the rates of followed ones use, with the driver that follows these."""
    _, signals = made()
    signals.followed = {}  # rates are recorded only
    for force in model.forces:
        with findings.about("forces", force.name):
            list(force.relations(signals))
    findings.raise_first()
    left = [*followed]
    while left:
        name = left.pop()
        for used in signals.used[name]:
            if used in states and used not in followed:
                followed[used] = followed[name]
                left.append(used)


def _own_forces(
    model: Model, poses: Poses, findings: Findings, states: Sequence[StateValue]
) -> dict[str, list[Primitive]]:
    own: dict[str, list[Primitive]] = {}
    inputs = _inputs(model)
    kinds = _kinds(states, inputs)
    gravity = _gravity(model)
    for force in model.forces:
        with findings.about("forces", force.name):
            _check_arguments(force, kinds)
            own[force.name] = _primitives(force, inputs, poses)
            own[force.name] += force.weight(poses, gravity) if any(gravity) else ()
    return own


def _check_arguments(part: Any, kinds: Mapping[str, str]) -> None:
    check_connections(part)
    refuse_arguments(part, kinds)


def _primitives(part: Any, inputs: Mapping[str, Input], *given: Any) -> list[Primitive]:
    """The primitives of a driver or force, for poses and known coordinates, with the values of inputs that it names."""
    acted = with_inputs(part, inputs)
    check_texts(acted)
    primitives = list(acted.primitives(*given))
    refuse_lost(part, primitives, inputs)
    return primitives


def signals_of(model: Model) -> tuple[Signals, tuple[str, ...]]:
    """What formulas may contain in a model that has been checked, and the names of its bodies and blocks."""
    bodies, findings = _bodies(model), Findings(model.origin)
    poses = {GROUND: GROUND_POSE, **{body.name: body.pose for body in bodies}}
    known: dict[str, tuple[Coordinate, ...]] = {}
    _joints(model, poses, findings, known)
    states = _states(model, findings)
    drivers = _drivers(model, poses, findings, known, states)
    blocks, found, _ = _signals(model, poses, findings, known, states, drivers, bodies)
    others = _others(model, findings)
    return found, tuple([one.name for some in (bodies, others, blocks) for one in some])


def _loads(bodies: tuple[BodyState, ...], gravity: Vec3) -> Iterator[Piece]:
    yield from (_inertia(body) for body in bodies)
    if any(gravity):
        yield from (_weight(body, gravity) for body in bodies)


def _inertia(body: BodyState) -> Piece:
    mass, inertia, center = body.mass
    kind, at = (elements.EccentricInertia, [center]) if any(center) else (elements.RigidInertia, [])
    return Piece(body.name, Primitive(kind, (body.name,), (mass, inertia, *at), "inertia"))


def _weight(body: BodyState, gravity: Vec3) -> Piece:
    mass, _, center = body.mass
    kind, at = (elements.EccentricGravity, [center]) if any(center) else (elements.Gravity, [])
    return Piece(body.name, Primitive(kind, (body.name,), (mass, *at, gravity), "gravity"))


def check_connections(part: Any) -> None:
    """Raise a ModelError for the first field of a part that should hold a body, point or frame, but does not."""
    for field, kinds in _connections(part.__class__).items():
        value = getattr(part, field)
        if not isinstance(value, kinds):
            wanted = [WANTED[kind] for kind in kinds if kind in WANTED]
            message = " or ".join(words for words, _ in wanted)
            remedy = " or ".join(words for _, words in wanted)
            by_keyword = next(
                (name for name, own in _connections(part.__class__).items() if type(value) in own), ""
            )
            remedy = f"it as {by_keyword}=" if by_keyword else remedy
            raise ModelError(
                f"{field} must be {message}, but is {kind_of(value)}. Give {remedy}.", field=field
            )


@cache
def _connections(kind: Any) -> dict[str, tuple[type, ...]]:
    """The fields that hold bodies, points or frames, and what may stand there, as annotated."""
    try:
        hints = get_type_hints(kind)
    except (NameError, TypeError):  # the annotations of a user's class cannot be read
        return {}
    found = {field.name: _members(hints.get(field.name)) for field in fields(kind)}
    return {name: members for name, members in found.items() if set(members) & set(WANTED)}


def _members(hint: Any) -> tuple[type, ...]:
    members = () if get_origin(hint) is Sequence else get_args(hint) or (hint,)
    plain = all(isinstance(one, type) for one in members)
    return (
        tuple(one for one in members if one is not NoneType) + (NoneType,) * (NoneType in members)
        if plain
        else ()
    )


def kind_of(value: Any) -> str:
    """A value for a message: plain values as they are, anything else by its class."""
    if value is None or isinstance(value, str | bool | int | float | list | tuple | dict):
        return show(value)
    article = "an" if type(value).__name__[0] in "AEIOU" else "a"
    return f"{article} {type(value).__name__}"


def refuse_arguments(part: Any, kinds: Mapping[str, str]) -> None:
    """Refuse a function of one variable, the time or all outputs, whose argument has the name of a state or an input.

    Parameters
    ----------
    part
        A driver or a force.
    kinds
        The names of states and inputs, each with what it is, ``an input``.

    Raises
    ------
    ModelError
        With the field, and what to write.
    """
    for field, measure in measures_of(part).items() if kinds else ():
        over_time = In(measure.unit, over="s") if isinstance(part, Input) else measure
        if not over_time.outputs and over_time.over != "s":
            continue  # such as a stiffness, a function of the length alone
        given: Any = getattr(part, field, None)
        for law in given if is_list(given) else (given,):
            name = _argument(law.function if isinstance(law, Formula) else law)
            if name in kinds and name not in OWN:
                own = isinstance(part, Input) and name == part.name
                remedy = _remedy(name, "itself" if own else kinds[name], over_time)
                raise ModelError(f"{field} is a function of {name}, {kinds[name]}. {remedy}", field=field)


def _argument(law: Any) -> str:
    """The name of the only argument of a function; empty if it has several, or is one of all outputs."""
    if isinstance(law, Tree | type) or not callable(law) or has_all_outputs(law, {TIME}):
        return ""
    wanted = [*arguments(law, {TIME})]
    return wanted[0] if len(wanted) == 1 else ""


def _remedy(name: str, kind: str, measure: In) -> str:
    if measure.outputs or (measure.states and kind == "a state"):
        return f'Write lambda o: o["{name}"], or a formula, "{name}". A function of time is lambda t: ...'
    if kind == "an input":
        return f'Write "{name}" for the input, or lambda t: ... for a function of time.'
    return "Write lambda t: ... for a function of time."
