"""Elements that an MJCF import leaves out: a note for each kind, or a refusal if the motion would change.

Controls are zero unless they are given, so an actuator whose force vanishes with its control is a note.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Any, NamedTuple

from ...model.errors import ModelError, listed
from ...model.show import counted
from . import loops
from .compiled import mujoco
from .loads import actuators, tendons
from .loads.actuators import active_actuators, acts_without_control, limited_lifts, muscle_obstacle
from .loads.contacts import left_out_contacts
from .loads.joints import balls_with_limit, has_nonlinear_springs
from .loops import active_equalities, springs_of_targets
from .sensors import sensors_of, unused


class Omission(NamedTuple):
    """A kind of thing: the word of ``ignore`` for it ("" where it is always left out), how many there are, and what.

    `text` has singular and plural, for `counted`; `names` are those of the file where they are known.
    """

    word: str
    number: int
    text: str
    names: Sequence[str] = ()

    def described(self) -> str:
        """Return the number and the kind, with the first names."""
        some = listed(self.names)
        return counted(f"{{n}} {self.text}", self.number) + (f" ({some})" if some else "")


def left_out(compiled: Any) -> Iterator[Omission]:
    """Yield all kinds; many have the count 0."""
    yield _named(compiled, "flex", range(compiled.nflex), "flexible [body|bodies]", "FLEX")
    yield _named(compiled, "plugins", range(compiled.nplugin), "plugin[s]", "PLUGIN")
    yielding = [k for k in range(compiled.ntendon) if not tendons.is_supported(compiled, k)]
    yield _named(compiled, "tendons", yielding, "tendon[s] with springs that yield", "TENDON")
    yield Omission("joints", has_nonlinear_springs(compiled), "joint[s] with nonlinear springs or dampers")
    text = "joint[s] with actuatorgravcomp whose actuators are limited, switched off or missing"
    yield Omission("joints", limited_lifts(compiled), text)
    unsupported = [k for k in active_equalities(compiled) if not loops.is_supported(compiled, k)]
    text = "[equality|equalities] of flexible bodies, and of tendons over several points or around shapes"
    yield _named(compiled, "equalities", unsupported, text, "EQUALITY")
    others = [k for k in active_actuators(compiled) if not actuators.is_supported(compiled, k)]
    for reason in sorted({muscle_obstacle(compiled, k) for k in others} - {""}):
        which = [k for k in others if muscle_obstacle(compiled, k) == reason]
        yield _named(compiled, "actuators", which, f"muscle[s] with {reason}", "ACTUATOR")
    others = [k for k in others if not muscle_obstacle(compiled, k)]
    acting = [k for k in others if acts_without_control(compiled, k)]
    text = "actuator[s] that [acts|act] without a control, such as motors with states of their own"
    yield _named(compiled, "actuators", acting, text, "ACTUATOR")
    yield Omission(
        "",
        len(others) - len(acting),
        "actuator[s] other than muscles and those linear in the length and rate of a joint, a tendon or a site, or "
        "with delays",
    )
    yield Omission(
        "",
        actuators.early_activations(compiled),
        "setting[s] actearly of actuators, which act on the activation of the same time; in MuJoCo on that of one "
        "time step later",
    )
    yield Omission("", balls_with_limit(compiled), "limit[s] of ball joints")
    yield Omission(
        "",
        tendons.stationary_limits(compiled),
        "inertia[s] along limited tendons whose length is stationary in the pose of the file, in place of which the "
        "mass at their sites determines the stiffness of the stop",
    )
    corners, more, touching = left_out_contacts(compiled)
    yield Omission(
        "", corners, "contact[s] with planes of shapes that are round or have more than 64 corners"
    )
    yield Omission(
        "",
        more,
        "contact[s] with torsional friction, adhesion, moving surfaces or two coefficients of sliding friction, which "
        "only [slides|slide], with the first coefficient",
    )
    yield Omission("", touching, "contact[s] of shapes with others than planes")
    held = springs_of_targets(compiled)
    yield Omission(
        "", len(active_equalities(compiled)) - held, "compliance[s] of equalities, which are rigid"
    )
    yield Omission("", held, "motion[s] of bodies that a program moves (mocap), to which springs hold others")
    supported = sensors_of(compiled)
    yield Omission(
        "",
        compiled.nsensor - len(supported),
        "sensor[s] of other kinds, relative to a frame, or with a cutoff",
    )
    noisy, delayed = unused(compiled, supported)
    yield Omission("", noisy, "noise[s] of sensors, whose outputs are exact")
    yield Omission("", delayed, "delay[s] and interval[s] of sensors, whose outputs are immediate")


def notes(compiled: Any, ignore: Collection[str], file: str) -> list[str]:
    """Return one message for each kind of thing that is left out.

    Raises
    ------
    ModelError
        For what changes the motion, unless ``ignore`` has its word.
    """
    omissions = list(left_out(compiled))
    refused = [one for one in omissions if one.number and one.word and one.word not in ignore]
    if refused:
        message = f"has {'; '.join(one.described() for one in refused)}, without which it moves differently"
        words = list(dict.fromkeys([*ignore, *(one.word for one in refused)]))
        remedy = f"Take them out of the file, or import it with ignore={words}."
        raise ModelError(f"{message}. {remedy}", part="file", where=file)
    return [f"{missing.described()}: left out" for missing in omissions if missing.number]


def _named(compiled: Any, word: str, which: Sequence[int], text: str, kind: str) -> Omission:
    """Return a kind whose members have names, those without one by their number."""
    names = [
        mujoco().mj_id2name(compiled, getattr(mujoco().mjtObj, f"mjOBJ_{kind}"), k) or f"{kind.lower()}{k}"
        for k in which
    ]
    return Omission(word, len(which), text, names)
