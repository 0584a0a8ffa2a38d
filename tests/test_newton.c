/* The general complementarity solver, on problems from the literature (truths T9) whose solutions
   are known, and on others whose solutions can be recognised: z >= 0, F >= 0, z F = 0. */
#include "test.h"

enum { NEWTON_MAX = 30 };

typedef struct newton_linear {
    int size;
    ecp_real M[NEWTON_MAX * NEWTON_MAX], q[NEWTON_MAX];
} newton_linear;

/* F = M z + q */
static void newton_linear_f(void *user, const ecp_real *z, ecp_real *F)
{
    const newton_linear *k = (const newton_linear *)user;
    int i, j;
    for (i = 0; i < k->size; i++) {
        F[i] = k->q[i];
        for (j = 0; j < k->size; j++) F[i] += k->M[k->size * i + j] * z[j];
    }
}

static void newton_linear_j(void *user, const ecp_real *z, ecp_real *J)
{
    const newton_linear *k = (const newton_linear *)user;
    (void)z;
    memcpy(J, k->M, (size_t)(k->size * k->size) * sizeof(ecp_real));
}

/* Kojima-Shindo, and with user != NULL Josephy */
static void newton_kojima_f(void *user, const ecp_real *x, ecp_real *F)
{
    ecp_real a = x[0], b = x[1], c = x[2], d = x[3];
    F[0] = 3 * a * a + 2 * a * b + 2 * b * b + c + 3 * d - 6;
    F[1] = 2 * a * a + a + b * b + (user ? 3 : 10) * c + 2 * d - 2;
    F[2] = 3 * a * a + a * b + 2 * b * b + 2 * c + (user ? 3 : 9) * d - (user ? 1 : 9);
    F[3] = a * a + 3 * b * b + 2 * c + 3 * d - 3;
}

static void newton_kojima_j(void *user, const ecp_real *x, ecp_real *J)
{
    ecp_real a = x[0], b = x[1], rows[4][4];
    rows[0][0] = 6 * a + 2 * b;
    rows[0][1] = 2 * a + 4 * b;
    rows[0][2] = 1;
    rows[0][3] = 3;
    rows[1][0] = 4 * a + 1;
    rows[1][1] = 2 * b;
    rows[1][2] = user ? 3 : 10;
    rows[1][3] = 2;
    rows[2][0] = 6 * a + b;
    rows[2][1] = a + 4 * b;
    rows[2][2] = 2;
    rows[2][3] = user ? 3 : 9;
    rows[3][0] = 2 * a;
    rows[3][1] = 6 * b;
    rows[3][2] = 2;
    rows[3][3] = 3;
    memcpy(J, rows, sizeof rows);
}

static void newton_billups_f(void *user, const ecp_real *x, ecp_real *F)
{
    (void)user;
    F[0] = (x[0] - 1) * (x[0] - 1) - ECP_R(1.01);
}

static void newton_billups_j(void *user, const ecp_real *x, ecp_real *J)
{
    (void)user;
    J[0] = 2 * (x[0] - 1);
}

static void newton_mathiesen_f(void *user, const ecp_real *x, ecp_real *F)
{
    (void)user;
    F[0] = -x[1] + x[2] + x[3];
    F[1] = x[0] - (ECP_R(4.5) * x[2] + ECP_R(2.7) * x[3]) / (x[1] + 1);
    F[2] = 5 - x[0] - (ECP_R(0.5) * x[2] + ECP_R(0.3) * x[3]) / (x[2] + 1);
    F[3] = 3 - x[0];
}

static void newton_mathiesen_j(void *user, const ecp_real *x, ecp_real *J)
{
    ecp_real rows[4][4], p = x[1] + 1, r = x[2] + 1;
    (void)user;
    memset(rows, 0, sizeof rows);
    rows[0][1] = -1;
    rows[0][2] = rows[0][3] = 1;
    rows[1][0] = 1;
    rows[1][1] = (ECP_R(4.5) * x[2] + ECP_R(2.7) * x[3]) / (p * p);
    rows[1][2] = -ECP_R(4.5) / p;
    rows[1][3] = -ECP_R(2.7) / p;
    rows[2][0] = -1;
    rows[2][2] = -(ECP_R(0.5) - ECP_R(0.3) * x[3]) / (r * r);
    rows[2][3] = -ECP_R(0.3) / r;
    rows[3][0] = -1;
    memcpy(J, rows, sizeof rows);
}

/* x >= 0, F = -1: no solution */
static void newton_infeasible_f(void *user, const ecp_real *x, ecp_real *F)
{
    (void)user;
    (void)x;
    F[0] = -1;
}

static void newton_infeasible_j(void *user, const ecp_real *x, ecp_real *J)
{
    (void)user;
    (void)x;
    J[0] = 0;
}

/* F = NaN: a function that cannot be evaluated */
static void newton_nan_f(void *user, const ecp_real *x, ecp_real *F)
{
    (void)user;
    (void)x;
    F[0] = ECP_R(NAN);
}

/* the circle |z| = 5 and the hyperbola z_0 z_1 = 12, without inequalities: (3, 4) or (4, 3) or
   their negatives */
static void newton_circle_f(void *user, const ecp_real *z, ecp_real *F)
{
    (void)user;
    F[0] = z[0] * z[0] + z[1] * z[1] - 25;
    F[1] = z[0] * z[1] - 12;
}

static void newton_circle_j(void *user, const ecp_real *z, ecp_real *J)
{
    (void)user;
    J[0] = 2 * z[0];
    J[1] = 2 * z[1];
    J[2] = z[1];
    J[3] = z[0];
}

static ecp_mcp newton_problem(int n, int m, void (*f)(void *, const ecp_real *, ecp_real *),
                              void (*j)(void *, const ecp_real *, ecp_real *), void *user)
{
    ecp_mcp p;
    p.n = n;
    p.m = m;
    p.function = f;
    p.jacobian = j;
    p.user = user;
    return p;
}

/* solves in exactly as many bytes as are asked for, between two fences */
static ecp_status newton_solve(const ecp_mcp *p, const ecp_options *o, ecp_real *z,
                               ecp_mcp_report *report)
{
    size_t need = ecp_mcp_memsize(p->n, p->m), i;
    unsigned char *mem = (unsigned char *)malloc(need + 64);
    ecp_status status;
    int intact = 1;
    memset(mem, 0xa5, need + 64);
    status = ecp_mcp_solve(p, o, z, mem + 32, need, report);
    for (i = 0; i < 32; i++) intact &= mem[i] == 0xa5 && mem[need + 32 + i] == 0xa5;
    CHECK(intact);
    free(mem);
    return status;
}

/* the conditions themselves, with no function of Fischer and Burmeister: min(z, F) = 0 */
static double newton_violation(const ecp_mcp *p, const ecp_real *z)
{
    ecp_real F[NEWTON_MAX];
    double worst = 0;
    int i;
    p->function(p->user, z, F);
    for (i = 0; i < p->n + p->m; i++) {
        double f = (double)F[i], x = (double)z[i];
        double miss = i < p->n ? fabs(f) : fabs(f < x ? f : x);
        if (!(miss <= worst)) worst = miss;
    }
    return worst;
}

/* how well a solution is met: the tolerance asked for bounds phi(z, F), and
   |min(a, b)| <= |phi(a, b)| (2 + sqrt 2) / 2 ... 1.71 */
static double newton_tolerance(void) { return 2 * test_by(1e-12, 1e-5); }

static double newton_apart(int n, const ecp_real *z, const double *want)
{
    double worst = 0;
    int i;
    for (i = 0; i < n; i++) {
        if (fabs((double)z[i] - want[i]) > worst) worst = fabs((double)z[i] - want[i]);
    }
    return worst;
}

/* ---- the function of Fischer and Burmeister */

static void newton_test_fb(void)
{
    static const double weight[3] = {45, -9, 1};
    ecp_real da, db, ignore;
    int round, k, s;
    for (round = 0; round < 200; round++) {
        /* value against the definition, both derivatives against sixth-order differences of it, at
           least 0.1 away from the kink */
        double a = test_random(), b = test_random(), tau = round % 2 ? 0 : 0.3, d = 0.005;
        double size = sqrt(a * a + b * b + 2 * tau * tau), slope[2];
        if (size < 0.1) continue;
        a = (double)ECP_R(a);
        b = (double)ECP_R(b);
        tau = (double)ECP_R(tau);
        size = sqrt(a * a + b * b + 2 * tau * tau);
        CHECK_NEAR(ecp_i_fb(ECP_R(a), ECP_R(b), ECP_R(tau), &da, &db), a + b - size,
                   8 * (double)ECP_I_EPSILON);
        for (k = 0; k < 2; k++) {
            slope[k] = 0;
            for (s = -3; s <= 3; s++) {
                double x = k ? a : a + s * d, y = k ? b + s * d : b, w;
                if (s == 0) continue;
                w = (s < 0 ? -weight[-s - 1] : weight[s - 1]) / (60 * d);
                slope[k] += w * (x + y - sqrt(x * x + y * y + 2 * tau * tau));
            }
        }
        /* truncation 36 d^6 / size^6: 6e-7 at 0.1, and far less for nearly all */
        CHECK_NEAR(da, slope[0], test_by(1e-12, 1e-6) + 4 * pow(d / size, 6));
        CHECK_NEAR(db, slope[1], test_by(1e-12, 1e-6) + 4 * pow(d / size, 6));
    }
    /* phi = 0 just where a >= 0, b >= 0, a b = 0; with tau: where a, b > 0 and a b = tau^2 */
    CHECK(ecp_i_fb(0, 3, 0, &da, &db) == 0 && da == 1 && db == 0);
    CHECK(ecp_i_fb(2, 0, 0, &da, &db) == 0 && da == 0 && db == 1);
    CHECK(ecp_i_fb(-1, 0, 0, &da, &db) < 0);
    CHECK(ecp_i_fb(1, ECP_R(1e-3), 0, &da, &db) > 0);
    CHECK_NEAR(ecp_i_fb(2, ECP_R(0.125), ECP_R(0.5), &da, &db), 0, 4 * (double)ECP_I_EPSILON);
    /* no cancellation where both are positive: phi(1, b) = b - b^2 / 2 + .. */
    CHECK_NEAR(ecp_i_fb(1, ECP_R(1e-20), 0, &da, &db) / ECP_R(1e-20), 1, 8 * (double)ECP_I_EPSILON);
    /* at the kink: a member of the generalised derivative, (1 - c, 1 - s) with c^2 + s^2 <= 1, that
       a Newton step can divide by */
    CHECK(ecp_i_fb(0, 0, 0, &da, &db) == 0);
    CHECK((1 - da) * (1 - da) + (1 - db) * (1 - db) <= 1 + 8 * ECP_I_EPSILON);
    CHECK(da > 0 && db > 0);
    /* a NaN is not taken for a solution */
    ignore = ecp_i_fb(ECP_R(NAN), 0, 0, &da, &db);
    CHECK(!(ignore == ignore));
    ignore = ecp_i_fb(0, ECP_R(NAN), 0, &da, &db);
    CHECK(!(ignore == ignore));
}

/* ---- T9 */

static void newton_test_literature(void)
{
    static const ecp_real starts[8][4] = {
        {0, 0, 0, 0}, {1, 1, 1, 1}, {100, 100, 100, 100}, {1, 0, 1, 0},
        {1, 0, 0, 0}, {0, 1, 1, 0}, {0, 1, 0, 1},         {ECP_R(1.25), 0, 0, ECP_R(0.5)}};
    const double first[4] = {sqrt(6.0) / 2, 0, 0, 0.5}, second[4] = {1, 0, 3, 0};
    int josephy = 1, k;
    ecp_mcp_report report;
    ecp_real z[4];
    for (k = 0; k < 8; k++) {
        ecp_mcp p = newton_problem(0, 4, newton_kojima_f, newton_kojima_j, &josephy);
        double near, tolerance = test_by(1e-9, 1e-3);
        memcpy(z, starts[k], sizeof z);
        CHECK(newton_solve(&p, NULL, z, &report) == ECP_OK);
        CHECK(newton_violation(&p, z) <= newton_tolerance());
        CHECK((double)report.natural_residual <= newton_tolerance());
        CHECK_NEAR(newton_apart(4, z, first), 0, tolerance);
        CHECK(report.iterations >= 1 || k == 7);
        CHECK(report.evaluations > report.iterations);

        /* Kojima-Shindo: either solution; the first is degenerate (z_2 = F_2 = 0), so an error of
           the equations of 1e-12 may be one of its root in z */
        p = newton_problem(0, 4, newton_kojima_f, newton_kojima_j, NULL);
        memcpy(z, starts[k], sizeof z);
        CHECK(newton_solve(&p, NULL, z, &report) == ECP_OK);
        CHECK(newton_violation(&p, z) <= newton_tolerance());
        near = newton_apart(4, z, first);
        if (newton_apart(4, z, second) < near) near = newton_apart(4, z, second);
        CHECK_NEAR(near, 0, test_by(1e-6, 1e-2));
    }
    {
        /* Billups: the start 0 traps pure descent; a way out has to be found, and to be reported */
        ecp_mcp p = newton_problem(0, 1, newton_billups_f, newton_billups_j, NULL);
        ecp_options o = ecp_options_default();
        z[0] = 0;
        CHECK(newton_solve(&p, NULL, z, &report) == ECP_OK);
        CHECK_NEAR(z[0], 1 + sqrt(1.01), test_by(1e-12, 1e-5));
        CHECK(report.fallbacks != 0);
        o.fallbacks = 0;
        z[0] = 0;
        CHECK(newton_solve(&p, &o, z, &report) == ECP_NOT_SOLVED);
        CHECK(report.fallbacks == 0);
        CHECK(z[0] == 0);
        /* and no search comes twice: there is no geometry to start from */
        k = report.iterations;
        o.fallbacks = ECP_FALLBACK_GEOMETRIC;
        CHECK(newton_solve(&p, &o, z, &report) == ECP_NOT_SOLVED);
        CHECK(report.fallbacks == 0 && report.iterations == k);
    }
    for (k = 0; k < 8; k++) {
        /* Mathiesen: a ray of solutions (l, 0, 0, 0), l in [0, 3] */
        ecp_mcp p = newton_problem(0, 4, newton_mathiesen_f, newton_mathiesen_j, NULL);
        memcpy(z, starts[k], sizeof z);
        CHECK(newton_solve(&p, NULL, z, &report) == ECP_OK);
        CHECK(newton_violation(&p, z) <= newton_tolerance());
        CHECK((double)z[0] >= -newton_tolerance() && (double)z[0] <= 3 + newton_tolerance());
        CHECK(fabs((double)z[1]) + fabs((double)z[2]) + fabs((double)z[3]) <= test_by(1e-5, 1e-2));
    }
}

static void newton_test_lcp(void)
{
    newton_linear lcp;
    ecp_mcp p;
    ecp_real z[NEWTON_MAX];
    ecp_mcp_report report;
    int i, j, round;
    /* Murty: 2 below the diagonal, q = -1: z = e_1 */
    lcp.size = 6;
    for (i = 0; i < 6; i++) {
        for (j = 0; j < 6; j++)
            lcp.M[6 * i + j] = i == j ? ECP_R(1) : (i > j ? ECP_R(2) : ECP_R(0));
        lcp.q[i] = -1;
        z[i] = 0;
    }
    p = newton_problem(0, 6, newton_linear_f, newton_linear_j, &lcp);
    CHECK(newton_solve(&p, NULL, z, &report) == ECP_OK);
    for (i = 0; i < 6; i++) CHECK_NEAR(z[i], i == 0, newton_tolerance());

    /* M-matrices have one solution for every q; random ones of size 30 with both kinds of index */
    for (round = 0; round < 5; round++) {
        int positive = 0;
        lcp.size = NEWTON_MAX;
        for (i = 0; i < NEWTON_MAX; i++) {
            double sum = 8;
            for (j = 0; j < NEWTON_MAX; j++) {
                double off = j == i ? 0 : -fabs(test_random());
                lcp.M[NEWTON_MAX * i + j] = ECP_R(off);
                sum -= off;
            }
            lcp.M[NEWTON_MAX * i + i] = ECP_R(sum);
            lcp.q[i] = ECP_R(test_random());
            z[i] = ECP_R(round);
        }
        p = newton_problem(0, NEWTON_MAX, newton_linear_f, newton_linear_j, &lcp);
        CHECK(newton_solve(&p, NULL, z, &report) == ECP_OK);
        CHECK(newton_violation(&p, z) <= newton_tolerance() + 64 * (double)ECP_I_EPSILON);
        for (i = 0; i < NEWTON_MAX; i++) positive += z[i] > ECP_R(1e-3);
        CHECK(positive > 0 && positive < NEWTON_MAX);
    }
}

/* ---- equations, and both kinds together */

static void newton_test_mixed(void)
{
    newton_linear k;
    ecp_mcp p = newton_problem(2, 0, newton_circle_f, newton_circle_j, NULL);
    ecp_mcp_report report;
    ecp_real z[4];
    /* equations only */
    z[0] = 1;
    z[1] = 7;
    CHECK(newton_solve(&p, NULL, z, &report) == ECP_OK);
    CHECK(newton_violation(&p, z) <= newton_tolerance());
    CHECK_NEAR(fabs((double)z[0] * (double)z[1]), 12, test_by(1e-11, 1e-4));
    CHECK(report.iterations > 1 && report.iterations < 15);
    /* a solved start is left as it is */
    z[0] = 3;
    z[1] = 4;
    CHECK(newton_solve(&p, NULL, z, &report) == ECP_OK);
    CHECK(z[0] == 3 && z[1] == 4 && report.iterations == 0);

    /* The step is the least one where rows are dependent: x + y = 2 twice, from 0, gives (1, 1) */
    k.size = 2;
    k.M[0] = k.M[1] = k.M[2] = k.M[3] = 1;
    k.q[0] = k.q[1] = -2;
    p = newton_problem(2, 0, newton_linear_f, newton_linear_j, &k);
    z[0] = z[1] = 0;
    CHECK(newton_solve(&p, NULL, z, &report) == ECP_OK);
    CHECK_NEAR(z[0], 1, 8 * (double)ECP_I_EPSILON);
    CHECK_NEAR(z[1], 1, 8 * (double)ECP_I_EPSILON);

    /* The nearest point of {x >= 0, y >= 0} to c under x + y = 1 + s, by its multipliers: unknowns
       (l, x, y), 0 = x + y - 1, 0 <= x - c_x + l _|_ x >= 0. For c = (2, -3) it is (1, 0), l = 1. */
    k.size = 3;
    memset(k.M, 0, sizeof k.M);
    k.M[1] = k.M[2] = 1;
    k.M[3] = 1;
    k.M[4] = 1;
    k.M[6] = 1;
    k.M[8] = 1;
    k.q[0] = -1;
    k.q[1] = -2;
    k.q[2] = 3;
    p = newton_problem(1, 2, newton_linear_f, newton_linear_j, &k);
    z[0] = z[1] = z[2] = 0;
    CHECK(newton_solve(&p, NULL, z, &report) == ECP_OK);
    CHECK_NEAR(z[0], 1, newton_tolerance());
    CHECK_NEAR(z[1], 1, newton_tolerance());
    CHECK_NEAR(z[2], 0, newton_tolerance());
}

/* ---- failures */

static void newton_test_bad_input(void)
{
    ecp_mcp p = newton_problem(0, 1, newton_infeasible_f, newton_infeasible_j, NULL), bad;
    ecp_options o = ecp_options_default();
    ecp_real z[2] = {ECP_R(0.25), 0}, bads[2];
    double aligned[512];
    unsigned char *mem = (unsigned char *)(void *)aligned;
    size_t need = ecp_mcp_memsize(0, 1);
    ecp_mcp_report report;
    int k;
    bads[0] = ECP_R(NAN);
    bads[1] = ECP_R(INFINITY);
    /* no solution: that is said, and z stays, bit for bit */
    CHECK(newton_solve(&p, NULL, z, &report) == ECP_NOT_SOLVED);
    CHECK(z[0] == ECP_R(0.25) && z[1] == 0);
    CHECK(report.fallbacks ==
              (ECP_FALLBACK_GEOMETRIC | ECP_FALLBACK_CONTINUATION | ECP_FALLBACK_MULTISTART) ||
          report.fallbacks == (ECP_FALLBACK_CONTINUATION | ECP_FALLBACK_MULTISTART));
    CHECK((double)report.natural_residual > 0.1);
    CHECK(newton_solve(&p, NULL, z, NULL) == ECP_NOT_SOLVED);
    for (k = 0; k < 2; k++) {
        ecp_mcp broken = newton_problem(k, 1 - k, newton_nan_f, newton_infeasible_j, NULL);
        ecp_real start = 0;
        CHECK(newton_solve(&broken, NULL, &start, NULL) == ECP_NOT_SOLVED);
        CHECK(start == 0);
    }

    CHECK(need > 0 && need <= sizeof aligned);
    CHECK(ecp_mcp_memsize(0, 0) == 0);
    CHECK(ecp_mcp_memsize(-1, 2) == 0);
    CHECK(ecp_mcp_memsize(2, -1) == 0);
    CHECK(ecp_mcp_memsize(1 << 30, 1 << 30) == 0);
    CHECK(ecp_mcp_memsize(3, 4) == ecp_mcp_memsize(4, 3));

    CHECK(ecp_mcp_solve(NULL, NULL, z, mem, need, NULL) == ECP_BAD_POINTER);
    CHECK(ecp_mcp_solve(&p, NULL, NULL, mem, need, NULL) == ECP_BAD_POINTER);
    CHECK(ecp_mcp_solve(&p, NULL, z, NULL, need, NULL) == ECP_BAD_POINTER);
    bad = p;
    bad.function = NULL;
    CHECK(ecp_mcp_solve(&bad, NULL, z, mem, need, NULL) == ECP_BAD_POINTER);
    bad = p;
    bad.jacobian = NULL;
    CHECK(ecp_mcp_solve(&bad, NULL, z, mem, need, NULL) == ECP_BAD_POINTER);
    bad = p;
    bad.m = 0;
    CHECK(ecp_mcp_solve(&bad, NULL, z, mem, need, NULL) == ECP_BAD_OPTION);
    bad.n = -1;
    bad.m = 2;
    CHECK(ecp_mcp_solve(&bad, NULL, z, mem, need, NULL) == ECP_BAD_OPTION);
    CHECK(ecp_mcp_solve(&p, NULL, z, mem, need - 1, NULL) == ECP_MEMORY_SMALL);
    CHECK(ecp_mcp_solve(&p, NULL, z, mem + 4, need, NULL) == ECP_MEMORY_ALIGN);
    for (k = 0; k < 2; k++) {
        ecp_real start = bads[k];
        CHECK(ecp_mcp_solve(&p, NULL, &start, mem, need, NULL) == ECP_NOT_FINITE);
        CHECK(memcmp(&start, &bads[k], sizeof start) == 0);
        o = ecp_options_default();
        o.tolerance = bads[k];
        CHECK(ecp_mcp_solve(&p, &o, z, mem, need, NULL) == ECP_NOT_FINITE);
    }
    for (k = 0; k < 5; k++) {
        o = ecp_options_default();
        if (k == 0) o.tolerance = 0;
        if (k == 1) o.tolerance = -1;
        if (k == 2) o.max_iterations = 0;
        if (k == 3) o.fallbacks = 128;
        if (k == 4) o.fallbacks = -1;
        CHECK(ecp_mcp_solve(&p, &o, z, mem, need, NULL) == ECP_BAD_OPTION);
    }
    CHECK(z[0] == ECP_R(0.25) && z[1] == 0);
}

/* continuation in haste, which only large islands take: a linear problem whose matrix is positive
   definite, and not symmetric; and one that has no solution */
static void newton_test_haste(void)
{
    static uint64_t mem[1024];
    newton_linear linear = {
        4, {5, -3, 1, 0, 1, 4, 2, -1, -2, 1, 6, 3, 1, 0, -1, 3}, {-1, 2, -3, 0}};
    ecp_mcp problem = newton_problem(0, 4, newton_linear_f, newton_linear_j, &linear);
    ecp_options o = ecp_options_default();
    ecp_i_arena arena = ecp_i_arena_over(mem, sizeof mem);
    ecp_i_effort effort = ecp_i_effort_after(&o, 0);
    ecp_i_problem p;
    ecp_i_mcp s;
    ecp_real *z;
    int k;
    memset(&p, 0, sizeof p);
    ecp_i_carve_mcp(&arena, 4, &s, &p, &z);
    p.kept = ecp_i_take_reals(&arena, 4, 1);
    CHECK(!arena.overflow);
    s.problem = &problem;
    p.self = &s;
    p.n = 4;
    p.residual = ecp_i_mcp_residual;
    p.step = ecp_i_mcp_step;
    for (k = 0; k < 4; k++) z[k] = 10;
    CHECK(ecp_i_continue_in_haste(&p, o.tolerance, z, &effort));
    CHECK(effort.fallbacks == ECP_FALLBACK_CONTINUATION);
    CHECK(effort.iterations > 3);
    CHECK(newton_violation(&problem, z) <= newton_tolerance());
    problem = newton_problem(0, 1, newton_infeasible_f, newton_infeasible_j, NULL);
    p.n = 1;
    z[0] = 0;
    CHECK(!ecp_i_continue_in_haste(&p, o.tolerance, z, &effort));
}

/* So many equations r(x) = 0 alike that Newton goes round in a circle: from x < 0.3, where r is a tenth of
   exp(-x), by 1 to where it is ten times as large, and from there back, a little short of where it came
   from, so that r is a little less than the last time. The root 0.4 is what a search finds that does not
   take r = 1 for an advance on the r = 1 before it. */
static ecp_real newton_round_f(ecp_real x, ecp_real *slope)
{
    double v = (double)x, r;
    if (v < 0.3) {
        r = 0.1 * exp(-v);
        *slope = (ecp_real)-r;
    } else if (v < 0.45) {
        r = 0.741 * (0.4 - v);
        *slope = ECP_R(-0.741);
    } else {
        r = exp(v - 1);
        *slope = (ecp_real)(r / (1 + 4e-4 * v));
    }
    return (ecp_real)r;
}

static void newton_round_residual(void *self, const ecp_real *z, ecp_real relax, ecp_real *F,
                                  ecp_i_size *size)
{
    ecp_real slope;
    int i, n = *(const int *)self;
    (void)relax;
    size->largest = 0;
    for (i = 0; i < n; i++) {
        F[i] = newton_round_f(z[i], &slope);
        size->largest = ecp_i_max(size->largest, ecp_i_abs(F[i]));
    }
    size->error = size->rest = size->largest;
}

static int newton_round_step(void *self, const ecp_real *z, const ecp_real *F, ecp_real fine,
                             ecp_real compliance, ecp_real *dz)
{
    ecp_real slope;
    int i, n = *(const int *)self;
    (void)fine;
    (void)compliance;
    for (i = 0; i < n; i++) {
        newton_round_f(z[i], &slope);
        dz[i] = -F[i] / slope;
    }
    return 1;
}

static void newton_test_circle(void)
{
    static ecp_real work[5][ECP_I_LARGE];
    ecp_options o = ecp_options_default();
    ecp_i_effort effort = ecp_i_effort_after(&o, 0);
    ecp_i_problem p;
    int k, n = ECP_I_LARGE;
    memset(&p, 0, sizeof p);
    p.self = &n;
    p.n = n;
    p.large = 1;
    p.hurries = 0;
    p.residual = newton_round_residual;
    p.step = newton_round_step;
    p.F = work[1];
    p.dz = work[2];
    p.trial = work[3];
    p.drift = work[4];
    for (k = 0; k < n; k++) work[0][k] = 1;
    CHECK(ecp_i_newton(&p, 0, o.tolerance, o.max_iterations, 0, work[0], &effort));
    CHECK(effort.iterations > ECP_I_STALE && effort.iterations < o.max_iterations);
    for (k = 0; k < n; k++) CHECK_NEAR(work[0][k], 0.4, 2 * (double)o.tolerance);
}

/* A search that only crawls, towards a limit that is no solution, and must be damped much to do so, ends as
   soon as that has shown; that of a relaxed problem, or of more than two bodies, when its iterations do, but
   not in haste. */
static void newton_crawl_residual(void *self, const ecp_real *z, ecp_real relax, ecp_real *F,
                                  ecp_i_size *size)
{
    (void)self;
    (void)relax;
    F[0] = 1 + 1 / (100 + z[0]);
    size->largest = size->error = size->rest = F[0];
    size->friction = 0;
}

static int newton_crawl_step(void *self, const ecp_real *z, const ecp_real *F, ecp_real fine,
                             ecp_real compliance, ecp_real *dz)
{
    (void)self;
    (void)z;
    (void)F;
    (void)fine;
    dz[0] = compliance < ECP_R(0.5) ? ECP_R(-99.0) : ECP_R(10.0);
    return 1;
}

static void newton_test_crawl(void)
{
    ecp_real work[5];
    ecp_options o = ecp_options_default();
    ecp_i_problem p;
    int k;
    memset(&p, 0, sizeof p);
    p.n = 1;
    p.residual = newton_crawl_residual;
    p.step = newton_crawl_step;
    p.F = work + 1;
    p.dz = work + 2;
    p.trial = work + 3;
    p.drift = work + 4;
    for (k = 0; k < 8; k++) {
        ecp_i_effort effort = ecp_i_effort_after(&o, 0);
        ecp_real relax = ECP_R(0.1) * (ecp_real)(k >> 2);
        p.hurries = k & 1;
        p.patient = k >> 1 & 1;
        work[0] = 0;
        CHECK(!ecp_i_newton(&p, 0, o.tolerance, o.max_iterations, relax, work, &effort));
        CHECK((p.hurries || (!p.patient && !(relax > 0))) == (effort.iterations < 2 * ECP_I_STALE));
    }
}

/* x / sqrt(1 + x^2) from 50 needs damped steps, which may take more iterations; more than an int holds there are not */
static void newton_flat_function(void *user, const ecp_real *z, ecp_real *F)
{
    (void)user;
    F[0] = z[0] / ecp_i_sqrt(1 + z[0] * z[0]);
}

static void newton_flat_jacobian(void *user, const ecp_real *z, ecp_real *J)
{
    ecp_real s = 1 + z[0] * z[0];
    (void)user;
    J[0] = 1 / (s * ecp_i_sqrt(s));
}

static void newton_test_limits(void)
{
    static const int most[4] = {40, 0x1fffffff, 0x20000000, 0x7fffffff};
    ecp_mcp p;
    ecp_mcp_report r;
    ecp_options o = ecp_options_default();
    double memory[200];
    int k, first = 0;
    memset(&p, 0, sizeof p);
    p.n = 1;
    p.function = newton_flat_function;
    p.jacobian = newton_flat_jacobian;
    o.fallbacks = 0;
    for (k = 0; k < 4; k++) {
        ecp_real z[1] = {50};
        o.max_iterations = most[k];
        CHECK(ecp_mcp_solve(&p, &o, z, memory, sizeof memory, &r) == ECP_OK);
        if (k == 0) first = r.iterations;
        CHECK(r.iterations == first && ecp_i_abs(z[0]) < o.tolerance);
    }
}

/* exp(z) - 1e6, whose first step goes where its square is no number */
static void newton_exp_f(void *user, const ecp_real *z, ecp_real *F)
{
    (void)user;
    F[0] = (ecp_real)exp((double)z[0]) - ECP_R(1e6);
}

static void newton_exp_j(void *user, const ecp_real *z, ecp_real *J)
{
    (void)user;
    J[0] = (ecp_real)exp((double)z[0]);
}

/* Numbers of very different sizes: what is accepted is a solution to the tolerance, by Fischer-Burmeister with more
   digits, or with scaled numbers. */
static void newton_test_sizes(void)
{
    static const double lines[7][3] = {{1e10, 1, -4e-7}, {1e6, 1, -4e-11}, {-1, 1e-8, 0},
                                       {-1, 1e-4, 0},    {1e4, 1, -2e-4},  {-1, 1e-3, 0},
                                       {1e6, 0, -0.01}};
    ecp_options o = ecp_options_default();
    ecp_mcp p;
    ecp_mcp_report r;
    double memory[200];
    int k, solved = 0;
    memset(&p, 0, sizeof p);
    p.m = 1;
    for (k = 0; k < 7; k++) {
        newton_linear line;
        ecp_real z[1], F;
        double least, most;
        line.size = 1;
        line.q[0] = (ecp_real)lines[k][0];
        line.M[0] = (ecp_real)lines[k][1];
        z[0] = (ecp_real)lines[k][2];
        p.function = newton_linear_f;
        p.jacobian = newton_linear_j;
        p.user = &line;
        if (ecp_mcp_solve(&p, &o, z, memory, sizeof memory, &r) != ECP_OK) continue;
        solved++;
        newton_linear_f(&line, z, &F);
        least = fmin((double)z[0], (double)F);
        most = fmax((double)z[0], (double)F);
        /* a + b - sqrt(a^2 + b^2) is between 0.59 and 2 times the smaller, if the other is larger and positive */
        CHECK(most >= 0 && fabs(least) <= 2 * (double)o.tolerance);
    }
    CHECK(solved >= 5);
    {
        ecp_real z[1] = {0};
        p.function = newton_exp_f;
        p.jacobian = newton_exp_j;
        if (ecp_mcp_solve(&p, &o, z, memory, sizeof memory, &r) == ECP_OK)
            CHECK_NEAR(z[0], log(1e6), test_by(1e-12, 1e-5));
        else
            CHECK(z[0] == 0);
    }
}

/* Linear equations whose unknowns are in units that differ by up to 1e8 (double: 1e16): all are solved, as fast as in
   one unit. */
static void newton_test_units(void)
{
    newton_linear k;
    ecp_mcp p = {0, 0, newton_linear_f, newton_linear_j, NULL};
    ecp_real z[5];
    unsigned char *mem = (unsigned char *)malloc(ecp_mcp_memsize(5, 0));
    ecp_mcp_report r;
    uint32_t seed = 5u;
    int round, i, j, w;
    p.n = k.size = 5;
    p.user = &k;
    for (round = 0; round < 40; round++) {
        for (j = 0; j < 5; j++) {
            ecp_real unit = 1;
            seed = seed * 1664525u + 1013904223u;
            for (w = (int)(seed >> 16) % (sizeof(ecp_real) == 8 ? 17 : 9); w > 0; w--) unit *= 10;
            unit /= sizeof(ecp_real) == 8 ? ECP_R(1e8) : ECP_R(1e4);
            for (i = 0; i < 5; i++) {
                seed = seed * 1664525u + 1013904223u;
                k.M[5 * i + j] = unit * ((ecp_real)(seed >> 8) / ECP_R(8388608.0) +
                                         (i == j ? ECP_R(3.0) : ECP_R(-1.0)));
            }
            k.q[j] = ECP_R(0.3) * (ecp_real)(j - 2) - 1;
            z[j] = 0;
        }
        CHECK(ecp_mcp_solve(&p, NULL, z, mem, ecp_mcp_memsize(5, 0), &r) == ECP_OK);
        CHECK(r.iterations <= 4 && r.fallbacks == 0);
    }
    free(mem);
}

static void test_newton(void)
{
    test_seed = 21;
    newton_test_fb();
    newton_test_literature();
    newton_test_lcp();
    newton_test_mixed();
    newton_test_bad_input();
    newton_test_haste();
    newton_test_circle();
    newton_test_crawl();
    newton_test_limits();
    newton_test_units();
    newton_test_sizes();
}
