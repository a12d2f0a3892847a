"""Tyre laws written a second time, in plain Python with branches: what the laws of the package are compared with.

`magic_formula` follows Pacejka and Besselink, Tire and Vehicle Dynamics, 3rd edition, 2012, section 4.3.2, with the
pressure of Besselink, Schmeitz and Pacejka (Vehicle System Dynamics 48, sup1, 2010), and 5.2 of the 2nd edition. Turn
slip is that of section 4.3.3 of the book, written with its φ = -(ψ̇ + (1 - ε) Ω sin γ)/V for axes whose z is upwards, so
that S_Hyφ and D_rφ have a minus in front, as in MBSim's MagicFormula62 (LGPL; read, not copied).
`fiala`, `brush` and `tmeasy` follow the sources of the package's files of the same names.
"""

from math import acos, atan, copysign, cos, exp, hypot, pi, sin, sqrt, tan
from typing import Any

FACTORS = """
LFZO LCX LMUX LEX LKX LHX LVX LCY LMUY LEY LKY LKYC LKZC LHY LVY LTR LRES LXAL LYKA LVYKA LS LMX
LVMX LMY LMP
"""
NEUTRAL = dict.fromkeys(FACTORS.split(), 1.0)
SMALL = 1e-6


class Numbers(dict[str, float]):
    def __getattr__(self, name: str) -> Any:
        return self.get(name, NEUTRAL.get(name, 0.0))


def sgn(x: float) -> float:
    return 1.0 if x >= 0 else -1.0


def MG(B: float, C: float, D: float, E: float, x: float) -> float:
    return D * sin(C * atan(B * x - E * (B * x - atan(B * x))))


def MC(B: float, C: float, E: float, x: float) -> float:
    return cos(C * atan(B * x - E * (B * x - atan(B * x))))


def magic_formula(
    given: dict[str, float],
    Fz: float,
    kappa: float,
    alpha: float,
    gamma: float,
    V: float,
    old: bool,
    star: bool = False,
    turn: tuple[float, float] | None = None,
) -> dict[str, float]:
    """6.1 and 6.2, or 5.2 (old); with tan α and sin γ (star); with the turn slip of a yaw rate and a spin (turn)."""
    p, sg = Numbers(given), sgn
    pr = p.INFLPRES or p.NOMPRES
    F0 = p.FNOMIN * p.LFZO
    df = (Fz - F0) / F0
    dp = (pr - p.NOMPRES) / p.NOMPRES if p.NOMPRES else 0.0
    R0 = p.UNLOADED_RADIUS
    e = SMALL
    a, g, ca = alpha, gamma, sg(V) * cos(alpha)
    if star:
        a, g = tan(alpha), sin(gamma)
    z0 = z1 = z2 = z3 = z5 = z6 = z7 = 1.0
    phi = phi_t = Drp = 0.0
    if turn is not None:
        eps = p.PECP1 * (1 + p.PECP2 * df)
        phi_t = -turn[0] / abs(V)
        phi = -(turn[0] + (1 - eps) * turn[1] * sin(gamma)) / abs(V)
        z0 = 0.0
        z1 = cos(atan(p.PDXP1 * (1 + p.PDXP2 * df) * cos(atan(p.PDXP3 * kappa)) * R0 * phi))
        Byp = p.PDYP1 * (1 + p.PDYP2 * df) * cos(atan(p.PDYP3 * tan(alpha)))
        z2 = cos(atan(Byp * (R0 * abs(phi) + p.PDYP4 * sqrt(R0 * abs(phi)))))
        z3 = cos(atan(p.PKYP1 * (R0 * phi) ** 2))
        z5, z6 = cos(atan(p.QDTP1 * R0 * phi)), cos(atan(p.QBRP1 * R0 * phi))
    # --- Fx pure
    Cx = p.PCX1 * p.LCX
    mux = (p.PDX1 + p.PDX2 * df) * (1 + p.PPX3 * dp + p.PPX4 * dp**2) * (1 - p.PDX3 * gamma**2) * p.LMUX
    Dx = mux * Fz * z1
    Kx = Fz * (p.PKX1 + p.PKX2 * df) * exp(p.PKX3 * df) * (1 + p.PPX1 * dp + p.PPX2 * dp**2) * p.LKX
    Bx = Kx / (Cx * Dx + e)
    SHx = (p.PHX1 + p.PHX2 * df) * p.LHX
    SVx = Fz * (p.PVX1 + p.PVX2 * df) * p.LVX * p.LMUX * z1
    kx = kappa + SHx
    Ex = min((p.PEX1 + p.PEX2 * df + p.PEX3 * df**2) * (1 - p.PEX4 * sg(kx)) * p.LEX, 1)
    Fx0 = MG(Bx, Cx, Dx, Ex, kx) + SVx

    # --- Fy pure
    def lateral(gs: float, spins: bool = True) -> tuple[float, ...]:
        w0, w2, w3 = (z0, z2, z3) if spins else (1.0, 1.0, 1.0)
        if old:
            Ky0 = p.PKY1 * F0 * sin(2 * atan(Fz / (p.PKY2 * F0))) * p.LKY
            K = Ky0 * (1 - p.PKY3 * abs(gs))
        else:
            K = (
                p.PKY1
                * F0
                * (1 + p.PPY1 * dp)
                * (1 - p.PKY3 * abs(gs))
                * sin(p.PKY4 * atan((Fz / F0) / ((p.PKY2 + p.PKY5 * gs**2) * (1 + p.PPY2 * dp))))
                * p.LKY
                * w3
            )
        SVg = Fz * (p.PVY3 + p.PVY4 * df) * gs * p.LKYC * p.LMUY * w2
        if old:
            SH = (p.PHY1 + p.PHY2 * df) * p.LHY + p.PHY3 * gs * p.LKYC
        else:
            Kg = Fz * (p.PKY6 + p.PKY7 * df) * (1 + p.PPY5 * dp) * p.LKYC
            SH = (p.PHY1 + p.PHY2 * df) * p.LHY + (Kg * gs - SVg) / (K + e * sg(K)) * w0
            if turn is not None and spins:
                Dhy = p.PHYP2 + p.PHYP3 * df
                K0 = p.PKY1 * F0 * (1 + p.PPY1 * dp) * p.LKY
                K0 *= sin(p.PKY4 * atan(Fz / F0 / (p.PKY2 * (1 + p.PPY2 * dp))))
                Bhy = -Kg / (1 - p.PECP1 * (1 + p.PECP2 * df)) / (p.PHYP1 * Dhy * K0)
                SH += MG(Bhy, p.PHYP1, Dhy, p.PHYP4, R0 * phi) * sg(V) - SVg / K
        SV = Fz * (p.PVY1 + p.PVY2 * df) * p.LVY * p.LMUY * w2 + SVg
        C = p.PCY1 * p.LCY
        mu = (p.PDY1 + p.PDY2 * df) * (1 + p.PPY3 * dp + p.PPY4 * dp**2) * (1 - p.PDY3 * gs**2) * p.LMUY
        D = mu * Fz * w2
        x = a + SH
        E = min((p.PEY1 + p.PEY2 * df) * (1 + p.PEY5 * gs**2 - (p.PEY3 + p.PEY4 * gs) * sg(x)) * p.LEY, 1)
        B = K / (C * D + e * sg(D))
        return MG(B, C, D, E, x) + SV, mu, K, B, C, SH, SV

    Fy0, muy, Ky, By, Cy, SHy, SVy = lateral(g)
    Fy00, muy00 = lateral(0.0, False)[:2]
    # --- combined
    Bxa = (p.RBX1 + p.RBX3 * g**2) * cos(atan(p.RBX2 * kappa)) * p.LXAL
    Exa = min(p.REX1 + p.REX2 * df, 1)
    Gx = MC(Bxa, p.RCX1, Exa, a + p.RHX1) / MC(Bxa, p.RCX1, Exa, p.RHX1)
    Fx = Gx * Fx0
    SHyk = p.RHY1 + p.RHY2 * df
    Eyk = min(p.REY1 + p.REY2 * df, 1)
    Byk = (p.RBY1 + p.RBY4 * g**2) * cos(atan(p.RBY2 * (a - p.RBY3))) * p.LYKA
    Gy = MC(Byk, p.RCY1, Eyk, kappa + SHyk) / MC(Byk, p.RCY1, Eyk, SHyk)
    SVyk = (
        muy
        * Fz
        * (p.RVY1 + p.RVY2 * df + p.RVY3 * g)
        * cos(atan(p.RVY4 * a))
        * sin(p.RVY5 * atan(p.RVY6 * kappa))
        * p.LVYKA
        * z2
    )
    Fy = Gy * Fy0 + SVyk
    # --- Mz
    Kp = Ky + e * sg(Ky)
    ar = a + SHy + SVy / Kp
    at = a + p.QHZ1 + p.QHZ2 * df + (p.QHZ3 + p.QHZ4 * df) * g
    Bt = (p.QBZ1 + p.QBZ2 * df + p.QBZ3 * df**2) * (1 + p.QBZ4 * gamma + p.QBZ5 * abs(gamma)) * p.LKY / p.LMUY
    Ct = p.QCZ1
    Dt = (
        Fz
        * R0
        / F0
        * (p.QDZ1 + p.QDZ2 * df)
        * (1 - p.PPZ1 * dp)
        * (1 + p.QDZ3 * gamma + p.QDZ4 * gamma**2)
        * p.LTR
        * z5
    )
    Et = min(
        (p.QEZ1 + p.QEZ2 * df + p.QEZ3 * df**2) * (1 + (p.QEZ4 + p.QEZ5 * g) * 2 / pi * atan(Bt * Ct * at)), 1
    )
    Br = (p.QBZ9 * p.LKY / p.LMUY + p.QBZ10 * By * Cy) * z6
    Dr = (
        Fz
        * R0
        * (
            (p.QDZ6 + p.QDZ7 * df) * p.LRES * z2
            + ((p.QDZ8 + p.QDZ9 * df) * (1 + p.PPZ2 * dp) + (p.QDZ10 + p.QDZ11 * df) * abs(g))
            * g
            * p.LKZC
            * z0
        )
        * p.LMUY
        * sg(V)
        * cos(a)
    )
    Mzinf = p.QCRP1 * abs(muy) * R0 * Fz * sqrt(Fz / F0) * p.LMP
    if turn is not None:
        Ddr = Mzinf / sin(pi / 2 * p.QDRP1)
        Kzg = Fz * R0 * (p.QDZ8 + p.QDZ9 * df + (p.QDZ10 + p.QDZ11 * df) * abs(gamma)) * p.LKZC
        Bdr = Kzg / (p.QDRP1 * Ddr * (1 - p.PECP1 * (1 + p.PECP2 * df)))
        Drp = MG(Bdr, p.QDRP1, Ddr, p.QDRP2, R0 * phi)
        Mz90 = Mzinf * 2 / pi * atan(p.QCRP2 * R0 * abs(phi_t)) * Gy
        z7 = 2 / pi * acos(min(Mz90 / abs(Drp), 1.0)) if Drp else 1.0
        Dr -= Drp
    q = (Kx / Kp * kappa) ** 2
    are = atan(sqrt(tan(ar) ** 2 + q)) * sg(ar)
    ate = atan(sqrt(tan(at) ** 2 + q)) * sg(at)
    t0 = Dt * MC(Bt, Ct, Et, at) * ca
    t = Dt * MC(Bt, Ct, Et, ate) * ca * p.LFZO
    Mz0 = -t0 * Fy00 + Dr * cos(atan(Br * ar)) * ca
    Mzr = Dr * cos(z7 * atan(Br * are))
    s = R0 * (p.SSZ1 + p.SSZ2 * Fy / p.FNOMIN + (p.SSZ3 + p.SSZ4 * df) * gamma) * p.LS
    Mz = (-t * (Fy - SVyk) if old else -t * Gy * Fy00) + Mzr + s * Fx
    # --- Mx, My
    f = Fz / p.FNOMIN
    y = Fy / p.FNOMIN
    Mx = R0 * Fz * p.LMX * (
        p.QSX1 * p.LVMX
        - p.QSX2 * gamma * (1 + p.PPMX1 * dp)
        + p.QSX3 * y
        + p.QSX4 * cos(p.QSX5 * atan((p.QSX6 * f) ** 2)) * sin(p.QSX7 * gamma + p.QSX8 * atan(p.QSX9 * y))
        + p.QSX10 * atan(p.QSX11 * f) * gamma
    ) + R0 * p.LMX * (Fy * (p.QSX13 + p.QSX14 * abs(gamma)) - Fz * p.QSX12 * gamma * abs(gamma))
    w = V / p.LONGVL
    if old:
        My = -R0 * Fz * p.LMY * (p.QSY1 + p.QSY2 * Fx / p.FNOMIN + p.QSY3 * abs(w) + p.QSY4 * w**4)
    else:
        My = (
            -R0
            * p.FNOMIN
            * p.LMY
            * (
                p.QSY1
                + p.QSY2 * Fx / p.FNOMIN
                + p.QSY3 * abs(w)
                + p.QSY4 * w**4
                + (p.QSY5 + p.QSY6 * f) * gamma**2
            )
            * f**p.QSY7
            * (pr / p.NOMPRES) ** p.QSY8
        )
    return {
        "Fx0": Fx0,
        "Fy0": Fy0,
        "Mz0": Mz0,
        "Fx": Fx,
        "Fy": Fy,
        "Mx": Mx,
        "My": My,
        "Mz": Mz,
        "t": t,
        "Mzr": Mzr,
        "mux": mux,
        "muy": muy,
        "Kx": Kx,
        "Ky": Ky,
        "Gx": Gx,
        "Gy": Gy,
        "SVyk": SVyk,
        "Mzinf": Mzinf,
    }


def ellipse(
    given: dict[str, float], Fz: float, kappa: float, alpha: float, gamma: float, V: float
) -> tuple[float, float]:
    """F_x and F_y of 5.2 with the friction ellipse of Adams (PAC2002), for coefficients without vertical shifts."""
    r, p = magic_formula(given, Fz, kappa, alpha, gamma, V, True), Numbers(given)
    df = Fz / (p.FNOMIN * p.LFZO) - 1
    kc = kappa + (p.PHX1 + p.PHX2 * df) * p.LHX
    sc = sin(alpha + (p.PHY1 + p.PHY2 * df) * p.LHY + p.PHY3 * gamma * p.LKYC)
    b = acos(abs(kc) / hypot(kc, sc))
    x, y = abs(r["Fx0"]) / Fz, abs(r["Fy0"]) / Fz
    along = 1 / sqrt(1 / x**2 + (tan(b) / r["muy"]) ** 2)
    across = tan(b) / sqrt(1 / r["mux"] ** 2 + (tan(b) / y) ** 2)
    return r["Fx0"] * along / x, r["Fy0"] * across / y


def fiala(
    kappa: float, alpha: float, Fz: float, C: float, Ca: float, umin: float, umax: float, width: float
) -> tuple[float, ...]:
    ss = min(1.0, sqrt(kappa**2 + tan(alpha) ** 2))
    U = umax - (umax - umin) * ss
    kc = abs(U * Fz / (2 * C))
    ac = atan(3 * U * Fz / Ca)
    Fx = (
        C * kappa
        if abs(kappa) < kc
        else copysign(1.0, kappa) * (U * Fz - (U * Fz) ** 2 / (4 * abs(kappa) * C))
    )
    if abs(alpha) <= ac:
        H = 1 - Ca * abs(tan(alpha)) / (3 * U * Fz)
        Fy = -U * Fz * (1 - H**3) * copysign(1.0, alpha)
        Mz = U * Fz * width * (1 - H) * H**3 * copysign(1.0, alpha)
    else:
        Fy = -U * Fz * copysign(1.0, alpha)
        Mz = 0
    return Fx, Fy, Mz


def brush(
    kappa: float, alpha: float, Fz: float, mu: float, Cx: float, Cy: float, a: float
) -> tuple[float, ...]:
    """Isotropic combined brush with parabolic pressure, slip sigma, C_s = Cx = Cy if isotropic."""
    sx = kappa / (1 + kappa)
    sy = tan(alpha) / (1 + kappa)
    g = sqrt((Cx * sx) ** 2 + (Cy * sy) ** 2)
    lim = 3 * mu * Fz
    f = g - g * g / lim + g**3 / (3 * lim * lim) if g < lim else mu * Fz
    if g == 0:
        return 0, 0, 0
    Fx = f * Cx * sx / g
    Fy = -f * Cy * sy / g
    t = a / 3 * (1 - g / lim) ** 3 / (1 - g / lim + (g / lim) ** 2 / 3) if g < lim else 0
    return Fx, Fy, -t * Fy


def tm(s: float, d0: float, sm: float, fm: float, ss: float, fs: float) -> float:
    d0 = max(d0, 2 * fm / sm)
    if s <= 0:
        return 0.0
    if s > ss:
        return fs
    if s < sm:
        x = s / sm
        return d0 * s / (1 + x * (x + d0 * sm / fm - 2))
    a = (fm / sm) ** 2 / (d0 * sm)
    st = sm + (fm - fs) / (a * (ss - sm))
    if st <= ss:
        if s <= st:
            return fm - a * (s - sm) ** 2
        b = a * (st - sm) / (ss - st)
        return fs + b * (ss - s) ** 2
    x = (s - sm) / (ss - sm)
    return fm - (fm - fs) * x * x * (3 - 2 * x)


def tmeasy(sx: float, sy: float, Fz: float, par: Any, mu: float = 1.0) -> tuple[float, ...]:
    q = Fz / par["N"]

    def L(w):
        return w[0] + (w[1] - w[0]) * (q - 1)

    def Q(w):
        return q * (2 * w[0] - 0.5 * w[1] - (w[0] - 0.5 * w[1]) * q)

    s = hypot(sx, sy)
    c, n = (sx / s, sy / s) if s > 0 else (sqrt(0.5), sqrt(0.5))

    def h(a, b):
        return hypot(a * c, b * n)

    f = tm(
        s,
        h(Q(par["dx"]), Q(par["dy"])),
        mu * h(L(par["sxm"]), L(par["sym"])),
        mu * h(Q(par["fxm"]), Q(par["fym"])),
        mu * h(L(par["sxs"]), L(par["sys"])),
        mu * h(Q(par["fxs"]), Q(par["fys"])),
    )
    n0 = L(par["n0"])
    s0 = L(par["s0"])
    se = max(L(par["se"]), s0)
    y = abs(sy)
    if y >= se:
        nt = 0
    else:
        w = s0 / se
        if y <= s0:
            x = y / s0
            nt = n0 * ((1 - w) * (1 - x) + w * (1 - (3 - 2 * x) * x * x))
        else:
            x = (se - y) / (se - s0)
            nt = -n0 * (1 - w) * (y - s0) / s0 * x * x
    return f * c, f * n, nt


MICROBUS: Any = {
    "N": 1900,
    "dx": (34910.7021, 73974.3082),
    "fxm": (2145.5102, 4140.6407),
    "fxs": (1522.8229, 2922.8487),
    "sxm": (0.13913, 0.13913),
    "sxs": (0.66667, 0.66667),
    "dy": (30366.8749, 48833.5824),
    "fym": (1901.7234, 3471.9636),
    "fys": (1583.8391, 2938.7727),
    "sym": (0.14852, 0.18504),
    "sys": (0.96524, 1.0714),
    "n0": (0.178, 0.19),
    "s0": (0.16337, 0.20355),
    "se": (0.96524, 1.0714),
}
