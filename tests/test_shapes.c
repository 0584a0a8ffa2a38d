/* The shapes section: functions and derivatives, support points, bounds, mass properties,
   the polytope constructor, and bad input.

   Everything is checked at sizes near 1 m, so tolerances are metres. EPS is the unit of rounding.
   Where a tolerance is a multiple of it, the factor counts operations and is far below what a wrong
   formula gives. */
#include "test.h"

#include <stdint.h>

#define SINGLE (sizeof(ecp_real) == sizeof(float))
#define PICK(single_value, double_value) ECP_R(SINGLE ? (single_value) : (double_value))
#define EPS PICK(1.2e-7, 2.3e-16)
#define PI ECP_R(3.14159265358979323846)

enum { SHAPES_MAX_PLANES = 40, SHAPES_MAX_VERTICES = 2 * SHAPES_MAX_PLANES, SHAPES_COUNT = 13 };

/* ---- seeded random numbers (xorshift), the same on every machine */

static uint32_t shapes_random_state = 1u;

static ecp_real shapes_random_in(ecp_real lo, ecp_real hi)
{
    shapes_random_state ^= shapes_random_state << 13;
    shapes_random_state ^= shapes_random_state >> 17;
    shapes_random_state ^= shapes_random_state << 5;
    return lo + (hi - lo) * ((ecp_real)(shapes_random_state >> 8) / ECP_R(16777216));
}

static void shapes_random_unit(ecp_real n[3])
{
    ecp_real length;
    do {
        for (int k = 0; k < 3; k++) {
            n[k] = shapes_random_in(ECP_R(-1), ECP_R(1));
        }
        length = ecp_i_norm(n);
    } while (length > ECP_R(1) || length < ECP_R(0.1));
    for (int k = 0; k < 3; k++) {
        n[k] /= length;
    }
}

/* ---- the shapes that the general tests run over */

static ecp_real shapes_octahedron_planes[8 * 4];
static ecp_real shapes_octahedron_vertices[6 * 3];
static ecp_real shapes_random_planes[30 * 4];
static ecp_real shapes_random_vertices[56 * 3];

static void shapes_make_octahedron(ecp_real *planes, ecp_real offset)
{
    const ecp_real c = ECP_R(1) / ecp_i_sqrt(ECP_R(3));
    for (int i = 0; i < 8; i++) {
        planes[4 * i] = (i & 1) ? c : -c;
        planes[4 * i + 1] = (i & 2) ? c : -c;
        planes[4 * i + 2] = (i & 4) ? c : -c;
        planes[4 * i + 3] = offset * c;
    }
}

/* planes that touch a ball of radius r about c */
static void shapes_make_tangent_planes(ecp_real *planes, int count, ecp_real r, const ecp_real c[3])
{
    for (int i = 0; i < count; i++) {
        shapes_random_unit(planes + 4 * i);
        planes[4 * i + 3] = r + ecp_i_dot(planes + 4 * i, c);
    }
}

static void shapes_make_box_planes(ecp_real *planes, const ecp_real lo[3], const ecp_real hi[3])
{
    for (int k = 0; k < 3; k++) {
        for (int j = 0; j < 8; j++) {
            planes[8 * k + j] = ECP_R(0);
        }
        planes[8 * k + k] = ECP_R(1);
        planes[8 * k + 3] = hi[k];
        planes[8 * k + 4 + k] = ECP_R(-1);
        planes[8 * k + 7] = -lo[k];
    }
}

static void shapes_make_all(ecp_shape s[SHAPES_COUNT])
{
    const ecp_real radii[3] = {ECP_R(0.5), ECP_R(1.1), ECP_R(0.8)};
    const ecp_real round[3] = {ECP_R(0.9), ECP_R(0.9), ECP_R(0.4)};
    const ecp_real half[3] = {ECP_R(0.4), ECP_R(0.7), ECP_R(1.2)};
    const ecp_real normal[3] = {ECP_R(1), ECP_R(-2), ECP_R(2)};
    const ecp_real aside[3] = {ECP_R(0.3), ECP_R(-0.2), ECP_R(0.1)};

    CHECK(ecp_shape_half_space(&s[0], normal, ECP_R(1.5)) == ECP_OK);
    CHECK(ecp_shape_sphere(&s[1], ECP_R(0.8)) == ECP_OK);
    CHECK(ecp_shape_ellipsoid(&s[2], radii) == ECP_OK);
    CHECK(ecp_shape_ellipsoid(&s[3], round) == ECP_OK);
    CHECK(ecp_shape_capsule(&s[4], ECP_R(0.5), ECP_R(0.7)) == ECP_OK);
    CHECK(ecp_shape_capsule(&s[5], ECP_R(0.5), ECP_R(0)) == ECP_OK);
    CHECK(ecp_shape_cylinder(&s[6], ECP_R(0.6), ECP_R(0.9)) == ECP_OK);
    CHECK(ecp_shape_frustum(&s[7], ECP_R(0.9), ECP_R(0.4), ECP_R(0.6)) == ECP_OK);
    CHECK(ecp_shape_frustum(&s[8], ECP_R(0.3), ECP_R(1), ECP_R(0.5)) == ECP_OK);
    CHECK(ecp_shape_frustum(&s[9], ECP_R(0.8), ECP_R(0), ECP_R(0.7)) == ECP_OK);
    CHECK(ecp_shape_box(&s[10], half) == ECP_OK);
    shapes_make_octahedron(shapes_octahedron_planes, ECP_R(1));
    CHECK(ecp_shape_polytope(&s[11], shapes_octahedron_planes, 8, shapes_octahedron_vertices, 6) ==
          ECP_OK);
    shapes_make_tangent_planes(shapes_random_planes, 30, ECP_R(0.7), aside);
    CHECK(ecp_shape_polytope(&s[12], shapes_random_planes, 30, shapes_random_vertices, 56) ==
          ECP_OK);
}

/* ---- helpers */

static ecp_real shapes_largest_f(const ecp_shape *s, const ecp_real x[3])
{
    ecp_real f[SHAPES_MAX_PLANES], most;
    s->cls->eval(s, x, f, NULL);
    most = f[0];
    for (int i = 1; i < s->inequalities; i++) {
        most = ecp_i_max(most, f[i]);
    }
    return most;
}

/* where the ray from the centre along n leaves the shape, by bisection; returns the distance */
static ecp_real shapes_leave(const ecp_shape *s, const ecp_real n[3], ecp_real x[3])
{
    ecp_real lo = ECP_R(0), hi = ECP_R(2) * s->radius;
    for (int round = 0; round < 60; round++) {
        const ecp_real t = ECP_R(0.5) * (lo + hi);
        for (int k = 0; k < 3; k++) {
            x[k] = s->centre[k] + t * n[k];
        }
        if (shapes_largest_f(s, x) <= ECP_R(0)) {
            lo = t;
        } else {
            hi = t;
        }
    }
    for (int k = 0; k < 3; k++) {
        x[k] = s->centre[k] + lo * n[k];
    }
    return lo;
}

/* a lower bound of the radius of curvature: EPS over it is how far a rounding of x turns a gradient */
static ecp_real shapes_sharpness(const ecp_shape *s)
{
    if (s->kind == ECP_FRUSTUM) {
        return ecp_i_min(s->size[0], s->size[1]);
    }
    return ECP_R(0.1);
}

/* is x farther than `margin` from every jump of a second or third derivative and, in a frustum,
   where rho is so large that differences of step margin / 4 resolve 1 / rho? */
static int shapes_smooth_near(const ecp_shape *s, const ecp_real x[3], ecp_real margin)
{
    if (s->kind == ECP_ELLIPSOID) {
        return ecp_i_abs(shapes_largest_f(s, x)) > margin;
    }
    if (s->kind == ECP_CAPSULE) {
        return ecp_i_abs(ecp_i_abs(x[2]) - s->size[1]) > margin;
    }
    if (s->kind == ECP_FRUSTUM) {
        ecp_real here[3];
        const ecp_real join = ECP_R(0.5) * ecp_i_min(s->size[0], s->size[1]);
        ecp_i_frustum_rho(s, x[2], here);
        return here[0] > join + margin * ecp_i_abs(here[1]) && here[0] > PICK(0.5, 0.2);
    }
    return 1;
}

/* sixth-order central shapes_difference from values at +-h, +-2h, +-3h: v[0..2] above, v[3..5] below */
static ecp_real shapes_difference(const ecp_real v[6], ecp_real h)
{
    return (ECP_R(45) * (v[0] - v[3]) - ECP_R(9) * (v[1] - v[4]) + (v[2] - v[5])) / (ECP_R(60) * h);
}

/* the gradients, and Hess of sum l_i f_i, at x by differences of step h, against the shape's own */
static void shapes_check_derivatives(const ecp_shape *s, const ecp_real x[3], ecp_real h,
                                     ecp_real tolerance)
{
    ecp_real f[6][SHAPES_MAX_PLANES], g[6][3 * SHAPES_MAX_PLANES], at[SHAPES_MAX_PLANES],
        grad[3 * SHAPES_MAX_PLANES];
    ecp_real l[SHAPES_MAX_PLANES], H[9], v[6];
    ecp_real worst_g = ECP_R(0), worst_H = ECP_R(0);

    for (int i = 0; i < s->inequalities; i++) {
        l[i] = shapes_random_in(ECP_R(-1), ECP_R(2));
    }
    for (int k = 0; k < 9; k++) {
        H[k] = s->cls->hess != NULL ? ECP_R(99) : ECP_R(0);
    }
    s->cls->eval(s, x, at, grad);
    if (s->cls->hess != NULL) {
        s->cls->hess(s, x, l, H);
    }
    for (int k = 0; k < 3; k++) {
        for (int j = 0; j < 6; j++) {
            const ecp_real t = (ecp_real)(j % 3 + 1) * (j < 3 ? h : -h);
            ecp_real y[3];
            ecp_i_copy3(x, y);
            y[k] += t;
            s->cls->eval(s, y, f[j], g[j]);
        }
        for (int i = 0; i < s->inequalities; i++) {
            for (int j = 0; j < 6; j++) {
                v[j] = f[j][i];
            }
            worst_g = ecp_i_max(worst_g, ecp_i_abs(shapes_difference(v, h) - grad[3 * i + k]));
        }
        for (int r = 0; r < 3; r++) {
            for (int j = 0; j < 6; j++) {
                v[j] = ECP_R(0);
                for (int i = 0; i < s->inequalities; i++) {
                    v[j] += l[i] * g[j][3 * i + r];
                }
            }
            worst_H = ecp_i_max(worst_H, ecp_i_abs(shapes_difference(v, h) - H[3 * r + k]));
        }
    }
    CHECK(worst_g <= tolerance);
    CHECK(worst_H <= tolerance);
    CHECK(H[1] == H[3] && H[2] == H[6] && H[5] == H[7]);
}

/* are there l_i >= 0 with n = sum l_i g_i over the active i? By Caratheodory three of them are
   enough, so it tries all triples by least squares: (G G^T) l = G n, by Cramer's rule */
static ecp_real shapes_cone_residual(const ecp_real *g, const int *active, int count,
                                     const ecp_real n[3])
{
    ecp_real best = ECP_R(9);
    for (int a = 0; a < count; a++) {
        for (int b = a; b < count; b++) {
            for (int c = b; c < count; c++) {
                const ecp_real *p = g + 3 * active[a], *q = g + 3 * active[b];
                const ecp_real *r = g + 3 * active[c];
                ecp_real l[3] = {0, 0, 0}, u[3], w[3], d[3];
                if (a == b && b == c) {
                    l[0] = ecp_i_dot(p, n) / ecp_i_dot(p, p);
                } else if (a != b && b == c) {
                    const ecp_real pq = ecp_i_dot(p, q), pp = ecp_i_dot(p, p), qq = ecp_i_dot(q, q);
                    const ecp_real det = pp * qq - pq * pq;
                    l[0] = (qq * ecp_i_dot(p, n) - pq * ecp_i_dot(q, n)) / det;
                    l[1] = (pp * ecp_i_dot(q, n) - pq * ecp_i_dot(p, n)) / det;
                } else if (a != b) {
                    ecp_i_cross(q, r, u);
                    l[0] = ecp_i_dot(n, u) / ecp_i_dot(p, u);
                    ecp_i_cross(r, p, w);
                    l[1] = ecp_i_dot(n, w) / ecp_i_dot(q, w);
                    ecp_i_cross(p, q, w);
                    l[2] = ecp_i_dot(n, w) / ecp_i_dot(r, w);
                } else {
                    continue;
                }
                for (int k = 0; k < 3; k++) {
                    l[k] = ecp_i_max(l[k], ECP_R(0));
                }
                for (int k = 0; k < 3; k++) {
                    d[k] = n[k] - l[0] * p[k] - l[1] * q[k] - l[2] * r[k];
                }
                if (ecp_i_finite(ecp_i_norm(d))) {
                    best = ecp_i_min(best, ecp_i_norm(d));
                }
            }
        }
    }
    return best;
}

/* ---- functions and derivatives */

/* step h = 2e-3 (float: 0.04). Truncation h^6 f^(7) / 140 is worst for the frustum, where it is of
   order 36 (h k / rho)^6 times a slope of up to 50: 2e-9 (float: 3e-4) at the least rho that is
   allowed. Rounding is EPS |f| / h with |f| up to 10: 1e-12 (float: 3e-5) */
static void test_shape_derivatives(void)
{
    const ecp_real h = PICK(0.04, 2e-3), tolerance = PICK(2e-3, 2e-9);
    ecp_shape s[SHAPES_COUNT];
    int inside = 0, outside = 0;

    shapes_random_state = 11u;
    shapes_make_all(s);
    for (int i = 0; i < SHAPES_COUNT; i++) {
        for (int sample = 0; sample < 60; sample++) {
            const ecp_real range = sample % 2 ? ECP_R(1.6) : ECP_R(0.6);
            ecp_real x[3];
            do {
                for (int k = 0; k < 3; k++) {
                    x[k] = shapes_random_in(-range, range);
                }
            } while (!shapes_smooth_near(&s[i], x, ECP_R(4) * h));
            /* inside the ellipsoid f bends on the scale of the smallest axis: a wider step has
               nothing left of its order */
            if (SINGLE && s[i].kind == ECP_ELLIPSOID && shapes_largest_f(&s[i], x) < ECP_R(0)) {
                shapes_check_derivatives(&s[i], x, ECP_R(0.02), ECP_R(2e-2));
            } else {
                shapes_check_derivatives(&s[i], x, h, tolerance);
            }
            if (shapes_largest_f(&s[i], x) < ECP_R(0)) {
                ++inside;
            } else {
                ++outside;
            }
        }
    }
    CHECK(inside > 100 && outside > 100);
}

/* beyond the narrow end of a cone rho is continued over a length of the tip's radius. There the
   derivatives are of size 1 / tip, so take a blunt frustum and look at the continuation only: below
   rho = r0 it is a rational function of d = (r0 - rho) / r0 with no structure below 0.3 */
static void test_shape_frustum_continuation(void)
{
    const ecp_real h = PICK(0.03, 3e-3);
    ecp_shape s;
    ecp_real below[3], above[3], rho[3], z;

    shapes_random_state = 12u;
    CHECK(ecp_shape_frustum(&s, ECP_R(2), ECP_R(1), ECP_R(0.5)) == ECP_OK);

    /* k = -1, and rho = 1/2 at z = 1 */
    for (int sample = 0; sample < 50; sample++) {
        const ecp_real x[3] = {shapes_random_in(ECP_R(-1), ECP_R(1)),
                               shapes_random_in(ECP_R(-1), ECP_R(1)),
                               shapes_random_in(ECP_R(1.1), ECP_R(3))};
        shapes_check_derivatives(&s, x, h, PICK(2e-2, 1e-8));
    }

    /* joined twice continuously: over 2 dz values differ by 2 dz times the next derivative, which
       is 1 for the value, 0 for the slope, and at most 200 for the curvature */
    z = ECP_R(1);
    ecp_i_frustum_rho(&s, z - PICK(1e-3, 1e-6), below);
    ecp_i_frustum_rho(&s, z + PICK(1e-3, 1e-6), above);
    CHECK_NEAR(above[0], below[0], PICK(2.1e-3, 2.1e-6));
    CHECK_NEAR(above[1], below[1], PICK(2e-3, 1e-9));
    CHECK_NEAR(above[2], below[2], PICK(0.4, 4e-4));

    /* positive and finite as far as numbers go whose squares do not overflow */
    for (z = ECP_R(1); z < PICK(1e18, 1e150); z *= ECP_R(10)) {
        ecp_i_frustum_rho(&s, z, rho);
        CHECK(rho[0] > ECP_R(0.2) && rho[0] <= ECP_R(0.51));
        CHECK(ecp_i_finite(rho[1]) && ecp_i_finite(rho[2]));
    }
}

/* no division by zero at the places where one could lurk: centres, axes, tips, far away */
static void test_shape_finite_everywhere(void)
{
    const ecp_real far = PICK(1e6, 1e30);
    const ecp_real at[6] = {0, ECP_R(0.7), ECP_R(-0.7), ECP_R(1), far, -far};
    ecp_shape s[SHAPES_COUNT];

    shapes_random_state = 13u;
    shapes_make_all(s);
    for (int i = 0; i < SHAPES_COUNT; i++) {
        int finite = 1;
        for (int c = 0; c < 6 * 6 * 6; c++) {
            const ecp_real x[3] = {at[c % 6], at[c / 6 % 6], at[c / 36]};
            ecp_real f[SHAPES_MAX_PLANES], g[3 * SHAPES_MAX_PLANES], l[SHAPES_MAX_PLANES], H[9];
            s[i].cls->eval(&s[i], x, f, g);
            for (int j = 0; j < s[i].inequalities; j++) {
                finite = finite && ecp_i_finite(f[j]) && ecp_i_finite(ecp_i_dot(g + 3 * j, x));
                l[j] = ECP_R(1);
            }
            if (s[i].cls->hess != NULL) {
                s[i].cls->hess(&s[i], x, l, H);
                for (int k = 0; k < 9; k++) {
                    finite = finite && ecp_i_finite(H[k]);
                }
            }
        }
        CHECK(finite);
    }

    /* the deepest point of a ball is r / 2 deep in this measure, of an ellipsoid a_min / 2 */
    for (int i = 1; i < 4; i++) {
        const ecp_real least[4] = {0, ECP_R(0.8), ECP_R(0.5), ECP_R(0.4)};
        CHECK_NEAR(shapes_largest_f(&s[i], s[i].centre), ECP_R(-0.5) * least[i], ECP_R(4) * EPS);
    }
}

/* bisection ends within EPS of the surface, on which rounding turns a gradient by EPS / (radius of
   curvature) */
static void test_shape_unit_gradients(void)
{
    ecp_shape s[SHAPES_COUNT];

    shapes_random_state = 14u;
    shapes_make_all(s);
    for (int i = 1; i < SHAPES_COUNT; i++) {
        const ecp_real tolerance = ECP_R(30) * EPS / shapes_sharpness(&s[i]);
        for (int sample = 0; sample < 100; sample++) {
            ecp_real n[3], x[3], f[SHAPES_MAX_PLANES], g[3 * SHAPES_MAX_PLANES];
            int active = 0;
            shapes_random_unit(n);
            (void)shapes_leave(&s[i], n, x);
            s[i].cls->eval(&s[i], x, f, g);
            for (int j = 0; j < s[i].inequalities; j++) {
                if (ecp_i_abs(f[j]) <= ECP_R(10) * EPS) {
                    CHECK_NEAR(ecp_i_norm(g + 3 * j), ECP_R(1), tolerance);
                    CHECK(ecp_i_dot(g + 3 * j, n) > ECP_R(0));
                    ++active;
                }
            }
            CHECK(active >= 1);
        }
    }
}

/* f is a length: near the surface it is the signed distance to first order, on both sides. At a
   distance d along the normal the error is of order d^2 / (2 r) */
static void test_shape_f_is_a_distance(void)
{
    const ecp_real d = PICK(1e-3, 1e-5);
    ecp_shape s[SHAPES_COUNT];

    shapes_random_state = 15u;
    shapes_make_all(s);
    for (int i = 1; i < 9; i++) {
        for (int sample = 0; sample < 50; sample++) {
            ecp_real n[3], x[3], f[3], g[9], fy[3];
            int j = 0;
            shapes_random_unit(n);
            (void)shapes_leave(&s[i], n, x);
            s[i].cls->eval(&s[i], x, f, g);
            for (int k = 1; k < s[i].inequalities; k++) {
                j = f[k] > f[j] ? k : j;
            }
            for (int side = -1; side <= 1; side += 2) {
                ecp_real y[3];
                for (int k = 0; k < 3; k++) {
                    y[k] = x[k] + (ecp_real)side * d * g[3 * j + k];
                }
                s[i].cls->eval(&s[i], y, fy, NULL);
                CHECK_NEAR(fy[j], (ecp_real)side * d, ECP_R(10) * d * d + ECP_R(20) * EPS);
            }
        }
    }
}

/* ---- support points */

/* on the surface, farther than all else, and with n in the normal cone. A support function is
   accurate to EPS; the point itself only to EPS / (angle), which is what the normal cone sees */
static void test_shape_support(void)
{
    ecp_shape s[SHAPES_COUNT];

    shapes_random_state = 21u;
    shapes_make_all(s);
    for (int i = 1; i < SHAPES_COUNT; i++) {
        const ecp_real tolerance = ECP_R(20) * EPS;
        for (int sample = 0; sample < 60; sample++) {
            ecp_real n[3], x[3], f[SHAPES_MAX_PLANES], g[3 * SHAPES_MAX_PLANES], d[3];
            int active[SHAPES_MAX_PLANES], count = 0, farthest = 1;

            shapes_random_unit(n);
            s[i].cls->support(&s[i], n, ECP_R(0), x);
            CHECK_NEAR(shapes_largest_f(&s[i], x), ECP_R(0), tolerance);
            for (int other = 0; other < 100; other++) {
                ecp_real u[3], y[3];
                shapes_random_unit(u);
                (void)shapes_leave(&s[i], u, y);
                farthest = farthest && ecp_i_dot(n, y) <= ecp_i_dot(n, x) + tolerance;
            }
            CHECK(farthest);
            s[i].cls->eval(&s[i], x, f, g);
            for (int j = 0; j < s[i].inequalities; j++) {
                if (ecp_i_abs(f[j]) <= tolerance) {
                    active[count++] = j;
                }
            }
            CHECK(shapes_cone_residual(g, active, count, n) <=
                  ECP_R(30) * EPS / shapes_sharpness(&s[i]));
            for (int k = 0; k < 3; k++) {
                d[k] = x[k] - s[i].centre[k];
            }
            CHECK(ecp_i_norm(d) <= s[i].radius + tolerance);
        }
        CHECK(shapes_largest_f(&s[i], s[i].centre) < ECP_R(-0.05));
    }
}

/* the radius is the least one: some point of the surface reaches it */
static void test_shape_radius_is_least(void)
{
    ecp_shape s[SHAPES_COUNT];

    shapes_random_state = 22u;
    shapes_make_all(s);
    for (int i = 1; i < SHAPES_COUNT; i++) {
        ecp_real most = ECP_R(0);
        for (int sample = 0; sample < 4000; sample++) {
            ecp_real n[3], x[3], d[3];
            shapes_random_unit(n);
            s[i].cls->support(&s[i], n, ECP_R(0), x);
            for (int k = 0; k < 3; k++) {
                d[k] = x[k] - s[i].centre[k];
            }
            most = ecp_i_max(most, ecp_i_norm(d));
        }
        /* some of 4000 directions is within 0.06 rad of the right one: second order in that */
        CHECK(most <= s[i].radius + ECP_R(20) * EPS && most >= ECP_R(0.99) * s[i].radius);
    }
}

static void shapes_check_support(const ecp_shape *s, ecp_real nx, ecp_real ny, ecp_real nz,
                                 ecp_real flat, ecp_real x, ecp_real y, ecp_real z)
{
    const ecp_real length = ecp_i_sqrt(nx * nx + ny * ny + nz * nz);
    const ecp_real n[3] = {nx / length, ny / length, nz / length};
    ecp_real at[3];
    s->cls->support(s, n, flat, at);
    CHECK_NEAR(at[0], x, ECP_R(20) * EPS);
    CHECK_NEAR(at[1], y, ECP_R(20) * EPS);
    CHECK_NEAR(at[2], z, ECP_R(20) * EPS);
}

/* middles of faces and edges: exact ties at flat = 0, and within the angle otherwise */
static void test_shape_support_flat(void)
{
    const ecp_real tilt = ECP_R(0.01), half[3] = {ECP_R(0.4), ECP_R(0.7), ECP_R(1.2)};
    const ecp_real q = ecp_i_sqrt(ECP_R(0.5));
    const ecp_real lo[3] = {0, 0, 0}, hi[3] = {ECP_R(2), ECP_R(4), ECP_R(6)};
    ecp_real planes[6 * 4], vertices[8 * 3], x[3];
    const ecp_real z_axis[3] = {0, 0, ECP_R(1)};
    ecp_shape s;

    CHECK(ecp_shape_box(&s, half) == ECP_OK);
    shapes_check_support(&s, 0, 0, ECP_R(-1), 0, 0, 0, -half[2]);
    shapes_check_support(&s, ECP_R(1), ECP_R(1), 0, 0, half[0], half[1], 0);
    shapes_check_support(&s, tilt, -tilt, ECP_R(1), 0, half[0], -half[1], half[2]);
    shapes_check_support(&s, tilt, -tilt, ECP_R(1), ECP_R(2) * tilt, 0, 0, half[2]);
    shapes_check_support(&s, ECP_R(1), tilt, ECP_R(1), ECP_R(2) * tilt, half[0], 0, half[2]);

    CHECK(ecp_shape_cylinder(&s, ECP_R(0.6), ECP_R(0.9)) == ECP_OK);
    shapes_check_support(&s, 0, 0, ECP_R(1), 0, 0, 0, ECP_R(0.9));
    shapes_check_support(&s, 0, ECP_R(-1), 0, 0, 0, ECP_R(-0.6), 0);
    shapes_check_support(&s, tilt, 0, ECP_R(-1), 0, ECP_R(0.6), 0, ECP_R(-0.9));
    shapes_check_support(&s, tilt, 0, ECP_R(-1), ECP_R(2) * tilt, 0, 0, ECP_R(-0.9));
    shapes_check_support(&s, ECP_R(1), ECP_R(1), tilt, 0, ECP_R(0.6) * q, ECP_R(0.6) * q,
                         ECP_R(0.9));
    shapes_check_support(&s, ECP_R(1), ECP_R(1), tilt, ECP_R(2) * tilt, ECP_R(0.6) * q,
                         ECP_R(0.6) * q, 0);

    CHECK(ecp_shape_capsule(&s, ECP_R(0.5), ECP_R(0.7)) == ECP_OK);
    shapes_check_support(&s, ECP_R(1), 0, 0, 0, ECP_R(0.5), 0, 0);
    shapes_check_support(&s, ECP_R(3), 0, ECP_R(4), 0, ECP_R(0.3), 0, ECP_R(1.1));
    shapes_check_support(&s, ECP_R(1), 0, -tilt, ECP_R(2) * tilt, ECP_R(0.5), 0, 0);
    shapes_check_support(&s, 0, 0, ECP_R(1), ECP_R(0.1), 0, 0, ECP_R(1.2));

    /* radii 1 and 0.25 at z = -+0.5: k = -3/4, and the side's normal is (4, 0, 3) / 5 */
    CHECK(ecp_shape_frustum(&s, ECP_R(1), ECP_R(0.25), ECP_R(0.5)) == ECP_OK);
    shapes_check_support(&s, 0, 0, ECP_R(1), 0, 0, 0, ECP_R(0.5));
    shapes_check_support(&s, ECP_R(4), 0, ECP_R(3), ECP_R(4) * EPS, ECP_R(0.625), 0, 0);
    shapes_check_support(&s, ECP_R(4), 0, ECP_R(3) + tilt, 0, ECP_R(0.25), 0, ECP_R(0.5));
    shapes_check_support(&s, ECP_R(4), 0, ECP_R(3) - tilt, 0, ECP_R(1), 0, ECP_R(-0.5));
    shapes_check_support(&s, ECP_R(4), 0, ECP_R(3) + tilt, tilt, ECP_R(0.625), 0, 0);

    /* a box again, as a polytope with a corner at the origin */
    shapes_make_box_planes(planes, lo, hi);
    CHECK(ecp_shape_polytope(&s, planes, 6, vertices, 8) == ECP_OK);
    shapes_check_support(&s, 0, 0, ECP_R(1), 0, ECP_R(1), ECP_R(2), ECP_R(6));
    shapes_check_support(&s, 0, ECP_R(-1), ECP_R(1), 0, ECP_R(1), 0, ECP_R(6));
    shapes_check_support(&s, tilt, tilt, ECP_R(1), 0, ECP_R(2), ECP_R(4), ECP_R(6));
    shapes_check_support(&s, tilt, tilt, ECP_R(1), ECP_R(2) * tilt, ECP_R(1), ECP_R(2), ECP_R(6));
    shapes_check_support(&s, ECP_R(1), tilt, ECP_R(1), ECP_R(2) * tilt, ECP_R(2), ECP_R(2),
                         ECP_R(6));

    /* `flat` is the sine of the tilt: just above it, and just below */
    shapes_check_support(&s, tilt, 0, ECP_R(1), ECP_R(1.1) * tilt, ECP_R(1), ECP_R(2), ECP_R(6));
    shapes_check_support(&s, tilt, 0, ECP_R(1), ECP_R(0.9) * tilt, ECP_R(2), ECP_R(2), ECP_R(6));
    shapes_check_support(&s, ECP_R(-1), tilt, 0, ECP_R(1.1) * tilt, 0, ECP_R(2), ECP_R(3));
    shapes_check_support(&s, ECP_R(-1), tilt, 0, ECP_R(0.9) * tilt, 0, ECP_R(4), ECP_R(3));
    shapes_check_support(&s, 0, ECP_R(1), -tilt, ECP_R(1.1) * tilt, ECP_R(1), ECP_R(4), ECP_R(3));
    shapes_check_support(&s, 0, ECP_R(1), -tilt, ECP_R(0.9) * tilt, ECP_R(1), ECP_R(4), 0);
    CHECK(ecp_shape_frustum(&s, ECP_R(1), ECP_R(0.25), ECP_R(0.5)) == ECP_OK);
    for (int side = -1; side <= 1; side += 2) {
        const ecp_real t = (ecp_real)side * tilt; /* along the generator (-3, 0, 4) / 5 */
        const ecp_real nx = ECP_R(4) - ECP_R(3) * t, nz = ECP_R(3) + ECP_R(4) * t;
        shapes_check_support(&s, nx, 0, nz, ECP_R(1.1) * tilt, ECP_R(0.625), 0, 0);
        shapes_check_support(&s, nx, 0, nz, ECP_R(0.9) * tilt, side > 0 ? ECP_R(0.25) : ECP_R(1), 0,
                             side > 0 ? ECP_R(0.5) : ECP_R(-0.5));
    }

    /* a half-space: the boundary point nearest the origin */
    CHECK(ecp_shape_half_space(&s, z_axis, ECP_R(-3)) == ECP_OK);
    s.cls->support(&s, z_axis, 0, x);
    CHECK(x[0] == 0 && x[1] == 0 && x[2] == ECP_R(-3));
}

static void test_shape_bounds(void)
{
    const ecp_real extent[SHAPES_COUNT][3] = {{0, 0, 0},
                                              {ECP_R(0.8), ECP_R(0.8), ECP_R(0.8)},
                                              {ECP_R(0.5), ECP_R(1.1), ECP_R(0.8)},
                                              {ECP_R(0.9), ECP_R(0.9), ECP_R(0.4)},
                                              {ECP_R(0.5), ECP_R(0.5), ECP_R(1.2)},
                                              {ECP_R(0.5), ECP_R(0.5), ECP_R(0.5)},
                                              {ECP_R(0.6), ECP_R(0.6), ECP_R(0.9)},
                                              {ECP_R(0.9), ECP_R(0.9), ECP_R(0.6)},
                                              {ECP_R(1), ECP_R(1), ECP_R(0.5)},
                                              {ECP_R(0.8), ECP_R(0.8), ECP_R(0.7)},
                                              {ECP_R(0.4), ECP_R(0.7), ECP_R(1.2)},
                                              {ECP_R(1), ECP_R(1), ECP_R(1)},
                                              {0, 0, 0}};
    const ecp_real down[3] = {0, ECP_R(-2), 0}, tilted[3] = {PICK(1e-4, 1e-9), 0, 1};
    ecp_shape s[SHAPES_COUNT];
    ecp_real lo[3], hi[3];

    shapes_random_state = 23u;
    shapes_make_all(s);
    for (int i = 1; i < SHAPES_COUNT - 1; i++) {
        ecp_shape_bounds(&s[i], lo, hi);
        for (int k = 0; k < 3; k++) {
            CHECK_NEAR(hi[k], extent[i][k], ECP_R(8) * EPS);
            CHECK_NEAR(lo[k], -extent[i][k], ECP_R(8) * EPS);
        }
    }

    /* the random polytope: its vertices' own bounds */
    ecp_shape_bounds(&s[12], lo, hi);
    for (int k = 0; k < 3; k++) {
        ecp_real most = ECP_R(-9), least = ECP_R(9);
        for (int v = 0; v < s[12].vertex_count; v++) {
            most = ecp_i_max(most, s[12].vertices[3 * v + k]);
            least = ecp_i_min(least, s[12].vertices[3 * v + k]);
        }
        CHECK_NEAR(hi[k], most, ECP_R(20) * EPS);
        CHECK_NEAR(lo[k], least, ECP_R(20) * EPS);
    }

    /* half-spaces: -2 y <= 3 ends at y = -1.5 on one side only; a slanted one ends nowhere */
    CHECK(ecp_shape_half_space(&s[0], down, ECP_R(3)) == ECP_OK);
    ecp_shape_bounds(&s[0], lo, hi);
    CHECK(lo[1] == ECP_R(-1.5) && hi[1] == ECP_R(1e30));
    CHECK(lo[0] == ECP_R(-1e30) && hi[0] == ECP_R(1e30) && lo[2] == ECP_R(-1e30));
    shapes_make_all(s);
    ecp_shape_bounds(&s[0], lo, hi);
    CHECK(lo[0] == ECP_R(-1e30) && hi[0] == ECP_R(1e30) && lo[1] == ECP_R(-1e30));
    CHECK(hi[1] == ECP_R(1e30) && lo[2] == ECP_R(-1e30) && hi[2] == ECP_R(1e30));

    /* one that is tilted by less than its normal's third component shows ends nowhere either */
    CHECK(ecp_shape_half_space(&s[0], tilted, ECP_R(2)) == ECP_OK && s[0].size[2] == 1);
    ecp_shape_bounds(&s[0], lo, hi);
    CHECK(lo[0] == ECP_R(-1e30) && hi[0] == ECP_R(1e30) && lo[2] == ECP_R(-1e30));
    CHECK(hi[2] == ECP_R(1e30));
}

/* the constructor scales normal and offset together: the set is what was asked for */
static void test_shape_half_space(void)
{
    const ecp_real normal[3] = {ECP_R(2), ECP_R(-4), ECP_R(4)}, zero[3] = {0, 0, 0};
    const ecp_real tiny[3] = {0, PICK(1e-38, 1e-300), 0};
    const ecp_real on[3] = {ECP_R(1), ECP_R(-0.5), ECP_R(1)}; /* normal.on = 8 */
    ecp_real f[1], g[3];
    ecp_shape s;

    CHECK(ecp_shape_half_space(&s, normal, ECP_R(8)) == ECP_OK);
    s.cls->eval(&s, on, f, g);
    CHECK_NEAR(f[0], ECP_R(0), ECP_R(4) * EPS);
    s.cls->eval(&s, zero, f, g);
    CHECK_NEAR(f[0], ECP_R(-8) / ECP_R(6), ECP_R(4) * EPS);
    CHECK_NEAR(g[0], ECP_R(1) / ECP_R(3), ECP_R(4) * EPS);
    CHECK_NEAR(g[1], ECP_R(-2) / ECP_R(3), ECP_R(4) * EPS);
    CHECK_NEAR(ecp_i_norm(g), ECP_R(1), ECP_R(4) * EPS);
    CHECK(s.radius < ECP_R(0) && s.cls->hess == NULL);
    s.cls->eval(&s, s.centre, f, NULL);
    CHECK_NEAR(f[0], ECP_R(0), ECP_R(4) * EPS);

    /* a normal whose square underflows is still a direction */
    CHECK(ecp_shape_half_space(&s, tiny, ECP_R(0)) == ECP_OK);
    CHECK(s.size[1] == ECP_R(1));
}

/* ---- mass properties */

/* relative to the mass, to 1 m, and to the trace of the inertia */
static void shapes_check_mass(const ecp_mass *m, const ecp_mass *expected, ecp_real tolerance)
{
    const ecp_real trace = expected->inertia[0] + expected->inertia[4] + expected->inertia[8];
    CHECK_NEAR(m->mass, expected->mass, tolerance * expected->mass);
    for (int k = 0; k < 3; k++) {
        CHECK_NEAR(m->centre[k], expected->centre[k], tolerance);
    }
    for (int k = 0; k < 9; k++) {
        CHECK_NEAR(m->inertia[k], expected->inertia[k], tolerance * trace);
    }
}

static ecp_mass shapes_diagonal_mass(ecp_real mass, ecp_real z, ecp_real ixx, ecp_real iyy,
                                     ecp_real izz)
{
    ecp_mass m;
    memset(&m, 0, sizeof m);
    m.mass = mass;
    m.centre[2] = z;
    m.inertia[0] = ixx;
    m.inertia[4] = iyy;
    m.inertia[8] = izz;
    return m;
}

/* solids of revolution, from nothing but eval: rho(z)^2 by bisection, and the integrals of
   pi rho^2, pi rho^2 z, pi rho^2 z^2 and pi rho^4 / 2 over z by Gauss' rule with three points.
   It is exact, because rho^2 is a quadratic in z on each of the pieces */
static ecp_mass shapes_revolve(const ecp_shape *s, const ecp_real *ends, int pieces)
{
    const ecp_real node = ecp_i_sqrt(ECP_R(0.6));
    ecp_real volume = 0, first = 0, second = 0, polar = 0, across;

    for (int piece = 0; piece < pieces; piece++) {
        const ecp_real middle = ECP_R(0.5) * (ends[piece] + ends[piece + 1]);
        const ecp_real half = ECP_R(0.5) * (ends[piece + 1] - ends[piece]);
        for (int j = -1; j <= 1; j++) {
            const ecp_real z = middle + (ecp_real)j * node * half;
            const ecp_real weight = half * (j == 0 ? ECP_R(8) : ECP_R(5)) / ECP_R(9);
            ecp_real lo = 0, hi = ECP_R(2) * s->radius, area;
            for (int round = 0; round < 60; round++) {
                const ecp_real x[3] = {ECP_R(0.5) * (lo + hi), 0, z};
                if (shapes_largest_f(s, x) <= ECP_R(0)) {
                    lo = x[0];
                } else {
                    hi = x[0];
                }
            }
            area = PI * lo * lo;
            volume += weight * area;
            first += weight * area * z;
            second += weight * area * z * z;
            polar += weight * area * lo * lo * ECP_R(0.5);
        }
    }
    across = ECP_R(0.5) * polar + second - first * first / volume;
    return shapes_diagonal_mass(volume, first / volume, across, across, polar);
}

static void test_shape_mass_of_revolution(void)
{
    ecp_shape s[SHAPES_COUNT];
    ecp_mass m, expected;

    shapes_random_state = 31u;
    shapes_make_all(s);
    for (int i = 1; i < 10; i++) {
        ecp_real ends[4] = {0, 0, 0, 0}, lo[3], hi[3];
        int pieces = 1;
        if (s[i].kind == ECP_ELLIPSOID && i == 2) {
            continue; /* not of revolution */
        }
        ecp_shape_bounds(&s[i], lo, hi);
        ends[0] = lo[2];
        ends[1] = hi[2];
        if (s[i].kind == ECP_CAPSULE) {
            ends[1] = -s[i].size[1];
            ends[2] = s[i].size[1];
            ends[3] = hi[2];
            pieces = 3;
        }
        expected = shapes_revolve(&s[i], ends, pieces);
        ecp_shape_mass(&s[i], ECP_R(1), &m);
        shapes_check_mass(&m, &expected, ECP_R(40) * EPS);
        for (int k = 0; k < 3; k++) {
            CHECK_NEAR(s[i].centre[k], m.centre[k], ECP_R(4) * EPS);
        }
    }
}

/* textbook values */
static void test_shape_mass_closed_forms(void)
{
    const ecp_real half[3] = {ECP_R(0.5), ECP_R(1), ECP_R(1.5)}, density = ECP_R(700);
    const ecp_real tolerance = ECP_R(20) * EPS;
    const ecp_real tip = PICK(1e-3, 1e-5);
    ecp_shape s;
    ecp_mass m, other, expected;

    /* box: m (b^2 + c^2) / 12 of the full edges 1, 2, 3 */
    CHECK(ecp_shape_box(&s, half) == ECP_OK);
    ecp_shape_mass(&s, density, &m);
    expected = shapes_diagonal_mass(4200, 0, ECP_R(4550), ECP_R(3500), ECP_R(1750));
    shapes_check_mass(&m, &expected, tolerance);

    /* ball: 2/5 m r^2; a capsule of no length and a round ellipsoid are balls */
    CHECK(ecp_shape_sphere(&s, ECP_R(2)) == ECP_OK);
    ecp_shape_mass(&s, ECP_R(3), &m);
    expected = shapes_diagonal_mass(ECP_R(32) * PI, 0, ECP_R(51.2) * PI, ECP_R(51.2) * PI,
                                    ECP_R(51.2) * PI);
    shapes_check_mass(&m, &expected, tolerance);
    CHECK(ecp_shape_capsule(&s, ECP_R(2), ECP_R(0)) == ECP_OK);
    ecp_shape_mass(&s, ECP_R(3), &other);
    shapes_check_mass(&other, &m, tolerance);

    /* ellipsoid: m (b^2 + c^2) / 5 */
    CHECK(ecp_shape_ellipsoid(&s, half) == ECP_OK);
    ecp_shape_mass(&s, ECP_R(1), &m);
    expected = shapes_diagonal_mass(PI, 0, ECP_R(0.65) * PI, ECP_R(0.5) * PI, ECP_R(0.25) * PI);
    shapes_check_mass(&m, &expected, tolerance);

    /* cylinder, r = 1, height 2: m r^2 / 2, m (3 r^2 + H^2) / 12; a frustum of equal radii is one */
    CHECK(ecp_shape_cylinder(&s, ECP_R(1), ECP_R(1)) == ECP_OK);
    ecp_shape_mass(&s, ECP_R(1), &m);
    expected = shapes_diagonal_mass(ECP_R(2) * PI, 0, ECP_R(14) / ECP_R(12) * PI,
                                    ECP_R(14) / ECP_R(12) * PI, PI);
    shapes_check_mass(&m, &expected, tolerance);
    CHECK(ecp_shape_frustum(&s, ECP_R(1), ECP_R(1), ECP_R(1)) == ECP_OK);
    ecp_shape_mass(&s, ECP_R(1), &other);
    shapes_check_mass(&other, &m, tolerance);

    /* cone, r = 1, height 2: m = pi r^2 H / 3, centre H / 4 above the base, 3/10 m r^2 and
       3/20 m r^2 + 3/80 m H^2. The blunt tip adds a volume of relative size tip */
    CHECK(ecp_shape_frustum(&s, ECP_R(1), ECP_R(0), ECP_R(1)) == ECP_OK);
    ecp_shape_mass(&s, ECP_R(1), &m);
    expected = shapes_diagonal_mass(ECP_R(2) / ECP_R(3) * PI, ECP_R(-0.5), ECP_R(0.2) * PI,
                                    ECP_R(0.2) * PI, ECP_R(0.2) * PI);
    shapes_check_mass(&m, &expected, ECP_R(2) * tip);
    CHECK(m.mass > expected.mass);

    /* upside down, only the centre moves */
    CHECK(ecp_shape_frustum(&s, ECP_R(0), ECP_R(1), ECP_R(1)) == ECP_OK);
    ecp_shape_mass(&s, ECP_R(1), &other);
    m.centre[2] = -m.centre[2];
    shapes_check_mass(&other, &m, tolerance);

    /* capsule, r = 1, segment of length 2: cylinder 2 pi and ball 4/3 pi */
    CHECK(ecp_shape_capsule(&s, ECP_R(1), ECP_R(1)) == ECP_OK);
    ecp_shape_mass(&s, ECP_R(1), &m);
    expected = shapes_diagonal_mass(ECP_R(10) / ECP_R(3) * PI, 0, ECP_R(0), 0, 0);
    expected.inertia[8] = PI + ECP_R(8) / ECP_R(15) * PI;
    /* half balls: 83/320 m r^2 about their own centres, which are h + 3/8 r away */
    expected.inertia[0] = ECP_R(14) / ECP_R(12) * PI +
                          ECP_R(4) / ECP_R(3) * PI * (ECP_R(83) / ECP_R(320) + ECP_R(1.890625));
    expected.inertia[4] = expected.inertia[0];
    shapes_check_mass(&m, &expected, tolerance);
}

/* a tip is raised, as stated, and never above the other radius; the larger radius stays */
static void test_shape_frustum_tip(void)
{
    const ecp_real tip = PICK(1e-3, 1e-5);
    ecp_shape s;

    CHECK(ecp_shape_frustum(&s, ECP_R(2), ECP_R(0), ECP_R(0.5)) == ECP_OK);
    CHECK(s.size[0] == ECP_R(2) && s.size[2] == ECP_R(0.5));
    CHECK_NEAR(s.size[1], ECP_R(2) * tip, ECP_R(4) * EPS * tip);
    CHECK(ecp_shape_frustum(&s, ECP_R(0), ECP_R(0.5), ECP_R(4)) == ECP_OK);
    CHECK_NEAR(s.size[0], ECP_R(4) * tip, ECP_R(8) * EPS * tip);
    CHECK(ecp_shape_frustum(&s, ECP_R(0), ECP_R(0.25) * tip, ECP_R(1)) == ECP_OK);
    CHECK(s.size[0] == ECP_R(0.25) * tip && s.size[1] == s.size[0]);
}

static void test_shape_mass_add(void)
{
    const ecp_real half[3] = {ECP_R(1), ECP_R(0.6), ECP_R(0.4)};
    const ecp_real part_half[3] = {ECP_R(0.5), ECP_R(0.6), ECP_R(0.4)};
    const ecp_real turned_half[3] = {ECP_R(0.6), ECP_R(0.5), ECP_R(0.4)};
    const ecp_real left[3] = {ECP_R(-0.5), 0, 0}, right[3] = {ECP_R(0.5), 0, 0};
    const ecp_real none[4] = {ECP_R(1), 0, 0, 0}, origin[3] = {0, 0, 0};
    const ecp_real quarter[4] = {ECP_R(3), 0, 0, ECP_R(3)}; /* 90 degrees about z, not normalised */
    const ecp_real turn[4] = {ECP_R(0.5), ECP_R(-0.1), ECP_R(0.7), ECP_R(0.3)};
    const ecp_real back[4] = {ECP_R(0.5), ECP_R(0.1), ECP_R(-0.7), ECP_R(-0.3)};
    const ecp_real away[3] = {ECP_R(0.3), ECP_R(-1), ECP_R(2)};
    const ecp_real z_quarter[3] = {0, ECP_R(1), 0};
    const ecp_real tolerance = ECP_R(20) * EPS;
    ecp_shape whole, part, turned, cone;
    ecp_mass expected, m, total, nothing;

    memset(&nothing, 0, sizeof nothing);
    CHECK(ecp_shape_box(&whole, half) == ECP_OK);
    CHECK(ecp_shape_box(&part, part_half) == ECP_OK);
    CHECK(ecp_shape_box(&turned, turned_half) == ECP_OK);
    ecp_shape_mass(&whole, ECP_R(5), &expected);

    /* two halves make a whole, one of them turned */
    total = nothing;
    ecp_shape_mass(&part, ECP_R(5), &m);
    ecp_mass_add(&total, &m, left, none);
    ecp_shape_mass(&turned, ECP_R(5), &m);
    ecp_mass_add(&total, &m, right, quarter);
    shapes_check_mass(&total, &expected, tolerance);

    /* and a cavity in the place of one half leaves the other */
    ecp_shape_mass(&part, ECP_R(-5), &m);
    ecp_mass_add(&total, &m, left, none);
    ecp_shape_mass(&part, ECP_R(5), &expected);
    expected.centre[0] = ECP_R(0.5);
    shapes_check_mass(&total, &expected, ECP_R(3) * tolerance);

    /* the quaternion turns the way that (w, x, y, z) should: z to x to y about (1, 1, 1) */
    {
        const ecp_real third[4] = {ECP_R(1), ECP_R(1), ECP_R(1), ECP_R(1)};
        CHECK(ecp_shape_frustum(&cone, ECP_R(1), ECP_R(0.5), ECP_R(1)) == ECP_OK);
        ecp_shape_mass(&cone, ECP_R(1), &m);
        total = nothing;
        ecp_mass_add(&total, &m, z_quarter, third);
        CHECK_NEAR(total.centre[0], m.centre[2], tolerance);
        CHECK_NEAR(total.centre[1], ECP_R(1), tolerance);
        CHECK_NEAR(total.inertia[0], m.inertia[8], tolerance * m.inertia[8]);
        CHECK_NEAR(total.inertia[8], m.inertia[4], tolerance * m.inertia[8]);
    }

    /* there and back again: rotate, then undo; trace, symmetry and mass are kept on the way */
    ecp_shape_mass(&whole, ECP_R(5), &m);
    total = nothing;
    ecp_mass_add(&total, &m, origin, turn);
    CHECK_NEAR(total.inertia[0] + total.inertia[4] + total.inertia[8],
               m.inertia[0] + m.inertia[4] + m.inertia[8], tolerance * ECP_R(50));
    CHECK(total.inertia[1] == total.inertia[3] && total.inertia[5] == total.inertia[7]);
    CHECK(ecp_i_abs(total.inertia[1]) > ECP_R(0.1));
    expected = nothing;
    ecp_mass_add(&expected, &total, origin, back);
    shapes_check_mass(&expected, &m, tolerance);

    /* one point of mass at a distance: I = mu (|d|^2 - d d^T) on top */
    total = m;
    memset(m.inertia, 0, sizeof m.inertia);
    ecp_mass_add(&total, &m, away, turn);
    {
        ecp_mass alone;
        const ecp_real mu = ECP_R(0.5) * m.mass;
        ecp_shape_mass(&whole, ECP_R(5), &alone);
        CHECK_NEAR(total.centre[1], ECP_R(-0.5), tolerance);
        CHECK_NEAR(total.inertia[0] - alone.inertia[0], mu * ECP_R(5), tolerance * ECP_R(100));
        CHECK_NEAR(total.inertia[1], mu * ECP_R(0.3), tolerance * ECP_R(100));
        CHECK_NEAR(total.inertia[5], mu * ECP_R(2), tolerance * ECP_R(100));
    }

    /* nothing and nothing is nothing, not NaN */
    total = nothing;
    ecp_mass_add(&total, &nothing, away, turn);
    CHECK(memcmp(&total, &nothing, sizeof total) == 0);
}

/* ---- polytopes */

/* every box as a polytope, wherever it is, with redundant planes added */
static void test_shape_polytope_box(void)
{
    const ecp_real half[3] = {ECP_R(0.4), ECP_R(0.7), ECP_R(1.2)};
    const ecp_real diagonal = ECP_R(1) / ecp_i_sqrt(ECP_R(3));
    const ecp_real shifts[2] = {0, ECP_R(7)};
    ecp_shape box, s;
    ecp_mass expected, m;

    CHECK(ecp_shape_box(&box, half) == ECP_OK);
    ecp_shape_mass(&box, ECP_R(1), &expected);
    for (int c = 0; c < 2; c++) {
        ecp_real planes[10 * 4], vertices[16 * 3], lo[3], hi[3];
        for (int k = 0; k < 3; k++) {
            lo[k] = shifts[c] - half[k];
            hi[k] = shifts[c] + half[k];
            expected.centre[k] = shifts[c];
        }
        shapes_make_box_planes(planes, lo, hi);

        /* repeats a face, touches a corner, touches an edge, and is far away */
        memcpy(planes + 24, planes + 8, 4 * sizeof(ecp_real));
        ecp_i_set3(diagonal, diagonal, diagonal, planes + 28);
        planes[31] = diagonal * (hi[0] + hi[1] + hi[2]);
        ecp_i_set3(ECP_R(0.6), 0, ECP_R(-0.8), planes + 32);
        planes[35] = ECP_R(0.6) * hi[0] - ECP_R(0.8) * lo[2];
        ecp_i_set3(0, ECP_R(0.6), ECP_R(0.8), planes + 36);
        planes[39] = ECP_R(1000);
        for (int count = 6; count <= 10; count++) {
            CHECK(ecp_shape_polytope(&s, planes, count, vertices, 16) == ECP_OK);
            CHECK(s.vertex_count == 8 && s.inequalities == count && s.cls->hess == NULL);
            ecp_shape_mass(&s, ECP_R(1), &m);

            /* positions carry an error of EPS times the distance from the origin */
            shapes_check_mass(&m, &expected, ECP_R(30) * EPS * (ECP_R(1) + shifts[c]));
            CHECK_NEAR(s.radius, box.radius, ECP_R(10) * EPS * (ECP_R(1) + shifts[c]));
            CHECK_NEAR(s.centre[1], shifts[c], ECP_R(10) * EPS * (ECP_R(1) + shifts[c]));
        }
    }
}

/* the corner tetrahedron {x, y, z >= 0, x/a + y/b + z/c <= 1}: V = a b c / 6, centre (a, b, c) / 4,
   I_xx = 3 m (b^2 + c^2) / 80, I_xy = m a b / 80 */
static void test_shape_polytope_tetrahedron(void)
{
    const ecp_real a = ECP_R(1), b = ECP_R(2), c = ECP_R(3);
    const ecp_real length = ecp_i_sqrt(b * b * c * c + a * a * c * c + a * a * b * b) / (a * b * c);
    const ecp_real planes[16] = {ECP_R(-1),
                                 0,
                                 0,
                                 0,
                                 0,
                                 ECP_R(-1),
                                 0,
                                 0,
                                 0,
                                 0,
                                 ECP_R(-1),
                                 0,
                                 ECP_R(1) / (a * length),
                                 ECP_R(1) / (b * length),
                                 ECP_R(1) / (c * length),
                                 ECP_R(1) / length};
    ecp_real vertices[4 * 3];
    ecp_shape s;
    ecp_mass m, expected;

    CHECK(ecp_shape_polytope(&s, planes, 4, vertices, 4) == ECP_OK);
    CHECK(s.vertex_count == 4);
    ecp_shape_mass(&s, ECP_R(2), &m);
    expected = shapes_diagonal_mass(ECP_R(2), c / ECP_R(4), ECP_R(3) / ECP_R(40) * (b * b + c * c),
                                    ECP_R(3) / ECP_R(40) * (a * a + c * c),
                                    ECP_R(3) / ECP_R(40) * (a * a + b * b));
    expected.centre[0] = a / ECP_R(4);
    expected.centre[1] = b / ECP_R(4);
    expected.inertia[1] = expected.inertia[3] = a * b / ECP_R(40);
    expected.inertia[2] = expected.inertia[6] = a * c / ECP_R(40);
    expected.inertia[5] = expected.inertia[7] = b * c / ECP_R(40);
    shapes_check_mass(&m, &expected, ECP_R(30) * EPS);
}

/* regular solids have more than three planes in a vertex (octahedron 4, icosahedron 5) or many
   vertices on a face (dodecahedron 5): counts, volume and inertia from the books */
static void test_shape_polytope_regular(void)
{
    const ecp_real root5 = ecp_i_sqrt(ECP_R(5)), phi = ECP_R(0.5) * (ECP_R(1) + root5);
    const ecp_real inverse = phi - ECP_R(1), tolerance = ECP_R(50) * EPS;
    ecp_real planes[20 * 4], vertices[36 * 3], edge, scale, volume;
    ecp_shape s;
    ecp_mass m;

    /* octahedron |x| + |y| + |z| <= 1: V = 4/3, I = m / 5 */
    shapes_make_octahedron(planes, ECP_R(1));
    CHECK(ecp_shape_polytope(&s, planes, 8, vertices, 12) == ECP_OK);
    CHECK(s.vertex_count == 6);
    ecp_shape_mass(&s, ECP_R(1), &m);
    CHECK_NEAR(m.mass, ECP_R(4) / ECP_R(3), tolerance);
    CHECK_NEAR(m.inertia[0], ECP_R(4) / ECP_R(15), tolerance);
    CHECK_NEAR(m.inertia[8], ECP_R(4) / ECP_R(15), tolerance);
    CHECK_NEAR(m.inertia[1], ECP_R(0), tolerance);

    /* dodecahedron: normals (0, +-1, +-phi) and cyclic; with inner radius 1 its edge is
       2 / sqrt((25 + 11 sqrt 5) / 10), V = (15 + 7 sqrt 5) / 4 edge^3 */
    scale = ECP_R(1) / ecp_i_sqrt(ECP_R(1) + phi * phi);
    for (int i = 0; i < 12; i++) {
        ecp_real *p = planes + 4 * i;
        p[i / 4] = ECP_R(0);
        p[(i / 4 + 1) % 3] = (i & 1) ? scale : -scale;
        p[(i / 4 + 2) % 3] = (i & 2) ? phi * scale : -phi * scale;
        p[3] = ECP_R(1);
    }
    CHECK(ecp_shape_polytope(&s, planes, 12, vertices, 20) == ECP_OK);
    CHECK(s.vertex_count == 20);
    edge = ECP_R(2) / ecp_i_sqrt((ECP_R(25) + ECP_R(11) * root5) / ECP_R(10));
    ecp_shape_mass(&s, ECP_R(1), &m);
    volume = (ECP_R(15) + ECP_R(7) * root5) / ECP_R(4) * edge * edge * edge;
    CHECK_NEAR(m.mass, volume, tolerance * ECP_R(5));
    CHECK_NEAR(m.inertia[0], m.inertia[4], tolerance * ECP_R(5));
    CHECK_NEAR(m.inertia[0], m.inertia[8], tolerance * ECP_R(5));

    /* icosahedron: normals (+-1, +-1, +-1) and (0, +-1/phi, +-phi) and cyclic, all of length
       sqrt 3; with inner radius 1 its edge is 12 / (sqrt 3 (3 + sqrt 5)), and
       V = 5 (3 + sqrt 5) / 12 edge^3 */
    scale = ECP_R(1) / ecp_i_sqrt(ECP_R(3));
    shapes_make_octahedron(planes, ECP_R(1) / scale);
    for (int i = 0; i < 12; i++) {
        ecp_real *p = planes + 32 + 4 * i;
        p[i / 4] = ECP_R(0);
        p[(i / 4 + 1) % 3] = (i & 1) ? inverse * scale : -inverse * scale;
        p[(i / 4 + 2) % 3] = (i & 2) ? phi * scale : -phi * scale;
        p[3] = ECP_R(1);
    }
    CHECK(ecp_shape_polytope(&s, planes, 20, vertices, 36) == ECP_OK);
    CHECK(s.vertex_count == 12);
    edge = ECP_R(12) / (ecp_i_sqrt(ECP_R(3)) * (ECP_R(3) + root5));
    ecp_shape_mass(&s, ECP_R(1), &m);
    volume = ECP_R(5) / ECP_R(12) * (ECP_R(3) + root5) * edge * edge * edge;
    CHECK_NEAR(m.mass, volume, tolerance * ECP_R(5));
    CHECK_NEAR(m.inertia[0], m.inertia[4], tolerance * ECP_R(5));
}

/* tolerances are relative: an octahedron of a millimetre or a kilometre is one all the same */
static void test_shape_polytope_scale(void)
{
    const ecp_real sizes[3] = {ECP_R(0.001), ECP_R(1), ECP_R(1000)};
    ecp_real planes[8 * 4], vertices[6 * 3];
    const ecp_real n[3] = {0, ECP_R(0.6), ECP_R(0.8)};
    ecp_shape s;
    ecp_mass m;

    for (int i = 0; i < 3; i++) {
        const ecp_real a = sizes[i];
        ecp_real x[3];
        shapes_make_octahedron(planes, a);
        CHECK(ecp_shape_polytope(&s, planes, 8, vertices, 6) == ECP_OK);
        CHECK(s.vertex_count == 6);
        ecp_shape_mass(&s, ECP_R(1), &m);
        CHECK_NEAR(m.mass / (a * a * a), ECP_R(4) / ECP_R(3), ECP_R(50) * EPS);
        CHECK_NEAR(m.inertia[4] / (a * a * a * a * a), ECP_R(4) / ECP_R(15), ECP_R(50) * EPS);
        s.cls->support(&s, n, ECP_R(0), x);
        CHECK_NEAR(x[2] / a, ECP_R(1), ECP_R(20) * EPS);
    }
}

/* the planes of a box or of a pyramid, turned at random */
static void shapes_turn_planes(ecp_real *planes, int count)
{
    ecp_real axes[3][3], length;
    shapes_random_unit(axes[0]);
    do {
        ecp_real other[3];
        shapes_random_unit(other);
        ecp_i_cross(axes[0], other, axes[1]);
        length = ecp_i_norm(axes[1]);
    } while (length < ECP_R(0.1));
    for (int k = 0; k < 3; k++) axes[1][k] /= length;
    ecp_i_cross(axes[0], axes[1], axes[2]);
    for (int i = 0; i < count; i++) {
        ecp_real n[3];
        for (int k = 0; k < 3; k++) n[k] = ecp_i_dot(axes[k], planes + 4 * i);
        ecp_i_copy3(n, planes + 4 * i);
    }
}

/* A rod, as thick as a part 1 / A of its length, has its volume to the rounding of its thickness, A eps; a pyramid
   whose offsets are all about 1 has its tip, far away, to D eps, and its volume to D^2 eps / 27 beyond that: an area
   vector of a triangle as long as D rounds to D^2 eps / 4, p is D / 5 and the volume 4 D / 3 (ecp_i_integrals_add) */
static void test_shape_polytope_slender(void)
{
    const ecp_real thin[3] = {ECP_R(10), ECP_R(100), ECP_R(1000)};
    const ecp_real far_tip[3] = {ECP_R(10), ECP_R(100), PICK(1000, 100000)};
    ecp_real planes[24], vertices[24];
    ecp_shape s;
    ecp_mass m;
    ecp_status status;

    shapes_random_state = 77u;
    for (int round = 0; round < 150; round++) {
        const ecp_real A = thin[round % 3], D = far_tip[round % 3];
        const ecp_real side = ecp_i_sqrt(1 + 1 / (D * D));
        memset(planes, 0, sizeof planes);
        for (int i = 0; i < 6; i++) {
            planes[4 * i + i / 2] = i % 2 ? ECP_R(-1) : ECP_R(1);
            planes[4 * i + 3] = i < 2 ? ECP_R(1) : 1 / A;
        }
        shapes_turn_planes(planes, 6);
        status = ecp_shape_polytope(&s, planes, 6, vertices, 8);
        CHECK(status == ECP_OK && s.vertex_count == 8);
        if (status != ECP_OK) continue;
        ecp_shape_mass(&s, ECP_R(1), &m);
        CHECK_NEAR(m.mass * A * A / 8, 1, 8 * A * EPS);
        CHECK_NEAR((m.inertia[0] + m.inertia[4] + m.inertia[8]) * A * A,
                   (2 + 4 / (A * A)) * ECP_R(8) / 3, 20 * A * EPS);

        /* half a base of 1 at z = -1, the tip at D - 1 */
        memset(planes, 0, sizeof planes);
        for (int i = 0; i < 4; i++) {
            planes[4 * i + i / 2] = (i % 2 ? ECP_R(-1) : ECP_R(1)) / side;
            planes[4 * i + 2] = 1 / (D * side);
            planes[4 * i + 3] = (1 - 1 / D) / side;
        }
        planes[18] = ECP_R(-1);
        planes[19] = ECP_R(1);
        shapes_turn_planes(planes, 5);
        status = ecp_shape_polytope(&s, planes, 5, vertices, 8);
        CHECK(status == ECP_OK);
        if (status != ECP_OK) continue;
        CHECK_NEAR(s.size[0] / (D - 1), 1, 8 * D * EPS);
        ecp_shape_mass(&s, ECP_R(1), &m);
        CHECK_NEAR(m.mass / (D * ECP_R(4) / 3), 1, (8 + D / 27) * D * EPS);
    }
}

/* planes that touch a ball are facets all of them, and no four meet, so by Euler's formula there
   are exactly 2 m - 4 vertices. A cut by a plane x = const gives two parts that make up the whole */
static void test_shape_polytope_random(void)
{
    const ecp_real none[4] = {ECP_R(1), 0, 0, 0}, origin[3] = {0, 0, 0};
    const ecp_real centre[3] = {ECP_R(0.2), ECP_R(-0.3), ECP_R(0.5)};
    static ecp_real planes[SHAPES_MAX_PLANES * 4], vertices[SHAPES_MAX_VERTICES * 3];

    shapes_random_state = 41u;
    for (int count = 14; count < 34; count++) {
        ecp_shape s;
        ecp_mass whole, part, total;

        shapes_make_tangent_planes(planes, count, ECP_R(1), centre);
        CHECK(ecp_shape_polytope(&s, planes, count, vertices, 2 * count - 4) == ECP_OK);
        CHECK(s.vertex_count == 2 * count - 4);
        ecp_shape_mass(&s, ECP_R(1), &whole);
        CHECK(whole.mass > ECP_R(4) / ECP_R(3) * PI);
        CHECK(ecp_shape_polytope(&s, planes, count, vertices, 2 * count - 5) == ECP_CAPACITY);

        memset(&total, 0, sizeof total);
        for (int side = 0; side < 2; side++) {
            ecp_real *cut = planes + 4 * count;
            ecp_i_set3(side ? ECP_R(-1) : ECP_R(1), 0, 0, cut);
            cut[3] = side ? ECP_R(-0.4) : ECP_R(0.4);
            CHECK(ecp_shape_polytope(&s, planes, count + 1, vertices, SHAPES_MAX_VERTICES) ==
                  ECP_OK);
            ecp_shape_mass(&s, ECP_R(1), &part);
            ecp_mass_add(&total, &part, origin, none);
        }

        /* vertices are good to EPS over the determinant of their normals; but a vertex that is out
           stays on its planes, so it is the polytope itself that is good to EPS */
        shapes_check_mass(&total, &whole, ECP_R(100) * EPS);
    }
}

/* ---- bad input */

static void test_shape_polytope_bad(void)
{
    const ecp_real lo[3] = {ECP_R(-1), ECP_R(-1), ECP_R(-1)};
    const ecp_real hi[3] = {ECP_R(1), ECP_R(1), ECP_R(1)};
    const ecp_real q = ecp_i_sqrt(ECP_R(0.5)), zero = ECP_R(0);
    ecp_real planes[7 * 4], vertices[16 * 3];
    ecp_shape s, before;

    memset(&before, 0x5a, sizeof before);
    memcpy(&s, &before, sizeof s);
    shapes_make_box_planes(planes, lo, hi);
    CHECK(ecp_shape_polytope(NULL, planes, 6, vertices, 16) == ECP_BAD_POINTER);
    CHECK(ecp_shape_polytope(&s, NULL, 6, vertices, 16) == ECP_BAD_POINTER);
    CHECK(ecp_shape_polytope(&s, planes, 6, NULL, 16) == ECP_BAD_POINTER);
    CHECK(ecp_shape_polytope(&s, planes, 0, vertices, 16) == ECP_BAD_SIZE);
    CHECK(ecp_shape_polytope(&s, planes, 6, vertices, 0) == ECP_BAD_SIZE);
    CHECK(ecp_shape_polytope(&s, planes, 6, vertices, 7) == ECP_CAPACITY);
    planes[3] = ECP_R(1) / zero;
    CHECK(ecp_shape_polytope(&s, planes, 6, vertices, 16) == ECP_NOT_FINITE);
    planes[3] = zero / zero;
    CHECK(ecp_shape_polytope(&s, planes, 6, vertices, 16) == ECP_NOT_FINITE);
    planes[3] = ECP_R(1);
    planes[0] = ECP_R(1.00001);
    CHECK(ecp_shape_polytope(&s, planes, 6, vertices, 16) == ECP_BAD_SIZE);
    planes[0] = ECP_R(1);
    for (int i = 0; i < 6; i++) planes[4 * i + 3] = (ecp_real)test_by(1e200, 1e30);
    CHECK(ecp_shape_polytope(&s, planes, 6, vertices, 16) == ECP_BAD_SIZE);
    shapes_make_box_planes(planes, lo, hi);

    /* unbounded: one plane; two; a slab; a corner; an open box; a prism with slanted sides */
    for (int count = 1; count < 6; count++) {
        CHECK(ecp_shape_polytope(&s, planes, count, vertices, 16) == ECP_UNBOUNDED_POLYTOPE);
    }
    ecp_i_set3(q, q, 0, planes + 16);
    planes[19] = ECP_R(1);
    ecp_i_set3(-q, q, 0, planes + 20);
    planes[23] = ECP_R(1);
    CHECK(ecp_shape_polytope(&s, planes, 6, vertices, 16) == ECP_UNBOUNDED_POLYTOPE);

    /* empty: x <= -1 and x >= 1; flat: x <= 1 and x >= 1; a box cut down to an edge and a corner */
    shapes_make_box_planes(planes, lo, hi);
    planes[3] = ECP_R(-2);
    CHECK(ecp_shape_polytope(&s, planes, 6, vertices, 16) == ECP_EMPTY_POLYTOPE);
    planes[3] = ECP_R(-1);
    CHECK(ecp_shape_polytope(&s, planes, 6, vertices, 16) == ECP_EMPTY_POLYTOPE);
    planes[3] = ECP_R(1);
    ecp_i_set3(-q, -q, 0, planes + 24);
    planes[27] = ECP_R(-2) * q;
    CHECK(ecp_shape_polytope(&s, planes, 7, vertices, 16) == ECP_EMPTY_POLYTOPE);
    ecp_i_set3(ECP_R(-0.6), ECP_R(-0.64), ECP_R(-0.48), planes + 24);
    planes[27] = ECP_R(-1.72);
    CHECK(ecp_shape_polytope(&s, planes, 7, vertices, 16) == ECP_EMPTY_POLYTOPE);

    /* a single point, the origin */
    {
        const ecp_real origin[3] = {0, 0, 0};
        shapes_make_box_planes(planes, origin, origin);
        CHECK(ecp_shape_polytope(&s, planes, 6, vertices, 16) == ECP_EMPTY_POLYTOPE);
    }
    CHECK(memcmp(&s, &before, sizeof s) == 0);

    /* thin is not flat */
    shapes_make_box_planes(planes, lo, hi);
    planes[3] = ECP_R(-1) + PICK(1e-3, 1e-7);
    CHECK(ecp_shape_polytope(&s, planes, 6, vertices, 8) == ECP_OK);
    CHECK(s.vertex_count == 8);
}

static void test_shape_bad_input(void)
{
    const ecp_real zero = ECP_R(0), one = ECP_R(1);
    const ecp_real bad[4] = {zero / zero, one / zero, zero, -one};
    const ecp_status why[4] = {ECP_NOT_FINITE, ECP_NOT_FINITE, ECP_BAD_SIZE, ECP_BAD_SIZE};
    const ecp_real origin[3] = {0, 0, 0};
    const ecp_shape_class empty = {NULL, NULL, NULL, NULL};
    ecp_shape s, before;

    memset(&before, 0x5a, sizeof before);
    memcpy(&s, &before, sizeof s);
    CHECK(ecp_shape_half_space(NULL, origin, one) == ECP_BAD_POINTER);
    CHECK(ecp_shape_half_space(&s, NULL, one) == ECP_BAD_POINTER);
    CHECK(ecp_shape_half_space(&s, origin, one) == ECP_BAD_SIZE);
    CHECK(ecp_shape_sphere(NULL, one) == ECP_BAD_POINTER);
    CHECK(ecp_shape_ellipsoid(NULL, origin) == ECP_BAD_POINTER);
    CHECK(ecp_shape_ellipsoid(&s, NULL) == ECP_BAD_POINTER);
    CHECK(ecp_shape_capsule(NULL, one, one) == ECP_BAD_POINTER);
    CHECK(ecp_shape_cylinder(NULL, one, one) == ECP_BAD_POINTER);
    CHECK(ecp_shape_frustum(NULL, one, one, one) == ECP_BAD_POINTER);
    CHECK(ecp_shape_frustum(&s, zero, zero, one) == ECP_BAD_SIZE);
    CHECK(ecp_shape_box(NULL, origin) == ECP_BAD_POINTER);
    CHECK(ecp_shape_box(&s, NULL) == ECP_BAD_POINTER);
    CHECK(ecp_shape_convex(NULL, &ecp_i_box_class, 1, origin, one, NULL) == ECP_BAD_POINTER);
    CHECK(ecp_shape_convex(&s, NULL, 1, origin, one, NULL) == ECP_BAD_POINTER);
    CHECK(ecp_shape_convex(&s, &empty, 1, origin, one, NULL) == ECP_BAD_POINTER);
    CHECK(ecp_shape_convex(&s, &ecp_i_box_class, 1, NULL, one, NULL) == ECP_BAD_POINTER);
    CHECK(ecp_shape_convex(&s, &ecp_i_box_class, 0, origin, one, NULL) == ECP_BAD_SIZE);
    /* sizes of which the squares are no numbers, or nothing; or that of the way to a corner is none */
    {
        const ecp_real most = (ecp_real)test_by(1.2e154, 1.7e19), corner[3] = {most, most, most};
        ecp_shape ball;
        CHECK(ecp_shape_sphere(&ball, most) == ECP_OK);
        CHECK(ecp_shape_cylinder(&s, most, most) == ECP_BAD_SIZE);
        CHECK(ecp_shape_box(&s, corner) == ECP_BAD_SIZE);
    }
    for (int b = 0; b < 2; b++) {
        const ecp_real extreme =
            b ? (ecp_real)test_by(1e-170, 1e-23) : (ecp_real)test_by(1e200, 1e25);
        const ecp_real size[3] = {extreme, extreme, extreme};
        CHECK(ecp_shape_sphere(&s, extreme) == ECP_BAD_SIZE);
        CHECK(ecp_shape_ellipsoid(&s, size) == ECP_BAD_SIZE);
        CHECK(ecp_shape_capsule(&s, extreme, extreme) == ECP_BAD_SIZE);
        CHECK(ecp_shape_cylinder(&s, extreme, extreme) == ECP_BAD_SIZE);
        CHECK(ecp_shape_frustum(&s, extreme, extreme / 2, extreme) == ECP_BAD_SIZE);
        CHECK(ecp_shape_frustum(&s, one, one, extreme) == ECP_BAD_SIZE);
        CHECK(ecp_shape_box(&s, size) == ECP_BAD_SIZE);
        CHECK(ecp_shape_convex(&s, &ecp_i_box_class, 1, origin, extreme, NULL) == ECP_BAD_SIZE);
        CHECK(memcmp(&s, &before, sizeof s) == 0);
    }
    for (int b = 0; b < 4; b++) {
        CHECK(ecp_shape_sphere(&s, bad[b]) == why[b]);
        CHECK(ecp_shape_capsule(&s, bad[b], one) == why[b]);
        CHECK(ecp_shape_cylinder(&s, bad[b], one) == why[b]);
        CHECK(ecp_shape_cylinder(&s, one, bad[b]) == why[b]);
        CHECK(ecp_shape_frustum(&s, one, one, bad[b]) == why[b]);
        CHECK(ecp_shape_convex(&s, &ecp_i_box_class, 1, origin, bad[b], NULL) == why[b]);

        /* here a zero is allowed */
        if (b != 2) {
            CHECK(ecp_shape_capsule(&s, one, bad[b]) == why[b]);
            CHECK(ecp_shape_frustum(&s, bad[b], one, one) == why[b]);
            CHECK(ecp_shape_frustum(&s, one, bad[b], one) == why[b]);
        }
        for (int k = 0; k < 3; k++) {
            ecp_real size[3] = {one, one, one};
            size[k] = bad[b];
            CHECK(ecp_shape_ellipsoid(&s, size) == why[b]);
            CHECK(ecp_shape_box(&s, size) == why[b]);
            if (b < 2) {
                CHECK(ecp_shape_half_space(&s, size, one) == why[b]);
                CHECK(ecp_shape_convex(&s, &ecp_i_box_class, 1, size, one, NULL) == why[b]);
            }
        }
        if (b < 2) {
            const ecp_real up[3] = {zero, zero, one};
            CHECK(ecp_shape_half_space(&s, up, bad[b]) == why[b]);
        }
    }
    CHECK(memcmp(&s, &before, sizeof s) == 0);
}

/* ---- a class of one's own: a ball about (1, 0, 0) whose radius is in `user` */

static void shapes_ball_eval(const ecp_shape *s, const ecp_real x[3], ecp_real *f, ecp_real *g)
{
    const ecp_real r = *(const ecp_real *)s->user;
    const ecp_real d[3] = {x[0] - ECP_R(1), x[1], x[2]};
    f[0] = (ecp_i_dot(d, d) - r * r) / (ECP_R(2) * r);
    if (g != NULL) {
        ecp_i_set3(d[0] / r, d[1] / r, d[2] / r, g);
    }
}

static void shapes_ball_support(const ecp_shape *s, const ecp_real n[3], ecp_real flat,
                                ecp_real x[3])
{
    const ecp_real r = *(const ecp_real *)s->user;
    (void)flat;
    ecp_i_set3(ECP_R(1) + r * n[0], r * n[1], r * n[2], x);
}

/* ways to get it wrong: the wrong sign, what is no number, and an answer to one direction that is beyond the others */
static void shapes_inside_out(const ecp_shape *s, const ecp_real n[3], ecp_real flat, ecp_real x[3])
{
    ecp_real back[3];
    ecp_i_scale(-1, n, back);
    shapes_ball_support(s, back, flat, x);
}

static void shapes_no_support(const ecp_shape *s, const ecp_real n[3], ecp_real flat, ecp_real x[3])
{
    shapes_ball_support(s, n, flat, x);
    if (n[1] < 0) x[2] = (ecp_real)NAN;
}

static void shapes_lopsided(const ecp_shape *s, const ecp_real n[3], ecp_real flat, ecp_real x[3])
{
    shapes_ball_support(s, n, flat, x);
    if (n[2] > 0) x[2] *= ECP_R(0.5);
    if (n[0] > 0) x[2] += ECP_R(0.375);
}

static void test_shape_convex(void)
{
    const ecp_shape_class inside_out = {shapes_ball_eval, NULL, shapes_inside_out, NULL},
                          none = {shapes_ball_eval, NULL, shapes_no_support, NULL},
                          lopsided = {shapes_ball_eval, NULL, shapes_lopsided, NULL};
    ecp_shape before;
    const ecp_shape_class ball = {shapes_ball_eval, NULL, shapes_ball_support, NULL};
    const ecp_real centre[3] = {ECP_R(1), 0, 0}, r = ECP_R(0.5);
    ecp_real lo[3], hi[3];
    ecp_shape s;
    ecp_mass m;

    CHECK(ecp_shape_convex(&s, &ball, 1, centre, r, &r) == ECP_OK);
    CHECK(s.kind == ECP_CONVEX && s.cls == &ball && s.user == &r && s.inequalities == 1);
    CHECK(s.centre[0] == ECP_R(1) && s.radius == r);
    ecp_shape_bounds(&s, lo, hi);
    CHECK(lo[0] == ECP_R(0.5) && hi[0] == ECP_R(1.5) && lo[2] == ECP_R(-0.5));
    ecp_shape_mass(&s, ECP_R(9), &m);
    CHECK(m.mass == 0 && m.inertia[0] == 0 && m.inertia[8] == 0 && m.centre[0] == ECP_R(1));

    /* mistakes that six support points show */
    memcpy(&before, &s, sizeof s);
    CHECK(ecp_shape_convex(&s, &inside_out, 1, centre, r, &r) == ECP_BAD_SUPPORT);
    CHECK(ecp_shape_convex(&s, &none, 1, centre, r, &r) == ECP_NOT_FINITE);
    CHECK(ecp_shape_convex(&s, &lopsided, 1, centre, ECP_R(0.7), &r) == ECP_BAD_SUPPORT);
    CHECK(ecp_shape_convex(&s, &ball, 1, centre, ECP_R(0.499), &r) == ECP_BAD_SUPPORT);
    CHECK(ecp_shape_convex(&s, &ball, 1, lo, r, &r) == ECP_BAD_SUPPORT);
    CHECK(memcmp(&before, &s, sizeof s) == 0);
    /* a radius as large as can be, and any within rounding of the least */
    CHECK(ecp_shape_convex(&s, &ball, 1, centre, 1000, &r) == ECP_OK);
    CHECK(ecp_shape_convex(&s, &ball, 1, centre, r * (1 - 4 * ECP_I_EPSILON), &r) == ECP_OK);
}

static void test_shapes(void)
{
    test_shape_derivatives();
    test_shape_frustum_continuation();
    test_shape_finite_everywhere();
    test_shape_unit_gradients();
    test_shape_f_is_a_distance();
    test_shape_support();
    test_shape_radius_is_least();
    test_shape_support_flat();
    test_shape_bounds();
    test_shape_half_space();
    test_shape_mass_of_revolution();
    test_shape_mass_closed_forms();
    test_shape_frustum_tip();
    test_shape_mass_add();
    test_shape_polytope_box();
    test_shape_polytope_tetrahedron();
    test_shape_polytope_regular();
    test_shape_polytope_scale();
    test_shape_polytope_slender();
    test_shape_polytope_random();
    test_shape_polytope_bad();
    test_shape_bad_input();
    test_shape_convex();
}

#undef SINGLE
#undef PICK
#undef EPS
#undef PI
