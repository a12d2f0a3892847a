"""A flight into a hard contact: a step that is long beside the contact is no impact of any speed."""

import numpy as np
import pytest

import sarrus as sr

G = 9.81
HEIGHTS = (0.563, 2.293, 3.903, 5.0)


def ball(stiffness: float, height: float, rounding: float) -> sr.System:
    """A ball of 1 kg above a plane, on which it bounces without a loss."""
    body = sr.Body("ball", 1.0, (1e-3,) * 3, position=(0, 0, 0.05 + height))
    plane = sr.ground.frame((0, 0, 0))
    law = {"stiffness": stiffness, "rounding": rounding}
    contact = sr.SphereContact("contact", body.point(0, 0, 0), plane, radius=0.05, **law)
    return sr.System(sr.Model("ball", [body], [], [contact], gravity=(0, 0, -G)))


# Steps ended in the contact with a reversed speed, or at it with that of no flight
@pytest.mark.one_in(8)
@pytest.mark.parametrize("stiffness", [1e8, 2.8e9, 4.7e10, 1e12])
@pytest.mark.parametrize("rtol", [None, 1e-6], ids=["default", "1e-6"])
def test_no_energy_is_won_or_lost(stiffness: float, rtol: float | None) -> None:
    method = sr.Radau() if rtol is None else sr.Radau(rtol=rtol)
    for height in HEIGHTS:
        for rounding in (1e-9, 7e-6):
            for share in (1.2, 1.95, 2.45):
                until = share * np.sqrt(2 * height / G)
                run = sr.simulate(
                    ball(stiffness, height, rounding), until=until, t_eval=[0, until], method=method
                )
                z, v = run["ball"].position[-1, 2] - 0.05, run["ball"].velocity[-1, 2]
                energy = G * z + v * v / 2 + stiffness * min(z, 0.0) ** 2 / 2
                # An error e of the position in the contact is one of k δ e of k δ² / 2
                error = (rtol or 1e-9) * height * np.sqrt(2 * stiffness / (G * height))
                near = max(1e-3, min(error, 1e-2))
                assert energy == pytest.approx(G * height, rel=near), (height, rounding, share)
