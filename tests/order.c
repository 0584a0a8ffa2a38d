/* What ecp_advance costs and how far it is from the truth (`make order`): scenes whose motion is known
   in closed form or from an ordinary differential equation, for tolerances from 1e-3 to 1e-10. The
   error is the largest one in position (m), turn (rad), velocity and angular velocity. Lines end in
   the last line's figures at the tolerance 1e-9. */

#define ECPSIM_IMPLEMENTATION
#include "../ecpsim.h"

#include "truths.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define G 9.8

typedef struct truth {
    double x[3], q[4], v[3], w[3];
    int turn; /* q counts */
} truth;

typedef struct scene {
    const char *name;
    double duration;
    void (*build)(truth *t);
    ecp_load load;
    double kick; /* when body 1 gets the angular impulse of Example 2, s; 0: never */
} scene;

static const double pi = 3.14159265358979323846;
static ecp_world *world;
static ecp_material material;

static void must(ecp_status status)
{
    if (status == ECP_OK) return;
    fprintf(stderr, "%s\n", ecp_status_string(status));
    exit(2);
}

static void open_world(double mu, double e_r)
{
    ecp_world_desc d = ecp_world_desc_default();
    size_t bytes;
    d.max_bodies = 2;
    d.max_shapes = 4;
    d.max_patches = 3;
    d.advance_order = 8;
    bytes = ecp_world_memsize(&d);
    must(ecp_world_init(&world, &d, malloc(bytes), bytes));
    material = ecp_material_default();
    material.mu = mu;
    material.e_r = e_r;
}

static void ground(double slope)
{
    ecp_body_desc b = ecp_body_desc_default();
    ecp_real up[3] = {0, 0, 1};
    ecp_shape s;
    up[0] = sin(slope);
    up[2] = cos(slope);
    b.kind = ECP_STATIC;
    must(ecp_body_add(world, &b, NULL));
    must(ecp_shape_half_space(&s, up, 0));
    must(ecp_body_add_shape(world, 0, &s, NULL, NULL, &material, NULL));
}

/* a body of the inertia of its shape, or of what is given, with the state that is in *t */
static void body(const ecp_shape *s, double mass, const double *inertia, const truth *t)
{
    ecp_body_desc b = ecp_body_desc_default();
    ecp_mass m = {0};
    int k, at;
    if (s) ecp_shape_mass(s, 1, &m);
    b.mass = mass;
    for (k = 0; k < 9; k++) {
        b.inertia[k] = inertia ? (k % 4 ? 0 : inertia[k / 4]) : m.inertia[k] * mass / m.mass;
    }
    for (k = 0; k < 3; k++) {
        b.position[k] = t->x[k];
        b.velocity[k] = t->v[k];
        b.angular_velocity[k] = t->w[k];
    }
    for (k = 0; k < 4; k++) b.rotation[k] = t->q[k];
    must(ecp_body_add(world, &b, &at));
    if (s) must(ecp_body_add_shape(world, at, s, NULL, NULL, &material, NULL));
}

static void box(ecp_shape *s, double x, double y, double z)
{
    ecp_real half[3];
    half[0] = x;
    half[1] = y;
    half[2] = z;
    must(ecp_shape_box(s, half));
}

static void turn_y(truth *t, double angle)
{
    t->q[0] = cos(angle / 2);
    t->q[1] = t->q[3] = 0;
    t->q[2] = sin(angle / 2);
}

static truth at_rest(double z)
{
    truth t;
    memset(&t, 0, sizeof t);
    t.q[0] = 1;
    t.x[2] = z;
    return t;
}

/* ---- scenes: build makes the world and leaves the state at the end in *t */

static void build_fall(truth *t)
{
    ecp_shape s;
    open_world(0.5, 0);
    ground(0);
    box(&s, 0.2, 0.1, 0.05);
    *t = at_rest(1);
    t->v[0] = 1;
    t->v[2] = 2;
    t->w[2] = 3;
    body(&s, 1, NULL, t);
    t->x[0] = 0.5;
    t->x[2] = 1 + 2 * 0.5 - G * 0.125;
    t->v[2] = 2 - G * 0.5;
    t->q[0] = cos(0.75);
    t->q[3] = sin(0.75);
    t->turn = 1;
}

/* falls 0.5 m, loses what mu takes of the tangential velocity in the impact, slides */
static void build_landing(truth *t)
{
    ecp_shape s;
    open_world(0.2, 0);
    ground(0);
    box(&s, 0.2, 0.1, 0.05);
    *t = at_rest(0.55);
    t->v[0] = 2;
    body(&s, 1, NULL, t);
    truth_landing(0.6, t->x, t->v);
    t->x[2] = 0.05;
    t->turn = 1;
}

/* the table, one leg on the axis x or y */
static void table(truth *t, double vx, double vy, double first_leg)
{
    const double inertia[3] = {0.3327, 0.3327, 0.4458};
    ecp_shape leg;
    int k;
    open_world(0.12, 1);
    ground(0);
    *t = at_rest(0.3);
    t->v[0] = vx;
    t->v[1] = vy;
    body(NULL, 5, inertia, t);
    must(ecp_shape_cylinder(&leg, 0.1, 0.2));
    for (k = 0; k < 3; k++) {
        ecp_real at[3] = {0, 0, -0.1};
        at[0] = 0.3 * cos(first_leg + 2 * pi * k / 3);
        at[1] = 0.3 * sin(first_leg + 2 * pi * k / 3);
        must(ecp_body_add_shape(world, 1, &leg, at, NULL, &material, NULL));
    }
    t->turn = 1;
}

/* Example 1 while it slides, and beyond its stop */
static void build_sliding(truth *t)
{
    double path;
    table(t, 4, 3, 0);
    path = 5 * 3 - 0.06 * G * 9;
    t->x[0] = 0.8 * path;
    t->x[1] = 0.6 * path;
    t->v[0] = 0.8 * (5 - 0.12 * G * 3);
    t->v[1] = 0.6 * (5 - 0.12 * G * 3);
}

static void build_example1(truth *t)
{
    table(t, 4, 3, 0);
    t->x[0] = 0.8 * 10.6292517006803;
    t->x[1] = 0.6 * 10.6292517006803;
    t->v[0] = t->v[1] = 0;
}

static void table_2(truth *t, double time)
{
    truth_t2_state s = truth_t2_at(time);
    long double arm[2];
    table(t, 0, 1, pi / 2);
    truth_t2_arm(s.y[2], arm);
    t->x[1] = (double)s.y[0];
    t->v[1] = (double)s.y[1];
    t->q[0] = (double)cosl(s.y[2] / 2);
    t->q[1] = (double)sinl(s.y[2] / 2);
    t->w[0] = (double)s.y[3];
    /* it stands on the point, or on all legs */
    t->x[2] = (double)-arm[1];
    t->v[2] = (double)(-arm[0] * s.y[3]);
}

/* Example 2: on one leg, just before it lands (1.6018 s), and when it has come to rest */
static void build_pivot(truth *t) { table_2(t, 1.6); }
static void build_example2(truth *t) { table_2(t, 2.4); }

static void build_t3(truth *t)
{
    const double inertia[3] = {0.125, 0.125, 0.125};
    double y[6];
    ecp_shape s;
    open_world(0.22, 0.1);
    ground(0);
    box(&s, 0.3, 0.3, 0.25);
    *t = at_rest(0.25);
    t->v[0] = 1;
    t->w[2] = 5;
    body(&s, 3, inertia, t);
    truth_t3(0.3, y);
    t->v[0] = y[0];
    t->v[1] = y[1];
    t->w[2] = y[2];
    t->x[0] = y[3];
    t->x[1] = y[4];
    t->q[0] = cos(y[5] / 2);
    t->q[3] = sin(y[5] / 2);
    t->turn = 1;
}

/* truths T3: spins on the spot until t = I w / (e_r mu m g) */
static void build_spin(truth *t)
{
    const double inertia[3] = {0.125, 0.125, 0.125};
    double stop = 0.125 * 5 / (0.1 * 0.22 * 3 * G), angle = 5 * stop / 2;
    ecp_shape s;
    open_world(0.22, 0.1);
    ground(0);
    box(&s, 0.3, 0.3, 0.25);
    *t = at_rest(0.25);
    t->w[2] = 5;
    body(&s, 3, inertia, t);
    t->w[2] = 0;
    t->q[0] = cos(angle / 2);
    t->q[3] = sin(angle / 2);
    t->turn = 1;
}

/* a block of half sizes 0.1 x 0.3 on its right edge, the angle to the right, or mirrored */
static void block_state(truth *t, double theta, double rate, int side)
{
    double R = sqrt(0.1), al = atan2(0.1, 0.3), c = al - theta;
    t->x[0] = 0.1 - R * sin(c);
    t->x[2] = R * cos(c);
    t->v[0] = R * cos(c) * rate;
    t->v[2] = R * sin(c) * rate;
    if (side < 0) {
        t->x[0] = -t->x[0];
        t->v[0] = -t->v[0];
    }
    turn_y(t, side * theta);
    t->w[1] = side * rate;
    t->turn = 1;
}

static void build_block(truth *t)
{
    ecp_shape s;
    open_world(2, 0);
    ground(0);
    box(&s, 0.1, 0.1, 0.3);
    *t = at_rest(0);
    block_state(t, (double)truth_rock_al() / 2, 0, 1);
    body(&s, 1, NULL, t);
}

static void build_rocking(truth *t)
{
    double theta, rate;
    build_block(t);
    truth_rock(0.27, &theta, &rate);
    block_state(t, theta, rate, 1);
}

/* through the impact, on to the other edge */
static void build_impact(truth *t)
{
    double theta, rate;
    build_block(t);
    truth_rock(0.6, &theta, &rate);
    block_state(t, -theta, -rate, -1);
}

/* a box on an incline of th: at rest there, as the truth is at first */
static void box_on_incline(truth *t, double th, double mu)
{
    ecp_shape s;
    open_world(mu, 0);
    ground(th);
    box(&s, 0.2, 0.1, 0.05);
    *t = at_rest(0);
    turn_y(t, th);
    t->x[0] = 0.05 * sin(th);
    t->x[2] = 0.05 * cos(th);
    body(&s, 1, NULL, t);
    t->turn = 1;
}

static void build_slip(truth *t)
{
    double th = 0.5, a = G * (sin(th) - 0.3 * cos(th));
    box_on_incline(t, th, 0.3);
    t->x[0] += a / 2 * cos(th);
    t->x[2] -= a / 2 * sin(th);
    t->v[0] = a * cos(th);
    t->v[2] = -a * sin(th);
}

static void build_stick(truth *t) { box_on_incline(t, 0.5, 0.6); }

/* slides, then rolls */
static void build_roll(truth *t)
{
    double stop = 2 / (7 * 0.2 * G);
    ecp_shape s;
    open_world(0.2, 0);
    ground(0);
    must(ecp_shape_sphere(&s, 0.1));
    *t = at_rest(0.1);
    t->v[0] = 1;
    body(&s, 1, NULL, t);
    t->x[0] = 12 / (49 * 0.2 * G) + 5.0 / 7 * (1 - stop);
    t->v[0] = 5.0 / 7;
    t->w[1] = 50.0 / 7;
}

static void build_roll_down(truth *t)
{
    double th = 0.3, a = G * sin(th) * 5 / 7;
    ecp_shape s;
    open_world(0.5, 0);
    ground(th);
    must(ecp_shape_sphere(&s, 0.1));
    *t = at_rest(0);
    t->x[0] = 0.1 * sin(th);
    t->x[2] = 0.1 * cos(th);
    body(&s, 1, NULL, t);
    t->x[0] += a / 2 * cos(th);
    t->x[2] -= a / 2 * sin(th);
    t->v[0] = a * cos(th);
    t->v[2] = -a * sin(th);
    t->w[1] = a / 0.1;
}

/* a load that grows: 2.3 N/s sideways, 7.7 N/s upwards */
static void push(void *user, ecp_world *w, ecp_real time)
{
    ecp_real f[3] = {0, 0, 0};
    (void)user;
    f[0] = 2.3 * time;
    must(ecp_body_apply_force(w, 1, f, NULL));
}

static void build_push(truth *t)
{
    double late = 2 - 0.3 * G / 2.3;
    ecp_shape s;
    open_world(0.3, 0);
    ground(0);
    box(&s, 0.2, 0.1, 0.05);
    *t = at_rest(0.05);
    body(&s, 1, NULL, t);
    t->x[0] = 2.3 * late * late * late / 6;
    t->v[0] = 2.3 * late * late / 2;
    t->turn = 1;
}

static void lift(void *user, ecp_world *w, ecp_real time)
{
    ecp_real f[3] = {0, 0, 0};
    (void)user;
    f[2] = 7.7 * time;
    must(ecp_body_apply_force(w, 1, f, NULL));
}

static void build_lift(truth *t)
{
    double late = 2 - G / 7.7;
    build_push(t);
    *t = at_rest(0.05 + 7.7 * late * late * late / 6);
    t->v[2] = 7.7 * late * late / 2;
    t->turn = 1;
}

/* T7, one turn over: I = (1, 2, 3) */
static const double t7_inertia[3] = {1, 2, 3};

static void t7_world(truth *t)
{
    const ecp_real none[3] = {0, 0, 0};
    open_world(0, 0);
    must(ecp_world_set_gravity(world, none));
    *t = at_rest(0);
    t->w[0] = t->w[2] = 0.01;
    t->w[1] = 1;
    body(NULL, 1, t7_inertia, t);
}

static void build_t7(truth *t)
{
    t7_world(t);
    truth_t7(20, t->q, t->w);
    t->turn = 1;
}

static const scene scenes[] = {
    {"free fall", 0.5, build_fall, NULL, 0},
    {"landing, then sliding", 0.6, build_landing, NULL, 0},
    {"T1 while it slides", 3, build_sliding, NULL, 0},
    {"T1 beyond its stop", 5, build_example1, NULL, 0},
    {"T2 on one leg", 1.6, build_pivot, NULL, 0.75},
    {"T2 through its landing", 2.4, build_example2, NULL, 0.75},
    {"T3 spin and slide", 0.3, build_t3, NULL, 0},
    {"T3 spins to a stop", 1.5, build_spin, NULL, 0},
    {"T5 rocking block", 0.27, build_rocking, NULL, 0},
    {"T5 through its impact", 0.6, build_impact, NULL, 0},
    {"T5 slip on an incline", 1, build_slip, NULL, 0},
    {"T5 stick on an incline", 1, build_stick, NULL, 0},
    {"T6 slides, then rolls", 1, build_roll, NULL, 0},
    {"T6 rolls down", 1, build_roll_down, NULL, 0},
    {"T7 turns over", 20, build_t7, NULL, 0},
    {"pushed until it slips", 2, build_push, push, 0},
    {"pulled until it lifts", 2, build_lift, lift, 0},
};
#define SCENES (int)(sizeof scenes / sizeof *scenes)

/* ---- runs */

static double largest(double a, double b) { return a > b || a != a ? a : b; }

static double error_of(const truth *t)
{
    ecp_real x[3], q[4], v[3], w[3];
    double worst = 0, dot = 0;
    int k;
    must(ecp_body_get_state(world, ecp_world_body_count(world) - 1, x, q, v, w));
    for (k = 0; k < 3; k++) {
        worst = largest(fabs(x[k] - t->x[k]), worst);
        worst = largest(fabs(v[k] - t->v[k]), worst);
        worst = largest(fabs(w[k] - t->w[k]), worst);
    }
    for (k = 0; k < 4; k++) dot += q[k] * t->q[k];
    for (k = 0; t->turn && k < 4; k++) {
        worst = largest(2 * fabs(q[k] - (dot < 0 ? -t->q[k] : t->q[k])), worst);
    }
    return worst;
}

/* overlap of the contacts at the end, by support functions */
static double overlap(void)
{
    double worst = 0;
    ecp_contact c;
    int k;
    for (k = 0; k < ecp_contact_count(world); k++) {
        must(ecp_contact_get(world, k, &c));
        worst = largest(-c.separation, worst);
    }
    return worst;
}

static double seconds(void) { return (double)clock() / CLOCKS_PER_SEC; }

static double advance(double duration, double tolerance, ecp_load load, ecp_advance_report *r)
{
    ecp_advance_options o = ecp_advance_options_default();
    double begin = seconds();
    o.tolerance = tolerance;
    o.load = load;
    must(ecp_advance(world, duration, &o, r));
    return seconds() - begin;
}

/* a scene from its beginning to its end; *r: of all */
static double run_scene(const scene *s, double tolerance, ecp_advance_report *r)
{
    const ecp_real kick[3] = {-5, 0, 0};
    ecp_advance_report first;
    double spent;
    if (!(s->kick > 0)) return advance(s->duration, tolerance, s->load, r);
    spent = advance(s->kick, tolerance, s->load, &first);
    must(ecp_body_apply_angular_impulse(world, 1, kick));
    spent += advance(s->duration - s->kick, tolerance, s->load, r);
    r->solves += first.solves;
    r->events += first.events;
    r->first_order += first.first_order;
    r->forced += first.forced;
    if (first.highest_order > r->highest_order) r->highest_order = first.highest_order;
    return spent;
}

/* the least time in which first-order steps are within 1e-3 of Example 1's stop, in ms */
static double first_order(double *h_out)
{
    double h = 0.01, ms, error;
    truth t;
    do {
        double begin;
        int k, steps = (int)(5 / h + 0.5);
        build_example1(&t);
        begin = seconds();
        for (k = 0; k < steps; k++) must(ecp_step(world, h, NULL, NULL));
        ms = 1e3 * (seconds() - begin);
        error = error_of(&t);
        free(world);
        *h_out = h;
        h /= error > 2e-3 ? 2 : 1.1;
    } while (error > 1e-3);
    return ms;
}

/* ---- T7: a body that flips over and over */

static void body_axes(double w[3])
{
    ecp_real q[4], v[3], R[9];
    int k;
    must(ecp_body_get_state(world, 0, NULL, q, NULL, v));
    ecp_quat_to_matrix(q, R);
    for (k = 0; k < 3; k++) w[k] = R[k] * v[0] + R[3 + k] * v[1] + R[6 + k] * v[2];
}

/* the time from now until the angular velocity about the middle axis is zero, and the world then */
static double next_flip(double tolerance)
{
    size_t bytes = ecp_world_state_size(world);
    void *before = malloc(bytes);
    double w[3], sign, time = 0, guess = 0.5;
    int k;
    body_axes(w);
    sign = w[1] > 0 ? 1 : -1;
    if (!before) exit(2);
    for (;;) {
        memcpy(before, world, bytes);
        advance(1, tolerance, NULL, NULL);
        body_axes(w);
        if (w[1] * sign < 0) break;
        time += 1;
    }
    for (k = 0; k < 8; k++) {
        memcpy(world, before, bytes);
        advance(guess, tolerance, NULL, NULL);
        body_axes(w);
        guess -= w[1] / (w[0] * w[2]); /* I2 w2' = (I3 - I1) w3 w1 */
    }
    free(before);
    return time + guess;
}

static double flip_interval_error(double tolerance)
{
    double w[3], energy = 0, momentum[3], before[3], drift = 0, interval;
    ecp_real R[9], q[4], v[3];
    ecp_advance_report r;
    truth t;
    int k, j;
    t7_world(&t);
    for (k = 0; k < 3; k++) before[k] = t7_inertia[k] * t.w[k];
    next_flip(tolerance);
    /* off the zero, so that the next one is another */
    advance(1, tolerance, NULL, NULL);
    interval = 1 + next_flip(tolerance);
    advance(20, tolerance, NULL, &r);
    body_axes(w);
    must(ecp_body_get_state(world, 0, NULL, q, NULL, v));
    ecp_quat_to_matrix(q, R);
    for (k = 0; k < 3; k++) energy += t7_inertia[k] * w[k] * w[k];
    for (k = 0; k < 3; k++) {
        for (j = 0, momentum[k] = 0; j < 3; j++) {
            momentum[k] += R[3 * k + j] * t7_inertia[j] * w[j];
        }
        drift = largest(fabs(momentum[k] - before[k]), drift);
    }
    printf(
        "T7 at %.0e: %d solves in 20 s, flip interval off by %.2e s, energy drift %.2e, momentum "
        "drift %.2e in 50 s (of 2)\n",
        tolerance, r.solves, interval - 19.55286710, energy - 2.0004, drift);
    free(world);
    return interval - 19.55286710;
}

int main(int argc, char **argv)
{
    double worst = 0, t3 = 0, rock = 0, ex1 = 0, ex1_ms = 0, first_ms, h, flip = 0, tolerance;
    int t3_solves = 0, rock_solves = 0, ex1_solves = 0, i, digits,
        last = argc > 1 ? atoi(argv[1]) : 10;
    printf("%-24s %9s %9s %7s %9s %7s %6s %7s %6s %9s\n", "scene", "tolerance", "error", "solves",
           "seconds", "events", "first", "forced", "order", "overlap");
    for (i = 0; i < SCENES; i++) {
        for (digits = 3; digits <= last; digits++) {
            ecp_advance_report r;
            truth t;
            double s, error, depth;
            tolerance = pow(10, -digits);
            scenes[i].build(&t);
            s = run_scene(scenes + i, tolerance, &r);
            error = error_of(&t);
            depth = overlap();
            worst = largest(error / tolerance, worst);
            printf("%-24s %9.0e %9.2e %7d %9.2e %7d %6d %7d %6d %9.1e\n", scenes[i].name, tolerance,
                   error, r.solves, s, r.events, r.first_order, r.forced, r.highest_order, depth);
            free(world);
            if (digits != 9) continue;
            if (scenes[i].build == build_t3) {
                t3 = error;
                t3_solves = r.solves;
            } else if (scenes[i].build == build_rocking) {
                rock = error;
                rock_solves = r.solves;
            } else if (scenes[i].build == build_example1) {
                ex1 = error;
                ex1_solves = r.solves;
                ex1_ms = 1e3 * s;
            }
        }
    }
    for (digits = 6; digits <= last; digits += 3) flip = flip_interval_error(pow(10, -digits));
    first_ms = first_order(&h);
    printf("first-order steps of Example 1 to 1e-3: h = %.2e, %.1f ms\n", h, first_ms);
    printf("order: scenes=%d worst_error_over_tolerance=%.2e t3_error=%.2e t3_solves=%d "
           "rock_error=%.2e rock_solves=%d example1_error=%.2e example1_solves=%d example1_ms=%.2f "
           "first_order_1e-3_ms=%.1f flip_interval_error_s=%.2e\n",
           SCENES + 1, worst, t3, t3_solves, rock, rock_solves, ex1, ex1_solves, ex1_ms, first_ms,
           fabs(flip));
    return !(worst <= 100 && fabs(t3) <= 1e-8 && rock <= 1e-8 && ex1 <= 1e-8 && t3_solves <= 500 &&
             rock_solves <= 700 && ex1_solves <= 1000 && ex1_ms < first_ms && fabs(flip) <= 1e-6);
}
