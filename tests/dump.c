/* A step as C source, and back: tests/run.sh compiles this file, which writes the dump of a step in
   the middle of a motion to a file, and then again with -DDUMPED="the file", which does the step from
   the source. Both print a hash of every bit of the state some steps later. */
#define ECPSIM_IMPLEMENTATION
#include "../ecpsim.h"

#include <stdio.h>
#include <stdlib.h>

/* FNV-1a, hash going on */
static unsigned long hash_bytes(unsigned long hash, const void *bytes, size_t count)
{
    const unsigned char *p = (const unsigned char *)bytes;
    while (count-- > 0) hash = ((hash ^ *p++) * 16777619ul) & 0xfffffffful;
    return hash;
}

/* the bodies, the contacts and their multipliers */
static unsigned long hash_world(const ecp_world *w)
{
    unsigned long hash = 2166136261ul;
    size_t patches = (size_t)w->patches;
    hash = hash_bytes(hash, ecp_i_bodies(w), (size_t)w->bodies * sizeof(ecp_i_body));
    hash = hash_bytes(hash, ecp_i_patches(w), patches * sizeof(ecp_i_patch));
    return hash_bytes(hash, ecp_i_multipliers(w, 0),
                      patches * (size_t)w->desc.max_inequalities * sizeof(ecp_real));
}

/* the status of the step, the world after it, and after ten more */
static int show(ecp_world *w, const ecp_report *r)
{
    ecp_status status = r->status;
    int k;
    printf("%d, %d bodies, %d asleep, %d contacts, %lu bytes, hash %08lx", (int)status, w->bodies,
           r->asleep, w->patches, (unsigned long)w->bytes, hash_world(w));
    for (k = 0; k < 10; k++) ecp_step(w, ECP_R(0.01), NULL, NULL);
    printf(", then %08lx\n", hash_world(w));
    free(w);
    return status != ECP_OK || r->asleep < 1;
}

#ifdef DUMPED

#include DUMPED

int main(void)
{
    ecp_world *w = NULL;
    ecp_report r;
    dumped_step(&w, &r);
    return w ? show(w, &r) : 1;
}

#else

static void write_file(void *user, const char *text) { fputs(text, (FILE *)user); }

/* a body at (x, 0, z), turned and moving, of mass 1 */
static int add_body(ecp_world *w, ecp_body_kind kind, double x, double z)
{
    ecp_body_desc d = ecp_body_desc_default();
    int body = -1;
    d.kind = kind;
    d.position[0] = ECP_R(x);
    d.position[2] = ECP_R(z);
    ecp_i_set3(ECP_R(0.1), ECP_R(0.2), ECP_R(x), d.rotation + 1);
    ecp_i_set3(ECP_R(0.1), 0, ECP_R(-0.3), d.velocity);
    ecp_i_set3(1, ECP_R(-x), 2, d.angular_velocity);
    d.inertia[0] = d.inertia[4] = d.inertia[8] = ECP_R(0.02);
    ecp_body_add(w, &d, &body);
    return body;
}

int main(int argc, char **argv)
{
    /* a tetrahedron */
    static const double corner[4][3] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    ecp_real planes[16], vertices[12], radii[3], at[3], slope[3], load[3];
    ecp_world_desc desc = ecp_world_desc_default();
    ecp_options o = ecp_options_default();
    ecp_material m = ecp_material_default();
    ecp_body_desc ground = ecp_body_desc_default();
    ecp_shape s[8];
    ecp_world *w = NULL;
    ecp_report r;
    FILE *file = argc > 1 ? fopen(argv[1], "w") : NULL;
    size_t bytes;
    int i, k, body, fixed;
    if (!file) return 1;
    desc.max_bodies = 12;
    desc.max_patches = 20;
    desc.solver_bytes = 200000;
    desc.advance_order = 3; /* its memory is there for steps as well */
    bytes = ecp_world_memsize(&desc);
    ecp_world_init(&w, &desc, malloc(bytes), bytes);
    for (i = 0; i < 4; i++) {
        for (k = 0; k < 3; k++) planes[4 * i + k] = ECP_R(corner[i][k]) / ecp_i_sqrt(3);
        planes[4 * i + 3] = ECP_R(0.12);
    }
    ecp_i_set3(ECP_R(0.2), ECP_R(0.15), ECP_R(0.1), radii);
    ecp_i_set3(ECP_R(0.05), ECP_R(0.01), 1, slope);
    ecp_i_set3(ECP_R(0.01), ECP_R(-0.02), ECP_R(0.03), at);
    ecp_i_set3(ECP_R(1.5), ECP_R(-0.7), ECP_R(0.1), load);
    ecp_shape_half_space(s, slope, ECP_R(-0.001));
    ecp_shape_sphere(s + 1, ECP_R(0.15));
    ecp_shape_ellipsoid(s + 2, radii);
    ecp_shape_capsule(s + 3, ECP_R(0.1), ECP_R(0.15));
    ecp_shape_cylinder(s + 4, ECP_R(0.15), ECP_R(0.1));
    ecp_shape_frustum(s + 5, ECP_R(0.2), ECP_R(0.1), ECP_R(0.12));
    ecp_shape_box(s + 6, radii);
    ecp_shape_polytope(s + 7, planes, 4, vertices, 4);
    /* every kind on a slope, a box that passes, two indices that are free again, and a box that sleeps */
    m.mu = ECP_R(0.3);
    m.e_t = ECP_R(0.8);
    m.e_r = ECP_R(0.05);
    m.direction[1] = ECP_R(1.1);
    ground.kind = ECP_STATIC;
    ecp_body_add(w, &ground, &fixed);
    ecp_body_add_shape(w, fixed, s, NULL, NULL, &m, NULL);
    for (i = 1; i < 8; i++) {
        body = add_body(w, ECP_DYNAMIC, 0.7 * i, 0.2 - 0.035 * i);
        ecp_body_add_shape(w, body, s + i, at, NULL, &m, NULL);
        if (i == 2) add_body(w, ECP_STATIC, 0, 2);
    }
    body = add_body(w, ECP_KINEMATIC, 4.2, -0.5);
    ecp_body_add_shape(w, body, s + 6, NULL, NULL, NULL, &k);
    ecp_shape_set_filter(w, k, 2, 0xfffffff5u);
    ecp_i_set3(ECP_R(-5.0), 0, 3, ground.position);
    ecp_body_add(w, &ground, &fixed);
    ecp_body_add_shape(w, fixed, s + 6, NULL, NULL, NULL, NULL);
    ground.kind = ECP_DYNAMIC;
    ground.position[2] += 2 * radii[2];
    ecp_body_add(w, &ground, &body);
    ecp_body_add_shape(w, body, s + 6, NULL, NULL, NULL, NULL);
    o.rule = ECP_NEAREST;
    o.tolerance /= 2;
    o.sleep = 1;
    for (i = 0; i < 25; i++) ecp_step(w, ECP_R(0.0123), &o, NULL);
    ecp_body_remove(w, 3);
    ecp_body_remove(w, 4);
    ecp_body_apply_force(w, 1, load, NULL);
    ecp_body_apply_impulse(w, 2, at, load);
    ecp_guess_ecp(w, 2, 0, at);
    if (ecp_dump(w, ECP_R(0.0123), &o, write_file, file) != ECP_OK || fclose(file)) return 1;
    ecp_step(w, ECP_R(0.0123), &o, &r);
    return show(w, &r);
}

#endif
