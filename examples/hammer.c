/* A body of several primitives: a hammer, made of a wooden cylinder and an iron box, falls and comes to
   rest on an edge of the head and the end of the handle. Shows how the mass, the centre of mass and the
   inertia of a union are found, and how contacts are read.

       cc -O2 -I. examples/hammer.c -o hammer -lm && ./hammer */

#define ECPSIM_IMPLEMENTATION
#include "ecpsim.h"
#include <stdio.h>
#include <stdlib.h>

/* the drawing: parts, where they are in it (m), turned how (w, x, y, z), and made of what (kg/m^3) */
enum { HANDLE, HEAD, PARTS };
static const ecp_real place[PARTS][3] = {{0, 0, 0}, {0.15, 0, 0}};
static const ecp_real turn[PARTS][4] = {{1, 0, 1, 0}, {1, 0, 0, 0}}; /* the handle lies along x */
static const ecp_real density[PARTS] = {700, 7800};
static const char *const part_names[PARTS] = {"handle", "head"};

static void must(ecp_status status)
{
    if (status == ECP_OK) return;
    fprintf(stderr, "hammer: %s\n", ecp_status_string(status));
    exit(1);
}

/* Adds the hammer at this height; its body's frame is that of the drawing, moved to the centre of mass. */
static int add_hammer(ecp_world *world, ecp_real height)
{
    const ecp_real half[3] = {0.015, 0.05, 0.015};
    ecp_body_desc desc = ecp_body_desc_default();
    ecp_mass total = {0, {0, 0, 0}, {0, 0, 0, 0, 0, 0, 0, 0, 0}}, mass;
    ecp_shape shapes[PARTS];
    int body;
    must(ecp_shape_cylinder(shapes + HANDLE, 0.012, 0.15)); /* radius, half of the length */
    must(ecp_shape_box(shapes + HEAD, half));
    for (int i = 0; i < PARTS; i++) {
        ecp_shape_mass(shapes + i, density[i], &mass);
        ecp_mass_add(&total, &mass, place[i], turn[i]);
    }
    printf("hammer: mass_kg=%.6f centre_x_m=%.6f\n", total.mass, total.centre[0]);

    desc.mass = total.mass;
    for (int i = 0; i < 9; i++) desc.inertia[i] = total.inertia[i];
    desc.position[2] = height;
    must(ecp_body_add(world, &desc, &body));
    for (int i = 0; i < PARTS; i++) {
        ecp_real position[3];
        for (int k = 0; k < 3; k++) position[k] = place[i][k] - total.centre[k];
        must(ecp_body_add_shape(world, body, shapes + i, position, turn[i], NULL, NULL));
    }
    return body;
}

int main(void)
{
    const ecp_real up[3] = {0, 0, 1}, h = 0.005;
    const int steps = 400;
    ecp_world_desc desc = ecp_world_desc_default();
    ecp_body_desc ground = ecp_body_desc_default();
    ecp_world *world;
    ecp_shape shape;
    ecp_real v[3], w[3], load = 0, weight;
    size_t bytes = ecp_world_memsize(&desc);
    void *memory = malloc(bytes);
    must(ecp_world_init(&world, &desc, memory, bytes));
    ground.kind = ECP_STATIC;
    must(ecp_body_add(world, &ground, NULL));
    must(ecp_shape_half_space(&shape, up, 0));
    must(ecp_body_add_shape(world, 0, &shape, NULL, NULL, NULL, NULL)); /* shape 0: the ground */
    int hammer = add_hammer(world, 0.3);                                /* shapes 1 and 2 */

    for (int k = 0; k < steps; k++) must(ecp_step(world, h, NULL, NULL));

    must(ecp_body_get_state(world, hammer, NULL, NULL, v, w));
    for (int i = 0; i < ecp_contact_count(world); i++) {
        ecp_contact c;
        must(ecp_contact_get(world, i, &c));
        if (!(c.p_n > 0)) continue;
        /* the ground is a half-space, so it is B, and the hammer's part A */
        printf("hammer: rests on the %s at height %.1e m, with %.6f N\n", part_names[c.shape_a - 1],
               c.gap, c.p_n / h);
        load += c.p_n / h;
    }
    weight = 9.8 * (0.15 * 2 * 3.14159265358979 * 0.012 * 0.012 * 700 + 0.03 * 0.1 * 0.03 * 7800);
    printf("hammer: load_N=%.6f weight_N=%.6f\n", load, weight);
    free(memory);
    return 0;
}
