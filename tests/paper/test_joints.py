"""Section 3: the basic constraints and the joints made of them, Eqs. (26) to (33).

The constraints are held against their definitions in fractions; the joints of the model layer against the list of basic
constraints that the paper gives, axes seen in the initial pose.
"""

import numpy as np
from tests.paper.kernels import kernel, split
from tests.paper.paper import A, equal, rational, unit

from sarrus import elements, model
from sarrus.elements import Distance, Dot1, Dot2, Normalization, Spherical
from sarrus.model.expansion.blueprint import blueprint

q, u, w, y, C = rational(1, 14), rational(2, 3), rational(3, 3), rational(4, 3), rational(5, 1)[0]
r_i, p_i, r_j, p_j = split(q)
U_I, W_J = A(p_i) @ u, A(p_j) @ w


def test_eq_026_dot_1():
    """DOT-1: Φ^d1 = s_iᵀ s_j."""
    assert equal(kernel(Dot1(u, w), "Phi", q), [U_I @ W_J])


def test_eq_027_dot_2():
    """DOT-2: Φ^d2 = a_iᵀ d_ij, on unit p."""
    r_i, p_i, r_j, p_j = on_sphere = rational(6, 3), unit(7), rational(8, 3), unit(9)
    d_ij = r_j + A(p_j) @ w - r_i - A(p_i) @ y
    assert equal(kernel(Dot2(u, y, w), "Phi", np.concatenate(on_sphere)), [(A(p_i) @ u) @ d_ij])


D_IJ = r_j + W_J - r_i - U_I


def test_eq_028_distance():
    """Distance: Φ^ss = d_ijᵀ d_ij - C²."""
    assert equal(kernel(Distance(u, w, C), "Phi", q), [D_IJ @ D_IJ - C**2])


def test_eq_029_spherical():
    """Spherical: Φ^s = r_j + s_j - r_i - s_i."""
    assert equal(kernel(Spherical(u, w), "Phi", q), D_IJ)


def test_eq_033_normalization():
    """Normalization: Φ^P = p_iᵀ p_i - 1."""
    assert equal(kernel(Normalization(), "Phi", q[:7]), [p_i @ p_i - 1])


POINT, AXIS, ACROSS = (
    np.array([0.3, -0.2, 0.7]),
    np.array([1.0, 2.0, -2.0]) / 3,
    np.array([2.0, 1.0, 2.0]) / 3,
)


def bodies():
    """Two bodies anywhere."""
    states = zip("ab", (unit(1), unit(2)), ((1, 2, 3), (-2, 0, 1)), strict=True)
    return [
        model.Body(n, mass=1, inertia=(1, 1, 1), position=r, orientation=p.astype(float))
        for n, p, r in states
    ]


def primitives(joint):
    """The constraints of a joint: class, and the fields in global axes, where its bodies are."""
    plan = blueprint(model.Model("joint", bodies(), [joint]))
    frames = [(plan.q[7 * b : 7 * b + 3], A(plan.q[7 * b + 3 : 7 * b + 7]).astype(float)) for b in (0, 1)]
    found = []
    for placed in plan.placed:
        if issubclass(placed.element, elements.Primitive):
            assert placed.bodies == (1, 2)
            by_name = dict(zip(placed.element.fields, placed.values, strict=True))
            found.append(
                (placed.element, {n: _global(n, x, *frames["ij".index(n[-1])]) for n, x in by_name.items()})
            )
    return found


def _global(name, value, r, orientation):
    vector = orientation @ np.array(value, dtype=float)
    return r + vector if name.startswith("s_") else vector


def same(a, b):
    return np.allclose(a, b, rtol=0, atol=1e-14)


def parallel(a, b):
    return same(np.cross(a, b), 0)


def is_frame(f, g, h):
    return same(np.column_stack([f, g, h]).T @ np.column_stack([f, g, h]), np.eye(3)) and same(
        np.cross(f, g), h
    )


def rank(joint):
    """Rank of the joint's Jacobian in its assembled state, with the normalizations."""
    plan = blueprint(model.Model("joint", bodies(), [joint]))
    found = [p for p in plan.placed if issubclass(p.element, elements.Primitive)]
    fields = [[np.array(x, dtype=float) if np.ndim(x) else x for x in p.values] for p in found]
    lines = [
        np.atleast_2d(kernel(p.element(*x), "Phi_q", plan.q)) for p, x in zip(found, fields, strict=True)
    ]
    sphere = np.zeros((2, 14))
    sphere[0, 3:7], sphere[1, 10:] = plan.q[3:7], plan.q[10:]
    return np.linalg.matrix_rank(np.vstack([*lines, sphere]).astype(float)) - 2


def test_eq_030_revolute():
    """Revolute joint: Φ^s(P_i, P_j), Φ^d1(f_i, h_j), Φ^d1(g_i, h_j)."""
    a, b = bodies()
    joint = model.Revolute("pin", a, b, point=POINT, axis=AXIS)
    (first, point), (second, f), (third, g) = primitives(joint)
    assert (first, second, third) == (Spherical, Dot1, Dot1)
    assert same(point["s_i"], POINT)
    assert same(point["s_j"], POINT)
    assert is_frame(f["a_i"], g["a_i"], AXIS)
    assert same(f["a_j"], AXIS)
    assert same(g["a_j"], AXIS)
    assert rank(joint) == 5


def test_eq_031_universal():
    """Universal joint: Φ^s(P_i, P_j), Φ^d1(h_i, h_j)."""
    a, b = bodies()
    joint = model.Universal("cross", a, b, point=POINT, axis_i=AXIS, axis_j=ACROSS)
    (first, point), (second, axes) = primitives(joint)
    assert (first, second) == (Spherical, Dot1)
    assert same(point["s_i"], POINT)
    assert same(point["s_j"], POINT)
    assert same(axes["a_i"], AXIS)
    assert same(axes["a_j"], ACROSS)
    assert rank(joint) == 4


def test_eq_032_translational():
    """Translational joint: Φ^d1(g_i, h_j), Φ^d1(f_i, h_j), Φ^d1(f_i, f_j), Φ^d2(g_i, d_ij), Φ^d2(f_i, d_ij)."""
    a, b = bodies()
    joint = model.Translational("slide", a, b, point=POINT, axis=AXIS)
    (c1, g_h), (c2, f_h), (c3, f_f), (c4, g_d), (c5, f_d) = primitives(joint)
    assert (c1, c2, c3, c4, c5) == (Dot1, Dot1, Dot1, Dot2, Dot2)
    f, g = f_h["a_i"], g_h["a_i"]
    assert is_frame(f, g, AXIS)
    assert same(g_h["a_j"], AXIS)
    assert same(f_h["a_j"], AXIS)
    assert same(f_f["a_i"], f)
    assert parallel(f_f["a_j"], g)
    assert same(g_d["a_i"], g)
    assert same(f_d["a_i"], f)
    assert all(same(line[s], POINT) for line in (g_d, f_d) for s in ("s_i", "s_j"))
    assert rank(joint) == 5
