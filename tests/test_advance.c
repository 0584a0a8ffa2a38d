/* >>advance: a time reached within a tolerance. Truths are closed forms; `make order` has more of
   them, and the figures. */

static ecp_world *advance_world(int order)
{
    ecp_world_desc d = ecp_world_desc_default();
    d.advance_order = order;
    return test_world(&d);
}

/* a body of this shape, 1 kg, at rest; its index */
static int advance_body(ecp_world *w, const ecp_shape *s, const ecp_material *m, double x, double y,
                        double z)
{
    ecp_body_desc b = ecp_body_desc_default();
    ecp_mass mass;
    int body = -1, k;
    ecp_shape_mass(s, 1, &mass);
    for (k = 0; k < 9; k++) b.inertia[k] = mass.inertia[k] / mass.mass;
    b.position[0] = (ecp_real)x;
    b.position[1] = (ecp_real)y;
    b.position[2] = (ecp_real)z;
    CHECK(ecp_body_add(w, &b, &body) == ECP_OK);
    CHECK(ecp_body_add_shape(w, body, s, NULL, NULL, m, NULL) == ECP_OK);
    return body;
}

static void advance_velocity(ecp_world *w, int body, double vx, double vz, double wz)
{
    ecp_real v[3] = {0, 0, 0}, spin[3] = {0, 0, 0};
    v[0] = (ecp_real)vx;
    v[2] = (ecp_real)vz;
    spin[2] = (ecp_real)wz;
    CHECK(ecp_body_set_state(w, body, NULL, NULL, v, spin) == ECP_OK);
}

static void advance_box(ecp_shape *s, double x, double y, double z)
{
    ecp_real half[3];
    half[0] = (ecp_real)x;
    half[1] = (ecp_real)y;
    half[2] = (ecp_real)z;
    CHECK(ecp_shape_box(s, half) == ECP_OK);
}

/* a box of half sizes 0.2 x 0.1 x 0.05 on the ground, or above it */
static ecp_world *advance_scene(int order, double mu, double e_r, double z)
{
    ecp_world *w = advance_world(order);
    ecp_material m = ecp_material_default();
    ecp_shape s;
    m.mu = (ecp_real)mu;
    m.e_r = (ecp_real)e_r;
    test_ground(w, 0, 0, 1, &m);
    advance_box(&s, 0.2, 0.1, 0.05);
    advance_body(w, &s, &m, 0, 0, z);
    return w;
}

static ecp_advance_options advance_options(double in_double, double in_float)
{
    ecp_advance_options o = ecp_advance_options_default();
    o.tolerance = (ecp_real)test_by(in_double, in_float);
    return o;
}

/* what is behind the state of a world is zero outside a call */
static int advance_clean(const ecp_world *w)
{
    const unsigned char *block = (const unsigned char *)w;
    ecp_world_desc d = w->desc;
    size_t i, n = ecp_world_memsize(&d);
    for (i = ecp_world_state_size(w); i < n; i++) {
        if (block[i]) return 0;
    }
    return 1;
}

static void advance_memory(void)
{
    ecp_world_desc d = ecp_world_desc_default();
    size_t none = ecp_world_memsize(&d), some, more;
    d.advance_order = 2;
    some = ecp_world_memsize(&d);
    d.advance_order = 12;
    more = ecp_world_memsize(&d);
    CHECK(some > none && more > some);
    d.advance_order = 1;
    CHECK(ecp_world_memsize(&d) == 0);
    d.advance_order = 13;
    CHECK(ecp_world_memsize(&d) == 0);
    d.advance_order = -1;
    CHECK(ecp_world_memsize(&d) == 0);
}

/* a long macro step may reach more patches than there is room for: it is shortened, not refused */
static void advance_short_of_room(void)
{
    ecp_world_desc d = ecp_world_desc_default();
    ecp_advance_options o = ecp_advance_options_default();
    ecp_material m = ecp_material_default();
    ecp_shape s;
    ecp_world *w;
    ecp_real x[3] = {0, 0, 0};
    int k, last = 0;
    d.advance_order = 6;
    d.max_patches = 5;
    w = test_world(&d);
    test_ground(w, 0, 0, 1, &m);
    advance_box(&s, 0.1, 0.1, 0.05);
    for (k = 0; k < 5; k++) last = advance_body(w, &s, &m, 0, 0, 0.05 + 0.1 * k);
    CHECK(ecp_advance(w, 1, &o, NULL) == ECP_OK);
    ecp_body_get_state(w, last, x, NULL, NULL, NULL);
    CHECK_NEAR(x[2], 0.45, test_by(1e-12, 1e-5));
    free(w);
}

static void advance_writes(void *user, const char *text)
{
    (void)user;
    (void)text;
    CHECK(0);
}

/* a callback that calls what has called it, and adds and removes */
static void advance_nested(void *user, ecp_world *w, ecp_real time)
{
    ecp_body_desc b = ecp_body_desc_default();
    ecp_shape s;
    (void)time;
    CHECK(ecp_shape_sphere(&s, 1) == ECP_OK);
    CHECK(ecp_body_add(w, &b, NULL) == ECP_BAD_OPTION);
    CHECK(ecp_body_add_shape(w, 1, &s, NULL, NULL, NULL, NULL) == ECP_BAD_OPTION);
    CHECK(ecp_body_remove(w, 1) == ECP_BAD_OPTION);
    CHECK(ecp_dump(w, 1, NULL, advance_writes, NULL) == ECP_BAD_OPTION);
    *(int *)user += ecp_advance(w, 1, NULL, NULL) == ECP_BAD_OPTION ? 1 : 1000;
    *(int *)user += ecp_step(w, ECP_R(0.01), NULL, NULL) == ECP_BAD_OPTION ? 0 : 1000;
}

/* A box at rest under a force that is 1.0625 of what friction holds at its peaks, at 3 rad/s for 5 s: the peaks are
   seen where no macro step is longer than a fraction of what they last. */
static void advance_peak(void *user, ecp_world *w, ecp_real time)
{
    ecp_real f[3] = {0, 0, 0};
    (void)user;
    f[0] = ECP_R(0.3 * 9.8 * 1.0625 * sin(3 * (double)time));
    ecp_body_apply_force(w, 1, f, NULL);
}

static void advance_peaks(void)
{
    ecp_advance_options o = ecp_advance_options_default();
    ecp_material m = ecp_material_default();
    ecp_advance_report r;
    const ecp_real half[3] = {ECP_R(0.1), ECP_R(0.1), ECP_R(0.1)};
    ecp_world *w = advance_world(6);
    ecp_shape s;
    double x = 0, v = 0, dt = 1e-5;
    long k;
    m.mu = ECP_R(0.3);
    test_ground(w, 0, 0, 1, &m);
    CHECK(ecp_shape_box(&s, half) == ECP_OK);
    advance_body(w, &s, &m, 0, 0, 0.1);
    o.load = advance_peak;
    o.tolerance = ECP_R(1e-3);
    o.longest_step = ECP_R(0.1);
    CHECK(ecp_advance(w, 5, &o, &r) == ECP_OK && r.macro_steps >= 50);
    for (k = 0; k < 500000; k++) {
        double f = 0.3 * 9.8 * 1.0625 * sin(3 * ((double)k + 0.5) * dt), held = 0.3 * 9.8, next;
        if (!(v < 0) && !(v > 0)) {
            if (fabs(f) <= held) continue;
            v = (f > 0 ? f - held : f + held) * dt;
            continue;
        }
        next = v + (v > 0 ? f - held : f + held) * dt;
        if (next * v < 0) next = 0;
        x += (v + next) / 2 * dt;
        v = next;
    }
    CHECK(x > 4e-3);
    /* the tolerance of one macro step, 1e-3 of L */
    CHECK_NEAR(ecp_i_bodies(w)[1].x[0], x, 1e-3 * (double)ecp_i_bodies(w)[1].length);
    free(w);
}

/* nothing to move, by itself and at a pace */
static void advance_nobody(void)
{
    ecp_advance_options o = ecp_advance_options_default();
    ecp_world *w = advance_world(4);
    ecp_advance_report r;
    CHECK(ecp_advance(w, 10, &o, &r) == ECP_OK && r.reached == 10);
    o.macro_step = 1;
    CHECK(ecp_advance(w, 10, &o, &r) == ECP_OK && r.reached == 10 && r.events == 0);
    free(w);
}

/* The same where base steps fail and go by parts: a box that falls on its edge, one iteration a step. The call may end
   either way; what it was called with comes through. */
static void advance_nested_parts(void)
{
    int nested = 0;
    ecp_world *w = advance_scene(4, 0.5, 0, 0.06);
    ecp_options step = ecp_options_default();
    ecp_advance_options o = ecp_advance_options_default();
    ecp_real spin[3] = {0, 3, 0}, v[3] = {1, 0, 0};
    size_t n = ecp_world_memsize(&w->desc);
    void *before = malloc(n);
    CHECK(ecp_body_set_state(w, 1, NULL, NULL, v, spin) == ECP_OK);
    memcpy(before, w, n);
    step.max_iterations = 1;
    step.fallbacks = ECP_FALLBACK_SUBSTEPS;
    o.step = &step;
    o.macro_step = ECP_R(0.02);
    o.order = 2;
    o.load = advance_nested;
    o.load_user = &nested;
    if (ecp_advance(w, ECP_R(0.5), &o, NULL) != ECP_OK) CHECK(memcmp(before, w, n) == 0);
    CHECK(nested > 0 && nested < 1000);
    CHECK(advance_clean(w));
    free(before);
    free(w);
}

/* A tilted box that lands with few iterations a step: at a given pace, too, a macro step that only sub-steps solve is
   counted as one that is not within the tolerance. */
static void advance_forced(void)
{
    const ecp_real tilted[4] = {1, ECP_R(0.2), 0, 0}, v[3] = {1, 0, 0}, spin[3] = {0, 1, 0};
    ecp_world *w = advance_world(4);
    ecp_shape box = test_box_shape(0.2, 0.1, 0.05);
    ecp_options step = ecp_options_default();
    ecp_advance_options o = ecp_advance_options_default();
    ecp_advance_report r;
    test_ground(w, 0, 0, 1, NULL);
    test_body(w, ECP_DYNAMIC, 1, 0.0042, 0.0142, 0.0167, 0, 0, 0.3);
    test_attach(w, 1, &box, 0, 0, 0, NULL);
    CHECK(ecp_body_set_state(w, 1, NULL, tilted, v, spin) == ECP_OK);
    o.tolerance = (ecp_real)test_by(1e-4, 1e-3);
    step.max_iterations = 6;
    step.fallbacks = ECP_FALLBACK_SUBSTEPS;
    o.step = &step;
    o.macro_step = ECP_R(0.1);
    o.order = 2;
    CHECK(ecp_advance(w, ECP_R(0.5), &o, &r) == ECP_OK && r.first_order > 0);
    CHECK(r.forced == r.first_order && r.error >= 2);
    free(w);
}

/* A box that falls: the contact without a load that it has below has the gap and the points of the pose that was
   reached. */
static void advance_falls(void)
{
    ecp_world *w = advance_scene(4, 0.5, 0, 0.15);
    ecp_advance_options o = ecp_advance_options_default();
    ecp_contact c;
    o.macro_step = ECP_R(0.0142);
    o.order = 2;
    CHECK(ecp_advance(w, ECP_R(0.142), &o, NULL) == ECP_OK);
    CHECK(ecp_contact_get(w, 0, &c) == ECP_OK && c.mode == ECP_APART);
    CHECK_NEAR(c.gap, test_get(w, 1).x[2] - 0.05, test_by(1e-15, 1e-7));
    CHECK_NEAR(c.point_b[2], 0, test_by(1e-15, 1e-7));
    free(w);
}

/* every bad call has its own status and changes nothing */
static void advance_refuses(void)
{
    int nested = 0;
    ecp_world *w = advance_scene(4, 0.5, 0, 0.05), *plain = advance_scene(0, 0.5, 0, 0.05);
    ecp_world_desc d = w->desc;
    size_t n = ecp_world_memsize(&d);
    void *before = malloc(n);
    ecp_advance_options o = ecp_advance_options_default();
    ecp_advance_report r;
    ecp_real nan = 0;
    nan /= nan;
    advance_velocity(w, 1, 1, 0, 2);
    memcpy(before, w, n);
    CHECK(ecp_advance(NULL, 1, NULL, &r) == ECP_BAD_POINTER && r.status == ECP_BAD_POINTER);
    CHECK(ecp_advance(plain, 1, NULL, NULL) == ECP_CAPACITY);
    CHECK(ecp_advance(w, -1, NULL, NULL) == ECP_BAD_STEP);
    CHECK(ecp_advance(w, nan, NULL, NULL) == ECP_NOT_FINITE);
    o.order = 1;
    CHECK(ecp_advance(w, 1, &o, NULL) == ECP_BAD_OPTION);
    o.order = 5;
    CHECK(ecp_advance(w, 1, &o, NULL) == ECP_CAPACITY);
    o.order = 0;
    o.tolerance = 0;
    CHECK(ecp_advance(w, 1, &o, NULL) == ECP_BAD_OPTION);
    o.tolerance = nan;
    CHECK(ecp_advance(w, 1, &o, NULL) == ECP_NOT_FINITE);
    /* what rounding leaves is known beforehand */
    o.tolerance = (ecp_real)test_by(1e-14, 1e-6);
    CHECK(ecp_advance(w, 1, &o, &r) == ECP_TOLERANCE && r.solves == 0);
    o = ecp_advance_options_default();
    o.macro_step = -1;
    CHECK(ecp_advance(w, 1, &o, NULL) == ECP_BAD_OPTION);
    o.macro_step = 0;
    o.longest_step = -1;
    CHECK(ecp_advance(w, 1, &o, NULL) == ECP_BAD_OPTION);
    o.longest_step = nan;
    CHECK(ecp_advance(w, 1, &o, NULL) == ECP_NOT_FINITE);
    o.longest_step = ECP_R(1e-30);
    CHECK(ecp_advance(w, 1, &o, NULL) == ECP_BAD_STEP);
    o.longest_step = 0;
    o.macro_step = ECP_R(1e-30); /* nothing, beside a second */
    CHECK(ecp_advance(w, 1, &o, NULL) == ECP_BAD_STEP);
    o.macro_step = ECP_R(0.1);
    o.tolerance = 0; /* the unit of the error that is reported */
    CHECK(ecp_advance(w, 1, &o, NULL) == ECP_BAD_OPTION);
    o = ecp_advance_options_default();
    /* a limit that is reached on the way */
    o.max_solves = 5;
    CHECK(ecp_advance(w, 1, &o, &r) == ECP_NOT_SOLVED && r.solves >= 5 && r.reached < 1);
    CHECK(memcmp(before, w, n) == 0);
    o.max_solves = 0;
    o.load = advance_nested;
    o.load_user = &nested;
    CHECK(ecp_advance(w, ECP_R(0.1), &o, &r) == ECP_OK && nested > 0 && nested < 1000);
    o.load = NULL;
    CHECK(ecp_advance(w, 0, &o, &r) == ECP_OK && r.solves == 0);
    CHECK(ecp_advance(w, 1, &o, &r) == ECP_OK);
    CHECK(advance_clean(w));
    free(before);
    free(w);
    free(plain);
}

/* Slides, spins, and stops: 5/2 v0^2 ... and a fall with a landing in it. */
static void advance_truths(void)
{
    ecp_advance_options o = advance_options(1e-9, 1e-3);
    double t = sqrt(2 * 0.5 / 9.8), v = 2 - 0.2 * 9.8 * t, late = 0.6 - t;
    ecp_world *w = advance_scene(8, 0.2, 0, 0.55);
    ecp_advance_report r;
    ecp_real x[3] = {1, 1, 1}, u[3] = {1, 1, 1};
    /* a landing: the impact takes mu m v_n of the tangential momentum */
    advance_velocity(w, 1, 2, 0, 0);
    CHECK(ecp_advance(w, ECP_R(0.6), &o, &r) == ECP_OK);
    ecp_body_get_state(w, 1, x, NULL, u, NULL);
    CHECK_NEAR(x[0], 2 * t + v * late - 0.1 * 9.8 * late * late, test_by(1e-8, 1e-2));
    CHECK_NEAR(u[0], v - 0.2 * 9.8 * late, test_by(1e-8, 1e-2));
    CHECK_NEAR(x[2], 0.05, test_by(1e-12, 1e-6));
    CHECK(r.events >= 1 && r.solves < 500);
    CHECK(advance_clean(w));
    free(w);

    /* it stops, to the last digit, though v^2 / (2 mu g) can hide from every column */
    w = advance_scene(8, 0.2, 0, 0.05);
    advance_velocity(w, 1, 1, 0, 0);
    CHECK(ecp_advance(w, 5, &o, &r) == ECP_OK);
    ecp_body_get_state(w, 1, x, NULL, u, NULL);
    CHECK_NEAR(x[0], 1 / (2 * 0.2 * 9.8), test_by(1e-8, 1e-3));
    CHECK(u[0] == 0 && u[1] == 0 && u[2] == 0);
    CHECK(r.solves < 300);
    free(w);
}

/* truths T3: the patch that spins and slides */
static void advance_spin(void)
{
    ecp_advance_options o = advance_options(1e-9, 1e-3);
    ecp_world *w = advance_world(8);
    ecp_material m = ecp_material_default();
    ecp_body_desc b = ecp_body_desc_default();
    ecp_advance_report r;
    ecp_real x[3] = {1, 1, 1}, v[3] = {1, 1, 1}, spin[3] = {1, 1, 1};
    ecp_shape s;
    int k;
    m.mu = ECP_R(0.22);
    m.e_r = ECP_R(0.1);
    test_ground(w, 0, 0, 1, &m);
    advance_box(&s, 0.3, 0.3, 0.25);
    b.mass = 3;
    for (k = 0; k < 3; k++) b.inertia[4 * k] = ECP_R(0.125);
    b.position[2] = ECP_R(0.25);
    b.velocity[0] = 1;
    b.angular_velocity[2] = 5;
    ecp_body_add(w, &b, NULL);
    ecp_body_add_shape(w, 1, &s, NULL, NULL, &m, NULL);
    CHECK(ecp_advance(w, ECP_R(0.3), &o, &r) == ECP_OK);
    ecp_body_get_state(w, 1, x, NULL, v, spin);
    CHECK_NEAR(v[0], 0.47548536355307, test_by(1e-8, 1e-3));
    CHECK_NEAR(v[1], -0.1077973682858, test_by(1e-8, 1e-3));
    CHECK_NEAR(spin[2], 4.1380593233353, test_by(1e-8, 1e-2));
    CHECK_NEAR(x[0], 0.21932522679829, test_by(1e-8, 1e-3));
    CHECK_NEAR(x[1], -0.01809344945830, test_by(1e-8, 1e-3));
    CHECK(r.solves <= 500);
    free(w);
}

/* the table of Example 2, as it is when it is hit at 0.75 s, but for the angular impulse of -5 about x */
static ecp_world *advance_sliding_table(const ecp_advance_options *o)
{
    ecp_world *w = advance_world(8);
    ecp_material m = ecp_material_default();
    ecp_body_desc b = ecp_body_desc_default();
    ecp_shape leg;
    int k;
    m.mu = ECP_R(0.12);
    m.e_r = 1;
    test_ground(w, 0, 0, 1, &m);
    b.mass = 5;
    b.inertia[0] = b.inertia[4] = ECP_R(0.3327);
    b.inertia[8] = ECP_R(0.4458);
    b.position[2] = ECP_R(0.3);
    b.velocity[1] = 1;
    ecp_body_add(w, &b, NULL);
    CHECK(ecp_shape_cylinder(&leg, ECP_R(0.1), ECP_R(0.2)) == ECP_OK);
    for (k = 0; k < 3; k++) {
        ecp_real at[3];
        double angle = (2 * k / 3.0 + 0.5) * acos(-1.0);
        at[0] = (ecp_real)(0.3 * cos(angle));
        at[1] = (ecp_real)(0.3 * sin(angle));
        at[2] = ECP_R(-0.1);
        ecp_body_add_shape(w, 1, &leg, at, NULL, &m, NULL);
    }
    CHECK(ecp_advance(w, ECP_R(0.75), o, NULL) == ECP_OK);
    return w;
}

/* truths T2: the table that is hit tilts to 42.81 degrees as h goes to 0, on one leg's rim, where slip
   turns round on the way; steps of 0.01 s reach 44.21. It falls back on all legs at once, and stops
   where an impact on them all stops it (tests/truths.h) */
static void advance_table(void)
{
    ecp_advance_options o = advance_options(1e-5, 1e-3);
    ecp_world *w = advance_sliding_table(&o);
    ecp_real hit[3] = {-5, 0, 0}, q[4] = {1, 0, 0, 0}, y[3] = {0, 1, 0};
    double most = 0;
    int k;
    ecp_body_apply_angular_impulse(w, 1, hit);
    CHECK(ecp_advance(w, ECP_R(0.38), &o, NULL) == ECP_OK);
    for (k = 0; k < 10; k++) {
        CHECK(ecp_advance(w, ECP_R(0.005), &o, NULL) == ECP_OK);
        ecp_body_get_state(w, 1, NULL, q, y, NULL);
        most = fmax(most, 2 * asin(sqrt((double)(q[1] * q[1] + q[2] * q[2]))));
    }
    CHECK_NEAR(most * 180 / acos(-1.0), 42.81, test_by(0.01, 0.1));
    for (k = 0; k < 8; k++) CHECK(ecp_advance(w, ECP_R(0.1), &o, NULL) == ECP_OK);
    ecp_body_get_state(w, 1, y, q, NULL, NULL);
    CHECK_NEAR(y[1], 0.576260391293, test_by(1e-3, 1e-2));
    CHECK_NEAR(y[2], 0.3, test_by(1e-5, 1e-3));
    CHECK(certificate(w) >= -test_by(1e-10, 1e-5));
    free(w);
}

/* The same in one call, for tolerances at which the macro step that lands on all legs came down to the shortest one
   before the impact was tried by itself, and 1e-10, at which macro steps up to where slip turns round are rounding: no
   event is forced. */
static void advance_landing(void)
{
    static const double tolerances[6] = {4e-5, 8.9e-6, 3.2e-6, 4e-7, 2e-8, 1e-10};
    int k;
    for (k = 0; sizeof(ecp_real) > 4 && k < 6; k++) {
        ecp_advance_options o = advance_options(tolerances[k], 1);
        ecp_world *w = advance_sliding_table(&o);
        ecp_real hit[3] = {-5, 0, 0}, y[3] = {0, 0, 0};
        ecp_advance_report r;
        ecp_body_apply_angular_impulse(w, 1, hit);
        CHECK(ecp_advance(w, ECP_R(1.65), &o, &r) == ECP_OK);
        CHECK(r.forced == 0);
        ecp_body_get_state(w, 1, y, NULL, NULL, NULL);
        CHECK_NEAR(y[1], 0.576260391293, 10 * tolerances[k]);
        free(w);
    }
}

static void advance_push(void *user, ecp_world *w, ecp_real time)
{
    ecp_real f[3] = {0, 0, 0};
    ++*(int *)user;
    f[0] = ECP_R(2.3) * time;
    CHECK(ecp_body_apply_force(w, 1, f, NULL) == ECP_OK);
}

/* loads: as they were applied before, all the time and then gone; impulses at once; by a callback */
static void advance_loads(void)
{
    ecp_advance_options o = advance_options(1e-9, 1e-3);
    ecp_real x[3] = {1, 1, 1}, v[3] = {1, 1, 1}, up[3] = {0, 0, ECP_R(9.8)},
             hit[3] = {ECP_R(0.5), 0, 0};
    double late = 2 - 0.3 * 9.8 / 2.3;
    ecp_world *w = advance_scene(6, 0.3, 0, 1);
    ecp_advance_report r;
    int calls = 0;
    ecp_body_apply_force(w, 1, up, NULL);
    ecp_body_apply_impulse(w, 1, hit, NULL);
    CHECK(ecp_advance(w, 2, &o, NULL) == ECP_OK);
    ecp_body_get_state(w, 1, x, NULL, v, NULL);
    CHECK_NEAR(x[0], 1, test_by(1e-12, 1e-5));
    CHECK_NEAR(x[2], 1, test_by(1e-12, 1e-5));
    CHECK(ecp_advance(w, ECP_R(0.1), &o, NULL) == ECP_OK);
    ecp_body_get_state(w, 1, x, NULL, v, NULL);
    CHECK_NEAR(v[2], -0.98, test_by(1e-12, 1e-5));
    free(w);

    w = advance_scene(6, 0.3, 0, 0.05);
    o.load = advance_push;
    o.load_user = &calls;
    CHECK(ecp_advance(w, 2, &o, &r) == ECP_OK);
    ecp_body_get_state(w, 1, x, NULL, v, NULL);
    CHECK_NEAR(x[0], 2.3 * late * late * late / 6, test_by(1e-8, 1e-3));
    CHECK_NEAR(v[0], 2.3 * late * late / 2, test_by(1e-8, 1e-3));
    CHECK(calls >= r.solves - r.macro_steps * 3 && calls <= 3 * r.solves);
    free(w);
}

/* a thrust that begins, and a belt that starts, at *user */
static void advance_switch(void *user, ecp_world *w, ecp_real time)
{
    const ecp_real *since = (const ecp_real *)user;
    ecp_real f[3] = {1, 0, 0}, v[3] = {0, 2, 0};
    if (!(time > *since)) return;
    CHECK(ecp_body_apply_force(w, 0, f, NULL) == ECP_OK);
    CHECK(ecp_body_set_state(w, 1, NULL, NULL, v, NULL) == ECP_OK);
}

/* What begins within the first base step of a macro step acts in all columns from the beginning on, and they agree: a
   free body that is still or not, and a driven one. Long macro steps, as nothing else happens; with and without a bound
   on them, and where it begins at the very beginning. */
static void advance_thrust(void)
{
    static const double begins[4] = {0.3, 0.77, 1e-3, 0}, bounds[3] = {0, 1, 0.1};
    int i, k, moves;
    for (i = 0; i < 4; i++) {
        for (k = 0; k < 3; k++) {
            for (moves = 0; moves < 2; moves++) {
                ecp_world *w = advance_world(8);
                ecp_advance_options o = advance_options(1e-8, 1e-3);
                ecp_advance_report r;
                ecp_body_desc b = ecp_body_desc_default();
                ecp_real since = (ecp_real)begins[i], x[3], v[3];
                double t = 2 - begins[i], v0 = moves ? 0.5 : 0;
                w->desc.gravity[2] = 0;
                b.velocity[0] = (ecp_real)v0;
                CHECK(ecp_body_add(w, &b, NULL) == ECP_OK);
                b.kind = ECP_KINEMATIC;
                b.velocity[0] = 0;
                CHECK(ecp_body_add(w, &b, NULL) == ECP_OK);
                o.load = advance_switch;
                o.load_user = &since;
                o.longest_step = (ecp_real)bounds[k];
                CHECK(ecp_advance(w, 2, &o, &r) == ECP_OK);
                ecp_body_get_state(w, 0, x, NULL, v, NULL);
                CHECK_NEAR(v[0], v0 + t, test_by(1e-6, 4e-3));
                CHECK_NEAR(x[0], 2 * v0 + t * t / 2, test_by(1e-6, 4e-3));
                ecp_body_get_state(w, 1, x, NULL, v, NULL);
                CHECK_NEAR(x[1], 2 * t, test_by(1e-6, 4e-3));
                CHECK(v[1] == 2);
                free(w);
            }
        }
    }
}

/* 1 N down, and *user along, which grows */
static void advance_pressed(void *user, ecp_world *w, ecp_real time)
{
    const ecp_real *along = (const ecp_real *)user;
    ecp_real f[3] = {0, 0, -1};
    f[0] = *along * (1 + ECP_R(0.3) * time);
    CHECK(ecp_body_apply_force(w, 1, f, NULL) == ECP_OK);
}

/* Without gravity, a box that a load presses on the ground, mu = 1/2, and that hardly moves: its velocities are measured
   by what the load would do to it. By themselves they would be so small that nothing is within the tolerance. 0.16 N
   at the end stop and hold it; 1 N pushes it on; the load of one call, and one by a callback. */
static void advance_slow_load(void)
{
    static const double speeds[5] = {1e-2, 1e-4, 1e-6, 1e-9, 0}, along[2] = {0.1, 1};
    const ecp_real none[3] = {0, 0, 0};
    int i, k, called;
    for (i = 0; i < 5; i++) {
        for (k = 0; k < 4; k++) {
            for (called = 0; called < 2; called++) {
                ecp_world *w = advance_scene(6, 0.5, 0, 0.05);
                ecp_advance_options o = advance_options(k < 2 ? 1e-6 : 1e-9, 1e-3);
                ecp_advance_report r;
                ecp_real v[3] = {0, 0, 0}, f[3] = {0, 0, -1}, push = (ecp_real)along[k % 2];
                double end = k % 2 ? speeds[i] + 2 + (called ? 0.6 : 0) - 1 : 0;
                v[0] = (ecp_real)speeds[i];
                f[0] = push;
                CHECK(ecp_world_set_gravity(w, none) == ECP_OK);
                CHECK(ecp_body_set_state(w, 1, NULL, NULL, v, NULL) == ECP_OK);
                o.load = called ? advance_pressed : NULL;
                o.load_user = &push;
                if (!called) CHECK(ecp_body_apply_force(w, 1, f, NULL) == ECP_OK);
                CHECK(ecp_advance(w, 2, &o, &r) == ECP_OK);
                CHECK(r.forced == 0 && r.solves < 300);
                ecp_body_get_state(w, 1, NULL, NULL, v, NULL);
                CHECK_NEAR(v[0], end, test_by(1e-9, 1e-3));
                free(w);
            }
        }
    }
}

/* A box that slides to rest has done so, however long it is followed. */
static void advance_for_ages(void)
{
    static const double ages[4] = {1e3, 1e6, 1e9, 1e18};
    int i;
    for (i = 0; i < 4; i++) {
        ecp_world *w = advance_scene(6, 0.5, 1, 0.05);
        ecp_advance_options o = advance_options(1e-6, 1e-3);
        ecp_advance_report r;
        ecp_real x[3], v[3] = {1, 0, 0};
        CHECK(ecp_body_set_state(w, 1, NULL, NULL, v, NULL) == ECP_OK);
        CHECK(ecp_advance(w, (ecp_real)ages[i], &o, &r) == ECP_OK);
        CHECK(r.reached == (ecp_real)ages[i] && r.forced == 0);
        ecp_body_get_state(w, 1, x, NULL, v, NULL);
        CHECK(v[0] == 0 && v[1] == 0 && v[2] == 0);
        CHECK_NEAR(x[0], 1 / (2 * 0.5 * 9.8), test_by(1e-6, 1e-3));
        free(w);
    }
}

/* A box of mu 0.5 or 1 that rides on a body driven at a velocity, or at a spin of 4 about z: on a half-space or
   on a box. */
static ecp_world *advance_ride(int plane, int spins)
{
    ecp_world *w = advance_world(8);
    ecp_material m = ecp_material_default();
    ecp_body_desc b = ecp_body_desc_default();
    ecp_real up[3] = {0, 0, 1}, v[3] = {0, 0, 0}, spin[3] = {0, 0, 4};
    ecp_shape s;
    m.mu = spins ? 1 : ECP_R(0.5);
    m.e_r = ECP_R(0.01);
    b.kind = ECP_KINEMATIC;
    b.position[2] = plane ? 0 : ECP_R(-0.1);
    b.velocity[0] = spins ? ECP_R(0) : ECP_R(1);
    b.angular_velocity[2] = spins ? ECP_R(4) : ECP_R(0);
    CHECK(ecp_body_add(w, &b, NULL) == ECP_OK);
    if (plane)
        CHECK(ecp_shape_half_space(&s, up, 0) == ECP_OK);
    else
        advance_box(&s, 3, 3, 0.1);
    CHECK(ecp_body_add_shape(w, 0, &s, NULL, NULL, &m, NULL) == ECP_OK);
    advance_box(&s, 0.02, 0.03, 0.01);
    advance_body(w, &s, &m, 0.3, 0, 0.01);
    v[1] = ECP_R(1.2);
    if (spins) CHECK(ecp_body_set_state(w, 1, NULL, NULL, v, spin) == ECP_OK);
    return w;
}

/* to and fro, by the callback */
static void advance_shake(void *user, ecp_world *w, ecp_real time)
{
    ecp_real v[3] = {0, 0, 0};
    (void)user;
    v[0] = ECP_R(sin(3 * (double)time));
    CHECK(ecp_body_set_state(w, 0, NULL, NULL, v, NULL) == ECP_OK);
}

/* On a conveyor a box slides until it has its velocity; on a turntable it stays where it is, which steps of
   one length do not (it drifts inwards by h w^2 / 2 of its radius a second). */
static void advance_driven(void)
{
    ecp_advance_options o = advance_options(1e-8, 1e-3);
    ecp_body_desc b = ecp_body_desc_default();
    ecp_world *w = advance_world(8);
    ecp_real x[3], q[4], v[3], spin[3];
    int plane, k;
    /* nothing else: driven bodies have no length */
    b.kind = ECP_KINEMATIC;
    b.velocity[1] = 2;
    b.angular_velocity[0] = ECP_R(0.5);
    CHECK(ecp_body_add(w, &b, NULL) == ECP_OK);
    CHECK(ecp_advance(w, 1, &o, NULL) == ECP_OK);
    ecp_body_get_state(w, 0, x, q, NULL, NULL);
    CHECK_NEAR(x[1], 2, test_by(1e-12, 1e-5));
    CHECK_NEAR(q[1], sin(0.25), test_by(1e-8, 1e-3));
    free(w);
    for (plane = 0; plane < 2; plane++) {
        double bound = test_by(1e-8, 1e-3), angle = 4;
        w = advance_ride(plane, 0);
        CHECK(ecp_advance(w, 1, &o, NULL) == ECP_OK);
        ecp_body_get_state(w, 1, x, NULL, v, NULL);
        CHECK_NEAR(x[0], 0.3 + 1 - 1 / 9.8, bound);
        CHECK_NEAR(v[0], 1, bound);
        CHECK_NEAR(x[2], 0.01, bound / 10);
        free(w);
        w = advance_ride(plane, 1);
        CHECK(ecp_advance(w, 1, &o, NULL) == ECP_OK);
        ecp_body_get_state(w, 1, x, NULL, v, spin);
        CHECK_NEAR(x[0], 0.3 * cos(angle), 10 * bound);
        CHECK_NEAR(x[1], 0.3 * sin(angle), 10 * bound);
        CHECK_NEAR(spin[2], 4, 10 * bound);
        ecp_body_get_state(w, 0, NULL, q, NULL, NULL);
        CHECK_NEAR(q[3], sin(angle / 2), 10 * bound);
        free(w);
    }
    /* a box that sticks to what shakes it; and nothing on it */
    for (k = 0; k < 2; k++) {
        double bound = test_by(1e-8, 1e-3);
        w = advance_ride(0, 0);
        if (k) CHECK(ecp_body_remove(w, 1) == ECP_OK);
        o.load = advance_shake;
        CHECK(ecp_advance(w, 1, &o, NULL) == ECP_OK);
        o.load = NULL;
        ecp_body_get_state(w, 0, x, NULL, NULL, NULL);
        CHECK_NEAR(x[0], (1 - cos(3.0)) / 3, bound);
        if (!k) ecp_body_get_state(w, 1, x, NULL, NULL, NULL);
        if (!k) CHECK_NEAR(x[0], 0.3 + (1 - cos(3.0)) / 3, bound);
        free(w);
    }
    w = advance_ride(0, 1);
    for (k = 0; k < 100; k++) CHECK(ecp_step(w, ECP_R(0.01), NULL, NULL) == ECP_OK);
    ecp_body_get_state(w, 1, x, NULL, NULL, NULL);
    CHECK_NEAR(sqrt((double)(x[0] * x[0] + x[1] * x[1])), 0.3 * exp(-0.01 * 16 / 2), 1e-4);
    free(w);
}

/* Torque-free: energy and angular momentum stay, within the tolerance, where a step loses them. */
static void advance_free_rotation(void)
{
    ecp_advance_options o = advance_options(1e-9, 1e-3);
    const ecp_real none[3] = {0, 0, 0};
    ecp_world *w = advance_world(8);
    ecp_body_desc b = ecp_body_desc_default();
    ecp_real q[4] = {1, 0, 0, 0}, spin[3] = {1, 1, 1}, R[9];
    double body[3], energy = 0, before = 1e-4 + 2 + 3e-4, momentum[3];
    int k, j;
    ecp_world_set_gravity(w, none);
    b.inertia[4] = 2;
    b.inertia[8] = 3;
    b.angular_velocity[0] = b.angular_velocity[2] = ECP_R(0.01);
    b.angular_velocity[1] = 1;
    ecp_body_add(w, &b, NULL);
    CHECK(ecp_advance(w, 20, &o, NULL) == ECP_OK);
    ecp_body_get_state(w, 0, NULL, q, NULL, spin);
    ecp_quat_to_matrix(q, R);
    for (k = 0; k < 3; k++) {
        for (j = 0, body[k] = 0; j < 3; j++) body[k] += (double)R[3 * j + k] * (double)spin[j];
        energy += (k + 1) * body[k] * body[k];
    }
    CHECK_NEAR(energy, before, test_by(1e-8, 1e-2));
    for (k = 0; k < 3; k++) {
        for (j = 0, momentum[k] = 0; j < 3; j++)
            momentum[k] += (double)R[3 * k + j] * (j + 1) * body[j];
        CHECK_NEAR(momentum[k], (k + 1) * (k == 1 ? 1 : 0.01), test_by(1e-8, 1e-2));
    }
    free(w);
}

/* Where nothing happens, no macro step is forced, however short the order or the caller makes them. */
static void advance_short(void)
{
    ecp_advance_options o = advance_options(1e-7, 3e-3);
    ecp_advance_report r;
    double steps = test_by(2e-4, 2e-3), energy[2];
    int k, j, i;
    for (k = 0; k < 2; k++) {
        ecp_world *w = advance_world(4);
        ecp_real spin[3] = {3, 2, ECP_R(0.5)}, q[4] = {1, 0, 0, 0}, R[9];
        const ecp_real none[3] = {0, 0, 0};
        ecp_shape s;
        int body;
        ecp_world_set_gravity(w, none);
        advance_box(&s, 0.05, 0.1, 0.2);
        body = advance_body(w, &s, NULL, 0, 0, 0);
        CHECK(ecp_body_set_state(w, body, NULL, NULL, NULL, spin) == ECP_OK);
        o.order = k == 0 ? 2 : 4;
        o.longest_step = k == 0 ? ECP_R(0) : (ecp_real)steps;
        for (j = 0; j < 2; j++) {
            double l[3] = {0, 0, 0};
            ecp_body_get_state(w, body, NULL, q, NULL, spin);
            ecp_quat_to_matrix(q, R);
            for (i = 0; i < 9; i++) l[i % 3] += (double)R[i] * (double)spin[i / 3];
            energy[j] =
                0.05 / 3 * l[0] * l[0] + 0.0425 / 3 * l[1] * l[1] + 0.0125 / 3 * l[2] * l[2];
            if (j == 0) CHECK(ecp_advance(w, ECP_R(0.5), &o, &r) == ECP_OK);
        }
        CHECK(r.forced == 0 && r.first_order == 0 && r.events == 0);
        CHECK_NEAR(energy[1], energy[0], energy[0] * test_by(1e-8, 1e-3));
        if (k == 1) CHECK(r.macro_steps >= (int)(0.499 / steps));
        free(w);
    }
}

/* A frustum that slides on a block and turns: what is done does not depend on the unit of length. */
static void advance_units(void)
{
    double kept[2][13];
    int i, j;
    for (j = 0; j < 2; j++) {
        double L = j ? 1.0 / 32 : 1.0;
        ecp_world *w = advance_world(8);
        ecp_advance_options o = ecp_advance_options_default();
        ecp_advance_report r;
        ecp_body_desc b = ecp_body_desc_default();
        ecp_real g[3] = {0, 0, 0}, x[3] = {0, 0, 0}, v[3] = {0, 0, 0}, spin[3] = {0, 0, 0};
        ecp_shape s;
        int body = -1;
        g[2] = (ecp_real)(-9.75 * L);
        ecp_world_set_gravity(w, g);
        b.kind = ECP_STATIC;
        b.position[2] = (ecp_real)(-0.5 * L);
        CHECK(ecp_body_add(w, &b, &body) == ECP_OK);
        advance_box(&s, 4 * L, 4 * L, 0.5 * L);
        CHECK(ecp_body_add_shape(w, body, &s, NULL, NULL, NULL, NULL) == ECP_OK);
        b.kind = ECP_DYNAMIC;
        b.position[2] = (ecp_real)(0.25 * L);
        b.inertia[0] = b.inertia[4] = (ecp_real)(0.04 * L * L);
        b.inertia[8] = (ecp_real)(0.05 * L * L);
        b.velocity[0] = (ecp_real)(1.25 * L);
        b.velocity[1] = (ecp_real)(0.3 * L);
        b.angular_velocity[2] = ECP_R(0.5);
        CHECK(ecp_body_add(w, &b, &body) == ECP_OK);
        CHECK(ecp_shape_frustum(&s, (ecp_real)(0.25 * L), (ecp_real)(0.125 * L),
                                (ecp_real)(0.25 * L)) == ECP_OK);
        CHECK(ecp_body_add_shape(w, body, &s, NULL, NULL, NULL, NULL) == ECP_OK);
        CHECK(ecp_advance(w, ECP_R(0.1), &o, &r) == ECP_OK);
        ecp_body_get_state(w, body, x, NULL, v, spin);
        for (i = 0; i < 3; i++) {
            kept[j][i] = (double)x[i] / L;
            kept[j][3 + i] = (double)v[i] / L;
            kept[j][6 + i] = (double)spin[i];
        }
        kept[j][9] = r.solves;
        kept[j][10] = r.events;
        kept[j][11] = (double)r.error;
        kept[j][12] = (double)r.projection / L;
        free(w);
    }
    for (i = 0; i < 13; i++) CHECK(kept[0][i] == kept[1][i]);
}

/* a constant pace: the error falls as H^order */
static double advance_paced(int order, double H)
{
    ecp_advance_options o = ecp_advance_options_default();
    ecp_world *w = advance_scene(8, 0.2, 0.1, 0.05);
    ecp_advance_report r;
    ecp_real x[3] = {1, 1, 1};
    double theta = 0;
    advance_velocity(w, 1, 1, 0, 5);
    o.macro_step = (ecp_real)H;
    o.order = order;
    CHECK(ecp_advance(w, ECP_R(0.24), &o, &r) == ECP_OK);
    CHECK(r.first_order == 0 && r.highest_order == order);
    CHECK(r.macro_steps == (int)(0.24 / H + 0.5));
    ecp_body_get_state(w, 1, x, NULL, NULL, NULL);
    theta = (double)x[0];
    free(w);
    return theta;
}

static void advance_order(void)
{
    double exact = advance_paced(8, 0.02);
    int order;
    if (sizeof(ecp_real) == sizeof(float)) return; /* below what rounding leaves */
    for (order = 2; order <= 4; order++) {
        double rough = fabs(advance_paced(order, 0.04) - exact);
        double fine = fabs(advance_paced(order, 0.02) - exact);
        CHECK(rough / fine > 0.7 * pow(2, order));
        CHECK(fine < rough);
    }
}

/* a body at rest costs nothing, however long */
static void advance_rest(void)
{
    ecp_world *w = advance_scene(8, 0.3, 0, 0.05);
    ecp_advance_report r;
    ecp_real x[3] = {1, 1, 1};
    CHECK(ecp_advance(w, ECP_R(1e6), NULL, &r) == ECP_OK);
    CHECK(r.solves <= 12 && r.reached == ECP_R(1e6));
    ecp_body_get_state(w, 1, x, NULL, NULL, NULL);
    CHECK(x[0] == 0 && x[1] == 0);
    free(w);
}

/* What begins in the ground, or in another, is where they touch after that, and as fast as before. */
static void advance_overlap(void)
{
    int k;
    for (k = 0; k < 8; k++) {
        double depth = pow(10, -3 - (k / 2) * test_by(2, 1));
        ecp_world *w = advance_scene(8, 0, 0, 0.05 - (k % 2 ? 0 : depth));
        ecp_advance_options o = advance_options(1e-8, 1e-3);
        ecp_advance_report r;
        ecp_real x[3], v[3];
        ecp_shape s;
        advance_box(&s, 0.2, 0.1, 0.05);
        if (k % 2) advance_body(w, &s, NULL, 0, 0, 0.15 - depth);
        advance_velocity(w, 1, k % 2 ? 0 : 2, 0, 0);
        CHECK(ecp_advance(w, ECP_R(0.01), &o, &r) == ECP_OK);
        CHECK(r.forced == 0);
        ecp_body_get_state(w, 1, x, NULL, v, NULL);
        CHECK_NEAR(x[0], k % 2 ? 0 : 0.02, test_by(1e-9, 1e-5));
        CHECK_NEAR(x[2], 0.05, test_by(1e-9, 1e-6));
        CHECK_NEAR(v[2], 0, test_by(1e-9, 1e-4));
        if (k % 2) {
            ecp_body_get_state(w, 2, x, NULL, v, NULL);
            CHECK_NEAR(x[2], 0.15, test_by(1e-9, 1e-6));
            CHECK_NEAR(v[2], 0, test_by(1e-9, 1e-4));
        }
        free(w);
    }
}

/* kinetic and potential energy of body 1, 1 kg */
static double advance_energy(const ecp_world *w)
{
    const ecp_i_body *b = ecp_i_bodies(w) + 1;
    ecp_real x[3] = {0, 0, 0}, q[4] = {1, 0, 0, 0}, v[3] = {0, 0, 0}, spin[3] = {0, 0, 0}, R[9],
             I[9], L[3];
    ecp_body_get_state(w, 1, x, q, v, spin);
    ecp_quat_to_matrix(q, R);
    ecp_i_congruence(R, b->inertia, I);
    ecp_i_mul(I, spin, L);
    return (double)(ecp_i_dot(v, v) + ecp_i_dot(spin, L)) / 2 + 9.8 * (double)x[2];
}

/* A block that rocks to rest: infinitely many impacts in a finite time. Bounded work, the report says
   that first order was used, energy never grows, nothing penetrates, and every run gives the same bits. */
static void advance_accumulation(void)
{
    ecp_advance_options o = advance_options(1e-6, 1e-3);
    ecp_world *w = advance_world(8), *copy;
    ecp_material m = ecp_material_default();
    ecp_shape s;
    ecp_real x[3], q[4] = {1, 0, 0, 0}, v[3], spin[3] = {1, 1, 1};
    double al = atan2(0.1, 0.3), R = sqrt(0.1), energy, before;
    size_t n;
    int k, solves = 0;
    ecp_advance_report r;
    m.mu = 2;
    test_ground(w, 0, 0, 1, &m);
    advance_box(&s, 0.1, 0.1, 0.3);
    advance_body(w, &s, &m, 0, 0, 0);
    x[0] = (ecp_real)(0.1 - R * sin(al / 2));
    x[1] = 0;
    x[2] = (ecp_real)(R * cos(al / 2));
    q[0] = (ecp_real)cos(al / 4);
    q[2] = (ecp_real)sin(al / 4);
    CHECK(ecp_body_set_state(w, 1, x, q, NULL, NULL) == ECP_OK);
    n = ecp_world_memsize(&w->desc);
    copy = (ecp_world *)malloc(n);
    memcpy(copy, w, n);
    before = advance_energy(w);
    for (k = 0; k < 24; k++) {
        CHECK(ecp_advance(w, ECP_R(0.25), &o, &r) == ECP_OK);
        CHECK(ecp_advance(copy, ECP_R(0.25), &o, NULL) == ECP_OK);
        solves += r.solves;
        energy = advance_energy(w);
        CHECK(energy <= before + test_by(1e-5, 1e-2));
        before = energy;
        CHECK(certificate(w) >= -test_by(1e-11, 1e-5));
    }
    CHECK(memcmp(w, copy, n) == 0);
    CHECK(solves < 20000);
    ecp_body_get_state(w, 1, x, NULL, v, spin);
    CHECK_NEAR(x[2], 0.3, test_by(1e-6, 1e-3));
    CHECK_NEAR(ecp_i_norm(spin), 0, test_by(1e-6, 1e-2));
    free(copy);
    free(w);
}

/* thrown solids of every kind: each call ends where it should, without overlap, in bounded work */
static void advance_thrown(void)
{
    ecp_advance_options o = advance_options(1e-3, 1e-2);
    int kind, round, k;
    test_seed = 7;
    for (kind = 0; kind < 6; kind++) {
        for (round = 0; round < 2; round++) {
            ecp_world *w = advance_world(6);
            ecp_material m = ecp_material_default();
            ecp_real half[3] = {ECP_R(0.2), ECP_R(0.1), ECP_R(0.05)}, q[4], v[3], spin[3];
            ecp_advance_report r;
            ecp_shape s;
            double energy, least = 0;
            m.mu = ECP_R(0.4);
            m.e_r = round ? ECP_R(0.02) : 0;
            test_ground(w, 0, 0, 1, &m);
            if (kind == 0) ecp_shape_box(&s, half);
            if (kind == 1) ecp_shape_sphere(&s, ECP_R(0.1));
            if (kind == 2) ecp_shape_ellipsoid(&s, half);
            if (kind == 3) ecp_shape_capsule(&s, ECP_R(0.05), ECP_R(0.15));
            if (kind == 4) ecp_shape_cylinder(&s, ECP_R(0.1), ECP_R(0.1));
            if (kind == 5) ecp_shape_frustum(&s, ECP_R(0.1), ECP_R(0.05), ECP_R(0.1));
            advance_body(w, &s, &m, 0, 0, 0.3);
            for (k = 0; k < 4; k++) q[k] = (ecp_real)test_random();
            for (k = 0; k < 3; k++) v[k] = (ecp_real)test_random();
            for (k = 0; k < 3; k++) spin[k] = (ecp_real)(4 * test_random());
            ecp_body_set_state(w, 1, NULL, q, v, spin);
            energy = advance_energy(w);
            for (k = 0; k < 4; k++) {
                o.max_solves = 20000;
                CHECK(ecp_advance(w, ECP_R(0.15), &o, &r) == ECP_OK);
                CHECK(r.reached == ECP_R(0.15));
                if (certificate(w) < least) least = certificate(w);
                CHECK(advance_energy(w) <= energy + test_by(1e-3, 1e-1));
                energy = advance_energy(w);
            }
            CHECK(least >= -test_by(1e-10, 1e-5));
            CHECK(advance_clean(w));
            free(w);
        }
    }
}

/* A ball is thrown up under a ceiling (or hit, so that it is at rest as the call finds it), and falls as soon as it has
   met it, however long the macro steps in its flight are: base steps lag behind it, and many would turn back below
   the ceiling. */
static void advance_ceiling(void)
{
    const double g = 9.8, up = 5, until = 0.9;
    int k;
    for (k = 1; k <= 50; k++) {
        ecp_advance_options o = advance_options(1e-6, 1e-3);
        ecp_world *w = advance_world(8);
        ecp_shape s;
        double high = up * up / (2 * g) - 0.01 * k, meets = (up - sqrt(up * up - 2 * g * high)) / g;
        double fallen = g * (until - meets) * (until - meets) / 2;
        int body;
        test_ground(w, 0, 0, -1, NULL);
        CHECK(ecp_shape_sphere(&s, ECP_R(0.1)) == ECP_OK);
        body = advance_body(w, &s, NULL, 0, 0, -0.1 - high);
        if (k & 1) {
            advance_velocity(w, body, 0, up, 0);
        } else {
            const ecp_real hit[3] = {0, 0, ECP_R(5.0)};
            CHECK(ecp_body_apply_impulse(w, body, hit, NULL) == ECP_OK);
        }
        CHECK(ecp_advance(w, ECP_R(until), &o, NULL) == ECP_OK);
        CHECK_NEAR(ecp_i_bodies(w)[body].x[2], -0.1 - fallen,
                   test_by(1e-5, 1e-2) * fmax(1, fallen));
        free(w);
    }
}

/* A ball that flies past another, which stands fast, more or less in its way: what is left of its velocity is what is
   tangential where they meet. */
static void advance_graze(void)
{
    int k;
    for (k = 0; k < 19; k++) {
        ecp_advance_options o = advance_options(1e-6, 1e-3);
        ecp_world_desc d = ecp_world_desc_default();
        ecp_body_desc b = ecp_body_desc_default();
        ecp_material m = ecp_material_default();
        ecp_world *w;
        ecp_shape s;
        double side = 0.01 * k / 0.2;
        int body;
        d.advance_order = 8;
        d.gravity[2] = m.mu = 0;
        w = test_world(&d);
        b.kind = ECP_STATIC;
        CHECK(ecp_body_add(w, &b, &body) == ECP_OK);
        CHECK(ecp_shape_sphere(&s, ECP_R(0.1)) == ECP_OK);
        CHECK(ecp_body_add_shape(w, body, &s, NULL, NULL, &m, NULL) == ECP_OK);
        body = advance_body(w, &s, &m, -2, 0, 0.2 * side);
        advance_velocity(w, body, 1, 0, 0);
        CHECK(ecp_advance(w, 4, &o, NULL) == ECP_OK);
        CHECK_NEAR(ecp_i_bodies(w)[body].v[0], side * side, test_by(1e-4, 2e-2));
        CHECK_NEAR(ecp_i_bodies(w)[body].v[2], side * sqrt(1 - side * side), test_by(1e-4, 2e-2));
        free(w);
    }
}

static void advance_lifting(void *user, ecp_world *w, ecp_real time)
{
    ecp_real f[3] = {0, 0, 0};
    (void)user;
    f[2] = ECP_R(7.7) * time;
    CHECK(ecp_body_apply_force(w, 1, f, NULL) == ECP_OK);
}

/* A box of 1 kg is pulled until it lifts. Its gap then grows with the cube of time, from none: the way through the floor
   that a parabola would take is not its own, and costs no base steps. */
static void advance_lift(void)
{
    double late = 2 - 9.8 / 7.7;
    int k;
    for (k = 0; k < 2; k++) {
        ecp_advance_options o = advance_options(k ? 1e-8 : 1e-5, 1e-3);
        ecp_advance_report r;
        ecp_world *w = advance_world(8);
        ecp_shape s;
        int body;
        test_ground(w, 0, 0, 1, NULL);
        advance_box(&s, 0.1, 0.1, 0.05);
        body = advance_body(w, &s, NULL, 0, 0, 0.05);
        o.load = advance_lifting;
        CHECK(ecp_advance(w, 2, &o, &r) == ECP_OK);
        CHECK(r.solves < 150);
        CHECK_NEAR(ecp_i_bodies(w)[body].x[2], 0.05 + 7.7 * late * late * late / 6,
                   (double)o.tolerance);
        free(w);
    }
}

/* base steps for a ball that lands on the one or the two blocks of the floor, beside the seam */
static int advance_seam(int blocks)
{
    ecp_advance_options o = advance_options(1e-6, 1e-3);
    ecp_advance_report r;
    ecp_world *w = advance_world(8);
    ecp_body_desc b = ecp_body_desc_default();
    ecp_material m = ecp_material_default();
    ecp_shape s;
    int i, floor, body;
    m.mu = 0;
    b.kind = ECP_STATIC;
    CHECK(ecp_body_add(w, &b, &floor) == ECP_OK);
    for (i = 0; i < blocks; i++) {
        ecp_real at[3] = {ECP_R(-0.5), 0, ECP_R(-0.25)};
        if (i > 0) at[0] = ECP_R(0.5);
        advance_box(&s, 0.5, 0.5, 0.25);
        CHECK(ecp_body_add_shape(w, floor, &s, at, NULL, &m, NULL) == ECP_OK);
    }
    CHECK(ecp_shape_sphere(&s, ECP_R(0.1)) == ECP_OK);
    body = advance_body(w, &s, &m, -0.02, 0, 0.3);
    advance_velocity(w, body, -0.05, -3, 0);
    CHECK(ecp_advance(w, ECP_R(0.5), &o, &r) == ECP_OK && r.forced == 0);
    CHECK_NEAR(ecp_i_bodies(w)[body].x[0], -0.045, test_by(1e-6, 1e-3));
    CHECK_NEAR(ecp_i_bodies(w)[body].x[2], 0.1, test_by(1e-6, 1e-3));
    free(w);
    return r.solves;
}

/* a bar of 1.2 m to either side, 4 cm thick, that turns at 1 rad/s, and a ball of 5 cm, at rest, so far and at this angle
   from it; no weight, no friction */
static ecp_world *advance_bar(double far, double angle)
{
    ecp_world_desc d = ecp_world_desc_default();
    ecp_body_desc b = ecp_body_desc_default();
    ecp_material m = ecp_material_default();
    ecp_world *w;
    ecp_shape s;
    d.advance_order = 8;
    d.gravity[2] = m.mu = 0;
    w = test_world(&d);
    b.kind = ECP_KINEMATIC;
    b.angular_velocity[2] = 1;
    CHECK(ecp_body_add(w, &b, NULL) == ECP_OK);
    advance_box(&s, 1.2, 0.02, 0.2);
    CHECK(ecp_body_add_shape(w, 0, &s, NULL, NULL, &m, NULL) == ECP_OK);
    CHECK(ecp_shape_sphere(&s, ECP_R(0.05)) == ECP_OK);
    advance_body(w, &s, &m, far * cos(angle), far * sin(angle), 0);
    return w;
}

static double advance_ball_speed(const ecp_world *w)
{
    const ecp_real *v = ecp_i_bodies(w)[1].v;
    return sqrt((double)(v[0] * v[0] + v[1] * v[1]));
}

/* The bar comes round, in one call, to the ball, which it meets at the distance u along the bar and c before it. As seen
   from the bar the ball then moves along it at c, and u'^2 - u^2 stays until it leaves the end, at 1.2 m; across the bar it
   is as fast as that end. The bound is for what the end's corner adds. */
static void advance_paddle(void)
{
    int k;
    for (k = 0; k < 14; k++) {
        ecp_advance_options o = advance_options(1e-4, 1e-3);
        double far = 1.1, c = 0.07, along = sqrt(1.44 - (far * far - c * c) + c * c) - c;
        ecp_world *w = advance_bar(far, 0.3 + 0.2 * k);
        CHECK(ecp_advance(w, ECP_R(4.5), &o, NULL) == ECP_OK);
        CHECK_NEAR(advance_ball_speed(w), sqrt(1.44 + along * along), test_by(0.025, 0.1));
        free(w);
    }
}

/* The ball begins in the bar, deeper than its own radius: moved out at rest, it is no faster after that than the bar's
   end, and a little along it. */
static void advance_deep(void)
{
    int k;
    for (k = 0; k < 12; k++) {
        ecp_advance_options o = advance_options(1e-4, 1e-3);
        ecp_world *w = advance_bar(1.02 + 0.03 * (k / 3), 3.1 + 0.025 * (k % 3));
        const ecp_real *x;
        double along, across;
        CHECK(ecp_advance(w, ECP_R(0.3), &o, NULL) == ECP_OK);
        CHECK(advance_ball_speed(w) < 1.5);
        x = ecp_i_bodies(w)[1].x;
        along = fabs((double)x[0] * cos(0.3) + (double)x[1] * sin(0.3)) - 1.2;
        across = fabs((double)x[1] * cos(0.3) - (double)x[0] * sin(0.3)) - 0.02;
        CHECK(hypot(fmax(along, 0), fmax(across, 0)) >= 0.05 - test_by(1e-5, 1e-4));
        free(w);
    }
}

/* Two pads close on a box that fits between them and has nowhere to go: there is no such motion, however short the base
   steps, and nothing has moved. */
static void advance_gripper(void)
{
    int k, side;
    for (k = 0; k < 3; k++) {
        ecp_body_desc b = ecp_body_desc_default();
        ecp_world_desc d = ecp_world_desc_default();
        ecp_world *w, *before;
        ecp_shape s;
        int body;
        d.advance_order = 8;
        d.gravity[2] = 0;
        w = test_world(&d);
        advance_box(&s, 0.1, 0.1, 0.1);
        b.kind = ECP_KINEMATIC;
        for (side = -1; side < 2; side += 2) {
            b.position[0] = ECP_R(0.2) * (ecp_real)side;
            b.velocity[0] = ECP_R(-0.1) * (ecp_real)side;
            CHECK(ecp_body_add(w, &b, &body) == ECP_OK);
            CHECK(ecp_body_add_shape(w, body, &s, NULL, NULL, NULL, NULL) == ECP_OK);
        }
        advance_body(w, &s, NULL, 0, 0, 0);
        before = test_copy_world(w);
        CHECK(ecp_advance(w, ECP_R(0.01) * (ecp_real)(1 + 9 * k), NULL, NULL) == ECP_NOT_SOLVED);
        CHECK(memcmp(w, before, w->bytes) == 0);
        free(before);
        free(w);
    }
}

/* The way that a macro step is taken to go: from the saved pose to the world's, at their velocities; after an impact at the
   velocity of the last alone. */
static void advance_way(void)
{
    static const double parts[4] = {0, 1, 1e-3, 1 - 1e-3};
    ecp_world *w = advance_scene(4, 0.5, 0, 1), *ends[2];
    const ecp_real from[4] = {ECP_R(0.9), ECP_R(0.3), ECP_R(0.2), ECP_R(0.1)},
                   origin[3] = {0, 0, 0};
    const ecp_real x[3] = {1, ECP_R(0.5), 2}, q[4] = {ECP_R(0.8), ECP_R(-0.2), ECP_R(0.4), 0};
    const ecp_real before[3] = {-2, 1, 1}, v[3] = {3, -1, 2}, spin[3] = {1, 2, -1};
    int impact, end, j, k;
    CHECK(ecp_body_set_state(w, 1, NULL, from, before, before) == ECP_OK);
    ends[0] = test_copy_world(w);
    CHECK(ecp_body_set_state(w, 1, x, q, v, spin) == ECP_OK);
    ends[1] = w;
    for (impact = 0; impact < 2; impact++) {
        ecp_i_posed p[4], want;
        ecp_i_advance a;
        ecp_i_way way;
        memset(&a, 0, sizeof a);
        a.w = w;
        a.saved = (unsigned char *)ends[0];
        a.H = ECP_R(0.5);
        a.impact = impact;
        ecp_i_way_of(&a, 1, origin, &way);
        for (k = 0; k < 4; k++) ecp_i_pose_on_way(&way, (ecp_real)parts[k], p + k);
        for (end = 0; end < 2; end++) {
            const ecp_real *u = ecp_i_bodies(ends[end])[1].v;
            double by = 0.5 * (end ? -1e-3 : 1e-3), off = 0;
            ecp_i_pose_of(ends[end], 1, origin, &want);
            for (k = 0; k < 3; k++) CHECK_NEAR(p[end].x[k], want.x[k], test_by(1e-14, 1e-6));
            for (k = 0; k < 9; k++) CHECK_NEAR(p[end].Q[k], want.Q[k], test_by(1e-14, 1e-6));
            /* x' = v and Q' = w x Q, by a difference over a thousandth of the way */
            for (j = 0; j < 3; j++) {
                const ecp_real *Q = want.Q + j, *then = p[2 + end].Q + j;
                double turned[3];
                turned[0] = (double)(u[4] * Q[6] - u[5] * Q[3]);
                turned[1] = (double)(u[5] * Q[0] - u[3] * Q[6]);
                turned[2] = (double)(u[3] * Q[3] - u[4] * Q[0]);
                off = fmax(off, fabs((double)(p[2 + end].x[j] - want.x[j]) / by - (double)u[j]));
                for (k = 0; k < 3; k++) {
                    double rate = (double)(then[3 * k] - Q[3 * k]) / by;
                    off = fmax(off, fabs(rate - turned[k]));
                }
            }
            if (impact && !end)
                CHECK(off > 1);
            else
                CHECK_NEAR(off, 0, 0.05);
        }
    }
    free(ends[0]);
    free(w);
}

/* A box slides and spins flat on the ground without torsional friction. When it sticks it goes on turning, about a point
   that wanders over its face as friction turns with it: the spin stays as it was, there is no tilt, and the speed
   stays what it is then, w times the place of the contact where friction is at its limit, mu times the height. */
static void advance_pivot(void)
{
    static const double speeds[3] = {1, 0.3, 0.7};
    int k, j;
    for (k = 0; k < 3; k++) {
        ecp_advance_options o = advance_options(1e-6, 1e-3);
        ecp_world *w = advance_scene(8, 0.5, 0, 0.05);
        advance_velocity(w, 1, speeds[k], 0, 4);
        o.max_solves = 5000;
        for (j = 0; j < 2; j++) {
            ecp_advance_report r;
            ecp_real v[3], spin[3];
            CHECK(ecp_advance(w, ECP_R(0.3), &o, &r) == ECP_OK && r.forced == 0);
            ecp_body_get_state(w, 1, NULL, NULL, v, spin);
            CHECK_NEAR(spin[2], 4, test_by(1e-9, 1e-4));
            CHECK_NEAR(spin[0], 0, test_by(1e-9, 1e-3));
            CHECK_NEAR(spin[1], 0, test_by(1e-9, 1e-3));
            CHECK_NEAR(v[2], 0, test_by(1e-9, 1e-4));
            CHECK_NEAR(sqrt((double)v[0] * (double)v[0] + (double)v[1] * (double)v[1]),
                       4 * 0.5 * 0.05, test_by(5e-6, 5e-4));
        }
        free(w);
    }
}

/* A table on three cylinders of different friction, without torsion, slides until one leg sticks, and turns about it:
   what one tolerance says another one says as well. */
static void advance_legs(void)
{
    double end[2][3];
    int k, i;
    for (k = 0; k < 2; k++) {
        ecp_advance_options o = advance_options(k ? 1e-9 : 1e-7, 0);
        ecp_advance_report r;
        ecp_world *w = advance_world(8);
        ecp_material m = ecp_material_default();
        ecp_body_desc b = ecp_body_desc_default();
        ecp_shape s;
        ecp_real v[3], spin[3];
        m.mu = 1;
        m.e_r = 1;
        test_ground(w, 0, 0, 1, &m);
        b.mass = 10;
        b.inertia[0] = b.inertia[4] = ECP_R(0.5);
        b.inertia[8] = ECP_R(0.9);
        b.position[2] = ECP_R(0.1);
        b.velocity[0] = 1;
        b.velocity[1] = ECP_R(-0.5);
        CHECK(ecp_body_add(w, &b, NULL) == ECP_OK);
        CHECK(ecp_shape_cylinder(&s, ECP_R(0.1), ECP_R(0.1)) == ECP_OK);
        m.e_r = 0;
        for (i = 0; i < 3; i++) {
            static const double mu[3] = {0.02, 0.2, 0.6};
            ecp_real at[3] = {0, 0, 0};
            at[0] = ECP_R(0.3 * cos(2.0943951023931953 * i));
            at[1] = ECP_R(0.3 * sin(2.0943951023931953 * i));
            m.mu = (ecp_real)(mu[i] * mu[i]);
            CHECK(ecp_body_add_shape(w, 1, &s, at, NULL, &m, NULL) == ECP_OK);
        }
        o.max_solves = 20000;
        CHECK(ecp_advance(w, ECP_R(0.35), &o, &r) == ECP_OK && r.forced == 0);
        ecp_body_get_state(w, 1, NULL, NULL, v, spin);
        end[k][0] = (double)v[0];
        end[k][1] = (double)v[1];
        end[k][2] = (double)spin[2];
        free(w);
    }
    for (i = 0; i < 3; i++) CHECK_NEAR(end[1][i], end[0][i], 5e-6);
}

/* an angular impulse about the axis of a needle, which is not the world's: all of it becomes spin about that axis */
static void advance_needle(void)
{
    ecp_world *w = advance_world(4);
    ecp_body_desc b = ecp_body_desc_default();
    ecp_real q[4], R[9], L[3], spin[3];
    int i, body;
    b.inertia[0] = b.inertia[4] = 1;
    b.inertia[8] = ECP_R(1e-6);
    b.rotation[0] = ECP_R(0.9);
    b.rotation[1] = ECP_R(0.3);
    b.rotation[2] = ECP_R(0.5);
    b.rotation[3] = ECP_R(0.2);
    CHECK(ecp_body_add(w, &b, &body) == ECP_OK);
    ecp_body_get_state(w, body, NULL, q, NULL, NULL);
    ecp_quat_to_matrix(q, R);
    for (i = 0; i < 3; i++) L[i] = R[3 * i + 2] * ECP_R(1e-6);
    ecp_body_apply_angular_impulse(w, body, L);
    CHECK(ecp_advance(w, 0, NULL, NULL) == ECP_OK);
    ecp_body_get_state(w, body, NULL, NULL, NULL, spin);
    CHECK_NEAR(R[2] * spin[0] + R[5] * spin[1] + R[8] * spin[2], 1, test_by(1e-9, 1e-3));
    free(w);
}

/* Bodies are parted at rest before the first step if they overlap, and by more than the rounding of their poses: flush
   cubes do not, and to part them down to rounding took most of the time of short calls. */
static void advance_overlaps(void)
{
    int k;
    for (k = 0; k < 200; k++) {
        ecp_world *w = advance_world(4);
        double yaw = 0.05 * k;
        ecp_real x[3] = {0, 0, ECP_R(0.5)}, q[4] = {0, 0, 0, 0};
        int body[2], i;
        test_ground(w, 0, 0, 1, NULL);
        q[0] = (ecp_real)cos(yaw / 2);
        q[3] = (ecp_real)sin(yaw / 2);
        for (i = 0; i < 2; i++) {
            body[i] = test_box(w, 1, 0.5, 0.5, 0.5, 0, 0, 0, NULL);
            x[0] = (ecp_real)(i * cos(yaw));
            x[1] = (ecp_real)(i * sin(yaw));
            CHECK(ecp_body_set_state(w, body[i], x, q, NULL, NULL) == ECP_OK);
        }
        CHECK(!ecp_i_overlaps(w));
        for (i = 0; i < 2; i++) x[i] *= (ecp_real)(1 - test_by(1e-9, 1e-3));
        CHECK(ecp_body_set_state(w, body[1], x, q, NULL, NULL) == ECP_OK);
        CHECK(ecp_i_overlaps(w));
        free(w);
    }
}

/* y = a x b */
static void advance_cross(const double *a, const double *b, double *y)
{
    y[0] = a[1] * b[2] - a[2] * b[1];
    y[1] = a[2] * b[0] - a[0] * b[2];
    y[2] = a[0] * b[1] - a[1] * b[0];
}

/* y = R diag(d) R^T x, R of the quaternion q */
static void advance_turned(const double *q, const double *d, const double *x, double *y)
{
    const double *u = q + 1;
    double a[3], b[3], own[3];
    int k;
    /* to the body, R^T x = x - 2 q0 u x x + 2 u x (u x x), and back */
    advance_cross(u, x, a);
    advance_cross(u, a, b);
    for (k = 0; k < 3; k++) own[k] = d[k] * (x[k] - 2 * q[0] * a[k] + 2 * b[k]);
    advance_cross(u, own, a);
    advance_cross(u, a, b);
    for (k = 0; k < 3; k++) y[k] = own[k] + 2 * q[0] * a[k] + 2 * b[k];
}

/* d y / dt of an egg that slips on the ground: y = x, q, v, w. Returns its normal force, negative where it slips no
   more, or no longer touches. */
static double advance_egg_rate(const double *y, double *rate)
{
    static const double up[3] = {0, 0, 1}, axes[3] = {0.04, 0.04, 0.09}, g = 9.8, mu = 0.3;
    static const double inertia[3] = {0.026, 0.026, 0.016},
                        inverse[3] = {1 / 0.026, 1 / 0.026, 1 / 0.016};
    const double *q = y + 3, *v = y + 7, *w = y + 10;
    double Dn[3], dDn[3], r[3], dr[3], slip[3], f[3], a[3], b[3], free[3], by[3], s, ds, n, speed;
    int k;
    advance_turned(q, axes, up, Dn);
    s = sqrt(Dn[2]);
    advance_cross(w, up, a);
    advance_turned(q, axes, a, b);
    advance_cross(w, Dn, dDn);
    for (k = 0; k < 3; k++) dDn[k] -= b[k];
    ds = dDn[2] / (2 * s);
    for (k = 0; k < 3; k++) {
        r[k] = -Dn[k] / s;
        dr[k] = -dDn[k] / s + Dn[k] * ds / (s * s);
    }
    advance_cross(w, r, slip);
    for (k = 0; k < 3; k++) slip[k] += v[k];
    speed = sqrt(slip[0] * slip[0] + slip[1] * slip[1]);
    f[0] = -mu * slip[0] / speed;
    f[1] = -mu * slip[1] / speed;
    f[2] = 1;
    /* the turn's acceleration is free + n by; the contact has none along the normal */
    advance_turned(q, inertia, w, a);
    advance_cross(a, w, b);
    advance_turned(q, inverse, b, free);
    advance_cross(r, f, a);
    advance_turned(q, inverse, a, by);
    advance_cross(free, r, a);
    n = g - a[2];
    advance_cross(w, dr, a);
    n -= a[2];
    advance_cross(by, r, a);
    n /= 1 + a[2];
    advance_cross(w, q + 1, a);
    rate[3] = -(w[0] * q[1] + w[1] * q[2] + w[2] * q[3]) / 2;
    for (k = 0; k < 3; k++) {
        rate[k] = v[k];
        rate[4 + k] = (q[0] * w[k] + a[k]) / 2;
        rate[7 + k] = n * f[k] - g * up[k];
        rate[10 + k] = free[k] + n * by[k];
    }
    return speed > 1e-3 ? n : -1;
}

/* y at the time t, by the Runge-Kutta method of the fourth order */
static double advance_egg_at(double t, int steps, double *y)
{
    static const double part[4] = {0, 0.5, 0.5, 1};
    double h = t / steps, least = 1e30;
    int i, j, k;
    for (i = 0; i < steps; i++) {
        double at[13], rate[13], sum[13] = {0};
        for (j = 0; j < 4; j++) {
            for (k = 0; k < 13; k++) at[k] = y[k] + (j ? h * part[j] * rate[k] : 0);
            least = fmin(least, advance_egg_rate(at, rate));
            for (k = 0; k < 13; k++) sum[k] += h / (j % 3 ? 3 : 6) * rate[k];
        }
        for (k = 0; k < 13; k++) y[k] += sum[k];
    }
    return least;
}

/* An egg that spins at 40 rad/s and slips: what holds it down is nearly all of what its contact's curve takes. With a
   lead-in whose way ahead closed the gap each first base step was free of the ground, and the spin was off at all
   tolerances. (Tolerances are of 40 rad/s here.) */
static void advance_egg(void)
{
    ecp_advance_options o = advance_options(1e-6, 1e-3);
    ecp_world *w = advance_world(8);
    ecp_material m = ecp_material_default();
    ecp_real axes[3], spin[3] = {0, 0, 40}, q[4] = {0, 0, 0, 0}, x[3], turn[3];
    ecp_shape s;
    ecp_advance_report r;
    double y[13] = {0}, T = 0.4;
    int k;
    axes[0] = axes[1] = ECP_R(0.2);
    axes[2] = ECP_R(0.3);
    m.mu = ECP_R(0.3);
    test_ground(w, 0, 0, 1, &m);
    y[3] = cos(0.65);
    y[4] = sin(0.65);
    y[2] = sqrt(0.09 * cos(1.3) * cos(1.3) + 0.04 * sin(1.3) * sin(1.3));
    y[12] = 40;
    CHECK(ecp_shape_ellipsoid(&s, axes) == ECP_OK);
    advance_body(w, &s, &m, 0, 0, y[2]);
    for (k = 0; k < 4; k++) q[k] = (ecp_real)y[3 + k];
    CHECK(ecp_body_set_state(w, 1, NULL, q, NULL, spin) == ECP_OK);
    CHECK(ecp_advance(w, (ecp_real)T, &o, &r) == ECP_OK);
    CHECK(r.forced == 0);
    CHECK(advance_egg_at(T, 20000, y) > 0);
    ecp_body_get_state(w, 1, x, NULL, NULL, turn);
    for (k = 0; k < 3; k++) {
        CHECK_NEAR(x[k], y[k], test_by(2e-6, 2e-3));
        CHECK_NEAR(turn[k], y[10 + k], test_by(4e-5, 4e-2));
    }
    free(w);
}

/* d y / dt of a plank of 2 m x 0.1 m that rocks without slip on a cylinder of 0.5 m: its angle and rate */
static void advance_plank_rate(const double *y, double *rate)
{
    const double R = 0.5, half = 0.05, I = (1 + 0.0025) / 3;
    rate[0] = y[1];
    rate[1] = (9.8 * (half * sin(y[0]) - R * y[0] * cos(y[0])) - R * R * y[0] * y[1] * y[1]) /
              (I + half * half + R * R * y[0] * y[0]);
}

/* Contacts of two primitives turn with them. Poses were put back on to them along the normals of the last base step,
   which moved the plank aside, whatever the tolerance, and reported nothing of it. */
static void advance_plank(void)
{
    static const double tolerances[3] = {1e-4, 1e-6, 1e-7};
    double y[2] = {0.3, 0}, h = 2.0 / 20000;
    int i, j, k;
    for (i = 0; i < 20000; i++) {
        double a[4][2], at[2];
        for (j = 0; j < 4; j++) {
            for (k = 0; k < 2; k++) at[k] = y[k] + (j ? (j < 3 ? h / 2 : h) * a[j - 1][k] : 0);
            advance_plank_rate(at, a[j]);
        }
        for (k = 0; k < 2; k++) y[k] += h / 6 * (a[0][k] + 2 * (a[1][k] + a[2][k]) + a[3][k]);
    }
    for (i = 0; i < (sizeof(ecp_real) == sizeof(double) ? 3 : 1); i++) {
        ecp_advance_options o = advance_options(tolerances[i], 1e-3);
        ecp_world *w = advance_world(8);
        ecp_body_desc b = ecp_body_desc_default();
        ecp_material m = ecp_material_default();
        ecp_real lie[4] = {1, 1, 0, 0}, q[4] = {0, 0, 0, 0}, spin[3];
        ecp_shape s;
        ecp_advance_report r;
        m.mu = 5;
        m.e_r = ECP_R(0.1);
        b.kind = ECP_STATIC;
        ecp_i_quat_unit(lie, b.rotation);
        CHECK(ecp_shape_cylinder(&s, ECP_R(0.5), ECP_R(0.4)) == ECP_OK);
        CHECK(ecp_body_add(w, &b, NULL) == ECP_OK);
        CHECK(ecp_body_add_shape(w, 0, &s, NULL, NULL, &m, NULL) == ECP_OK);
        advance_box(&s, 1, 0.1, 0.05);
        advance_body(w, &s, &m, 0.55 * sin(0.3) - 0.15 * cos(0.3), 0,
                     0.55 * cos(0.3) + 0.15 * sin(0.3));
        q[0] = (ecp_real)cos(0.15);
        q[2] = (ecp_real)sin(0.15);
        CHECK(ecp_body_set_state(w, 1, NULL, q, NULL, NULL) == ECP_OK);
        CHECK(ecp_advance(w, 2, &o, &r) == ECP_OK);
        CHECK(r.forced == 0);
        ecp_body_get_state(w, 1, NULL, q, NULL, spin);
        CHECK_NEAR(2 * atan2((double)q[2], (double)q[0]), y[0], 3 * (double)o.tolerance);
        CHECK_NEAR(spin[1], y[1], 3 * (double)o.tolerance);
        free(w);
    }
}

/* A force along x at the centre of the body *user, that grows until it tips. */
static void advance_tipping(void *user, ecp_world *world, ecp_real t)
{
    int body = *(int *)user;
    ecp_real f[3] = {0, 0, 0};
    f[0] = 6 * t;
    CHECK(ecp_body_apply_force(world, body, f, NULL) == ECP_OK);
}

/* A box that tips on the ground, on a large box that was added before it, and on one added after. Of two primitives that
   have faces the rim ahead may be that of either: with A's alone the large box before it was off by 2.1e-8 m. */
static void advance_tips(void)
{
    double x[3];
    int k;
    for (k = 0; k < 3; k++) {
        ecp_world *w = advance_world(8);
        ecp_advance_options o = advance_options(1e-7, 1e-3);
        ecp_material m = ecp_material_default();
        ecp_shape box, large;
        ecp_body_desc table = ecp_body_desc_default();
        ecp_real at[3];
        int body = -1, floor = -1;
        table.kind = ECP_STATIC;
        table.position[2] = -1;
        m.mu = 2;
        advance_box(&box, 0.1, 0.1, 0.3);
        advance_box(&large, 4, 4, 1);
        if (k == 0) test_ground(w, 0, 0, 1, &m);
        if (k == 2) body = advance_body(w, &box, &m, 0, 0, 0.3);
        if (k > 0) {
            CHECK(ecp_body_add(w, &table, &floor) == ECP_OK);
            CHECK(ecp_body_add_shape(w, floor, &large, NULL, NULL, &m, NULL) == ECP_OK);
        }
        if (k < 2) body = advance_body(w, &box, &m, 0, 0, 0.3);
        o.load = advance_tipping;
        o.load_user = &body;
        CHECK(ecp_advance(w, ECP_R(0.75), &o, NULL) == ECP_OK);
        CHECK(ecp_body_get_state(w, body, at, NULL, NULL, NULL) == ECP_OK);
        x[k] = (double)at[0];
        free(w);
    }
    CHECK(x[0] > 5e-3);
    CHECK_NEAR(x[1], x[0], test_by(1e-9, 2e-4));
    CHECK_NEAR(x[2], x[0], test_by(1e-9, 2e-4));
    printf("tips in %s: %.9f m on the ground, %.2e and %.2e off on boxes\n",
           sizeof(ecp_real) == sizeof(double) ? "double" : "float", x[0], x[1] - x[0], x[2] - x[0]);
}

static void test_advance_section(void)
{
    advance_memory();
    advance_nobody();
    advance_short_of_room();
    advance_forced();
    advance_falls();
    advance_refuses();
    advance_nested_parts();
    advance_truths();
    advance_spin();
    advance_table();
    advance_landing();
    advance_loads();
    advance_thrust();
    advance_slow_load();
    advance_for_ages();
    advance_peaks();
    advance_driven();
    advance_free_rotation();
    advance_short();
    advance_units();
    advance_order();
    advance_rest();
    advance_overlap();
    advance_overlaps();
    advance_accumulation();
    advance_thrown();
    advance_way();
    advance_ceiling();
    advance_graze();
    advance_lift();
    CHECK(advance_seam(2) == advance_seam(1));
    advance_paddle();
    advance_deep();
    advance_gripper();
    advance_pivot();
    if (sizeof(ecp_real) == sizeof(double)) advance_legs();
    advance_needle();
    advance_egg();
    advance_plank();
    advance_tips();
}
