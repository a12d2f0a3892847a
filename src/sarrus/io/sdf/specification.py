"""The elements of SDF that an import uses, the notes on those that it does not use, and those that it refuses."""

POSE = "relative_to degrees rotation_format"
AXIS = {
    "": "",
    "/xyz": "expressed_in",
    "/use_parent_model_frame": "",
    "/dynamics": "",
    **{f"/dynamics/{tag}": "" for tag in ("damping", "friction", "spring_reference", "spring_stiffness")},
    "/limit": "",
    **{f"/limit/{tag}": "" for tag in ("lower", "upper", "effort", "velocity")},
    "/mimic": "joint axis",
    **{f"/mimic/{tag}": "" for tag in ("multiplier", "offset", "reference")},
}
SHAPES = {
    "box/size": "",
    "cylinder/radius": "",
    "cylinder/length": "",
    "capsule/radius": "",
    "capsule/length": "",
    "sphere/radius": "",
    "ellipsoid/radii": "",
    "mesh/uri": "",
    "mesh/scale": "",
}
GEOMETRY = "model/link/visual/geometry"
USED = {
    "sdf": "version",
    "world": "name",
    "world/gravity": "",
    "world/frame": "name attached_to",
    "world/frame/pose": POSE,
    "model": "name canonical_link placement_frame namespace",
    "model/static": "",
    "model/pose": POSE,
    "model/frame": "name attached_to",
    "model/frame/pose": POSE,
    "model/link": "name",
    "model/link/pose": POSE,
    "model/link/gravity": "",
    "model/link/inertial": "auto",
    "model/link/inertial/pose": POSE,
    "model/link/inertial/mass": "",
    "model/link/inertial/density": "",
    "model/link/inertial/inertia": "",
    **{f"model/link/inertial/inertia/{tag}": "" for tag in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")},
    "model/link/visual": "name",
    "model/link/visual/pose": POSE,
    GEOMETRY: "",
    **{f"{GEOMETRY}/{path.partition('/')[0]}": "" for path in SHAPES},
    **{f"{GEOMETRY}/{path}": "" for path in SHAPES},
    f"{GEOMETRY}/mesh": "optimization",  # of meshes for contact
    "model/link/visual/material": "",
    "model/link/visual/material/diffuse": "",
    **{
        f"{model}/joint{path}": names
        for model in ("model", "world")
        for path, names in {
            "": "name type",
            "/pose": POSE,
            **dict.fromkeys(("/parent", "/child", "/gearbox_ratio", "/gearbox_reference_body"), ""),
            **dict.fromkeys(("/thread_pitch", "/screw_thread_pitch"), ""),
            **{f"/{axis}{path}": names for axis in ("axis", "axis2") for path, names in AXIS.items()},
        }.items()
    },
}
SENSORS = "{n} sensor[s] [is|are] left out: the model has outputs by name"
PLUGINS = "{n} plugin[s] [is|are] left out: what [it does|they do] to the motion is not known"
WORLD = "{n} setting[s] of the world [is|are] left out: scene, physics engine, lights and the like"
LOOKS = "{n} setting[s] of the looks of links [is|are] left out"
SOLVER = "settings of {n} joint[s] for a physics engine are left out: joints are rigid"
DISABLED = (
    "{n} setting[s] of contact and of resting models [is|are] left out: there is no contact, and models never "
    "sleep"
)
LIMITS = "limits of {n} [axis|axes] are stored, not enforced: joints move beyond them, without a stop"
STOPS = "stiffness and dissipation of {n} joint limit[s] are left out: limits are not enforced"
START = "initial position[s] of {n} [axis|axes] [is|are] left out: give them as q0"
JOINT = {
    "physics": SOLVER,
    "sensor": SENSORS,
    **{f"{axis}/limit": LIMITS for axis in ("axis", "axis2")},
    **{f"{axis}/limit/*": STOPS for axis in ("axis", "axis2")},
    **{f"{axis}/initial_position": START for axis in ("axis", "axis2")},
}
WIND = "enable_wind of {n} [model or link|models and links] is left out: there is no wind"
NOTED = {  # a path that ends in * is that of all elements in another one which are not used
    "world/*": WORLD,
    "world/plugin": PLUGINS,
    "world/wind": "{n} wind[s] [is|are] left out: there are no forces of the air",
    "world/actor": "{n} actor[s] [is|are] left out: [it is|they are] no mechanism[s]",
    "world/state": "{n} state[s] of a world [is|are] left out: models start in the poses of their elements",
    "model/self_collide": DISABLED,
    "model/allow_auto_disable": DISABLED,
    "model/enable_wind": WIND,
    "model/plugin": PLUGINS,
    "model/gripper": "{n} gripper[s] [is|are] left out: [it needs|they need] contact",
    "model/link/self_collide": DISABLED,
    "model/link/must_be_base_link": DISABLED,
    "model/link/enable_wind": WIND,
    "model/link/kinematic": "{n} setting[s] <kinematic> [is|are] left out: links move by forces",
    "model/link/velocity_decay": "{n} setting[s] <velocity_decay> [is|are] left out: velocities do not decay",
    "model/link/inertial/auto_inertia_params": "{n} setting[s] of automatic inertias [is|are] left out",
    "model/link/inertial/fluid_added_mass": "{n} added [mass|masses] of a fluid [is|are] left out",
    "model/link/collision": "{n} collision shape[s] [is|are] left out: there is no contact",
    "model/link/sensor": SENSORS,
    "model/link/battery": "{n} [battery is|batteries are] left out",
    **{
        f"model/link/{tag}": LOOKS
        for tag in ("projector", "audio_sink", "audio_source", "light", "particle_emitter")
    },
    "model/link/visual/*": LOOKS,
    "model/link/visual/material/*": LOOKS,
    f"{GEOMETRY}/*": "{n} visual[s] [is|are] left out: planes, terrains and polygons are not drawn",
    f"{GEOMETRY}/mesh/*": "{n} setting[s] of meshes [is|are] left out: whole meshes are drawn",
    **{f"{model}/joint/{path}": message for model in ("model", "world") for path, message in JOINT.items()},
}
REFUSED = {  # what changes the motion: the word of ``ignore``, and what it is
    "model/link/kinematic": ("kinematic", "is moved by a program, not by forces"),
    "model/link/velocity_decay": ("decay", "has velocities that decay"),
    "model/link/inertial/fluid_added_mass": ("fluid", "has an added mass of a fluid"),
}
