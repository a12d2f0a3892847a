"""Workspaces in words: what was found, and how sure that is."""

from __future__ import annotations

from ..results.workspace import CurveKind, Workspace

TOLD: tuple[CurveKind, ...] = ("outer", "void", "barrier", "crossable")


def area_unit(found: Workspace) -> str:
    return "m²" if found.units == ("m", "m") else "rad²" if found.units == ("rad", "rad") else "m rad"


def workspace_report(found: Workspace) -> str:
    """What was found, in words: area, parts, voids, barriers with their causes, tests, work."""
    unit = area_unit(found)
    lines = [
        f"{found.name}: {' and '.join(found.outputs)} can reach {found.area:.9g} {unit} "
        f"(± {found.area_error:.1g}), perimeter {found.perimeter:.9g}.",
        _parts(found, unit),
        *(_causes(found, kind) for kind in TOLD),
        found.message + ".",
        str(found.verification or "It was not tested by random positions; see verify_workspace."),
    ]
    if found.effort:
        e = found.effort
        lines.append(
            f"Work: {e.points} points of curves, {e.newton_steps} Newton steps, {e.starts} starts, "
            f"{len(found.curves)} parts of curves."
        )
    return "\n".join(line for line in lines if line)


def _parts(found: Workspace, unit: str) -> str:
    count = len(found.components)
    if count == 1:
        return "It hangs together in one part."
    areas = ", ".join(f"{part.area:.6g}" for part in found.components)
    return f"It falls into {count} parts that do not hang together, of {areas} {unit}."


def _causes(found: Workspace, kind: str) -> str:
    """Lengths of the curves of one kind by their causes, the longest first."""
    totals: dict[str, float] = {}
    for curve in found.curves:
        if curve.kind == kind and not curve.again:
            totals[curve.cause] = totals.get(curve.cause, 0.0) + curve.length
    if not totals:
        return ""
    listed = sorted(totals.items(), key=lambda item: -item[1])
    told = ", ".join(f"{cause} ({length:.4g})" for cause, length in listed[:6])
    more = f", and {len(listed) - 6} others" if len(listed) > 6 else ""
    words = {
        "outer": "Boundary",
        "void": "Voids",
        "barrier": "Barriers inside",
        "crossable": "Can be crossed",
    }
    return f"{words[kind]} by cause and length: {told}{more}."
