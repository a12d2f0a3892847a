"""What the import does with every element and attribute of MJCF: the whole schema of MuJoCo has a place here.

RESOLVED is what MuJoCo's compiler turns into poses, masses and numbers; HONOURED what the model has; NOTED what is left
out with a note; REFUSED what changes the motion and is refused unless `ignore` names it; NO_MOTION what no motion
depends on, such as colours, names, and settings of MuJoCo's solver.
"""

import re
from collections.abc import Iterator

from sarrus.io.robot.sensors import KINDS

RESOLVED, HONOURED, NOTED, REFUSED, NO_MOTION = "resolved", "honoured", "noted", "refused", "no motion"

ACTUATORS = "general", "motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle"
ELEMENTS = {  # by the beginning of the path; the longest one counts
    "mujoco": RESOLVED,
    "compiler": RESOLVED,
    "compiler/lengthrange": NO_MOTION,
    "option": NO_MOTION,
    "option/flag": NO_MOTION,
    "size": NO_MOTION,
    "statistic": NO_MOTION,
    "visual": NO_MOTION,
    "default": RESOLVED,
    "extension": REFUSED,
    "asset": RESOLVED,
    "asset/skin": NO_MOTION,
    "asset/texture": NO_MOTION,
    "asset/material": NO_MOTION,
    "body": RESOLVED,
    "body/joint": RESOLVED,
    "body/geom": RESOLVED,
    "body/geom/plugin": REFUSED,
    "body/camera": NO_MOTION,
    "body/light": NO_MOTION,
    "body/plugin": REFUSED,
    "body/flexcomp": REFUSED,
    "deformable": REFUSED,
    "deformable/skin": NO_MOTION,
    "contact": HONOURED,
    "tendon": HONOURED,
    "tendon/spatial/geom": HONOURED,
    "equality": REFUSED,
    "equality/connect": HONOURED,
    "equality/weld": HONOURED,
    "equality/joint": HONOURED,
    "equality/tendon": HONOURED,
    "actuator": REFUSED,
    **{f"actuator/{kind}": HONOURED for kind in ACTUATORS},
    "actuator/adhesion": NOTED,
    "sensor": NOTED,
    **dict.fromkeys([f"sensor/{kind}" for kind in KINDS], HONOURED),
    "custom": NO_MOTION,
    "keyframe": HONOURED,
}


def _all(verdict: str, attributes: str) -> dict[str, str]:
    return dict.fromkeys(attributes.split(), verdict)


TENDON = (
    _all(
        HONOURED,
        "actuatorfrclimited actuatorfrcrange armature class damping frictionloss limited margin name range",
    )
    | _all(HONOURED, "solimplimit solreflimit springlength stiffness")
    | _all(REFUSED, "springyield")
    | _all(NO_MOTION, "group material rgba solimpfriction solreffriction user width")
)
ACTUATOR = (
    _all(RESOLVED, "class inheritrange")
    | _all(HONOURED, "ctrllimited ctrlrange forcelimited forcerange gear group joint jointinparent")
    | _all(HONOURED, "name refsite site tendon")
    | _all(NOTED, "cranklength cranksite delay interp nsample slidersite")
    | _all(REFUSED, "armature damping")
    | _all(NO_MOTION, "lengthrange user")
)
ATTRIBUTES = {  # of elements in which each attribute is decided on by itself
    "option": _all(HONOURED, "gravity actuatorgroupdisable")
    | _all(HONOURED, "density viscosity wind")
    | _all(HONOURED, "o_margin o_friction o_solimp o_solref")
    | _all(
        NO_MOTION, "ccd_iterations ccd_tolerance cone impratio integrator iterations jacobian ls_iterations"
    )
    | _all(
        NO_MOTION, "ls_tolerance magnetic noslip_iterations noslip_tolerance sdf_initpoints sdf_iterations"
    )
    | _all(NO_MOTION, "sleep_tolerance solver timestep tolerance apirate"),
    "option/flag": _all(
        HONOURED,
        "actuation clampctrl contact filterparent constraint damper equality frictionloss gravity limit override "
        "passive refsafe spring",
    )
    | _all(
        NO_MOTION,
        "autoreset diagexact energy eulerdamp fwdinv invdiscrete ipc island midphase multiccd nativeccd",
    )
    | _all(NO_MOTION, "sensor sleep speculative warmstart"),
    "body": _all(RESOLVED, "axisangle childclass euler fuse name pos quat simple xyaxes zaxis")
    | _all(HONOURED, "gravcomp")
    | _all(NO_MOTION, "mocap sleep user"),
    "body/joint": _all(RESOLVED, "axis class name pos ref type")
    | _all(HONOURED, "armature damping frictionloss limited margin range")
    | _all(HONOURED, "solimplimit solreflimit springdamper springref stiffness")
    | _all(HONOURED, "actuatorfrclimited actuatorfrcrange")
    | _all(REFUSED, "actuatorgravcomp springyield")  # the first where actuators are limited or missing
    | _all(NO_MOTION, "group solimpfriction solreffriction user"),
    "body/geom": _all(
        RESOLVED, "axisangle class density euler fitscale fromto hfield mass mesh name pos quat"
    )
    | _all(RESOLVED, "shellinertia size type xyaxes zaxis")
    | _all(HONOURED, "fluidcoef fluidshape")
    | _all(HONOURED, "conaffinity condim contype friction gap margin priority solimp solmix solref")
    | _all(
        NOTED,
        "adhesion surfacevel",
    )
    | _all(NO_MOTION, "castshadow group material rgba user"),
    "equality/connect": _all(HONOURED, "active anchor body1 body2 class name site1 site2")
    | _all(NOTED, "solimp solref"),
    "equality/weld": _all(HONOURED, "active anchor body1 body2 class name relpose site1 site2 torquescale")
    | _all(NOTED, "solimp solref"),
    "actuator/general": ACTUATOR
    | _all(HONOURED, "actlimited actrange biasprm biastype dynprm dyntype gainprm gaintype lengthrange")
    | _all(NOTED, "actdim actearly body")
    | _all(NO_MOTION, "ffrange input velrange"),  # of a gaintype with one control; others are refused
    "actuator/motor": ACTUATOR,
    "actuator/position": ACTUATOR | _all(HONOURED, "dampratio kp kv timeconst"),
    "actuator/velocity": ACTUATOR | _all(HONOURED, "kv"),
    "actuator/intvelocity": ACTUATOR
    | _all(HONOURED, "actrange dampratio kp kv")
    | _all(NO_MOTION, "actlimited"),  # always, in MuJoCo
    "actuator/damper": ACTUATOR | _all(HONOURED, "kv"),
    "actuator/cylinder": ACTUATOR | _all(HONOURED, "area bias diameter timeconst"),
    "actuator/muscle": ACTUATOR
    | _all(HONOURED, "force fpmax fvmax lengthrange lmax lmin range scale tausmooth timeconst vmax")
    | _all(REFUSED, "forcelimited forcerange"),
    "tendon/fixed": TENDON,
    "tendon/spatial": TENDON,
    "contact/pair": _all(HONOURED, "class gap geom1 geom2 margin name solimp solref")
    | _all(NOTED, "adhesion condim friction")  # beyond one coefficient of sliding friction
    | _all(NO_MOTION, "solreffriction"),
    **{
        f"sensor/{kind}": _all(HONOURED, "joint name objname objtype site")
        | _all(NOTED, "cutoff delay interp interval noise nsample refname reftype")
        | _all(NO_MOTION, "user")
        for kind in KINDS
    },
    "equality/tendon": _all(HONOURED, "active class name polycoef tendon1 tendon2")
    | _all(NOTED, "solimp solref"),
    "equality/joint": _all(HONOURED, "active class joint1 joint2 name polycoef")
    | _all(NOTED, "solimp solref"),
}


def items(schema: str) -> Iterator[tuple[str, str]]:
    """Yield (path, attribute) of MuJoCo's printed schema, and (path, "") for the element itself."""
    path: list[str] = []
    for line in schema.splitlines():
        name = re.match(r"(?P<indent> *)(?P<name>[\w()]+) \([!?*R]\) *(?P<rest>.*)", line)
        if name:
            path = [*path[: len(name["indent"]) // 3], name["name"].replace("(world)", "")]
            yield "/".join(path[1:]) or path[0], ""
        for attribute in (name["rest"] if name else line).split():
            yield "/".join(path[1:]) or path[0], attribute


def verdict(path: str, attribute: str) -> str | None:
    """Return what the import does, None where nobody has decided."""
    if path in ATTRIBUTES and attribute:
        return ATTRIBUTES[path].get(attribute)
    parts = path.split("/")
    beginnings = ("/".join(parts[:n]) for n in range(len(parts), 0, -1))
    return next((ELEMENTS[one] for one in beginnings if one in ELEMENTS), None)
