"""The bodies of a robot: body frames are link frames, so the centre of mass is elsewhere."""

from __future__ import annotations

from collections.abc import Mapping

from ...model.bodies.body import Body
from ...model.errors import ModelError
from ...model.geometry.pose import Pose
from ...model.show import quote
from .description import Description, Edge, Inertial
from .given_body import GivenBody
from .merge import Merged
from .options import InertiaOption


def bodies_of(
    description: Description,
    inertia: InertiaOption,
    merged: Merged,
    names: Mapping[str, str],
    poses: Mapping[str, Pose],
) -> tuple[Body, ...]:
    """Return a checked body for every link that heads others.

    Raises
    ------
    ModelError
        If a body has no mass, or an inertia that no body can have.
    """
    if not merged.edges:
        urdf = description.file.lower().endswith(".urdf")
        remedy = 'import it with base="floating", or give it' if urdf else "give a body"
        message = f"nothing in it moves; {remedy} a joint that moves"
        raise ModelError(message, part="robot", where=description.file)
    kind = Body if inertia == "check" else GivenBody
    bodies = []
    for edge in merged.edges:
        name, link = names[edge.child], description.links[edge.child]
        try:
            body = _body(kind, name, _inertial(merged, edge), poses[name])
            body.mass_properties()
        except ModelError as error:
            remedy = ', or take it as it is: inertia="given"' if error.field == "inertia" else ""
            part, where = f"link {quote(link.name)}", description.where(link.line)
            raise ModelError(error.message + remedy, part=part, field=error.field, where=where) from None
        bodies.append(body)
    return tuple(bodies)


def _body(kind: type[Body], name: str, inertial: Inertial, pose: Pose) -> Body:
    return kind(name, inertial.mass, inertial.tensor, pose.r, pose.p, inertial.center)


def _inertial(merged: Merged, edge: Edge) -> Inertial:
    inertial = merged.inertials.get(edge.child)
    if inertial is None or inertial.mass == 0:
        remedy = f"give it an inertial, or stop the joint that moves it, lock=[{quote(edge.name)}]"
        raise ModelError(f"moves, but neither it nor what is fixed to it has mass; {remedy}", field="mass")
    return inertial
