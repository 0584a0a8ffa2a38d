/* What the examples share: the three-legged table of the paper, and a world whose every step is
   checked by code that does not use the solver. */

#ifndef TABLE_H
#define TABLE_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TABLE_MASS 5.0           /* kg */
#define TABLE_HEIGHT 0.3         /* of the centre of mass above the plane, m */
#define TABLE_LEG_RADIUS 0.1     /* m */
#define TABLE_LEG_LENGTH 0.4178  /* m */
#define TABLE_LEG_AXIS 0.3       /* from the centre to the axis of each leg, m */
#define TABLE_TOP_RADIUS 0.4     /* m */
#define TABLE_TOP_THICKNESS 0.05 /* m */
#define TABLE_MU 0.12            /* friction of the legs and of the ground; e = (1, 1, 1) */

/* A world, and what is known about its last step and its worst step. */
typedef struct scene {
    ecp_world *world;
    ecp_world *before;       /* the state before the last step */
    ecp_report report;       /* of the last step */
    double separation;       /* of the two bodies that came nearest: below zero is penetration, m */
    double printed;          /* scaled residual of the equations printed in the paper */
    double worst_separation; /* the least so far */
    double worst_printed;    /* the largest so far */
} scene;

/* Ends the program when a call of the library fails: an example has no better answer. */
static inline void must(ecp_status status)
{
    if (status == ECP_OK) return;
    fprintf(stderr, "ecpsim: %s\n", ecp_status_string(status));
    exit(1);
}

static inline ecp_material table_material(void)
{
    ecp_material m = ecp_material_default();
    m.mu = (ecp_real)TABLE_MU;
    m.e_t = m.e_o = m.e_r = 1;
    return m;
}

/* Body 0 and shape 0 of every scene are the ground, the half-space z <= 0. */
static inline void scene_open(scene *s)
{
    const ecp_real up[3] = {0, 0, 1};
    ecp_world_desc desc = ecp_world_desc_default();
    ecp_body_desc ground = ecp_body_desc_default();
    ecp_material material = table_material();
    size_t bytes = ecp_world_memsize(&desc);
    void *mem = malloc(bytes);
    ecp_shape plane;
    memset(s, 0, sizeof *s);
    must(ecp_world_init(&s->world, &desc, mem, bytes));
    s->before = (ecp_world *)malloc(ecp_world_state_size(s->world));
    if (!s->before) must(ECP_BAD_POINTER);
    s->worst_separation = 1e300;
    ground.kind = ECP_STATIC;
    must(ecp_shape_half_space(&plane, up, 0));
    must(ecp_body_add(s->world, &ground, NULL));
    must(ecp_body_add_shape(s->world, 0, &plane, NULL, NULL, &material, NULL));
}

static inline void scene_close(scene *s)
{
    free(s->world);
    free(s->before);
}

/* The axis of leg i, seen from the centre: three legs stand at 210, 330 and 90 degrees (A1, A2, A3),
   two at 180 and 0. */
static inline void table_leg_axis(int legs, int i, double xy[2])
{
    const double three[3][2] = {{-0.75, -0.5}, {0.75, -0.5}, {0, 1}}; /* x still squared */
    double x = legs == 3 ? three[i][0] : i == 0 ? -1 : 1;
    xy[0] = TABLE_LEG_AXIS * (x < 0 ? -1 : 1) * sqrt(fabs(x));
    xy[1] = TABLE_LEG_AXIS * (legs == 3 ? three[i][1] : 0);
}

/* Adds a table that stands on the ground at the origin: its shapes are the legs, in order, and then
   the top. Returns the first leg's shape index; the body is the last one added. */
static inline int table_add(ecp_world *world, int legs, double inertia_scale,
                            const double velocity[3], const double angular_velocity[3])
{
    ecp_body_desc body = ecp_body_desc_default();
    ecp_material material = table_material();
    ecp_shape leg, top;
    ecp_real at[3] = {0, 0, (ecp_real)(TABLE_LEG_LENGTH + TABLE_TOP_THICKNESS / 2 - TABLE_HEIGHT)};
    int i, index, first = ecp_world_shape_count(world);
    /* a uniform solid of this mass with three legs */
    body.mass = (ecp_real)TABLE_MASS;
    body.inertia[0] = body.inertia[4] = (ecp_real)(inertia_scale * 0.3327);
    body.inertia[8] = (ecp_real)(inertia_scale * 0.4458);
    body.position[2] = (ecp_real)TABLE_HEIGHT;
    for (i = 0; i < 3; i++) {
        body.velocity[i] = (ecp_real)velocity[i];
        body.angular_velocity[i] = (ecp_real)angular_velocity[i];
    }
    must(ecp_body_add(world, &body, &index));
    must(ecp_shape_cylinder(&leg, (ecp_real)TABLE_LEG_RADIUS, (ecp_real)(TABLE_LEG_LENGTH / 2)));
    must(ecp_shape_cylinder(&top, (ecp_real)TABLE_TOP_RADIUS, (ecp_real)(TABLE_TOP_THICKNESS / 2)));
    for (i = 0; i < legs; i++) {
        double xy[2];
        ecp_real foot[3] = {0, 0, (ecp_real)(TABLE_LEG_LENGTH / 2 - TABLE_HEIGHT)};
        table_leg_axis(legs, i, xy);
        foot[0] = (ecp_real)xy[0];
        foot[1] = (ecp_real)xy[1];
        must(ecp_body_add_shape(world, index, &leg, foot, NULL, &material, NULL));
    }
    must(ecp_body_add_shape(world, index, &top, at, NULL, &material, NULL));
    return first;
}

/* Finds the contact of a shape with the ground. Pairs that cannot touch are left out of a step, so
   there may be none, and a contact's index says nothing about who touches. */
static inline int ground_contact(const ecp_world *world, int shape, ecp_contact *contact)
{
    int i;
    for (i = 0; i < ecp_contact_count(world); i++) {
        must(ecp_contact_get(world, i, contact));
        if (contact->shape_a == shape && contact->shape_b == 0) return 1;
    }
    return 0;
}

/* The point of a shape farthest along the world direction n, and how far along n it lies. */
static inline double farthest(const ecp_world *world, int shape, const double n[3], double x[3])
{
    const ecp_shape *s;
    ecp_real at[3], R[9], local_n[3], local_x[3];
    double along = 0;
    int i, k;
    must(ecp_shape_get(world, shape, &s, NULL, at, R));
    for (k = 0; k < 3; k++) {
        local_n[k] =
            (ecp_real)((double)R[k] * n[0] + (double)R[3 + k] * n[1] + (double)R[6 + k] * n[2]);
    }
    s->cls->support(s, local_n, 0, local_x);
    for (i = 0; i < 3; i++) {
        x[i] = (double)at[i];
        for (k = 0; k < 3; k++) x[i] += (double)R[3 * i + k] * (double)local_x[k];
        along += n[i] * x[i];
    }
    return along;
}

/* How far apart two shapes are along the unit vector n, from b to a. Whatever n is, the shapes are
   at least that far apart. */
static inline double separation_along(const ecp_world *world, int a, int b, const double n[3])
{
    const double back[3] = {-n[0], -n[1], -n[2]};
    double x[3];
    return -farthest(world, a, back, x) - farthest(world, b, n, x);
}

/* The best bound on the distance of two shapes (b may be the ground) that these directions give:
   up, the axes, the line of the centres, the normals of the contacts. */
static inline double separation(const ecp_world *world, int a, int b)
{
    static const double axes[6][3] = {{0, 0, 1},  {0, 0, -1}, {1, 0, 0},
                                      {-1, 0, 0}, {0, 1, 0},  {0, -1, 0}};
    ecp_real xa[3], xb[3];
    double n[3], length, best;
    ecp_contact c;
    int i, k;
    if (b == 0) {
        const double down[3] = {0, 0, -1};
        return 0 - farthest(world, a, down, n);
    }
    must(ecp_shape_get(world, a, NULL, NULL, xa, NULL));
    must(ecp_shape_get(world, b, NULL, NULL, xb, NULL));
    for (k = 0; k < 3; k++) n[k] = (double)xa[k] - (double)xb[k];
    length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (k = 0; k < 3; k++) n[k] /= length;
    best = separation_along(world, a, b, n);
    for (i = 0; i < 6; i++) best = fmax(best, separation_along(world, a, b, axes[i]));
    for (i = 0; i < ecp_contact_count(world); i++) {
        must(ecp_contact_get(world, i, &c));
        if (c.shape_a + c.shape_b != a + b || (c.shape_a != a && c.shape_a != b)) continue;
        for (k = 0; k < 3; k++) n[k] = (c.shape_a == a ? 1 : -1) * (double)c.normal[k];
        best = fmax(best, separation_along(world, a, b, n));
    }
    return best;
}

/* The least separation of all pairs of shapes that belong to different bodies. */
static inline double least_separation(const ecp_world *world)
{
    double least = 1e300;
    int a, b, body_a, body_b;
    for (a = 0; a < ecp_world_shape_count(world); a++) {
        must(ecp_shape_get(world, a, NULL, &body_a, NULL, NULL));
        for (b = 0; b < a; b++) {
            must(ecp_shape_get(world, b, NULL, &body_b, NULL, NULL));
            if (body_a != body_b) least = fmin(least, separation(world, a, b));
        }
    }
    return least;
}

/* One step, then its two checks. */
static inline void scene_step(scene *s, double h, const ecp_options *options)
{
    ecp_printed printed;
    memcpy(s->before, s->world, ecp_world_state_size(s->world));
    if (ecp_step(s->world, (ecp_real)h, options, &s->report) != ECP_OK) {
        fprintf(
            stderr,
            "step not taken: fallbacks %d, iterations %d, shapes %d and %d, %g but must be %g\n",
            s->report.fallbacks, s->report.iterations, s->report.shape_a, s->report.shape_b,
            (double)s->report.value, (double)s->report.limit);
        must(s->report.status);
    }
    must(ecp_printed_residual(s->before, s->world, (ecp_real)h, &printed));
    s->printed = (double)printed.largest;
    s->separation = least_separation(s->world);
    s->worst_printed = fmax(s->worst_printed, s->printed);
    s->worst_separation = fmin(s->worst_separation, s->separation);
}

/* Penetration over all steps so far, m. */
static inline double scene_penetration(const scene *s) { return fmax(0, -s->worst_separation); }

#endif /* TABLE_H */
