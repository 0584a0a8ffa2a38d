/* The stress run: stress [quick|full] [family] [case]

   Families of scenes, each built from a seed, so that `stress full pair 17` repeats one case, with a
   line a step on stderr. STRESS_SEED=1 stress full: other cases of the same families, for any number.
   STRESS_FALLBACKS=95 stress full corner: with these of the ECP_FALLBACK_... alone (here without the chord).
   STRESS_BOUND=500 stress full drop: with max_total_iterations.
   After every step the report is counted, and penetration is measured by code that knows nothing of
   the solver (distance.h). A step that is not solved ends its case. `stress full cups`, `wall` and
   `jolt` are known to leave some unsolved (docs/numerics.md); they and `crates` are no part of the whole run. One row a
   family, and the sum:

     geom .. sub   steps that needed each fallback
     depth         worst penetration, in relation to the smaller body of the pair
     residual      worst natural residual, scaled
     gain          most energy won in a step, in relation to m v^2 + I w^2 + m g size, where no load
                   acts. The explicit gyroscopic term wins some at h w near 1
     own           worst error of the family's own truth, if it has one (impulses, creep, drift)
     missed        steps deeper than 1e-9, or in which bodies go elsewhere than their velocities (whole
                   steps), or a contact pulls or leaves its cone; cases that miss their own truth's bar

   Exit status 1: a bar is missed. In float only unsolved steps count, more than one in 10^6. */
#define ECPSIM_IMPLEMENTATION
#include "../ecpsim.h"

#include "scene.h"
#include "distance.h"

#include <unistd.h>

#define MOST_BODIES 64
#define PRIMITIVES 8
#define SOLIDS 12
#define FALLBACKS 7

/* one case of a family, and what is known of it while it runs */
typedef struct trial {
    scene s;
    int number, full, trace;
    double h;
    int steps;
    int loaded;      /* no energy balance */
    int overlapping; /* energy balance only from the first solved step on */
    int endless;     /* fallbacks of the second half may not outnumber those of the first */
    void (*drive)(struct trial *t, int step);
    double (*truth)(struct trial *t, int step);       /* the family's own error after a step */
    double bar;                                       /* and the most that it may be, in double */
    ecp_body_desc body[MOST_BODIES];                  /* as added; kind 0: static */
    double size[MOST_BODIES], before[MOST_BODIES][3]; /* where they were before the step */
    double energy, energy_scale;
} trial;

typedef struct family {
    const char *name;
    void (*build)(trial *t);
    int quick, full; /* cases */
    int apart; /* runs only if it is named, and is in no sum: many of its steps are not solved; 2: so by
                  ecp_advance alone, whose limit of solves such heaps exceed */
} family;

/* what a row prints; the sum of all rows is one too */
typedef struct tally {
    long cases, steps, unsolved, missed, iterations, by[FALLBACKS], fallback_steps;
    double depth, metres, residual, gain, own;
    int most_iterations, complaints;
} tally;

static const int in_double = sizeof(ecp_real) == sizeof(double);
static const double up[3] = {0, 0, 1}, down[3] = {0, 0, -1};

/* ---- parts of scenes */

static int put(trial *t, const solid *b, double mass, const double x[3], const double *q,
               const double *v, const double *w)
{
    ecp_body_desc d;
    int body = body_add(&t->s, b, mass, x, q, v, w, &d);
    t->body[body] = d;
    return body;
}

static void polytope(scene *s, double size, solid *b)
{
    double c = size / 2, side = sqrt(3.0) / 2;
    double tetrahedron[4][4] = {{1, 1, 1, c}, {1, -1, -1, c}, {-1, 1, -1, c}, {-1, -1, 1, c}};
    double prism[5][4] = {
        {1, 0, 0, c}, {-0.5, side, 0, c}, {-0.5, -side, 0, c}, {0, 0, 1, 0.7 * c}, {0, 0, -1, c}};
    double octahedron[8][4];
    int i;
    for (i = 0; i < 8; i++) {
        octahedron[i][0] = i & 1 ? 1 : -1;
        octahedron[i][1] = i & 2 ? 1 : -1;
        octahedron[i][2] = i & 4 ? 1 : -1;
        octahedron[i][3] = c;
    }
    switch (pick(s, 3)) {
    case 0: solid_hull(s, b, tetrahedron, 4); break;
    case 1: solid_hull(s, b, prism, 5); break;
    default: solid_hull(s, b, octahedron, 8);
    }
}

/* boxes: those of half sizes `half` at `at`, as one solid */
static void boxes(solid *b, int count, double (*half)[3], double (*at)[3])
{
    ecp_shape shape;
    ecp_real size[3];
    int i;
    memset(b, 0, sizeof *b);
    for (i = 0; i < count; i++) {
        to_real(half[i], 3, size);
        must(ecp_shape_box(&shape, size));
        solid_add(b, &shape, at[i][0], at[i][1], at[i][2], NULL);
    }
    solid_close(b);
}

/* a board on four round legs, or a square of n feet under one board */
static void table(solid *b, double size, double leg, int across)
{
    ecp_shape shape;
    ecp_real half[3];
    double pitch = across > 1 ? 2 * (size - leg) / (across - 1) : 0;
    int i;
    memset(b, 0, sizeof *b);
    half[0] = half[1] = (ecp_real)size;
    half[2] = (ecp_real)(0.1 * size);
    must(ecp_shape_box(&shape, half));
    solid_add(b, &shape, 0, 0, 0.6 * size, NULL);
    must(ecp_shape_cylinder(&shape, (ecp_real)leg, (ecp_real)(0.5 * size)));
    for (i = 0; i < across * across; i++) {
        solid_add(b, &shape, i % across * pitch - size + leg, i / across * pitch - size + leg, 0,
                  NULL);
    }
    solid_close(b);
}

static void dumbbell(solid *b, double size)
{
    ecp_shape shape;
    memset(b, 0, sizeof *b);
    must(ecp_shape_sphere(&shape, (ecp_real)(0.4 * size)));
    solid_add(b, &shape, 0, 0, 0.6 * size, NULL);
    solid_add(b, &shape, 0, 0, -0.6 * size, NULL);
    must(ecp_shape_cylinder(&shape, (ecp_real)(0.1 * size), (ecp_real)(0.6 * size)));
    solid_add(b, &shape, 0, 0, 0, NULL);
    solid_close(b);
}

/* a solid of this kind (the first PRIMITIVES are single) with random proportions */
static void random_solid(scene *s, int kind, double size, solid *b)
{
    double a = size * uniform(s, 0.3, 1), c = size * uniform(s, 0.3, 1);
    double L[2][3] = {{0.2, 0.2, 1}, {0.4, 0.2, 0.2}}, L_at[2][3] = {{0, 0, 0}, {0.6, 0, -0.8}};
    double T[2][3] = {{0.2, 0.2, 0.8}, {0.9, 0.2, 0.2}}, T_at[2][3] = {{0, 0, 0}, {0, 0, 1}};
    ecp_real radii[3];
    int i, k;
    for (i = 0; i < 2; i++) {
        for (k = 0; k < 3; k++) {
            L[i][k] *= size;
            L_at[i][k] *= size;
            T[i][k] *= size;
            T_at[i][k] *= size;
        }
    }
    switch (kind) {
    case 0: solid_round(b, ECP_SPHERE, a, 0, 0); break;
    case 1:
        radii[0] = (ecp_real)a;
        radii[1] = (ecp_real)c;
        radii[2] = (ecp_real)(size * uniform(s, 0.3, 1));
        memset(b, 0, sizeof *b);
        must(ecp_shape_ellipsoid(b->shape, radii));
        b->parts = 1;
        b->turn[0][0] = 1;
        solid_close(b);
        break;
    case 2: solid_round(b, ECP_CAPSULE, 0.5 * a, 0, c); break;
    case 3: solid_round(b, ECP_CYLINDER, a, 0, c); break;
    case 4: solid_round(b, ECP_FRUSTUM, a, 0.5 * c, c); break;
    case 5: solid_round(b, ECP_FRUSTUM, a, 0, c); break;
    case 6: solid_box(b, a, c, size * uniform(s, 0.3, 1)); break;
    case 7: polytope(s, a, b); break;
    case 8: table(b, size, 0.15 * size, 2); break;
    case 9: boxes(b, 2, L, L_at); break;
    case 10: boxes(b, 2, T, T_at); break;
    default: dumbbell(b, size);
    }
}

static double random_mu(scene *s)
{
    static const double mu[5] = {0, 0.1, 0.5, 1, 2};
    return mu[pick(s, 5)];
}

static void random_friction(scene *s, double e_r) { friction(s, random_mu(s), e_r); }

/* flat, nearly flat, or anyhow */
static void random_stand(scene *s, double q[4])
{
    double axis[3];
    switch (pick(s, 3)) {
    case 0: turn_about(0, 0, 1, uniform(s, 0, 6), q); break;
    case 1:
        random_vector(s, 1, axis);
        normalise(axis, 3);
        turn_about(axis[0], axis[1], axis[2], log_uniform(s, 1e-9, 1e-1), q);
        break;
    default: random_turn(s, q);
    }
}

/* one solid over the plane z = 0, its lowest point `gap` above it */
static int put_above(trial *t, const solid *b, double mass, double gap, const double q[4],
                     const double *v, const double *w)
{
    double p[3], x[3] = {0, 0, 0};
    x[2] = solid_reach(b, q, down, p) + gap;
    return put(t, b, mass, x, q, v, w);
}

/* a world of one solid and the plane z = 0 */
static void open_plane(trial *t, const solid *b, double g)
{
    int i, most = 1;
    for (i = 0; i < b->parts; i++) {
        if (b->shape[i].inequalities > most) most = b->shape[i].inequalities;
    }
    scene_open(&t->s, 2, b->parts + 1, b->parts, most, g);
}

/* ---- single bodies on a plane */

/* the step, the friction and the solid of a case by its number */
static void plane_case(trial *t, solid *b)
{
    static const double hs[5] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5}, mus[5] = {0, 0.1, 0.5, 1, 2};
    scene *s = &t->s;
    double size = log_uniform(s, 0.1, 1);
    random_solid(s, t->number % SOLIDS, size, b);
    open_plane(t, b, 9.8);
    friction(s, mus[(t->number / SOLIDS + t->number / (5 * SOLIDS)) % 5],
             pick(s, 2) * uniform(s, 0, 0.3) * size);
    ground(s, 0, 0, 1, NULL);
    t->h = hs[t->number / SOLIDS % 5];
    t->steps = 200;
}

static void build_drop(trial *t)
{
    double q[4], v[3] = {0, 0, 0}, lift;
    scene *s = &t->s;
    solid b;
    plane_case(t, &b);
    random_stand(s, q);
    v[2] = -log_uniform(s, 1e-3, 10);
    lift = -v[2] * t->h * uniform(s, 0, 20);
    put_above(t, &b, log_uniform(s, 0.1, 10), lift, q, v, NULL);
}

static void build_throw(trial *t)
{
    double q[4], v[3], w[3], lift;
    scene *s = &t->s;
    solid b;
    plane_case(t, &b);
    random_stand(s, q);
    random_vector(s, log_uniform(s, 0.1, 100), v);
    random_vector(s, log_uniform(s, 0.1, 1000), w);
    v[2] = -fabs(v[2]);
    lift = -v[2] * t->h * uniform(s, 0, 10);
    put_above(t, &b, log_uniform(s, 0.1, 10), lift, q, v, w);
}

/* ---- pairs in free space */

enum {
    HEAD_ON,
    GLANCING,
    EDGES,
    VERTICES,
    FACES,
    ALONGSIDE,
    TOUCHING,
    APART,
    OVERLAPPING,
    MEETINGS
};

/* the direction of a solid that meets the other one: a face, edge, vertex, mantle, or anything */
static void meeting_direction(scene *s, int meeting, double n[3])
{
    static const double face[3] = {0, 0, 1}, edge[3] = {1, 0, 1}, vertex[3] = {1, 1, 1},
                        mantle[3] = {1, 0, 0};
    const double *fixed = NULL;
    if (meeting >= TOUCHING) meeting = pick(s, 6);
    if (meeting == EDGES) fixed = edge;
    if (meeting == VERTICES) fixed = vertex;
    if (meeting == FACES) fixed = face;
    if (meeting == ALONGSIDE) fixed = mantle;
    if (fixed) memcpy(n, fixed, sizeof face);
    if (!fixed) random_vector(s, 1, n);
    normalise(n, 3);
}

/* how the upper one of the pair comes down on the lower one, 1 m/s or so */
static void meeting_velocity(scene *s, int meeting, double v[3])
{
    double speed = log_uniform(s, 0.01, 10);
    v[0] = v[1] = 0;
    v[2] = -speed;
    if (meeting == OVERLAPPING) v[2] = 0;
    if (meeting == GLANCING || (meeting >= TOUCHING && meeting < OVERLAPPING && pick(s, 2))) {
        v[0] = speed;
        v[2] = -0.05 * speed;
    }
}

static void build_pair(trial *t)
{
    scene *s = &t->s;
    int meeting = t->number / (PRIMITIVES * PRIMITIVES) % MEETINGS, k;
    double na[3], nb[3], qa[4], qb[4], twist[4], pa[3], pb[3], x[3], v[3], w[3] = {0, 0, 0};
    double gap, reach, other, size = log_uniform(s, 0.2, 1);
    solid a, b;
    random_solid(s, t->number % PRIMITIVES, size, &a);
    random_solid(s, t->number / PRIMITIVES % PRIMITIVES, size * uniform(s, 0.2, 1), &b);
    scene_open(s, 2, 2, 1, a.shape->inequalities + b.shape->inequalities, 0);
    random_friction(s, pick(s, 2) * 0.1 * size);
    t->h = pick(s, 2) ? 1e-2 : 1e-3;
    t->steps = 50;

    /* they meet in the lowest point of a and the highest of b */
    meeting_direction(s, meeting, na);
    meeting_direction(s, meeting, nb);
    turn_between(na, down, qa);
    turn_between(nb, up, qb);
    turn_about(0, 0, 1, meeting == ALONGSIDE || pick(s, 2) ? 0 : uniform(s, 0, 6), twist);
    turn_after(twist, qa, qa);
    reach = solid_reach(&a, qa, down, pa);
    other = solid_reach(&b, qb, up, pb);
    if (other < reach) reach = other;

    meeting_velocity(s, meeting, v);
    gap = -v[2] * t->h * uniform(s, 0, 5);
    if (meeting == TOUCHING) gap = 0;
    if (meeting == APART) gap = 1e-12 * size;
    if (meeting == OVERLAPPING) gap = -uniform(s, 0, 0.25) * reach;
    t->overlapping = meeting == OVERLAPPING;
    for (k = 0; k < 3; k++) x[k] = pb[k] - pa[k] + gap * up[k];
    if (pick(s, 2)) random_vector(s, 1, w);
    put(t, &a, log_uniform(s, 0.1, 10), x, qa, v, w);
    x[0] = x[1] = x[2] = 0;
    put(t, &b, log_uniform(s, 0.1, 10), x, qb, NULL, NULL);
}

/* ---- stacks and structures */

/* the impulse between any two neighbours carries what is above, shape i on shape i - 1 */
static double stack_truth(trial *t, int step)
{
    int n = ecp_world_body_count(t->s.world) - 1, i, k;
    double above = 0, worst = 0;
    if (step != 0 && step != t->steps - 1) return 0;
    for (i = n; i > 0; i--) {
        double carried = 0, error;
        ecp_contact c;
        above += (double)t->body[i].mass;
        for (k = 0; k < ecp_contact_count(t->s.world); k++) {
            must(ecp_contact_get(t->s.world, k, &c));
            if (c.shape_a + c.shape_b == 2 * i - 1 && (c.shape_a == i || c.shape_b == i)) {
                carried += (double)c.p_n;
            }
        }
        /* (of the base step, where ecp_advance has taken more than one) */
        error = fabs(carried / (-t->s.g[2] * (double)t->s.world->last_h * above) - 1);
        if (!(error <= worst)) worst = error;
    }
    return worst;
}

/* 2 to 50 boxes, the uppermost of 1e-6 to 1e6 times the mass of the lowest */
static void build_stack(trial *t)
{
    static const int heights[6] = {2, 3, 5, 10, 20, 50};
    int n = heights[t->number % 6], i;
    double ratio = pow(1e3, t->number / 6 % 5 - 2), x[3] = {0, 0, 0};
    solid b;
    scene_open(&t->s, n + 1, n + 1, 3 * n, 12, 9.8);
    ground(&t->s, 0, 0, 1, NULL);
    solid_box(&b, 0.1, 0.1, 0.05);
    for (i = 0; i < n; i++) {
        x[2] = 0.1 * i + 0.05;
        put(t, &b, pow(ratio, (double)i / (n - 1)), x, NULL, NULL, NULL);
    }
    t->h = t->number / 30 % 2 ? 1e-3 : 1e-2;
    t->steps = 20;
    t->truth = stack_truth;
    t->bar = 1e-9;
}

static void build_plank(trial *t)
{
    scene *s = &t->s;
    double r = 0.2, x[3] = {0, 0, 0}, v[3] = {0, 0, 0};
    solid ball, plank;
    int i;
    scene_open(s, 4, 4, 6, 7, 9.8);
    random_friction(s, 0);
    ground(s, 0, 0, 1, NULL);
    solid_round(&ball, ECP_SPHERE, r, 0, 0);
    solid_box(&plank, 1, 0.2, 0.05);
    x[2] = r;
    for (i = 0; i < 2; i++) {
        x[0] = i ? 0.6 : -uniform(s, 0.3, 0.7);
        put(t, &ball, 1, x, NULL, NULL, NULL);
    }
    x[0] = 0;
    x[2] = 2 * r + 0.05;
    v[0] = pick(s, 2) * uniform(s, -1, 1);
    put(t, &plank, log_uniform(s, 1e-3, 1e3), x, NULL, v, NULL);
    t->h = t->number % 2 ? 1e-3 : 1e-2;
    t->steps = 200;
}

/* two cards that lean against each other over the point (x, z) */
static void lean(trial *t, double x, double z, double half, double thick, double angle)
{
    double at[3] = {0, 0, 0}, q[4];
    solid card;
    int side;
    solid_box(&card, thick, 0.7 * half, half);
    for (side = -1; side <= 1; side += 2) {
        at[0] = x + side * (half * sin(angle) + thick * cos(angle));
        at[2] = z + half * cos(angle) + thick * sin(angle);
        turn_about(0, 1, 0, -side * angle, q);
        put(t, &card, 1e-3, at, q, NULL, NULL);
    }
}

/* one pair of cards, or two under a deck that carries a third */
static void build_cards(trial *t)
{
    double half = 0.045, thick = 2e-4, angle = uniform(&t->s, 0.1, 0.4), x[3] = {0, 0, 0}, wide,
           top;
    int house = t->number % 2;
    solid deck;
    scene_open(&t->s, house ? 8 : 3, house ? 8 : 3, house ? 30 : 3, 12, 9.8);
    friction(&t->s, uniform(&t->s, 0.3, 1), 0);
    ground(&t->s, 0, 0, 1, NULL);
    wide = 2 * (half * sin(angle) + thick * cos(angle));
    top = 2 * (half * cos(angle) + thick * sin(angle));
    lean(t, house * wide, 0, half, thick, angle);
    if (house) {
        lean(t, -wide, 0, half, thick, angle);
        solid_box(&deck, 2 * wide, 0.7 * half, thick);
        x[2] = top + thick;
        put(t, &deck, 1e-3, x, NULL, NULL, NULL);
        lean(t, 0, top + 2 * thick, half, thick, angle);
    }
    t->h = t->number / 2 % 2 ? 1e-3 : 1e-2;
    t->steps = 100;
}

/* half a ring of n wedges that stands on the plane; block i is turned by the middle of its angle */
static void build_arch(trial *t)
{
    scene *s = &t->s;
    int n = 3 + t->number % 7, i;
    double step = scene_pi / n, middle = cos(step / 2), thick = uniform(s, 0.15, 0.3), q[4], x[3];
    double half = sin(step / 2), mean = 1 - thick / 2; /* the outer radius is 1 */
    double rows[6][4] = {{1, 0, 0, 0}, {-1, 0, 0, 0}, {0, 1, 0, 0.2}, {0, -1, 0, 0.2}};
    solid b;
    rows[0][3] = rows[1][3] = thick / 2 * middle;
    for (i = 4; i < 6; i++) { /* the joints: their planes contain the axis of the ring */
        rows[i][0] = -half;
        rows[i][2] = i == 4 ? middle : -middle;
        rows[i][3] = mean * middle * half;
    }
    scene_open(s, n + 1, n + 1, 3 * n, 12, 9.8);
    friction(s, uniform(s, 0.5, 1), 0);
    ground(s, 0, 0, 1, NULL);
    solid_hull(s, &b, rows, 6);
    for (i = 0; i < n; i++) {
        double angle = (i + 0.5) * step, centre[3] = {0, 0, 0}, moved[3];
        centre[0] =
            mean * middle - b.at[0][0]; /* the origin of the planes, and the closed solid's */
        turn_about(0, 1, 0, -angle, q);
        turned(q, centre, moved);
        memcpy(x, moved, sizeof x);
        put(t, &b, 1, x, q, NULL, NULL);
    }
    t->h = t->number / 7 % 2 ? 1e-3 : 1e-2;
    t->steps = 50;
}

static void build_dominoes(trial *t)
{
    scene *s = &t->s;
    double x[3] = {0, 0, 0}, w[3] = {0, 0, 0}, pitch = uniform(s, 0.03, 0.06);
    solid b;
    int i;
    scene_open(s, 21, 21, 100, 12, 9.8);
    friction(s, uniform(s, 0.2, 1), 0);
    ground(s, 0, 0, 1, NULL);
    solid_box(&b, 0.005, 0.025, 0.05);
    x[2] = 0.05;
    for (i = 0; i < 20; i++) {
        x[0] = pitch * i;
        w[1] = i == 0 ? 5 : 0;
        put(t, &b, 0.05, x, NULL, NULL, w);
    }
    t->h = t->number % 2 ? 2e-3 : 1e-2;
    t->steps = t->number % 2 ? 500 : 150;
}

/* What falls and is thrown in games, at the steps of games: small bodies that fall on each other, between
   three planes or on one, and a wall of bricks that a ball hits. */
static void build_heap(trial *t)
{
    static const double funnel[3][3] = {{0.6, 0, 0.8}, {-0.3, 0.52, 0.8}, {-0.3, -0.52, 0.8}};
    static const double around[3][2] = {{-1, 0}, {0.5, 0.866}, {0.5, -0.866}};
    scene *s = &t->s;
    solid kinds[6];
    int scene_kind = t->number % 3, i, j;
    double x[3], v[3] = {0, 0, 0}, q[4], e_r, mass;
    solid_box(kinds, 0.03, 0.02, 0.015);
    solid_round(kinds + 1, ECP_SPHERE, 0.02, 0, 0);
    solid_round(kinds + 2, ECP_CYLINDER, 0.024, 0, 0.001);
    solid_round(kinds + 3, ECP_CAPSULE, 0.012, 0, 0.03);
    solid_round(kinds + 4, ECP_CYLINDER, 0.015, 0, 0.02);
    solid_box(kinds + 5, 0.05, 0.008, 0.008);
    scene_open(s, 24, 24, 200, 12, 9.8);
    e_r = uniform(s, 0, 0.005);
    friction(s, uniform(s, 0.2, 0.8), e_r);
    ground(s, 0, 0, 1, NULL);
    if (scene_kind == 2) {
        solid_box(kinds, 0.1, 0.05, 0.05);
        for (i = 0; i < 16; i++) {
            x[0] = 0.2 * (i % 4) + 0.1 * (i / 4 % 2);
            x[1] = 0;
            x[2] = 0.05 + 0.1 * (i / 4);
            put(t, kinds, 2, x, NULL, NULL, NULL);
        }
        solid_round(kinds + 1, ECP_SPHERE, 0.1, 0, 0);
        x[0] = uniform(s, 0.1, 0.6);
        x[1] = -1;
        x[2] = uniform(s, 0.15, 0.35);
        v[1] = uniform(s, 3, 8);
        put(t, kinds + 1, 5, x, NULL, v, NULL);
    } else {
        for (i = 0; scene_kind == 1 && i < 3; i++)
            ground(s, funnel[i][0], funnel[i][1], funnel[i][2], NULL);
        /* apart, three a layer; or so close above each other that they may begin in each other */
        t->overlapping = t->number / 6 % 2;
        for (i = 0; i < 15; i++) {
            double beside = t->overlapping ? 0.03 : 0.005;
            for (j = 0; j < 2; j++) {
                x[j] = uniform(s, -beside, beside);
                if (!t->overlapping) x[j] += 0.07 * around[i % 3][j];
            }
            x[2] = t->overlapping ? 0.06 + 0.05 * i : 0.13 + 0.11 * (i / 3);
            random_stand(s, q);
            mass = log_uniform(s, 0.01, 0.2);
            put(t, kinds + pick(s, 6), mass, x, q, NULL, NULL);
        }
    }
    t->h = t->number / 3 % 2 ? 1.0 / 60 : 1.0 / 30;
    t->steps = t->number / 3 % 2 ? 60 : 30;
}

/* ---- extremes of scale */

static void build_scale(trial *t)
{
    static const double gs[4] = {0, 1.6, 9.8, 1e3};
    scene *s = &t->s;
    double size = log_uniform(s, 1e-6, 1e4), g = gs[t->number % 4], natural, lift, q[4], v[3], w[3];
    solid b;
    random_solid(s, t->number % SOLIDS, size, &b);
    open_plane(t, &b, g);
    random_friction(s, pick(s, 2) * 0.1 * size);
    ground(s, 0, 0, 1, NULL);
    natural = sqrt(size / (g > 0 ? g : 1));
    t->h = pick(s, 2) ? 0.02 * natural : 1e-2;
    random_stand(s, q);
    random_vector(s, size / natural, v);
    random_vector(s, log_uniform(s, 0.01, 1) / natural, w);
    v[2] = -fabs(v[2]);
    lift = size * uniform(s, 0, 0.1);
    put_above(t, &b, log_uniform(s, 1e-12, 1e9), lift, q, v, w);
    t->steps = 100;
}

/* a plane in any direction, far from the origin */
static void build_far(trial *t)
{
    scene *s = &t->s;
    double n[3], at[3], x[3], v[3], q[4], p[3], below[3], reach;
    solid b;
    int k;
    random_solid(s, t->number % SOLIDS, 1, &b);
    open_plane(t, &b, 9.8);
    random_friction(s, 0.1);
    random_vector(s, 0.3, n);
    n[2] += 1;
    normalise(n, 3);
    random_vector(s, 1, at);
    normalise(at, 3);
    for (k = 0; k < 3; k++) at[k] = (double)(ecp_real)(1e6 * at[k]);
    ground(s, n[0], n[1], n[2], at);
    random_turn(s, q);
    for (k = 0; k < 3; k++) below[k] = -n[k];
    reach = solid_reach(&b, q, below, p);
    for (k = 0; k < 3; k++) x[k] = at[k] + (reach + 0.01) * n[k];
    random_vector(s, 2, v);
    put(t, &b, log_uniform(s, 0.1, 10), x, q, v, NULL);
    t->h = t->number / SOLIDS % 2 ? 1e-3 : 1e-2;
    t->steps = 100;
}

/* ---- degenerate scenes */

/* no friction but in torsion's place, none at all, or torsion far larger than the body */
static void build_torsion(trial *t)
{
    scene *s = &t->s;
    double q[4], v[3], w[3] = {0, 0, 0};
    solid b;
    random_solid(s, t->number % SOLIDS, 1, &b);
    open_plane(t, &b, 9.8);
    switch (t->number / SOLIDS % 3) {
    case 0: friction(s, 0, 1); break;
    case 1: friction(s, 0.5, 0); break;
    default: friction(s, 0.5, 1e3);
    }
    ground(s, 0, 0, 1, NULL);
    random_stand(s, q);
    random_vector(s, 2, v);
    v[2] = 0;
    w[2] = log_uniform(s, 0.1, 100);
    put_above(t, &b, 1, 0, q, v, w);
    t->h = pick(s, 2) ? 1e-2 : 1e-3;
    t->steps = 200;
}

/* moments of inertia as 1 : 1 : 1e-6 */
static void build_needle(trial *t)
{
    scene *s = &t->s;
    double q[4], v[3], w[3];
    solid b;
    if (t->number % 3 == 0) solid_round(&b, ECP_CAPSULE, 1e-3, 0, 1);
    if (t->number % 3 == 1) solid_round(&b, ECP_CYLINDER, 1e-3, 0, 1);
    if (t->number % 3 == 2) solid_box(&b, 1e-3, 1e-3, 1);
    b.inertia[0] = b.inertia[4] = 0.33;
    b.inertia[8] = 0.33e-6;
    open_plane(t, &b, 9.8);
    random_friction(s, pick(s, 2) * 1e-3);
    ground(s, 0, 0, 1, NULL);
    random_stand(s, q);
    random_vector(s, 1, v);
    random_vector(s, log_uniform(s, 0.1, 10), w);
    put_above(t, &b, 1, pick(s, 2) * 0.01, q, v, w);
    t->h = pick(s, 2) ? 1e-2 : 1e-3;
    t->steps = 200;
}

/* thickness 1e-4 of the width, alone or as a stack of three */
static void build_plate(trial *t)
{
    scene *s = &t->s;
    double q[4], v[3], x[3] = {0, 0, 0};
    int n = t->number % 2 ? 3 : 1, i;
    solid b;
    solid_box(&b, 1, 1, 1e-4);
    scene_open(s, n + 1, n + 1, 2 * n, 12, 9.8);
    random_friction(s, 0);
    ground(s, 0, 0, 1, NULL);
    random_stand(s, q);
    random_vector(s, 2, v);
    for (i = 0; i < n; i++) {
        x[2] = 2e-4 * i + 1e-4;
        if (n > 1) put(t, &b, 1, x, NULL, i == n - 1 ? v : NULL, NULL);
        if (n == 1) put_above(t, &b, 1, pick(s, 2) * 0.01, q, v, NULL);
    }
    t->h = pick(s, 2) ? 1e-2 : 1e-3;
    t->steps = 200;
}

/* a board on 4, 16 or 64 feet, at rest, sliding or dropped */
static void build_patches(trial *t)
{
    static const int across[3] = {2, 4, 8};
    scene *s = &t->s;
    double q[4] = {1, 0, 0, 0}, v[3] = {0, 0, 0}, w[3] = {0, 0, 0};
    int n = across[t->number % 3], kind = t->number / 3 % 3;
    solid b;
    table(&b, 1, 0.4 / n, n);
    open_plane(t, &b, 9.8);
    random_friction(s, pick(s, 2) * 0.1);
    ground(s, 0, 0, 1, NULL);
    if (kind == 1) random_vector(s, 1, v);
    if (kind == 1) w[2] = uniform(s, -3, 3);
    if (kind == 2) random_stand(s, q);
    v[2] = 0;
    put_above(t, &b, 10, kind == 2 ? 0.02 : 0, q, v, w);
    t->h = t->number / 9 % 2 ? 1e-3 : 1e-2;
    t->steps = 100;
}

/* a pyramid or a cone on its tip: upright to rounding, nearly so, or spinning */
static void build_apex(trial *t)
{
    double rows[5][4] = {{1, 0, -0.6, 0.2},
                         {-1, 0, -0.6, 0.2},
                         {0, 1, -0.6, 0.2},
                         {0, -1, -0.6, 0.2},
                         {0, 0, 1, 0.3}};
    static const double tilts[4] = {0, 1e-12, 1e-6, 1e-2};
    double q[4], w[3] = {0, 0, 0};
    solid b;
    if (t->number % 2)
        solid_round(&b, ECP_FRUSTUM, 0, 0.3, 0.3);
    else
        solid_hull(&t->s, &b, rows, 5);
    open_plane(t, &b, 9.8);
    random_friction(&t->s, pick(&t->s, 2) * 0.01);
    ground(&t->s, 0, 0, 1, NULL);
    turn_about(0.6, 0.8, 0, tilts[t->number / 2 % 4], q);
    if (pick(&t->s, 2)) w[2] = log_uniform(&t->s, 0.1, 100);
    put_above(t, &b, 1, 0, q, NULL, w);
    t->h = t->number / 8 % 2 ? 1e-3 : 1e-2;
    t->steps = 200;
}

/* a ball, and then other primitives, thrown into the corner of three planes */
static void corner(trial *t, double e_r)
{
    scene *s = &t->s;
    double q[4], v[3], w[3], x[3], turn[4], n[3], p[3];
    int kind = t->number % 2 ? pick(s, PRIMITIVES) : 0, i, k;
    solid b;
    random_solid(s, kind, 0.5, &b);
    scene_open(s, 4, 4, 3, b.shape->inequalities, 9.8);
    random_friction(s, e_r);
    turn_about(0.6, 0.8, 0, t->number % 4 < 2 ? 0 : uniform(s, 0, 0.8), turn);
    random_turn(s, q);
    random_vector(s, 5, v);
    random_vector(s, 5, w);
    x[0] = x[1] = x[2] = 0;
    for (i = 0; i < 3; i++) {
        double axis[3] = {0, 0, 0}, back[3], reach;
        axis[i] = 1;
        turned(turn, axis, n);
        ground(s, n[0], n[1], n[2], NULL);
        for (k = 0; k < 3; k++) back[k] = -n[k];
        reach = solid_reach(&b, q, back, p) + pick(s, 2) * 0.05;
        for (k = 0; k < 3; k++) x[k] += reach * n[k];
    }
    put(t, &b, log_uniform(s, 0.1, 10), x, q, v, w);
    t->h = pick(s, 2) ? 1e-2 : 1e-3;
    t->steps = 200;
}

static void build_corner(trial *t) { corner(t, 0); }

/* the same with friction against turns */
static void build_grip(trial *t) { corner(t, 0.005); }

/* a disc with six staves that lean outwards */
static void cup(solid *b)
{
    const double out[3] = {0.036, 0, 0.043};
    ecp_shape shape;
    ecp_real half[3];
    int i;
    memset(b, 0, sizeof *b);
    must(ecp_shape_cylinder(&shape, (ecp_real)0.03, (ecp_real)0.003));
    solid_add(b, &shape, 0, 0, 0.003, NULL);
    half[0] = (ecp_real)0.002;
    half[1] = (ecp_real)0.018;
    half[2] = (ecp_real)0.04;
    must(ecp_shape_box(&shape, half));
    for (i = 0; i < 6; i++) {
        double about[4], lean[4], at[3];
        turn_about(0, 0, 1, scene_pi / 3 * i, about);
        turn_about(0, 1, 0, 0.15, lean);
        turned(about, out, at);
        turn_after(about, lean, about);
        solid_add(b, &shape, at[0], at[1], at[2], about);
    }
    solid_close(b);
}

/* two to four cups, each let go in the one below, nearly upright */
static void build_cups(trial *t)
{
    scene *s = &t->s;
    double q[4], tilt[4], x[3] = {0, 0, 0}, p[3];
    int n = 2 + t->number % 3, i;
    solid b;
    cup(&b);
    scene_open(s, n + 1, 7 * n + 1, 60 * n, 12, 9.8);
    random_friction(s, t->number / 6 % 2 * 0.003);
    ground(s, 0, 0, 1, NULL);
    for (i = 0; i < n; i++) {
        turn_about(0, 0, 1, uniform(s, -0.01, 0.01), q);
        if (i == 0) x[2] = solid_reach(&b, q, down, p);
        if (i > 0) {
            turn_about(1, 0, 0, uniform(s, -0.005, 0.005), tilt);
            turn_after(tilt, q, q);
            x[0] = uniform(s, -3e-4, 3e-4);
            x[1] = uniform(s, -3e-4, 3e-4);
            x[2] += 0.033;
        }
        put(t, &b, 0.05, x, q, NULL, NULL);
    }
    t->h = t->number / 3 % 2 ? 1e-3 : 1e-2;
    t->steps = 200;
}

/* a wall of 2 to 5 layers of 3 to 8 bricks, in bond, that a ball hits: most of a step's travel is deeper
   than a brick is thick */
static void build_wall(trial *t)
{
    scene *s = &t->s;
    int layers = 2 + t->number % 4, across = 3 + t->number / 4 % 6, i;
    double x[3], v[3] = {0, 0, 0}, e_r;
    solid brick, ball;
    solid_box(&brick, 0.1, 0.05, 0.05);
    solid_round(&ball, ECP_SPHERE, 0.1, 0, 0);
    scene_open(s, layers * across + 2, layers * across + 2, 10 * layers * across, 12, 9.8);
    e_r = uniform(s, 0, 0.005);
    friction(s, uniform(s, 0.2, 0.8), e_r);
    ground(s, 0, 0, 1, NULL);
    for (i = 0; i < layers * across; i++) {
        x[0] = 0.2 * (i % across) + 0.1 * (i / across % 2);
        x[1] = 0;
        x[2] = 0.05 + 0.1 * (i / across);
        put(t, &brick, 2, x, NULL, NULL, NULL);
    }
    x[0] = uniform(s, 0, 0.2 * (across - 1));
    x[1] = -0.3;
    x[2] = uniform(s, 0.15, 0.1 * layers);
    v[1] = uniform(s, 5, 15);
    put(t, &ball, 5, x, NULL, v, NULL);
    t->h = 1.0 / 60;
    t->steps = 30;
}

/* a block of 1 to 18 flush cubes, turned about the vertical or not, that stands, falls or slides */
static void build_grid(trial *t)
{
    static const double hs[4] = {0.01, 0.005, 0.002, 1.0 / 60};
    scene *s = &t->s;
    int nx = 1 + pick(s, 3), ny = 1 + pick(s, 2), nz = 1 + pick(s, 3), i;
    double yaw = t->number % 2 ? uniform(s, 0, 6.28) : 0, fall = uniform(s, -0.15, 0.4);
    double x[3], v[3] = {0, 0, 0}, q[4];
    solid cube;
    solid_box(&cube, 0.5, 0.5, 0.5);
    scene_open(s, nx * ny * nz + 1, nx * ny * nz + 1, 14 * nx * ny * nz, 12, 9.8);
    friction(s, t->number % 3 ? 0.5 : 0.2, 0);
    ground(s, 0, 0, 1, NULL);
    turn_about(0, 0, 1, yaw, q);
    v[0] = uniform(s, -6, 3);
    if (v[0] < 0) v[0] = 0;
    for (i = 0; i < nx * ny * nz; i++) {
        x[0] = cos(yaw) * (i % nx) - sin(yaw) * (i / nx % ny);
        x[1] = sin(yaw) * (i % nx) + cos(yaw) * (i / nx % ny);
        x[2] = 0.5 + i / (nx * ny) + (fall > 0 ? fall : 0);
        put(t, &cube, 1, x, q, v, NULL);
    }
    t->h = hs[t->number / 6 % 4];
    t->steps = 50;
}

/* x and v in a frame that is turned by yaw about the vertical */
static void put_turned(trial *t, const solid *b, double mass, const double at[3],
                       const double along[3], double yaw)
{
    double x[3], v[3], q[4];
    x[0] = cos(yaw) * at[0] - sin(yaw) * at[1];
    x[1] = sin(yaw) * at[0] + cos(yaw) * at[1];
    x[2] = at[2];
    v[0] = cos(yaw) * along[0] - sin(yaw) * along[1];
    v[1] = sin(yaw) * along[0] + cos(yaw) * along[1];
    v[2] = along[2];
    turn_about(0, 0, 1, yaw, q);
    put(t, b, mass, x, q, v, NULL);
}

/* flush cubes with friction that are jolted: a block that slides, a wall that a ball hits, rows that a cube hits, and a
   block that begins with overlaps of a millimetre to a centimetre */
static void build_jolt(trial *t)
{
    static const double hs[4] = {0.01, 0.005, 0.002, 1.0 / 60};
    scene *s = &t->s;
    int kind = t->number % 4, nx, ny, nz, i;
    double yaw = t->number / 4 % 2 ? uniform(s, 0, 6.28) : 0, space = 1;
    double x[3], v[3] = {0, 0, 0};
    solid cube, ball;
    solid_box(&cube, 0.5, 0.5, 0.5);
    solid_round(&ball, ECP_SPHERE, 0.5, 0, 0);
    nx = kind == 0 || kind == 3 ? 2 + pick(s, 2) : 3 + pick(s, kind == 1 ? 3 : 5);
    ny = kind == 1 ? 1 : 1 + pick(s, 2);
    nz = kind == 2 ? 1 : 2 + pick(s, kind == 1 ? 3 : 2);
    if (kind == 0) v[0] = uniform(s, 1, 4);
    if (kind == 3) space = pick(s, 2) ? 0.99 : 0.999;
    t->overlapping = kind == 3;
    scene_open(s, nx * ny * nz + 2, nx * ny * nz + 2, 14 * nx * ny * nz, 12, 9.8);
    friction(s, t->number % 3 ? 0.5 : 0.2, 0);
    ground(s, 0, 0, 1, NULL);
    for (i = 0; i < nx * ny * nz; i++) {
        x[0] = space * (i % nx);
        x[1] = space * (i / nx % ny);
        x[2] = 0.5 + space * (i / (nx * ny));
        if (kind == 3) x[0] += uniform(s, -1e-3, 1e-3);
        if (kind == 3) x[1] += uniform(s, -1e-3, 1e-3);
        put_turned(t, &cube, 1, x, v, yaw);
    }
    if (kind == 1) {
        x[0] = uniform(s, 0, nx - 1);
        x[1] = -1.2;
        x[2] = uniform(s, 0.5, nz - 0.5);
        v[1] = uniform(s, 3, 15);
        put_turned(t, &ball, 5, x, v, yaw);
    } else if (kind == 2) {
        x[0] = -1.2;
        x[1] = uniform(s, -0.3, 0.3);
        x[2] = 0.5;
        v[0] = 6;
        put_turned(t, &cube, 5, x, v, yaw);
    }
    t->h = hs[t->number / 8 % 4];
    t->steps = 40;
}

/* a wedge driven between two planes: its half angle theirs, or off by a little; mu locks it */
static void build_jam(trial *t)
{
    static const double off[4] = {0, 1e-9, 1e-4, -1e-2};
    scene *s = &t->s;
    double angle = uniform(s, 0.05, 0.6), own = angle + off[t->number % 4], v[3] = {0, 0, 0};
    double rows[6][4] = {{0, 0, 1, 0.3}, {0, 0, -1, 0.2}, {0, 1, 0, 0.2}, {0, -1, 0, 0.2}};
    double x[3] = {0, 0, 0}, q[4], n[3], p[3], reach;
    solid b;
    rows[4][0] = cos(own);
    rows[5][0] = -cos(own);
    rows[4][2] = rows[5][2] = -sin(own);
    rows[4][3] = rows[5][3] = 0.2;
    solid_hull(s, &b, rows, 6);
    scene_open(s, 3, 3, 2, 6, 9.8);
    random_friction(s, 0);
    ground(s, cos(angle), 0, sin(angle), NULL);
    ground(s, -cos(angle), 0, sin(angle), NULL);
    turn_about(0, 0, 1, 0, q);
    if (pick(s, 2)) turn_about(0, 1, 0, uniform(s, -0.02, 0.02), q);
    n[0] = -cos(angle);
    n[1] = 0;
    n[2] = -sin(angle);
    reach = solid_reach(&b, q, n, p);
    n[0] = -n[0];
    if (solid_reach(&b, q, n, p) > reach) reach = solid_reach(&b, q, n, p);
    v[2] = -log_uniform(s, 0.01, 10);
    x[2] = reach / sin(angle) - v[2] * t->h * 2;
    put(t, &b, 1, x, q, v, NULL);
    t->h = pick(s, 2) ? 1e-2 : 1e-3;
    t->steps = 100;
}

/* a rod that slides on its tip, leaning as in Painleve's paradox */
static void build_rod(trial *t)
{
    scene *s = &t->s;
    double q[4], v[3] = {0, 0, 0}, w[3] = {0, 0, 0}, angle = uniform(s, 0.2, 1.3);
    solid b;
    if (t->number % 2)
        solid_round(&b, ECP_CAPSULE, 0.01, 0, 1);
    else
        solid_box(&b, 0.02, 0.02, 1);
    open_plane(t, &b, 9.8);
    friction(s, uniform(s, 1, 3), 0);
    ground(s, 0, 0, 1, NULL);
    turn_about(0, 1, 0, angle, q);
    v[0] = (pick(s, 2) ? 1 : -1) * log_uniform(s, 0.1, 20);
    w[1] = pick(s, 2) * uniform(s, -2, 2);
    put_above(t, &b, 1, 0, q, v, w);
    t->h = pick(s, 2) ? 1e-2 : 1e-3;
    t->steps = 150;
}

/* ---- long times */

/* how far the last body is from where it began */
static double way(trial *t)
{
    int last = ecp_world_body_count(t->s.world) - 1, k;
    double d2 = 0;
    ecp_real x[3];
    must(ecp_body_get_state(t->s.world, last, x, NULL, NULL, NULL));
    for (k = 0; k < 3; k++) {
        double d = (double)(x[k] - t->body[last].position[k]);
        d2 += d * d;
    }
    return sqrt(d2);
}

static double stay_truth(trial *t, int step)
{
    (void)step;
    return way(t);
}

static void standing_table(trial *t)
{
    const double q[4] = {1, 0, 0, 0};
    solid b;
    table(&b, 0.5, 0.05, 2);
    open_plane(t, &b, 9.8);
    friction(&t->s, 0.5, 0.05);
    ground(&t->s, 0, 0, 1, NULL);
    put_above(t, &b, 10, 0, q, NULL, NULL);
    t->h = 1e-2;
    t->endless = 1;
}

static void build_rest(trial *t)
{
    standing_table(t);
    t->steps = t->full ? 1000000 : 50000;
    t->truth = stay_truth;
    t->bar = 1e-12;
}

/* The pushes, of the 49 N that friction bears. 0: to and fro, too weak. 1: too weak, round about.
   2: strong enough, 40 steps there, 40 steps of rest, 40 steps back. */
static void push(trial *t, int step)
{
    ecp_real f[3] = {0, 0, 0};
    double phase = step % 160 * 2 * scene_pi / 160;
    if (t->number == 0) f[0] = (ecp_real)(30 * sin(phase));
    if (t->number == 1) {
        f[0] = (ecp_real)(30 * sin(phase));
        f[1] = (ecp_real)(30 * cos(phase));
    }
    if (t->number == 2 && step % 80 < 40) f[0] = step % 160 < 80 ? 60 : -60;
    must(ecp_body_apply_force(t->s.world, 1, f, NULL));
}

static double push_truth(trial *t, int step)
{
    return t->number == 2 && step % 160 != 159 ? 0 : way(t);
}

static void build_push(trial *t)
{
    standing_table(t);
    t->loaded = 1;
    t->steps = t->full ? 100000 : 8000;
    t->drive = push;
    t->truth = push_truth;
    t->bar = 1e-9;
}

/* a box, a cylinder or a table on an incline of 20 degrees, 10 s */
static void build_creep(trial *t)
{
    static const double hs[4] = {1e-1, 1e-2, 1e-3, 1e-4};
    double angle = 20 * scene_pi / 180, q[4], n[3], x[3], p[3], reach;
    solid b;
    int k;
    switch (t->number % 3) {
    case 0: solid_box(&b, 0.2, 0.15, 0.1); break;
    case 1: solid_round(&b, ECP_CYLINDER, 0.2, 0, 0.1); break;
    default: table(&b, 0.5, 0.05, 2);
    }
    open_plane(t, &b, 9.8);
    ground(&t->s, sin(angle), 0, cos(angle), NULL);
    turn_about(0, 1, 0, angle, q);
    n[0] = -sin(angle);
    n[1] = 0;
    n[2] = -cos(angle);
    reach = solid_reach(&b, q, n, p);
    for (k = 0; k < 3; k++) x[k] = -reach * n[k];
    put(t, &b, 1, x, q, NULL, NULL);
    t->h = hs[t->number / 3];
    t->steps = (int)(10 / t->h + 0.5);
    t->truth = stay_truth;
    t->bar = 1e-12;
}

/* the fastest of all velocities at the end, in units g h */
static double rest_truth(trial *t, int step)
{
    double most = 0;
    int i, k;
    for (i = 1; step == t->steps - 1 && i < ecp_world_body_count(t->s.world); i++) {
        ecp_real v[3], w[3];
        must(ecp_body_get_state(t->s.world, i, NULL, NULL, v, w));
        for (k = 0; k < 3; k++) {
            most = fmax(most, fabs((double)v[k]) / (9.8 * t->h));
            most = fmax(most, fabs((double)w[k]) * t->size[i] / (9.8 * t->h));
        }
    }
    return most;
}

/* 2 to 27 flush crates, in rows, walls and blocks, that are dropped together and come to rest */
static void build_crates(trial *t)
{
    static const double hs[4] = {0.01, 0.005, 0.01, 1.0 / 60};
    scene *s = &t->s;
    int nx = 2 + pick(s, 3), ny = 1 + pick(s, 3), nz = 1 + pick(s, 4), i;
    double size = pick(s, 2) ? 1 : uniform(s, 0.1, 1), fall = size * uniform(s, 0.01, 0.5);
    double x[3];
    solid cube;
    while (nx * ny * nz > 27) nz--;
    solid_box(&cube, size / 2, size / 2, size / 2);
    scene_open(s, nx * ny * nz + 1, nx * ny * nz + 1, 14 * nx * ny * nz, 12, 9.8);
    friction(s, t->number % 3 ? 0.5 : 0.2, 0);
    ground(s, 0, 0, 1, NULL);
    for (i = 0; i < nx * ny * nz; i++) {
        x[0] = size * (i % nx);
        x[1] = size * (i / nx % ny);
        x[2] = size * (0.5 + i / (nx * ny)) + fall;
        put(t, &cube, 1, x, NULL, NULL, NULL);
    }
    t->h = hs[t->number % 4];
    t->steps = 200;
    t->truth = rest_truth;
    t->bar = 1e-8;
}

static const family families[] = {
    {"drop", build_drop, 120, 1800, 0},   {"throw", build_throw, 120, 1800, 0},
    {"pair", build_pair, 576, 1728, 0},   {"stack", build_stack, 30, 60, 0},
    {"plank", build_plank, 10, 100, 0},   {"cards", build_cards, 4, 20, 0},
    {"arch", build_arch, 7, 28, 0},       {"dominoes", build_dominoes, 2, 40, 0},
    {"heap", build_heap, 7, 24, 2},       {"scale", build_scale, 120, 1800, 0},
    {"far", build_far, 48, 240, 0},       {"torsion", build_torsion, 36, 216, 0},
    {"needle", build_needle, 30, 150, 0}, {"plate", build_plate, 20, 200, 0},
    {"patches", build_patches, 9, 54, 0}, {"apex", build_apex, 16, 96, 0},
    {"corner", build_corner, 20, 200, 0}, {"grip", build_grip, 20, 200, 0},
    {"jam", build_jam, 20, 200, 0},       {"rod", build_rod, 30, 300, 0},
    {"rest", build_rest, 1, 1, 0},        {"push", build_push, 3, 3, 0},
    {"creep", build_creep, 9, 12, 0},     {"grid", build_grid, 6, 60, 2},
    {"cups", build_cups, 4, 40, 1},       {"wall", build_wall, 4, 24, 1},
    {"jolt", build_jolt, 8, 64, 1},       {"crates", build_crates, 8, 60, 1},
};

/* ---- measuring */

/* kinetic energy, its sum with the potential one, and m g size (or what rounding may stir up) */
static void energies(trial *t, double *kinetic, double *total, double *lift)
{
    int i, k, r;
    *kinetic = *total = *lift = 0;
    for (i = 0; i < ecp_world_body_count(t->s.world); i++) {
        const ecp_body_desc *d = t->body + i;
        double m = (double)d->mass, q[4], w[3], local[3], g = 0;
        double noise = (in_double ? 1e-12 : 1e-4) * t->size[i] / t->h;
        ecp_real x[3], turn[4], v[3], spin[3];
        if (d->kind != ECP_DYNAMIC) continue;
        must(ecp_body_get_state(t->s.world, i, x, turn, v, spin));
        for (k = 0; k < 4; k++) q[k] = (k ? -1 : 1) * (double)turn[k];
        for (k = 0; k < 3; k++) w[k] = (double)spin[k];
        turned(q, w, local);
        for (k = 0; k < 3; k++) {
            *kinetic += m * (double)v[k] * (double)v[k] / 2;
            for (r = 0; r < 3; r++) {
                *kinetic += local[k] * (double)d->inertia[3 * k + r] * local[r] / 2;
            }
            *total -= m * t->s.g[k] * (double)(x[k] - d->position[k]);
            g += t->s.g[k] * t->s.g[k];
        }
        *lift += m * (sqrt(g) * t->size[i] + noise * noise);
    }
    *total += *kinetic;
}

/* the gain of a step in relation to the most that the case has held */
static double energy_gain(trial *t, int first)
{
    double kinetic, total, lift, before = t->energy;
    energies(t, &kinetic, &total, &lift);
    t->energy = total;
    if (kinetic + lift > t->energy_scale) t->energy_scale = kinetic + lift;
    return first || total <= before ? 0 : (total - before) / t->energy_scale;
}

static void complain(const family *f, const trial *t, int step, tally *sum, const char *what)
{
    if (sum->complaints++ < 5) {
        fprintf(stderr, "%s case %d step %d: %s\n", f->name, t->number, step, what);
    }
}

static void count_report(const ecp_report *r, tally *sum)
{
    int i;
    for (i = 0; i < FALLBACKS; i++) sum->by[i] += r->fallbacks >> i & 1;
    sum->fallback_steps += r->fallbacks != 0;
    sum->iterations += r->iterations;
    if (r->iterations > sum->most_iterations) sum->most_iterations = r->iterations;
}

static void unsolved(const family *f, const trial *t, int step, const ecp_report *r, tally *sum)
{
    char text[200];
    sum->unsolved++;
    snprintf(text, sizeof text, "%s: shapes %d and %d, %.3e but must be %.3e",
             r->status == ECP_NOT_SOLVED ? "not solved" : ecp_status_string(r->status), r->shape_a,
             r->shape_b, (double)r->value, (double)r->limit);
    complain(f, t, step, sum, text);
}

static void remember(trial *t)
{
    int i, k;
    for (i = 0; i < ecp_world_body_count(t->s.world); i++) {
        ecp_real x[3];
        must(ecp_body_get_state(t->s.world, i, x, NULL, NULL, NULL));
        for (k = 0; k < 3; k++) t->before[i][k] = (double)x[k];
    }
}

/* how far bodies have gone elsewhere than h v, in relation to what they are held to, their sizes and their ways */
static double strayed(const trial *t)
{
    double worst = 0;
    int i, k;
    for (i = 0; i < ecp_world_body_count(t->s.world); i++) {
        ecp_real x[3], v[3];
        double off = 0, way = 0, far = 0;
        if (t->body[i].kind != ECP_DYNAMIC) continue;
        must(ecp_body_get_state(t->s.world, i, x, NULL, v, NULL));
        for (k = 0; k < 3; k++) {
            off = fmax(off, fabs((double)x[k] - t->before[i][k] - t->h * (double)v[k]));
            way = fmax(way, fabs(t->h * (double)v[k]));
            far = fmax(far, fabs((double)x[k]));
        }
        /* a position is rounded */
        off -= 4 * (double)ECP_I_EPSILON * far;
        worst = fmax(worst, off / (t->size[i] + way));
    }
    return worst;
}

/* the worst contact: 1 if it pulls, or how far it leaves its cone, in relation to the largest impulse or momentum */
static double unlawful(const trial *t)
{
    double worst = 0, most = 0;
    int i;
    for (i = 0; i < ecp_world_body_count(t->s.world); i++) {
        const ecp_body_desc *d = t->body + i;
        ecp_real v[3];
        if (d->kind != ECP_DYNAMIC) continue;
        must(ecp_body_get_state(t->s.world, i, NULL, NULL, v, NULL));
        most = fmax(most,
                    (double)d->mass * fmax(fabs((double)v[0]), hypot((double)v[1], (double)v[2])));
        /* (a rounding unit of its size in a step is a billionth of this) */
        most = fmax(most, (double)d->mass * 1e-6 * t->size[i] / t->h);
        most = fmax(most, (double)d->mass * t->h * hypot(t->s.g[0], hypot(t->s.g[1], t->s.g[2])));
    }
    for (i = 0; i < ecp_contact_count(t->s.world); i++) {
        ecp_contact c;
        double size;
        must(ecp_contact_get(t->s.world, i, &c));
        if (c.p_n < 0) return 1;
        most = fmax(most, (double)c.p_n);
        size = hypot((double)(c.p_t / c.e_t), (double)(c.p_o / c.e_o));
        if (c.e_r > 0) size = hypot(size, (double)(c.p_r / c.e_r));
        worst = fmax(worst, size - (double)(c.mu * c.p_n));
    }
    return most > 0 ? worst / most : worst;
}

/* what is true after a solved step: nothing penetrates, no energy is won, bodies go where their velocities
   say, contacts push within their cones, the family's own */
static void measure(const family *f, trial *t, int step, const ecp_report *r, distance_set *set,
                    tally *sum)
{
    char text[200];
    distance_worst worst = distance_least(set, t->s.world, in_double ? 1e-11 : 1e-6);
    double gain = t->loaded ? 0 : energy_gain(t, t->overlapping && step == 0);
    if ((double)r->natural_residual > sum->residual) sum->residual = (double)r->natural_residual;
    if (-worst.relative > sum->depth) sum->depth = -worst.relative;
    if (-worst.gap > sum->metres) sum->metres = -worst.gap;
    if (gain > sum->gain) sum->gain = gain;
    if (in_double && !(worst.relative >= -1e-9)) {
        sum->missed++;
        snprintf(text, sizeof text, "shapes %d and %d overlap by %.3e of their size", worst.a,
                 worst.b, -worst.relative);
        complain(f, t, step, sum, text);
    }
    if (in_double && scene_advance_order == 0 && r->substeps == 1 && !(strayed(t) <= 1e-9)) {
        sum->missed++;
        snprintf(text, sizeof text, "x - x0 - h v is %.3e of a body's size", strayed(t));
        complain(f, t, step, sum, text);
    }
    if (in_double && scene_advance_order == 0 && !(unlawful(t) <= 1e-9)) {
        sum->missed++;
        snprintf(text, sizeof text, "a contact pulls or leaves its cone by %.3e", unlawful(t));
        complain(f, t, step, sum, text);
    }
}

/* the sizes of the bodies, as distance.h finds them, and the energy to begin with */
static void prepare(trial *t, const distance_set *set)
{
    double kinetic, lift;
    int i;
    for (i = 0; i < set->count; i++) t->size[set->solid[i].body] = set->solid[i].size;
    energies(t, &kinetic, &t->energy, &lift);
    t->energy_scale = kinetic + lift;
}

/* the family's own truth, and no growth of fallbacks */
static void judge(const family *f, const trial *t, double own, long early, long late, tally *sum)
{
    char text[200];
    if (own > sum->own) sum->own = own;
    if (in_double && own > t->bar) {
        sum->missed++;
        snprintf(text, sizeof text, "its own error is %.3e, above %.0e", own, t->bar);
        complain(f, t, t->steps, sum, text);
    }
    if (t->endless && late > early) {
        sum->missed += in_double;
        snprintf(text, sizeof text, "fallbacks in the halves: %ld, then %ld", early, late);
        complain(f, t, t->steps, sum, text);
    }
}

static void progress(const family *f, int number, int cases, int step)
{
    static int terminal = -1;
    if (terminal < 0) terminal = isatty(2);
    if (terminal) fprintf(stderr, "\r%s %d of %d: %d \r", f->name, number + 1, cases, step);
}

static void trace(const trial *t, int step, const ecp_report *r)
{
    if (!t->trace) return;
    fprintf(stderr,
            "%6d status %d newton %d fallbacks %d residual %.1e patches %d turn %.1e depth %.1e "
            "energy %.12g\n",
            step, r->status, r->iterations, r->fallbacks, (double)r->natural_residual,
            r->patches_kept, (double)r->largest_turn, -(double)r->worst_gap, t->energy);
}

/* what rounding of positions leaves, in lengths of the bodies: ecp_advance refuses less */
static ecp_real advance_floor(const ecp_world *w)
{
    ecp_real worst = 0;
    int i;
    for (i = 0; i < w->bodies; i++) {
        const ecp_i_body *b = ecp_i_bodies(w) + i;
        ecp_real far = b->kind == ECP_DYNAMIC ? ecp_i_norm(b->x) / b->length : 0;
        worst = ecp_i_max(worst, 65 * ECP_I_EPSILON * (1 + far));
    }
    return worst;
}

/* a step, or with `stress advance` the same time within a tolerance */
static void go_on(trial *t, ecp_report *r)
{
    ecp_advance_options o = ecp_advance_options_default();
    ecp_advance_report a;
    ecp_options step = ecp_options_default();
    const char *fallbacks = getenv("STRESS_FALLBACKS"), *bound = getenv("STRESS_BOUND");
    if (fallbacks) step.fallbacks = atoi(fallbacks);
    if (bound) step.max_total_iterations = atoi(bound);
    if (scene_advance_order == 0) {
        ecp_step(t->s.world, (ecp_real)t->h, &step, r);
        return;
    }
    o.tolerance = ecp_i_max((ecp_real)(in_double ? 1e-4 : 2e-3), advance_floor(t->s.world));
    o.max_solves = 20000;
    ecp_advance(t->s.world, (ecp_real)t->h, &o, &a);
    *r = a.step;
    r->status = a.status;
}

static void run_case(const family *f, int number, int full, int traced, tally *sum)
{
    trial *t = (trial *)calloc(1, sizeof *t);
    const char *seed = getenv("STRESS_SEED");
    long by_half[2] = {0, 0};
    double own = 0;
    distance_set set;
    int step;
    if (!t) exit(2);
    t->number = number;
    t->full = full;
    t->trace = traced;
    t->s.seed = scene_seed(f->name, number + 10000 * (seed ? atoi(seed) : 0));
    f->build(t);
    if (scene_advance_order > 0 && t->steps > 60) t->steps = 60;
    set = distance_open(t->s.world);
    prepare(t, &set);
    sum->cases++;
    for (step = 0; step < t->steps; step++) {
        ecp_report r;
        if (step % 4096 == 0) progress(f, number, full ? f->full : f->quick, step);
        if (t->drive) t->drive(t, step);
        remember(t);
        go_on(t, &r);
        sum->steps++;
        count_report(&r, sum);
        by_half[2 * step >= t->steps] += r.fallbacks != 0;
        if (r.status != ECP_OK) {
            unsolved(f, t, step, &r, sum);
            trace(t, step, &r);
            break;
        }
        measure(f, t, step, &r, &set, sum);
        trace(t, step, &r);
        if (t->truth) own = fmax(own, t->truth(t, step));
    }
    judge(f, t, own, by_half[0], by_half[1], sum);
    distance_close(&set);
    scene_close(&t->s);
    free(t);
}

static void add_tally(const tally *row, tally *sum)
{
    int i;
    sum->steps += row->steps;
    sum->unsolved += row->unsolved;
    sum->missed += row->missed;
    sum->fallback_steps += row->fallback_steps;
    for (i = 0; i < FALLBACKS; i++) sum->by[i] += row->by[i];
    sum->metres = fmax(sum->metres, row->metres);
    sum->residual = fmax(sum->residual, row->residual);
    sum->gain = fmax(sum->gain, row->gain);
}

static void print_row(const family *f, const tally *r)
{
    printf(
        "%-9s %5ld %8ld %8ld %6ld %7ld %6ld %6ld %6ld %6ld %6ld %8.1e %8.1e %8.1e %8.1e %7.2f %5d "
        "%6ld\n",
        f->name, r->cases, r->steps, r->unsolved, r->by[6], r->by[0], r->by[1], r->by[2], r->by[3],
        r->by[5], r->by[4], r->depth, r->residual, r->gain, r->own,
        r->steps ? (double)r->iterations / (double)r->steps : 0.0, r->most_iterations, r->missed);
    fflush(stdout);
}

int main(int argc, char **argv)
{
    int count = (int)(sizeof families / sizeof families[0]), run = 0, full, advance, i, k;
    const char *filter = argc > 2 ? argv[2] : "";
    tally sum;
    memset(&sum, 0, sizeof sum);
    full = argc > 1 && strcmp(argv[1], "full") == 0;
    advance = argc > 1 && strcmp(argv[1], "advance") == 0;
    if (advance) scene_advance_order = 6;
    if (argc > 4 || (argc > 1 && !full && !advance && strcmp(argv[1], "quick") != 0)) {
        fprintf(stderr, "usage: stress [quick|full|advance] [family] [case]\n");
        return 2;
    }
    printf("%-9s %5s %8s %8s %6s %7s %6s %6s %6s %6s %6s %8s %8s %8s %8s %7s %5s %6s\n",
           in_double ? "double" : "float", "cases", "steps", "unsolved", "set", "geom", "cont",
           "multi", "load", "chord", "sub", "depth", "residual", "gain", "own", "newton", "most",
           "missed");
    for (i = 0; i < count; i++) {
        const family *f = families + i;
        const int alone = f->apart == 1 || (f->apart == 2 && advance);
        tally row;
        if (alone ? strcmp(f->name, filter) != 0 : !strstr(f->name, filter)) continue;
        memset(&row, 0, sizeof row);
        for (k = 0; k < (full ? f->full : f->quick) && !(advance && k == 6); k++) {
            if (argc < 4 || atoi(argv[3]) == k) run_case(f, k, full, argc == 4, &row);
        }
        print_row(f, &row);
        add_tally(&row, &sum);
        run++;
    }
    printf("stress: families=%d steps=%ld unsolved=%ld fallback_steps=%ld max_penetration_m=%.3e "
           "max_scaled_residual=%.3e max_energy_gain=%.3e\n",
           run, sum.steps, sum.unsolved, sum.fallback_steps, sum.metres, sum.residual, sum.gain);
    /* 1: too many steps were not solved; 2: one that counts as solved misses a bar */
    if (in_double) return (sum.unsolved > 0) | (sum.missed > 0) << 1;
    return sum.unsolved * 1000000 > sum.steps;
}
