/* The world: every bad input has its own status and changes nothing, snapshots are worlds, memory
   is what was asked for, loads act once. Where nothing is rounded, comparisons are exact. */
#include "test.h"

#include <limits.h>

typedef struct world_fixture {
    ecp_world *world;
    unsigned char *copy;
    size_t bytes, state;
    int ground, box, rail, half_space, box_shape, rail_shape;
} world_fixture;

enum { WORLD_NAN, WORLD_INF, WORLD_MINUS_INF };

static ecp_real world_bad_number(int which)
{
    if (which == WORLD_NAN) return ECP_R(NAN);
    return which == WORLD_INF ? ECP_R(INFINITY) : -ECP_R(INFINITY);
}

static ecp_shape world_box(double x, double y, double z)
{
    ecp_shape s;
    ecp_real half[3];
    ecp_i_set3(ECP_R(x), ECP_R(y), ECP_R(z), half);
    CHECK(ecp_shape_box(&s, half) == ECP_OK);
    return s;
}

static int world_work_is_zero(const ecp_world *w, size_t bytes)
{
    const unsigned char *p = (const unsigned char *)w;
    size_t i;
    for (i = ecp_world_state_size(w); i < bytes; i++) {
        if (p[i] != 0) return 0;
    }
    return 1;
}

/* a floor, a box that slides on it and turns, and a kinematic ball that flies past; patches and
   loads are there, so that there is something to spoil */
static void world_setup(world_fixture *f)
{
    ecp_world_desc desc = ecp_world_desc_default();
    ecp_body_desc d = ecp_body_desc_default();
    ecp_shape shape = world_box(0.3, 0.2, 0.1);
    ecp_real force[3] = {1, 2, 3};
    int k;
    desc.max_bodies = 3;
    desc.max_shapes = 3;
    f->world = test_world(&desc);
    f->bytes = ecp_world_memsize(&desc);
    f->state = ecp_world_state_size(f->world);
    f->copy = (unsigned char *)malloc(f->bytes);
    f->ground = test_ground(f->world, 0, 0, 1, NULL);
    f->half_space = 0;
    d.mass = 2;
    ecp_i_set3(ECP_R(0.1), ECP_R(-0.2), ECP_R(0.1), d.position);
    ecp_i_set3(1, ECP_R(0.5), 0, d.velocity);
    ecp_i_set3(0, 0, 2, d.angular_velocity);
    d.inertia[0] = d.inertia[4] = d.inertia[8] = ECP_R(0.1);
    CHECK(ecp_body_add(f->world, &d, &f->box) == ECP_OK);
    CHECK(ecp_body_add_shape(f->world, f->box, &shape, NULL, NULL, NULL, &f->box_shape) == ECP_OK);
    d.kind = ECP_KINEMATIC;
    ecp_i_set3(2, 2, 2, d.position);
    CHECK(ecp_shape_sphere(&shape, ECP_R(0.2)) == ECP_OK);
    CHECK(ecp_body_add(f->world, &d, &f->rail) == ECP_OK);
    CHECK(ecp_body_add_shape(f->world, f->rail, &shape, NULL, NULL, NULL, &f->rail_shape) ==
          ECP_OK);
    for (k = 0; k < 3; k++) CHECK(ecp_step(f->world, ECP_R(0.01), NULL, NULL) == ECP_OK);
    CHECK(ecp_contact_count(f->world) > 0);
    CHECK(ecp_body_apply_force(f->world, f->box, force, NULL) == ECP_OK);
    CHECK(world_work_is_zero(f->world, f->bytes));
    memcpy(f->copy, f->world, f->bytes);
}

static void world_free(world_fixture *f)
{
    free(f->world);
    free(f->copy);
}

/* the call was refused with this status, and no bit of the block has changed */
#define WORLD_REFUSED(f, call, status) world_refused(f, call, status, #call, __LINE__)

static void world_refused(world_fixture *f, ecp_status got, ecp_status wanted, const char *text,
                          int line)
{
    int same = memcmp(f->world, f->copy, f->bytes) == 0;
    if (got != wanted) {
        printf("line %d: \"%s\" instead of \"%s\"\n", line, ecp_status_string(got),
               ecp_status_string(wanted));
    }
    test_check(got == wanted, text, __FILE__, line);
    test_check(same, text, "world changed by", line);
    memcpy(f->world, f->copy, f->bytes);
}

/* ---- statuses */

static void world_test_strings(void)
{
    static const ecp_status all[] = {
#define WORLD_STATUS(name, value, text) name,
        ECP_STATUS_LIST(WORLD_STATUS)
#undef WORLD_STATUS
    };
    int count = (int)(sizeof all / sizeof *all), i, j;
    CHECK(count == 22);
    CHECK(ECP_OK == 0);
    for (i = 0; i < count; i++) {
        CHECK(strlen(ecp_status_string(all[i])) > 0);
        if (all[i] != ECP_OK) CHECK(all[i] < 0);
        for (j = 0; j < i; j++) {
            CHECK(all[i] != all[j]);
            CHECK(strcmp(ecp_status_string(all[i]), ecp_status_string(all[j])) != 0);
        }
    }
    CHECK(strlen(ecp_status_string((ecp_status)-30)) > 0); /* not a status */
}

/* ---- init and memory */

static void world_test_init(void)
{
    ecp_world_desc d = ecp_world_desc_default(), bad;
    size_t need = ecp_world_memsize(&d), i;
    unsigned char *mem = (unsigned char *)malloc(need + 64), *block = mem + 32;
    ecp_world *w = NULL;
    int k, which, intact = 1;
    CHECK(((size_t)block & 7) == 0);
    CHECK(need > 0 && need % 8 == 0);
    CHECK(d.max_bodies == 8 && d.max_shapes == 32 && d.max_patches == 16 &&
          d.max_inequalities == 12);
    CHECK(d.gravity[0] == 0 && d.gravity[1] == 0 && d.gravity[2] == ECP_R(-9.8));
    memset(mem, 0xa5, need + 64);
    CHECK(ecp_world_init(NULL, &d, block, need) == ECP_BAD_POINTER);
    CHECK(ecp_world_init(&w, NULL, block, need) == ECP_BAD_POINTER);
    CHECK(ecp_world_init(&w, &d, NULL, need) == ECP_BAD_POINTER);
    CHECK(ecp_world_init(&w, &d, block, need - 1) == ECP_MEMORY_SMALL);
    CHECK(ecp_world_init(&w, &d, block, 0) == ECP_MEMORY_SMALL);
    for (k = 1; k < 8; k++) {
        CHECK(ecp_world_init(&w, &d, block + k, need) == ECP_MEMORY_ALIGN);
    }
    CHECK(ecp_world_memsize(NULL) == 0);
    for (k = 0; k < 4; k++) {
        for (which = 0; which < 4; which++) {
            static const int values[4] = {0, -1, INT_MIN, INT_MAX};
            bad = d;
            if (k == 0) bad.max_bodies = values[which];
            if (k == 1) bad.max_shapes = values[which];
            if (k == 2) bad.max_patches = values[which];
            if (k == 3) bad.max_inequalities = values[which];
            CHECK(ecp_world_memsize(&bad) == 0);
            CHECK(ecp_world_init(&w, &bad, block, need) == ECP_BAD_OPTION);
        }
    }
    for (k = 0; k < 3; k++) {
        for (which = 0; which < 3; which++) {
            bad = d;
            bad.gravity[k] = world_bad_number(which);
            CHECK(ecp_world_init(&w, &bad, block, need) == ECP_NOT_FINITE);
        }
    }
    CHECK(w == NULL);
    /* what no size_t holds */
    bad = d;
    bad.solver_bytes = (size_t)-1;
    CHECK(ecp_world_memsize(&bad) == 0);
    CHECK(ecp_world_init(&w, &bad, block, need) == ECP_BAD_OPTION && w == NULL);
    for (i = 0; i < need + 64; i++) intact &= mem[i] == 0xa5;
    CHECK(intact);

    CHECK(ecp_world_init(&w, &d, block, need) == ECP_OK);
    CHECK((void *)w == (void *)block);
    CHECK(ecp_world_state_size(w) > 0 && ecp_world_state_size(w) < need);
    CHECK(ecp_world_body_count(w) == 0 && ecp_world_shape_count(w) == 0);
    CHECK(ecp_contact_count(w) == 0);
    CHECK(world_work_is_zero(w, need));
    /* an empty world can be stepped */
    CHECK(ecp_step(w, ECP_R(0.01), NULL, NULL) == ECP_OK);
    for (i = 0, intact = 1; i < 32; i++) intact &= mem[i] == 0xa5 && mem[need + 32 + i] == 0xa5;
    CHECK(intact);
    CHECK(ecp_world_body_count(NULL) == 0 && ecp_world_shape_count(NULL) == 0);
    CHECK(ecp_world_state_size(NULL) == 0 && ecp_contact_count(NULL) == 0);
    free(mem);

    /* The size of a large description is not one that an int overflow made: the least that a step
       of all bodies needs is one real for each pair of velocities of two bodies that touch, and for
       each patch its kept contact; or else the description is out of range */
    for (k = 0; k < 2; k++) {
        bad = d;
        bad.max_bodies = k ? 100 : 10000;
        bad.max_patches = k ? 100000 : 16;
        bad.max_inequalities = k ? 1000 : 12;
        need = ecp_world_memsize(&bad);
        CHECK(need == 0 || (double)need > (double)bad.max_bodies * 6 * 6 * sizeof(ecp_real) +
                                              (double)bad.max_patches * sizeof(ecp_contact));
        CHECK(need == 0 || need > ecp_world_memsize(&d));
    }
}

/* ---- bodies */

static void world_test_bodies(void)
{
    ecp_world_desc desc = ecp_world_desc_default();
    world_fixture f;
    ecp_body_desc d, good = ecp_body_desc_default();
    int k, which, body = -7;
    ecp_real g[3];
    desc.max_bodies = 2;
    f.world = test_world(&desc);
    f.bytes = ecp_world_memsize(&desc);
    f.copy = (unsigned char *)malloc(f.bytes);
    memcpy(f.copy, f.world, f.bytes);

    WORLD_REFUSED(&f, ecp_body_add(NULL, &good, &body), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_body_add(f.world, NULL, &body), ECP_BAD_POINTER);
    for (which = 0; which < 3; which++) {
        ecp_real bad = world_bad_number(which);
        for (k = 0; k < 3; k++) {
            d = good;
            d.position[k] = bad;
            WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), ECP_NOT_FINITE);
            d.kind = ECP_STATIC;
            WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), ECP_NOT_FINITE);
            d = good;
            d.velocity[k] = bad;
            WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), ECP_NOT_FINITE);
            d.kind = ECP_KINEMATIC;
            WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), ECP_NOT_FINITE);
            d = good;
            d.angular_velocity[k] = bad;
            WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), ECP_NOT_FINITE);
            ecp_i_set3(0, 0, 0, g);
            g[k] = bad;
            WORLD_REFUSED(&f, ecp_world_set_gravity(f.world, g), ECP_NOT_FINITE);
        }
        for (k = 0; k < 4; k++) {
            d = good;
            d.rotation[k] = bad;
            WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), ECP_NOT_FINITE);
        }
        for (k = 0; k < 9; k++) {
            d = good;
            d.inertia[k] = bad;
            WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), ECP_NOT_FINITE);
        }
        d = good;
        d.mass = bad;
        WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), ECP_NOT_FINITE);
    }
    WORLD_REFUSED(&f, ecp_world_set_gravity(f.world, NULL), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_world_set_gravity(NULL, g), ECP_BAD_POINTER);

    d = good;
    d.kind = (ecp_body_kind)3;
    WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), ECP_BAD_KIND);
    d = good;
    d.rotation[0] = 0;
    WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), ECP_BAD_ROTATION);
    d = good;
    d.mass = 0;
    WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), ECP_BAD_MASS);
    d.mass = -1;
    WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), ECP_BAD_MASS);
    d.mass = (ecp_real)test_by(1e-310, 1e-40);
    WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), ECP_BAD_MASS);
    CHECK(body == -7); /* the index is not written either */

    /* half a dozen inertias: (xx, yy, zz, xy, what is said of it) */
    {
        static const struct {
            double xx, yy, zz, xy, yx;
            ecp_status status;
        } cases[] = {
            {0, 0, 0, 0, 0, ECP_BAD_INERTIA},              /* nothing */
            {-1, -1, -1, 0, 0, ECP_BAD_INERTIA},           /* negative */
            {1, 1, 0, 0, 0, ECP_BAD_INERTIA},              /* a point on the z axis */
            {1, 1, -0.5, 0, 0, ECP_BAD_INERTIA},           /* indefinite */
            {1, 1, 1, 0.5, 0, ECP_BAD_INERTIA},            /* not symmetric */
            {1, 1, 1, 1.5, 1.5, ECP_BAD_INERTIA},          /* indefinite, by its products */
            {1, 1, 2.001, 0, 0, ECP_BAD_INERTIA_TRIANGLE}, /* z above x + y */
            {3, 1, 1, 0, 0, ECP_BAD_INERTIA_TRIANGLE},
            {1, 1, 0.5, 0.6, 0.6, ECP_BAD_INERTIA_TRIANGLE}, /* principal 1.6, 0.4, 0.5 */
        };
        unsigned i;
        for (i = 0; i < sizeof cases / sizeof *cases; i++) {
            d = good;
            d.inertia[0] = ECP_R(cases[i].xx);
            d.inertia[4] = ECP_R(cases[i].yy);
            d.inertia[8] = ECP_R(cases[i].zz);
            d.inertia[1] = ECP_R(cases[i].xy);
            d.inertia[3] = ECP_R(cases[i].yx);
            WORLD_REFUSED(&f, ecp_body_add(f.world, &d, &body), cases[i].status);
        }
    }

    /* a flat disc is the limit of the triangle inequality, and allowed, in any frame of axes; a
       quaternion of any length is normalised; static bodies need no mass */
    {
        ecp_real q[4] = {ECP_R(0.3), ECP_R(-0.5), ECP_R(0.7), ECP_R(0.1)}, R[9], disc[9], out[4];
        double size = 0;
        memset(disc, 0, sizeof disc);
        disc[0] = disc[4] = ECP_R(0.3);
        disc[8] = ECP_R(0.6);
        d = good;
        memcpy(d.rotation, q, sizeof q);
        for (k = 0; k < 4; k++) size += (double)q[k] * (double)q[k];
        ecp_i_quat_normalise(q);
        ecp_quat_to_matrix(q, R);
        ecp_i_congruence(R, disc, d.inertia);
        CHECK(ecp_body_add(f.world, &d, &body) == ECP_OK && body == 0);
        CHECK(ecp_body_get_state(f.world, 0, NULL, out, NULL, NULL) == ECP_OK);
        for (k = 0; k < 4; k++) {
            CHECK_NEAR(out[k], (double)d.rotation[k] / sqrt(size), 4 * (double)ECP_I_EPSILON);
        }
        d.kind = ECP_STATIC;
        d.mass = 0;
        memset(d.inertia, 0, sizeof d.inertia);
        CHECK(ecp_body_add(f.world, &d, NULL) == ECP_OK);
        CHECK(ecp_world_body_count(f.world) == 2);
        memcpy(f.copy, f.world, f.bytes);
        WORLD_REFUSED(&f, ecp_body_add(f.world, &good, &body), ECP_CAPACITY);
        CHECK(body == 0);
    }
    world_free(&f);
}

static void world_test_state(void)
{
    world_fixture f;
    ecp_real v[3] = {1, 2, 3}, q[4] = {0, 3, 0, 4}, got[3] = {0}, got_q[4] = {0},
             zero[4] = {0, 0, 0, 0};
    int k, which, i;
    static const int bad_index[4] = {-1, 3, INT_MAX, INT_MIN};
    world_setup(&f);
    WORLD_REFUSED(&f, ecp_body_get_state(NULL, 0, v, NULL, NULL, NULL), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_body_set_state(NULL, 0, v, NULL, NULL, NULL), ECP_BAD_POINTER);
    for (i = 0; i < 4; i++) {
        WORLD_REFUSED(&f, ecp_body_get_state(f.world, bad_index[i], got, NULL, NULL, NULL),
                      ECP_BAD_INDEX);
        WORLD_REFUSED(&f, ecp_body_set_state(f.world, bad_index[i], v, NULL, NULL, NULL),
                      ECP_BAD_INDEX);
        WORLD_REFUSED(&f, ecp_shape_get(f.world, bad_index[i], NULL, NULL, got, NULL),
                      ECP_BAD_INDEX);
    }
    WORLD_REFUSED(&f, ecp_shape_get(NULL, 0, NULL, NULL, got, NULL), ECP_BAD_POINTER);
    for (which = 0; which < 3; which++) {
        for (k = 0; k < 3; k++) {
            ecp_real bad[3] = {0, 0, 0};
            bad[k] = world_bad_number(which);
            WORLD_REFUSED(&f, ecp_body_set_state(f.world, f.box, bad, NULL, NULL, NULL),
                          ECP_NOT_FINITE);
            WORLD_REFUSED(&f, ecp_body_set_state(f.world, f.box, v, NULL, bad, NULL),
                          ECP_NOT_FINITE);
            WORLD_REFUSED(&f, ecp_body_set_state(f.world, f.box, v, q, v, bad), ECP_NOT_FINITE);
        }
        for (k = 0; k < 4; k++) {
            ecp_real bad[4] = {1, 0, 0, 0};
            bad[k] = world_bad_number(which);
            WORLD_REFUSED(&f, ecp_body_set_state(f.world, f.box, v, bad, NULL, NULL),
                          ECP_NOT_FINITE);
        }
    }
    WORLD_REFUSED(&f, ecp_body_set_state(f.world, f.box, v, zero, NULL, NULL), ECP_BAD_ROTATION);
    WORLD_REFUSED(&f, ecp_body_set_state(f.world, f.ground, v, NULL, v, NULL), ECP_BAD_KIND);
    WORLD_REFUSED(&f, ecp_body_set_state(f.world, f.ground, v, NULL, NULL, v), ECP_BAD_KIND);

    /* NULL keeps what is there; what is set comes back */
    CHECK(ecp_body_get_state(f.world, f.box, NULL, NULL, got, NULL) == ECP_OK);
    CHECK(ecp_body_set_state(f.world, f.box, v, q, NULL, zero) == ECP_OK);
    {
        ecp_real x[3] = {0}, u[3] = {0}, w[3] = {0};
        CHECK(ecp_body_get_state(f.world, f.box, x, got_q, u, w) == ECP_OK);
        CHECK(memcmp(x, v, sizeof x) == 0 && memcmp(u, got, sizeof u) == 0);
        CHECK(w[0] == 0 && w[1] == 0 && w[2] == 0);
        CHECK_NEAR(got_q[1], 0.6, 2 * (double)ECP_I_EPSILON);
        CHECK_NEAR(got_q[3], 0.8, 2 * (double)ECP_I_EPSILON);
        CHECK(got_q[0] == 0 && got_q[2] == 0);
    }
    CHECK(ecp_body_set_state(f.world, f.ground, v, NULL, NULL, NULL) == ECP_OK);
    CHECK(ecp_body_set_state(f.world, f.ground, v, NULL, zero, zero) ==
          ECP_OK); /* as get gives it */
    CHECK(ecp_body_get_state(f.world, f.ground, got, NULL, NULL, NULL) == ECP_OK);
    CHECK(memcmp(got, v, sizeof v) == 0);
    world_free(&f);
}

/* ---- shapes on bodies */

static void world_test_shapes(void)
{
    world_fixture f;
    ecp_world_desc desc = ecp_world_desc_default();
    ecp_body_desc d = ecp_body_desc_default();
    ecp_shape box = world_box(1, 2, 3), plane, blank;
    ecp_real up[3] = {0, 0, 1}, x[3], q[4], R[9], got[3] = {0};
    const ecp_shape *kept = &box;
    ecp_material m;
    int k, which, index = -7, body = -1, i;
    static const int bad_index[4] = {-1, 2, INT_MAX, INT_MIN};
    desc.max_shapes = 2;
    desc.max_inequalities = 6;
    f.world = test_world(&desc);
    f.bytes = ecp_world_memsize(&desc);
    f.copy = (unsigned char *)malloc(f.bytes);
    ecp_i_set3(1, 0, 0, d.position);
    d.rotation[3] = 1; /* a quarter turn about z */
    CHECK(ecp_body_add(f.world, &d, NULL) == ECP_OK);
    d.kind = ECP_STATIC;
    CHECK(ecp_body_add(f.world, &d, NULL) == ECP_OK);
    memcpy(f.copy, f.world, f.bytes);
    memset(&blank, 0, sizeof blank);
    CHECK(ecp_shape_half_space(&plane, up, 0) == ECP_OK);

    WORLD_REFUSED(&f, ecp_body_add_shape(NULL, 0, &box, NULL, NULL, NULL, &index), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_body_add_shape(f.world, 0, NULL, NULL, NULL, NULL, &index),
                  ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_body_add_shape(f.world, 0, &blank, NULL, NULL, NULL, &index),
                  ECP_BAD_POINTER);
    for (i = 0; i < 4; i++) {
        WORLD_REFUSED(&f, ecp_body_add_shape(f.world, bad_index[i], &box, NULL, NULL, NULL, &index),
                      ECP_BAD_INDEX);
    }
    WORLD_REFUSED(&f, ecp_body_add_shape(f.world, 0, &plane, NULL, NULL, NULL, &index),
                  ECP_BAD_KIND);
    for (which = 0; which < 3; which++) {
        ecp_real bad = world_bad_number(which);
        for (k = 0; k < 3; k++) {
            ecp_i_set3(0, 0, 0, x);
            x[k] = bad;
            WORLD_REFUSED(&f, ecp_body_add_shape(f.world, 0, &box, x, NULL, NULL, &index),
                          ECP_NOT_FINITE);
            m = ecp_material_default();
            m.direction[k] = bad;
            WORLD_REFUSED(&f, ecp_body_add_shape(f.world, 0, &box, NULL, NULL, &m, &index),
                          ECP_NOT_FINITE);
        }
        for (k = 0; k < 4; k++) {
            q[0] = 1;
            ecp_i_set3(0, 0, 0, q + 1);
            q[k] = bad;
            WORLD_REFUSED(&f, ecp_body_add_shape(f.world, 0, &box, NULL, q, NULL, &index),
                          ECP_NOT_FINITE);
            m = ecp_material_default();
            if (k == 0) m.mu = bad;
            if (k == 1) m.e_t = bad;
            if (k == 2) m.e_o = bad;
            if (k == 3) m.e_r = bad;
            WORLD_REFUSED(&f, ecp_body_add_shape(f.world, 0, &box, NULL, NULL, &m, &index),
                          ECP_NOT_FINITE);
        }
    }
    memset(q, 0, sizeof q);
    WORLD_REFUSED(&f, ecp_body_add_shape(f.world, 0, &box, NULL, q, NULL, &index),
                  ECP_BAD_ROTATION);
    for (k = 0; k < 6; k++) {
        m = ecp_material_default();
        if (k == 0) m.mu = ECP_R(-0.001);
        if (k == 1) m.e_t = 0;
        if (k == 2) m.e_t = -1;
        if (k == 3) m.e_o = 0;
        if (k == 4) m.e_o = -1;
        if (k == 5) m.e_r = ECP_R(-0.001);
        WORLD_REFUSED(&f, ecp_body_add_shape(f.world, 0, &box, NULL, NULL, &m, &index),
                      k == 0 ? ECP_BAD_FRICTION : ECP_BAD_ELLIPSOID);
    }
    {
        /* one inequality more than a patch may have: a heptahedron, the box with a corner off */
        ecp_real planes[7 * 4], vertices[10 * 3], third = ECP_R(sqrt(1.0 / 3));
        ecp_shape seven;
        memset(planes, 0, sizeof planes);
        for (k = 0; k < 6; k++) {
            planes[4 * k + k / 2] = k % 2 ? -1 : 1;
            planes[4 * k + 3] = 1;
        }
        ecp_i_set3(third, third, third, planes + 24);
        planes[27] = 1;
        CHECK(ecp_shape_polytope(&seven, planes, 7, vertices, 10) == ECP_OK);
        WORLD_REFUSED(&f, ecp_body_add_shape(f.world, 0, &seven, NULL, NULL, NULL, &index),
                      ECP_CAPACITY);
    }
    CHECK(index == -7);

    /* mu = 0 and e_r = 0 are allowed; the pose in the world is the body's times the shape's */
    m = ecp_material_default();
    m.mu = 0;
    ecp_i_set3(2, 0, 0, x);
    q[0] = q[1] = 5; /* a quarter turn about x, not normalised */
    CHECK(ecp_body_add_shape(f.world, 0, &box, x, q, &m, &index) == ECP_OK && index == 0);
    CHECK(ecp_body_add_shape(f.world, 1, &plane, NULL, NULL, NULL, &index) == ECP_OK && index == 1);
    CHECK(ecp_world_shape_count(f.world) == 2);
    CHECK(ecp_shape_get(f.world, 0, &kept, &body, got, R) == ECP_OK);
    CHECK(body == 0 && kept->kind == ECP_BOX && kept->size[2] == 3);
    /* (1, 0, 0) + z-turn of (2, 0, 0); x -> y, y -> z, z -> x */
    CHECK_NEAR(got[0], 1, 8 * (double)ECP_I_EPSILON);
    CHECK_NEAR(got[1], 2, 8 * (double)ECP_I_EPSILON);
    CHECK_NEAR(got[2], 0, 8 * (double)ECP_I_EPSILON);
    for (k = 0; k < 9; k++) {
        CHECK_NEAR(R[k], k == 3 || k == 7 || k == 2, 8 * (double)ECP_I_EPSILON);
    }
    memcpy(f.copy, f.world, f.bytes);
    WORLD_REFUSED(&f, ecp_body_add_shape(f.world, 0, &box, NULL, NULL, NULL, &index), ECP_CAPACITY);
    world_free(&f);
}

/* ---- loads */

static void world_test_bad_loads(void)
{
    world_fixture f;
    ecp_real v[3] = {1, 2, 3}, most[3], aside[3] = {0, 10, 0};
    static const int bad_index[4] = {-1, 3, INT_MAX, INT_MIN};
    int i, k, which;
    world_setup(&f);
    WORLD_REFUSED(&f, ecp_body_apply_force(NULL, f.box, v, NULL), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_body_apply_force(f.world, f.box, NULL, v), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_body_apply_torque(f.world, f.box, NULL), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_body_apply_impulse(f.world, f.box, NULL, NULL), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_body_apply_angular_impulse(f.world, f.box, NULL), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_body_clear_loads(NULL, f.box), ECP_BAD_POINTER);
    for (i = 0; i < 4; i++) {
        int b = bad_index[i];
        WORLD_REFUSED(&f, ecp_body_apply_force(f.world, b, v, NULL), ECP_BAD_INDEX);
        WORLD_REFUSED(&f, ecp_body_apply_torque(f.world, b, v), ECP_BAD_INDEX);
        WORLD_REFUSED(&f, ecp_body_apply_impulse(f.world, b, v, v), ECP_BAD_INDEX);
        WORLD_REFUSED(&f, ecp_body_apply_angular_impulse(f.world, b, v), ECP_BAD_INDEX);
        WORLD_REFUSED(&f, ecp_body_clear_loads(f.world, b), ECP_BAD_INDEX);
    }
    for (i = 0; i < 2; i++) {
        int b = i ? f.rail : f.ground;
        WORLD_REFUSED(&f, ecp_body_apply_force(f.world, b, v, NULL), ECP_BAD_KIND);
        WORLD_REFUSED(&f, ecp_body_apply_torque(f.world, b, v), ECP_BAD_KIND);
        WORLD_REFUSED(&f, ecp_body_apply_impulse(f.world, b, v, v), ECP_BAD_KIND);
        WORLD_REFUSED(&f, ecp_body_apply_angular_impulse(f.world, b, v), ECP_BAD_KIND);
        WORLD_REFUSED(&f, ecp_body_clear_loads(f.world, b), ECP_BAD_KIND);
    }
    /* loads that are taken back leave nothing */
    CHECK(ecp_body_apply_force(f.world, f.box, v, NULL) == ECP_OK);
    CHECK(ecp_body_apply_impulse(f.world, f.box, v, aside) == ECP_OK);
    CHECK(!ecp_i_is_zero(ecp_i_bodies(f.world)[f.box].force));
    CHECK(ecp_body_clear_loads(f.world, f.box) == ECP_OK);
    CHECK(ecp_i_is_zero(ecp_i_bodies(f.world)[f.box].force));
    CHECK(ecp_i_is_zero(ecp_i_bodies(f.world)[f.box].impulse));
    CHECK(ecp_i_is_zero(ecp_i_bodies(f.world)[f.box].impulse + 3));
    memcpy(f.copy, f.world, f.bytes);
    for (which = 0; which < 3; which++) {
        for (k = 0; k < 3; k++) {
            ecp_real bad[3] = {1, 1, 1};
            bad[k] = world_bad_number(which);
            WORLD_REFUSED(&f, ecp_body_apply_force(f.world, f.box, bad, NULL), ECP_NOT_FINITE);
            WORLD_REFUSED(&f, ecp_body_apply_force(f.world, f.box, v, bad), ECP_NOT_FINITE);
            WORLD_REFUSED(&f, ecp_body_apply_torque(f.world, f.box, bad), ECP_NOT_FINITE);
            WORLD_REFUSED(&f, ecp_body_apply_impulse(f.world, f.box, bad, NULL), ECP_NOT_FINITE);
            WORLD_REFUSED(&f, ecp_body_apply_impulse(f.world, f.box, v, bad), ECP_NOT_FINITE);
            WORLD_REFUSED(&f, ecp_body_apply_angular_impulse(f.world, f.box, bad), ECP_NOT_FINITE);
        }
    }
    /* finite loads whose sum, or moment, is not */
    ecp_i_set3(ECP_R(test_by(1.5e308, 3e38)), 0, 0, most);
    ecp_i_set3(0, 10, 0, aside);
    CHECK(ecp_body_apply_force(f.world, f.box, most, NULL) == ECP_OK);
    memcpy(f.copy, f.world, f.bytes);
    WORLD_REFUSED(&f, ecp_body_apply_force(f.world, f.box, most, NULL), ECP_NOT_FINITE);
    WORLD_REFUSED(&f, ecp_body_apply_impulse(f.world, f.box, most, aside), ECP_NOT_FINITE);
    /* and a step that they would throw beyond the numbers is refused as well */
    for (k = 0; k < 2; k++) {
        ecp_report report;
        ecp_status status = ecp_step(f.world, ECP_R(k ? 100 : 0.01), NULL, &report);
        CHECK(status == ECP_NOT_FINITE || status == ECP_NOT_SOLVED);
        CHECK(report.status == status);
        CHECK(memcmp(f.world, f.copy, f.bytes) == 0);
    }
    world_free(&f);
}

/* without gravity or contacts: m dv = h F + J, I dw = h (T + r x F - w x I w) + L + s x J, by a loop
   over components written here; inertia in world axes, everything at the beginning of the step */
static void world_test_loads(void)
{
    int round, k, i;
    test_seed = 5;
    for (round = 0; round < 10; round++) {
        ecp_world_desc desc = ecp_world_desc_default();
        ecp_body_desc d = ecp_body_desc_default();
        ecp_world *w;
        ecp_real F[3], T[3], J[3], L[3], r[3], s[3], h = ECP_R(0.05), v[3] = {0}, omega[3] = {0},
                                                     R[9], I[9], q[4];
        double moment[3], spin[3], got;
        memset(desc.gravity, 0, sizeof desc.gravity);
        w = test_world(&desc);
        for (k = 0; k < 4; k++) q[k] = d.rotation[k] = ECP_R(test_random());
        for (k = 0; k < 3; k++) {
            F[k] = ECP_R(test_random());
            T[k] = ECP_R(test_random());
            J[k] = ECP_R(test_random());
            L[k] = ECP_R(test_random());
            r[k] = ECP_R(test_random());
            s[k] = ECP_R(test_random());
            d.position[k] = ECP_R(2 * test_random());
            d.velocity[k] = ECP_R(test_random());
            d.angular_velocity[k] = ECP_R(3 * test_random());
        }
        d.mass = ECP_R(2.5);
        d.inertia[0] = ECP_R(0.8);
        d.inertia[4] = ECP_R(1.1);
        d.inertia[8] = ECP_R(1.4);
        d.inertia[1] = d.inertia[3] = ECP_R(0.15);
        d.inertia[2] = d.inertia[6] = ECP_R(-0.1);
        CHECK(ecp_body_add(w, &d, NULL) == ECP_OK);
        for (k = 0; k < 3; k++) {
            r[k] += d.position[k];
            s[k] += d.position[k];
        }
        CHECK(ecp_body_apply_force(w, 0, F, r) == ECP_OK);
        CHECK(ecp_body_apply_force(w, 0, F, NULL) == ECP_OK); /* loads add up */
        CHECK(ecp_body_apply_torque(w, 0, T) == ECP_OK);
        CHECK(ecp_body_apply_impulse(w, 0, J, s) == ECP_OK);
        CHECK(ecp_body_apply_angular_impulse(w, 0, L) == ECP_OK);
        /* a step that is refused does not use them up */
        CHECK(ecp_step(w, 0, NULL, NULL) == ECP_BAD_STEP);
        CHECK(ecp_step(w, h, NULL, NULL) == ECP_OK);
        CHECK(ecp_body_get_state(w, 0, NULL, NULL, v, omega) == ECP_OK);
        ecp_i_quat_normalise(q);
        ecp_quat_to_matrix(q, R);
        ecp_i_congruence(R, d.inertia, I);
        for (k = 0; k < 3; k++) {
            for (i = 0, spin[k] = 0; i < 3; i++) {
                spin[k] += (double)I[3 * k + i] * (double)d.angular_velocity[i];
            }
        }
        for (k = 0; k < 3; k++) {
            int a = (k + 1) % 3, b = (k + 2) % 3;
            double ra = (double)r[a] - (double)d.position[a],
                   rb = (double)r[b] - (double)d.position[b];
            double sa = (double)s[a] - (double)d.position[a],
                   sb = (double)s[b] - (double)d.position[b];
            CHECK_NEAR((double)d.mass * ((double)v[k] - (double)d.velocity[k]),
                       2 * (double)h * (double)F[k] + (double)J[k], 64 * (double)ECP_I_EPSILON);
            moment[k] = (double)h * ((double)T[k] + ra * (double)F[b] - rb * (double)F[a]);
            moment[k] += (double)L[k] + sa * (double)J[b] - sb * (double)J[a];
            moment[k] -= (double)h * ((double)d.angular_velocity[a] * spin[b] -
                                      (double)d.angular_velocity[b] * spin[a]);
            for (i = 0, got = -spin[k]; i < 3; i++) got += (double)I[3 * k + i] * (double)omega[i];
            CHECK_NEAR(got, moment[k], 256 * (double)ECP_I_EPSILON);
        }
        /* once: the next step keeps the momentum. The angular one of the body at the beginning of
           the step changes by its own gyroscopic term only, which for h -> 0 is nothing */
        {
            ecp_real v2[3] = {0}, w2[3] = {0};
            CHECK(ecp_step(w, ECP_R(1e-9), NULL, NULL) == ECP_OK);
            CHECK(ecp_body_get_state(w, 0, NULL, NULL, v2, w2) == ECP_OK);
            for (k = 0; k < 3; k++) {
                CHECK(v2[k] == v[k]);
                CHECK_NEAR(w2[k], omega[k], 1e-8 + 16 * (double)ECP_I_EPSILON);
            }
        }
        free(w);
    }
}

/* gravity of any direction; kinematic bodies keep their velocity, static bodies their place */
static void world_test_kinds(void)
{
    world_fixture f;
    ecp_real g[3] = {3, -4, 5}, x0[3] = {0}, x[3], v[3], w[3] = {0};
    int k, i;
    world_setup(&f);
    CHECK(ecp_world_set_gravity(f.world, g) == ECP_OK);
    ecp_i_set3(0, 0, 50, x);
    CHECK(ecp_body_set_state(f.world, f.box, x, NULL, NULL, NULL) == ECP_OK);
    ecp_i_set3(0, 0, 0, v);
    CHECK(ecp_body_set_state(f.world, f.box, NULL, NULL, v, v) == ECP_OK);
    CHECK(ecp_body_get_state(f.world, f.rail, x0, NULL, NULL, NULL) == ECP_OK);
    CHECK(ecp_step(f.world, ECP_R(0.125), NULL, NULL) == ECP_OK); /* uses up the force (1, 2, 3) */
    for (i = 1; i < 8; i++) CHECK(ecp_step(f.world, ECP_R(0.125), NULL, NULL) == ECP_OK);
    CHECK(ecp_body_get_state(f.world, f.box, NULL, NULL, v, NULL) == ECP_OK);
    for (k = 0; k < 3; k++) {
        CHECK_NEAR(v[k], (double)g[k] + 0.125 * (k + 1) / 2, 16 * (double)ECP_I_EPSILON);
    }
    CHECK(ecp_body_get_state(f.world, f.rail, x, NULL, v, w) == ECP_OK);
    CHECK(v[0] == 1 && v[1] == ECP_R(0.5) && v[2] == 0 && w[2] == 2);
    for (k = 0; k < 3; k++)
        CHECK_NEAR(x[k], (double)x0[k] + (double)v[k], 8 * (double)ECP_I_EPSILON);
    CHECK(ecp_body_get_state(f.world, f.ground, x, NULL, v, w) == ECP_OK);
    for (k = 0; k < 3; k++) CHECK(x[k] == 0 && v[k] == 0 && w[k] == 0);
    world_free(&f);
}

/* ---- guesses, contacts and steps */

static void world_test_bad_guess(void)
{
    world_fixture f;
    ecp_real p[3] = {0, 0, 0};
    ecp_contact contact;
    ecp_printed printed;
    static const int bad_index[4] = {-1, 3, INT_MAX, INT_MIN};
    int i, k, which;
    world_setup(&f);
    WORLD_REFUSED(&f, ecp_guess_ecp(NULL, 0, 1, p), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_guess_ecp(f.world, 0, 1, NULL), ECP_BAD_POINTER);
    for (i = 0; i < 4; i++) {
        WORLD_REFUSED(&f, ecp_guess_ecp(f.world, bad_index[i], 1, p), ECP_BAD_INDEX);
        WORLD_REFUSED(&f, ecp_guess_ecp(f.world, 1, bad_index[i], p), ECP_BAD_INDEX);
        WORLD_REFUSED(&f, ecp_guess_ecp(f.world, bad_index[i], bad_index[i], p), ECP_BAD_INDEX);
        WORLD_REFUSED(&f, ecp_contact_get(f.world, i ? bad_index[i] : -1, &contact), ECP_BAD_INDEX);
    }
    WORLD_REFUSED(&f, ecp_guess_ecp(f.world, 1, 1, p), ECP_BAD_INDEX);
    for (which = 0; which < 3; which++) {
        for (k = 0; k < 3; k++) {
            ecp_real bad[3] = {0, 0, 0};
            bad[k] = world_bad_number(which);
            WORLD_REFUSED(&f, ecp_guess_ecp(f.world, 1, 0, bad), ECP_NOT_FINITE);
        }
    }
    WORLD_REFUSED(&f, ecp_contact_get(NULL, 0, &contact), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_contact_get(f.world, 0, NULL), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_contact_get(f.world, ecp_contact_count(f.world), &contact),
                  ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_contact_get(f.world, 0, &contact), ECP_OK);
    WORLD_REFUSED(&f, ecp_printed_residual(NULL, f.world, 1, &printed), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_printed_residual(f.world, NULL, 1, &printed), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_printed_residual(f.world, f.world, 1, NULL), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_printed_residual(f.world, f.world, 0, &printed), ECP_BAD_STEP);
    for (which = 0; which < 3; which++) {
        ecp_real h = world_bad_number(which);
        WORLD_REFUSED(&f, ecp_printed_residual(f.world, f.world, h, &printed), ECP_NOT_FINITE);
    }
    world_free(&f);
}

static void world_test_bad_step(void)
{
    world_fixture f;
    ecp_options o;
    ecp_report r;
    int which, k;
    world_setup(&f);
    WORLD_REFUSED(&f, ecp_step(NULL, ECP_R(0.01), NULL, &r), ECP_BAD_POINTER);
    CHECK(r.status == ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_step(f.world, 0, NULL, &r), ECP_BAD_STEP);
    CHECK(r.status == ECP_BAD_STEP && r.value == 0);
    WORLD_REFUSED(&f, ecp_step(f.world, ECP_R(-0.01), NULL, NULL), ECP_BAD_STEP);
    for (which = 0; which < 3; which++) {
        WORLD_REFUSED(&f, ecp_step(f.world, world_bad_number(which), NULL, &r), ECP_NOT_FINITE);
        CHECK(r.status == ECP_NOT_FINITE && r.body == -1);
        o = ecp_options_default();
        o.tolerance = world_bad_number(which);
        WORLD_REFUSED(&f, ecp_step(f.world, ECP_R(0.01), &o, NULL), ECP_NOT_FINITE);
    }
    for (k = 0; k < 6; k++) {
        o = ecp_options_default();
        if (k == 0) o.tolerance = 0;
        if (k == 1) o.tolerance = -1;
        if (k == 2) o.max_iterations = 0;
        if (k == 3) o.max_iterations = -1;
        if (k == 4) o.fallbacks = 128;
        if (k == 5) o.fallbacks = -1;
        WORLD_REFUSED(&f, ecp_step(f.world, ECP_R(0.01), &o, &r), ECP_BAD_OPTION);
        CHECK(r.status == ECP_BAD_OPTION);
    }
#ifndef __cplusplus
    /* in C++ there is no such value of the type */
    o = ecp_options_default();
    o.rule = (ecp_rule)7;
    WORLD_REFUSED(&f, ecp_step(f.world, ECP_R(0.01), &o, NULL), ECP_BAD_OPTION);
#endif
    world_free(&f);
}

/* patches, and inequalities of the two primitives of a patch, beyond the description: found in the
   step, which says where */
static void world_test_capacity(void)
{
    int k;
    for (k = 0; k < 2; k++) {
        ecp_world_desc desc = ecp_world_desc_default();
        ecp_body_desc d = ecp_body_desc_default();
        ecp_shape box = world_box(0.5, 0.5, 0.5);
        ecp_report r;
        world_fixture f;
        desc.max_patches = k ? 16 : 1;
        desc.max_inequalities = k ? 11 : 12;
        f.world = test_world(&desc);
        f.bytes = ecp_world_memsize(&desc);
        f.copy = (unsigned char *)malloc(f.bytes);
        test_ground(f.world, 0, 0, 1, NULL);
        ecp_i_set3(0, 0, ECP_R(0.5), d.position);
        CHECK(ecp_body_add(f.world, &d, NULL) == ECP_OK);
        ecp_i_set3(0, 0, ECP_R(1.5), d.position);
        CHECK(ecp_body_add(f.world, &d, NULL) == ECP_OK);
        CHECK(ecp_body_add_shape(f.world, 1, &box, NULL, NULL, NULL, NULL) == ECP_OK);
        CHECK(ecp_body_add_shape(f.world, 2, &box, NULL, NULL, NULL, NULL) == ECP_OK);
        memcpy(f.copy, f.world, f.bytes);
        WORLD_REFUSED(&f, ecp_step(f.world, ECP_R(0.01), NULL, &r), ECP_CAPACITY);
        CHECK(r.status == ECP_CAPACITY && r.shape_a == 1 && r.shape_b == 2);
        CHECK_NEAR(r.value, k ? 12 : 2, 0);
        CHECK_NEAR(r.limit, k ? 11 : 1, 0);
        if (k == 0) {
            /* guesses take places of patches, too */
            ecp_real p[3] = {0, 0, 1};
            CHECK(ecp_guess_ecp(f.world, 0, 1, p) == ECP_OK);
            memcpy(f.copy, f.world, f.bytes);
            WORLD_REFUSED(&f, ecp_guess_ecp(f.world, 1, 2, p), ECP_CAPACITY);
        }
        world_free(&f);
    }
}

/* a box on its corner hits the floor at 20 m/s; with one iteration and no way out that is not
   solved, nothing changes, and the world can still be stepped as if nothing had been tried */
/* quaternions so long or so short that their squares are no numbers are still rotations, and give the
   bits of the same one with length about one; found by tests/fuzz.sh */
static void world_test_extreme_rotations(void)
{
    const double exponents[4] = {-300, -160, 160, 300};
    world_fixture f;
    ecp_mass part, one, sum;
    ecp_shape box = world_box(0.3, 0.2, 0.1);
    ecp_real q[4], at[3] = {1, 2, 3}, got[4], expected[4], turned[9], plain[9];
    int i, k, shape;
    world_setup(&f);
    ecp_shape_mass(&box, 1, &part);
    for (i = 0; i < 5; i++) {
        double exponent = i == 4 ? 0 : exponents[i] / test_by(1, 8);
        ecp_real unit = ecp_i_power_of_two(ECP_R(pow(10, exponent)));
        ecp_body_desc d = ecp_body_desc_default();
        q[0] = unit * ECP_R(0.5);
        q[1] = -unit * ECP_R(0.25);
        q[2] = unit * ECP_R(0.125);
        q[3] = unit;
        CHECK(ecp_body_set_state(f.world, f.box, NULL, q, NULL, NULL) == ECP_OK);
        ecp_body_get_state(f.world, f.box, NULL, got, NULL, NULL);
        for (k = 0; k < 4; k++) d.rotation[k] = q[k];
        ecp_body_remove(f.world, f.rail);
        CHECK(ecp_body_add(f.world, &d, &f.rail) == ECP_OK);
        ecp_body_get_state(f.world, f.rail, NULL, expected, NULL, NULL);
        CHECK(memcmp(got, expected, sizeof got) == 0);
        CHECK(ecp_body_add_shape(f.world, f.rail, &box, NULL, q, NULL, &shape) == ECP_OK);
        ecp_shape_get(f.world, shape, NULL, NULL, NULL, turned);
        memset(&sum, 0, sizeof sum);
        ecp_mass_add(&sum, &part, at, q);
        q[0] = ECP_R(0.5);
        q[1] = ECP_R(-0.25);
        q[2] = ECP_R(0.125);
        q[3] = 1;
        memset(&one, 0, sizeof one);
        ecp_mass_add(&one, &part, at, q);
        CHECK(memcmp(&sum, &one, sizeof sum) == 0);
        CHECK(ecp_body_set_state(f.world, f.box, NULL, q, NULL, NULL) == ECP_OK);
        ecp_body_get_state(f.world, f.box, NULL, expected, NULL, NULL);
        CHECK(memcmp(got, expected, sizeof got) == 0);
        CHECK_NEAR(got[0] * got[0] + got[1] * got[1] + got[2] * got[2] + got[3] * got[3], 1,
                   test_by(1e-15, 1e-6));
        ecp_quat_to_matrix(got, plain);
        for (k = 0; k < 9; k++) CHECK(turned[k] - turned[k] == 0);
    }
    world_free(&f);
}

/* A turn in a step whose square is no number is refused: it would leave a rotation without a length. */
static void world_test_extreme_turns(void)
{
    const ecp_real slow[3] = {0, 0, ECP_R(test_by(1e140, 1e15))};
    const ecp_real fast[3] = {0, 0, ECP_R(test_by(1e153, 5e20))};
    ecp_real q[4];
    ecp_report r;
    world_fixture f;
    world_setup(&f);
    CHECK(ecp_body_set_state(f.world, f.rail, NULL, NULL, NULL, fast) == ECP_OK);
    memcpy(f.copy, f.world, f.bytes);
    WORLD_REFUSED(&f, ecp_step(f.world, ECP_R(0.01), NULL, &r), ECP_NOT_FINITE);
    CHECK(r.body == f.rail && r.value > r.limit && r.limit > 0);
    CHECK(ecp_body_set_state(f.world, f.rail, NULL, NULL, NULL, slow) == ECP_OK);
    CHECK(ecp_step(f.world, ECP_R(0.01), NULL, &r) == ECP_OK);
    ecp_body_get_state(f.world, f.rail, NULL, q, NULL, NULL);
    CHECK_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, test_by(1e-15, 1e-6));
    world_free(&f);
}

static void world_test_failed_step(void)
{
    ecp_world_desc desc = ecp_world_desc_default();
    ecp_body_desc d = ecp_body_desc_default();
    ecp_shape box = world_box(0.5, 0.4, 0.3);
    ecp_options o = ecp_options_default();
    ecp_report r;
    world_fixture f;
    unsigned char *untried;
    f.world = test_world(&desc);
    f.bytes = ecp_world_memsize(&desc);
    f.copy = (unsigned char *)malloc(f.bytes);
    untried = (unsigned char *)malloc(f.bytes);
    test_ground(f.world, 0, 0, 1, NULL);
    d.inertia[0] = d.inertia[4] = d.inertia[8] = ECP_R(0.08);
    d.rotation[0] = ECP_R(0.8);
    ecp_i_set3(ECP_R(0.3), ECP_R(0.4), ECP_R(0.2), d.rotation + 1);
    ecp_i_set3(0, 0, ECP_R(0.75), d.position);
    ecp_i_set3(3, 1, -20, d.velocity);
    ecp_i_set3(5, -7, 3, d.angular_velocity);
    CHECK(ecp_body_add(f.world, &d, NULL) == ECP_OK);
    CHECK(ecp_body_add_shape(f.world, 1, &box, NULL, NULL, NULL, NULL) == ECP_OK);
    memcpy(f.copy, f.world, f.bytes);
    memcpy(untried, f.world, f.bytes);
    o.max_iterations = 1;
    o.fallbacks = 0;
    WORLD_REFUSED(&f, ecp_step(f.world, ECP_R(0.02), &o, &r), ECP_NOT_SOLVED);
    CHECK(r.status == ECP_NOT_SOLVED);
    CHECK(r.iterations >= 1 && r.fallbacks == 0);
    CHECK(r.body == 1 && r.value > r.limit && r.limit > 0);
    CHECK(r.memory_used > f.bytes / 100 && r.memory_used <= f.bytes);
    CHECK(r.largest_turn == 0); /* nothing was turned */
    CHECK(world_work_is_zero(f.world, f.bytes));
    CHECK(ecp_step(f.world, ECP_R(0.02), NULL, &r) == ECP_OK);
    CHECK(r.status == ECP_OK && r.body == -1 && r.shape_a == -1);
    CHECK(ecp_step((ecp_world *)(void *)untried, ECP_R(0.02), NULL, NULL) == ECP_OK);
    CHECK(memcmp(f.world, untried, f.bytes) == 0);
    CHECK(world_work_is_zero(f.world, f.bytes));
    free(untried);
    world_free(&f);
}

/* ---- bodies that go */

/* a dynamic box of half sizes 0.2 at (x, 0, z), with its shape */
static int world_add_cube(ecp_world *w, double x, double z, int *shape_index)
{
    ecp_body_desc d = ecp_body_desc_default();
    ecp_shape shape = world_box(0.2, 0.2, 0.2);
    int body = -1;
    d.inertia[0] = d.inertia[4] = d.inertia[8] = ECP_R(0.03);
    ecp_i_set3(ECP_R(x), 0, ECP_R(z), d.position);
    CHECK(ecp_body_add(w, &d, &body) == ECP_OK);
    CHECK(ecp_body_add_shape(w, body, &shape, NULL, NULL, NULL, shape_index) == ECP_OK);
    return body;
}

/* ground, a cube on it, a second one on that, a third one on the ground beside them, at rest */
static void world_cubes(world_fixture *f, double lower)
{
    ecp_world_desc desc = ecp_world_desc_default();
    int k, index;
    desc.max_bodies = desc.max_shapes = 4;
    f->world = test_world(&desc);
    f->bytes = ecp_world_memsize(&desc);
    f->copy = (unsigned char *)malloc(f->bytes);
    f->ground = test_ground(f->world, 0, 0, 1, NULL);
    CHECK(world_add_cube(f->world, lower, 0.2, &index) == 1 && index == 1);
    CHECK(world_add_cube(f->world, 0, 0.6, &index) == 2 && index == 2);
    CHECK(world_add_cube(f->world, 2, 0.2, &index) == 3 && index == 3);
    for (k = 0; k < 3; k++) CHECK(ecp_step(f->world, ECP_R(0.01), NULL, NULL) == ECP_OK);
    memcpy(f->copy, f->world, f->bytes);
}

/* max_total_iterations is never exceeded, whatever the fallbacks; a step that it ends changes nothing,
   and with as many as the step needs it is the same step */
static void world_test_total_iterations(void)
{
    world_fixture f;
    ecp_body_desc d = ecp_body_desc_default();
    ecp_shape box = world_box(0.5, 0.4, 0.3);
    ecp_options o = ecp_options_default();
    ecp_report r, bounded;
    unsigned char *whole;
    int kind, most, refused;
    world_setup(&f);
    d.inertia[0] = d.inertia[4] = d.inertia[8] = ECP_R(0.08);
    ecp_body_remove(f.world, f.rail);
    ecp_i_set3(ECP_R(0.2), 0, ECP_R(0.4), d.position);
    ecp_i_set3(3, 1, -20, d.velocity);
    ecp_i_set3(5, -7, 3, d.angular_velocity);
    CHECK(ecp_body_add(f.world, &d, &f.rail) == ECP_OK);
    CHECK(ecp_body_add_shape(f.world, f.rail, &box, NULL, NULL, NULL, NULL) == ECP_OK);
    memcpy(f.copy, f.world, f.bytes);
    whole = (unsigned char *)malloc(f.bytes);
    o.max_iterations = 3; /* so that it does not do without fallbacks */
    for (kind = 0; kind < 2; kind++) {
        if (kind) o.fallbacks &= ~ECP_FALLBACK_SUBSTEPS;
        o.max_total_iterations = 0;
        memcpy(f.world, f.copy, f.bytes);
        refused = 0;
        CHECK(ecp_step(f.world, ECP_R(0.02), &o, &r) == ECP_OK);
        CHECK(r.fallbacks != 0 && r.iterations > 6);
        memcpy(whole, f.world, f.bytes);
        for (most = 1; most <= r.iterations; most++) {
            memcpy(f.world, f.copy, f.bytes);
            o.max_total_iterations = most;
            if (ecp_step(f.world, ECP_R(0.02), &o, &bounded) != ECP_OK) {
                refused++;
                WORLD_REFUSED(&f, bounded.status, ECP_NOT_SOLVED);
                CHECK(bounded.centred == 0);
                /* the report is that of the search that it ended: no other was begun */
                CHECK(most >= o.max_iterations || bounded.fallbacks == 0);
            }
            CHECK(bounded.iterations <= most);
        }
        CHECK(refused >= 3);
        /* (in parts only once more than twice their iterations are left, where it is for their work alone) */
        CHECK(bounded.status == ECP_OK);
        CHECK(kind == 0 || memcmp(f.world, whole, f.bytes) == 0);
        o.max_total_iterations = 4 * r.iterations;
        memcpy(f.world, f.copy, f.bytes);
        CHECK(ecp_step(f.world, ECP_R(0.02), &o, &bounded) == ECP_OK);
        CHECK(memcmp(f.world, whole, f.bytes) == 0);
    }
    o.max_total_iterations = -1;
    CHECK(ecp_step(f.world, ECP_R(0.02), &o, NULL) == ECP_BAD_OPTION);
    free(whole);
    world_free(&f);
}

/* A step in parts: forces act in all of them. A body that is alone takes what its force gives in h. */
static void world_test_parts(void)
{
    ecp_body_desc d = ecp_body_desc_default();
    ecp_shape box = world_box(0.5, 0.4, 0.3);
    ecp_options o = ecp_options_default();
    const ecp_real force[3] = {3, 0, 0};
    ecp_report r;
    ecp_real v[3];
    ecp_world *w = test_world(NULL);
    int alone;
    test_ground(w, 0, 0, 1, NULL);
    ecp_i_set3(0, 0, 50, d.position);
    CHECK(ecp_body_add(w, &d, &alone) == ECP_OK);
    d.inertia[0] = d.inertia[4] = d.inertia[8] = ECP_R(0.08);
    ecp_i_set3(ECP_R(0.2), 0, ECP_R(0.4), d.position);
    ecp_i_set3(3, 1, -20, d.velocity);
    ecp_i_set3(5, -7, 3, d.angular_velocity);
    CHECK(ecp_body_add(w, &d, NULL) == ECP_OK);
    CHECK(ecp_body_add_shape(w, 2, &box, NULL, NULL, NULL, NULL) == ECP_OK);
    CHECK(ecp_body_apply_force(w, alone, force, NULL) == ECP_OK);
    o.max_iterations = 3;
    o.fallbacks = ECP_FALLBACK_GEOMETRIC | ECP_FALLBACK_SUBSTEPS;
    CHECK(ecp_step(w, ECP_R(0.02), &o, &r) == ECP_OK);
    CHECK(r.substeps > 1 && r.body == -1 && r.value == 0 && r.limit == 0);
    CHECK(ecp_body_get_state(w, alone, NULL, NULL, v, NULL) == ECP_OK);
    CHECK_NEAR(v[0], 3 * 0.02, test_by(1e-14, 1e-7));
    CHECK_NEAR(v[2], -9.8 * 0.02, test_by(1e-14, 1e-7));
    free(w);
}

/* Worlds are equal bytes whatever the padding of the shapes that they were given. */
static void world_test_padding(void)
{
    ecp_world *w[2];
    ecp_shape box = world_box(0.5, 0.4, 0.3), copy;
    ecp_body_desc d = ecp_body_desc_default();
    int k;
    for (k = 0; k < 2; k++) {
        memset(&copy, k ? 0xff : 0, sizeof copy);
        copy.cls = box.cls;
        copy.kind = box.kind;
        copy.inequalities = box.inequalities;
        copy.vertex_count = 0;
        memcpy(copy.size, box.size, sizeof copy.size);
        memcpy(copy.centre, box.centre, sizeof copy.centre);
        copy.radius = box.radius;
        copy.planes = copy.vertices = NULL;
        copy.user = NULL;
        w[k] = test_world(NULL);
        CHECK(ecp_body_add(w[k], &d, NULL) == ECP_OK);
        CHECK(ecp_body_add_shape(w[k], 0, &copy, NULL, NULL, NULL, NULL) == ECP_OK);
    }
    CHECK(memcmp(w[0], w[1], ecp_world_state_size(w[0])) == 0);
    free(w[0]);
    free(w[1]);
}

static void world_test_bad_remove(void)
{
    world_fixture f;
    ecp_real v[3] = {1, 2, 3};
    ecp_shape box = world_box(1, 1, 1);
    static const int bad_index[4] = {-1, 4, INT_MAX, INT_MIN};
    int i;
    world_cubes(&f, 0);
    WORLD_REFUSED(&f, ecp_body_remove(NULL, 0), ECP_BAD_POINTER);
    for (i = 0; i < 4; i++) {
        WORLD_REFUSED(&f, ecp_body_remove(f.world, bad_index[i]), ECP_BAD_INDEX);
    }
    CHECK(ecp_body_remove(f.world, 1) == ECP_OK);
    CHECK(world_work_is_zero(f.world, f.bytes));
    memcpy(f.copy, f.world, f.bytes);
    WORLD_REFUSED(&f, ecp_body_remove(f.world, 1), ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_body_get_state(f.world, 1, v, NULL, NULL, NULL), ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_body_set_state(f.world, 1, v, NULL, NULL, NULL), ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_body_apply_force(f.world, 1, v, NULL), ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_body_apply_torque(f.world, 1, v), ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_body_apply_impulse(f.world, 1, v, NULL), ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_body_apply_angular_impulse(f.world, 1, v), ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_body_add_shape(f.world, 1, &box, NULL, NULL, NULL, NULL), ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_shape_get(f.world, 1, NULL, NULL, NULL, NULL), ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_guess_ecp(f.world, 0, 1, v), ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_guess_ecp(f.world, 1, 2, v), ECP_BAD_INDEX);
    world_free(&f);
}

/* the lower cube goes: its contacts with it, the upper one falls freely, the one beside notices
   nothing; and the index is taken again */
static void world_test_remove(void)
{
    world_fixture f;
    ecp_contact c, beside;
    ecp_report r;
    ecp_printed printed;
    ecp_real x[3] = {0, 0, 0}, v[3] = {0, 0, 0}, h = ECP_R(0.01);
    int i, index = -1;
    world_cubes(&f, 0);
    CHECK(ecp_contact_count(f.world) == 3);
    CHECK(ecp_contact_get(f.world, 1, &beside) == ECP_OK && beside.shape_a == 3);
    CHECK(ecp_body_remove(f.world, 1) == ECP_OK);
    CHECK(ecp_world_body_count(f.world) == 4 && ecp_world_shape_count(f.world) == 4);
    CHECK(ecp_contact_count(f.world) == 1 && ecp_contact_get(f.world, 0, &c) == ECP_OK);
    CHECK(memcmp(&c, &beside, sizeof c) == 0);
    CHECK(ecp_contact_get(f.world, 1, &c) == ECP_BAD_INDEX);
    memcpy(f.copy, f.world, f.bytes);
    CHECK(ecp_step(f.world, h, NULL, &r) == ECP_OK);
    /* one island of a cube on the ground, started from its solution */
    CHECK(r.islands == 1 && r.unknowns == 6 + 3 + 6 + 3 && r.iterations <= 1);
    CHECK(ecp_body_get_state(f.world, 2, x, NULL, v, NULL) == ECP_OK);
    CHECK_NEAR(v[2], -9.8 * 0.01, test_by(1e-12, 1e-5));
    CHECK(ecp_body_get_state(f.world, 3, x, NULL, v, NULL) == ECP_OK);
    CHECK_NEAR(x[2], 0.2, test_by(1e-12, 1e-6));
    CHECK(ecp_printed_residual((const ecp_world *)(const void *)f.copy, f.world, h, &printed) ==
          ECP_OK);
    CHECK(printed.largest < ECP_R(test_by(1e-9, 1e-2)));
    CHECK(world_work_is_zero(f.world, f.bytes));
    /* the free index is taken, and by a body that may have any shape; then the world is full */
    for (i = 0; i < 60; i++) CHECK(ecp_step(f.world, h, NULL, NULL) == ECP_OK);
    CHECK(world_add_cube(f.world, 0.1, 0.6, &index) == 1 && index == 1);
    for (i = 0; i < 60; i++) CHECK(ecp_step(f.world, h, NULL, NULL) == ECP_OK);
    CHECK(ecp_body_get_state(f.world, 1, x, NULL, NULL, NULL) == ECP_OK);
    CHECK_NEAR(x[2], 0.6, test_by(1e-9, 1e-4));
    CHECK(ecp_contact_count(f.world) == 3);
    /* the highest ones go: the counts follow */
    CHECK(ecp_body_remove(f.world, 2) == ECP_OK && ecp_world_body_count(f.world) == 4);
    CHECK(ecp_body_remove(f.world, 3) == ECP_OK && ecp_world_body_count(f.world) == 2);
    CHECK(ecp_world_shape_count(f.world) == 2);
    CHECK(ecp_body_remove(f.world, 0) == ECP_OK && ecp_contact_count(f.world) == 0);
    CHECK(test_ground(f.world, 0, 0, 1, NULL) == 0);
    CHECK(ecp_body_remove(f.world, 0) == ECP_OK && ecp_body_remove(f.world, 1) == ECP_OK);
    CHECK(ecp_world_body_count(f.world) == 0 && ecp_world_shape_count(f.world) == 0);
    CHECK(ecp_step(f.world, h, NULL, NULL) == ECP_OK);
    world_free(&f);

    /* what is added and removed between two steps leaves no trace, holes in the list or not */
    world_cubes(&f, 0);
    for (i = 3; i > 0; i--) {
        CHECK(ecp_body_remove(f.world, i) == ECP_OK);
        memcpy(f.copy, f.world, f.bytes);
        world_add_cube(f.world, 0, 1, NULL);
        CHECK(ecp_body_remove(f.world, i) == ECP_OK);
        CHECK(memcmp(f.copy, f.world, f.bytes) == 0);
        if (i == 2) world_add_cube(f.world, 0, 1, NULL);
    }
    world_free(&f);
}

/* A body with three shapes between those of others: all go, and their indices are taken in order.
   Without it the others move as in a world where it never was, with the same work. */
static void world_test_remove_many(void)
{
    enum { WITH, WITHOUT };
    world_fixture f[2];
    ecp_report r[2];
    ecp_real a[13] = {0}, b[13] = {0}, at[3] = {0, 0, 0};
    ecp_body_desc d = ecp_body_desc_default();
    ecp_shape small = world_box(0.1, 0.1, 0.1);
    int k, i, index = -1;
    for (k = 0; k < 2; k++) {
        ecp_world_desc desc = ecp_world_desc_default();
        f[k].world = test_world(&desc);
        f[k].bytes = ecp_world_memsize(&desc);
        f[k].copy = (unsigned char *)malloc(f[k].bytes);
        test_ground(f[k].world, 0.1, 0, 1, NULL);
        ecp_i_set3(0, 0, ECP_R(0.3), d.position);
        if (k == WITH) CHECK(ecp_body_add(f[k].world, &d, NULL) == ECP_OK);
        for (i = 0; i < 3; i++) {
            at[0] = ECP_R(0.3 * i);
            if (k == WITH) {
                CHECK(ecp_body_add_shape(f[k].world, 1, &small, at, NULL, NULL, &index) == ECP_OK);
                CHECK(index == 1 + 2 * i);
            }
            world_add_cube(f[k].world, 0.05 * i, 0.3 + 0.5 * i, NULL);
        }
    }
    CHECK(ecp_body_remove(f[WITH].world, 1) == ECP_OK);
    for (i = 0; i < 40; i++) {
        for (k = 0; k < 2; k++) {
            CHECK(ecp_step(f[k].world, ECP_R(0.01), NULL, r + k) == ECP_OK);
        }
        r[WITH].memory_used = r[WITHOUT].memory_used;
        CHECK(memcmp(r, r + 1, sizeof *r) == 0);
        for (k = 1; k < 4; k++) {
            CHECK(ecp_body_get_state(f[WITH].world, k + 1, a, a + 3, a + 7, a + 10) == ECP_OK);
            CHECK(ecp_body_get_state(f[WITHOUT].world, k, b, b + 3, b + 7, b + 10) == ECP_OK);
            CHECK(memcmp(a, b, sizeof a) == 0);
        }
    }
    CHECK(ecp_contact_count(f[WITH].world) >= 3);
    for (i = 0; i < 4; i++) {
        CHECK(ecp_body_add_shape(f[WITH].world, 2, &small, NULL, NULL, NULL, &index) == ECP_OK);
        CHECK(index == (i < 3 ? 1 + 2 * i : 7));
    }
    world_free(f);
    world_free(f + 1);
}

/* ---- filters */

static void world_test_filter(void)
{
    static const struct {
        uint32_t category_a, with_a, category_b, with_b;
        int touch;
    } cases[] = {
        {0xffffffffu, 0xffffffffu, 0xffffffffu, 0xffffffffu, 1},
        {1, 2, 2, 1, 1},                                         /* each is what the other meets */
        {1, 2, 2, 2, 0},                                         /* B does not meet A */
        {1, 1, 2, 1, 0},                                         /* A does not meet B */
        {0x80000000u, 0x40000001u, 0x40000000u, 0x80000000u, 1}, /* the highest bits */
        {0, 0xffffffffu, 0xffffffffu, 0xffffffffu, 0},           /* A is nothing */
        {0xffffffffu, 0, 0xffffffffu, 0xffffffffu, 0},           /* A meets nothing */
        {6, 12, 8, 2, 1},                                        /* one bit of several is enough */
    };
    world_fixture f;
    ecp_report r;
    ecp_real x[3] = {0, 0, 0}, h = ECP_R(0.01);
    unsigned i;
    int k;
    /* a cube a hair over the ground falls through, or does not */
    for (i = 0; i < sizeof cases / sizeof *cases; i++) {
        for (k = 0; k < 2; k++) {
            ecp_world *w = test_world(NULL);
            test_ground(w, 0, 0, 1, NULL);
            world_add_cube(w, 0, 0.2001, NULL);
            CHECK(ecp_shape_set_filter(w, k, cases[i].category_a, cases[i].with_a) == ECP_OK);
            CHECK(ecp_shape_set_filter(w, 1 - k, cases[i].category_b, cases[i].with_b) == ECP_OK);
            CHECK(ecp_step(w, ECP_R(0.05), NULL, &r) == ECP_OK);
            CHECK(r.patches_kept == cases[i].touch && r.patches_left_out == !cases[i].touch);
            CHECK(ecp_body_get_state(w, 1, x, NULL, NULL, NULL) == ECP_OK);
            CHECK_NEAR(x[2], cases[i].touch ? 0.2 : 0.2001 - 9.8 * 0.05 * 0.05,
                       test_by(1e-12, 1e-6));
            free(w);
        }
    }

    world_cubes(&f, 0);
    WORLD_REFUSED(&f, ecp_shape_set_filter(NULL, 0, 1, 1), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_shape_set_filter(f.world, -1, 1, 1), ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_shape_set_filter(f.world, 4, 1, 1), ECP_BAD_INDEX);
    /* the upper cube sinks into the lower one for two steps, and is pushed out when it is seen
       again: from 3 g h^2 = 3 mm deep at no more than depth / h */
    CHECK(ecp_shape_set_filter(f.world, 2, 2, 1) == ECP_OK);
    CHECK(ecp_shape_set_filter(f.world, 1, 1, 1) == ECP_OK);
    for (k = 0; k < 2; k++) CHECK(ecp_step(f.world, h, NULL, NULL) == ECP_OK);
    CHECK(ecp_body_get_state(f.world, 2, x, NULL, NULL, NULL) == ECP_OK);
    CHECK_NEAR(x[2], 0.6 - 3 * 9.8 * 1e-4, test_by(1e-12, 1e-6));
    CHECK(ecp_shape_set_filter(f.world, 1, 1, 3) == ECP_OK);
    for (k = 0; k < 60; k++) {
        CHECK(ecp_step(f.world, h, NULL, NULL) == ECP_OK);
        CHECK(ecp_body_get_state(f.world, 2, x, NULL, NULL, NULL) == ECP_OK);
        CHECK(x[2] > ECP_R(0.5999) && x[2] < ECP_R(0.606));
    }
    CHECK_NEAR(x[2], 0.6, test_by(1e-9, 1e-4));
    /* the index forgets its filter with its shape */
    CHECK(ecp_shape_set_filter(f.world, 3, 0, 0) == ECP_OK);
    CHECK(ecp_body_remove(f.world, 3) == ECP_OK);
    CHECK(ecp_shape_set_filter(f.world, 3, 1, 1) == ECP_BAD_INDEX);
    world_add_cube(f.world, 2, 0.2, NULL);
    CHECK(ecp_step(f.world, h, NULL, &r) == ECP_OK && r.patches_kept == 3);
    world_free(&f);
}

/* a cube slides on the ground, whose material changes from step to step */
static void world_test_material(void)
{
    static const double mu[] = {0.5, 0, 0.8, 0.5};
    ecp_world *w = test_world(NULL);
    ecp_material m = ecp_material_default(), bad[4];
    ecp_real v[3] = {3, 0, 0}, h = ECP_R(0.01), before;
    ecp_report r;
    world_fixture f;
    int k;
    test_ground(w, 0, 0, 1, NULL);
    world_add_cube(w, 0, 0.2, NULL);
    CHECK(ecp_body_set_state(w, 1, NULL, NULL, v, NULL) == ECP_OK);
    for (k = 0; k < 4; k++) {
        m.mu = (ecp_real)mu[k];
        m.e_r = k == 2 ? ECP_R(0.1) : ECP_R(0);
        CHECK(ecp_shape_set_material(w, 0, k < 3 ? &m : NULL) == ECP_OK);
        CHECK(ecp_shape_set_material(w, 1, k < 3 ? &m : NULL) == ECP_OK);
        before = v[0];
        CHECK(ecp_step(w, h, NULL, &r) == ECP_OK);
        CHECK(ecp_body_get_state(w, 1, NULL, NULL, v, NULL) == ECP_OK);
        CHECK_NEAR(v[0], (double)before - mu[k] * 9.8 * 0.01, test_by(1e-12, 1e-6));
        /* 6 of the body, 3 + 6 + 1 of the patch, and its friction */
        CHECK(r.unknowns == (k == 1 ? 16 : k == 2 ? 19 : 18));
    }
    free(w);
    world_cubes(&f, 0);
    for (k = 0; k < 4; k++) bad[k] = ecp_material_default();
    bad[0].mu = -1;
    bad[1].e_t = 0;
    bad[2].e_r = -1;
    bad[3].direction[1] = (ecp_real)NAN;
    WORLD_REFUSED(&f, ecp_shape_set_material(NULL, 0, bad), ECP_BAD_POINTER);
    WORLD_REFUSED(&f, ecp_shape_set_material(f.world, -1, NULL), ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_shape_set_material(f.world, 4, NULL), ECP_BAD_INDEX);
    WORLD_REFUSED(&f, ecp_shape_set_material(f.world, 1, bad), ECP_BAD_FRICTION);
    WORLD_REFUSED(&f, ecp_shape_set_material(f.world, 1, bad + 1), ECP_BAD_ELLIPSOID);
    WORLD_REFUSED(&f, ecp_shape_set_material(f.world, 1, bad + 2), ECP_BAD_ELLIPSOID);
    WORLD_REFUSED(&f, ecp_shape_set_material(f.world, 1, bad + 3), ECP_NOT_FINITE);
    world_free(&f);
}

/* A table at rest on a slope that gets rough, or takes up turning: the impulses are those of a table that has stood on it
   from the start. */
static void world_test_rough(void)
{
    const ecp_real tilted[3] = {ECP_R(3.35), 0, ECP_R(-9.21)},
                   half[3] = {ECP_R(.02), ECP_R(.02), ECP_R(.1)};
    int k, i, leg;
    for (k = 0; k < 2; k++) {
        ecp_contact c[2][4];
        for (i = 0; i < 2; i++) {
            ecp_world *w = test_world(NULL);
            ecp_material floor = ecp_material_default(), m = ecp_material_default();
            ecp_body_desc b = ecp_body_desc_default();
            ecp_shape s;
            ecp_report r;
            void *before;
            int step, body = 0;
            ecp_world_set_gravity(w, tilted);
            m.mu = m.e_r = 1;
            floor.mu = k == 0 && i == 0 ? ECP_R(0.2) : ECP_R(1);
            floor.e_r = k == 1 && i == 1 ? ECP_R(0.5) : ECP_R(0);
            test_ground(w, 0, 0, 1, &floor);
            b.inertia[0] = b.inertia[4] = b.inertia[8] = ECP_R(0.05);
            b.position[2] = ECP_R(0.3);
            CHECK(ecp_body_add(w, &b, &body) == ECP_OK);
            CHECK(ecp_shape_box(&s, half) == ECP_OK);
            for (leg = 0; leg < 4; leg++) {
                ecp_real at[3];
                ecp_i_set3(leg & 1 ? ECP_R(.2) : ECP_R(-.2), leg & 2 ? ECP_R(.25) : ECP_R(-.2),
                           ECP_R(-.2), at);
                CHECK(ecp_body_add_shape(w, body, &s, at, NULL, &m, NULL) == ECP_OK);
            }
            for (step = 0; step < 20; step++) {
                if (step == 10) {
                    floor.mu = 1;
                    floor.e_r = k == 1 ? ECP_R(0.5) : ECP_R(0);
                    CHECK(ecp_shape_set_material(w, 0, &floor) == ECP_OK);
                }
                CHECK(ecp_step(w, ECP_R(0.01), NULL, &r) == ECP_OK);
            }
            CHECK(r.centred == 1);
            /* what is there already changes no bit */
            before = malloc(w->bytes);
            memcpy(before, w, w->bytes);
            CHECK(ecp_shape_set_material(w, 0, &floor) == ECP_OK);
            CHECK(memcmp(before, w, w->bytes) == 0);
            free(before);
            for (leg = 0; leg < 4; leg++) CHECK(ecp_contact_get(w, leg, &c[i][leg]) == ECP_OK);
            free(w);
        }
        for (leg = 0; leg < 4; leg++) {
            CHECK_NEAR(c[0][leg].p_n, c[1][leg].p_n, test_by(1e-9, 1e-5));
            CHECK_NEAR(c[0][leg].p_t, c[1][leg].p_t, test_by(1e-9, 1e-5));
            CHECK_NEAR(c[0][leg].p_r, c[1][leg].p_r, test_by(1e-9, 1e-5));
        }
    }
}

/* ---- snapshots */

/* three boxes and a ball that tumble on to each other: every kind of patch, coming and going */
static ecp_world *world_tumble(size_t *bytes)
{
    ecp_world_desc desc = ecp_world_desc_default();
    ecp_world *w;
    int i;
    desc.max_bodies = 5;
    desc.max_shapes = 5;
    desc.max_patches = 10;
    w = test_world(&desc);
    *bytes = ecp_world_memsize(&desc);
    test_ground(w, 0.1, 0, 1, NULL);
    for (i = 0; i < 4; i++) {
        ecp_body_desc d = ecp_body_desc_default();
        ecp_shape s = world_box(0.3, 0.25, 0.2);
        d.inertia[0] = d.inertia[4] = d.inertia[8] = ECP_R(0.03);
        ecp_i_set3(ECP_R(0.1 * i), ECP_R(-0.05 * i), ECP_R(0.3 + 0.5 * i), d.position);
        ecp_i_set3(ECP_R(0.1 * i), ECP_R(0.2), ECP_R(0.1), d.rotation + 1);
        ecp_i_set3(0, 0, ECP_R(-0.5 * i), d.velocity);
        ecp_i_set3(1, ECP_R(i), -1, d.angular_velocity);
        if (i == 3) CHECK(ecp_shape_sphere(&s, ECP_R(0.2)) == ECP_OK);
        CHECK(ecp_body_add(w, &d, NULL) == ECP_OK);
        CHECK(ecp_body_add_shape(w, i + 1, &s, NULL, NULL, NULL, NULL) == ECP_OK);
    }
    return w;
}

static void world_test_snapshots(void)
{
    enum { WARM = 15, AFTER = 15 };
    size_t bytes, state;
    ecp_world *w = world_tumble(&bytes), *copy, *part, *first;
    int i, kept = 0, same = 1, zero = 1, solved = 1;
    ecp_report r;
    copy = (ecp_world *)malloc(bytes);
    part = (ecp_world *)calloc(1, bytes);
    first = (ecp_world *)malloc(bytes);
    state = ecp_world_state_size(w);
    for (i = 0; i < WARM; i++) {
        solved &= ecp_step(w, ECP_R(0.01), NULL, &r) == ECP_OK;
        CHECK(r.memory_used <= bytes);
        kept += r.patches_kept;
    }
    CHECK(solved && kept > WARM);
    /* all of the block; and the state alone, into zeros */
    memcpy(copy, w, bytes);
    memcpy(part, w, state);
    CHECK(memcmp(part, w, bytes) == 0);
    for (i = 0; i < AFTER; i++) {
        solved &= ecp_step(w, ECP_R(0.01), NULL, NULL) == ECP_OK;
        zero &= world_work_is_zero(w, bytes);
    }
    for (i = 0; i < AFTER; i++) {
        solved &= ecp_step(part, ECP_R(0.01), NULL, NULL) == ECP_OK;
    }
    CHECK(memcmp(part, w, bytes) == 0);
    memcpy(first, w, bytes);
    /* back, and the same future again */
    memcpy(w, copy, bytes);
    for (i = 0; i < AFTER; i++) {
        solved &= ecp_step(w, ECP_R(0.01), NULL, NULL) == ECP_OK;
        solved &= ecp_step(copy, ECP_R(0.01), NULL, NULL) == ECP_OK;
        same &= memcmp(w, copy, bytes) == 0;
    }
    CHECK(same && zero && solved);
    CHECK(memcmp(first, w, bytes) == 0);
    free(w);
    free(copy);
    free(part);
    free(first);
}

/* ---- exactly memsize bytes: a world filled to its description, between two fences, and in a block
   of its own for the address sanitizer */

static void world_test_fences(void)
{
    ecp_world_desc desc = ecp_world_desc_default();
    ecp_body_desc d = ecp_body_desc_default();
    ecp_shape box = world_box(0.5, 0.5, 0.25);
    ecp_report r;
    ecp_world *w = NULL;
    unsigned char *mem;
    size_t need, i;
    int k, intact = 1;
    desc.max_bodies = 4;
    desc.max_shapes = 4;
    desc.max_patches = 3;
    desc.max_inequalities = 12;
    need = ecp_world_memsize(&desc);
    mem = (unsigned char *)malloc(need + 128);
    memset(mem, 0xa5, need + 128);
    CHECK(ecp_world_init(&w, &desc, mem + 64, need) == ECP_OK);
    test_ground(w, 0, 0, 1, NULL);
    for (k = 0; k < 3; k++) {
        d.inertia[0] = d.inertia[4] = d.inertia[8] = ECP_R(0.1);
        ecp_i_set3(ECP_R(0.05 * k), 0, ECP_R(0.25 + 0.5 * k), d.position);
        ecp_i_set3(ECP_R(0.1 * k), 0, 0, d.velocity);
        CHECK(ecp_body_add(w, &d, NULL) == ECP_OK);
        CHECK(ecp_body_add_shape(w, k + 1, &box, NULL, NULL, NULL, NULL) == ECP_OK);
    }
    for (k = 0; k < 5; k++) {
        CHECK(ecp_step(w, ECP_R(0.01), NULL, &r) == ECP_OK);
        CHECK(r.patches_kept == 3 && r.unknowns > 3 * 6 + 10 + 2 * 16);
        CHECK(r.memory_used > ecp_world_state_size(w) && r.memory_used <= need);
    }
    for (i = 0; i < 64; i++) intact &= mem[i] == 0xa5 && mem[need + 64 + i] == 0xa5;
    CHECK(intact);
    free(mem);
}

static void test_world_section(void)
{
    world_test_strings();
    world_test_init();
    world_test_bodies();
    world_test_state();
    world_test_shapes();
    world_test_bad_loads();
    world_test_loads();
    world_test_kinds();
    world_test_bad_guess();
    world_test_bad_step();
    world_test_capacity();
    world_test_extreme_rotations();
    world_test_extreme_turns();
    world_test_failed_step();
    world_test_total_iterations();
    world_test_parts();
    world_test_padding();
    world_test_bad_remove();
    world_test_remove();
    world_test_remove_many();
    world_test_filter();
    world_test_material();
    world_test_rough();
    world_test_snapshots();
    world_test_fences();
}
