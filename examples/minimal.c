/* A box falls on a plane and slides to rest: the program of the manual.

       cc -O2 -I. examples/minimal.c -o minimal -lm && ./minimal */

#define ECPSIM_IMPLEMENTATION
#include "ecpsim.h"
#include <stdio.h>
#include <stdlib.h>

int main(void)
{
    const ecp_real up[3] = {0, 0, 1}, half[3] = {0.2, 0.1, 0.05}; /* m */
    const ecp_real inertia[9] = {0.0042, 0, 0, 0, 0.0142, 0, 0, 0, 0.0167};
    ecp_world_desc desc = ecp_world_desc_default();
    ecp_body_desc body = ecp_body_desc_default();
    ecp_world *world;
    ecp_shape shape;
    ecp_real x[3] = {0};
    size_t bytes = ecp_world_memsize(&desc);
    if (ecp_world_init(&world, &desc, malloc(bytes), bytes) != ECP_OK) return 1;

    body.kind = ECP_STATIC; /* body 0: the ground, z <= 0 */
    ecp_body_add(world, &body, NULL);
    ecp_shape_half_space(&shape, up, 0);
    ecp_body_add_shape(world, 0, &shape, NULL, NULL, NULL, NULL);

    body.kind = ECP_DYNAMIC; /* body 1: a box of 1 kg, thrown */
    for (int i = 0; i < 9; i++) body.inertia[i] = inertia[i];
    body.position[2] = 0.5;
    body.velocity[0] = 1;
    ecp_body_add(world, &body, NULL);
    ecp_shape_box(&shape, half);
    ecp_body_add_shape(world, 1, &shape, NULL, NULL, NULL, NULL);

    for (int k = 0; k < 100; k++) {
        ecp_status status = ecp_step(world, 0.01, NULL, NULL);
        if (status != ECP_OK) return puts(ecp_status_string(status)), 1;
    }
    ecp_body_get_state(world, 1, x, NULL, NULL, NULL);
    printf("minimal: the box rests at (%.6f, %.6f, %.6f)\n", x[0], x[1], x[2]);
    free(world);
    return 0;
}
