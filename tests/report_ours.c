/* This library as an engine of the report. Compiled twice: in double and with -DECPSIM_FLOAT. */

#define ECPSIM_IMPLEMENTATION
#include "../ecpsim.h"

#include "report.h"

#include <stdio.h>
#include <stdlib.h>

#ifdef ECPSIM_FLOAT
#define ENGINE report_ours_float
#define ENGINE_ADVANCE report_advance_float
#else
#define ENGINE report_ours_double
#define ENGINE_ADVANCE report_advance_double
#define ENGINE_PACED report_paced_double
extern const report_engine ENGINE_PACED;
#endif

extern const report_engine ENGINE, ENGINE_ADVANCE;

typedef struct ours {
    ecp_world *world;
    const report_world *scene;
    double h;
    ecp_options options;
    ecp_report report;
    ecp_advance_options advance;
} ours;

typedef struct ours_method {
    double tolerance;
    ecp_rule rule;
} ours_method;

#ifdef ECPSIM_FLOAT
static const ours_method with[] = {{1e-5, ECP_CENTRED}, {1e-4, ECP_CENTRED}, {1e-5, ECP_NEAREST}};
static const report_method methods[] = {
    {"ours float 1e-5", "tolerance 1e-5 (the default), rule centred", 0, 0},
    {"ours float 1e-4", "tolerance 1e-4, rule centred", 0, 0},
    {"ours float 1e-5 nearest", "tolerance 1e-5, rule nearest", 0, 1},
};
static const report_method advance_methods[] = {
    {"ours float advance", "float, within the tolerance, order 8 at most", 0, 0},
};
#else
static const ours_method with[] = {{1e-12, ECP_CENTRED}, {1e-10, ECP_CENTRED}, {1e-8, ECP_CENTRED},
                                   {1e-6, ECP_CENTRED},  {1e-4, ECP_CENTRED},  {1e-12, ECP_NEAREST},
                                   {1e-6, ECP_NEAREST}};
static const report_method methods[] = {
    {"ours 1e-12", "double, tolerance 1e-12 (the default), rule centred", 0, 0},
    {"ours 1e-10", "double, tolerance 1e-10, rule centred", 0, 0},
    {"ours 1e-8", "double, tolerance 1e-8, rule centred", 0, 0},
    {"ours 1e-6", "double, tolerance 1e-6, rule centred", 0, 0},
    {"ours 1e-4", "double, tolerance 1e-4, rule centred", 0, 0},
    {"ours 1e-12 nearest", "double, tolerance 1e-12, rule nearest", 0, 1},
    {"ours 1e-6 nearest", "double, tolerance 1e-6, rule nearest", 0, 1},
};
static const report_method advance_methods[] = {
    {"ours advance", "double, within the tolerance, order 8 at most", 0, 0},
};
static const int orders[] = {2, 4, 6};
static const report_method paced_methods[] = {
    {"ours order 2", "double, macro steps of the size h, order 2 (3 base steps each)", 1, 0},
    {"ours order 4", "double, macro steps of the size h, order 4 (10 base steps)", 1, 0},
    {"ours order 6", "double, macro steps of the size h, order 6 (21 base steps)", 1, 0},
};
#endif

static void must(ecp_status status)
{
    if (status == ECP_OK) return;
    fprintf(stderr, "report: %s\n", ecp_status_string(status));
    exit(2);
}

static void to_real(const double *from, int n, ecp_real *to)
{
    int k;
    for (k = 0; k < n; k++) to[k] = (ecp_real)from[k];
}

static void add_body(ecp_world *world, const report_body *b, const ecp_material *material)
{
    ecp_body_desc d = ecp_body_desc_default();
    int i, k, index;
    d.mass = (ecp_real)b->mass;
    for (k = 0; k < 3; k++) d.inertia[4 * k] = (ecp_real)b->inertia[k];
    to_real(b->start.x, 3, d.position);
    to_real(b->start.q, 4, d.rotation);
    to_real(b->start.v, 3, d.velocity);
    to_real(b->start.w, 3, d.angular_velocity);
    d.kind = ECP_DYNAMIC;
    must(ecp_body_add(world, &d, &index));
    for (i = 0; i < b->parts; i++) {
        const report_part *p = b->part + i;
        ecp_shape shape;
        ecp_real at[3], size[3];
        if (!(p->who & REPORT_OURS)) continue;
        to_real(p->at, 3, at);
        to_real(p->size, 3, size);
        if (p->kind == REPORT_BOX) must(ecp_shape_box(&shape, size));
        if (p->kind == REPORT_CYLINDER) must(ecp_shape_cylinder(&shape, size[0], size[1]));
        if (p->kind == REPORT_SPHERE) must(ecp_shape_sphere(&shape, size[0]));
        must(ecp_body_add_shape(world, index, &shape, at, NULL, material, NULL));
    }
}

/* advance_order: 0 for a world of plain steps */
static ours *open_world(const report_world *scene, int advance_order)
{
    const ecp_real up[3] = {0, 0, 1};
    ecp_world_desc d = ecp_world_desc_default();
    ecp_body_desc ground = ecp_body_desc_default();
    ecp_material material = ecp_material_default();
    ours *w = (ours *)calloc(1, sizeof *w);
    ecp_shape plane;
    size_t bytes;
    void *mem;
    int i;
    if (!w) exit(2);
    d.max_bodies = scene->bodies + 1;
    d.max_shapes = 1;
    for (i = 0; i < scene->bodies; i++) d.max_shapes += scene->body[i].parts;
    d.max_patches = 2 * d.max_shapes;
    d.advance_order = advance_order;
    to_real(scene->g, 3, d.gravity);
    bytes = ecp_world_memsize(&d);
    mem = malloc(bytes);
    must(ecp_world_init(&w->world, &d, mem, bytes));
    material.mu = (ecp_real)scene->mu;
    material.e_t = material.e_o = 1;
    material.e_r = (ecp_real)scene->e_r;
    ground.kind = ECP_STATIC;
    must(ecp_shape_half_space(&plane, up, 0));
    must(ecp_body_add(w->world, &ground, NULL));
    must(ecp_body_add_shape(w->world, 0, &plane, NULL, NULL, &material, NULL));
    for (i = 0; i < scene->bodies; i++) add_body(w->world, scene->body + i, &material);
    w->scene = scene;
    w->options = ecp_options_default();
    w->advance = ecp_advance_options_default();
    return w;
}

static void *ours_open(const report_world *scene, int method, double h)
{
    ours *w = open_world(scene, 0);
    w->h = h;
    w->options.tolerance = (ecp_real)with[method].tolerance;
    w->options.rule = with[method].rule;
    return w;
}

static void *advance_open(const report_world *scene, int method, double tolerance)
{
    ours *w = open_world(scene, 8);
    (void)method;
    w->advance.tolerance = (ecp_real)tolerance;
    return w;
}

#ifdef ENGINE_PACED
static void *paced_open(const report_world *scene, int method, double h)
{
    ours *w = open_world(scene, orders[method]);
    w->advance.macro_step = (ecp_real)h;
    return w;
}
#endif

/* from t to t + h, or at t */
static void apply_load(ours *w, double t, double h)
{
    report_load load;
    ecp_real force[3], torque[3], impulse[3];
    w->scene->load(t, h, &load);
    to_real(load.force, 3, force);
    to_real(load.torque, 3, torque);
    to_real(load.angular_impulse, 3, impulse);
    must(ecp_body_apply_force(w->world, 1, force, NULL));
    must(ecp_body_apply_torque(w->world, 1, torque));
    must(ecp_body_apply_angular_impulse(w->world, 1, impulse));
}

static int ours_step(void *world, double t)
{
    ours *w = (ours *)world;
    if (w->scene->load) apply_load(w, t, w->h);
    return ecp_step(w->world, (ecp_real)w->h, &w->options, &w->report) != ECP_OK;
}

/* the load of a base step that ends at this time */
static void load_at(void *user, ecp_world *world, ecp_real time)
{
    (void)world;
    apply_load((ours *)user, (double)time, 0);
}

static int ours_advance(void *world, double t, double duration, report_cost *cost)
{
    ours *w = (ours *)world;
    ecp_advance_report r;
    ecp_status status;
    if (w->scene->load && w->scene->kick > 0) apply_load(w, t, duration);
    w->advance.load = w->scene->load && !(w->scene->kick > 0) ? load_at : NULL;
    w->advance.load_user = w;
    w->advance.time = (ecp_real)t;
    status = ecp_advance(w->world, (ecp_real)duration, &w->advance, &r);
    cost->solves += r.solves;
    cost->first_order += r.first_order;
    cost->forced += r.forced;
    cost->refused |= status == ECP_TOLERANCE;
    return status != ECP_OK;
}

static void ours_state(void *world, int body, report_state *out)
{
    ours *w = (ours *)world;
    ecp_real x[3], q[4], v[3], turn[3];
    int k;
    must(ecp_body_get_state(w->world, body + 1, x, q, v, turn));
    for (k = 0; k < 3; k++) {
        out->x[k] = (double)x[k];
        out->v[k] = (double)v[k];
        out->w[k] = (double)turn[k];
    }
    for (k = 0; k < 4; k++) out->q[k] = (double)q[k];
}

static int ours_unknowns(void *world) { return ((ours *)world)->report.unknowns; }

static void ours_close(void *world)
{
    free(((ours *)world)->world);
    free(world);
}

#ifdef ECPSIM_FLOAT
#define REAL "float"
#else
#define REAL "double"
#endif

const report_engine ENGINE = {"ecpsim.h in " REAL,
                              "this commit",
                              "the bodies' own shapes over a half-space; ecp_step()",
                              1,
                              (int)(sizeof methods / sizeof methods[0]),
                              methods,
                              ours_open,
                              ours_step,
                              ours_state,
                              ours_unknowns,
                              ours_close,
                              REPORT_STEPS,
                              NULL};

const report_engine ENGINE_ADVANCE = {
    "ecpsim.h in " REAL ", to a tolerance",
    "this commit",
    "the same worlds by ecp_advance(), which chooses step and order; one call from the start to "
    "the "
    "end, or to the next kick or the next time at which the scene's error is taken; tolerances "
    "that it refuses, as rounding leaves more, are left out",
    1,
    (int)(sizeof advance_methods / sizeof advance_methods[0]),
    advance_methods,
    advance_open,
    NULL,
    ours_state,
    NULL,
    ours_close,
    REPORT_TOLERANCES,
    ours_advance};

#ifdef ENGINE_PACED
const report_engine ENGINE_PACED = {
    "ecpsim.h in " REAL ", of fixed order",
    "this commit",
    "the same worlds by ecp_advance() with its options macro_step and order: smooth motion at that "
    "order, what changes within a macro step at first order",
    1,
    (int)(sizeof paced_methods / sizeof paced_methods[0]),
    paced_methods,
    paced_open,
    NULL,
    ours_state,
    NULL,
    ours_close,
    REPORT_MACRO_STEPS,
    ours_advance};
#endif
