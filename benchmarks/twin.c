/* The three groups of derivatives as a C programmer would write them: the closed formulas, by hand.

   gcc -O3 -march=native -shared -fPIC twin.c -o twin.so -lm      (-DVECTORS: four numbers are one vector register)

   Same functions, same numbers and same sparse storage as Sarrus: an element's blocks go to places given by (base, row
   stride), base < 0 where nobody wants a block. B matrices and what else the operators of a group share are computed
   once. Elements between a body and the ground take shorter ways. A, B, D, G as in the formula sheet (Euler
   parameters, scalar first). */

#include <math.h>
#include <string.h>

#define INLINE static inline __attribute__((always_inline))

typedef struct {
    long count;
    const double *numbers; /* the element's own numbers, one after the other */
    const int *bodies;     /* first coordinate of each body, < 0 for ground */
    const int *rows;       /* first constraint equation */
    const int *places[5];  /* per operator: base and stride of each block */
} Elements;

/* ------------------------------------------------------------------------------------------ vectors */

typedef struct { double x, y, z; } V3;

#ifdef VECTORS
typedef double V4 __attribute__((vector_size(32)));
typedef double Loose __attribute__((vector_size(32), aligned(8)));
#define AT(a, i) ((a)[i])
INLINE V4 scale4(double f, V4 a) { return f * a; }
INLINE V4 plus4(V4 a, V4 b) { return a + b; }
INLINE V4 axpy4(double f, V4 a, V4 b) { return f * a + b; }
INLINE V4 load4(const double *p) { return *(const Loose *)p; }
INLINE void store4(double *p, V4 a) { *(Loose *)p = a; }
#else
typedef struct { double v[4]; } V4;
#define AT(a, i) ((a).v[i])
INLINE V4 scale4(double f, V4 a) { return (V4){{f * a.v[0], f * a.v[1], f * a.v[2], f * a.v[3]}}; }
INLINE V4 plus4(V4 a, V4 b) { return (V4){{a.v[0] + b.v[0], a.v[1] + b.v[1], a.v[2] + b.v[2], a.v[3] + b.v[3]}}; }
INLINE V4 axpy4(double f, V4 a, V4 b) {
    return (V4){{f * a.v[0] + b.v[0], f * a.v[1] + b.v[1], f * a.v[2] + b.v[2], f * a.v[3] + b.v[3]}};
}
INLINE V4 load4(const double *p) { return (V4){{p[0], p[1], p[2], p[3]}}; }
INLINE void store4(double *p, V4 a) { p[0] = a.v[0], p[1] = a.v[1], p[2] = a.v[2], p[3] = a.v[3]; }
#endif

INLINE V4 make4(double a, double b, double c, double d) {
    V4 r;
    AT(r, 0) = a, AT(r, 1) = b, AT(r, 2) = c, AT(r, 3) = d;
    return r;
}
INLINE double dot4(V4 a, V4 b) {
    return AT(a, 0) * AT(b, 0) + AT(a, 1) * AT(b, 1) + AT(a, 2) * AT(b, 2) + AT(a, 3) * AT(b, 3);
}
INLINE V3 load3(const double *p) { return (V3){p[0], p[1], p[2]}; }
INLINE void store3(double *p, V3 a) { p[0] = a.x, p[1] = a.y, p[2] = a.z; }
INLINE V3 scale3(double f, V3 a) { return (V3){f * a.x, f * a.y, f * a.z}; }
INLINE V3 plus3(V3 a, V3 b) { return (V3){a.x + b.x, a.y + b.y, a.z + b.z}; }
INLINE V3 minus3(V3 a, V3 b) { return (V3){a.x - b.x, a.y - b.y, a.z - b.z}; }
INLINE double dot3(V3 a, V3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
INLINE V3 cross(V3 a, V3 b) { return (V3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
INLINE V3 imaginary(V4 p) { return (V3){AT(p, 1), AT(p, 2), AT(p, 3)}; }

/* --------------------------------------------------------------------------------- Euler parameters */

typedef struct { V4 x, y, z; } M34;
typedef struct { V4 r0, r1, r2, r3; } M44;

INLINE V3 rotate(V4 p, V3 a) {
    V3 e = imaginary(p), d = scale3(2, e);
    double k = 2 * AT(p, 0) * AT(p, 0) - 1;
    return plus3(scale3(k, a), plus3(scale3(dot3(d, a), e), scale3(AT(p, 0), cross(d, a))));
}

/* d(A(p) a)/dp */
INLINE M34 make_B(V4 p, V3 a) {
    double w = 2 * AT(p, 0);
    V3 d = scale3(2, imaginary(p)), c = plus3(scale3(2 * w, a), cross(d, a)), u = scale3(w, a);
    double m = dot3(d, a);
    return (M34){
        make4(c.x, d.x * a.x + m, d.x * a.y + u.z, d.x * a.z - u.y),
        make4(c.y, d.y * a.x - u.z, d.y * a.y + m, d.y * a.z + u.x),
        make4(c.z, d.z * a.x + u.y, d.z * a.y - u.x, d.z * a.z + m),
    };
}

/* f d(B(p, a)'x)/dp, symmetric */
INLINE M44 make_D(double f, V3 a, V3 x) {
    V3 d = scale3(2 * f, a), c = cross(d, x);
    double xy = d.x * x.y + x.x * d.y, xz = d.x * x.z + x.x * d.z, yz = d.y * x.z + x.y * d.z;
    return (M44){
        make4(2 * dot3(d, x), c.x, c.y, c.z),
        make4(c.x, 2 * d.x * x.x, xy, xz),
        make4(c.y, xy, 2 * d.y * x.y, yz),
        make4(c.z, xz, yz, 2 * d.z * x.z),
    };
}

INLINE V3 times(M34 b, V4 x) { return (V3){dot4(b.x, x), dot4(b.y, x), dot4(b.z, x)}; }
INLINE V4 row(V3 y, M34 b) { return axpy4(y.x, b.x, axpy4(y.y, b.y, scale4(y.z, b.z))); }
INLINE M34 scale34(double f, M34 b) { return (M34){scale4(f, b.x), scale4(f, b.y), scale4(f, b.z)}; }

/* a'b */
INLINE M44 product(M34 a, M34 b) {
    return (M44){
        row((V3){AT(a.x, 0), AT(a.y, 0), AT(a.z, 0)}, b),
        row((V3){AT(a.x, 1), AT(a.y, 1), AT(a.z, 1)}, b),
        row((V3){AT(a.x, 2), AT(a.y, 2), AT(a.z, 2)}, b),
        row((V3){AT(a.x, 3), AT(a.y, 3), AT(a.z, 3)}, b),
    };
}

INLINE M44 plus44(M44 a, M44 b) {
    return (M44){plus4(a.r0, b.r0), plus4(a.r1, b.r1), plus4(a.r2, b.r2), plus4(a.r3, b.r3)};
}

INLINE M44 transposed(M44 m) {
    return (M44){
        make4(AT(m.r0, 0), AT(m.r1, 0), AT(m.r2, 0), AT(m.r3, 0)),
        make4(AT(m.r0, 1), AT(m.r1, 1), AT(m.r2, 1), AT(m.r3, 1)),
        make4(AT(m.r0, 2), AT(m.r1, 2), AT(m.r2, 2), AT(m.r3, 2)),
        make4(AT(m.r0, 3), AT(m.r1, 3), AT(m.r2, 3), AT(m.r3, 3)),
    };
}

/* ------------------------------------------------------------------------------------------- blocks */

INLINE void put3(double *out, const int *at, V3 a) {
    if (at[0] >= 0) store3(out + at[0], a);
}
INLINE void put4(double *out, const int *at, V4 a) {
    if (at[0] >= 0) store4(out + at[0], a);
}
INLINE void put34(double *out, const int *at, M34 b) {
    if (at[0] < 0) return;
    store4(out + at[0], b.x), store4(out + at[0] + at[1], b.y), store4(out + at[0] + 2 * at[1], b.z);
}
INLINE void put_identity(double *out, const int *at, double f) {
    if (at[0] < 0) return;
    double *a = out + at[0], *b = a + at[1], *c = b + at[1];
    a[0] = f, a[1] = 0, a[2] = 0, b[0] = 0, b[1] = f, b[2] = 0, c[0] = 0, c[1] = 0, c[2] = f;
}
INLINE void more4(double *to, V4 a) { store4(to, plus4(load4(to), a)); }
INLINE void more3(double *to, double a, double b, double c) { to[0] += a, to[1] += b, to[2] += c; }
INLINE void add34(double *out, const int *at, M34 b) {
    if (at[0] < 0) return;
    more4(out + at[0], b.x), more4(out + at[0] + at[1], b.y), more4(out + at[0] + 2 * at[1], b.z);
}
INLINE void add43(double *out, const int *at, M34 b) { /* the transpose */
    if (at[0] < 0) return;
    double *to = out + at[0];
    more3(to, AT(b.x, 0), AT(b.y, 0), AT(b.z, 0)), more3(to + at[1], AT(b.x, 1), AT(b.y, 1), AT(b.z, 1));
    more3(to + 2 * at[1], AT(b.x, 2), AT(b.y, 2), AT(b.z, 2)), more3(to + 3 * at[1], AT(b.x, 3), AT(b.y, 3), AT(b.z, 3));
}
INLINE void add44(double *out, const int *at, M44 m) {
    if (at[0] < 0) return;
    double *to = out + at[0];
    more4(to, m.r0), more4(to + at[1], m.r1), more4(to + 2 * at[1], m.r2), more4(to + 3 * at[1], m.r3);
}

/* Four blocks in a row: 3, 4, 3, 4 wide. */
typedef struct { V3 r_i; V4 p_i; V3 r_j; V4 p_j; } Row;

INLINE void put_row(double *out, const int *at, Row r) {
    put3(out, at, r.r_i), put4(out, at + 2, r.p_i), put3(out, at + 4, r.r_j), put4(out, at + 6, r.p_j);
}
INLINE Row scale_row(double f, Row r) {
    return (Row){scale3(f, r.r_i), scale4(f, r.p_i), scale3(f, r.r_j), scale4(f, r.p_j)};
}
INLINE Row plus_row(Row a, Row b) {
    return (Row){plus3(a.r_i, b.r_i), plus4(a.p_i, b.p_i), plus3(a.r_j, b.r_j), plus4(a.p_j, b.p_j)};
}

typedef struct { V3 r; V4 p; } State;
static const double FIXED[7] = {0, 0, 0, 1, 0, 0, 0}, REST[7];

INLINE State of(const double *x, int at, const double *ground) {
    const double *s = at < 0 ? ground : x + at;
    return (State){load3(s), load4(s + 3)};
}

/* ---------------------------------------------------------------------------------------- constraints
   Outputs: Phi_q, (Phi_q' lam)_q, (Phi_q xi)_q, gamma_q, gamma_v. With `same` the direction xi is v. */

INLINE void spherical(const Elements *e, long k, int same, const double *q, const double *xi, const double *v,
                      const double *lam, double *restrict *out) {
    const int *body = e->bodies + 2 * k, *phi = e->places[0] + 8 * k, *H = e->places[1] + 4 * k;
    const int *px = e->places[2] + 4 * k, *gv = e->places[4] + 4 * k;
    V3 l = load3(lam + e->rows[k]);
    put_identity(out[0], phi, -1);
    put_identity(out[0], phi + 4, 1);
    for (int s = 0; s < 2; s++) {
        if (body[s] < 0) continue;
        V3 a = scale3(s ? 1 : -1, load3(e->numbers + 6 * k + 3 * s));
        put34(out[0], phi + 4 * s + 2, make_B(load4(q + body[s] + 3), a));
        add44(out[1], H + 2 * s, make_D(1, a, l));
        M34 b = make_B(load4(v + body[s] + 3), a);
        put34(out[4], gv + 2 * s, scale34(-2, b));
        put34(out[2], px + 2 * s, same ? b : make_B(load4(xi + body[s] + 3), a));
    }
}

/* DOT-1 between a body and the ground: Phi = u'A(p)a with a constant vector u. */
INLINE void dot1_ground(const Elements *e, long k, int side, int same, const double *q, const double *xi,
                        const double *v, const double *lam, double *restrict *out) {
    const int at = e->bodies[2 * k + side] + 3;
    V3 a = load3(e->numbers + 6 * k + 3 * side), u = load3(e->numbers + 6 * k + 3 * (1 - side));
    put4(out[0], e->places[0] + 4 * k + 2 * side, row(u, make_B(load4(q + at), a)));
    add44(out[1], e->places[1] + 8 * k + 6 * side, make_D(lam[e->rows[k]], a, u));
    V4 along = row(u, make_B(load4(v + at), a));
    put4(out[4], e->places[4] + 4 * k + 2 * side, scale4(-2, along));
    if (!same) along = row(u, make_B(load4(xi + at), a));
    put4(out[2], e->places[2] + 4 * k + 2 * side, along);
}

INLINE void dot1(const Elements *e, long k, int same, const double *q, const double *xi, const double *v,
                 const double *lam, double *restrict *out) {
    const int *body = e->bodies + 2 * k, *phi = e->places[0] + 4 * k, *H = e->places[1] + 8 * k;
    const int *px = e->places[2] + 4 * k, *gq = e->places[3] + 4 * k, *gv = e->places[4] + 4 * k;
    if (body[0] < 0 || body[1] < 0) {
        dot1_ground(e, k, body[0] < 0, same, q, xi, v, lam, out);
        return;
    }
    V3 a_i = load3(e->numbers + 6 * k), a_j = load3(e->numbers + 6 * k + 3);
    V4 p_i = load4(q + body[0] + 3), p_j = load4(q + body[1] + 3);
    V4 v_i = load4(v + body[0] + 3), v_j = load4(v + body[1] + 3);
    double l = lam[e->rows[k]];
    V3 u_i = rotate(p_i, a_i), u_j = rotate(p_j, a_j);
    M34 B_i = make_B(p_i, a_i), B_j = make_B(p_j, a_j), V_i = make_B(v_i, a_i), V_j = make_B(v_j, a_j);
    put4(out[0], phi, row(u_j, B_i));
    put4(out[0], phi + 2, row(u_i, B_j));

    M44 X = product(scale34(l, B_i), B_j);
    add44(out[1], H, make_D(l, a_i, u_j));
    add44(out[1], H + 2, X);
    add44(out[1], H + 4, transposed(X));
    add44(out[1], H + 6, make_D(l, a_j, u_i));

    V3 t_i = times(B_i, v_i), t_j = times(B_j, v_j);
    V4 by_i = plus4(row(u_j, V_i), row(t_j, B_i)), by_j = plus4(row(u_i, V_j), row(t_i, B_j));
    put4(out[4], gv, scale4(-2, by_i));
    put4(out[4], gv + 2, scale4(-2, by_j));
    put4(out[3], gq, plus4(row(scale3(-2, t_j), V_i), row(scale3(-1, times(V_j, v_j)), B_i)));
    put4(out[3], gq + 2, plus4(row(scale3(-2, t_i), V_j), row(scale3(-1, times(V_i, v_i)), B_j)));
    if (!same) {
        V4 x_i = load4(xi + body[0] + 3), x_j = load4(xi + body[1] + 3);
        by_i = plus4(row(u_j, make_B(x_i, a_i)), row(times(B_j, x_j), B_i));
        by_j = plus4(row(u_i, make_B(x_j, a_j)), row(times(B_i, x_i), B_j));
    }
    put4(out[2], px, by_i);
    put4(out[2], px + 2, by_j);
}

/* DOT-2 with the vector fixed in the ground: Phi = u'(r_j + s_j) - constant. */
INLINE void dot2_ground(const Elements *e, long k, int same, const double *q, const double *xi, const double *v,
                        const double *lam, double *restrict *out) {
    const int at = e->bodies[2 * k + 1] + 3;
    V3 u = load3(e->numbers + 9 * k), s = load3(e->numbers + 9 * k + 6);
    put3(out[0], e->places[0] + 8 * k + 4, u);
    put4(out[0], e->places[0] + 8 * k + 6, row(u, make_B(load4(q + at), s)));
    add44(out[1], e->places[1] + 16 * k + 14, make_D(lam[e->rows[k]], s, u));
    V4 along = row(u, make_B(load4(v + at), s));
    put4(out[4], e->places[4] + 8 * k + 6, scale4(-2, along));
    if (!same) along = row(u, make_B(load4(xi + at), s));
    put4(out[2], e->places[2] + 8 * k + 6, along);
}

/* (Phi_q x)_q of DOT-2, where X are the B matrices at x, eta and turn the derivatives of h and a_i along x. */
INLINE Row dot2_along(V3 h, V3 u, M34 B_i, M34 B_j, M34 X_i, M34 X_j, V3 eta, V3 turn) {
    return (Row){scale3(-1, turn), plus4(row(eta, B_i), row(h, X_i)), turn, plus4(row(turn, B_j), row(u, X_j))};
}

INLINE void dot2(const Elements *e, long k, int same, const double *q, const double *xi, const double *v,
                 const double *lam, double *restrict *out) {
    const int *body = e->bodies + 2 * k, *H = e->places[1] + 16 * k;
    if (body[0] < 0) {
        dot2_ground(e, k, same, q, xi, v, lam, out);
        return;
    }
    V3 a = load3(e->numbers + 9 * k), s_j = load3(e->numbers + 9 * k + 6);
    State q_i = of(q, body[0], FIXED), q_j = of(q, body[1], FIXED);
    State v_i = of(v, body[0], REST), v_j = of(v, body[1], REST);
    V3 u = rotate(q_i.p, a), h = minus3(plus3(q_j.r, rotate(q_j.p, s_j)), q_i.r);
    M34 B_i = make_B(q_i.p, a), B_j = make_B(q_j.p, s_j), V_i = make_B(v_i.p, a), V_j = make_B(v_j.p, s_j);
    put_row(out[0], e->places[0] + 8 * k, (Row){scale3(-1, u), row(h, B_i), u, row(u, B_j)});

    double l = lam[e->rows[k]];
    M34 lB = scale34(l, B_i), minus = scale34(-l, B_i);
    M44 X = product(lB, B_j);
    add34(out[1], H, minus);
    add43(out[1], H + 2, minus);
    add44(out[1], H + 4, make_D(l, a, h));
    add43(out[1], H + 6, lB);
    add44(out[1], H + 8, X);
    add34(out[1], H + 10, lB);
    add44(out[1], H + 12, transposed(X));
    add44(out[1], H + 14, make_D(l, s_j, u));

    V3 eta = plus3(minus3(v_j.r, v_i.r), times(B_j, v_j.p)), turn = times(B_i, v_i.p), t2 = times(V_i, v_i.p);
    Row r = dot2_along(h, u, B_i, B_j, V_i, V_j, eta, turn);
    put_row(out[4], e->places[4] + 8 * k, scale_row(-2, r));
    V3 s2 = times(V_j, v_j.p);
    Row g = {t2, plus4(row(scale3(-2, eta), V_i), row(scale3(-1, s2), B_i)), scale3(-1, t2),
             plus4(row(scale3(-1, t2), B_j), row(scale3(-2, turn), V_j))};
    put_row(out[3], e->places[3] + 8 * k, g);
    if (!same) {
        State x_i = of(xi, body[0], REST), x_j = of(xi, body[1], REST);
        eta = plus3(minus3(x_j.r, x_i.r), times(B_j, x_j.p));
        r = dot2_along(h, u, B_i, B_j, make_B(x_i.p, a), make_B(x_j.p, s_j), eta, times(B_i, x_i.p));
    }
    put_row(out[2], e->places[2] + 8 * k, r);
}

/* d from P_i to P_j: with its Jacobian [-I, B_i, I, B_j] (the sign of body i is in s_i). */
typedef struct { V3 s_i, s_j, d; M34 B_i, B_j; } Segment;
/* Its derivative w along a direction, and the Jacobian of w. */
typedef struct { V3 w; M34 B_i, B_j; } Along;

INLINE Segment segment(const double *n, State i, State j) {
    V3 s_i = scale3(-1, load3(n)), s_j = load3(n + 3);
    V3 d = plus3(minus3(j.r, i.r), plus3(rotate(j.p, s_j), rotate(i.p, s_i)));
    return (Segment){s_i, s_j, d, make_B(i.p, s_i), make_B(j.p, s_j)};
}
INLINE Along along(const Segment *s, State i, State j) {
    V3 w = plus3(minus3(j.r, i.r), plus3(times(s->B_j, j.p), times(s->B_i, i.p)));
    return (Along){w, make_B(i.p, s->s_i), make_B(j.p, s->s_j)};
}
INLINE Row by_d(V3 y, const Segment *s) { return (Row){scale3(-1, y), row(y, s->B_i), y, row(y, s->B_j)}; }
INLINE Row by_w(V3 y, const Along *a) {
    V3 zero = {0, 0, 0};
    return (Row){zero, row(y, a->B_i), zero, row(y, a->B_j)};
}

/* Add the four blocks of one pair of bodies, f m'n (+ pp), where m = [+-I, M] and n = [+-I, N]; `sign` of I'I. */
INLINE void add_pair(double f, double sign_m, double sign_n, M34 M, M34 N, M44 pp, const int *at, double *out) {
    if (at[0] < 0) return;
    double *rr = out + at[0], g = f * sign_m * sign_n;
    rr[0] += g, rr[at[1] + 1] += g, rr[2 * at[1] + 2] += g;
    add34(out, at + 2, scale34(f * sign_m, N));
    add43(out, at + 8, scale34(f * sign_n, M));
    add44(out, at + 10, pp);
}

/* Add f (d_q'd_q + (d_q'y)_q at y = d). */
INLINE void add_stiffness(const Segment *s, double f, const int *at, double *out) {
    M34 fB = scale34(f, s->B_i);
    M44 ij = product(fB, s->B_j);
    add_pair(f, -1, -1, s->B_i, s->B_i, plus44(product(fB, s->B_i), make_D(f, s->s_i, s->d)), at, out);
    add_pair(f, -1, 1, s->B_i, s->B_j, ij, at + 4, out);
    add_pair(f, 1, -1, s->B_j, s->B_i, transposed(ij), at + 16, out);
    add_pair(f, 1, 1, s->B_j, s->B_j, plus44(product(scale34(f, s->B_j), s->B_j), make_D(f, s->s_j, s->d)), at + 20, out);
}

INLINE void distance(const Elements *e, long k, int same, const double *q, const double *xi, const double *v,
                     const double *lam, double *restrict *out) {
    const int *body = e->bodies + 2 * k;
    State v_i = of(v, body[0], REST), v_j = of(v, body[1], REST);
    Segment s = segment(e->numbers + 7 * k, of(q, body[0], FIXED), of(q, body[1], FIXED));
    V3 d = scale3(2, s.d);
    put_row(out[0], e->places[0] + 8 * k, by_d(d, &s));
    add_stiffness(&s, 2 * lam[e->rows[k]], e->places[1] + 32 * k, out[1]);
    Along a = along(&s, v_i, v_j);
    Row r = plus_row(by_d(scale3(2, a.w), &s), by_w(d, &a));
    put_row(out[4], e->places[4] + 8 * k, scale_row(-2, r));
    V3 second = plus3(times(a.B_i, v_i.p), times(a.B_j, v_j.p));
    put_row(out[3], e->places[3] + 8 * k, plus_row(by_d(scale3(-2, second), &s), by_w(scale3(-4, a.w), &a)));
    if (!same) {
        a = along(&s, of(xi, body[0], REST), of(xi, body[1], REST));
        r = plus_row(by_d(scale3(2, a.w), &s), by_w(d, &a));
    }
    put_row(out[2], e->places[2] + 8 * k, r);
}

INLINE void normalization(const Elements *e, long k, const double *q, const double *xi, const double *v,
                          const double *lam, double *restrict *out) {
    int at = e->bodies[k] + 3;
    const int *H = e->places[1] + 2 * k;
    double l = 2 * lam[e->rows[k]], *to = out[1] + H[0];
    put4(out[0], e->places[0] + 2 * k, scale4(2, load4(q + at)));
    to[0] += l, to[H[1] + 1] += l, to[2 * H[1] + 2] += l, to[3 * H[1] + 3] += l;
    put4(out[2], e->places[2] + 2 * k, scale4(2, load4(xi + at)));
    put4(out[4], e->places[4] + 2 * k, scale4(-4, load4(v + at)));
}

INLINE void kinematic_group(const Elements *e, int same, const double *q, const double *xi, const double *v,
                            const double *lam, double *restrict *out, const long *sizes) {
    memset(out[1], 0, sizes[1] * sizeof(double));
    for (long k = 0; k < e[0].count; k++) spherical(e, k, same, q, xi, v, lam, out);
    for (long k = 0; k < e[1].count; k++) dot1(e + 1, k, same, q, xi, v, lam, out);
    for (long k = 0; k < e[2].count; k++) dot2(e + 2, k, same, q, xi, v, lam, out);
    for (long k = 0; k < e[3].count; k++) distance(e + 3, k, same, q, xi, v, lam, out);
    for (long k = 0; k < e[4].count; k++) normalization(e + 4, k, q, xi, v, lam, out);
}

/* ---------------------------------------------------------------------------------- forces: Q_q, Q_v */

/* Add left'right to the 14x14 block. */
INLINE void add_outer(Row left, Row right, const int *at, double *out) {
    const double l[14] = {left.r_i.x, left.r_i.y, left.r_i.z, AT(left.p_i, 0), AT(left.p_i, 1), AT(left.p_i, 2),
                          AT(left.p_i, 3), left.r_j.x, left.r_j.y, left.r_j.z, AT(left.p_j, 0), AT(left.p_j, 1),
                          AT(left.p_j, 2), AT(left.p_j, 3)};
    static const int start[4] = {0, 3, 7, 10}, height[4] = {3, 4, 3, 4};
    for (int m = 0; m < 4; m++)
        for (int r = 0; r < height[m]; r++) {
            const int *a = at + 8 * m;
            double f = l[start[m] + r];
            if (a[0] >= 0) {
                double *to = out + a[0] + r * a[1];
                more3(to, f * right.r_i.x, f * right.r_i.y, f * right.r_i.z);
                more4(out + a[2] + r * a[3], scale4(f, right.p_i));
            }
            if (a[4] >= 0) {
                double *to = out + a[4] + r * a[5];
                more3(to, f * right.r_j.x, f * right.r_j.y, f * right.r_j.z);
                more4(out + a[6] + r * a[7], scale4(f, right.p_j));
            }
        }
}

INLINE void tsda(const Elements *e, long k, const double *q, const double *v, double *restrict *out) {
    const int *body = e->bodies + 2 * k;
    const double *n = e->numbers + 10 * k, stiffness = n[6], damping = n[7];
    Segment s = segment(n, of(q, body[0], FIXED), of(q, body[1], FIXED));
    Along a = along(&s, of(v, body[0], REST), of(v, body[1], REST));
    double l = sqrt(dot3(s.d, s.d)), one = 1 / l;
    V3 u = scale3(one, s.d);
    double rate = dot3(u, a.w), tension = (stiffness * (l - n[8]) + damping * rate + n[9]) * one;
    Row l_q = by_d(u, &s);
    Row rate_q = plus_row(by_d(scale3(one, minus3(a.w, scale3(rate, u))), &s), by_w(u, &a));
    add_stiffness(&s, -tension, e->places[0] + 32 * k, out[0]);
    add_outer(l_q, plus_row(scale_row(tension - stiffness, l_q), scale_row(-damping, rate_q)), e->places[0] + 32 * k, out[0]);
    add_outer(l_q, scale_row(-damping, l_q), e->places[1] + 32 * k, out[1]);
}

INLINE void tyre(const Elements *e, long k, const double *q, const double *v, double *restrict *out) {
    const int *at = e->places[0] + 8 * k, *bt = e->places[1] + 8 * k;
    const double *n = e->numbers + 7 * k, stiffness = n[3], damping = n[4];
    State x = of(q, e->bodies[k], FIXED), w = of(v, e->bodies[k], REST);
    V3 s = load3(n);
    V4 z = make_B(x.p, s).z, z_rate = make_B(w.p, s).z, F_p = axpy4(-stiffness, z, scale4(-damping, z_rate));
    double height = x.r.z + rotate(x.p, s).z, rate = w.r.z + dot4(z, w.p);
    double F = stiffness * (n[5] - (height - n[6])) - damping * rate;
    M44 m = make_D(F, s, (V3){0, 0, 1});
    V4 damped = scale4(-damping, z);
    out[0][at[0] + 2 * at[1] + 2] -= stiffness;
    out[1][bt[0] + 2 * bt[1] + 2] -= damping;
    more4(out[0] + at[2] + 2 * at[3], F_p);
    more4(out[1] + bt[2] + 2 * bt[3], damped);
    for (int i = 0; i < 4; i++) {
        out[0][at[4] + i * at[5] + 2] -= stiffness * AT(z, i);
        out[1][bt[4] + i * bt[5] + 2] += AT(damped, i);
        more4(out[1] + bt[6] + i * bt[7], scale4(AT(z, i), damped));
    }
    m = (M44){axpy4(AT(z, 0), F_p, m.r0), axpy4(AT(z, 1), F_p, m.r1), axpy4(AT(z, 2), F_p, m.r2), axpy4(AT(z, 3), F_p, m.r3)};
    add44(out[0], at + 6, m);
}

INLINE void force_group(const Elements *e, const double *q, const double *v, double *restrict *out, const long *sizes) {
    memset(out[0], 0, sizes[0] * sizeof(double));
    memset(out[1], 0, sizes[1] * sizeof(double));
    for (long k = 0; k < e[0].count; k++) tsda(e, k, q, v, out);
    for (long k = 0; k < e[1].count; k++) tyre(e + 1, k, q, v, out);
}

/* ------------------------------------------------------------------------------------ inertia: (M a)_q */

INLINE M34 make_G(V4 p) {
    double w = AT(p, 0), x = AT(p, 1), y = AT(p, 2), z = AT(p, 3);
    return (M34){make4(-x, w, z, -y), make4(-y, -z, w, x), make4(-z, y, -x, w)};
}

INLINE void rigid_inertia(const Elements *e, long k, const double *q, const double *a, double *restrict *out) {
    const int at = e->bodies[k] + 3;
    const double *n = e->numbers + 7 * k + 1;
    V3 J_x = {n[0], n[3], n[4]}, J_y = {n[3], n[1], n[5]}, J_z = {n[4], n[5], n[2]};
    V4 w = load4(a + at);
    M34 G = make_G(load4(q + at)), G_a = make_G(w);
    V3 g = scale3(4, times(G, w)), y = {dot3(J_x, g), dot3(J_y, g), dot3(J_z, g)};
    M44 m = product(scale34(-4, G), (M34){row(J_x, G_a), row(J_y, G_a), row(J_z, G_a)});
    M44 bar = {make4(0, -y.x, -y.y, -y.z), make4(y.x, 0, y.z, -y.y), make4(y.y, -y.z, 0, y.x), make4(y.z, y.y, -y.x, 0)};
    add44(out[0], e->places[0] + 2 * k, plus44(m, bar));
}

INLINE void inertia_group(const Elements *e, const double *q, const double *a, double *restrict *out, const long *sizes) {
    memset(out[0], 0, sizes[0] * sizeof(double));
    for (long k = 0; k < e[0].count; k++) rigid_inertia(e, k, q, a, out);
}

/* ---------------------------------------------------------------------------------------- entry points
   Evaluate a group `repeats` times. Operands in the order q, xi, v, lam / q, v / q, a. */

typedef const double *const *Operands;

static __attribute__((noinline)) void kinematic_1(const Elements *e, Operands x, double **out, const long *n) {
    double *restrict o[5] = {out[0], out[1], out[2], out[3], out[4]};
    kinematic_group(e, 0, x[0], x[1], x[2], x[3], o, n);
}
static __attribute__((noinline)) void kinematic_v_1(const Elements *e, Operands x, double **out, const long *n) {
    double *restrict o[5] = {out[0], out[1], out[2], out[3], out[4]};
    kinematic_group(e, 1, x[0], x[2], x[2], x[3], o, n);
}
static __attribute__((noinline)) void force_1(const Elements *e, Operands x, double **out, const long *n) {
    double *restrict o[2] = {out[0], out[1]};
    force_group(e, x[0], x[1], o, n);
}
static __attribute__((noinline)) void inertia_1(const Elements *e, Operands x, double **out, const long *n) {
    double *restrict o[1] = {out[0]};
    inertia_group(e, x[0], x[1], o, n);
}

#define LOOP(group) \
    void group(long repeats, const Elements *e, Operands x, double **out, const long *n) { \
        for (long k = 0; k < repeats; k++) group##_1(e, x, out, n); \
    }
LOOP(kinematic)
LOOP(kinematic_v)
LOOP(force)
LOOP(inertia)
