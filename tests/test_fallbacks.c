/* Each fallback on a step that plain Newton does not solve and it does. The steps are dumps of ecp_dump,
   from `make stress`, in which options.fallbacks was made a variable (of one, the bound on iterations too). */

static int fallbacks_of_the_step;

#ifndef ECPSIM_FLOAT

static int iterations_of_the_step;

#include "fallbacks/geometric.inc"
#include "fallbacks/continuation.inc"
#include "fallbacks/multistart.inc"
#include "fallbacks/substeps.inc"
#include "fallbacks/sticking.inc"
#include "fallbacks/strides.inc"
#include "fallbacks/rival.inc"
#include "fallbacks/chord.inc"
#include "fallbacks/light.inc"
#include "fallbacks/work.inc"
#include "fallbacks/anyhow.inc"
#include "fallbacks/heavy.inc"
#include "fallbacks/wedge.inc"
#include "fallbacks/turned.inc"
#include "fallbacks/swung.inc"
#include "fallbacks/held.inc"
#include "fallbacks/bounded.inc"

typedef ecp_status dumped(ecp_world **world, ecp_report *report);

static ecp_status step_with(dumped *step, int fallbacks, ecp_report *r)
{
    ecp_world *world = NULL;
    ecp_status status;
    fallbacks_of_the_step = fallbacks;
    status = step(&world, r);
    free(world);
    return status;
}

static void check_fallback(dumped *step, int fallback)
{
    ecp_report r;
    CHECK(step_with(step, 0, &r) == ECP_NOT_SOLVED);
    CHECK(r.fallbacks == 0 && r.substeps == 1);
    CHECK(step_with(step, fallback, &r) == ECP_OK);
    CHECK(r.fallbacks == fallback);
    CHECK(r.worst_gap >= -1e-12);
    CHECK(step_with(step, ecp_options_default().fallbacks, &r) == ECP_OK);
    CHECK(r.fallbacks != 0);
}

/* A step that ends in the midst of its parts, as its iterations do, leaves the world as it was. */
static void test_fallbacks_restore(void)
{
    ecp_world *w = NULL, *before;
    ecp_options o = ecp_options_default();
    ecp_report r;
    int most, parts = 0;
    fallbacks_of_the_step = 0;
    CHECK(step_substeps(&w, &r) == ECP_NOT_SOLVED);
    before = (ecp_world *)malloc(w->bytes);
    memcpy(before, w, w->bytes);
    o.fallbacks = ECP_FALLBACK_SUBSTEPS;
    for (most = 20; most < 200; most++) {
        o.max_total_iterations = most;
        memcpy(w, before, before->bytes);
        if (ecp_step(w, ECP_R(0.1), &o, &r) == ECP_OK) break;
        CHECK(memcmp(w, before, before->bytes) == 0);
        parts += (r.fallbacks & ECP_FALLBACK_SUBSTEPS) != 0;
    }
    CHECK(parts > 0 && r.status == ECP_OK && r.substeps > 1);
    free(before);
    free(w);
}

/* Newton alone from the velocities as they were, where those that balance the last step's impulses lead
   nowhere (ecp_i_better_start) */
static void test_fallbacks_rival(void)
{
    ecp_report r;
    CHECK(step_with(step_rival, 0, &r) == ECP_OK);
    CHECK(r.fallbacks == 0 && r.substeps == 1 && r.worst_gap >= -1e-12);
}

/* Newton alone where the line search takes no part of a damped step: along the drift of the impulses
   (ecp_i_take_stride) */
static void test_fallbacks_strides(void)
{
    ecp_report r;
    CHECK(step_with(step_strides, 0, &r) == ECP_OK);
    CHECK(r.fallbacks == 0 && r.worst_gap >= -1e-12);
}

/* Newton finds from slipping to sticking under a load of 5e-4 of the momenta in play: rho of its steps is
   that load (ecp_i_rho); with that of the residual it would not */
static void test_fallbacks_sticking(void)
{
    ecp_world *w = NULL;
    ecp_report r;
    ecp_contact c;
    ecp_real x[3], v[3], spin[3];
    double friction;
    fallbacks_of_the_step = 0;
    CHECK(step_sticking(&w, &r) == ECP_OK);
    CHECK(r.fallbacks == 0 && r.iterations <= 12);
    CHECK(ecp_contact_count(w) == 1);
    CHECK(ecp_contact_get(w, 0, &c) == ECP_OK && c.mode == ECP_STICK);
    CHECK(ecp_body_get_state(w, 1, x, NULL, v, spin) == ECP_OK);
    friction = sqrt(v[0] * v[0] + v[1] * v[1]) / (spin[2] * x[2]);
    CHECK(friction > 0.85 && friction < 0.9);
    CHECK_NEAR(sqrt(c.p_t * c.p_t + c.p_o * c.p_o) / c.p_n, friction, 1e-8);
    free(w);
}

/* A body wedged between two planes: with the slip at the end of the step nothing leads to a solution
   (docs/numerics.md, Slip along the chord); along the chord one is found, in which it sticks to one plane and
   slides on the other. */
static void test_fallbacks_chord(void)
{
    ecp_world *w = NULL;
    ecp_report r;
    ecp_contact c;
    int i, modes[3] = {0, 0, 0};
    CHECK(step_with(step_chord, ecp_options_default().fallbacks & ~ECP_FALLBACK_CHORD, &r) ==
          ECP_NOT_SOLVED);
    fallbacks_of_the_step = ECP_FALLBACK_CHORD;
    CHECK(step_chord(&w, &r) == ECP_OK);
    CHECK(r.natural_residual <= 1e-12 && r.substeps == 1);
    for (i = 0; i < ecp_contact_count(w); i++) {
        CHECK(ecp_contact_get(w, i, &c) == ECP_OK);
        modes[c.mode]++;
        CHECK(c.mode == ECP_APART || c.p_n > 0);
    }
    CHECK(modes[ECP_STICK] == 1 && modes[ECP_SLIP] == 1);
    free(w);
}

/* A ball of 1 g between boxes of 100 kg: rho goes by what the ball can take (ecp_i_rho). By the load alone its spin goes
   to and fro between slipping one way and slipping the other, and no fallback helps. */
static void test_fallbacks_light(void)
{
    ecp_report r;
    CHECK(step_with(step_light, ECP_FALLBACK_GEOMETRIC, &r) == ECP_OK);
    CHECK(r.iterations < 1000 && r.natural_residual <= 1e-12);
}

/* A frustum that rolls at 0.1 m/s comes to rest on its side within the step of 0.1 s, or is thrown up with 23 rad/s: a
   solution far away, whole and exact, which Newton takes if sub-steps may not be used. In parts it rests. Under
   a bound the solution is the one or the other: the better one as soon as its iterations fit beside twice those of the
   first, which is solved once more if they do not. None is lost by a larger bound. (The last iteration of the first
   takes rounding off a solution: it is one without.) */
static void test_fallbacks_work(void)
{
    ecp_world *w = NULL;
    ecp_report r;
    ecp_real spin[3] = {0, 0, 0};
    int bound, first, solved, again = 0, better = 0;
    fallbacks_of_the_step = 0;
    CHECK(step_work(&w, &r) == ECP_OK);
    CHECK(ecp_body_get_state(w, 1, NULL, NULL, NULL, spin) == ECP_OK);
    CHECK(r.substeps == 1 && r.work > 0.8 && r.natural_residual <= 1e-12 && ecp_i_norm(spin) > 22);
    first = r.iterations;
    free(w);
    fallbacks_of_the_step = ECP_FALLBACK_SUBSTEPS;
    CHECK(step_work(&w, &r) == ECP_OK && r.fallbacks == ECP_FALLBACK_SUBSTEPS);
    CHECK(ecp_body_get_state(w, 1, NULL, NULL, NULL, spin) == ECP_OK);
    CHECK(r.substeps > 1 && r.work < 0.01); /* the most of any part: more is given up */
    CHECK(ecp_i_norm(spin) < 1e-6);
    free(w);
    for (bound = 1; bound < 1000; bound += bound < 300 ? 1 : 50) {
        iterations_of_the_step = bound;
        solved = step_work(&w, &r) == ECP_OK;
        CHECK(r.iterations <= bound && (solved || bound < first) && !(solved && bound < first - 1));
        CHECK(ecp_body_get_state(w, 1, NULL, NULL, NULL, spin) == ECP_OK);
        free(w);
        if (!solved) continue;
        CHECK(bound > 2 * first || (r.fallbacks == 0 && r.iterations <= first));
        CHECK(better == 0 || r.work < 0.01);
        if (r.work < 0.01) {
            CHECK(r.substeps > 1 && ecp_i_norm(spin) < 1e-6);
            better++;
        } else {
            CHECK(r.substeps == 1 && r.work > 0.8 && ecp_i_norm(spin) > 22);
            again += r.fallbacks != 0;
        }
    }
    CHECK(again > 0 && better > 0);
    iterations_of_the_step = 0;
}

/* An ellipsoid of 4 um that turns by 13 radians in the step: its contact wins energy in all the sub-steps that
   are tried as well. Then it is let, in the whole step, with the bits that it has without sub-steps. */
static void test_fallbacks_anyhow(void)
{
    ecp_world *w[2];
    ecp_report r[2];
    int k;
    for (k = 0; k < 2; k++) {
        fallbacks_of_the_step = k ? ECP_FALLBACK_SUBSTEPS : 0;
        CHECK(step_anyhow(w + k, r + k) == ECP_OK);
        CHECK(r[k].fallbacks == fallbacks_of_the_step && r[k].substeps == 1 && r[k].work > 0.7);
    }
    CHECK(r[1].iterations > 3 * r[0].iterations);
    CHECK(!memcmp(ecp_i_bodies(w[0]), ecp_i_bodies(w[1]), 2 * sizeof(ecp_i_body)));
    free(w[0]);
    free(w[1]);
}

static ecp_real kinetic_energy(const ecp_world *w, int body)
{
    const ecp_i_body *b = ecp_i_bodies(w) + body;
    ecp_real R[9], own[3], L[3];
    ecp_quat_to_matrix(b->q, R);
    ecp_i_mul_t(R, b->v + 3, own);
    ecp_i_mul(b->inertia, own, L);
    return (b->mass * ecp_i_dot(b->v, b->v) + ecp_i_dot(own, L)) / 2;
}

/* A plate of 10 kg comes down on a cube of 10 g that slides at 6 m/s. In the whole step it shoots the cube out: 2 J are
   won of 1.3 J, which is little beside the plate's mass and the cube's speed (ecp_i_most_energy). In parts none are. */
static void test_fallbacks_heavy(void)
{
    ecp_report r;
    int k;
    for (k = 0; k < 2; k++) {
        ecp_world *w = NULL;
        ecp_real energy;
        fallbacks_of_the_step = ecp_options_default().fallbacks;
        if (k == 0) fallbacks_of_the_step &= ~ECP_FALLBACK_SUBSTEPS;
        CHECK(step_heavy(&w, &r) == ECP_OK);
        energy = kinetic_energy(w, 1) + kinetic_energy(w, 2);
        CHECK(k ? energy < 1.32 && r.substeps > 1 && r.work < 0.1
                : energy > 3 && r.substeps == 1 && r.work > 0.1);
        free(w);
    }
}

/* A capsule of 18 g hits a fixed plate at 94 m/s, 79 J, and takes sub-steps, some of which win 13 J in the middle. The
   report has the worst of them, not the last, where the bound on the iterations leaves none to do better; where it
   does none is won. */
static void test_fallbacks_bounded(void)
{
    ecp_real energy;
    ecp_report r;
    double bound;
    int won = 0, kept = 0;
    fallbacks_of_the_step = ecp_options_default().fallbacks;
    for (bound = 1000; bound < 10000; bound *= 1.1) {
        ecp_world *w = NULL;
        iterations_of_the_step = (int)bound;
        if (step_bounded(&w, &r) == ECP_OK) {
            energy = kinetic_energy(w, 2);
            won += energy > 79.5;
            kept += energy < 36;
            CHECK(r.substeps > 1);
            CHECK(energy > 79.5 ? r.work > 0.04 && kept == 0 : r.work < 0.01);
        } else {
            CHECK(won + kept == 0);
        }
        free(w);
    }
    CHECK(kept > 5);
    if (sizeof(ecp_real) == 8) CHECK(won > 0);
    iterations_of_the_step = 0;
    {
        ecp_world *w = NULL;
        CHECK(step_bounded(&w, &r) == ECP_OK && r.substeps > 1);
        CHECK(r.work < 0.01 && kinetic_energy(w, 2) < 36);
        free(w);
    }
}

/* What rolls in a groove with friction of 1.2 is shot out at hundreds of m/s by all solutions that are found for the
   printed slip, in parts as well, if any is. Along the chord it is held. */
static void test_fallbacks_wedge(void)
{
    ecp_world *w = NULL;
    ecp_report r;
    ecp_status status;
    ecp_real v[3] = {0, 0, 0};
    int k;
    for (k = 0; k < 2; k++) {
        fallbacks_of_the_step = ecp_options_default().fallbacks;
        if (k == 0) fallbacks_of_the_step &= ~ECP_FALLBACK_CHORD;
        status = step_wedge(&w, &r);
        CHECK(ecp_body_get_state(w, 3, NULL, NULL, v, NULL) == ECP_OK);
        CHECK(k ? status == ECP_OK && r.natural_residual <= 1e-11 && r.work < 0.1 &&
                      ecp_i_norm(v) < 2
                : status == ECP_NOT_SOLVED || (r.work > 0.9 && ecp_i_norm(v) > 100));
        CHECK(((r.fallbacks & ECP_FALLBACK_CHORD) != 0) == k);
        free(w);
    }
}

/* On the way to the solution normals come within 1e-3 of what fixes the tangents, and leave it again. In one step friction
   is anisotropic, and along x of the shapes in the end; in the other one centring comes there and fails, and the
   solution that it leaves as it was has the friction that it had (ecp_i_tangents). */
static void test_fallbacks_tangents(void)
{
    ecp_world *w = NULL;
    ecp_report r;
    int i, k, loaded = 0;
    fallbacks_of_the_step = ecp_options_default().fallbacks;
    CHECK(step_turned(&w, &r) == ECP_OK && r.natural_residual <= 1e-12);
    for (i = 0; i < ecp_contact_count(w); i++) {
        ecp_contact c;
        ecp_real R[9], along[3], t[3];
        CHECK(ecp_contact_get(w, i, &c) == ECP_OK);
        if (c.mode == ECP_APART) continue;
        loaded++;
        /* (as the shape was when the step began, up to what it turns) */
        CHECK(ecp_shape_get(w, c.shape_a == 0 ? c.shape_b : c.shape_a, NULL, NULL, NULL, R) ==
              ECP_OK);
        for (k = 0; k < 3; k++) along[k] = R[3 * k];
        ecp_i_axpy(along, -ecp_i_dot(along, c.normal), c.normal, along);
        ecp_i_copy3(along, t);
        ecp_i_normalise(t);
        CHECK(fabs((double)ecp_i_dot(t, c.direction_t)) > 0.9);
    }
    CHECK(loaded == 4);
    free(w);
    CHECK(step_swung(&w, &r) == ECP_OK && r.natural_residual <= 1e-12);
    free(w);
}

/* Friction that centring holds on its limit leaves one solution, 0.3 % from that limit: centred once the step has gone
   there, not before. */
static void test_fallbacks_held(void)
{
    ecp_world *w = NULL;
    ecp_contact c;
    ecp_report r;
    CHECK(step_held(&w, &r) == ECP_OK);
    CHECK(ecp_contact_get(w, 1, &c) == ECP_OK && c.p_n > 0);
    CHECK(!r.centred || fabs(sqrt(c.p_t * c.p_t + c.p_o * c.p_o) / (c.mu * c.p_n) - 1) < 1e-9);
    free(w);
}

static void test_fallbacks(void)
{
    ecp_report r;
    check_fallback(step_geometric, ECP_FALLBACK_GEOMETRIC);
    check_fallback(step_continuation, ECP_FALLBACK_CONTINUATION);
    check_fallback(step_multistart, ECP_FALLBACK_MULTISTART);
    check_fallback(step_multistart, ECP_FALLBACK_LOAD); /* solves that one, too */
    check_fallback(step_substeps, ECP_FALLBACK_SUBSTEPS);
    check_fallback(step_chord, ECP_FALLBACK_CHORD);
    step_with(step_substeps, ECP_FALLBACK_SUBSTEPS, &r);
    CHECK(r.substeps > 1);
    test_fallbacks_restore();
    test_fallbacks_sticking();
    test_fallbacks_rival();
    test_fallbacks_strides();
    test_fallbacks_chord();
    test_fallbacks_light();
    test_fallbacks_work();
    test_fallbacks_anyhow();
    test_fallbacks_heavy();
    test_fallbacks_bounded();
    test_fallbacks_wedge();
    test_fallbacks_tangents();
    test_fallbacks_held();
}

#else

#include "fallbacks/loose.inc"
#include "fallbacks/rails.inc"

/* No fallback, but a pair that is left out: where rounding of a large primitive ends the search for the direction between
   two, the last one it had says nothing. This one let a box into a rail by 3 mm. */
static void test_fallbacks_rails(void)
{
    ecp_world *w = NULL;
    ecp_contact c;
    ecp_report r;
    CHECK(step_rails(&w, &r) == ECP_OK);
    CHECK(ecp_contact_count(w) > 0 && ecp_contact_get(w, 0, &c) == ECP_OK);
    CHECK(c.p_n > 100 && c.separation > -ECP_R(1e-5));
    free(w);
}

/* Normals can not be held to rounding here by any start; held to the tolerance they can, with neither the chord nor
   sub-steps (ecp_i_geometry_error). The other steps are hard in double only. */
static void test_fallbacks(void)
{
    ecp_world *w = NULL;
    ecp_report r;
    fallbacks_of_the_step = ECP_FALLBACK_GEOMETRIC | ECP_FALLBACK_CONTINUATION |
                            ECP_FALLBACK_MULTISTART | ECP_FALLBACK_LOAD;
    CHECK(step_loose(&w, &r) == ECP_OK);
    CHECK(r.fallbacks == fallbacks_of_the_step);
    free(w);
    test_fallbacks_rails();
}

#endif
