"""The paper's Tables 1 to 6 as text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

KINEMATIC = ("Phi_q", "Phi_qT_lam_q", "Phi_q_xi_q", "gamma_q", "gamma_v")
FORCE = ("Q_q", "Q_v", "M_a_q")
HEADINGS = {"Phi_q_xi_q": "(Phi_q v)_q", "Phi_qT_lam_q": "(Phi_qT lam)_q", "M_a_q": "(M a)_q"}


def paper_tables(experiments: Sequence[Any], steps: Sequence[float]) -> str:
    """Tables 1 to 3 for the first mechanism, 4 to 6 for the second."""
    text = [_tables(found, steps, 3 * place + 1) for place, found in enumerate(experiments)]
    return "\n\n".join(text)


def _tables(found: Any, steps: Sequence[float], first: int) -> str:
    counts = ", ".join(f"{value} {key.replace('_', ' ')}" for key, value in found.counts.items())
    parts = [
        f"{found.name}: {counts}",
        f"Table {first}. Constraint derivatives: largest relative difference from finite differences",
        _differences(found, steps, KINEMATIC),
        f"Table {first + 1}. Force and inertia derivatives: largest relative difference from finite differences",
        _differences(found, steps, FORCE),
        f"Table {first + 2}. Time of one evaluation in µs, called from compiled code",
        _times(found),
    ]
    return "\n".join(parts)


def _differences(found: Any, steps: Sequence[float], names: Sequence[str]) -> str:
    lines = ["  step   " + "".join(f"{HEADINGS.get(name, name):>18}" for name in names)]
    lines.append("  " + " " * 7 + "".join(f"{'forward  central':>18}" for _ in names))
    for n, step in enumerate(steps):
        pairs = [
            (found.differences["forward"][name][n], found.differences["central"][name][n]) for name in names
        ]
        lines.append(f"  {step:<7.0e}" + "".join(f"  {a:>7.0e}  {b:>7.0e}" for a, b in pairs))
    return "\n".join(lines)


def _times(found: Any) -> str:
    lines = [f"  {'':<11}{'':>9}{'central differences':>24}{'forward':>10}{'speed-up over':>22}"]
    lines.append(
        f"  {'group':<11}{'exact':>9}{'shared':>12}{'one by one':>12}{'':>10}{'central':>12}{'forward':>10}"
    )
    for name, t in found.times.items():
        times = (
            f"{1e6 * t.exact:>9.3f}{1e6 * t.shared:>12.1f}{1e6 * t.separate:>12.1f}{1e6 * t.forward:>10.1f}"
        )
        lines.append(f"  {name:<11}{times}{t.speedup:>12.0f}{t.speedup_forward:>10.0f}")
    return "\n".join(lines)
