/* A block is released on its edge, rocks over, hits the ground with the other edge, and so on to rest:
   first with steps, then with ecp_advance, which takes no step size but a tolerance. A callback pushes
   it as it rises. Printed are the angle at 0.25 s, before the first impact, against the exact one
   of the pendulum that it is until then, and what both have cost; then the call that lets it come to rest.

       cc -O2 -I. examples/advance.c -o advance -lm && ./advance */

#define ECPSIM_IMPLEMENTATION
#include "ecpsim.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double b = 0.1, H = 0.3, g = 9.8; /* half width, half height, gravity */

static void must(ecp_status status)
{
    if (status == ECP_OK) return;
    fprintf(stderr, "ecpsim: %s\n", ecp_status_string(status));
    exit(1);
}

/* Body 1, a block of 1 kg, stands on its right edge, turned by half the angle at which it would fall. */
static ecp_world *rocking_block(void)
{
    const ecp_real up[3] = {0, 0, 1};
    ecp_real half[3];
    ecp_world_desc desc = ecp_world_desc_default();
    ecp_body_desc body = ecp_body_desc_default();
    ecp_material rough = ecp_material_default();
    double critical = atan2(b, H), angle = critical / 2, R = sqrt(b * b + H * H);
    ecp_world *world;
    ecp_shape shape;
    size_t bytes;

    desc.advance_order = 8; /* memory for ecp_advance */
    bytes = ecp_world_memsize(&desc);
    must(ecp_world_init(&world, &desc, malloc(bytes), bytes));
    rough.mu = 2;

    body.kind = ECP_STATIC;
    must(ecp_body_add(world, &body, NULL));
    must(ecp_shape_half_space(&shape, up, 0));
    must(ecp_body_add_shape(world, 0, &shape, NULL, NULL, &rough, NULL));

    body.kind = ECP_DYNAMIC;
    body.inertia[0] = body.inertia[4] = (ecp_real)((b * b + H * H) / 3);
    body.inertia[8] = (ecp_real)(2 * b * b / 3);
    body.position[0] = (ecp_real)(b - R * sin(critical - angle));
    body.position[2] = (ecp_real)(R * cos(critical - angle));
    body.rotation[0] = (ecp_real)cos(angle / 2);
    body.rotation[2] = (ecp_real)sin(angle / 2);
    must(ecp_body_add(world, &body, NULL));
    half[0] = half[1] = (ecp_real)b;
    half[2] = (ecp_real)H;
    must(ecp_shape_box(&shape, half));
    must(ecp_body_add_shape(world, 1, &shape, NULL, NULL, &rough, NULL));
    return world;
}

static double angle_of(const ecp_world *world)
{
    ecp_real q[4] = {1, 0, 0, 0};
    must(ecp_body_get_state(world, 1, NULL, q, NULL, NULL));
    return 2 * atan2((double)q[2], (double)q[0]);
}

/* theta'' = -p^2 sin(critical - theta), p^2 = 3 g / (4 R), by a fine Runge-Kutta */
static double exact_angle(double duration)
{
    double critical = atan2(b, H), p2 = 0.75 * g / sqrt(b * b + H * H);
    double x = critical / 2, v = 0, h = duration / 10000;
    for (int k = 0; k < 10000; k++) {
        double a1 = -p2 * sin(critical - x), a2 = -p2 * sin(critical - x - h / 2 * v);
        double a3 = -p2 * sin(critical - x - h / 2 * (v + h / 2 * a1));
        double a4 = -p2 * sin(critical - x - h * (v + h / 2 * a2));
        x += h * v + h * h / 6 * (a1 + a2 + a3);
        v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
    return x;
}

/* a push of 0.3 N to the right while the block leans to the left */
static void push(void *user, ecp_world *world, ecp_real time)
{
    const ecp_real force[3] = {(ecp_real)0.3, 0, 0};
    (void)user;
    (void)time;
    if (angle_of(world) < 0) must(ecp_body_apply_force(world, 1, force, NULL));
}

int main(void)
{
    const double duration = 0.25, exact = exact_angle(duration);
    ecp_advance_options options = ecp_advance_options_default();
    ecp_advance_report report;
    ecp_world *world;
    double error;

    for (int steps = 25; steps <= 2500; steps *= 10) {
        world = rocking_block();
        for (int k = 0; k < steps; k++)
            must(ecp_step(world, (ecp_real)(duration / steps), NULL, NULL));
        printf("advance: steps=%d angle_error=%.1e\n", steps, fabs(angle_of(world) - exact));
        free(world);
    }
    for (int digits = 3; digits <= 9; digits += 3) {
        world = rocking_block();
        options.tolerance = (ecp_real)pow(10, -digits);
        must(ecp_advance(world, (ecp_real)duration, &options, &report));
        error = fabs(angle_of(world) - exact);
        printf("advance: tolerance=1e-%d solves=%d highest_order=%d angle_error=%.1e\n", digits,
               report.solves, report.highest_order, error);
        if (digits < 9) free(world);
    }

    /* and on: impacts that come faster and faster, until it rests */
    options.tolerance = (ecp_real)1e-6;
    options.load = push;
    must(ecp_advance(world, 10, &options, &report));
    printf("advance: to rest: solves=%d events=%d first_order=%d forced=%d angle=%.1e\n",
           report.solves, report.events, report.first_order, report.forced, fabs(angle_of(world)));
    free(world);
    return 0;
}
