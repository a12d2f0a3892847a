"""Reports of workspaces as text: results and their certainty."""

from __future__ import annotations

import numpy as np

from ...outputs.units import product
from ...results.maps.workspace import Component, CurveKind, Workspace

DESCRIPTIONS: dict[CurveKind, str] = {
    "outer": "Boundary",
    "void": "Boundaries of voids",
    "barrier": "Barriers inside, which motion can meet from one side only",
    "crossable": "Singular, but no impediment",
}
MOST = 6  # causes that are listed


def area_unit(found: Workspace) -> str:
    """The unit of the area, and of the size of parts."""
    return product(*((unit, 1) for unit in found.units))


def workspace_report(found: Workspace) -> str:
    """Return a report as text: area, parts, voids, barriers with their causes, tests, work."""
    tested = [found.verification] if found.verification else []
    if not found.success:
        text = f"{found.name}: what {' and '.join(found.outputs)} can reach is not known"
        return "\n".join([f"{text}. {as_text(found.name, found.message)}", *map(str, tested)])
    unit = area_unit(found)
    perimeter = (
        f", perimeter {found.perimeter:.9g} {found.units[0]}" if found.units[0] == found.units[1] else ""
    )
    lines = [
        f"{found.name}: {' and '.join(found.outputs)} can reach {found.area:.9g} {unit} "
        f"(± {found.area_error:.1g}){perimeter}.",
        _parts(found, unit),
        *(_causes(found, kind) for kind in DESCRIPTIONS),
        as_text(found.name, found.message),
        str(found.verification or "It was not tested by random positions; see sarrus.verify."),
    ]
    return "\n".join(line for line in lines if line)


def as_text(name: str, message: str) -> str:
    """A message without the name of the model in front."""
    text = message.removeprefix(f"{name}: ")
    return f"{text[0].upper()}{text[1:]}."


def _parts(found: Workspace, unit: str) -> str:
    """The connected components, and the one that contains the model."""
    count = len(found.components)
    if count == 0:
        return ""
    if count == 1:
        return "The region is connected."
    lines = [f"The region has {count} components; no motion leads from one to another, only a new assembly:"]
    lines += [f"  {n}: {_part(found, part, unit)}" for n, part in enumerate(found.components, 1)]
    where = "none of them" if found.drawn is None else f"component {found.drawn + 1}"
    return "\n".join([*lines, f"The model as drawn is in {where}."])


def _part(found: Workspace, part: Component, unit: str) -> str:
    corners = np.concatenate(part.loops)
    ends = zip(found.outputs, corners.min(axis=0), corners.max(axis=0), found.units, strict=True)
    text = ", ".join(f"{name} from {low:.4g} to {high:.4g} {of}" for name, low, high, of in ends)
    return f"{part.area:.6g} {unit}, {text}"


def workspace_rows(found: Workspace) -> list[tuple[str, ...]]:
    """Parts with their areas and the ranges of both outputs, then the curves by kind and cause with their lengths."""
    rows: list[tuple[str, ...]] = []
    for n, part in enumerate(found.components, 1):
        corners = np.concatenate(part.loops)
        ranges = zip(corners.min(axis=0), corners.max(axis=0), strict=True)
        text = (f"{low:.6g} to {high:.6g}" for low, high in ranges)
        rows.append((f"component {n}", f"{part.area:.6g} {area_unit(found)}", *text))
    for kind, description in DESCRIPTIONS.items():
        for cause, length in _totals(found, kind):
            rows.append((f"{description.partition(',')[0].lower()}: {cause}", f"{length:.4g}", "", ""))
    return rows


def _causes(found: Workspace, kind: CurveKind) -> str:
    """Lengths of the curves of one kind by their causes, the longest first."""
    listed = _totals(found, kind)
    if not listed:
        return ""
    text = "; ".join(f"{cause} ({length:.4g})" for cause, length in listed[:MOST])
    more = f"; and {len(listed) - MOST} others" if len(listed) > MOST else ""
    return f"{DESCRIPTIONS[kind]}, by cause and length: {text}{more}."


def _totals(found: Workspace, kind: CurveKind) -> list[tuple[str, float]]:
    """Lengths of the curves of one kind by their causes, the longest first."""
    totals: dict[str, float] = {}
    for curve in found.curves:
        if curve.kind == kind and not curve.again:
            totals[curve.cause] = totals.get(curve.cause, 0.0) + curve.length
    return sorted(totals.items(), key=lambda item: -item[1])
