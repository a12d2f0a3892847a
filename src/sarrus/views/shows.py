"""``view`` and ``animate``: a model or its runs as a page, in the browser, a notebook or a file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..activity import activity, for_seconds
from ..algebra import Array
from ..model import Model, Point
from ..model.checks.arguments import CHECKS
from ..model.coordinates import by_body, number_of, slice_of
from ..model.expansion.blueprint import blueprint
from ..model.show import MOST as LISTED
from ..outputs.bodies import point_of
from ..outputs.output import labelled
from ..results import Gradient, Modes, Trajectory
from ..system import System
from .browser import Page, Scene, write_page
from .browser.page import SHORT, Curve, Influences, in_notebook
from .figures.modes import mode_title
from .film import write_film, write_picture
from .glb import write_glb
from .looks import Sketch, sketch
from .motion import MOST, SAMPLES, Frames, arrows, frames, same_signs

Trace = str | Point


def view(
    model: Model | System,
    file: str | Path | None = None,
    *,
    q: Array | None = None,
    names: bool = False,
    frames: bool = False,
) -> Page | Path:
    """Show a mechanism in three dimensions: in the browser, in a notebook, or as a file.

    Bodies are drawn by their shapes, if given, otherwise from their joints and points.

    Parameters
    ----------
    model : Model or System
    file : ``.html`` for a page that works without a network, ``.glb`` for other programs, ``.png`` for a
        picture; left out, a notebook shows the page, and elsewhere it is opened in the browser
    q : (nq,) a position, such as that of `assemble`; by default the initial position of the model
    names, frames : whether names of bodies and their frames are initially visible; the page has switches

    Returns
    -------
    Page, or the path of the file

    Raises
    ------
    ModelError
        If anything is wrong in the model, or a mesh cannot be read.
    ValueError
        If the file has an ending that cannot be written, or q the wrong length.
    """
    described = model.model if isinstance(model, System) else model
    return put(still(described, q), file, names=names, frames=frames)


def still(model: Model, q: Array | None) -> Scene:
    """A mechanism at a position, by default the model's own."""
    positions = _position(model, q)
    drawn, at = sketch(model, positions), Frames(np.zeros(1), positions, np.zeros_like(positions))
    return Scene(model.name, drawn, _drawn_frames(at, drawn))


def put(scene: Scene, file: str | Path | None, *, names: bool = False, frames: bool = False) -> Page | Path:
    """A model at rest as a page, a picture or a file for other programs, by the extension of the file."""
    ending = _ending(file, (".html", ".glb", ".png"))
    if ending == ".glb":
        return write_glb(scene, Path(str(file)))
    if ending == ".png":
        return write_picture([scene], Path(str(file)))
    return _delivered(write_page([scene], names=names, frames=frames), file)


def _position(model: Model, q: Array | None) -> Array:
    """A position of a model, by default its initial one, as the only row (1, nq)."""
    initial = blueprint(model).q
    if q is not None and np.shape(q) != initial.shape:
        raise ValueError(
            f"{model.name} has {len(initial)} coordinates, but q has {np.size(q)}. Give coordinates of this model."
        )
    return np.asarray(initial if q is None else q, dtype=float)[None]


def animate(
    run: Trajectory,
    file: str | Path | None = None,
    *,
    beside: Iterable[Trajectory] = (),
    labels: Sequence[str] = (),
    traces: Iterable[Trace] = (),
    outputs: Iterable[str] = (),
    gradient: Gradient | None = None,
    reactions: Sequence[str] | bool | None = None,
    forces: bool = True,
    weights: bool = False,
    arrows: bool = False,
    speed: float | None = None,
    names: bool = False,
    follow: str | None = None,
    count: int = MOST,
    play: bool = True,
    progress: bool | Callable[[float], None] | None = None,
) -> Page | Path:
    """Animate a run: in the browser, in a notebook, or as a file.

    Parameters
    ----------
    run : Trajectory
    file : ``.html`` for a page that works without a network, ``.glb`` for other programs, ``.gif`` or ``.mp4`` for a
        film; left out, a notebook shows the page, and elsewhere it is opened in the browser
    beside : further runs, drawn together with the first, each in one colour
    labels : names of all runs, including the first one
    traces : names of bodies (their centres of mass) and points, ``"rod(0.1, 0, 0)"``, whose paths are drawn
    outputs : names of outputs, ``"spring.tension"``, whose curves over time a page shows beside the mechanism
    gradient : of responses of the run; a page shows the largest influences as bars
    reactions : names of joints and drivers whose reactions are drawn as arrows, or True for all; by default all if
        there are few
    forces : whether the forces of springs, loads, tyres and contacts are drawn as arrows
    weights : whether the weights of bodies are drawn as arrows
    arrows : whether arrows are initially visible; the page has switches
    speed : initial speed relative to real time; by default 1, or less if the motion is fast
    names : whether names of bodies are initially visible
    follow : name of a body of the first run that the camera moves with
    count : number of frames
    play : whether the animation starts when the page is opened
    progress : while a film is drawn: True for a bar on standard error, a function of the number of pictures, or False;
        by default a bar on a terminal

    Returns
    -------
    Page, or the path of the file

    Raises
    ------
    KeyError
        If there is no such body, joint, driver or output.
    ValueError
        If the file has an ending that cannot be written, or a run holds no states or does not know its system.
    """
    for word, given in (("traces", traces), ("outputs", outputs), ("labels", labels)):
        CHECKS["variables"](word, given)
    ending, curves = _ending(file, (".html", ".glb", ".gif", ".mp4")), tuple(outputs)
    if ending == ".glb" and follow is not None:
        raise ValueError(f"{file}: this format has no camera that follows a body. Write .html, .gif or .mp4.")
    if ending != ".html" and (curves or gradient is not None):
        raise ValueError(
            f"{file}: only pages show curves of outputs and influences. "
            "Write .html, or leave out `outputs` and `gradient`."
        )
    runs = [run, *beside]
    others = (f"{other.name} ({n})" for n, other in enumerate(runs[1:], start=2))
    titles = list(labels) or [run.name, *others]
    if len(titles) != len(runs):
        raise ValueError(f"there are {len(runs)} runs, but {len(titles)} labels. Give one for each.")
    selection = ([], False, False) if ending in (".gif", ".mp4", ".glb") else (reactions, forces, weights)
    scenes = [
        _scene(motion, title, traces, selection, count) for motion, title in zip(runs, titles, strict=True)
    ]
    pairs = zip(scenes, runs, strict=True)
    scenes = [scene._replace(curves=_curves(motion, curves, scene.frames)) for scene, motion in pairs]
    if follow is not None:
        scenes[0] = scenes[0]._replace(follow=number_of(follow, run.bodies, run.name) + 1)
    if ending == ".glb":
        return write_glb(scenes[0], Path(str(file)))
    if ending in (".gif", ".mp4"):
        return write_film(scenes, Path(str(file)), speed, progress=progress)
    bars = [] if gradient is None else [_influences(gradient, n) for n in range(len(gradient.responses))]
    page = write_page(scenes, speed=speed, names=names, arrows=arrows, play=play, influences=bars)
    return _delivered(page, file)


@activity(for_seconds("drawing the motion"))
def _scene(run: Trajectory, name: str, traces: Iterable[Trace], selection: Any, count: int) -> Scene:
    """A run as it is drawn; `selection` are the reactions, forces and weights of `arrows`."""
    if run.system is None:
        message = f"{run.name}: this trajectory does not know its system, so it cannot be drawn"
        raise ValueError(f"{message}. Read a saved run with it: sarrus.load_run(folder, system).")
    at = frames(run, count)
    few = slice(None, None, max(1, len(at.q) // SAMPLES))
    drawn = sketch(run.system.model, at.q[few], at.t[few])
    paths = [_place(trace, run, drawn) for trace in traces]
    return Scene(name, drawn, _drawn_frames(at, drawn), arrows(run, at, *selection), paths)


def _drawn_frames(at: Frames, drawn: Sketch) -> Frames:
    """Return frames with the coordinates of bodies, and of roads and wheels that move, without first-order states."""
    q = same_signs(drawn.coordinates(at.t, at.q, at.v), len(drawn.bodies) + len(drawn.moving))
    return at._replace(q=q, v=at.v[:, : slice_of(len(drawn.bodies)).start])


def _curves(run: Trajectory, names: Sequence[str], at: Frames) -> list[Curve]:
    """Outputs at the times of the frames."""
    outputs = map(run.output, names)
    return [Curve(output.name, output.unit, np.interp(at.t, output.t, output.values)) for output in outputs]


def _influences(gradient: Gradient, response: int) -> Influences:
    names, changes = gradient.largest(response, LISTED)
    title = labelled(gradient.responses[response], gradient.response_units[response])
    return Influences(f"{title}, by {gradient.increment} more of", names, changes)


def _place(trace: Trace, run: Trajectory, drawn: Sketch) -> tuple[int, Array]:
    """Number of the body, and the point in its axes."""
    assert run.system is not None
    if isinstance(trace, Point):
        local = trace.resolve(run.system.model.design_poses(), "traces")
        return run.bodies.index(local.body) + 1, np.array(local.s)
    if point := point_of(run.system, trace):
        return number_of(point[0], run.bodies, run.name) + 1, np.array(point[1])
    number = number_of(trace, run.bodies, run.name)
    return number + 1, drawn.centers[number]


def _ending(file: str | Path | None, known: Sequence[str]) -> str:
    ending = ".html" if file is None else Path(file).suffix.lower()
    if ending not in known:
        raise ValueError(f"{file}: the ending must be one of {', '.join(known)}. Rename the file.")
    return ending


def _delivered(page: Page, file: str | Path | None) -> Page | Path:
    """Save a page to a file; without one open it in the browser, unless a notebook shows it."""
    if file is not None:
        return page.save(file)
    if not in_notebook():
        page.open()
    return page


FRAMES = 121
SHARE = 0.12  # of the size of the drawing: the default amplitude of the largest coordinate


def animate_mode(
    modes: Modes,
    system: System,
    mode: int = 0,
    file: str | Path | None = None,
    *,
    amplitude: float | None = None,
) -> Page | Path:
    """Play one swing of a vibration mode, without its growth or decay, again and again.

    Parameters
    ----------
    modes : Modes
    system : the system that they belong to
    mode : index, 0 for mode 1
    file : as for `animate`; left out, in the browser or the notebook
    amplitude : of the coordinate that swings most [m] or [-]; by default as much as is well seen

    Returns
    -------
    Page, or the path of the file

    Raises
    ------
    NoModeError
        If there is no such mode.
    """
    modes.refuse_unknown(mode)
    size = sketch(system.model, modes.q[None]).size
    shape = modes.shapes[:, mode] * (SHARE * size if amplitude is None else amplitude)
    period = 1 / modes.frequencies[mode] if modes.frequencies[mode] > 0 else SHORT
    t = np.linspace(0.0, period, FRAMES)
    swing = shape * np.exp(2j * np.pi / period * t)[:, None]
    q, v = modes.q + swing.real, (2j * np.pi / period * swing).real
    p = by_body(q)[..., 3:]
    p /= np.linalg.norm(p, axis=2, keepdims=True)
    title = f"{modes.name}: {mode_title(modes, mode)}"
    run = Trajectory(
        title,
        modes.bodies,
        (),
        t,
        q,
        v,
        0 * v,
        lam=np.zeros((FRAMES, 0)),
        violation=np.zeros(FRAMES),
        system=system,
    )
    options: dict[str, Any] = {"reactions": [], "forces": False, "speed": period / SHORT}
    return animate(run, file, labels=[title], count=FRAMES, **options)
