/* Each fallback on a step that plain Newton does not solve and it does. The steps are dumps of ecp_dump,
   from `make stress`, in which options.fallbacks was made a variable. */

#ifndef ECPSIM_FLOAT

static int fallbacks_of_the_step;

#include "fallbacks/geometric.inc"
#include "fallbacks/continuation.inc"
#include "fallbacks/multistart.inc"
#include "fallbacks/load.inc"
#include "fallbacks/substeps.inc"
#include "fallbacks/sticking.inc"
#include "fallbacks/chord.inc"
#include "fallbacks/work.inc"

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

/* A solution in which the plate shoots out from between the boxes: whole, and exact, if sub-steps may not be
   used; with them the step is made in two, and nothing moves much. */
static void test_fallbacks_work(void)
{
    static const int without = ECP_FALLBACK_GEOMETRIC | ECP_FALLBACK_CONTINUATION;
    ecp_world *w = NULL;
    ecp_report r;
    ecp_real v[3] = {0, 0, 0};
    int k;
    for (k = 0; k < 2; k++) {
        fallbacks_of_the_step = k == 0 ? without : without | ECP_FALLBACK_SUBSTEPS;
        CHECK(step_work(&w, &r) == ECP_OK);
        CHECK(ecp_body_get_state(w, 2, NULL, NULL, v, NULL) == ECP_OK);
        if (k == 0) {
            CHECK(r.substeps == 1 && r.work > 1 && ecp_i_norm(v) > 20);
        } else {
            CHECK(r.substeps == 2 && r.work < 0.01 && ecp_i_norm(v) < 0.1);
            CHECK(r.fallbacks & ECP_FALLBACK_SUBSTEPS);
        }
        free(w);
    }
}

/* A ball between two plates that close on it, 1 cm or 3 cm off their middle. Rigid, it can only jump out to the side, which
   takes more energy than all that moves has; in shorter steps more still. So the step is taken as it comes
   after all. Nearer to the edge the plates squeeze it out: it slips along them, and wins nothing from that. */
static void test_fallbacks_squeeze(void)
{
    static const double aside[3] = {0.01, 0.03, 0.045};
    ecp_shape plate, ball;
    int i, k;
    const ecp_real half[3] = {ECP_R(0.05), ECP_R(0.05), ECP_R(0.01)};
    CHECK(ecp_shape_box(&plate, half) == ECP_OK && ecp_shape_sphere(&ball, ECP_R(0.05)) == ECP_OK);
    for (i = 0; i < 3; i++) {
        ecp_world_desc d = ecp_world_desc_default();
        ecp_body_desc b = ecp_body_desc_default();
        ecp_world *w;
        ecp_report r;
        ecp_real v[3] = {0, 0, 0};
        d.gravity[2] = 0;
        w = test_world(&d);
        b.kind = ECP_KINEMATIC;
        for (k = 0; k < 2; k++) {
            b.position[2] = ECP_R(0.12) * (ecp_real)k - ECP_R(0.06);
            b.velocity[2] = (ecp_real)(1 - 2 * k);
            CHECK(ecp_body_add(w, &b, NULL) == ECP_OK);
            CHECK(ecp_body_add_shape(w, k, &plate, NULL, NULL, NULL, NULL) == ECP_OK);
        }
        b = ecp_body_desc_default();
        b.mass = ECP_R(0.5);
        for (k = 0; k < 9; k += 4) b.inertia[k] = ECP_R(0.0005);
        b.position[0] = (ecp_real)aside[i];
        b.position[1] = ECP_R(0.001);
        CHECK(ecp_body_add(w, &b, NULL) == ECP_OK);
        CHECK(ecp_body_add_shape(w, 2, &ball, NULL, NULL, NULL, NULL) == ECP_OK);
        CHECK(ecp_step(w, ECP_R(0.01), NULL, &r) == ECP_OK && r.substeps == 1);
        CHECK(ecp_body_get_state(w, 2, NULL, NULL, v, NULL) == ECP_OK && ecp_i_norm(v) > 3);
        CHECK((r.work > 1) == (i < 2) && (r.work <= 0) == (i == 2));
        CHECK(((r.fallbacks & ECP_FALLBACK_SUBSTEPS) != 0) == (i < 2));
        free(w);
    }
}

static void test_fallbacks(void)
{
    ecp_report r;
    check_fallback(step_geometric, ECP_FALLBACK_GEOMETRIC);
    check_fallback(step_continuation, ECP_FALLBACK_CONTINUATION);
    check_fallback(step_multistart, ECP_FALLBACK_MULTISTART);
    check_fallback(step_load, ECP_FALLBACK_LOAD);
    check_fallback(step_substeps, ECP_FALLBACK_SUBSTEPS);
    check_fallback(step_chord, ECP_FALLBACK_CHORD);
    step_with(step_substeps, ECP_FALLBACK_SUBSTEPS, &r);
    CHECK(r.substeps > 1);
    test_fallbacks_sticking();
    test_fallbacks_chord();
    test_fallbacks_work();
    test_fallbacks_squeeze();
}

#else

/* the steps are hard in double only */
static void test_fallbacks(void) {}

#endif
