"""A simulated motion: plain arrays over time, with names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ...algebra import Array
from ...deferred import estimator, renderer, saver
from ...elements.element import POSITION
from ...model.checks.arguments import CHECKS, checked
from ...model.read_only import read_only
from ...outputs import outputs_of
from ...outputs.motion import Series, series
from ...outputs.output import UnknownOutput, components, short, unknown_output
from ...system import JointCoordinates, System
from ..result import Result, values_of
from ..saving.exported_file import exports
from .energy_balance import EnergyBalance, energy_balance
from .events import EventRecord
from .part_motion import PartMotion
from .parts import BodyMotion, JointMotion, Reaction, reaction
from .solution import NoSolution, Solution, State
from .steps import Segments, StepsTaken
from .tables import columns, quoted, to_frame, to_xarray

ENERGIES = ("kinetic_energy", "potential_energy")
COLUMNS = ("t", "q", "v", "a", "lam", "violation", "velocity_violation", *ENERGIES, "memory", "revolutions")
# Fields that a run computes when somebody looks at them; the last ones are not computed with positions and velocities
LAST = ("a", "lam", *ENERGIES, "singular", "message")
COMPUTED = (*COLUMNS[1:], "singular", "message", "final")


class Later(Protocol):
    """Outputs of a run that are computed when somebody looks at them."""

    @property
    def lock(self) -> AbstractContextManager[Any]:
        """Held while they are taken."""

    def fields(self, name: str) -> dict[str, Any]:
        """One of `COMPUTED` by its name, and all that are computed so far."""


WITHOUT_SYSTEM = (
    "This run has no system, and so coordinates of bodies only. Use sarrus.load_run(folder, system)."
)


@dataclass(frozen=True, eq=False)
class Trajectory(Result):
    """A motion: the states at the times t, with fields named as in SciPy, time along the first axis.

    Attributes
    ----------
    t : (nt,) [s]
    q, v, a : (nt, nq)
    lam : (nt, m) joint multipliers, then those of the normalizations
    success, status, message : whether the end was reached; if not, one message with the reason
    nfev : evaluations of the equations of motion
    njev, nlu : matrices of their derivatives formed, matrices factored
    nsteps, nrejected : steps accepted and rejected
    history : (nsteps, 5) for each step: end time, length, error estimate (1 is the tolerance), Newton iterations, and
        rejected steps before it
    events : the events in the order of time
    restitutions : of all impacts, ``bounce.restitution``, including those that did not occur
    sol : the motion at any time, if requested: `Solution`
    joints : angles and displacements of the system, which `joint` evaluates
    violation, velocity_violation : (nt,) largest entry of |Φ| and of |Φ_q v + Φ_t|
    kinetic_energy, potential_energy : (nt,) potential of gravity, springs, also with laws for their stiffness, and
        bushings [J]; contacts, stops, tyres and loads are left out
    singular : times at which a driven motion passed a singular configuration, or a simulated one came close to one [s]
    system : the system that moved, for its reactions
    steps : all steps, if they were stored
    steps_folder : of a run that was loaded without the steps stored in it, the folder
    memory : (nt, k) state variables of elements at the times, see `State`
    revolutions : (nt, nc) of the joints' angles at the times, counted from step to step, see `State`
    warnings : those of states that are not computed yet follow when they are; `strict` computes all at once
    final : the state at the end of the run; later than the last of the times only if `t_eval` ends before `until`
    analysis : "simulation", "kinematics" or "inverse dynamics"
    states : of a run that was loaded without its system, its first-order states: place, unit, and v or q
    """

    name: str
    bodies: tuple[str, ...]
    coordinate_names: tuple[str, ...] = field(repr=False)
    t: Array = field(repr=False)
    q: Array = field(repr=False)
    v: Array = field(repr=False)
    a: Array = field(repr=False)
    lam: Array = field(repr=False)
    violation: Array = field(repr=False)
    success: bool = True
    status: str = "finished"
    message: str = field(default_factory=str)
    nfev: int = 0
    njev: int = 0
    nlu: int = 0
    nsteps: int = 0
    nrejected: int = 0
    history: Array = field(default_factory=lambda: np.zeros((0, 5)), repr=False)
    events: tuple[EventRecord, ...] = ()
    restitutions: Mapping[str, float] = field(default_factory=dict, repr=False)
    sol: Solution | NoSolution = field(default=NoSolution(), repr=False, compare=False)
    velocity_violation: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    kinetic_energy: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    potential_energy: Array = field(default_factory=lambda: np.zeros(0), repr=False)
    joints: JointCoordinates | None = field(default=None, repr=False, compare=False)
    singular: tuple[float, ...] = field(default_factory=tuple)
    system: System | None = field(default=None, repr=False, compare=False)
    steps: StepsTaken | Segments | None = field(default=None, repr=False, compare=False)
    steps_folder: str = field(default="", repr=False, compare=False)
    memory: Array = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    revolutions: Array = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    final: State | None = field(default_factory=lambda: None, repr=False)
    analysis: str = field(default="simulation", repr=False)
    states: Mapping[str, tuple[int, str, str]] = field(default_factory=dict, repr=False, compare=False)
    _later: Later | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        if self._later:
            for name in COMPUTED:
                if self.__dict__[name] is None:
                    del self.__dict__[name]
        if not len(self.t) and not self.success:
            for name in COLUMNS:
                object.__setattr__(self, name, values_of(self, getattr(self, name)))

    def __getattr__(self, name: str) -> Any:  # of fields that are not computed yet
        known = self.__dict__
        if name in COMPUTED and (later := known.get("_later")):
            with later.lock:
                try:
                    fields = later.fields(name)
                except AttributeError as wrong:  # which Python would report as a missing field
                    raise RuntimeError(f"{self.name}: {name} could not be computed: {wrong}") from wrong
                known.update({field: x for field, x in fields.items() if field not in known})
                if "message" in fields:  # all are computed
                    known["warnings"] = tuple(dict.fromkeys((*known["warnings"], *fields["warnings"])))
                    known["_later"] = None
        if name not in known:
            raise AttributeError(
                f"{type(self).__name__!r} object has no attribute {name!r}", name=name, obj=self
            )
        return known[name]

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *COMPUTED]

    def __getstate__(self) -> dict[str, Any]:
        for name in COMPUTED:
            getattr(self, name)
        return super().__getstate__()

    def summary(self) -> str:
        """The outcome in one line."""
        reached = f"t = {self.t[-1]:g} s in {self.nsteps} steps" if len(self.t) else "there is no motion"
        message = self.message if self.message.startswith(self.name) else f"{self.name}: {self.message}"
        gap = f", |Φ| < {max(self.violation.max(), 1e-16):.0e}" if len(self.violation) else ""
        return f"{message}; {reached}{gap}; bodies {', '.join(self.bodies)}"

    def __getitem__(self, name: str) -> Any:
        """The motion of a body, a `BodyMotion`; what another part has, a `PartMotion`; the values of an output.

        ``run["slider"].velocity``, ``run["spring"].tension``, ``run["rod(0.1, 0, 0)"].acceleration``,
        ``run["spring.tension"]`` (nt,), ``run["2*slider.x - rod.y"]`` (nt,), ``run["pin.force"]`` (nt, 3).

        Raises
        ------
        KeyError
            If there is none of them.
        """
        if name in self.bodies:
            return BodyMotion(self, name)
        known = outputs_of(self.system, name) if self.system is not None and isinstance(name, str) else ()
        outputs = list(known)
        if outputs and all(one.name != name for one in outputs):  # of a state variable its value
            return PartMotion(self, name, outputs)
        try:
            columns = [self.output(one).values for one in self.components(name)]
        except UnknownOutput:
            if not name.isidentifier() or not self.bodies:
                raise
            return BodyMotion(self, name)  # which names the nearest
        return values_of(self, columns[0] if len(columns) == 1 else np.column_stack(columns))

    def components(self, name: str) -> list[str]:
        """The names of the components of a vector, ``pin.force``; the name of an output itself."""
        return [name] if self.system is None else components(self.system, name)

    def _ipython_key_completions_(self) -> list[str]:
        names = [one.name for one in outputs_of(self.system)] if self.system else []
        return [*dict.fromkeys([name.partition(".")[0] for name in names] + names)]

    @checked
    def joint(self, name: str) -> JointMotion:
        """Return the angles and displacements of a joint with their rates; revolutions are counted.

        Raises
        ------
        KeyError
            If there is no joint of this name that has any.
        """
        if self.joints is None:
            message = f"this trajectory of {self.name} was made without joints"
            raise KeyError(f"{message}. Read a saved run with its system: sarrus.load_run(folder, system).")
        values, rates = self.joints.along(self.t, self.q, self.v, self.revolutions)
        names = {own: self.joints.index(f"{name}.{own}") for own in self.joints.of_joint(name)}
        of = ({own: values_of(self, array[:, n]) for own, n in names.items()} for array in (values, rates))
        return JointMotion(name, *of)

    @checked
    def state(self, t: float) -> State:
        """Return the state at a time of `t` or at the end, as a start of analyses; any time with ``store="dense"``.

        Raises
        ------
        ValueError
            For a time at which the state was not stored.
        """
        if self.final is not None and t == self.final.t:
            return self.final
        if self.sol:
            state: State = read_only(self.sol(float(t)))
            return state
        rows = np.flatnonzero(self.t == t)
        if not len(rows):
            raise ValueError(
                f"{self.name}: no state was stored at t = {t!r} s. Choose one of `t`, or "
                "simulate with store='dense'."
            )
        names = ("q", "v", "a", "lam", "memory", "revolutions")
        n, arrays = int(rows[0]), (getattr(self, name) for name in names)
        return State(float(t), *(array[n] if len(array) else np.zeros(0) for array in arrays))

    def at(self, times: Array) -> Trajectory:
        """Return the trajectory at some of its times `t`."""
        keep = np.isin(self.t, times)
        arrays = {n: getattr(self, n)[keep] for n in COLUMNS if len(getattr(self, n)) == len(self.t)}
        return replace(self, **arrays)

    @property
    def total_energy(self) -> Array:
        """Kinetic and potential energy (nt,), without the energy in contacts, stops and tyres. [J]"""
        return values_of(self, self.kinetic_energy + self.potential_energy)

    @checked
    def coordinate(self, name: str) -> Array:
        """Return the values of `output` (nt,): ``slider.x`` (for ``slider.r.x``), ``crank.e0``, ``pin.angle``."""
        return self.output(name).values

    def reaction(self, joint: str) -> Reaction:
        """Return the reaction of a joint or driver: force and torque on its second body over time.

        Raises
        ------
        KeyError
            If there is no such joint or driver.
        ValueError
            If the trajectory does not know its system.
        """
        self._refuse_without_system("reactions")
        CHECKS["name"]("joint", joint)
        found = reaction(self, joint)
        names = ("t", "point", "force", "torque")
        arrays: dict[str, Any] = {name: values_of(self, getattr(found, name)) for name in names}
        return replace(found, **arrays)

    def _refuse_without_system(self, what: str) -> None:
        if self.system is None:
            message = f"{self.name}: this trajectory does not know its system, so it has no {what}"
            raise ValueError(f"{message}. Read a saved run with it: sarrus.load_run(folder, system).")

    def output(self, name: str, *, rate: bool = False) -> Series:
        """Return an output over time, ``spring.tension``, or its rate of change; `outputs_of` lists them.

        Raises
        ------
        UnknownOutput
            If there is no such output, which is a KeyError, too.
        """
        if self.system is not None:
            found = series(self.system, self, name, rate=rate)
            return replace(found, values=values_of(self, found.values), run=self)
        if name in self.states:
            place, unit, kind = self.states[name]
            values, rates = (self.q, self.v) if kind == "q" else (self.v, self.a)
            return Series.of(name, unit, self.t, np.asarray((rates if rate else values)[:, place]), rate)
        try:
            place = place_of(name, self.coordinate_names, self.name)
        except UnknownOutput as unknown:
            raise UnknownOutput(f"{unknown} {WITHOUT_SYSTEM}") from None
        unit = "m" if self.coordinate_names[place].endswith(POSITION.parts) else "1"
        values = self.v if rate else self.q
        return Series.of(name, unit, self.t, np.asarray(values[:, place]), rate)

    def error(self, responses: Any) -> Any:
        """Estimate the global error of responses, from the local errors of the steps and the adjoint.

        Parameters
        ----------
        responses : one or several, as for `sensitivity`: names of outputs stand for their final values

        Returns
        -------
        ErrorEstimate
            of one response; a tuple of them for several

        Raises
        ------
        ValueError
            If the run stored no steps, or failed, and for a response that is not a number.
        """
        found = estimator()(self, responses)
        several = isinstance(responses, Sequence) and not isinstance(responses, str)
        return found if several else found[0]

    @checked
    def save(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Write the run to a folder, ``"drop.sarrus"``, from which `sarrus.load_run` reads it.

        The states at the output times, the final state and the events are saved, not the continuous motion and the
        stored steps. Saving while the run is computed, ``simulate(..., save=path)``, also saves these, and survives a
        crash.

        Parameters
        ----------
        path : a folder that does not exist or is empty
        overwrite : whether a saved run that is there is replaced

        Raises
        ------
        TypeError
            For a path that is none.
        ValueError
            If the trajectory does not know its system, or has no states.
        SarrusError
            If something else is there (also a FileExistsError), or the folder cannot be written (also an OSError).
        """
        self._refuse_without_system("model to save")
        if not len(self.t):
            raise ValueError(f"{self.name}: this run has no states to save. {self.message}")
        saver()(self, path, overwrite=overwrite)

    @exports
    def to_csv(self, path: str | Path, *outputs: str) -> None:
        """Write outputs over time, ``"spring.tension"``, with the time in the first column and units in the header.

        By default those of `to_frame`; without a system the coordinates.
        """
        found = [one for one in columns(self, outputs) if one.name != "t"]
        header = ",".join(map(quoted, ["t [s]", *(one.label for one in found)]))
        table = np.column_stack([self.t, *(one.values for one in found)]) + 0.0  # no -0
        np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.15g")

    def to_frame(self, *outputs: str) -> Any:
        """Return outputs over time as a pandas DataFrame, whose index is the time; needs the extra `tables`.

        By default the motion of bodies and joints, reactions, what forces do, and energies. Columns are labels with
        units; ``frame.attrs["units"]`` has the units.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        return to_frame(self, outputs)

    def to_xarray(self, *outputs: str) -> Any:
        """Return outputs over time as an xarray Dataset with units as attributes; needs the extra `tables`.

        Raises
        ------
        ImportError
            If xarray is not installed.
        """
        return to_xarray(self, outputs)

    @exports
    def to_parquet(self, path: str | Path, *outputs: str) -> None:
        """Write the table of `to_frame` as a Parquet file; needs the extra `tables`.

        Raises
        ------
        ImportError
            If pandas or pyarrow is not installed.
        """
        self.to_frame(*outputs).to_parquet(path)

    def plot(self, *names: str, ax: Any = None, rates: bool = False, over: str | None = None) -> Any:
        """Draw outputs over time, or over another output; see `sarrus.views.plot`."""
        return renderer().plot(self, *names, ax=ax, rates=rates, over=over)

    def plot_phase(self, name: str, ax: Any = None) -> Any:
        """Draw the rate of an output over the output; see `sarrus.views.plot_phase`."""
        return renderer().plot_phase(self, name, ax)

    def plot_energies(self, ax: Any = None) -> Any:
        """Draw kinetic, potential and total energy over time; see `sarrus.views.plot_energies`."""
        return renderer().plot_energies(self, ax)

    def energy_balance(self) -> EnergyBalance:
        """Return the stored energy, and the energy that each part dissipated and supplied since the start.

        Raises
        ------
        UnknownOutput
            If the motion between the stored times is not known.
        ValueError
            If the trajectory does not know its system.
        """
        self._refuse_without_system("energy balance")
        return energy_balance(self)

    def plot_violation(self, ax: Any = None) -> Any:
        """Draw how far constraints are violated over time; see `sarrus.views.plot_violation`."""
        return renderer().plot_violation(self, ax)

    def plot_steps(self, ax: Any = None) -> Any:
        """Draw the length of the steps over time; see `sarrus.views.plot_steps`."""
        return renderer().plot_steps(self, ax)

    def animate(self, file: Any = None, **options: Any) -> Any:
        """Play the motion in three dimensions, in the browser, a notebook or a file; see `sarrus.animate`."""
        return renderer().animate(self, file, **options)


def place_of(name: str, coordinate_names: Sequence[str], owner: str) -> int:
    """Place in q of a coordinate given by its short or full name, where the system is not known.

    Raises
    ------
    UnknownOutput
        If there is none.
    """
    known = [short(full) for full in coordinate_names]
    for names in (known, coordinate_names):
        if name in names:
            return names.index(name)
    raise unknown_output(owner, name, known)
