/* Siconos numerics (fc3d, nonsmooth Gauss-Seidel) as an engine of the report. Siconos solves the
   contact problem of a step; the step around it, which its kernel would do, is written here: points
   that touch a plane or the body below, the theta method, one problem with all of them. */

#include "../report.h"

#include <math.h>
#include <siconos/numerics/FrictionContactProblem.h>
#include <siconos/numerics/Friction_cst.h>
#include <siconos/numerics/NonSmoothDrivers.h>
#include <siconos/numerics/NumericsMatrix.h>
#include <siconos/numerics/SolverOptions.h>
#include <siconos/numerics/fc3d_Solvers.h>
#include <siconos/numerics/NumericsVerbose.h>
#include <stdlib.h>
#include <string.h>

typedef struct siconos_method {
    double theta, tolerance;
} siconos_method;

static const siconos_method with[] = {{1, 1e-12}, {1, 1e-6}, {0.5, 1e-12}, {0.5, 1e-6}};

static const report_method methods[] = {
    {"Siconos 1e-12", "theta = 1 with the gap at the end of the step, as ours; tolerance 1e-12", 0,
     0},
    {"Siconos 1e-6", "theta = 1 with the gap at the end of the step, as ours; tolerance 1e-6", 0,
     0},
    {"Siconos 1/2 1e-12", "theta = 1/2 with the law on velocities (Moreau-Jean); tolerance 1e-12",
     0, 0},
    {"Siconos 1/2 1e-6", "theta = 1/2 with the law on velocities (Moreau-Jean); tolerance 1e-6", 0,
     0},
};

/* a point that may touch: `side` 0 is the body it belongs to, 1 what is below (none: the plane) */
typedef struct touching {
    int body[2], id;
    double arm[2][3], axis[3][3]; /* normal and two tangents, world */
    double gap;
} touching;

typedef struct siconos {
    const report_world *scene;
    double h, theta;
    report_state state[REPORT_BODIES];
    double turner[REPORT_BODIES][9]; /* inverse inertia in world axes */
    int count, last;                 /* contacts now, and those of the matrix */
    touching *contact;
    double *reaction, *velocity, *q, *mu, *all; /* all: reactions of every point, by id */
    NumericsMatrix *M;
    FrictionContactProblem problem;
    SolverOptions *options;
} siconos;

static void cross(const double *a, const double *b, double *out)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void matrix(const double *q, double *R)
{
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double m[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                         2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                         2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    memcpy(R, m, sizeof m);
}

static void times(const double *R, const double *v, double *out)
{
    int i;
    for (i = 0; i < 3; i++) out[i] = dot(R + 3 * i, v);
}

static void *siconos_open(const report_world *scene, int method, double h)
{
    siconos *w = (siconos *)calloc(1, sizeof *w);
    size_t points = 0;
    int i;
    for (i = 0; i < scene->bodies; i++) {
        w->state[i] = scene->body[i].start;
        points += (size_t)scene->body[i].points;
    }
    w->scene = scene;
    w->h = h;
    w->theta = with[method].theta;
    w->contact = (touching *)calloc(points, sizeof *w->contact);
    w->reaction = (double *)calloc(3 * points, sizeof(double));
    w->velocity = (double *)calloc(3 * points, sizeof(double));
    w->q = (double *)calloc(3 * points, sizeof(double));
    w->all = (double *)calloc(3 * points, sizeof(double));
    w->mu = (double *)calloc(points, sizeof(double));
    for (i = 0; i < (int)points; i++) w->mu[i] = scene->mu;
    w->options = solver_options_create(SICONOS_FRICTION_3D_NSGS);
    w->options->dparam[SICONOS_DPARAM_TOL] = with[method].tolerance;
    w->options->iparam[SICONOS_IPARAM_MAX_ITER] = 20000;
    solver_options_update_internal(w->options, 0, SICONOS_FRICTION_3D_ONECONTACT_NSN);
    w->options->iparam[SICONOS_FRICTION_3D_IPARAM_ERROR_EVALUATION] =
        SICONOS_FRICTION_3D_NSGS_ERROR_EVALUATION_LIGHT;
    numerics_set_verbose(0);
    return w;
}

/* Where a point of the body `i` is, and its contact if it is near enough to matter. */
static int find(siconos *w, int i, int k, const double *R, const double *below, touching *c)
{
    const report_body *body = w->scene->body + i;
    const report_state *s = w->state + i, *b = i > 0 ? s - 1 : s;
    double x[3], approach;
    int j;
    memset(c, 0, sizeof *c);
    c->body[0] = i;
    c->body[1] = w->scene->stacked && i > 0 ? i - 1 : -1;
    times(R, body->point[k].at, c->arm[0]);
    c->axis[0][2] = c->axis[1][0] = c->axis[2][1] = 1;
    if (c->body[1] >= 0) {
        for (j = 0; j < 9; j++) c->axis[j / 3][j % 3] = below[3 * (j % 3) + (j / 3 + 2) % 3];
    }
    for (j = 0; j < 3; j++) {
        c->arm[0][j] -= body->point[k].radius * c->axis[0][j];
        x[j] = s->x[j] + c->arm[0][j];
    }
    c->gap = x[2];
    if (c->body[1] >= 0) {
        for (j = 0; j < 3; j++) c->arm[1][j] = x[j] - b->x[j];
        c->gap = dot(c->axis[0], c->arm[1]) - w->scene->body[i - 1].part[0].size[2];
    }
    cross(s->w, c->arm[0], x);
    approach = dot(c->axis[0], s->v) + dot(c->axis[0], x);
    if (c->body[1] >= 0) {
        cross(b->w, c->arm[1], x);
        approach -= dot(c->axis[0], b->v) + dot(c->axis[0], x);
    }
    /* theta = 1: the problem decides of all that may be reached */
    if (w->theta >= 1) return c->gap < 0.01 + 2 * w->h * (approach < 0 ? -approach : 0);
    return c->gap + w->h / 2 * approach <= 1e-6; /* kept closed where rounding would open it */
}

static void find_all(siconos *w)
{
    double R[9], below[9];
    int i, k, id = 0;
    w->count = 0;
    for (i = 0; i < w->scene->bodies; i++) {
        matrix(w->state[i].q, R);
        for (k = 0; k < w->scene->body[i].points; k++, id++) {
            if (!find(w, i, k, R, below, w->contact + w->count)) continue;
            w->contact[w->count++].id = id;
        }
        memcpy(below, R, sizeof R);
    }
}

/* velocities without contacts, and the inverse inertias in world axes */
static void fly(siconos *w, double t)
{
    int i, j, k;
    for (i = 0; i < w->scene->bodies; i++) {
        const report_body *b = w->scene->body + i;
        report_state *s = w->state + i;
        double R[9], local[3], moment[3] = {0, 0, 0}, gyro[3], spin[3], *turner = w->turner[i];
        matrix(s->q, R);
        for (j = 0; j < 9; j++) {
            turner[j] = 0;
            for (k = 0; k < 3; k++) {
                turner[j] += R[3 * (j / 3) + k] * R[3 * (j % 3) + k] / b->inertia[k];
            }
        }
        for (j = 0; j < 3; j++) {
            local[j] = 0;
            for (k = 0; k < 3; k++) local[j] += R[3 * k + j] * s->w[k];
            local[j] *= b->inertia[j];
        }
        times(R, local, spin);
        cross(spin, s->w, gyro);
        for (j = 0; j < 3; j++) moment[j] = w->h * gyro[j];
        if (i == 0 && w->scene->load) {
            report_load l, before;
            /* loads are given at the end of the step that is asked for */
            w->scene->load(t, w->h, &l);
            w->scene->load(t - w->h, w->h, &before);
            for (j = 0; j < 3; j++) {
                s->v[j] +=
                    w->h * (w->theta * l.force[j] + (1 - w->theta) * before.force[j]) / b->mass;
                moment[j] += w->h * (w->theta * l.torque[j] + (1 - w->theta) * before.torque[j]) +
                             l.angular_impulse[j];
            }
        }
        times(turner, moment, gyro);
        for (j = 0; j < 3; j++) {
            s->v[j] += w->h * w->scene->g[j];
            s->w[j] += gyro[j];
        }
    }
}

/* the change of the relative velocity of contact b, along its axis l, by an impulse at a along k */
static double delassus(const siconos *w, const touching *a, int k, const touching *b, int l)
{
    double sum = 0, twist[3], turned[3], at[3];
    int i, j;
    for (i = 0; i < 2; i++) {
        for (j = 0; j < 2; j++) {
            double sign = i == j ? 1 : -1;
            if (a->body[i] < 0 || a->body[i] != b->body[j]) continue;
            cross(a->arm[i], a->axis[k], twist);
            times(w->turner[a->body[i]], twist, turned);
            cross(b->arm[j], b->axis[l], at);
            sum += sign * (dot(a->axis[k], b->axis[l]) / w->scene->body[a->body[i]].mass +
                           dot(turned, at));
        }
    }
    return sum;
}

static int solve(siconos *w)
{
    int n = 3 * w->count, i, j, k, info = 0;
    if (w->count != w->last) {
        if (w->M) NM_clear(w->M);
        free(w->M);
        w->M = n ? NM_create(NM_DENSE, n, n) : NULL;
        w->last = w->count;
    }
    if (n == 0) return 0;
    for (i = 0; i < n; i++) {
        const touching *c = w->contact + i / 3;
        double u = 0, v[3];
        for (k = 0; k < 2; k++) {
            const report_state *s = w->state + c->body[k];
            if (c->body[k] < 0) continue;
            cross(s->w, c->arm[k], v);
            u += (k ? -1 : 1) * (dot(c->axis[i % 3], s->v) + dot(c->axis[i % 3], v));
        }
        w->q[i] = u;
        if (i % 3 == 0 && w->theta >= 1) w->q[i] += c->gap / w->h;
        for (j = 0; j <= i; j++) {
            double m = delassus(w, c, i % 3, w->contact + j / 3, j % 3);
            w->M->matrix0[i * n + j] = w->M->matrix0[j * n + i] = m;
        }
        w->reaction[i] = w->all[3 * c->id + i % 3];
        w->velocity[i] = 0;
    }
    w->problem.dimension = 3;
    w->problem.numberOfContacts = w->count;
    w->problem.M = w->M;
    w->problem.q = w->q;
    w->problem.mu = w->mu;
    info = fc3d_driver(&w->problem, w->reaction, w->velocity, w->options);
    for (i = 0; i < n; i++) w->all[3 * w->contact[i / 3].id + i % 3] = w->reaction[i];
    return info;
}

static void push(siconos *w)
{
    int i, j, k;
    for (i = 0; i < 3 * w->count; i++) {
        const touching *c = w->contact + i / 3;
        for (k = 0; k < 2; k++) {
            report_state *s = w->state + c->body[k];
            double p = (k ? -1 : 1) * w->reaction[i], twist[3], turn[3];
            if (c->body[k] < 0) continue;
            cross(c->arm[k], c->axis[i % 3], twist);
            times(w->turner[c->body[k]], twist, turn);
            for (j = 0; j < 3; j++) {
                s->v[j] += p * c->axis[i % 3][j] / w->scene->body[c->body[k]].mass;
                s->w[j] += p * turn[j];
            }
        }
    }
}

/* the pose after h at a mean of the old and the new velocity, the rotation by Cayley's map */
static void move(report_state *s, const report_state *old, double h, double theta)
{
    double u[3], q[4], size = 0;
    int k;
    for (k = 0; k < 3; k++) {
        s->x[k] += h * (theta * s->v[k] + (1 - theta) * old->v[k]);
        u[k] = h / 2 * (theta * s->w[k] + (1 - theta) * old->w[k]);
    }
    q[0] = s->q[0] - u[0] * s->q[1] - u[1] * s->q[2] - u[2] * s->q[3];
    cross(u, s->q + 1, q + 1);
    for (k = 0; k < 3; k++) q[k + 1] += s->q[k + 1] + s->q[0] * u[k];
    for (k = 0; k < 4; k++) size += q[k] * q[k];
    for (k = 0; k < 4; k++) s->q[k] = q[k] / sqrt(size);
}

static int siconos_step(void *world, double t)
{
    siconos *w = (siconos *)world;
    report_state old[REPORT_BODIES];
    int i, info;
    memcpy(old, w->state, sizeof old);
    find_all(w);
    fly(w, t);
    info = solve(w);
    push(w);
    for (i = 0; i < w->scene->bodies; i++) move(w->state + i, old + i, w->h, w->theta);
    return info != 0;
}

static void siconos_state(void *world, int body, report_state *out)
{
    *out = ((siconos *)world)->state[body];
}

static int siconos_unknowns(void *world) { return 3 * ((siconos *)world)->count; }

static void siconos_close(void *world)
{
    siconos *w = (siconos *)world;
    if (w->M) NM_clear(w->M);
    free(w->M);
    solver_options_delete(w->options);
    free(w->options);
    free(w->contact);
    free(w->reaction);
    free(w->velocity);
    free(w->q);
    free(w->all);
    free(w->mu);
    free(w);
}

const report_engine report_peer = {
    "Siconos",
    VERSION,
    "fc3d NSGS, local solver ONECONTACT_NSN, light evaluation of the error, at most 20000 "
    "iterations, "
    "warm start; dense Delassus matrix; points instead of "
    "collision detection: the middle of each foot, its outermost point where the body tilts, or "
    "the corners",
    0,
    (int)(sizeof methods / sizeof methods[0]),
    methods,
    siconos_open,
    siconos_step,
    siconos_state,
    siconos_unknowns,
    siconos_close,
    REPORT_STEPS,
    NULL};
