/* Sleep: every scene runs twice, with options.sleep and without, and after every step all bits of all
   bodies, contacts and multipliers must be the same. So each event below fails where a body sleeps
   through it; and each scene says when how many bodies are to be asleep, so that it also fails where
   nothing sleeps at all. */
#include "test.h"

typedef struct sleep_run {
    ecp_world *w[2]; /* that sleeps, and that does not */
    ecp_options o[2];
    ecp_report r[2];
    ecp_real h;
} sleep_run;

/* ---- scenes */

static int sleep_box(ecp_world *w, ecp_body_kind kind, double x, double y, double z, double half_z)
{
    ecp_body_desc d = ecp_body_desc_default();
    ecp_real half[3];
    ecp_shape shape;
    int body = -1, k;
    half[0] = half[1] = ECP_R(0.1);
    half[2] = (ecp_real)half_z;
    d.kind = kind;
    d.position[0] = (ecp_real)x;
    d.position[1] = (ecp_real)y;
    d.position[2] = (ecp_real)z;
    for (k = 0; k < 3; k++) {
        ecp_real a = half[(k + 1) % 3], b = half[(k + 2) % 3];
        d.inertia[4 * k] = (a * a + b * b) / 3;
    }
    CHECK(ecp_body_add(w, &d, &body) == ECP_OK);
    CHECK(ecp_shape_box(&shape, half) == ECP_OK);
    CHECK(ecp_body_add_shape(w, body, &shape, NULL, NULL, NULL, NULL) == ECP_OK);
    return body;
}

static int sleep_ball(ecp_world *w, double x, double z, double v)
{
    ecp_body_desc d = ecp_body_desc_default();
    ecp_shape shape;
    int body = -1;
    d.position[0] = (ecp_real)x;
    d.position[2] = (ecp_real)z;
    d.velocity[0] = (ecp_real)v;
    d.inertia[0] = d.inertia[4] = d.inertia[8] = ECP_R(0.004);
    CHECK(ecp_body_add(w, &d, &body) == ECP_OK);
    CHECK(ecp_shape_sphere(&shape, ECP_R(0.1)) == ECP_OK);
    CHECK(ecp_body_add_shape(w, body, &shape, NULL, NULL, NULL, NULL) == ECP_OK);
    return body;
}

/* Body 0 the ground, 1 to 3 a stack, 4 a box by itself, 5 a static table that carries box 6, 7 a
   kinematic plate that carries box 8. Shapes have the indices of their bodies. */
static ecp_world *sleep_room(void)
{
    ecp_world_desc d = ecp_world_desc_default();
    ecp_world *w;
    int i;
    d.max_bodies = 12;
    d.max_patches = 24;
    w = test_world(&d);
    test_ground(w, 0, 0, 1, NULL);
    for (i = 0; i < 3; i++) sleep_box(w, ECP_DYNAMIC, 0.01 * i, 0, 0.1 + 0.2 * i, 0.1);
    sleep_box(w, ECP_DYNAMIC, 2, 0, 0.1, 0.1);
    sleep_box(w, ECP_STATIC, 0, 3, 0.5, 0.1);
    sleep_box(w, ECP_DYNAMIC, 0.02, 3, 0.7, 0.1);
    sleep_box(w, ECP_KINEMATIC, 3, 3, 0.5, 0.1);
    sleep_box(w, ECP_DYNAMIC, 3, 3.03, 0.65, 0.05);
    return w;
}

/* ---- running both */

static sleep_run sleep_begin(ecp_world *(*build)(void))
{
    sleep_run run;
    int k;
    memset(&run, 0, sizeof run);
    for (k = 0; k < 2; k++) {
        run.w[k] = build();
        run.o[k] = ecp_options_default();
        run.o[k].sleep = k == 0;
    }
    run.h = ECP_R(0.01);
    return run;
}

static void sleep_end(sleep_run *run)
{
    free(run->w[0]);
    free(run->w[1]);
}

/* are all bits of the two worlds the same, but for what says who sleeps? */
static int sleep_same(const ecp_world *a, const ecp_world *b)
{
    size_t patches = (size_t)a->patches, most = (size_t)a->desc.max_inequalities;
    int i;
    if (a->bodies != b->bodies || a->patches != b->patches || a->last_h != b->last_h) return 0;
    for (i = 0; i < a->bodies; i++) {
        if (memcmp(ecp_i_bodies(a) + i, ecp_i_bodies(b) + i, offsetof(ecp_i_body, asleep)))
            return 0;
    }
    return !memcmp(ecp_i_patches(a), ecp_i_patches(b), patches * sizeof(ecp_i_patch)) &&
           !memcmp(ecp_i_multipliers(a, 0), ecp_i_multipliers(b, 0),
                   patches * most * sizeof(ecp_real));
}

/* steps of both; returns how many bodies the last one left out, -1 if the two have differed */
static int sleep_steps(sleep_run *run, int steps)
{
    int i, k;
    for (i = 0; i < steps; i++) {
        for (k = 0; k < 2; k++) {
            if (ecp_step(run->w[k], run->h, run->o + k, run->r + k) != ECP_OK) return -1;
        }
        if (!sleep_same(run->w[0], run->w[1])) return -1;
        CHECK(run->r[0].centred == run->r[1].centred);
    }
    CHECK(run->r[1].asleep == 0);
    CHECK(run->r[0].patches_kept == run->r[1].patches_kept);
    CHECK(run->r[0].patches_left_out == run->r[1].patches_left_out);
    CHECK_NEAR(run->r[0].worst_gap, run->r[1].worst_gap, 0);
    return run->r[0].asleep;
}

/* Does the event wake just so many of the room's six, in its own step? And do they all sleep again some
   steps later, but for `stays` of them? (-1: it depends on rounding whether a tilted box comes to rest
   to the last bit.) */
typedef void (*sleep_event)(ecp_world *w);

static void sleep_wakes(sleep_event event, int wakes, int stays, int line)
{
    sleep_run run = sleep_begin(sleep_room);
    int asleep = sleep_steps(&run, 20), k;
    test_check(asleep == 6, "the room sleeps", __FILE__, line);
    for (k = 0; k < 2; k++) event(run.w[k]);
    asleep = sleep_steps(&run, 1);
    test_check(asleep == 6 - wakes, "the event wakes as many as it should", __FILE__, line);
    asleep = sleep_steps(&run, 150);
    test_check(asleep == 6 - stays || (stays < 0 && asleep >= 5), "and they sleep again", __FILE__,
               line);
    sleep_end(&run);
}

#define WAKES(event, wakes, stays) sleep_wakes(event, wakes, stays, __LINE__)

/* ---- events */

static const ecp_real sleep_up[3] = {0, 0, ECP_R(3.0)}, sleep_aside[3] = {ECP_R(0.4), 0, 0};

static void nothing(ecp_world *w) { (void)w; }
static void force(ecp_world *w) { ecp_body_apply_force(w, 3, sleep_up, NULL); }
static void torque(ecp_world *w) { ecp_body_apply_torque(w, 4, sleep_aside); }
static void impulse(ecp_world *w) { ecp_body_apply_impulse(w, 4, sleep_aside, NULL); }
static void angular_impulse(ecp_world *w) { ecp_body_apply_angular_impulse(w, 6, sleep_aside); }
static void velocity(ecp_world *w) { ecp_body_set_state(w, 2, NULL, NULL, sleep_aside, NULL); }

static void lift(ecp_world *w)
{
    static const ecp_real at[3] = {0, 0, ECP_R(0.7)};
    ecp_body_set_state(w, 3, at, NULL, NULL, NULL);
}

static void tilt_table(ecp_world *w)
{
    static const ecp_real q[4] = {1, ECP_R(0.02), 0, 0};
    ecp_body_set_state(w, 5, NULL, q, NULL, NULL);
}

static void lower_table(ecp_world *w)
{
    static const ecp_real at[3] = {0, 3, ECP_R(0.4)};
    ecp_body_set_state(w, 5, at, NULL, NULL, NULL);
}

static void move_plate(ecp_world *w) { ecp_body_set_state(w, 7, NULL, NULL, sleep_aside, NULL); }
static void remove_table(ecp_world *w) { ecp_body_remove(w, 5); }
static void remove_lowest(ecp_world *w) { ecp_body_remove(w, 1); }
static void touch(ecp_world *w) { ecp_body_set_state(w, 2, NULL, NULL, NULL, NULL); }
/* loads of nothing, and the state, materials and filters that they have: what games say in every frame */
static void say_again(ecp_world *w)
{
    static const ecp_real zero[3] = {0, 0, 0};
    ecp_real x[3], q[4], v[3], turn[3];
    int i, shape;
    for (shape = 0; shape < w->shapes; shape++) {
        const ecp_i_part p = ecp_i_parts(w)[shape];
        ecp_shape_set_material(w, shape, &p.material);
        ecp_shape_set_filter(w, shape, p.category, p.collides_with);
    }
    for (i = 1; i <= 8; i++) {
        ecp_body_get_state(w, i, x, q, v, turn);
        ecp_body_set_state(w, i, x, q, i == 5 ? NULL : v, i == 5 ? NULL : turn);
        if (i == 5 || i == 7) continue;
        ecp_body_apply_force(w, i, zero, x);
        ecp_body_apply_angular_impulse(w, i, zero);
    }
}

static void fall_through(ecp_world *w) { ecp_shape_set_filter(w, 6, 2, 0xfffffffdu & 2u); }

static void table_lets_through(ecp_world *w) { ecp_shape_set_filter(w, 5, 0, 0); }

static void slippery(ecp_world *w, int shape)
{
    ecp_material m = ecp_material_default();
    m.mu = ECP_R(0.001);
    m.e_r = ECP_R(0.1);
    ecp_shape_set_material(w, shape, &m);
}

static void slippery_ground(ecp_world *w) { slippery(w, 0); }
static void slippery_box(ecp_world *w) { slippery(w, 2); }
static void slippery_table(ecp_world *w) { slippery(w, 5); }

static void gravity(ecp_world *w)
{
    static const ecp_real g[3] = {ECP_R(0.3), 0, ECP_R(-5.0)};
    ecp_world_set_gravity(w, g);
}

static void guess(ecp_world *w)
{
    static const ecp_real at[3] = {ECP_R(2.05), ECP_R(0.02), 0};
    ecp_guess_ecp(w, 4, 0, at);
}

/* a guess for two that do not touch changes nothing */
static void far_guess(ecp_world *w)
{
    static const ecp_real at[3] = {1, 1, 1};
    ecp_guess_ecp(w, 4, 6, at);
}

static void put_on_top(ecp_world *w) { sleep_box(w, ECP_DYNAMIC, 0, 0, 0.7, 0.1); }

/* the box by itself gets a foot that touches the ground */
static void add_foot(ecp_world *w)
{
    static const ecp_real at[3] = {ECP_R(0.05), 0, ECP_R(-0.08)};
    ecp_shape foot;
    ecp_shape_sphere(&foot, ECP_R(0.02));
    ecp_body_add_shape(w, 4, &foot, at, NULL, NULL, NULL);
}

static void test_sleep_events(void)
{
    WAKES(nothing, 0, 0);
    WAKES(say_again, 0, 0);
    WAKES(force, 3, 0);
    WAKES(torque, 1, 0);
    WAKES(impulse, 1, 0);
    WAKES(angular_impulse, 1, 0);
    WAKES(velocity, 3, 0);
    WAKES(lift, 3, 0);
    WAKES(touch, 3, 0);
    WAKES(tilt_table, 1, -1);
    WAKES(lower_table, 1, 0);
    WAKES(move_plate, 1, 1);
    WAKES(remove_table, 1, 0);
    WAKES(remove_lowest, 3, 1);
    WAKES(fall_through, 1, 1);
    WAKES(table_lets_through, 1, 0);
    WAKES(slippery_ground, 4, 0);
    WAKES(slippery_box, 3, 0);
    WAKES(slippery_table, 1, 0);
    WAKES(gravity, 6, 0);
    WAKES(guess, 1, 0);
    WAKES(far_guess, 2, 0);
    WAKES(put_on_top, 3, -1);
    WAKES(add_foot, 1, 0);
}

/* what a step is asked for */
static void test_sleep_asked(void)
{
    sleep_run run = sleep_begin(sleep_room);
    int k, change;
    CHECK(sleep_steps(&run, 20) == 6);
    for (change = 0; change < 5; change++) {
        for (k = 0; k < 2; k++) {
            if (change == 1) run.o[k].tolerance *= 2;
            if (change == 2) run.o[k].rule = ECP_NEAREST;
            if (change == 3) run.o[k].max_iterations++;
            if (change == 4) run.o[k].fallbacks &= ~ECP_FALLBACK_LOAD;
        }
        if (change == 0) run.h *= 2;
        CHECK(sleep_steps(&run, 1) == 0);
        CHECK(sleep_steps(&run, 20) == 6);
    }
    /* off and on again: flags are not believed that a step has not set */
    run.o[0].sleep = 0;
    CHECK(sleep_steps(&run, 1) == 0);
    run.o[0].sleep = 1;
    CHECK(sleep_steps(&run, 1) == 0);
    CHECK(sleep_steps(&run, 2) == 6);
    run.o[0].sleep = 2;
    CHECK(ecp_step(run.w[0], run.h, run.o, NULL) == ECP_BAD_OPTION);
    sleep_end(&run);
}

/* a load in every step, the same: the bodies come to rest under it, but the next step is without */
static void test_sleep_load(void)
{
    static const ecp_real push[3] = {1, ECP_R(0.5), 2};
    sleep_run run = sleep_begin(sleep_room);
    int i, k;
    CHECK(sleep_steps(&run, 20) == 6);
    for (i = 0; i < 20; i++) {
        for (k = 0; k < 2; k++) ecp_body_apply_force(run.w[k], 4, push, NULL);
        CHECK(sleep_steps(&run, 1) == 5);
    }
    CHECK(sleep_steps(&run, 1) == 5);
    CHECK(sleep_steps(&run, 10) == 6);
    sleep_end(&run);
}

/* ---- a ball hits a stack that sleeps, next to what it does not touch */

static ecp_world *sleep_thrown(void)
{
    ecp_world *w = sleep_room();
    sleep_ball(w, -5, 1.2, 6);
    return w;
}

static void test_sleep_ball(void)
{
    sleep_run run = sleep_begin(sleep_thrown);
    int k, asleep, slept = 0, hit = -1;
    for (k = 0; k < 600; k++) {
        asleep = sleep_steps(&run, 1);
        if (asleep < 0) break;
        if (hit < 0 && asleep == 6) slept++;
        if (slept > 20 && asleep == 3 && hit < 0) hit = k;
        if (hit >= 0 && k < hit + 30) CHECK(asleep >= 3);
    }
    CHECK(k == 600);
    CHECK(slept > 50 && hit > 60);
    sleep_end(&run);
}

/* a box too fast for its margin comes to rest against one that sleeps: the two meet within a step */
static void test_sleep_surprise(void)
{
    sleep_run run = sleep_begin(sleep_room);
    static const ecp_real push[3] = {ECP_R(-90.0), 0, 0}, up[3] = {0, 0, ECP_R(4.0)};
    int k, i;
    CHECK(sleep_steps(&run, 20) == 6);
    for (i = 0; i < 40; i++) {
        for (k = 0; k < 2; k++) {
            ecp_body_apply_impulse(run.w[k], i % 2 ? 4 : 2, i == 0 ? push : up, NULL);
        }
        CHECK(sleep_steps(&run, 10) >= 0);
    }
    sleep_end(&run);
}

static ecp_world *sleep_wall(void)
{
    ecp_world_desc d = ecp_world_desc_default();
    ecp_world *w;
    int i;
    d.max_bodies = 10;
    d.max_patches = 40;
    w = test_world(&d);
    test_ground(w, 0, 0, 1, NULL);
    for (i = 0; i < 9; i++) sleep_box(w, ECP_DYNAMIC, 0.2 * (i % 3), 0, 0.1 + 0.2 * (i / 3), 0.1);
    return w;
}

/* Boxes that touch at corners make no patch, nor do they while they sleep; but one of them that is pushed pushes them
   into each other, and in the same step they do. */
static void test_sleep_corners(void)
{
    static const ecp_real pushes[3][3] = {
        {ECP_R(0.3), 0, ECP_R(-0.6)}, {ECP_R(-0.9), ECP_R(0.3), 0}, {ECP_R(0.6), 0, ECP_R(0.3)}};
    int i, k, met = 0;
    for (i = 0; i < 27; i++) {
        sleep_run run = sleep_begin(sleep_wall);
        int kept;
        CHECK(sleep_steps(&run, 10) == 9);
        kept = run.r[0].patches_kept;
        for (k = 0; k < 2; k++)
            ecp_body_set_state(run.w[k], 1 + i / 3, NULL, NULL, pushes[i % 3], NULL);
        CHECK(sleep_steps(&run, 1) == 0);
        met += run.r[0].patches_kept > kept;
        sleep_end(&run);
    }
    CHECK(met > 0);
}

/* ---- sub-steps: where one island needs them the others are solved in the same parts */

static void test_sleep_substeps(void)
{
    sleep_run run = sleep_begin(sleep_thrown);
    int k;
    CHECK(sleep_steps(&run, 20) == 6);
    for (k = 0; k < 2; k++) {
        memset(run.r + k, 0, sizeof run.r[k]);
        CHECK(ecp_i_step_by_parts(run.w[k], run.h, run.o + k, 0, 0, run.r + k) == ECP_OK);
        CHECK(run.r[k].substeps == 2 && run.r[k].asleep == 0);
    }
    CHECK(sleep_same(run.w[0], run.w[1]));
    CHECK(sleep_steps(&run, 1) == 0);
    CHECK(sleep_steps(&run, 10) == 6);
    sleep_end(&run);
}

/* ---- worlds and events at random */

static ecp_world *sleep_heap(void)
{
    ecp_world_desc d = ecp_world_desc_default();
    ecp_world *w;
    int i;
    d.max_bodies = 14;
    d.max_patches = 60;
    w = test_world(&d);
    test_ground(w, 0, 0, 1, NULL);
    sleep_box(w, ECP_STATIC, 0.5, 0, 0.05, 0.05);
    for (i = 0; i < 7; i++) {
        double y = 0.02 * test_random(), x = 0.5 * (i % 3) + 0.02 * test_random();
        sleep_box(w, ECP_DYNAMIC, x, y, 0.15 + 0.25 * (i / 3), i % 2 ? 0.1 : 0.05);
    }
    return w;
}

static void sleep_chance(ecp_world *w, double what, double x)
{
    ecp_real v[3] = {0, 0, 0};
    int body = 1 + (int)(4 * (1 + x));
    v[0] = (ecp_real)x;
    v[2] = (ecp_real)(1 + x);
    if (what < -0.7) {
        ecp_body_remove(w, body);
    } else if (what < -0.4) {
        sleep_box(w, ECP_DYNAMIC, x, 0, 1.2, 0.1);
    } else if (what < -0.1) {
        ecp_body_apply_impulse(w, body, v, NULL);
    } else if (what < 0.2) {
        ecp_body_apply_force(w, body, v, NULL);
    } else if (what < 0.4) {
        ecp_body_set_state(w, body, NULL, NULL, NULL, v);
    } else if (what < 0.6) {
        ecp_shape_set_filter(w, body, x < 0 ? 1u : 3u, x < -0.5 ? 2u : 3u);
    } else if (what < 0.8) {
        sleep_ball(w, -1, 0.3, 3 * x);
    }
}

static void test_sleep_random(void)
{
    unsigned seed = test_seed;
    int trial, i, k, asleep, slept = 0, woken = 0;
    for (trial = 0; trial < 12; trial++) {
        sleep_run run;
        ecp_world *twin;
        run = sleep_begin(sleep_heap);
        /* the second world is a copy: the heap was made from other random numbers */
        twin = run.w[1];
        memcpy(twin, run.w[0], run.w[0]->bytes);
        for (i = 0; i < 10; i++) {
            double what = test_random(), x = test_random();
            asleep = sleep_steps(&run, 60);
            CHECK(asleep >= 0);
            if (asleep < 0) break;
            slept += asleep > 0;
            for (k = 0; k < 2; k++) {
                int failed = test_failed;
                sleep_chance(run.w[k], what, x);
                test_failed = failed; /* a full world takes no more bodies */
            }
            k = sleep_steps(&run, 1);
            woken += k >= 0 && k < asleep;
        }
        sleep_end(&run);
    }
    CHECK(slept > 40 && woken > 10); /* what there was to compare */
    test_seed = seed;
}

/* ---- the rest */

/* contacts of bodies that sleep carry their weight; a snapshot sleeps on; a failed step changes
   neither state nor sleep */
static void test_sleep_contacts(void)
{
    sleep_run run = sleep_begin(sleep_room);
    ecp_contact c;
    double sum = 0;
    size_t bytes;
    ecp_world *copy;
    ecp_options hard;
    static const ecp_real fast[3] = {3, 4, -5};
    int i;
    CHECK(sleep_steps(&run, 20) == 6);
    for (i = 0; i < ecp_contact_count(run.w[0]); i++) {
        CHECK(ecp_contact_get(run.w[0], i, &c) == ECP_OK);
        CHECK(c.mode == ECP_STICK);
        if (c.body_b == 0 || c.body_a == 0) sum += (double)c.p_n;
    }
    CHECK_NEAR(sum, 4 * 9.8 * 0.01, test_by(1e-12, 1e-5));
    CHECK(run.r[0].unknowns == 0 && run.r[0].islands == 0 && run.r[0].evaluations == 0);
    CHECK(run.r[0].centred == 1);
    bytes = run.w[0]->bytes;
    copy = (ecp_world *)malloc(bytes);
    memcpy(copy, run.w[0], bytes);
    CHECK(ecp_step(copy, run.h, run.o, run.r) == ECP_OK && run.r[0].asleep == 6);
    CHECK(memcmp(copy, run.w[0], bytes) == 0);
    /* box 4 cannot be solved, the others sleep */
    ecp_body_set_state(copy, 4, NULL, NULL, NULL, fast);
    memcpy(run.w[0], copy, bytes);
    hard = run.o[0];
    hard.max_iterations = 1;
    hard.fallbacks = 0;
    hard.tolerance /= 100;
    CHECK(ecp_step(copy, run.h, &hard, run.r) == ECP_NOT_SOLVED);
    CHECK(memcmp(copy, run.w[0], bytes) == 0);
    CHECK(ecp_step(copy, run.h, run.o, run.r) == ECP_OK && run.r[0].asleep == 5);
    free(copy);
    sleep_end(&run);
}

/* A box on an incline, along it or askew: no number is round, and it rests in every bit all the same. */
static void sleep_on_incline(double degrees, double yaw)
{
    const double down = degrees * 3.14159265358979323846 / 180;
    double s = sin(down / 2), c = cos(down / 2), yaw_s = sin(yaw / 2), yaw_c = cos(yaw / 2);
    ecp_real x[3], q[4], v[3], w[3];
    ecp_world *world = test_world(NULL);
    ecp_options o = ecp_options_default();
    ecp_report r;
    int i;
    o.sleep = 1;
    test_ground(world, sin(down), 0, cos(down), NULL);
    sleep_box(world, ECP_DYNAMIC, 0.1 * sin(down), 0, 0.1 * cos(down), 0.1);
    q[0] = (ecp_real)(c * yaw_c);
    q[1] = (ecp_real)(s * yaw_s);
    q[2] = (ecp_real)(s * yaw_c);
    q[3] = (ecp_real)(c * yaw_s);
    ecp_body_set_state(world, 1, NULL, q, NULL, NULL);
    for (i = 0; i < 40; i++) CHECK(ecp_step(world, ECP_R(0.01), &o, &r) == ECP_OK);
    CHECK(r.asleep == 1);
    ecp_body_get_state(world, 1, x, NULL, v, w);
    for (i = 0; i < 3; i++) CHECK(v[i] == 0 && w[i] == 0);
    CHECK_NEAR((double)x[0] * sin(down) + (double)x[2] * cos(down), 0.1, test_by(1e-15, 1e-7));
    CHECK_NEAR(x[1], 0, test_by(1e-15, 1e-7));
    free(world);
}

static void test_sleep_incline(void)
{
    int k;
    for (k = 0; k < 26; k++) sleep_on_incline(1 + k / 2 * 2, k % 2 ? 0.7 : 0);
}

/* Pushed and turned at random, boxes and cylinders come to rest in every bit, each by itself: no residual
   that rounding floors let pass keeps them moving to and fro. */
static void test_sleep_pushed(void)
{
    static const ecp_real half[3] = {ECP_R(0.1), ECP_R(0.1), ECP_R(0.1)};
    static const ecp_real up[3] = {0, 0, 1};
    int k, i;
    test_seed = 5;
    for (k = 0; k < 40; k++) {
        ecp_world *w = test_world(NULL);
        ecp_options o = ecp_options_default();
        ecp_report r;
        ecp_real p[3], turn[3];
        ecp_body_desc d = ecp_body_desc_default();
        ecp_material m = ecp_material_default();
        ecp_shape shape;
        int body;
        o.sleep = 1;
        m.mu = ECP_R(0.5);
        m.e_t = m.e_o = 1;
        m.e_r = ECP_R(0.05);
        d.kind = ECP_STATIC;
        CHECK(ecp_body_add(w, &d, &body) == ECP_OK);
        CHECK(ecp_shape_half_space(&shape, up, 0) == ECP_OK);
        CHECK(ecp_body_add_shape(w, body, &shape, NULL, NULL, &m, NULL) == ECP_OK);
        d.kind = ECP_DYNAMIC;
        d.position[0] = 2;
        d.position[2] = ECP_R(0.1);
        d.inertia[0] = d.inertia[4] = d.inertia[8] = ECP_R(0.006);
        CHECK(ecp_body_add(w, &d, &body) == ECP_OK);
        if (k % 2)
            CHECK(ecp_shape_box(&shape, half) == ECP_OK);
        else
            CHECK(ecp_shape_cylinder(&shape, ECP_R(0.1), ECP_R(0.1)) == ECP_OK);
        CHECK(ecp_body_add_shape(w, body, &shape, NULL, NULL, &m, NULL) == ECP_OK);
        for (i = 0; i < 3; i++) {
            p[i] = (ecp_real)(0.3 * test_random());
            turn[i] = (ecp_real)(0.01 * test_random());
        }
        if (p[2] < 0) p[2] = -p[2];
        ecp_body_apply_impulse(w, body, p, NULL);
        ecp_body_apply_angular_impulse(w, body, turn);
        for (i = 0; i < 200; i++) CHECK(ecp_step(w, ECP_R(0.01), &o, &r) == ECP_OK);
        CHECK(r.asleep == 1);
        free(w);
    }
}

/* at rest without gravity, without any patch; and no sleep in free flight or free spin */
static void test_sleep_space(void)
{
    static const ecp_real none[3] = {0, 0, 0}, v[3] = {1, 0, 0};
    ecp_world *w = test_world(NULL);
    ecp_options o = ecp_options_default();
    ecp_report r;
    int i;
    o.sleep = 1;
    ecp_world_set_gravity(w, none);
    for (i = 0; i < 3; i++) sleep_box(w, ECP_DYNAMIC, i, 0, 0, 0.1);
    ecp_body_set_state(w, 1, NULL, NULL, v, NULL);
    ecp_body_set_state(w, 2, NULL, NULL, NULL, v);
    for (i = 0; i < 4; i++) CHECK(ecp_step(w, ECP_R(0.01), &o, &r) == ECP_OK);
    CHECK(r.asleep == 1 && r.largest_turn > 0);
    free(w);
}

/* Boxes of any shape, dropped on the ground in any pose, end on a face and sleep there: an angle of half a
   rounding error must not go to and fro (the floor of ecp_i_block_fill). Without torsion they would spin. */
static void test_sleep_tossed(void)
{
    ecp_world_desc d = ecp_world_desc_default();
    ecp_material m = ecp_material_default();
    ecp_options o = ecp_options_default();
    ecp_report r;
    int run, i, k, asleep = 0;
    d.max_bodies = d.max_shapes = 11;
    d.max_patches = 40;
    d.max_inequalities = 12;
    m.e_r = ECP_R(0.05);
    o.sleep = 1;
    for (run = 0; run < 4; run++) {
        ecp_world *w = test_world(&d);
        ecp_body_desc b = ecp_body_desc_default();
        ecp_shape box;
        test_ground(w, 0, 0, 1, &m);
        for (i = 0; i < 10; i++) {
            ecp_real half[3];
            ecp_mass mass;
            int body = -1;
            for (k = 0; k < 3; k++) half[k] = (ecp_real)(0.15 + 0.1 * test_random());
            for (k = 0; k < 4; k++) b.rotation[k] = (ecp_real)test_random();
            b.position[0] = (ecp_real)(2 * i);
            b.position[2] = (ecp_real)(1 + 0.5 * test_random());
            CHECK(ecp_shape_box(&box, half) == ECP_OK);
            ecp_shape_mass(&box, 500, &mass);
            b.mass = mass.mass;
            for (k = 0; k < 9; k++) b.inertia[k] = mass.inertia[k];
            CHECK(ecp_body_add(w, &b, &body) == ECP_OK);
            CHECK(ecp_body_add_shape(w, body, &box, NULL, NULL, &m, NULL) == ECP_OK);
        }
        for (i = 0; i < 900; i++) CHECK(ecp_step(w, (ecp_real)(1 / 240.0), &o, &r) == ECP_OK);
        asleep += r.asleep;
        free(w);
    }
    CHECK(asleep >= 39);
}

/* What rolls keeps its speed, however slowly it rolls: where a surface is curved the floor that lets
   boxes sleep would shift the ECP, and its moment be a brake. */
static void test_sleep_slow_ball(void)
{
    static const double speeds[] = {1e-6, 1e-5, 1e-4}, steps[] = {1e-2, 1e-3, 1e-4};
    ecp_material m = ecp_material_default();
    ecp_options o = ecp_options_default();
    ecp_report r;
    int i, j, k;
    m.mu = ECP_R(0.5);
    m.e_r = 0;
    o.sleep = 1;
    for (i = 0; i < 9; i++) {
        ecp_world *w = test_world(NULL);
        ecp_body_desc b = ecp_body_desc_default();
        ecp_real v[3], v0 = (ecp_real)speeds[i / 3];
        ecp_shape ball;
        int body = -1;
        test_ground(w, 0, 0, 1, &m);
        b.position[2] = ECP_R(0.1);
        b.velocity[0] = v0;
        b.angular_velocity[1] = v0 / ECP_R(0.1);
        for (j = 0; j < 9; j += 4) b.inertia[j] = ECP_R(0.004);
        CHECK(ecp_shape_sphere(&ball, ECP_R(0.1)) == ECP_OK);
        CHECK(ecp_body_add(w, &b, &body) == ECP_OK);
        CHECK(ecp_body_add_shape(w, body, &ball, NULL, NULL, &m, NULL) == ECP_OK);
        for (k = 0; k < 300; k++) CHECK(ecp_step(w, (ecp_real)steps[i % 3], &o, &r) == ECP_OK);
        ecp_body_get_state(w, body, NULL, NULL, v, NULL);
        CHECK(v[0] >= ECP_R(0.9999) * v0 && v[0] <= ECP_R(1.0001) * v0);
        free(w);
    }
}

static void test_sleep(void)
{
    test_sleep_events();
    test_sleep_asked();
    test_sleep_load();
    test_sleep_ball();
    test_sleep_surprise();
    test_sleep_corners();
    test_sleep_substeps();
    test_sleep_random();
    test_sleep_contacts();
    test_sleep_incline();
    test_sleep_space();
    test_sleep_pushed();
    test_sleep_tossed();
    test_sleep_slow_ball();
}
