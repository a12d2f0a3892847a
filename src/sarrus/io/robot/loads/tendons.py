"""Springs, dampers, dry friction, limits and inertia of tendons, as forces by formulas."""

from __future__ import annotations

from ....model import Tendon
from ....model.forces import Force
from ..description import TendonForces
from ..tree.coordinates import Coordinates
from .dynamics import CREEP

REMEDY = 'Import it with ignore=["tendons"].'
STRETCH = "(max(x - longest, 0) + min(x - shortest, 0))"
OF_ONE_LENGTH = "(x - longest)"  # without corners, at which steps would end
TERMS = {
    "stiffness": f"- stiffness*{STRETCH}",
    "stiffness_2": f"- stiffness_2*{STRETCH}^2",
    "stiffness_3": f"- stiffness_3*{STRETCH}^3",
    "damping": "- damping*v",
    "damping_2": "- damping_2*v*abs(v)",
    "damping_3": "- damping_3*v^3",
    "friction": "- friction*tanh(v/creep)",
    "stop": "- stop*(max(x - upper, 0)*max(1 + loss*v, 0) - max(lower - x, 0)*max(1 - loss*v, 0))",
}
NAMES = {"stop": ("loss", "lower", "upper")} | dict.fromkeys(
    ("stiffness", "stiffness_2", "stiffness_3"), ("shortest", "longest")
)
LENGTHS = ("shortest", "longest", "lower", "upper")


def tendon_force(name: str, given: TendonForces, coordinates: Coordinates) -> Force | None:
    """Return the force of a tendon, None if its length is constant."""
    laid = coordinates.lay(given.path, REMEDY)
    if laid is None:
        return None
    terms = [word for word in TERMS if getattr(given, word)]
    parameters = {one: getattr(given, one) for word in terms for one in (word, *NAMES.get(word, ()))}
    parameters |= {one: parameters[one] - laid.start for one in LENGTHS if one in parameters}
    if "friction" in terms:
        parameters["creep"] = CREEP
    value = " ".join(TERMS[word] for word in terms)
    if given.shortest == given.longest:
        value = value.replace(STRETCH, OF_ONE_LENGTH)
        parameters.pop("shortest", None)
    return Tendon(name, **laid.fields, value=value or None, parameters=parameters, inertia=given.inertia)
