/* Contact reports: that they are consistent with each other and with the motion, friction in all
   its forms, guesses, and the closed form for translation. */

/* the largest f_i of a primitive at a world point: zero on its surface */
static double contact_level(const ecp_world *world, int shape, const ecp_real point[3])
{
    const ecp_shape *s;
    ecp_real x[3], Q[9], local[3], f[32], g[96];
    double most = -1e300;
    int i, k;
    CHECK(ecp_shape_get(world, shape, &s, NULL, x, Q) == ECP_OK);
    for (k = 0; k < 3; k++) {
        local[k] =
            Q[k] * (point[0] - x[0]) + Q[3 + k] * (point[1] - x[1]) + Q[6 + k] * (point[2] - x[2]);
    }
    CHECK(s->inequalities <= 32);
    s->cls->eval(s, local, f, g);
    for (i = 0; i < s->inequalities; i++) most = fmax(most, (double)f[i]);
    return most;
}

static double contact_dot(const ecp_real *a, const double *b)
{
    return (double)a[0] * b[0] + (double)a[1] * b[1] + (double)a[2] * b[2];
}

/* One report against the states after the step. Lengths are compared to 1e-9 m, velocities to
   1e-8 m/s and impulses to 1e-9 of m v: the solver's 1e-12 with room for the square root that a
   residual at a corner (p_n = d = 0) may hide; float likewise from 1e-5. */
static void contact_consistent(const ecp_world *world, const ecp_contact *c)
{
    const double x = test_by(1e-9, 1e-4), v_tol = test_by(1e-8, 5e-3), p_tol = test_by(1e-9, 2e-3);
    test_state a = test_get(world, c->body_a), b = test_get(world, c->body_b);
    double v[3], spin[3], slip[3], y = 0, power = 0, size = 0;
    const double e[3] = {(double)c->e_t, (double)c->e_o, (double)c->e_r};
    const double p[3] = {(double)c->p_t, (double)c->p_o, (double)c->p_r};
    double cone = (double)c->mu * (double)c->p_n;
    int k;
    /* (t, o, normal) is orthonormal and right-handed */
    for (k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        double cross = (double)c->direction_t[i] * (double)c->direction_o[j] -
                       (double)c->direction_t[j] * (double)c->direction_o[i];
        CHECK_NEAR(cross, c->normal[k], test_by(1e-11, 1e-5));
        size += (double)c->normal[k] * (double)c->normal[k];
    }
    CHECK_NEAR(size, 1, test_by(1e-11, 1e-5));
    /* the ECPs are on the surfaces, the gap apart against the normal, and the normal points to A */
    for (k = 0; k < 3; k++) {
        CHECK_NEAR(c->point_b[k] - c->point_a[k], -c->gap * c->normal[k], x);
    }
    CHECK_NEAR(contact_level(world, c->shape_a, c->point_a), 0, x);
    CHECK_NEAR(contact_level(world, c->shape_b, c->point_b), 0, x);
    CHECK((double)c->gap >= -x);
    CHECK_NEAR(c->separation, c->gap, x);
    {
        const ecp_shape *A;
        ecp_real at[3], Q[9];
        double n[3], lowest[3];
        CHECK(ecp_shape_get(world, c->shape_a, &A, NULL, at, Q) == ECP_OK);
        for (k = 0; k < 3; k++) n[k] = -(double)c->normal[k];
        certificate_farthest(A, at, Q, n, lowest);
        CHECK_NEAR(contact_dot(c->normal, lowest) + contact_dot(c->point_a, n), 0, x);
    }
    /* impulses: none across a gap, in the cone, against the slip as equation:friction says */
    CHECK(c->p_n >= 0);
    if (c->mode == ECP_APART) {
        CHECK(c->p_n == 0 && c->p_t == 0 && c->p_o == 0 && c->p_r == 0 && c->sigma == 0);
        return;
    }
    CHECK_NEAR(c->gap, 0, x);
    for (k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        v[k] = a.v[k] - b.v[k];
        v[k] +=
            a.w[i] * ((double)c->point_a[j] - a.x[j]) - a.w[j] * ((double)c->point_a[i] - a.x[i]);
        v[k] -=
            b.w[i] * ((double)c->point_a[j] - b.x[j]) - b.w[j] * ((double)c->point_a[i] - b.x[i]);
        spin[k] = a.w[k] - b.w[k];
    }
    slip[0] = contact_dot(c->direction_t, v);
    slip[1] = contact_dot(c->direction_o, v);
    slip[2] = contact_dot(c->normal, spin);
    for (k = 0, size = 0; k < 3; k++) {
        if (e[k] > 0)
            y += p[k] / e[k] * (p[k] / e[k]);
        else
            CHECK_NEAR(p[k], 0, 0);
        size += e[k] * slip[k] * e[k] * slip[k];
        power += p[k] * slip[k];
        CHECK_NEAR(p[k] * (double)c->sigma, -e[k] * e[k] * cone * slip[k], p_tol * (1 + cone));
    }
    size = sqrt(size);
    CHECK(sqrt(y) <= cone + p_tol * (1 + cone));
    CHECK(power <= p_tol);
    CHECK_NEAR(c->sigma, cone > 0 ? size : 0, v_tol);
    if (c->mode == ECP_STICK) CHECK_NEAR(size, 0, v_tol);
    if (c->mode == ECP_SLIP) CHECK_NEAR(sqrt(y), cone, p_tol * (1 + cone));
}

/* A step with every report checked, and the balance of momentum of every body: m dv is its weight
   and the reported impulses, I dw their moments and -h w x I w, with I and w of the beginning. */
static void contact_advance(ecp_world *world, double h)
{
    ecp_world *before = test_copy_world(world);
    int i, j, k;
    test_advance(world, h, NULL);
    for (i = 0; i < ecp_contact_count(world); i++) {
        ecp_contact c = test_contact(world, i);
        contact_consistent(world, &c);
    }
    for (j = 0; j < ecp_world_body_count(world); j++) {
        const ecp_i_body *b = ecp_i_bodies(before) + j;
        test_state s = test_get(before, j), end = test_get(world, j);
        double linear[3], angular[3], w[3], dw[3], Iw[3], Idw[3], m = (double)b->mass;
        if (b->kind != ECP_DYNAMIC) continue;
        for (k = 0; k < 3; k++) {
            linear[k] = h * m * (double)world->desc.gravity[k] - m * (end.v[k] - s.v[k]);
            linear[k] += (double)b->impulse[k] + h * (double)b->force[k];
            w[k] = dw[k] = 0;
            for (i = 0; i < 3; i++) {
                w[k] += s.R[3 * i + k] * s.w[i];
                dw[k] += s.R[3 * i + k] * (end.w[i] - s.w[i]);
            }
        }
        for (k = 0; k < 3; k++) {
            for (Iw[k] = Idw[k] = 0, i = 0; i < 3; i++) {
                Iw[k] += (double)b->inertia[3 * k + i] * w[i];
                Idw[k] += (double)b->inertia[3 * k + i] * dw[i];
            }
        }
        for (k = 0; k < 3; k++) {
            for (i = 0; i < 3; i++) {
                int u = (i + 1) % 3, v = (i + 2) % 3;
                if (i == 0) angular[k] = (double)b->impulse[3 + k] + h * (double)b->force[3 + k];
                angular[k] -= s.R[3 * k + i] * (Idw[i] + h * (w[u] * Iw[v] - w[v] * Iw[u]));
            }
        }
        for (i = 0; i < ecp_contact_count(world); i++) {
            ecp_contact c = test_contact(world, i);
            double p[3], r[3], sign = c.body_a == j ? 1 : -1;
            if (c.body_a != j && c.body_b != j) continue;
            for (k = 0; k < 3; k++) {
                p[k] = sign * ((double)c.p_n * (double)c.normal[k] +
                               (double)c.p_t * (double)c.direction_t[k] +
                               (double)c.p_o * (double)c.direction_o[k]);
                r[k] = (double)c.point_a[k] - end.x[k];
                linear[k] += p[k];
                angular[k] += sign * (double)c.p_r * (double)c.normal[k];
            }
            for (k = 0; k < 3; k++) {
                angular[k] += r[(k + 1) % 3] * p[(k + 2) % 3] - r[(k + 2) % 3] * p[(k + 1) % 3];
            }
        }
        for (k = 0; k < 3; k++) {
            CHECK_NEAR(linear[k] / m, 0, test_by(1e-9, 2e-3));
            CHECK_NEAR(angular[k] / m, 0, test_by(1e-9, 2e-3));
        }
    }
    free(before);
}

static void test_contacts_consistent(void)
{
    ecp_world *world;
    ecp_material m = test_material(0.4, 1, 1, 0.05), rough = test_material(0.6, 0.8, 1.3, 0.1);
    ecp_world_desc d = ecp_world_desc_default();
    ecp_shape s;
    int body, k, modes[3] = {0, 0, 0}, i;
    /* a box that tumbles, slides and comes to rest on ground with anisotropic friction */
    world = test_world(NULL);
    rough.direction[0] = 1;
    rough.direction[1] = ECP_R(0.4);
    test_ground(world, 0, 0, 1, &rough);
    body = test_box(world, 2, 0.3, 0.2, 0.1, 0, 0, 0, &m);
    test_set_pose(world, body, 0, 0, 0.4, 1, 2, 0.5, 0.7);
    test_set_velocity(world, body, 2, 0.5, -1, 3, -2, 1);
    for (k = 0; k < 120; k++) {
        contact_advance(world, 0.01);
        for (i = 0; i < ecp_contact_count(world); i++) modes[test_contact(world, i).mode]++;
    }
    /* it has gone through all of them */
    CHECK(modes[ECP_APART] > 0 && modes[ECP_STICK] > 0 && modes[ECP_SLIP] > 0);
    free(world);
    /* a capsule that falls on a box that slides on the ground: a pair of convex bodies */
    d.max_inequalities = 16;
    world = test_world(&d);
    test_ground(world, 0, 0, 1, &m);
    body = test_box(world, 5, 0.5, 0.4, 0.1, 0, 0, 0.1, &m);
    test_set_velocity(world, body, 1, 0.3, 0, 0, 0, 0.5);
    CHECK(ecp_shape_capsule(&s, ECP_R(0.1), ECP_R(0.2)) == ECP_OK);
    body = test_body(world, ECP_DYNAMIC, 1, 0.03, 0.03, 0.01, 0, 0, 0);
    test_attach(world, body, &s, 0, 0, 0, &m);
    test_set_pose(world, body, 0.1, 0, 0.5, 1, 0.3, 0.2, 1.2);
    for (k = 0; k < 80; k++) contact_advance(world, 0.01);
    free(world);
    /* an ellipsoid beside a cylinder on one plate, which is a union that rests on three balls */
    d.max_patches = 20;
    world = test_world(&d);
    test_ground(world, 0, 0, 1, &m);
    body = test_body(world, ECP_DYNAMIC, 6, 0.6, 0.6, 1, 0, 0, 0.2);
    s = test_box_shape(0.6, 0.5, 0.05);
    test_attach(world, body, &s, 0, 0, 0.05, &m);
    CHECK(ecp_shape_sphere(&s, ECP_R(0.1)) == ECP_OK);
    for (k = 0; k < 3; k++)
        test_attach(world, body, &s, 0.4 * cos(2.1 * k), 0.4 * sin(2.1 * k), -0.1, &m);
    test_add_primitive(world, 1, 0.3, 0, 0.6, 1, 1, 0, 0.3, &m);
    test_add_primitive(world, 3, -0.2, 0.1, 0.6, 1, 0.2, 0, 0.2, &m);
    test_set_velocity(world, body, 0.5, 0, 0, 0, 0, 1);
    for (k = 0; k < 60; k++) contact_advance(world, 0.01);
    free(world);
}

/* ---- anisotropic friction */

/* one step of a puck without spin: v_k' = v_k s / (s + a_k), a_k = e_k^2 mu g h, where s is the
   root of sum e_k^2 v_k^2 / (s + a_k)^2 = 1; at rest when that is less than 1 at s = 0 */
static void contact_puck(double v[2], const double e[2], double loss)
{
    double lo = 0, hi = 1, s, sum;
    int i, k, grow = 1;
    for (i = 0; i < 200; i++) {
        s = i == 0 ? 0 : grow ? hi : (lo + hi) / 2;
        for (k = 0, sum = 0; k < 2; k++) {
            double q = e[k] * v[k] / (s + e[k] * e[k] * loss);
            sum += q * q;
        }
        if (i == 0 && sum <= 1) break;
        if (i == 0) continue;
        if (grow && sum > 1)
            hi *= 2;
        else if (grow)
            grow = 0;
        else if (sum > 1)
            lo = s;
        else
            hi = s;
    }
    if (i == 0) hi = 0;
    for (k = 0; k < 2; k++) v[k] *= hi > 0 ? hi / (hi + e[k] * e[k] * loss) : 0;
}

/* The puck's scene, turned as a whole by `angle` about the axis (1, 2, 2) / 3. The direction of
   e_t is at `tilt` in the plane, in the ground's material or in the puck's. */
static ecp_world *contact_puck_world(double angle, double tilt, int on_puck, int *puck, double R[9])
{
    ecp_material plain = test_material(0.3, 0.5, 1.2, 0.1), grain = plain;
    ecp_world *world = test_world(NULL);
    test_state s;
    grain.direction[0] = (ecp_real)cos(tilt);
    grain.direction[1] = (ecp_real)sin(tilt);
    {
        ecp_body_desc b = ecp_body_desc_default();
        ecp_real up[3] = {0, 0, 1};
        ecp_shape ground;
        int body;
        b.kind = ECP_STATIC;
        CHECK(ecp_body_add(world, &b, &body) == ECP_OK);
        test_set_pose(world, body, 0, 0, 0, 1, 2, 2, angle);
        CHECK(ecp_shape_half_space(&ground, up, 0) == ECP_OK);
        test_attach(world, body, &ground, 0, 0, 0, on_puck ? &plain : &grain);
        s = test_get(world, body);
        memcpy(R, s.R, 9 * sizeof(double));
    }
    *puck = test_box(world, 2, 0.3, 0.3, 0.1, 0, 0, 0, on_puck ? &grain : &plain);
    test_set_pose(world, *puck, 0.1 * R[2], 0.1 * R[5], 0.1 * R[8], 1, 2, 2, angle);
    test_set_velocity(world, *puck, 2 * R[0] + R[1], 2 * R[3] + R[4], 2 * R[6] + R[7], 0, 0, 0);
    test_set_gravity(world, -9.8 * R[2], -9.8 * R[5], -9.8 * R[8]);
    return world;
}

static void test_contacts_anisotropic(void)
{
    const double e[2] = {0.5, 1.2};
    int variant, k, i;
    for (variant = 0; variant < 4; variant++) {
        double tilt = 0.6, R[9], t[2], v[2], x[3] = {0, 0, 0}, first, turned, c = cos(tilt),
               n = sin(tilt);
        int puck;
        ecp_world *world = contact_puck_world(variant < 2 ? 0 : 1.1, tilt, variant & 1, &puck, R);
        t[0] = 2 * c + n;
        t[1] = c - 2 * n;
        first = turned = atan2(t[1], t[0]);
        for (k = 0; k < 320; k++) {
            test_state s;
            ecp_contact report;
            contact_puck(t, e, 0.3 * 9.8 * 0.01);
            if (t[0] > 0) turned = atan2(t[1], t[0]);
            v[0] = c * t[0] - n * t[1];
            v[1] = n * t[0] + c * t[1];
            for (i = 0; i < 2; i++) x[i] += 0.01 * v[i];
            contact_advance(world, 0.01);
            s = test_get(world, puck);
            report = test_contact(world, 0);
            for (i = 0; i < 3; i++) {
                CHECK_NEAR(s.v[i], R[3 * i] * v[0] + R[3 * i + 1] * v[1], test_by(1e-10, 2e-4));
                CHECK_NEAR(s.x[i], R[3 * i] * x[0] + R[3 * i + 1] * x[1] + 0.1 * R[3 * i + 2],
                           test_by(1e-10, 2e-4));
                CHECK_NEAR(report.direction_t[i], R[3 * i] * c + R[3 * i + 1] * n,
                           test_by(1e-9, 1e-4));
            }
            CHECK(report.mode == (t[0] > 0 ? ECP_SLIP : ECP_STICK));
        }
        /* the path curves, towards the direction that friction brakes less */
        CHECK(fabs(turned) < fabs(first) - 0.02);
        CHECK_NEAR(t[0], 0, 0);
        free(world);
    }
}

/* On a spinning puck the grain turns along; after each step direction_t is where it was at the
   beginning of the step. Of two directions the one of the primitive that was added first counts. */
static void test_contacts_direction(void)
{
    ecp_material ground = test_material(0.3, 0.5, 1.2, 0.1), own = ground;
    int both, puck, k;
    own.direction[1] = 1;
    for (both = 0; both < 2; both++) {
        ecp_world *world = test_world(NULL);
        ground.direction[0] = (ecp_real)both;
        test_ground(world, 0, 0, 1, &ground);
        puck = test_box(world, 2, 0.3, 0.3, 0.1, 0, 0, 0.1, &own);
        test_set_velocity(world, puck, 1, 0, 0, 0, 0, 6);
        for (k = 0; k < 30; k++) {
            test_state s = test_get(world, puck);
            ecp_contact c;
            contact_advance(world, 0.01);
            c = test_contact(world, 0);
            CHECK_NEAR(c.direction_t[0], both ? 1 : s.R[1], test_by(1e-9, 1e-4));
            CHECK_NEAR(c.direction_t[1], both ? 0 : s.R[4], test_by(1e-9, 1e-4));
        }
        free(world);
    }
}

/* Without a direction the tangents are some axis of the world, the same one in each step of a box that slides over
   another, whose normal is off by rounding. */
static void test_contacts_tangents(void)
{
    ecp_material m = test_material(0.4, 1, 0.5, 0);
    int run, k, i, known = 0;
    for (run = 0; run < 6; run++) {
        ecp_world *world = test_world(NULL);
        double angle = 0.2 + 0.3 * run, way[2] = {0, 0};
        int box;
        test_ground(world, 0, 0, 1, &m);
        test_set_pose(world, test_box(world, 20, 2, 2, 0.1, 0, 0, 0.1, &m), 0, 0, 0.1, 0, 0, 1,
                      angle);
        box = test_box(world, 1, 0.1, 0.1, 0.05, 0, 0, 0.25, &m);
        test_set_velocity(world, box, 2, 1, 0, 0, 0, 0);
        for (k = 0; k < 40; k++) {
            contact_advance(world, 0.005);
            for (i = 0; i < ecp_contact_count(world); i++) {
                ecp_contact c = test_contact(world, i);
                if (c.body_b != box && c.body_a != box) continue;
                if (k > 0) {
                    CHECK_NEAR(c.direction_t[0], way[0], test_by(1e-9, 1e-3));
                    CHECK_NEAR(c.direction_t[1], way[1], test_by(1e-9, 1e-3));
                }
                way[0] = (double)c.direction_t[0];
                way[1] = (double)c.direction_t[1];
                known++;
            }
        }
        free(world);
    }
    CHECK(known == 6 * 40);
}

static void test_contacts_mixing(void)
{
    ecp_material a = test_material(0.2, 0.5, 2, 0.01), b = test_material(0.8, 2, 0.5, 0.04);
    ecp_world *world = test_world(NULL);
    ecp_contact c;
    int box;
    test_ground(world, 0, 0, 1, &a);
    box = test_box(world, 2, 0.2, 0.2, 0.1, 0, 0, 0.1, &b);
    test_set_velocity(world, box, 1, 0, 0, 0, 0, 0);
    contact_advance(world, 0.01);
    c = test_contact(world, 0);
    CHECK_NEAR(c.mu, 0.4, test_by(1e-15, 1e-7));
    CHECK_NEAR(c.e_t, 1, test_by(1e-15, 1e-7));
    CHECK_NEAR(c.e_o, 1, test_by(1e-15, 1e-7));
    CHECK_NEAR(c.e_r, 0.02, test_by(1e-16, 1e-8));
    /* and it is what brakes: mu g h */
    CHECK_NEAR(test_get(world, box).v[0], 1 - 0.4 * 9.8 * 0.01, test_by(1e-12, 1e-5));
    CHECK(ecp_contact_get(world, 1, &c) == ECP_BAD_INDEX);
    CHECK(ecp_contact_get(world, -1, &c) == ECP_BAD_INDEX);
    CHECK(ecp_contact_get(world, 0, NULL) == ECP_BAD_POINTER);
    CHECK(ecp_contact_get(NULL, 0, &c) == ECP_BAD_POINTER);
    free(world);
    /* one side without friction: none at all */
    world = test_world(NULL);
    a.mu = 0;
    test_ground(world, 0, 0, 1, &a);
    box = test_box(world, 2, 0.2, 0.2, 0.1, 0, 0, 0.1, &b);
    test_set_velocity(world, box, 1, 0, 0, 0, 0, 2);
    contact_advance(world, 0.01);
    CHECK_NEAR(test_get(world, box).v[0], 1, test_by(1e-13, 1e-6));
    CHECK_NEAR(test_get(world, box).w[2], 2, test_by(1e-13, 1e-6));
    free(world);
}

/* ---- guesses */

static void test_contacts_guess(void)
{
    ecp_material m = test_material(0.5, 1, 1, 0.1);
    ecp_real at[3] = {0, 0, 0}, bad[3] = {0, 0, 0};
    const ecp_real turned[4] = {ECP_R(0.9), ECP_R(0.3), ECP_R(0.2), ECP_R(0.1)};
    ecp_options o = ecp_options_default();
    int rule, side, k, box, other, still;
    /* A face that hovers over the plane: any of its points may be the ECP. `nearest` takes the
       guess, `centred` the middle, and what the guess was does not show. */
    for (rule = 0; rule < 2; rule++) {
        for (side = -1; side < 2; side += 2) {
            ecp_world *world = test_world(NULL);
            ecp_contact c;
            test_ground(world, 0, 0, 1, &m);
            test_set_gravity(world, 0, 0, 0);
            box = test_box(world, 2, 0.2, 0.3, 0.1, 0, 0, 0.1001, &m);
            at[0] = (ecp_real)(0.1 * side);
            at[1] = ECP_R(-0.2);
            at[2] = ECP_R(1e-4);
            o.rule = rule ? ECP_CENTRED : ECP_NEAREST;
            CHECK(ecp_guess_ecp(world, side < 0 ? 0 : 1, side < 0 ? 1 : 0, at) == ECP_OK);
            CHECK(ecp_contact_count(world) == 0); /* a guess is not a report */
            test_advance(world, 0.01, &o);
            CHECK(ecp_contact_count(world) == 1);
            c = test_contact(world, 0);
            CHECK(c.mode == ECP_APART);
            CHECK_NEAR(c.gap, 1e-4, test_by(1e-12, 1e-6));
            CHECK_NEAR(c.point_a[0], rule ? 0 : 0.1 * side, test_by(1e-9, 1e-4));
            CHECK_NEAR(c.point_a[1], rule ? 0 : -0.2, test_by(1e-9, 1e-4));
            free(world);
        }
    }
    at[2] = 0;
    /* A stool on two runners that slides without turning: the ECPs follow the guess under
       `nearest`, the motion does not */
    {
        double x[2], ecp[2];
        for (side = 0; side < 2; side++) {
            ecp_world *world = test_world(NULL);
            ecp_shape runner = test_box_shape(0.3, 0.05, 0.1);
            test_ground(world, 0, 0, 1, &m);
            box = test_body(world, ECP_DYNAMIC, 3, 0.1, 0.1, 0.2, 0, 0, 0.15);
            test_attach(world, box, &runner, 0, -0.2, -0.05, &m);
            test_attach(world, box, &runner, 0, 0.2, -0.05, &m);
            test_set_velocity(world, box, 0, 1, 0, 0, 0, 0);
            at[0] = (ecp_real)(side ? 0.2 : -0.2);
            o.rule = ECP_NEAREST;
            for (k = 1; k <= 2; k++) {
                at[1] = (ecp_real)(k == 1 ? -0.2 : 0.2);
                CHECK(ecp_guess_ecp(world, 0, k, at) == ECP_OK);
                at[0] = -at[0];
            }
            for (k = 0; k < 10; k++) test_advance(world, 0.01, &o);
            x[side] = test_get(world, box).x[1];
            ecp[side] = (double)test_contact(world, 0).point_a[0];
            free(world);
        }
        CHECK_NEAR(x[0], x[1], test_by(1e-11, 1e-4));
        CHECK(fabs(ecp[0] - ecp[1]) > 0.1);
    }
    /* what a guess must be */
    {
        ecp_world *world = test_world(NULL), *before;
        ecp_shape s = test_box_shape(0.1, 0.1, 0.1);
        test_ground(world, 0, 0, 1, &m);
        box = test_box(world, 2, 0.2, 0.3, 0.1, 0, 0, 0.1, &m);
        other = test_attach(world, box, &s, 0, 0, 0.3, &m);
        still =
            test_attach(world, test_body(world, ECP_STATIC, 0, 0, 0, 0, 3, 0, 0), &s, 0, 0, 0, &m);
        CHECK(ecp_body_set_state(world, box, NULL, turned, NULL, NULL) == ECP_OK);
        before = test_copy_world(world);
        bad[1] = (ecp_real)NAN;
        CHECK(ecp_guess_ecp(NULL, 0, 1, at) == ECP_BAD_POINTER);
        CHECK(ecp_guess_ecp(world, 0, 1, NULL) == ECP_BAD_POINTER);
        CHECK(ecp_guess_ecp(world, 0, 1, bad) == ECP_NOT_FINITE);
        /* finite, but not as the box sees it */
        for (k = 0; k < 3; k++) bad[k] = (ecp_real)test_by(1.7e308, 3e38);
        CHECK(ecp_guess_ecp(world, 0, 1, bad) == ECP_NOT_FINITE);
        CHECK(ecp_guess_ecp(world, 0, 4, at) == ECP_BAD_INDEX);
        CHECK(ecp_guess_ecp(world, -1, 1, at) == ECP_BAD_INDEX);
        CHECK(ecp_guess_ecp(world, 1, 1, at) == ECP_BAD_INDEX);
        CHECK(ecp_guess_ecp(world, 1, other, at) == ECP_BAD_KIND); /* of one body */
        CHECK(ecp_guess_ecp(world, 0, still, at) == ECP_BAD_KIND); /* neither moves */
        CHECK(memcmp(world, before, world->bytes) == 0);
        free(before);
        free(world);
    }
}

/* ---- the closed form for translation */

/* The closed form against steps of a flat box, whose ECP stays inside its face, on inclined
   ground and under random impulses: it slips, sticks and is lifted off. */
static void test_contacts_translation(void)
{
    int seen[3] = {0, 0, 0}, k, i;
    test_seed = 5;
    for (k = 0; k < 60; k++) {
        double nx = 0.3 * test_random(), ny = 0.3 * test_random(), nz = 1, size, along = 0,
               strength;
        double tolerance = test_by(1e-11, 2e-4), e = 1 + 0.3 * test_random(), p[3];
        ecp_material m = test_material(0.4, e, e, 0.1);
        ecp_world *world = test_world(NULL);
        ecp_real n[3], J[3], v[3], v_out[3], impulse[3], kick[3];
        ecp_mode mode;
        test_state s;
        double angle, N[3];
        int box;
        size = sqrt(nx * nx + ny * ny + nz * nz);
        N[0] = nx / size;
        N[1] = ny / size;
        N[2] = nz / size;
        angle = acos(N[2]);
        test_ground(world, nx, ny, nz, &m);
        box = test_box(world, 2, 0.5, 0.5, 0.1, 0, 0, 0, &m);
        test_set_pose(world, box, 0.1 * N[0], 0.1 * N[1], 0.1 * N[2], -N[1], N[0], 0, angle);
        /* a velocity in the plane, of a third of them zero; a weak impulse, or a strong one
           upwards */
        strength = k % 4 == 3 ? 0.5 : 0.05;
        for (i = 0; i < 3; i++) v[i] = (ecp_real)(k % 3 ? test_random() : 0);
        for (i = 0; i < 3; i++) along += N[i] * (double)v[i];
        for (i = 0; i < 3; i++) v[i] -= (ecp_real)(along * N[i]);
        for (i = 0; i < 3; i++) {
            n[i] = (ecp_real)N[i];
            kick[i] = (ecp_real)(strength * (i == 2 ? 1 : test_random()));
            J[i] = kick[i] - (i == 2 ? ECP_R(2 * 9.8 * 0.01) : 0);
        }
        CHECK(ecp_body_set_state(world, box, NULL, NULL, v, NULL) == ECP_OK);
        CHECK(ecp_body_apply_impulse(world, box, kick, NULL) == ECP_OK);
        mode = ecp_translation_step(2, n, ECP_R(0.4), (ecp_real)e, J, v, v_out, impulse);
        seen[mode]++;
        contact_advance(world, 0.01);
        s = test_get(world, box);
        test_impulse(world, p);
        for (i = 0; i < 3; i++) {
            CHECK_NEAR(s.v[i], v_out[i], tolerance);
            CHECK_NEAR(p[i], impulse[i], tolerance);
            CHECK_NEAR(s.w[i], 0, 10 * tolerance);
        }
        CHECK(test_contact(world, 0).mode == mode);
        free(world);
    }
    CHECK(seen[ECP_APART] >= 5 && seen[ECP_STICK] >= 5 && seen[ECP_SLIP] >= 5);
}

static void test_contacts(void)
{
    test_contacts_consistent();
    test_contacts_anisotropic();
    test_contacts_direction();
    test_contacts_tangents();
    test_contacts_mixing();
    test_contacts_guess();
    test_contacts_translation();
}
