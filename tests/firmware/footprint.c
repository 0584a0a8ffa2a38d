/* One scene as a program of its own, to see what it costs: tests/size.sh compiles it with SCENE as one
   of the names below and takes the size of the image; with -DMEASURE it also prints what a run needs. */
#define ECPSIM_IMPLEMENTATION
#include "../../ecpsim.h"
#include "port.h"

#define BALL 1
#define BOX 2
#define TABLE 3
#define BOX_ON_BOX 4
#define EVERYTHING 5

#define STEPS 200

static union {
    uint64_t align;
    unsigned char bytes[SCENE == EVERYTHING ? 1000000 : 65536];
} memory __attribute__((aligned(8)));

/* the capacities that the scene needs, no more */
static ecp_world_desc describe(void)
{
    ecp_world_desc d = ecp_world_desc_default();
    if (SCENE == EVERYTHING) return d;
    d.max_bodies = SCENE == BOX_ON_BOX ? 3 : 2;
    d.max_shapes = SCENE == TABLE ? 4 : SCENE == BOX_ON_BOX ? 3 : 2;
    d.max_patches = SCENE == TABLE ? 3 : SCENE == BOX_ON_BOX ? 2 : 1;
    d.max_inequalities = SCENE == BALL ? 1 : SCENE == TABLE ? 3 : SCENE == BOX ? 6 : 12;
    return d;
}

static ecp_status add(ecp_world *w, ecp_body_kind kind, const ecp_shape *shape, ecp_real x,
                      ecp_real z, const ecp_material *m)
{
    ecp_body_desc b = ecp_body_desc_default();
    ecp_status status;
    int body;
    b.kind = kind;
    b.inertia[0] = b.inertia[4] = b.inertia[8] = ECP_R(0.01);
    ecp_i_set3(x, 0, z, b.position);
    if (kind == ECP_DYNAMIC) ecp_i_set3(1, ECP_R(0.5), 0, b.velocity);
    status = ecp_body_add(w, &b, &body);
    return status != ECP_OK ? status : ecp_body_add_shape(w, body, shape, NULL, NULL, m, NULL);
}

#if SCENE == EVERYTHING

/* every public function, so that all are linked */
typedef void (*any)(void);
static const any api[] = {(any)ecp_status_string,
                          (any)ecp_arithmetic,
                          (any)ecp_lu_factor,
                          (any)ecp_lu_solve,
                          (any)ecp_chol_factor,
                          (any)ecp_chol_solve,
                          (any)ecp_qr_factor,
                          (any)ecp_qr_apply_qt,
                          (any)ecp_qr_apply_q,
                          (any)ecp_least_squares,
                          (any)ecp_eliminate,
                          (any)ecp_quat_to_matrix,
                          (any)ecp_quat_multiply,
                          (any)ecp_quat_advance,
                          (any)ecp_shape_convex,
                          (any)ecp_shape_bounds,
                          (any)ecp_shape_mass,
                          (any)ecp_mass_add,
                          (any)ecp_world_state_size,
                          (any)ecp_world_set_gravity,
                          (any)ecp_world_body_count,
                          (any)ecp_world_shape_count,
                          (any)ecp_body_remove,
                          (any)ecp_body_set_state,
                          (any)ecp_body_apply_force,
                          (any)ecp_body_apply_torque,
                          (any)ecp_body_apply_impulse,
                          (any)ecp_shape_get,
                          (any)ecp_body_apply_angular_impulse,
                          (any)ecp_body_clear_loads,
                          (any)ecp_shape_set_filter,
                          (any)ecp_guess_ecp,
                          (any)ecp_dump,
                          (any)ecp_printed_residual,
                          (any)ecp_translation_step,
                          (any)ecp_mcp_memsize,
                          (any)ecp_mcp_solve};

static volatile unsigned which; /* so that no compiler knows which one is read */
static ecp_real vertices[3 * 8];

static ecp_status build(ecp_world *w)
{
    static const ecp_real planes[6 * 4] = {1, 0, 0, ECP_R(0.1), -1, 0,  0,  ECP_R(0.1),
                                           0, 1, 0, ECP_R(0.1), 0,  -1, 0,  ECP_R(0.1),
                                           0, 0, 1, ECP_R(0.1), 0,  0,  -1, ECP_R(0.1)};
    const ecp_real half[3] = {ECP_R(0.1), ECP_R(0.1), ECP_R(0.1)}, up[3] = {0, 0, 1};
    ecp_shape s;
    ecp_status status;
    int i;
    if (!api[which]) return ECP_BAD_POINTER;
    ecp_shape_half_space(&s, up, 0);
    status = add(w, ECP_STATIC, &s, 0, 0, NULL);
    for (i = 0; i < 7 && status == ECP_OK; i++) {
        if (i == 0) ecp_shape_sphere(&s, ECP_R(0.1));
        if (i == 1) ecp_shape_ellipsoid(&s, half);
        if (i == 2) ecp_shape_capsule(&s, ECP_R(0.1), ECP_R(0.1));
        if (i == 3) ecp_shape_cylinder(&s, ECP_R(0.1), ECP_R(0.1));
        if (i == 4) ecp_shape_frustum(&s, ECP_R(0.1), ECP_R(0.05), ECP_R(0.1));
        if (i == 5) ecp_shape_box(&s, half);
        if (i == 6) ecp_shape_polytope(&s, planes, 6, vertices, 8);
        status = add(w, ECP_DYNAMIC, &s, ECP_R(0.4) * (ecp_real)i, ECP_R(0.5), NULL);
    }
    return status;
}

#else

static ecp_status build(ecp_world *w)
{
    const ecp_real up[3] = {0, 0, 1}, half[3] = {ECP_R(0.2), ECP_R(0.15), ECP_R(0.1)};
    ecp_material m = ecp_material_default();
    ecp_shape s;
    ecp_status status;
    int i;
    if (SCENE == BALL) m.mu = 0;
    if (SCENE == TABLE) m.e_r = 1;
    ecp_shape_half_space(&s, up, 0);
    status = add(w, ECP_STATIC, &s, 0, 0, &m);
    if (status != ECP_OK) return status;
    if (SCENE == BALL) ecp_shape_sphere(&s, ECP_R(0.1));
    if (SCENE == TABLE) ecp_shape_cylinder(&s, ECP_R(0.1), ECP_R(0.2));
    if (SCENE == BOX || SCENE == BOX_ON_BOX) ecp_shape_box(&s, half);
    status = add(w, ECP_DYNAMIC, &s, SCENE == TABLE ? ECP_R(0.3) : ECP_R(0), ECP_R(0.5), &m);
    if (status == ECP_OK && SCENE == BOX_ON_BOX) {
        status = add(w, ECP_DYNAMIC, &s, ECP_R(0.05), ECP_R(0.8), &m);
    }
    for (i = 0; SCENE == TABLE && i < 2 && status == ECP_OK; i++) {
        ecp_real at[3] = {ECP_R(-0.45), ECP_R(0.26), 0};
        if (i > 0) at[1] = -at[1];
        status = ecp_body_add_shape(w, 1, &s, at, NULL, &m, NULL);
    }
    return status;
}

#endif

#ifdef MEASURE
#include "print.h"

static int most_unknowns, full_unknowns, not_solved;
static size_t most_memory;

/* unknowns of the library, and of the paper for the same contacts: 6 a body, and for each patch two
   points, their multipliers, p_n, p_t, p_o, p_r and sigma */
static void note(const ecp_world *w, const ecp_report *r)
{
    int i, bodies = ecp_world_body_count(w) - 1, full = 6 * bodies;
    ecp_contact c;
    not_solved += r->status != ECP_OK;
    if (r->memory_used > most_memory) most_memory = r->memory_used;
    if (r->unknowns <= most_unknowns || r->status != ECP_OK) return;
    for (i = 0; ecp_contact_get(w, i, &c) == ECP_OK; i++) {
        const ecp_shape *a, *b;
        ecp_shape_get(w, c.shape_a, &a, NULL, NULL, NULL);
        ecp_shape_get(w, c.shape_b, &b, NULL, NULL, NULL);
        full += 11 + a->inequalities + b->inequalities;
    }
    most_unknowns = r->unknowns;
    full_unknowns = full;
}

static void show(const ecp_world_desc *d)
{
    print_field("world_bytes", (uint32_t)ecp_world_memsize(d));
    print_field("used_bytes", (uint32_t)most_memory);
    print_field("stack_bytes", port_stack_used());
    print_field("unknowns", (uint32_t)most_unknowns);
    print_field("full_mncp", (uint32_t)full_unknowns);
    print_field("not_solved", (uint32_t)not_solved);
    port_write("\n");
}
#endif

int port_main(void)
{
    const ecp_world_desc d = describe();
    ecp_options o = ecp_options_default();
    ecp_world *w;
    int k;
    if (ecp_world_init(&w, &d, memory.bytes, sizeof memory) != ECP_OK) return 1;
    if (build(w) != ECP_OK) return 2;
    for (k = 0; k < STEPS; k++) {
        ecp_report r;
        ecp_step(w, ECP_R(0.01), &o, &r);
#ifdef MEASURE
        note(w, &r);
#else
        if (r.status != ECP_OK) return 3;
#endif
    }
#ifdef MEASURE
    show(&d);
#endif
    return 0;
}
