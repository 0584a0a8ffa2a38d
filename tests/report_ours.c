/* This library as an engine of the report. Compiled twice: in double and with -DECPSIM_FLOAT. */

#define ECPSIM_IMPLEMENTATION
#include "../ecpsim.h"

#include "report.h"

#include <stdio.h>
#include <stdlib.h>

#ifdef ECPSIM_FLOAT
#define ENGINE report_ours_float
#else
#define ENGINE report_ours_double
#endif

extern const report_engine ENGINE;

typedef struct ours {
    ecp_world *world;
    const report_world *scene;
    double h;
    ecp_options options;
    ecp_report report;
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

static void *ours_open(const report_world *scene, int method, double h)
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
    w->h = h;
    w->options = ecp_options_default();
    w->options.tolerance = (ecp_real)with[method].tolerance;
    w->options.rule = with[method].rule;
    return w;
}

static int ours_step(void *world, double t)
{
    ours *w = (ours *)world;
    if (w->scene->load) {
        report_load load;
        ecp_real force[3], torque[3], impulse[3];
        w->scene->load(t, w->h, &load);
        to_real(load.force, 3, force);
        to_real(load.torque, 3, torque);
        to_real(load.angular_impulse, 3, impulse);
        must(ecp_body_apply_force(w->world, 1, force, NULL));
        must(ecp_body_apply_torque(w->world, 1, torque));
        must(ecp_body_apply_angular_impulse(w->world, 1, impulse));
    }
    return ecp_step(w->world, (ecp_real)w->h, &w->options, &w->report) != ECP_OK;
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

const report_engine ENGINE = {
#ifdef ECPSIM_FLOAT
    "ecpsim.h in float",
#else
    "ecpsim.h in double",
#endif
    "this commit",
    "the bodies' own shapes over a half-space; ecp_step()",
    1,
    (int)(sizeof methods / sizeof methods[0]),
    methods,
    ours_open,
    ours_step,
    ours_state,
    ours_unknowns,
    ours_close};
