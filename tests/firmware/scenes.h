/* Fixed scenes that need nothing of a C library, and the hash of all their states: for the firmware,
   and for the comparison of bits between compilers and machines (tests/hashes.sh). To be included
   after the implementation of ecpsim.h. */
#ifndef SCENES_H
#define SCENES_H

#include "print.h"

enum { SCENE_HASH_EVERY = 100 };

/* One scene: `build` adds to an empty world with the ground z <= 0 as body 0; `load` acts before step
   number k = 1, 2, ..; `options` changes what the steps are told. The last two may be NULL. */
typedef struct scene {
    const char *name;
    int steps;
    ecp_real h;
    void (*build)(ecp_world *w);
    void (*load)(ecp_world *w, int k);
    void (*options)(ecp_options *o);
} scene;

/* what a run has come to; instructions: the most of a step, and of all steps in thousands */
typedef struct scene_result {
    uint32_t hash, most_instructions, thousand_instructions;
    int not_solved, fallbacks, centred;
} scene_result;

/* the description of the world of every scene, and memory that is enough for it in double */
static ecp_world_desc scene_desc(void)
{
    ecp_world_desc d = ecp_world_desc_default();
    d.max_bodies = 8;
    d.max_shapes = 16;
    d.max_patches = 16;
    d.max_inequalities = 14;
    return d;
}

static union {
    uint64_t align;
    unsigned char bytes[1500000];
} scene_memory __attribute__((aligned(8)));

/* ---- parts of scenes; errors show in the hash */

static ecp_material scene_material(double mu, double e_r)
{
    ecp_material m = ecp_material_default();
    m.mu = (ecp_real)mu;
    m.e_r = (ecp_real)e_r;
    return m;
}

static void scene_ground(ecp_world *w, double mu, double e_r)
{
    const ecp_real up[3] = {0, 0, 1};
    const ecp_material m = scene_material(mu, e_r);
    ecp_body_desc b = ecp_body_desc_default();
    ecp_shape s;
    b.kind = ECP_STATIC;
    ecp_body_add(w, &b, NULL);
    ecp_shape_half_space(&s, up, 0);
    ecp_body_add_shape(w, 0, &s, NULL, NULL, &m, NULL);
}

/* a uniform solid of this shape and mass at a place, moving; returns the body */
static int scene_solid(ecp_world *w, const ecp_shape *s, double mass, double x, double y, double z,
                       double vx, double wy, double mu)
{
    const ecp_material m = scene_material(mu, 0);
    ecp_body_desc b = ecp_body_desc_default();
    ecp_mass solid;
    int body = 0, k;
    ecp_shape_mass(s, 1, &solid);
    b.mass = (ecp_real)mass;
    for (k = 0; k < 9; k++) b.inertia[k] = solid.inertia[k] / solid.mass * b.mass;
    b.position[0] = (ecp_real)x;
    b.position[1] = (ecp_real)y;
    b.position[2] = (ecp_real)z;
    b.velocity[0] = (ecp_real)vx;
    b.angular_velocity[1] = (ecp_real)wy;
    ecp_body_add(w, &b, &body);
    ecp_body_add_shape(w, body, s, NULL, NULL, &m, NULL);
    return body;
}

static void scene_box(ecp_shape *s, double x, double y, double z)
{
    ecp_real half[3];
    half[0] = (ecp_real)x;
    half[1] = (ecp_real)y;
    half[2] = (ecp_real)z;
    ecp_shape_box(s, half);
}

/* the paper's three-legged table at rest at the origin, moving with this velocity (examples/table.h) */
static void scene_table(ecp_world *w, double vx, double vy)
{
    const ecp_material m = scene_material(0.12, 1);
    ecp_body_desc b = ecp_body_desc_default();
    const double across = 0.25980762113533160; /* 0.3 cos 30 degrees */
    ecp_shape s;
    int body = 0, i;
    b.mass = 5;
    b.inertia[0] = b.inertia[4] = ECP_R(0.3327);
    b.inertia[8] = ECP_R(0.4458);
    b.position[2] = ECP_R(0.3);
    b.velocity[0] = (ecp_real)vx;
    b.velocity[1] = (ecp_real)vy;
    ecp_body_add(w, &b, &body);
    ecp_shape_cylinder(&s, ECP_R(0.1), ECP_R(0.2089));
    for (i = 0; i < 3; i++) {
        ecp_real at[3];
        at[0] = (ecp_real)(i == 0 ? -across : i == 1 ? across : 0);
        at[1] = (ecp_real)(i == 2 ? 0.3 : -0.15);
        at[2] = ECP_R(-0.0911);
        ecp_body_add_shape(w, body, &s, at, NULL, &m, NULL);
    }
    ecp_shape_cylinder(&s, ECP_R(0.4), ECP_R(0.025));
    {
        const ecp_real at[3] = {0, 0, ECP_R(0.1428)};
        ecp_body_add_shape(w, body, &s, at, NULL, &m, NULL);
    }
}

/* ---- the scenes */

/* Example 1 of the paper: the table slides to rest */
static void scene_build_example1(ecp_world *w)
{
    scene_ground(w, 0.12, 1);
    scene_table(w, 4, 3);
}

/* Example 2: it is hit, tilts and rocks back */
static void scene_build_example2(ecp_world *w)
{
    scene_ground(w, 0.12, 1);
    scene_table(w, 0, 1);
}

static void scene_load_example2(ecp_world *w, int k)
{
    const ecp_real hit[3] = {-5, 0, 0};
    if (k == 76) ecp_body_apply_angular_impulse(w, 1, hit);
}

static void scene_build_box_drop(ecp_world *w)
{
    ecp_shape s;
    scene_ground(w, 0.5, 0);
    scene_box(&s, 0.2, 0.1, 0.05);
    scene_solid(w, &s, 1, 0, 0, 0.5, 1, 3, 0.5);
}

/* a hammer of two cylinders and a ball, thrown */
static void scene_build_union(ecp_world *w)
{
    const ecp_material m = scene_material(0.4, 0.01);
    const ecp_real head[3] = {0, 0, ECP_R(0.25)}, knob[3] = {0, 0, ECP_R(-0.2)};
    const ecp_real across[4] = {1, 1, 0, 0};
    ecp_shape s;
    int body;
    scene_ground(w, 0.4, 0.01);
    ecp_shape_cylinder(&s, ECP_R(0.02), ECP_R(0.2));
    body = scene_solid(w, &s, 2, 0, 0, 0.6, 1, -4, 0.4);
    ecp_shape_cylinder(&s, ECP_R(0.06), ECP_R(0.1));
    ecp_body_add_shape(w, body, &s, head, across, &m, NULL);
    ecp_shape_sphere(&s, ECP_R(0.04));
    ecp_body_add_shape(w, body, &s, knob, NULL, &m, NULL);
}

static ecp_real scene_vertices[3 * 16];

/* every kind of primitive on a box that is fixed */
static void scene_build_pairs(ecp_world *w)
{
    static const ecp_real planes[5 * 4] = {
        ECP_R(0.6),  0,          ECP_R(0.8), ECP_R(0.06), ECP_R(-0.6), 0,          ECP_R(0.8),
        ECP_R(0.06), 0,          1,          0,           ECP_R(0.1),  0,          -1,
        0,           ECP_R(0.1), 0,          0,           -1,          ECP_R(0.05)};
    const ecp_real radii[3] = {ECP_R(0.1), ECP_R(0.08), ECP_R(0.06)};
    ecp_body_desc b = ecp_body_desc_default();
    ecp_shape s;
    int body = 0;
    scene_ground(w, 0.5, 0);
    b.kind = ECP_STATIC;
    b.position[2] = ECP_R(0.1);
    ecp_body_add(w, &b, &body);
    scene_box(&s, 2, 0.5, 0.1);
    ecp_body_add_shape(w, body, &s, NULL, NULL, NULL, NULL);
    ecp_shape_sphere(&s, ECP_R(0.1));
    scene_solid(w, &s, 1, -1.2, 0, 0.4, 0.5, 0, 0.5);
    ecp_shape_ellipsoid(&s, radii);
    scene_solid(w, &s, 1, -0.8, 0, 0.4, 0.5, 0, 0.5);
    ecp_shape_capsule(&s, ECP_R(0.08), ECP_R(0.1));
    scene_solid(w, &s, 1, -0.4, 0, 0.5, 0, 2, 0.5);
    ecp_shape_frustum(&s, ECP_R(0.1), ECP_R(0.05), ECP_R(0.1));
    scene_solid(w, &s, 1, 0, 0, 0.4, 0, 1, 0.5);
    ecp_shape_polytope(&s, planes, 5, scene_vertices, 16);
    scene_solid(w, &s, 1, 0.5, 0, 0.4, 0, 1, 0.5);
    ecp_shape_cylinder(&s, ECP_R(0.1), ECP_R(0.1));
    scene_solid(w, &s, 1, 1, 0, 0.4, -1, 0, 0.5);
}

/* boxes on each other, the upper ones heavier, pushed from the side */
static void scene_build_stack(ecp_world *w)
{
    ecp_shape s;
    int i;
    scene_ground(w, 0.5, 0);
    scene_box(&s, 0.1, 0.1, 0.1);
    for (i = 0; i < 5; i++) {
        scene_solid(w, &s, i + 1, 0.01 * i, -0.01 * i, 0.1 + 0.2 * i, 0, 0, 0.5);
    }
}

static void scene_load_stack(ecp_world *w, int k)
{
    const ecp_real push[3] = {ECP_R(0.5), ECP_R(0.2), 0};
    if (k == 50) ecp_body_apply_impulse(w, 5, push, NULL);
}

/* planks thrown at each other in long steps, with few iterations: what the fallbacks are for */
static void scene_build_fallbacks(ecp_world *w)
{
    ecp_shape s;
    scene_ground(w, 1, 0);
    scene_box(&s, 0.5, 0.1, 0.01);
    scene_solid(w, &s, 1, 0, 0, 0.6, 3, 20, 1);
    scene_solid(w, &s, 0.01, 0.2, 0.02, 1.2, -3, -15, 1);
    ecp_shape_cylinder(&s, ECP_R(0.05), ECP_R(0.3));
    scene_solid(w, &s, 10, 0.1, 0, 1.8, 0, 10, 1);
}

static void scene_options_fallbacks(ecp_options *o) { o->max_iterations = 4; }

static const scene scenes[] = {
    {"example1", 500, ECP_R(0.01), scene_build_example1, NULL, NULL},
    {"example2", 300, ECP_R(0.01), scene_build_example2, scene_load_example2, NULL},
    {"box_drop", 300, ECP_R(0.01), scene_build_box_drop, NULL, NULL},
    {"union", 300, ECP_R(0.01), scene_build_union, NULL, NULL},
    {"pairs", 200, ECP_R(0.01), scene_build_pairs, NULL, NULL},
    {"stack", 200, ECP_R(0.01), scene_build_stack, scene_load_stack, NULL},
    {"fallbacks", 100, ECP_R(0.03), scene_build_fallbacks, NULL, scene_options_fallbacks},
};

enum { SCENE_COUNT = (int)(sizeof scenes / sizeof scenes[0]) };

/* ---- running them */

/* FNV-1a, going on by a byte */
static uint32_t scene_hash_byte(uint32_t hash, unsigned byte) { return (hash ^ byte) * 16777619u; }

#ifdef ECPSIM_FLOAT
typedef uint32_t scene_bits;
#else
typedef uint64_t scene_bits;
#endif

/* the bits of a real, the lowest byte first on machines of either byte order */
static uint32_t scene_hash_real(uint32_t hash, ecp_real x)
{
    union {
        ecp_real x;
        scene_bits bits;
    } of;
    unsigned k;
    of.x = x;
    for (k = 0; k < 8 * sizeof x; k += 8) {
        hash = scene_hash_byte(hash, (unsigned)(of.bits >> k) & 255u);
    }
    return hash;
}

/* the status of a step, and the states of all bodies after it */
static uint32_t scene_hash_world(uint32_t hash, const ecp_world *w, ecp_status status)
{
    ecp_real state[13];
    int i, k;
    hash = scene_hash_byte(hash, (unsigned)status & 255u);
    for (i = 0; i < ecp_world_body_count(w); i++) {
        ecp_body_get_state(w, i, state, state + 3, state + 7, state + 10);
        for (k = 0; k < 13; k++) hash = scene_hash_real(hash, state[k]);
    }
    return hash;
}

/* "name step=100 hash=xxxxxxxx" */
static void scene_show_hash(const char *name, int k, uint32_t hash)
{
    port_write(name);
    print_field("step", (uint32_t)k);
    port_write(" hash=");
    print_number(hash, 16, 8);
    port_write("\n");
}

/* Runs one scene, and shows its hash after every SCENE_HASH_EVERY steps if `show` says so. */
static scene_result scene_run(const scene *s, int show)
{
    const ecp_world_desc d = scene_desc();
    scene_result result = {2166136261u, 0, 0, 0, 0, 0};
    ecp_options o = ecp_options_default();
    uint32_t rest = 0;
    ecp_world *w;
    int k;
    if (ecp_world_init(&w, &d, scene_memory.bytes, sizeof scene_memory.bytes) != ECP_OK) {
        result.not_solved = -1;
        return result;
    }
    s->build(w);
    if (s->options) s->options(&o);
    for (k = 1; k <= s->steps; k++) {
        ecp_report r;
        ecp_status status;
        uint32_t count;
        if (s->load) s->load(w, k);
        port_instructions();
        status = ecp_step(w, s->h, &o, &r);
        count = port_instructions();
        if (count > result.most_instructions) result.most_instructions = count;
        rest += count % 1000;
        result.thousand_instructions += count / 1000 + rest / 1000;
        rest %= 1000;
        result.not_solved += status != ECP_OK;
        result.fallbacks |= r.fallbacks;
        result.centred += r.centred;
        result.hash = scene_hash_world(result.hash, w, status);
        if (show && k % SCENE_HASH_EVERY == 0) scene_show_hash(s->name, k, result.hash);
    }
    return result;
}

#endif
