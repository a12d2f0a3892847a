"""The class Model: the user's description of a mechanism."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Mapping, Sequence, Sized
from dataclasses import dataclass, field, replace
from typing import Any, Self

from ..deferred import renderer
from ..rendering import Display
from .bodies.body import Body
from .bodies.shape import Look, Shape
from .checks.calls import CallCheck
from .checks.findings import Findings, Origin, Path
from .drivers import Driver
from .errors import ModelError
from .expression import Expression
from .forces import Force
from .geometry.points import GROUND
from .geometry.pose import GROUND_POSE, Poses
from .joints import Joint
from .laws.formulas import Formulas
from .preparation.prepare import prepare
from .quantity import Vector
from .show import show

ONE = {"bodies": "body", "joints": "joint", "drivers": "driver", "forces": "force"}
KINDS: dict[str, type] = {"bodies": Body, "joints": Joint, "drivers": Driver, "forces": Force}


def registered_kinds() -> dict[str, Mapping[str, type]]:
    """Return the kinds of joints, drivers and forces that are registered now, by section and type."""
    return {"joints": Joint.kinds, "drivers": Driver.kinds, "forces": Force.kinds}


@dataclass(frozen=True, eq=False)
class Model(Display, metaclass=CallCheck):
    """A mechanism: bodies, joints, drivers, forces and gravity.

    Parameters
    ----------
    name
        Any short text.
    bodies
        In the order of their coordinates; the ground is not listed.
    joints, forces
        They refer to bodies by name.
    gravity
        Acceleration in global axes [m/s²].
    drivers
        Prescribed motions; they refer to joints and bodies by name.
    origin
        The file that the model was read from.
    formulas
        The parameters of that file, and the formulas that compute other parameters from them.
    rates
        Initial rates of joints, ``{"pin": 5.0, "sleeve.displacement": 0.2}`` [rad/s], [m/s], from which `assemble`
        computes the velocities of all bodies.
    outputs
        Names for formulas of outputs, ``{"gap": "slider.x - 2*crank.y"}``, which are then outputs themselves.
    """

    name: str
    bodies: Sequence[Body]
    joints: Sequence[Joint] = ()
    forces: Sequence[Force] = ()
    gravity: Vector = (0.0, 0.0, 0.0)
    drivers: Sequence[Driver] = ()
    origin: Origin | None = field(default=None, repr=False, kw_only=True)
    formulas: Formulas = field(default_factory=Formulas, repr=False, kw_only=True)
    rates: Mapping[str, float] = field(default_factory=dict, kw_only=True)
    outputs: Mapping[str, str] = field(default_factory=dict, kw_only=True)

    def __post_init__(self) -> None:
        prepare(self)

    def headline(self) -> str:
        """The name, and the number of parts."""
        counts = ((_count(parts), name) for name, parts in self.sections().items())
        return f"{self.name}: {', '.join(f'{n} {ONE[name] if n == 1 else name}' for n, name in counts if n)}"

    @property
    def parameters(self) -> Mapping[str, float]:
        """The value of every parameter of the model file, and of every coordinate of a hardpoint, in SI units."""
        return self.formulas.parameters

    @property
    def hardpoints(self) -> Mapping[str, tuple[float, float, float]]:
        """The hardpoints by name, in global axes in the design position. [m]"""
        values = self.formulas.parameters
        return {
            name: (values[f"{name}.x"], values[f"{name}.y"], values[f"{name}.z"])
            for name in self.formulas.hardpoints
        }

    @property
    def expressions(self) -> Mapping[Path, Expression]:
        """The formula of every value that is given by a formula, by its place: ``("bodies", "rod", "mass")``."""
        return self.formulas.expressions

    def where(self, name: str) -> str:
        """Return ``file:line`` of the part called ``name``, or nothing if there is no file."""
        for section, parts in self.sections().items():
            if self.origin and any(part.name == name for part in parts):
                return self.origin.where((section, name))
        return ""

    def adding(self, *parts: Body | Joint | Driver | Force) -> Self:
        """Return the model with further bodies, joints, drivers and forces.

        Raises
        ------
        TypeError
            For what is none of them.
        """
        sections, found = self.sections(), dict[str, Any]()
        for part in parts:
            section = next((name for name, kind in KINDS.items() if isinstance(part, kind)), None)
            if section is None:
                raise TypeError(
                    f"adding: each part must be a body, joint, driver or force, got {show(part)}. Leave it out."
                )
            found.setdefault(section, [*sections[section]]).append(part)
        return replace(self, **found)

    def with_parameters(self, values: Mapping[str, float | str]) -> Model:
        """Return the model with other values of parameters, and of all that follows from them by formulas.

        Parameters
        ----------
        values
            By name, in SI units or as texts with units: coordinates of hardpoints, ``{"lower_ball.z": "-55 mm"}``,
            parameters of the model file, and numbers of parts, as in ``spring.k``.

        Raises
        ------
        ModelError
            For an unknown name, or a value that is no number or in another unit.
        """
        from .written import with_parameters

        return with_parameters(self, values)

    def view(self, file: Any = None, **options: Any) -> Any:
        """Show the mechanism in three dimensions, in the browser, a notebook or a file; see `sarrus.view`."""
        return renderer().view(self, file, **options)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model to a file, from which `load` reads the same model, to the last bit.

        Where the model is from a file, and only values differ, the new file has the comments and the order of the old
        one. Otherwise it has all parts, with the formulas of parameters, and those of included files.

        Parameters
        ----------
        path
            A file whose name ends in ``.yaml``, ``.yml`` or ``.json``; one that is there is replaced. With another
            ending, such as ``.xml``, it is written for another program; see `sarrus.export`.

        Raises
        ------
        ModelError
            If anything is wrong in the model, a file cannot describe one of its parts (as a Python function of
            operations that formulas do not have), or the file cannot be written.
        """
        from .file.save import save

        save(self, path)

    def unwritten(self) -> tuple[str, ...]:
        """Return what the model has and a model file cannot contain, for a warning of `save`."""
        return ()

    def design_poses(self) -> Poses:
        """Return the poses of the ground and of all bodies in the design position, by name."""
        return {GROUND: GROUND_POSE, **{body.name: body.pose() for body in self.bodies}}

    def looks(self) -> list[Look]:
        """The shapes of bodies, if given.

        Raises
        ------
        ModelError
            If the numbers of a shape are wrong.
        """
        looks = []
        with Findings(self.origin) as findings:
            for body in self.bodies:
                with findings.about("bodies", body.name):
                    shape: object = body.shape
                    if not isinstance(shape, Shape | None):
                        message = f"shape must be a sarrus.Shape, but is a {type(shape).__name__}. Give one."
                        raise ModelError(message, field="shape")
                    if body.shape is not None:
                        looks.append(body.shape.look(body.name, self.folder_of(body.name)))
        return looks

    def folder_of(self, body: str) -> pathlib.Path:
        """Return the folder of the file that a body was read from; the present one if there is no file."""
        if self.origin is None:
            return pathlib.Path()
        return pathlib.Path(self.origin.files.get(("bodies", body), self.origin.file)).parent

    def sections(self) -> dict[str, Sequence[Body | Joint | Driver | Force]]:
        """Return the bodies, joints, drivers and forces under these names."""
        return {"bodies": self.bodies, "joints": self.joints, "drivers": self.drivers, "forces": self.forces}


def _count(parts: object) -> int:
    """Return the number of parts; None if the input is no sequence."""
    return len(parts) if isinstance(parts, Sized) else 0
