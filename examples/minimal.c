/* A box dropped on a plane: the program of the manual.

       cc -O2 -I. examples/minimal.c -o minimal -lm && ./minimal */

#define ECPSIM_IMPLEMENTATION
#include "ecpsim.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(void)
{
    const ecp_real up[3] = {0, 0, 1}, half[3] = {0.2, 0.1, 0.05}; /* m */
    ecp_world_desc desc = ecp_world_desc_default();
    ecp_body_desc ground = ecp_body_desc_default(), box = ecp_body_desc_default();
    ecp_world *world;
    ecp_shape plane, brick;
    ecp_mass mass;
    ecp_real x[3];
    ecp_status status = ECP_OK;
    size_t bytes = ecp_world_memsize(&desc);
    void *mem = malloc(bytes);

    if (ecp_world_init(&world, &desc, mem, bytes) != ECP_OK) return 1;
    ecp_shape_half_space(&plane, up, 0); /* z <= 0 */
    ground.kind = ECP_STATIC;
    ecp_body_add(world, &ground, NULL); /* body 0 */
    ecp_body_add_shape(world, 0, &plane, NULL, NULL, NULL, NULL);

    ecp_shape_box(&brick, half);
    ecp_shape_mass(&brick, 500, &mass); /* kg/m^3 */
    box.mass = mass.mass;
    memcpy(box.inertia, mass.inertia, sizeof box.inertia);
    box.position[2] = 0.5;
    box.velocity[0] = 1;
    ecp_body_add(world, &box, NULL); /* body 1 */
    ecp_body_add_shape(world, 1, &brick, NULL, NULL, NULL, NULL);

    for (int k = 0; k < 100 && status == ECP_OK; k++) status = ecp_step(world, 0.01, NULL, NULL);
    ecp_body_get_state(world, 1, x, NULL, NULL, NULL);
    printf("minimal: %s, the box rests at x = %.6f, y = %.6f, z = %.6f\n",
           ecp_status_string(status), x[0], x[1], x[2]);
    free(mem);
    return status == ECP_OK ? 0 : 1;
}
