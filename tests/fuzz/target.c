/* The public API as a machine of a few instructions: a byte string becomes a sequence of calls, with
   values that are ordinary, extreme or bad. For libFuzzer and AFL++ (tests/fuzz.sh); tests/fuzz/replay.c
   runs files through it without either. What must hold, whatever the calls:

   - a call that does not return ECP_OK has not changed a byte of the world;
   - all states are finite and quaternions have length one, after every call;
   - work memory is zero outside a call, and nothing is written beyond the bytes that were asked for
     (the block is an allocation of its own, full of other bytes before);
   - a step repeated from a copy of the block gives the same bytes.

   Memory errors and undefined behaviour are the sanitizers' to find, a loop without end the fuzzer's. */
#define ECPSIM_IMPLEMENTATION
#include "../../ecpsim.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef __has_feature
#if __has_feature(memory_sanitizer)
#define FUZZ_UNINITIALISED /* reads of what nobody wrote are to be found: do not write it */
#endif
#endif

#define REQUIRE(x) ((x) ? (void)0 : broken(#x, __LINE__))

static void broken(const char *what, int line)
{
    fprintf(stderr, "tests/fuzz/target.c:%d: broken: %s\n", line, what);
    abort();
}

/* calls and steps since the start, shown at exit */
static unsigned long calls, steps, solved;

typedef struct input {
    const unsigned char *at;
    size_t left;
} input;

static unsigned take(input *in)
{
    if (in->left == 0) return 0;
    in->left--;
    return *in->at++;
}

/* a number: mostly a small decimal, sometimes one of those that break things */
static ecp_real number(input *in)
{
    static const double odd[16] = {0,     -0.0, 1e-3, 1e-7, 1e-12, 1e-20, 1e-30, 1e-37,
                                   1e-44, 1e3,  1e6,  1e10, 1e15,  1e20,  3e37,  -1e10};
    unsigned b = take(in);
    ecp_real zero = ECP_R(0) * (ecp_real)b;
    if (b < 200) return (ecp_real)((int)b - 100) / ECP_R(20.0);
    if (b < 232) return (ecp_real)((int)b - 200) / ECP_R(1000.0);
    if (b < 248) return (ecp_real)odd[b - 232];
    if (b == 248) return zero / zero;
    if (b == 249) return 1 / zero;
    if (b == 250) return -1 / zero;
    if (b == 251) return sizeof(ecp_real) == 8 ? (ecp_real)1e300 : (ecp_real)3e38;
    if (b == 252) return sizeof(ecp_real) == 8 ? (ecp_real)1e-300 : (ecp_real)1e-45;
    return (ecp_real)(((int)take(in) << 8) + (int)take(in) - 32768) / ECP_R(8192.0);
}

/* the same, but bad only now and then: most scenes are to get as far as a step */
static ecp_real size(input *in)
{
    unsigned b = take(in);
    return b < 240 ? (ecp_real)(b + 1) / ECP_R(200.0) : number(in);
}

static void numbers(input *in, int n, ecp_real *x)
{
    int i;
    for (i = 0; i < n; i++) x[i] = number(in);
}

typedef struct machine {
    ecp_world *world;
    unsigned char *copy, *again; /* the state alone, and another block for the world */
    size_t bytes, state;
    ecp_real vertices[8][3 * 24], planes[8][4 * 9]; /* of polytopes: they must outlive the world */
    int polytopes;
} machine;

static unsigned char *block(size_t bytes)
{
    unsigned char *p = (unsigned char *)malloc(bytes);
    REQUIRE(p != NULL);
#ifndef FUZZ_UNINITIALISED
    memset(p, 0xa5, bytes);
#endif
    return p;
}

static void check_world(const machine *m)
{
    const unsigned char *p = (const unsigned char *)m->world;
    int k, j, count = ecp_world_body_count(m->world);
    REQUIRE(p[m->state] == 0 &&
            memcmp(p + m->state, p + m->state + 1, m->bytes - m->state - 1) == 0);
    for (k = 0; k < count; k++) {
        ecp_real x[13], length = 0;
        if (ecp_body_get_state(m->world, k, x, x + 3, x + 7, x + 10) != ECP_OK) continue;
        for (j = 0; j < 13; j++) REQUIRE(x[j] - x[j] == 0);
        for (j = 3; j < 7; j++) length += x[j] * x[j];
        REQUIRE(length > ECP_R(0.999) && length < ECP_R(1.001));
    }
}

/* what a call may have done, by its status */
static void after(machine *m, ecp_status status)
{
    calls++;
    REQUIRE(strcmp(ecp_status_string(status), "not a status of this library") != 0);
    if (status != ECP_OK) REQUIRE(memcmp(m->world, m->copy, m->state) == 0);
    memcpy(m->copy, m->world, m->state);
    check_world(m);
}

/* a world in a block of its own, or none; one byte short and misaligned first */
static int begin(machine *m, input *in)
{
    ecp_world_desc d = ecp_world_desc_default();
    unsigned char *p;
    ecp_world *w = NULL;
    ecp_status status;
    unsigned more;
    memset(m, 0, sizeof *m);
    d.max_bodies = 1 + (int)take(in) % 5;
    d.max_shapes = 1 + (int)take(in) % 8;
    d.max_patches = 1 + (int)take(in) % 8;
    d.max_inequalities = 1 + (int)take(in) % 14;
    if (take(in) % 4 == 0) numbers(in, 3, d.gravity);
    if (take(in) % 8 == 0) d.solver_bytes = 8 * (size_t)take(in);
    more = take(in);
    if (more % 32 == 0) d.max_patches = (int)take(in) * 8421504;
    if (more % 4 == 1) d.advance_order = 2 + (int)more / 4 % 5;
    m->bytes = ecp_world_memsize(&d);
    if (m->bytes == 0 || m->bytes > 4000000) return 0;
    p = (unsigned char *)malloc(m->bytes - 1);
    REQUIRE(p != NULL);
    REQUIRE(ecp_world_init(&w, &d, p, m->bytes - 1) != ECP_OK && w == NULL);
    free(p);
    p = (unsigned char *)malloc(m->bytes + 8);
    REQUIRE(p != NULL);
    REQUIRE(ecp_world_init(&w, &d, p + 1, m->bytes + 7) != ECP_OK && w == NULL);
    free(p);
    p = block(m->bytes);
    status = ecp_world_init(&w, &d, p, m->bytes);
    calls += 4;
    if (status != ECP_OK) {
        free(p);
        return 0;
    }
    REQUIRE((unsigned char *)w == p);
    m->world = w;
    m->state = ecp_world_state_size(w);
    m->copy = block(m->state);
    m->again = (unsigned char *)calloc(m->bytes, 1);
    REQUIRE(m->again != NULL);
    memcpy(m->copy, w, m->state);
    check_world(m);
    return 1;
}

static void add_body(machine *m, input *in)
{
    ecp_body_desc b = ecp_body_desc_default();
    unsigned how = take(in);
    int body;
    b.kind = (ecp_body_kind)(how % 16 < 11 ? 2 : how % 16 < 13 ? 0 : how % 16 < 15 ? 1 : 3);
    b.mass = size(in);
    b.inertia[0] = b.inertia[4] = b.inertia[8] = b.mass * ECP_R(0.02);
    if (how & 16) numbers(in, 9, b.inertia);
    if (how & 32) b.inertia[0] = b.inertia[4] = b.inertia[8] = size(in);
    numbers(in, 3, b.position);
    if (how & 64) numbers(in, 4, b.rotation);
    if (how & 128) {
        numbers(in, 3, b.velocity);
        numbers(in, 3, b.angular_velocity);
    }
    after(m, ecp_body_add(m->world, take(in) % 64 ? &b : NULL, &body));
}

static ecp_status shape(machine *m, input *in, ecp_shape *s)
{
    ecp_real v[4], *planes;
    int i, n;
    switch (take(in) % 9) {
    case 0:
    case 1: numbers(in, 4, v); return ecp_shape_half_space(s, v, v[3]);
    case 2: return ecp_shape_sphere(s, size(in));
    case 3:
        for (i = 0; i < 3; i++) v[i] = size(in);
        return ecp_shape_ellipsoid(s, v);
    case 4: v[0] = size(in); return ecp_shape_capsule(s, v[0], size(in));
    case 5: v[0] = size(in); return ecp_shape_cylinder(s, v[0], size(in));
    case 6:
        v[0] = size(in);
        v[1] = size(in);
        return ecp_shape_frustum(s, v[0], v[1], size(in));
    case 7:
        for (i = 0; i < 3; i++) v[i] = size(in);
        return ecp_shape_box(s, v);
    default: break;
    }
    if (m->polytopes == 8) return ECP_CAPACITY;
    planes = m->planes[m->polytopes];
    n = 4 + (int)take(in) % 6;
    for (i = 0; i < n; i++) {
        numbers(in, 3, planes + 4 * i);
        planes[4 * i + 3] = size(in);
    }
    return ecp_shape_polytope(s, planes, n, m->vertices[m->polytopes++], 24);
}

/* with a direction, or without */
static ecp_material any_material(input *in, unsigned how)
{
    ecp_material material = ecp_material_default();
    material.mu = number(in);
    material.e_t = size(in);
    material.e_o = size(in);
    material.e_r = size(in);
    if (how & 32) numbers(in, 3, material.direction);
    return material;
}

static void add_shape(machine *m, input *in)
{
    unsigned how = take(in);
    ecp_material material = ecp_material_default();
    ecp_real at[3], q[4], lo[3], hi[3];
    ecp_mass mass, sum;
    ecp_shape s;
    int body = (int)take(in) % 6 - (how % 32 == 0);
    calls++;
    if (shape(m, in, &s) != ECP_OK) return;
    ecp_shape_bounds(&s, lo, hi);
    ecp_shape_mass(&s, 1, &mass);
    memset(&sum, 0, sizeof sum);
    if (how & 4) numbers(in, 3, at);
    if (how & 8) numbers(in, 4, q);
    if (how & 16) material = any_material(in, how);
    after(m, ecp_body_add_shape(m->world, body, &s, how & 4 ? at : NULL, how & 8 ? q : NULL,
                                how & 16 ? &material : NULL, NULL));
}

static void ignore(void *user, const char *text)
{
    while (*text) *(unsigned long *)user += (unsigned char)*text++;
}

/* a step, and the same from a copy */
static void step(machine *m, input *in)
{
    static const double lengths[8] = {0.01, 0.01, 0.02, 0.1, 1e-3, 1e-5, 1, 0.05};
    ecp_options o = ecp_options_default();
    unsigned how = take(in), kind = take(in);
    ecp_real h = (ecp_real)lengths[how % 8];
    ecp_report r, r2;
    ecp_printed printed;
    ecp_status status;
    ecp_contact c;
    unsigned long sum = 0;
    int i;
    o.max_iterations = 1 + (int)(how >> 3) % 16; /* 32 of these a byte are too slow */
    o.fallbacks = kind % 16;
    if (kind % 64 == 63) o.fallbacks = 63;
    if (how > 250) h = number(in);
    if (kind & 128) o.rule = ECP_NEAREST;
    o.sleep = kind >> 6 & 1;
    if (kind == 200) o.tolerance = number(in);
    /* what is not solved takes its time to say so */
    o.max_total_iterations = kind % 64 == 63 ? 300 : kind % 8 == 6 ? 1 + (int)take(in) % 40 : 60;
    if (kind == 201) o.max_iterations = (int)take(in) - 1;
    if (kind == 202) o.max_total_iterations = -1;
    memcpy(m->again, m->world, m->state);
    status = ecp_step(m->world, h, &o, &r);
    steps++;
    solved += status == ECP_OK;
    REQUIRE(status == r.status);
    REQUIRE(o.max_total_iterations <= 0 || r.iterations <= o.max_total_iterations);
    if (status == ECP_OK) {
        REQUIRE(r.natural_residual - r.natural_residual == 0 && r.merit - r.merit == 0);
        REQUIRE(r.memory_used <= m->bytes);
    }
    if (status == ECP_OK) {
        ecp_printed_residual((const ecp_world *)(const void *)m->copy, m->world, h, &printed);
    }
    after(m, status);
    if (r.iterations < 100) { /* a step that took long is not done twice */
        REQUIRE(ecp_step((ecp_world *)(void *)m->again, h, &o, &r2) == status);
        REQUIRE(memcmp(m->again, m->world, m->state) == 0);
    }
    for (i = 0; ecp_contact_get(m->world, i, &c) == ECP_OK; i++) {
        REQUIRE(c.p_n - c.p_n == 0 && c.gap - c.gap == 0);
    }
    REQUIRE(i <= ecp_contact_count(m->world));
    if (kind % 16 == 5) ecp_dump(m->world, h, &o, ignore, &sum);
    calls += 2;
}

/* the world to a time, with few base steps: how many it takes is the caller's business */
static void advance(machine *m, input *in)
{
    static const double durations[8] = {0.01, 0.05, 0.1, 0.3, 1, 1e-3, 1e-5, 0};
    ecp_advance_options o = ecp_advance_options_default();
    ecp_options step = ecp_options_default();
    unsigned how = take(in);
    ecp_real duration = (ecp_real)durations[how % 8];
    ecp_advance_report r;
    ecp_status status;
    if (how > 250) duration = number(in);
    if (how & 8) o.macro_step = size(in);
    if (how & 16) o.tolerance = size(in) * ECP_R(0.01);
    if (how & 32) o.order = (int)take(in) % 8;
    o.max_solves = 1 + (int)(how >> 6) * 4;
    step.max_iterations = 8;
    step.max_total_iterations = 30;
    o.step = &step;
    status = ecp_advance(m->world, duration, &o, &r);
    REQUIRE(status == r.status);
    if (status == ECP_OK) REQUIRE(r.reached == duration && r.error == r.error);
    after(m, status);
}

static void other(machine *m, input *in)
{
    unsigned which = take(in);
    int i = (int)take(in) % 6 - (which > 250), j = (int)take(in) % 9;
    ecp_real v[13], *point = which & 64 ? v + 3 : NULL;
    const ecp_shape *s;
    ecp_material material;
    ecp_world *w = m->world;
    switch (which % 12) {
    case 0:
        numbers(in, 3, v);
        after(m, ecp_world_set_gravity(w, v));
        break;
    case 1: after(m, ecp_body_remove(w, i)); break;
    case 2:
    case 3:
        numbers(in, 13, v);
        after(m, ecp_body_set_state(w, i, which & 16 ? v : NULL, which & 32 ? v + 3 : NULL,
                                    which & 64 ? v + 7 : NULL, which & 128 ? v + 10 : NULL));
        break;
    case 4:
        numbers(in, 6, v);
        after(m, ecp_body_apply_force(w, i, v, point));
        break;
    case 5:
        numbers(in, 6, v);
        after(m, ecp_body_apply_impulse(w, i, v, point));
        break;
    case 6:
        numbers(in, 3, v);
        after(m, ecp_body_apply_torque(w, i, v));
        break;
    case 7:
        numbers(in, 3, v);
        after(m, ecp_body_apply_angular_impulse(w, i, v));
        break;
    case 8:
        numbers(in, 3, v);
        after(m, ecp_guess_ecp(w, (int)take(in) % 9 - 1, j, which & 128 ? NULL : v));
        break;
    case 9: after(m, ecp_shape_set_filter(w, j, take(in), take(in))); break;
    case 10:
        if (which & 64) {
            material = any_material(in, which);
            after(m, ecp_shape_set_material(w, j, which & 128 ? NULL : &material));
            break;
        }
        if (which & 128) {
            after(m, ecp_body_clear_loads(w, i));
            break;
        }
        after(m, ecp_shape_get(w, j, &s, &i, v, NULL));
        break;
    default:
        if (which & 64) {
            advance(m, in);
            break;
        }
        /* what has no world */
        calls += 2;
        REQUIRE(ecp_step(NULL, 1, NULL, NULL) == ECP_BAD_POINTER);
        REQUIRE(ecp_step(w, 0, NULL, NULL) == ECP_BAD_STEP);
        after(m, ecp_contact_get(w, 1000000, NULL));
        break;
    }
}

static void show_sum(void)
{
    fprintf(stderr, "fuzz: calls=%lu steps=%lu solved=%lu\n", calls, steps, solved);
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t count);
int LLVMFuzzerTestOneInput(const unsigned char *data, size_t count)
{
    static int registered;
    int steps_left = 6;
    machine m;
    input in;
    if (!registered) atexit(show_sum);
    registered = 1;
    in.at = data;
    in.left = count < 600 ? count : 600;
    if (!begin(&m, &in)) return 0;
    while (in.left > 0) {
        unsigned op = take(&in) % 16;
        if (op < 3)
            add_body(&m, &in);
        else if (op < 7)
            add_shape(&m, &in);
        else if (op < 11 && steps_left-- > 0)
            step(&m, &in);
        else
            other(&m, &in);
    }
    if (steps_left == 6) step(&m, &in);
    free(m.world);
    free(m.copy);
    free(m.again);
    return 0;
}
