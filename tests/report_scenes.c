/* The scenes of the report and what is true of them (docs/model.md, docs/report.md). Everything here
   is double, and none of it is the library's. */

#include "report_scenes.h"
#include "truths.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double g = 9.8, pi = 3.14159265358979323846;

/* ---- building blocks */

static double square(double x) { return x * x; }

static report_body *body(report_world *w, double mass, double ix, double iy, double iz, double z)
{
    report_body *b = w->body + w->bodies++;
    memset(b, 0, sizeof *b);
    b->mass = mass;
    b->inertia[0] = ix;
    b->inertia[1] = iy;
    b->inertia[2] = iz;
    b->start.x[2] = z;
    b->start.q[0] = 1;
    return b;
}

static void part(report_body *b, int who, report_kind kind, double size_0, double size_1,
                 double size_2, double x, double y, double z)
{
    report_part *p = b->part + b->parts++;
    p->who = who;
    p->kind = kind;
    p->size[0] = size_0;
    p->size[1] = size_1;
    p->size[2] = size_2;
    p->at[0] = x;
    p->at[1] = y;
    p->at[2] = z;
}

static void point(report_body *b, double x, double y, double z, double radius)
{
    report_point *p = b->point + b->points++;
    p->at[0] = x;
    p->at[1] = y;
    p->at[2] = z;
    p->radius = radius;
}

/* the lower corners of a box */
static void corners(report_body *b, double x, double y, double z)
{
    point(b, x, y, z, 0);
    point(b, -x, y, z, 0);
    point(b, -x, -y, z, 0);
    point(b, x, -y, z, 0);
}

static void world(report_world *w, double mu, double e_r)
{
    w->g[2] = -g;
    w->mu = mu;
    w->e_r = e_r;
}

/* gravity as on a plane inclined by `angle`, downhill along the direction `turn` of the plane */
static void incline(report_world *w, double angle, double turn)
{
    w->g[0] = g * sin(angle) * cos(turn);
    w->g[1] = g * sin(angle) * sin(turn);
    w->g[2] = -g * cos(angle);
}

static report_body *solid_box(report_world *w, double mass, double x, double y, double z)
{
    report_body *b = body(w, mass, mass / 3 * (y * y + z * z), mass / 3 * (z * z + x * x),
                          mass / 3 * (x * x + y * y), z);
    part(b, REPORT_ALL, REPORT_BOX, x, y, z, 0, 0, 0);
    corners(b, x, y, -z);
    return b;
}

static double largest(double a, double b) { return a > b ? a : b; }

static double distance(const double *a, const double *b)
{
    return sqrt(square(a[0] - b[0]) + square(a[1] - b[1]) + square(a[2] - b[2]));
}

static void rotation(const double *q, double *R)
{
    double w = q[0], x = q[1], y = q[2], z = q[3];
    R[0] = 1 - 2 * (y * y + z * z);
    R[1] = 2 * (x * y - w * z);
    R[2] = 2 * (x * z + w * y);
    R[3] = 2 * (x * y + w * z);
    R[4] = 1 - 2 * (x * x + z * z);
    R[5] = 2 * (y * z - w * x);
    R[6] = 2 * (x * z - w * y);
    R[7] = 2 * (y * z + w * x);
    R[8] = 1 - 2 * (x * x + y * y);
}

/* ---- T1, T2: the paper's table. It stands on three legs; the peers do without its top */

static const double table_v1[3] = {4, 3, 0};

/* The peers stand on a ball under each leg, at `foot`, and do without the top. Three points carry the
   table as three discs do as long as it stands or tilts the way of Example 2. */
static report_body *table(report_world *w, const double foot[3][2], double ball)
{
    const double side = 0.3 * sqrt(0.75), axis[3][2] = {{-side, -0.15}, {side, -0.15}, {0, 0.3}};
    report_body *b = body(w, 5, 0.3327, 0.3327, 0.4458, 0.3);
    int i;
    for (i = 0; i < 3; i++) {
        const double *at = foot ? foot[i] : axis[i];
        part(b, REPORT_OURS, REPORT_CYLINDER, 0.1, 0.2089, 0, axis[i][0], axis[i][1], 0.2089 - 0.3);
        part(b, REPORT_PEERS, REPORT_SPHERE, ball, 0, 0, at[0], at[1], ball - 0.3);
        point(b, at[0], at[1], -0.3, 0);
    }
    part(b, REPORT_OURS, REPORT_CYLINDER, 0.4, 0.025, 0, 0, 0, 0.4178 + 0.025 - 0.3);
    world(w, 0.12, 1);
    return b;
}

static void t1_world(report_world *w)
{
    report_body *b = table(w, NULL, 0.1);
    memcpy(b->start.v, table_v1, sizeof table_v1);
}

static double t1_way(double t)
{
    double rest = 5 / (0.12 * g);
    if (t > rest) t = rest;
    return 5 * t - 0.12 * g * t * t / 2;
}

/* the way after k steps; each takes mu g h from the speed, the last one what is left */
static double t1_discrete_way(int k, double h)
{
    double loss = 0.12 * g * h, slides = floor(5 / loss), n = k < slides ? k : slides;
    return h * (n * 5 - loss * n * (n + 1) / 2);
}

static double t1_off(const report_state *s, double way)
{
    double x[3];
    x[0] = 0.8 * way;
    x[1] = 0.6 * way;
    x[2] = 0.3;
    return distance(s->x, x);
}

static void t1_watch(report_watch *w, int k, double t, const report_state *s)
{
    if (w->at_end) w->continuous = t1_off(s, t1_way(t));
    w->discrete = largest(w->discrete, t1_off(s, t1_discrete_way(k, w->h)));
}

static void t2_load(double t, double h, report_load *l)
{
    memset(l, 0, sizeof *l);
    if (t <= 0.75 + 1e-9 * h && t + h > 0.75 + 1e-6 * h) l->angular_impulse[0] = -5;
}

/* the points of the legs that stay, and come, down */
static void t2_world(report_world *w)
{
    const double side = 0.3 * sqrt(0.75), foot[3][2] = {{-side, -0.25}, {side, -0.25}, {0, 0.4}};
    table(w, foot, 1e-4)->start.v[1] = 1;
    w->load = t2_load;
    w->kick = 0.75;
}

/* against the motion in the plane (truths.h), after every 0.4 s and at the end */
static void t2_watch(report_watch *w, int k, double t, const report_state *s)
{
    static truth_t2_state known[7];
    static int have[7];
    double x[3] = {0, 0, 0};
    long double arm[2];
    int i = (int)(t / 0.4 + 0.5);
    (void)k;
    if (fabs(t - 0.4 * i) > 1e-6 || i >= 7) return;
    if (!have[i]) known[i] = truth_t2_at(0.4L * i);
    have[i] = 1;
    truth_t2_arm(known[i].y[2], arm);
    x[1] = (double)known[i].y[0];
    x[2] = (double)-arm[1];
    w->continuous = largest(w->continuous, distance(s->x, x));
}

/* ---- T3, T4: one patch that slides and spins (truths T3: one scalar equation a step) */

typedef struct puck {
    double m, I, H, mu, e_r, v[2], w;
} puck;

static const puck t3_puck = {3, 0.125, 0.25, 0.22, 0.1, {1, 0}, 5};
static const puck t4_puck = {15, 0.625, 0.45, 0.22, 0.1, {0.3, 0.2}, 0.5};

static double puck_equation(const puck *p, const double *V, double W, double p_n, double s)
{
    double al = p->mu * p_n / p->m, be = p->e_r * p->e_r * p->mu * p_n / p->I;
    double k = p->mu * p->H * W * s / (s + be);
    return (V[0] * V[0] + V[1] * V[1]) / (square(s + al) + k * k) + square(p->e_r * W / (s + be)) -
           1;
}

/* the exact discrete step from t, by bisection */
static void puck_step(puck *p, double t, double h, void (*load)(double, double, report_load *))
{
    double p_n = p->m * g * h, V[2], W, lo = 0, hi = 1, re, im, size, friction[2];
    report_load l;
    int k;
    memset(&l, 0, sizeof l);
    if (load) load(t, h, &l);
    for (k = 0; k < 2; k++) V[k] = p->v[k] + h * l.force[k] / p->m;
    W = p->w + h * l.torque[2] / p->I;
    if (puck_equation(p, V, W, p_n, 0) <= 0) hi = 0; /* it sticks */
    while (hi > 0 && puck_equation(p, V, W, p_n, hi) > 0) hi *= 2;
    for (k = 0; hi > 0 && k < 60; k++) {
        double s = (lo + hi) / 2;
        if (puck_equation(p, V, W, p_n, s) > 0) {
            lo = s;
        } else {
            hi = s;
        }
    }
    p->w = W * hi / (hi + p->e_r * p->e_r * p->mu * p_n / p->I);
    re = hi + p->mu * p_n / p->m;
    im = -p->mu * p->H * p->w;
    size = re * re + im * im;
    friction[0] = -p->mu * p_n * (V[0] * re + V[1] * im) / size;
    friction[1] = -p->mu * p_n * (V[1] * re - V[0] * im) / size;
    for (k = 0; k < 2; k++) p->v[k] = V[k] + friction[k] / p->m;
}

/* how far apart two velocities are, spin at a lever of 0.25 m */
static double puck_off(const report_state *s, const double *v, double w)
{
    return largest(sqrt(square(s->v[0] - v[0]) + square(s->v[1] - v[1])), 0.25 * fabs(s->w[2] - w));
}

/* the discrete truth at every step, kept for the methods that follow */
static const puck *puck_history(report_watch *w, const puck *start, int k)
{
    static puck *history;
    static const puck *of;
    static double of_h;
    static int steps;
    int i;
    if (of != start || fabs(of_h - w->h) > 1e-15 || steps < w->steps) {
        free(history);
        of = start;
        of_h = w->h;
        steps = w->steps;
        history = (puck *)malloc((size_t)(steps + 1) * sizeof *history);
        if (!history) exit(2);
        history[0] = *start;
        for (i = 1; i <= steps; i++) {
            history[i] = history[i - 1];
            puck_step(history + i, (i - 1) * w->h, w->h, w->scene->world.load);
        }
    }
    return history + k;
}

static void t3_world(report_world *w)
{
    report_body *b = body(w, 3, 0.125, 0.125, 0.125, 0.25);
    double foot = 0.1 / sqrt(2);
    part(b, REPORT_OURS, REPORT_BOX, 0.28, 0.28, 0.25, 0, 0, 0);
    part(b, REPORT_PEERS, REPORT_BOX, foot, foot, 0.25, 0, 0, 0);
    corners(b, foot, foot, -0.25);
    b->start.v[0] = 1;
    b->start.w[2] = 5;
    world(w, 0.22, 0.1);
}

static void t3_watch(report_watch *w, int k, double t, const report_state *s)
{
    const puck *p = puck_history(w, &t3_puck, k);
    double y[6];
    if (w->at_end) {
        truth_t3(t, y);
        w->continuous = puck_off(s, y, y[2]);
    }
    w->discrete = largest(w->discrete, puck_off(s, p->v, p->w));
}

/* sampled where the step ends */
static void t4_load(double t, double h, report_load *l)
{
    double angle = 2 * pi * (t + h);
    memset(l, 0, sizeof *l);
    l->force[0] = 22.5 * sin(angle) + 22.5;
    l->force[1] = 22.5 * cos(angle) + 22.5;
    l->torque[2] = 2.1 * cos(angle);
}

static report_body *desk(report_world *w)
{
    report_body *b = body(w, 15, 1.2, 1.2, 0.625, 0.45);
    part(b, REPORT_PEERS, REPORT_BOX, 0.25, 0.25, 0.225, 0, 0, -0.225);
    corners(b, 0.25, 0.25, -0.45);
    b->start.v[0] = 0.3;
    b->start.v[1] = 0.2;
    b->start.w[2] = 0.5;
    world(w, 0.22, 0.1);
    w->load = t4_load;
    return b;
}

static void t4_one_world(report_world *w)
{
    part(desk(w), REPORT_OURS, REPORT_BOX, 0.28, 0.28, 0.225, 0, 0, -0.225);
}

static void t4_four_world(report_world *w)
{
    report_body *b = desk(w);
    int i;
    for (i = 0; i < 4; i++) {
        part(b, REPORT_OURS, REPORT_BOX, 0.03, 0.03, 0.225, i & 1 ? 0.25 : -0.25,
             i & 2 ? 0.25 : -0.25, -0.225);
    }
}

/* the continuous truth of the desk as one patch: the exact steps, extrapolated in h (Neville) */
static const puck *t4_truth(void)
{
    enum { ORDER = 7 };
    static puck out;
    static int known;
    double table[ORDER][3];
    int i, j, k, steps;
    if (known) return &out;
    for (i = 0; i < ORDER; i++) {
        puck p = t4_puck;
        steps = 400 << i;
        for (k = 0; k < steps; k++) puck_step(&p, 4.0 * k / steps, 4.0 / steps, t4_load);
        table[i][0] = p.v[0];
        table[i][1] = p.v[1];
        table[i][2] = p.w;
        for (j = i - 1; j >= 0; j--) {
            for (k = 0; k < 3; k++) {
                table[j][k] =
                    table[j + 1][k] + (table[j + 1][k] - table[j][k]) / (pow(2, i - j) - 1);
            }
        }
    }
    out.v[0] = table[0][0];
    out.v[1] = table[0][1];
    out.w = table[0][2];
    known = 1;
    return &out;
}

static void t4_one_watch(report_watch *w, int k, double t, const report_state *s)
{
    const puck *p = puck_history(w, &t4_puck, k);
    (void)t;
    if (w->at_end) w->continuous = puck_off(s, t4_truth()->v, t4_truth()->w);
    w->discrete = largest(w->discrete, puck_off(s, p->v, p->w));
}

/* ---- T5: blocks */

static void t5_stick_world(report_world *w)
{
    solid_box(w, 1, 0.1, 0.1, 0.1);
    world(w, 0.5, 0.05);
    incline(w, 20 * pi / 180, 0);
}

static const double slip_angle = 30 * 3.14159265358979323846 / 180, slip_mu = 0.3;

static void t5_slip_world(report_world *w)
{
    solid_box(w, 1, 0.1, 0.1, 0.1);
    world(w, slip_mu, 0.05);
    incline(w, slip_angle, 0);
}

static void t5_slip_turned_world(report_world *w)
{
    t5_slip_world(w);
    incline(w, slip_angle, 30 * pi / 180);
}

static void t5_slip_watch(report_watch *w, int k, double t, const report_state *s)
{
    const double *down = w->scene->world.g;
    double a = g * (sin(slip_angle) - slip_mu * cos(slip_angle)), size = hypot(down[0], down[1]);
    double x[3], way[2];
    int i;
    way[0] = a * t * t / 2;
    way[1] = a * w->h * w->h * k * (k + 1.0) / 2;
    for (i = 0; i < 2; i++) {
        x[0] = down[0] / size * way[i];
        x[1] = down[1] / size * way[i];
        x[2] = 0.1;
        if (i == 0 && w->at_end) w->continuous = distance(s->x, x);
        if (i == 1) w->discrete = largest(w->discrete, distance(s->x, x));
    }
}

static const double rock_b = 0.1, rock_H = 0.3;

static void t5_rock_world(report_world *w)
{
    report_body *b = solid_box(w, 1, rock_b, 0.1, rock_H);
    double th = (double)truth_rock_al() / 2;
    corners(b, rock_b, 0.1, rock_H);
    b->start.q[0] = cos(th / 2);
    b->start.q[2] = sin(th / 2);
    b->start.x[0] = rock_H * sin(th) - rock_b * cos(th);
    b->start.x[2] = rock_b * sin(th) + rock_H * cos(th);
    world(w, 0.5, 0.05);
}

static void t5_rock_watch(report_watch *w, int k, double t, const report_state *s)
{
    double theta, rate;
    (void)k;
    if (!w->at_end) return;
    truth_rock(t, &theta, &rate);
    w->continuous = fabs(2 * atan2(s->q[2], s->q[0]) - theta);
}

/* ---- T6: a ball slides until it rolls */

static void t6_world(report_world *w)
{
    report_body *b = body(w, 1, 0.004, 0.004, 0.004, 0.1);
    part(b, REPORT_ALL, REPORT_SPHERE, 0.1, 0, 0, 0, 0, 0);
    point(b, 0, 0, 0, 0.1);
    b->start.v[0] = 3;
    world(w, 0.3, 0);
}

static void t6_watch(report_watch *w, int k, double t, const report_state *s)
{
    double rolls = 2 * 3 / (7 * 0.3 * g), loss = 0.3 * g * w->h, n = floor((3 - 15.0 / 7) / loss);
    double x[3] = {0, 0, 0.1};
    if (w->at_end) {
        x[0] = 12 * 9 / (49 * 0.3 * g) + 15.0 / 7 * (t - rolls);
        w->continuous = distance(s->x, x);
    }
    if (k < n) n = k;
    x[0] = w->h * (n * 3 - loss * n * (n + 1) / 2 + (k - n) * 15.0 / 7);
    w->discrete = largest(w->discrete, distance(s->x, x));
}

/* ---- T7, free fall, landing: nothing below, or not at first */

static void t7_world(report_world *w)
{
    report_body *b = body(w, 1, 1, 2, 3, 1);
    part(b, REPORT_ALL, REPORT_SPHERE, 0.1, 0, 0, 0, 0, 0);
    b->start.w[0] = b->start.w[2] = 0.01;
    b->start.w[1] = 1;
}

/* twice the energy, and the angular momentum in world axes */
static void conserved(const report_body *b, const report_state *s, double *energy, double *L)
{
    double R[9];
    int j, k;
    rotation(s->q, R);
    *energy = L[0] = L[1] = L[2] = 0;
    for (k = 0; k < 3; k++) {
        double w = R[k] * s->w[0] + R[3 + k] * s->w[1] + R[6 + k] * s->w[2];
        *energy += b->inertia[k] * w * w;
        for (j = 0; j < 3; j++) L[j] += R[3 * j + k] * b->inertia[k] * w;
    }
}

static void t7_watch(report_watch *w, int k, double t, const report_state *s)
{
    const report_body *b = w->scene->world.body;
    const double zero[3] = {0, 0, 0};
    double before, now, L[3], M[3], q[4], spin[3], dot = 0;
    (void)k;
    conserved(b, &b->start, &before, L);
    conserved(b, s, &now, M);
    w->energy = largest(w->energy, fabs(now - before) / before);
    w->momentum = largest(w->momentum, distance(L, M) / distance(L, zero));
    if (!w->at_end) return;
    truth_t7(t, q, spin);
    for (k = 0; k < 4; k++) dot += s->q[k] * q[k];
    for (k = 0; k < 4; k++) {
        /* nearly half the angle between the two */
        w->continuous += square(s->q[k] - (dot < 0 ? -q[k] : q[k]));
    }
    w->continuous = 4 * asin(fmin(sqrt(w->continuous) / 2, 1));
}

static report_body *box_in_the_air(report_world *w, double z, double vx, double vz)
{
    report_body *b = solid_box(w, 1, 0.2, 0.1, 0.05);
    b->start.x[2] = z;
    b->start.v[0] = vx;
    b->start.v[2] = vz;
    world(w, 0.2, 0.05);
    return b;
}

static void fall_world(report_world *w) { box_in_the_air(w, 1, 1, 2)->start.w[2] = 3; }

static void fall_watch(report_watch *w, int k, double t, const report_state *s)
{
    double x[3] = {0, 0, 0};
    x[0] = t;
    x[2] = 1 + 2 * t - g * t * t / 2;
    if (w->at_end) w->continuous = distance(s->x, x);
    x[2] = 1 + 2 * t - g * w->h * w->h * k * (k + 1.0) / 2;
    w->discrete = largest(w->discrete, distance(s->x, x));
}

static void landing_world(report_world *w) { box_in_the_air(w, 0.55, 2, 0); }

static void landing_watch(report_watch *w, int k, double t, const report_state *s)
{
    double x[3] = {0, 0, 0.05}, v;
    (void)k;
    if (!w->at_end) return;
    truth_landing(t, x, &v);
    w->continuous = distance(s->x, x);
}

/* ---- at rest */

static void cube_world(report_world *w)
{
    solid_box(w, 1, 0.1, 0.1, 0.1);
    world(w, 0.5, 0.05);
}

static void stack_world(report_world *w)
{
    int i;
    for (i = 0; i < 10; i++) solid_box(w, 1, 0.1, 0.1, 0.05)->start.x[2] = 0.05 + 0.1 * i;
    world(w, 0.5, 0.05);
    w->stacked = 1;
}

/* whatever moves is an error */
static void rest_watch(report_watch *w, int k, double t, const report_state *s)
{
    int i;
    (void)k, (void)t;
    for (i = 0; i < w->scene->world.bodies; i++) {
        w->continuous = largest(w->continuous, distance(s[i].x, w->scene->world.body[i].start.x));
    }
    w->discrete = w->continuous;
}

/* ---- a scene whose truth is our own solution at small steps: velocities at its end */

static void own_watch(report_watch *w, int k, double t, const report_state *s)
{
    const report_scene *scene = w->scene;
    int i = (int)(10 * t + 0.5) - 1;
    (void)k;
    if (!w->at_end || !scene->truth_known || i < 0 || i >= REPORT_TRUTHS) return;
    w->continuous = puck_off(s, scene->truth[i].v, scene->truth[i].w[2]);
}

/* ---- the list */

static report_scene scenes[] = {
    {.name = "t1",
     .title = "T1: the table of Example 1 slides to rest",
     .unit = "m",
     .measure = "position at 4.5 s",
     .truth_is = "its exact motion (rest after 4.2517 s and 10.6293 m)",
     .end = 4.5,
     .build = t1_world,
     .watch = t1_watch,
     .has_discrete = 1,
     .rests = 1,
     .patches = 1,
     .moves = 1,
     .floor = 1e-12},
    {.name = "t2",
     .title = "T2: the table of Example 2 slides, is hit, and tilts on a leg",
     .unit = "m",
     .measure = "position of the centre of mass, the worst of every 0.4 s to 1.6 s",
     .truth_is = "the integral of its equations of motion in the plane of symmetry, with the leg's "
                 "slip and its reversal",
     .remark = "That integral knows nothing of the library; our first-order steps approach it in "
               "proportion to h. At 1.6018 s the table falls back on all legs. The peers stand on "
               "the outermost points of the legs, about which it tilts, and do without its top.",
     .end = 1.6,
     .sample = 0.4,
     .build = t2_world,
     .watch = t2_watch,
     .patches = 1,
     .moves = 1,
     .floor = 1e-12},
    {.name = "t2_rest",
     .title = "T2: the table of Example 2 falls back on its legs and rests",
     .unit = "m",
     .measure = "position of the centre of mass, the worst of every 0.4 s to 2.4 s",
     .truth_is = "that integral, with an impact on all legs at once whose friction stops the table",
     .remark = "A step that does not end just when the table lands leaves a part of the impact to "
               "the next step, and friction is another one in between: with our first-order steps "
               "up to 1.3 cm, however short they are.",
     .end = 2.4,
     .sample = 0.4,
     .build = t2_world,
     .watch = t2_watch,
     .rests = 1,
     .patches = 1,
     .moves = 1,
     .floor = 1e-12},
    {.name = "t3",
     .title = "T3: one patch spins and slides",
     .unit = "m/s",
     .measure = "velocity at 0.3 s, the spin at a lever of 0.25 m",
     .truth_is = "the integral of its equations of motion",
     .remark =
         "The truth has the ellipsoid law of friction with e_r = 0.1 m, which no peer has. They "
         "stand on four corners 0.1 m from the axis: the same law where the body only slides or "
         "only spins, another one in between. That is a part of their error which no step size "
         "removes.",
     .end = 0.3,
     .build = t3_world,
     .watch = t3_watch,
     .has_discrete = 1,
     .moves = 1,
     .floor = 1e-12},
    {.name = "t4_one",
     .title = "T4: a desk that is pushed round, its feet as one patch",
     .unit = "m/s",
     .measure = "velocity at 4 s, the spin at a lever of 0.25 m",
     .truth_is = "the exact steps, extrapolated to step size zero",
     .remark =
         "The truth has one patch with the ellipsoid law and e_r = 0.1 m. The peers have no such "
         "patch; on corners 0.1 m from the axis they would tip over, so they stand on the desk's "
         "own, 0.35 m from it. Most of their error is that other law; compare their times.",
     .end = 4,
     .build = t4_one_world,
     .watch = t4_one_watch,
     .has_discrete = 1,
     .moves = 1,
     .floor = 1e-10},
    {.name = "t4_four",
     .title = "T4: the same desk on four patches",
     .unit = "m/s",
     .measure = "velocity at 4 s, the spin at a lever of 0.25 m",
     .truth_is = "our own solution by the rule centred",
     .remark =
         "Each of our patches has torsional friction, e_r = 0.1 m, and the peers' corners have "
         "none; how the weight is shared by four legs is a matter of the rule. Both are in "
         "their error; compare their times.",
     .end = 4,
     .build = t4_four_world,
     .watch = own_watch,
     .patches = 1,
     .moves = 1},
    {.name = "t5_stick",
     .title = "T5: a block on an incline that it does not slide down",
     .unit = "m",
     .measure = "the farthest that it gets in 1 s",
     .truth_is = "it stays where it is",
     .end = 1,
     .build = t5_stick_world,
     .watch = rest_watch,
     .has_discrete = 1,
     .rests = 1,
     .floor = 1e-15},
    {.name = "t5_slip",
     .title = "T5: a block slides down an incline, along an axis",
     .unit = "m",
     .measure = "position at 1 s",
     .truth_is = "g (sin - mu cos) t^2 / 2",
     .end = 1,
     .build = t5_slip_world,
     .watch = t5_slip_watch,
     .has_discrete = 1,
     .moves = 1,
     .floor = 1e-13},
    {.name = "t5_slip_30",
     .title = "T5: a block slides down an incline, at 30 degrees to the axes",
     .unit = "m",
     .measure = "position at 1 s",
     .truth_is = "g (sin - mu cos) t^2 / 2",
     .end = 1,
     .build = t5_slip_turned_world,
     .watch = t5_slip_watch,
     .has_discrete = 1,
     .moves = 1,
     .floor = 1e-13},
    {.name = "t5_rock",
     .title = "T5: a block rocks on its edge",
     .unit = "rad",
     .measure = "angle at 0.2 s",
     .truth_is = "the integral of its equation of motion",
     .end = 0.2,
     .build = t5_rock_world,
     .watch = t5_rock_watch,
     .moves = 1,
     .floor = 1e-12},
    {.name = "t5_impact",
     .title = "T5: a block rocks on to its other edge",
     .unit = "rad",
     .measure = "angle at 0.6 s",
     .truth_is = "the integral of its equation of motion to the exact quarter period, 0.27386 s, "
                 "where momentum about the new edge is kept, and beyond",
     .end = 0.6,
     .build = t5_rock_world,
     .watch = t5_rock_watch,
     .moves = 1,
     .floor = 1e-12},
    {.name = "t6",
     .title = "T6: a ball slides until it rolls",
     .unit = "m",
     .measure = "position at 1 s",
     .truth_is = "its exact motion (rolls after 0.2915 s)",
     .end = 1,
     .build = t6_world,
     .watch = t6_watch,
     .has_discrete = 1,
     .moves = 1,
     .floor = 1e-13},
    {.name = "t7",
     .title = "T7: free rotation about the axis in the middle, a turn over",
     .unit = "rad",
     .measure = "the angle by which the pose is off at 20 s",
     .truth_is = "the integral of Euler's equations",
     .remark = "Moments of inertia 1, 2, 3, angular velocity (0.01, 1, 0.01) at first: it turns "
               "over every 19.55 s, and what is off grows on the way. Energy and angular momentum: "
               "how far from those of the start, relative to them.",
     .end = 20,
     .build = t7_world,
     .watch = t7_watch,
     .moves = 1,
     .conserves = 1,
     .floor = 1e-12},
    {.name = "fall",
     .title = "A box falls",
     .unit = "m",
     .measure = "position at 0.5 s",
     .truth_is = "its exact motion",
     .end = 0.5,
     .build = fall_world,
     .watch = fall_watch,
     .has_discrete = 1,
     .moves = 1,
     .floor = 1e-14},
    {.name = "landing",
     .title = "A box lands, and slides",
     .unit = "m",
     .measure = "position at 0.6 s",
     .truth_is = "its exact motion (lands after 0.3194 s, and loses mu times the impulse)",
     .end = 0.6,
     .build = landing_world,
     .watch = landing_watch,
     .moves = 1,
     .floor = 1e-14},
    {.name = "cube",
     .title = "A cube at rest",
     .unit = "m",
     .measure = "the farthest that it gets in 1 s",
     .truth_is = "it stays where it is",
     .end = 1,
     .build = cube_world,
     .watch = rest_watch,
     .has_discrete = 1,
     .rests = 1,
     .floor = 1e-15},
    {.name = "stack",
     .title = "A stack of ten boxes at rest",
     .unit = "m",
     .measure = "the farthest that any of them gets in 2 s",
     .truth_is = "they stay where they are",
     .end = 2,
     .build = stack_world,
     .watch = rest_watch,
     .has_discrete = 1,
     .rests = 1,
     .patches = 1,
     .floor = 1e-15},
};

report_scene *report_scenes(int *count)
{
    int i, n = (int)(sizeof scenes / sizeof scenes[0]);
    for (i = 0; i < n; i++) {
        if (scenes[i].world.bodies) break;
        scenes[i].build(&scenes[i].world);
        scenes[i].own_truth = scenes[i].watch == own_watch;
    }
    *count = n;
    return scenes;
}

/* n cylinders in a ring carry a board that is not a part of the patches */
void report_legs(report_world *w, int n)
{
    report_body *b;
    int i;
    memset(w, 0, sizeof *w);
    b = body(w, 1, 0.5, 0.5, 1, 0.1);
    for (i = 0; i < n; i++) {
        double x = n > 1 ? cos(2 * pi * i / n) : 0, y = n > 1 ? sin(2 * pi * i / n) : 0;
        part(b, REPORT_OURS, REPORT_CYLINDER, 1.0 / (n + 2), 0.1, 0, x, y, 0);
        part(b, REPORT_PEERS, REPORT_SPHERE, 0.1, 0, 0, x, y, 0);
        point(b, x, y, -0.1, 0);
    }
    b->start.v[0] = 100; /* slides as long as it is timed */
    b->start.v[1] = 50;
    world(w, 0.5, 0.1);
}

/* ---- penetration, from the poses alone */

/* the depth of a part below the plane, from its lowest point */
static double depth_in_plane(const report_part *p, const report_state *s, const double *R)
{
    double low = s->x[2] + R[6] * p->at[0] + R[7] * p->at[1] + R[8] * p->at[2];
    if (p->kind == REPORT_BOX) {
        low -= fabs(R[6]) * p->size[0] + fabs(R[7]) * p->size[1] + fabs(R[8]) * p->size[2];
    } else if (p->kind == REPORT_CYLINDER) {
        low -= hypot(R[6], R[7]) * p->size[0] + fabs(R[8]) * p->size[1];
    } else {
        low -= p->size[0];
    }
    return -low;
}

/* the least overlap of two boxes over the fifteen axes that can separate them */
static double depth_of_boxes(const double *a, const report_state *sa, const double *b,
                             const report_state *sb)
{
    double A[9], B[9], d[3], least = 1e300;
    int i, j, k;
    rotation(sa->q, A);
    rotation(sb->q, B);
    for (k = 0; k < 3; k++) d[k] = sb->x[k] - sa->x[k];
    for (i = 0; i < 15; i++) {
        double n[3], size, reach = 0, along = 0;
        for (k = 0; k < 3; k++) {
            int p = (k + 1) % 3, q = (k + 2) % 3, u = (i - 6) / 3, v = (i - 6) % 3;
            if (i < 3) n[k] = A[3 * k + i];
            if (i >= 3 && i < 6) n[k] = B[3 * k + i - 3];
            if (i >= 6) n[k] = A[3 * p + u] * B[3 * q + v] - A[3 * q + u] * B[3 * p + v];
        }
        size = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        if (size < 1e-3) continue; /* parallel edges: the faces' axes do */
        for (k = 0; k < 3; k++) along += n[k] / size * d[k];
        for (j = 0; j < 3; j++) {
            reach += a[j] * fabs(n[0] * A[j] + n[1] * A[3 + j] + n[2] * A[6 + j]) / size;
            reach += b[j] * fabs(n[0] * B[j] + n[1] * B[3 + j] + n[2] * B[6 + j]) / size;
        }
        if (reach - fabs(along) < least) least = reach - fabs(along);
    }
    return least;
}

double report_penetration(const report_world *w, const report_state *s, int who)
{
    double depth = 0, R[9];
    int i, j;
    for (i = 0; i < w->bodies; i++) {
        rotation(s[i].q, R);
        for (j = 0; j < w->body[i].parts; j++) {
            const report_part *p = w->body[i].part + j;
            if (p->who & who) depth = largest(depth, depth_in_plane(p, s + i, R));
        }
        for (j = 0; w->stacked && j < i; j++) {
            depth = largest(depth, depth_of_boxes(w->body[i].part[0].size, s + i,
                                                  w->body[j].part[0].size, s + j));
        }
    }
    return depth;
}
