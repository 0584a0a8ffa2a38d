/* The step's equations: the analytic Jacobian, and the Newton step that the structured elimination
   makes of it, against differences of the residual alone.

   Differences are central and of sixth order with step d: they miss d^6 F^(7) / 140 by truncation
   and eps |F| / d by rounding. Points are drawn at random, at least `reach` away from every kink
   (of Fischer-Burmeister, of the projection, of p_n = 0, of the shapes' third derivatives), where
   F^(7) is of the order of 2000 / reach^6. With d = 1e-3, reach = 0.05 that is 1e-9 in double and
   1e-12 of rounding; in float with d = 0.02, reach = 0.25 it is 4e-6, and 2e-5 of rounding. */
#include "test.h"

enum { EQUATIONS_KINDS = 8, EQUATIONS_BODIES = 4, EQUATIONS_PAIRS = 8, EQUATIONS_MAX = 200 };

static double equations_d(void) { return test_by(1e-3, 0.02); }
static double equations_reach(void) { return test_by(0.05, 0.25); }

/* of the Jacobian, relative to the largest entry of the row */
static double equations_tolerance(void) { return test_by(1e-8, 2e-3); }

/* ---- shapes: the seven primitives, and one of our own: the lens between two spheres of radius
   1.3 about (0, 0, -+0.7) */

static void equations_lens_eval(const ecp_shape *s, const ecp_real x[3], ecp_real *f, ecp_real *g)
{
    ecp_real r = ECP_R(1.3), c = ECP_R(0.7);
    int i;
    (void)s;
    for (i = 0; i < 2; i++) {
        ecp_real z = x[2] + (i ? -c : c);
        f[i] = (x[0] * x[0] + x[1] * x[1] + z * z - r * r) / (2 * r);
        if (g) ecp_i_set3(x[0] / r, x[1] / r, z / r, g + 3 * i);
    }
}

static void equations_lens_hess(const ecp_shape *s, const ecp_real x[3], const ecp_real *l,
                                ecp_real H[9])
{
    int k;
    (void)s;
    (void)x;
    for (k = 0; k < 9; k++) H[k] = k % 4 == 0 ? (l[0] + l[1]) / ECP_R(1.3) : 0;
}

/* not used by the equations; only its presence is asked for */
static void equations_lens_support(const ecp_shape *s, const ecp_real n[3], ecp_real flat,
                                   ecp_real x[3])
{
    (void)s;
    (void)n;
    (void)flat;
    ecp_i_set3(0, 0, 0, x);
}

static const ecp_shape_class equations_lens = {equations_lens_eval, equations_lens_hess,
                                               equations_lens_support, NULL};

static ecp_real equations_planes[6 * 4], equations_vertices[8 * 3];

/* a tetrahedron with one edge cut off: no two faces parallel or at right angles */
static ecp_status equations_polytope(ecp_shape *s)
{
    static const double normals[5][3] = {
        {1, 0.2, -0.3}, {-0.8, 0.9, -0.2}, {-0.4, -1, -0.3}, {0.1, 0.1, 1}, {-1, 0.1, -0.6}};
    int i, k;
    for (i = 0; i < 5; i++) {
        double size = sqrt(normals[i][0] * normals[i][0] + normals[i][1] * normals[i][1] +
                           normals[i][2] * normals[i][2]);
        for (k = 0; k < 3; k++) equations_planes[4 * i + k] = ECP_R(normals[i][k] / size);
        equations_planes[4 * i + 3] = ECP_R(0.5 + 0.05 * i);
    }
    /* closed from below */
    ecp_i_set3(0, 0, -1, equations_planes + 20);
    equations_planes[23] = ECP_R(0.6);
    return ecp_shape_polytope(s, equations_planes, 6, equations_vertices, 8);
}

static void equations_shape(int kind, ecp_shape *s)
{
    ecp_real three[3], zero[3] = {0, 0, 0};
    ecp_status status = ECP_BAD_KIND;
    ecp_i_set3(ECP_R(0.6), ECP_R(0.9), ECP_R(0.75), three);
    if (kind == 0) status = ecp_shape_sphere(s, ECP_R(0.8));
    if (kind == 1) status = ecp_shape_ellipsoid(s, three);
    if (kind == 2) status = ecp_shape_capsule(s, ECP_R(0.5), ECP_R(0.4));
    if (kind == 3) status = ecp_shape_cylinder(s, ECP_R(0.7), ECP_R(0.5));
    if (kind == 4) status = ecp_shape_frustum(s, ECP_R(0.9), ECP_R(0.6), ECP_R(0.5));
    if (kind == 5) status = ecp_shape_box(s, three);
    if (kind == 6) status = equations_polytope(s);
    if (kind == 7) status = ecp_shape_convex(s, &equations_lens, 2, zero, ECP_R(1.2), NULL);
    CHECK(status == ECP_OK);
}

/* is x away from the jumps of the third derivatives, and, in a frustum, near enough for the change
   of its radius over d to be small? */
static int equations_smooth(const ecp_shape *s, const ecp_real x[3])
{
    double z = fabs((double)x[2]), reach = equations_reach();
    if (s->kind == ECP_FRUSTUM) return z < (double)s->size[2];
    if (s->kind == ECP_CAPSULE) return fabs(z - (double)s->size[1]) > reach;
    if (s->kind == ECP_ELLIPSOID) {
        ecp_real f[1];
        s->cls->eval(s, x, f, NULL);
        /* inside, 1 / sqrt(P + ..) bends on the scale of the distance from the centre */
        return (double)f[0] > reach;
    }
    return 1;
}

/* ---- an island, built like ecp_i_solve_island builds it, of all bodies and all pairs */

typedef struct equations_scene {
    ecp_world *world;
    unsigned char *memory;
    ecp_i_arena arena;
    ecp_i_motion motions[EQUATIONS_BODIES];
    ecp_i_pair pairs[EQUATIONS_PAIRS], *members[EQUATIONS_PAIRS];
    int bodies[EQUATIONS_BODIES];
    ecp_i_island s;
    ecp_real *z, *F, *dz;
    double *J; /* by differences */
} equations_scene;

static void equations_random_body(ecp_world *w, ecp_body_kind kind, double spread)
{
    static const double principal[3] = {0.3, 0.42, 0.5};
    ecp_body_desc d = ecp_body_desc_default();
    ecp_real R[9], I[9];
    int i;
    for (i = 0; i < 4; i++) d.rotation[i] = ECP_R(test_random());
    d.rotation[0] += 2;
    for (i = 0; i < 9; i++) I[i] = i % 4 == 0 ? ECP_R(principal[i / 4]) : 0;
    {
        ecp_real q[4] = {ECP_R(0.5), ECP_R(0.5), ECP_R(0.1), ECP_R(0.7)};
        ecp_i_quat_normalise(q);
        ecp_quat_to_matrix(q, R);
    }
    ecp_i_congruence(R, I, d.inertia);
    d.kind = kind;
    d.mass = ECP_R(1 + 0.5 * test_random());
    for (i = 0; i < 3; i++) {
        d.position[i] = ECP_R(spread * test_random());
        d.velocity[i] = kind == ECP_STATIC ? 0 : ECP_R(test_random());
        d.angular_velocity[i] = kind == ECP_STATIC ? 0 : ECP_R(2 * test_random());
    }
    CHECK(ecp_body_add(w, &d, NULL) == ECP_OK);
}

/* friction: 0, 2 or 3 rows; kind -1: a half-space */
static void equations_add_shape(ecp_world *w, int body, int kind, int friction, int directed)
{
    ecp_material m = ecp_material_default();
    ecp_shape s;
    ecp_real x[3], q[4], n[3];
    int i;
    m.mu = friction ? ECP_R(0.6) : 0;
    m.e_t = ECP_R(1.3);
    m.e_o = ECP_R(0.7);
    m.e_r = friction == 3 ? ECP_R(0.4) : 0;
    for (i = 0; i < 3; i++) {
        m.direction[i] = directed ? ECP_R(test_random()) : 0;
        x[i] = ECP_R(0.2 * test_random());
        n[i] = ECP_R(test_random());
    }
    for (i = 0; i < 4; i++) q[i] = ECP_R(test_random());
    q[1] += 2;
    n[2] += 2;
    if (kind < 0)
        CHECK(ecp_shape_half_space(&s, n, ECP_R(0.1)) == ECP_OK);
    else
        equations_shape(kind, &s);
    CHECK(ecp_body_add_shape(w, body, &s, x, q, &m, NULL) == ECP_OK);
}

/* the unit of the multipliers in Newton steps, of all patches */
static void equations_set_tilt(ecp_i_island *s, double tilt)
{
    int i;
    for (i = 0; i < s->pair_count; i++) s->pairs[i]->tilt = (ecp_real)tilt;
}

/* what Newton steps take for the rows of multipliers */
static void equations_tilt_rows(const ecp_i_pair *c, int count, const ecp_real *l,
                                const ecp_real *f, ecp_real *F)
{
    ecp_real r;
    int i;
    for (i = 0; i < count; i++) F[i] = ecp_i_fb_value(l[i], -c->tilt * f[i] / c->L, 0, &r);
}

/* F, of which a Newton step is the one */
static void equations_residual(ecp_i_island *s, const ecp_real *z, ecp_real relax, ecp_real *F)
{
    ecp_i_size size;
    int i;
    ecp_i_island_residual(s, z, relax, F, &size);
    for (i = 0; i < s->pair_count; i++) {
        const ecp_i_pair *c = s->pairs[i];
        int pair = !ecp_i_on_plane(c), row = c->at + (pair ? 4 : 3);
        if (ecp_i_tilt_unit(c) >= 1) continue;
        equations_tilt_rows(c, c->nl, z + c->at + 3, c->fa, F + row);
        if (pair)
            equations_tilt_rows(c, c->nm, z + c->at + ecp_i_at_m(c), c->on_b->fb, F + row + c->nl);
    }
}

/* slip is measured along the chord in every other scene */
static int equations_chords;

static void equations_build(equations_scene *k, ecp_real h)
{
    ecp_i_step step;
    ecp_real *vectors[ECP_I_VECTORS];
    size_t bytes = (size_t)1 << 20;
    int i, j, at;
    memset(&step, 0, sizeof step);
    memset(&k->s, 0, sizeof k->s);
    k->memory = (unsigned char *)malloc(bytes);
    k->J = (double *)malloc(EQUATIONS_MAX * EQUATIONS_MAX * sizeof(double));
    step.w = k->world;
    step.motions = k->motions;
    k->arena = ecp_i_arena_over(k->memory, bytes);
    k->s.arena = &k->arena;
    k->s.motions = k->motions;
    k->s.bodies = k->bodies;
    k->s.pairs = k->members;
    k->s.h = h;
    k->s.chord = equations_chords++ % 2 ? h : 0;
    k->s.world = k->world;
    for (i = 0; i < ecp_world_body_count(k->world); i++) {
        ecp_i_motion *m = k->motions + i;
        memset(m, 0, sizeof *m);
        ecp_i_predict(k->world, ecp_i_bodies(k->world) + i, h, m);
        if (!m->dynamic) continue;
        m->at = 6 * k->s.body_count;
        k->bodies[k->s.body_count++] = i;
    }
    at = 6 * k->s.body_count;
    for (i = 0; i < ecp_world_shape_count(k->world); i++) {
        for (j = i + 1; j < ecp_world_shape_count(k->world); j++) {
            ecp_i_pair candidate, *c = k->pairs + k->s.pair_count;
            memset(&candidate, 0, sizeof candidate);
            if (!ecp_i_pair_bind(&step, i, j, &candidate)) continue;
            ecp_i_pair_setup(&candidate, -1);
            CHECK(k->s.pair_count < EQUATIONS_PAIRS);
            *c = candidate;
            ecp_i_carve_pair(&k->arena, c->nl, c->nm, c);
            c->at = at;
            at += c->count;
            k->members[k->s.pair_count++] = c;
        }
    }
    k->s.unknowns = at;
    ecp_i_carve_vectors(&k->arena, at, vectors);
    k->z = vectors[0];
    k->F = vectors[1];
    k->dz = vectors[2];
    CHECK(!k->arena.overflow && at <= EQUATIONS_MAX);
    ecp_i_island_units(&k->s);
    equations_set_tilt(&k->s, 1);
    /* of the load, which rho goes by: from half of what rho is without a load down to its floor */
    for (i = 0; i < k->s.pair_count; i++) {
        ecp_i_set3(0, 0, k->pairs[i].rho * ECP_R(pow(0.25, i) / 2), k->pairs[i].weight);
    }
    ecp_i_island_carve(&k->s);
    CHECK(!k->arena.overflow);
}

static void equations_free(equations_scene *k)
{
    free(k->world);
    free(k->memory);
    free(k->J);
}

/* ---- random points */

typedef enum equations_mode { EQUATIONS_OPEN, EQUATIONS_STICK, EQUATIONS_SLIP } equations_mode;

static double equations_between(double lo, double hi)
{
    return lo + (hi - lo) * (1 + test_random()) / 2;
}

/* multipliers for the constraint values f: in the branch da < db (l > -f / L), or in either */
static int equations_multipliers(int count, const ecp_real *f, ecp_real L, int all_active,
                                 ecp_real *l)
{
    double reach = equations_reach();
    int i;
    for (i = 0; i < count; i++) {
        double b = -(double)f[i] / (double)L, value;
        value = all_active ? b + equations_between(0.1, 1) : equations_between(-1, 1.5);
        if (fabs(value - b) < 0.05 || sqrt(value * value + b * b) < reach) return 0;
        l[i] = (ecp_real)value;
    }
    return 1;
}

/* what the friction rows project, at y */
static ecp_i_projection equations_project(ecp_i_pair *c, const ecp_real *y, ecp_real h)
{
    ecp_i_projection q;
    ecp_i_pair_evaluate(c, y, h);
    ecp_i_cone_project(c, ecp_i_rho(c), &q);
    return q;
}

/* p_n and friction in the wanted branch, given everything else */
static int equations_impulses(ecp_i_pair *c, ecp_real *y, ecp_real h, equations_mode mode)
{
    ecp_real *p = y + ecp_i_at_p(c);
    double reach = equations_reach(), gap = (double)c->d / ((double)h * (double)c->V), size, radius;
    double aim[3], sum = 0;
    ecp_i_projection q;
    int i;
    p[0] = ECP_R(mode == EQUATIONS_OPEN ? equations_between(-1.5, -reach - 0.05)
                                        : equations_between(0.5, 1.5));
    gap += (double)(c->relax * p[0]);
    if (fabs(gap) > 20 || sqrt((double)p[0] * (double)p[0] + gap * gap) < reach) return 0;
    if (c->nf == 0) return 1;
    for (i = 0; i < c->nf; i++) p[1 + i] = 0;
    q = equations_project(c, y, h); /* z = -rho w */
    radius = mode == EQUATIONS_OPEN ? 1 : (double)c->mu * (double)p[0];
    size = mode == EQUATIONS_SLIP ? radius + equations_between(reach + 0.05, 2)
                                  : radius - reach - equations_between(0, 0.2);
    if (size < 0.01) size = 0.01;
    if (mode == EQUATIONS_STICK && radius - size < reach) return 0;
    for (i = 0; i < c->nf; i++) {
        aim[i] = test_random();
        sum += aim[i] * aim[i];
    }
    for (i = 0; i < c->nf; i++) {
        double z = size * aim[i] / sqrt(sum) - (double)q.z[i];
        p[1 + i] = (ecp_real)(z / (1 - (double)(q.rho * c->relax)));
    }
    return 1;
}

static int equations_try(ecp_i_pair *c, ecp_real *y, ecp_real h, int all_active,
                         equations_mode mode)
{
    ecp_real a[3];
    double size;
    int i, k;
    for (i = 0; i < c->count; i++) y[i] = 0;
    for (k = 0; k < 3; k++) {
        a[k] = ECP_R(1.2 * test_random());
        y[k] = a[k] / c->L;
    }
    if (!equations_smooth(&c->a->shape, a)) return 0;
    ecp_i_pair_evaluate(c, y, h);
    if (!equations_multipliers(c->nl, c->fa, c->L, all_active, y + 3)) return 0;
    if (!c->plane) y[ecp_i_at_d(c)] = ECP_R(2 * test_random());
    ecp_i_pair_evaluate(c, y, h);
    size = (double)ecp_i_norm(c->n);
    if (size < 0.3 || size > 3) return 0;
    ecp_i_tangents(c);
    ecp_i_pair_evaluate(c, y, h);
    /* a half-space's normal does not change with the unknowns */
    if (c->nf && (double)c->c_norm < (c->plane ? 0.01 : 0.4) * size) return 0;
    if (!c->plane) {
        if (!equations_smooth(&c->b->shape, c->on_b->b_local) || ecp_i_norm(c->on_b->b_local) > 2)
            return 0;
        if (!equations_multipliers(c->nm, c->on_b->fb, c->L, all_active, y + ecp_i_at_m(c)))
            return 0;
    }
    return equations_impulses(c, y, h, mode);
}

/* a point for all unknowns, and F there; pairs take their mode in turn, from `mode` on */
static int equations_sample(equations_scene *k, int all_active, int mode, ecp_real relax)
{
    int i, attempt;
    for (i = 0; i < k->s.unknowns; i++)
        k->z[i] = i < 6 * k->s.body_count ? ECP_R(0.5 * test_random()) : 0;
    for (i = 0; i < k->s.pair_count; i++) k->members[i]->relax = relax;
    equations_residual(&k->s, k->z, relax, k->F);
    for (i = 0; i < k->s.pair_count; i++) {
        ecp_i_pair *c = k->members[i];
        for (attempt = 0;; attempt++) {
            if (attempt == 20000) return 0;
            if (equations_try(c, k->z + c->at, k->s.h, all_active,
                              (equations_mode)((mode + i) % 3))) {
                break;
            }
        }
    }
    equations_residual(&k->s, k->z, relax, k->F);
    return 1;
}

/* J by differences of sixth order, row major; leaves the island evaluated at z. Returns how far those
   of fourth order are from it, relative to the largest entry of a row: where the two are not near
   each other, F is too curved here for differences to judge by. */
static double equations_differences(equations_scene *k, ecp_real relax)
{
    static const double weight[3] = {45, -9, 1}, lower[3] = {40, -5, 0};
    static double J4[EQUATIONS_MAX * EQUATIONS_MAX];
    double doubt = 0;
    ecp_real F[EQUATIONS_MAX];
    int n = k->s.unknowns, i, j, s;
    for (i = 0; i < n * n; i++) k->J[i] = J4[i] = 0;
    for (j = 0; j < n; j++) {
        ecp_real keep = k->z[j];
        for (s = -3; s <= 3; s++) {
            double step;
            if (s == 0) continue;
            k->z[j] = keep + ECP_R(s * equations_d());
            /* the step that was taken, rounded */
            step = ((double)k->z[j] - (double)keep) / s;
            equations_residual(&k->s, k->z, relax, F);
            for (i = 0; i < n; i++) {
                double slope = (s < 0 ? -1 : 1) / (60 * step) * (double)F[i];
                k->J[n * i + j] += weight[abs(s) - 1] * slope;
                J4[n * i + j] += lower[abs(s) - 1] * slope;
            }
        }
        k->z[j] = keep;
    }
    equations_residual(&k->s, k->z, relax, k->F);
    for (i = 0; i < n; i++) {
        double largest = 0, apart = 0;
        for (j = 0; j < n; j++) {
            largest = fmax(largest, fabs(k->J[n * i + j]));
            apart = fmax(apart, fabs(k->J[n * i + j] - J4[n * i + j]));
        }
        doubt = fmax(doubt, apart / largest);
    }
    return doubt;
}

/* ---- the Jacobian, before elimination, of a scene with one pair and all multipliers active */

/* A patch's block with six velocities and momenta for each of its bodies. The library keeps one set of the
   linear ones for two bodies: velocities of A less those of B, and what A gets in units of the
   lighter body. Rows of such a block; entry i, j of it; j = rows: the right-hand side. */
static int equations_block_rows(const ecp_i_pair *c)
{
    return c->ny + 6 * (c->ma->dynamic + c->mb->dynamic);
}

/* where row or column i stands in the library's block, and what that is to be multiplied by */
static int equations_block_at(const ecp_i_pair *c, int i, int row, double *by)
{
    int both = c->ma->dynamic && c->mb->dynamic, k = (i - c->ny) % 6;
    int of_b = both && i - c->ny >= 6;
    double light = fmin((double)c->ma->mass, (double)c->mb->mass);
    *by = 1;
    if (i < c->ny) return i;
    if (both && k < 3) {
        *by = of_b ? -1 : 1;
        if (row) *by *= light / (double)(of_b ? c->mb : c->ma)->mass;
    }
    return c->ny + k + (of_b && k >= 3 ? 3 : 0);
}

static double equations_block_entry(const ecp_i_pair *c, int i, int j)
{
    double rows, columns = 1;
    int row = equations_block_at(c, i, 1, &rows), column = c->columns - 1;
    if (j < equations_block_rows(c)) column = equations_block_at(c, j, 0, &columns);
    return rows * columns * (double)c->block[c->columns * row + column];
}

/* the mass matrix, which is not in the patch's block, in units m and m L^2 */
static double equations_mass(const equations_scene *k, int row, int column)
{
    const ecp_i_motion *m = k->motions + k->bodies[row / 6];
    ecp_real I[9];
    if (row / 6 != column / 6) return 0;
    row %= 6;
    column %= 6;
    if (row < 3 || column < 3) return row == column;
    ecp_i_congruence(m->R0, m->body->inertia, I);
    return (double)I[3 * (row - 3) + column - 3] /
           ((double)m->body->mass * (double)m->length * (double)m->length);
}

/* the largest difference of an entry, relative to the largest entry of its row */
static double equations_jacobian_error(equations_scene *k)
{
    ecp_i_pair *c = k->members[0];
    int n = k->s.unknowns, place[EQUATIONS_MAX], i, j, side, count = 0;
    double worst = 0;
    ecp_i_block_condense(c, k->z + c->at, 0);
    ecp_i_carve_block(&k->arena, c->ny, c->ma->dynamic + c->mb->dynamic, c);
    CHECK(!k->arena.overflow);
    ecp_i_block_fill(c, k->z + c->at, k->F + c->at, k->s.h, 0, 0);
    CHECK(c->kl == c->nl && c->km == c->nm && equations_block_rows(c) == n);
    for (i = 0; i < c->count; i++) place[count++] = c->at + i;
    for (side = 0; side < 2; side++) {
        const ecp_i_motion *m = side ? c->mb : c->ma;
        for (i = 0; m->dynamic && i < 6; i++) place[count++] = m->at + i;
    }
    CHECK(count == n);
    for (i = 0; i < n; i++) {
        double largest = 0, error = 0;
        for (j = 0; j < n; j++) {
            double wanted = k->J[n * place[i] + place[j]], found = equations_block_entry(c, i, j);
            if (place[i] < 6 * k->s.body_count && place[j] < 6 * k->s.body_count) {
                found += equations_mass(k, place[i], place[j]);
            }
            if (fabs(wanted) > largest) largest = fabs(wanted);
            if (!(fabs(wanted - found) <= error)) error = fabs(wanted - found);
        }
        CHECK(largest > 0);
        if (!(error / largest <= worst)) worst = error / largest;
    }
    return worst;
}

/* ---- the step: J dz = -F, relative to |J| |dz| of the row */

static double equations_step_error(equations_scene *k)
{
    int n = k->s.unknowns, i, j;
    double worst = 0;
    CHECK(ecp_i_island_step(&k->s, k->z, k->F, 1, 0, k->dz));
    for (i = 0; i < n; i++) {
        double sum = (double)k->F[i], size = fabs(sum);
        for (j = 0; j < n; j++) {
            sum += k->J[n * i + j] * (double)k->dz[j];
            size += fabs(k->J[n * i + j] * (double)k->dz[j]);
        }
        if (!(fabs(sum) <= worst * size)) worst = fabs(sum) / size;
    }
    return worst;
}

/* A lower estimate of |J^-1|, with the rows of J scaled to one: what it makes of some random right-
   hand sides. Where it is large the step is a least step by intention (the library takes what is
   below sqrt(eps) for singular), and need not satisfy J dz = -F. */
static double equations_condition(const equations_scene *k)
{
    static double A[EQUATIONS_MAX * (EQUATIONS_MAX + 3)];
    int n = k->s.unknowns, ld = n + 3, i, j, r;
    double worst = 0;
    for (i = 0; i < n; i++) {
        double largest = 0;
        for (j = 0; j < n; j++) {
            if (fabs(k->J[n * i + j]) > largest) largest = fabs(k->J[n * i + j]);
        }
        for (j = 0; j < n; j++) A[ld * i + j] = k->J[n * i + j] / largest;
        for (; j < ld; j++) A[ld * i + j] = test_random() < 0 ? -1 : 1;
    }
    for (r = 0; r < n; r++) {
        int best = r;
        for (i = r; i < n; i++) {
            if (fabs(A[ld * i + r]) > fabs(A[ld * best + r])) best = i;
        }
        if (!(fabs(A[ld * best + r]) > 1e-14)) return 1e300;
        for (j = r; j < ld; j++) {
            double t = A[ld * best + j];
            A[ld * best + j] = A[ld * r + j];
            A[ld * r + j] = t;
        }
        for (i = r + 1; i < n; i++) {
            double factor = A[ld * i + r] / A[ld * r + r];
            for (j = r; factor < 0 || factor > 0 ? j < ld : 0; j++)
                A[ld * i + j] -= factor * A[ld * r + j];
        }
    }
    for (j = n; j < ld; j++) {
        for (i = n - 1; i >= 0; i--) {
            for (r = i + 1; r < n; r++) A[ld * i + j] -= A[ld * i + r] * A[ld * r + j];
            A[ld * i + j] /= A[ld * i + i];
            if (fabs(A[ld * i + j]) > worst) worst = fabs(A[ld * i + j]);
        }
    }
    return worst;
}

static int equations_steps, equations_singular; /* points checked, and those left out */
static int equations_tilted;                    /* checked with multipliers in their unit */

/* ---- scenes */

/* A: a primitive on a dynamic body, or on a kinematic one; B likewise, or a half-space (-1) */
static void equations_one_pair(equations_scene *k, int kind_a, ecp_body_kind body_a, int kind_b,
                               ecp_body_kind body_b, int friction, int directed)
{
    k->world = test_world(NULL);
    equations_random_body(k->world, body_a, 0.8);
    equations_random_body(k->world, body_b, 0.8);
    equations_add_shape(k->world, 0, kind_a, friction, directed & 1);
    equations_add_shape(k->world, 1, kind_b, friction, directed >> 1);
    equations_build(k, ECP_R(0.3));
    CHECK(k->s.pair_count == 1 && k->pairs[0].nf == friction);
    CHECK(k->pairs[0].plane == (kind_b < 0));
}

static void equations_judge(const char *test, const char *what, const int label[3], double relax,
                            double error, double tolerance)
{
    if (!(error <= tolerance)) {
        printf("%s of %s %d %d, mode %d, relax %g\n", test, what, label[0], label[1], label[2],
               relax);
    }
    CHECK_NEAR(error, 0, tolerance);
}

/* The same with multipliers in their unit, which relaxed problems leave alone; in double, as the differences of float
   are too coarse for rows with slopes that far apart. */
static void equations_check_tilted(equations_scene *k, const char *what, const int label[3])
{
    double tilt = 1.0 / 16;
    if (sizeof(ecp_real) == sizeof(float) || k->pairs[0].relax > 0) return;
    equations_set_tilt(&k->s, tilt);
    if (4 * equations_differences(k, 0) <= equations_tolerance() &&
        equations_condition(k) <= test_by(1e6, 100)) {
        equations_tilted++;
        equations_judge("tilted step", what, label, 0, equations_step_error(k),
                        10 * equations_tolerance());
    }
    equations_set_tilt(&k->s, 1);
    equations_residual(&k->s, k->z, 0, k->F);
}

static void equations_check(equations_scene *k, int mode, const char *what, int kind_a, int kind_b)
{
    int active, smooth, label[3];
    label[0] = kind_a;
    label[1] = kind_b;
    label[2] = mode;
    for (smooth = 0; smooth < 2; smooth++) {
        ecp_real relax = smooth ? ECP_R(0.3) : 0;
        for (active = 1; active >= 0; active--) {
            double doubt = 1;
            int found = 1, sample;
            for (sample = 0; sample < 50 && found && !(4 * doubt <= equations_tolerance());
                 sample++) {
                found = equations_sample(k, active, mode, relax);
                if (found) doubt = equations_differences(k, relax);
            }
            CHECK(found && 4 * doubt <= equations_tolerance());
            if (!found) continue;
            if (active && k->s.pair_count == 1) {
                equations_judge("jacobian", what, label, (double)relax, equations_jacobian_error(k),
                                equations_tolerance());
            }
            if (equations_condition(k) > test_by(1e6, 100)) {
                equations_singular++;
                continue;
            }
            equations_steps++;
            equations_judge("step", what, label, (double)relax, equations_step_error(k),
                            10 * equations_tolerance());
            equations_check_tilted(k, what, label);
        }
    }
}

static void equations_test_planes(void)
{
    static const int rows[3] = {0, 2, 3};
    int kind, f, mode;
    for (kind = 0; kind < EQUATIONS_KINDS; kind++) {
        for (f = 0; f < 3; f++) {
            for (mode = 0; mode < 3; mode++) {
                equations_scene k;
                equations_one_pair(&k, kind, ECP_DYNAMIC, -1, mode % 2 ? ECP_STATIC : ECP_KINEMATIC,
                                   rows[f], (kind + mode) % 3);
                equations_check(&k, mode, "plane", kind, rows[f]);
                equations_free(&k);
            }
        }
    }
}

static void equations_test_pairs(void)
{
    static const int rows[3] = {0, 2, 3};
    static const ecp_body_kind partners[4][2] = {{ECP_DYNAMIC, ECP_DYNAMIC},
                                                 {ECP_DYNAMIC, ECP_KINEMATIC},
                                                 {ECP_KINEMATIC, ECP_DYNAMIC},
                                                 {ECP_DYNAMIC, ECP_STATIC}};
    int a, b, turn = 0, kind, mode;
    for (a = 0; a < EQUATIONS_KINDS; a++) {
        for (b = 0; b < EQUATIONS_KINDS; b++, turn++) {
            equations_scene k;
            equations_one_pair(&k, a, partners[turn / 3 % 4][0], b, partners[turn / 3 % 4][1],
                               rows[turn % 3], turn % 3);
            equations_check(&k, turn % 2 ? turn / 2 % 3 : 2, "pair", a, b);
            equations_free(&k);
        }
    }
    /* every kind of partner in every mode with every number of rows, on curved and flat sides */
    for (kind = 0; kind < 4; kind++) {
        for (turn = 0; turn < 3; turn++) {
            for (mode = 0; mode < 3; mode++) {
                equations_scene k;
                equations_one_pair(&k, 3, partners[kind][0], 4, partners[kind][1], rows[turn],
                                   (kind + mode) % 3);
                equations_check(&k, mode, "partners", kind, rows[turn]);
                equations_free(&k);
            }
        }
    }
}

/* an island of two dynamic bodies between a floor and a moving body: patches share bodies, so the
   front has to put their blocks together */
static void equations_test_islands(void)
{
    static const int kinds[4][4] = {{5, 3, 0, 1}, {6, 4, 2, 7}, {5, 5, 5, 5}, {0, 1, 0, 3}};
    int i, mode;
    for (i = 0; i < 4; i++) {
        for (mode = 0; mode < 3; mode++) {
            ecp_world_desc desc = ecp_world_desc_default();
            equations_scene k;
            desc.max_inequalities = 12;
            k.world = test_world(&desc);
            equations_random_body(k.world, ECP_STATIC, 0);
            equations_random_body(k.world, ECP_DYNAMIC, 0.8);
            equations_random_body(k.world, ECP_KINEMATIC, 0.8);
            equations_random_body(k.world, ECP_DYNAMIC, 0.8);
            equations_add_shape(k.world, 0, -1, 3, 0);
            equations_add_shape(k.world, 1, kinds[i][0], 3, 1);
            equations_add_shape(k.world, 2, kinds[i][1], 2, 0);
            equations_add_shape(k.world, 3, kinds[i][2], mode ? 3 : 0, 1);
            if (i != 2) equations_add_shape(k.world, 3, kinds[i][3], 3, 0);
            equations_build(&k, ECP_R(0.3));
            CHECK(k.s.body_count == 2 && k.s.pair_count == (i != 2 ? 8 : 5));
            equations_check(&k, mode, "island", i, 0);
            equations_free(&k);
        }
    }
}

/* Two bodies that move as one: along the chord of the step nothing slips between them, wherever the ECP is; at its
   end they slip by about h w^2 r / 2. */
static void equations_test_chord(void)
{
    const ecp_real h = ECP_R(0.1), w[3] = {ECP_R(1.1), ECP_R(-0.7), ECP_R(0.5)};
    ecp_real T[9], J[9], apart[3], turned[3], dv[6];
    int chord, k;
    for (chord = 0; chord < 2; chord++) {
        equations_scene e;
        const ecp_i_motion *a, *b;
        equations_one_pair(&e, 3, ECP_DYNAMIC, 5, ECP_DYNAMIC, 3, 1);
        e.s.chord = chord ? h : 0;
        e.s.h = h;
        a = e.pairs[0].ma;
        b = e.pairs[0].mb;
        ecp_i_cayley(w, h, T, J);
        ecp_i_sub(b->body->x, a->body->x, apart);
        ecp_i_mul(T, apart, turned);
        for (k = 0; k < 3; k++) {
            dv[k] = (k == 0) - a->body->v[k];
            dv[3 + k] = w[k] - a->body->v[3 + k];
        }
        for (k = 0; k < 6; k++) e.z[a->at + k] = dv[k] / a->speed * (k < 3 ? ECP_R(1) : a->length);
        for (k = 0; k < 3; k++) {
            dv[k] = (k == 0) + turned[k] / h - b->body->v[k];
            dv[3 + k] = w[k] - b->body->v[3 + k];
        }
        for (k = 0; k < 6; k++) e.z[b->at + k] = dv[k] / b->speed * (k < 3 ? ECP_R(1) : b->length);
        for (k = 0; k < 3; k++) e.z[e.pairs[0].at + k] = ECP_R(0.1 * k);
        equations_residual(&e.s, e.z, 0, e.F);
        CHECK((double)ecp_i_norm(e.pairs[0].spin) <= test_by(1e-14, 1e-5));
        if (chord)
            CHECK((double)ecp_i_norm(e.pairs[0].v) <= test_by(1e-14, 1e-5));
        else
            CHECK(ecp_i_norm(e.pairs[0].v) > ECP_R(0.01));
        equations_free(&e);
    }
}

/* rho of the friction rows: the load or the lighter body's mass (float: the load), but no more than that of the
   error and no less than its 2^-20 (float: 2^-10); in a relaxed problem that of the error */
static void equations_test_rho(void)
{
    /* weight of the load, and masses of the two (0: does not move), in P / V */
    static const double cases[9][3] = {{2, 3, 4},     {0.1, 3, 4},    {1e-9, 3, 4},
                                       {0, 3, 4},     {2, 0.2, 4},    {2, 5, 0.01},
                                       {0.1, 0.2, 4}, {2, 1e-9, 100}, {2, 0.125, 0}};
    static const double expected[9] = {0.5, 0.1, 0, 0, 0.2, 0.01, 0.1, 0, 0.125};
    static const double in_float[9] = {0.5, 0.1, 0,   0,  0.5,
                                       0.5, 0.1, 0.5, 0.5}; /* by the load alone */
    ecp_i_motion a, b;
    ecp_i_pair c;
    int k;
    memset(&a, 0, sizeof a);
    memset(&b, 0, sizeof b);
    memset(&c, 0, sizeof c);
    c.ma = c.carried = &a;
    c.mb = &b;
    c.rho = ECP_R(0.5);
    c.P = 6;
    c.V = 3;
    a.dynamic = 1;
    for (k = 0; k < 9; k++) {
        double rho =
            fmax(test_by(expected[k], in_float[k]), test_by(0.5 / 1024 / 1024, 0.5 / 1024));
        ecp_i_set3(0, -ECP_R(cases[k][0]), 0, c.weight);
        a.mass = ECP_R(2 * cases[k][1]);
        b.mass = ECP_R(2 * cases[k][2]);
        b.dynamic = cases[k][2] > 0;
        c.relax = 0;
        CHECK_NEAR(ecp_i_rho(&c), rho, test_by(1e-15, 1e-7) * rho);
        c.relax = ECP_R(1e-3);
        CHECK_NEAR(ecp_i_rho(&c), 0.5, 0);
    }
}

/* whether friction holds says the rho that does not depend on the load: a slip of 2 at an impulse of 1, without
   load, is one */
static void equations_test_sticks(void)
{
    ecp_i_pair c;
    memset(&c, 0, sizeof c);
    c.nf = 2;
    c.rho = c.mu = c.p[0] = 1;
    ecp_i_set3(2, 0, 0, c.slip);
    CHECK(!ecp_i_sticks(&c, ECP_R(1e-3)));
    ecp_i_set3(ECP_R(0.5), 0, 0, c.slip);
    CHECK(ecp_i_sticks(&c, ECP_R(1e-3)));
}

/* So is the error measured: without a load, and without friction's impulse, a contact that slips within the
   cone is off by rho times its slip, and that is what the residual says where no other row is larger. */
static void equations_test_measured(void)
{
    int kind, found = 0;
    for (kind = 0; kind < 24; kind++) {
        equations_scene k;
        ecp_i_pair *c = k.pairs;
        ecp_i_size size;
        double others = 0, slip = 0;
        int i;
        equations_one_pair(&k, kind % 8, ECP_DYNAMIC, -1, ECP_STATIC, 2, 0);
        c->mu = 1000;
        c->rho = 30;   /* so that the row is a large one */
        k.s.loose = 1; /* geometry without its weights in float */
        ecp_i_set3(0, 0, 0, c->weight);
        CHECK(equations_sample(&k, 1, EQUATIONS_STICK, 0));
        for (i = 0; i < 2; i++) k.z[c->at + ecp_i_at_p(c) + 1 + i] = 0;
        ecp_i_island_residual(&k.s, k.z, 0, k.F, &size);
        for (i = 0; i < k.s.unknowns; i++) {
            int friction = i - c->at - ecp_i_at_p(c) - 1;
            if (friction < 0 || friction >= 2) others = fmax(others, fabs((double)k.F[i]));
        }
        for (i = 0; i < 2; i++) slip = fmax(slip, fabs((double)(c->rho * c->slip[i])));
        CHECK_NEAR(size.largest, fmax(others, slip), test_by(1e-13, 1e-5) * fmax(others, slip));
        if (slip > others) {
            CHECK_NEAR(size.error, slip, test_by(1e-9, 1e-3) * slip);
            found++;
        }
        equations_free(&k);
    }
    CHECK(found >= 3);
}

static void test_equations(void)
{
    equations_test_chord();
    equations_test_rho();
    equations_test_sticks();
    test_seed = 34;
    equations_test_planes();
    equations_test_pairs();
    equations_test_islands();
    equations_test_measured();
    /* nearly no random point is singular in double; in float one in ten is too nearly so */
    CHECK(equations_singular < test_by(0.02, 0.25) * equations_steps);
    CHECK(sizeof(ecp_real) == sizeof(float) || equations_tilted > 0.2 * equations_steps);
}
