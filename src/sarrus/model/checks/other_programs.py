"""Names that users of Adams, Exudyn, MuJoCo and SciPy type, and what takes their place."""

from __future__ import annotations

from collections.abc import Container
from typing import Any

MOTION = "sr.AngleDriver, sr.DisplacementDriver or sr.PointDriver for a prescribed motion"
LOAD = "sr.PointForce at a point, sr.Force between two points or on a joint, sr.Torque on a body or joint"
STOPS = "sr.AngleStop, sr.DisplacementStop or sr.LengthStop"
SPRING = "sr.TSDA between two points, sr.RSDA about an axis"
OUTPUT = 'an output by its name, run["rod.x"], and sr.Event for what happens at its zero'
POINT = "body.point(x, y, z), or sr.Frame for a point with directions"
TYPES = {  # of parts of a model file
    "spring": "tsda",
    "hinge": "revolute",
    "prismatic": "translational",
    "ball": "spherical",
    "weld": "fixed",
}
INSTEAD = {
    "Actuator Servo": f"{MOTION}, sr.Force or sr.Torque for a force by a formula",
    "Motor": "sr.AngleDriver for a prescribed angle, sr.Torque for a torque, sr.DCMotor for an electric motor",
    "Motion MotionGenerator JointMotion": MOTION,
    "VelocityDriver SpeedDriver": 'sr.AngleDriver or sr.DisplacementDriver with a motion such as "2*t"',
    "Rail Track": "sr.Translational, sr.PointOnLine on a straight one, sr.FormulaCoupler on a curve",
    "Slider Slide PrismaticJoint TranslationalJoint CreatePrismaticJoint": "sr.Translational",
    "RevoluteJoint HingeJoint Pin CreateRevoluteJoint": "sr.Revolute",
    "SphericalJoint BallJoint CreateSphericalJoint": "sr.Spherical",
    "FixedJoint WeldJoint Weld Rigid": "sr.Fixed",
    "UniversalJoint Hooke Cardan": "sr.Universal",
    "CylindricalJoint": "sr.Cylindrical",
    "Inplane": "sr.PointOnPlane",
    "Inline": "sr.PointOnLine",
    "DistanceConstraint CreateDistanceConstraint": "sr.Distance",
    "GenericJoint CreateGenericJoint Equality Connect": "a joint with these constraints, such as sr.Spherical",
    "CoordinateConstraint": "sr.Coupler between two joints, or a driver such as sr.AngleDriver",
    "Marker Site Node": POINT,
    "RigidBody Part Link CreateRigidBody CreateMassPoint": "sr.Body",
    "Geom Geometry Mesh": "sr.Shape for a mesh; without it, a body is drawn from its joints",
    "SpringDamper CreateSpringDamper Damper Dashpot": SPRING,
    "CartesianSpringDamper CreateCartesianSpringDamper": "sr.CartesianSpring",
    "TorsionSpring TorsionalSpring RotationalSpring TorsionalSpringDamper CreateTorsionalSpringDamper": "sr.RSDA",
    "RigidBodySpringDamper CreateRigidBodySpringDamper": "sr.Bushing",
    "Load SForce GForce SingleForce AppliedForce CreateForce CreateTorque": LOAD,
    "Contact": f"sr.SphereContact of a sphere and a plane, {STOPS} for limits of joints",
    "Bistop Limit Stop": STOPS,
    "Friction": "sr.AngleFriction, sr.DisplacementFriction or sr.LuGre",
    "Tire": "sr.MagicFormulaTyre, sr.TmeasyTyre, sr.FialaTyre or sr.BrushTyre; sr.RoadTyre for the load alone",
    "Cable Rope": "sr.TSDA or sr.Force between two points",
    "Sensor Measure Request Probe": OUTPUT,
    "Gravity AccelGrav": "sr.Model(..., gravity=(0, 0, -9.81))",
    "FlexibleBody Flex BeamElement": "sr.Beam between bodies for slender parts; other bodies are rigid",
    "SystemContainer MainSystem MjModel World Multibody Mechanism": "sr.Model, and sr.System(model) for its analyses",
    "Run Solve solve_ivp odeint integrate SolveDynamic mj_step Transient": "sr.simulate",
    "Static SolveStatic mj_inverse": "sr.equilibrium for a state of rest, sr.inverse_dynamics for forces of a motion",
    "Eigenvalues Eigenmodes eig ComputeODE2Eigenvalues": "sr.modes, or sr.linearize for the matrices",
    "Minimize": "sr.optimize",
    "LeastSquares CurveFit": "sr.fit",
    "Jacobian": "sr.sensitivity, or sr.state_derivatives",
    "Plot Save Export": "methods of the result: run.plot(...), run.save(...), run.to_csv(...)",
    "Quaternion": "orientation= of sr.Body, which may be Euler parameters, a matrix, or angles",
    "Vector Vec3": "three numbers, (x, y, z)",
}
_BY_NAME = {_key: text for names, text in INSTEAD.items() for _key in names.lower().replace("_", "").split()}


def instead_of(name: str) -> str:
    """Return what takes the place of a name of another program; empty if it is not known."""
    found = _BY_NAME.get(name.lower().replace("_", ""), "")
    return f"Use {found}." if found else ""


def with_own_types(data: Any, known: Container[str] = ()) -> None:
    """Replace other names of types of joints, drivers and forces of a file, unless they are known."""
    sections = [data.get(key) for key in ("joints", "drivers", "forces")] if isinstance(data, dict) else []
    for section in sections:
        for part in section.values() if isinstance(section, dict) else ():
            if not isinstance(part, dict) or not isinstance(other := part.get("type"), str):
                continue
            if other not in known:
                part["type"] = "rsda" if other == "spring" and "axis" in part else TYPES.get(other, other)
