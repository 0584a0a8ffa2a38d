/* All tests in one program: tests/main.c [name] runs those whose name contains `name`. */
#include "test.h"

#include "test_linear.c"
#include "test_shapes.c"
#include "test_world.c"
#include "test_fallbacks.c"
#include "test_equations.c"
#include "test_elimination.c"
#include "test_newton.c"
#include "test_broad.c"
#include "test_step.c"
#include "test_contacts.c"
#include "test_sleep.c"
#include "test_advance.c"
#include "test_truths.c"

/* Example 2 of the paper, 200 steps with a landing, fallbacks and rest, as one number: tests/run.sh
   compares it between the builds. FNV-1a over the bytes of the states. */
static unsigned long state_bits(void)
{
    ecp_world *world = test_world(NULL);
    ecp_material m = ecp_material_default();
    ecp_body_desc b = ecp_body_desc_default();
    ecp_real leg[3][3] = {
        {ECP_R(-0.26), ECP_R(-0.15), 0}, {ECP_R(0.26), ECP_R(-0.15), 0}, {0, ECP_R(0.3), 0}};
    ecp_real hit[3] = {-5, 0, 0}, state[13];
    ecp_shape shape;
    unsigned long hash = 2166136261ul;
    size_t i;
    int k, table;
    m.mu = ECP_R(0.12);
    m.e_r = 1;
    test_ground(world, 0, 0, 1, &m);
    b.mass = 5;
    b.inertia[0] = b.inertia[4] = ECP_R(0.3327);
    b.inertia[8] = ECP_R(0.4458);
    b.position[2] = ECP_R(0.3);
    b.velocity[1] = 1;
    ecp_body_add(world, &b, &table);
    ecp_shape_cylinder(&shape, ECP_R(0.1), ECP_R(0.2));
    for (k = 0; k < 3; k++) {
        leg[k][2] = ECP_R(-0.1);
        ecp_body_add_shape(world, table, &shape, leg[k], NULL, &m, NULL);
    }
    for (k = 0; k < 200; k++) {
        if (k == 20) ecp_body_apply_angular_impulse(world, table, hit);
        CHECK(ecp_step(world, ECP_R(0.01), NULL, NULL) == ECP_OK);
        ecp_body_get_state(world, table, state, state + 3, state + 7, state + 10);
        for (i = 0; i < sizeof state; i++) {
            hash = ((hash ^ ((const unsigned char *)state)[i]) * 16777619ul) & 0xfffffffful;
        }
    }
    free(world);
    return hash;
}

static void run(const char *filter, const char *name, void (*test)(void))
{
    int failed = test_failed;
    if (filter && !strstr(name, filter)) return;
    test();
    printf("%-12s %s\n", name, test_failed > failed ? "FAILED" : "ok");
}

int main(int argc, char **argv)
{
    const char *filter = argc > 1 ? argv[1] : NULL;
    run(filter, "linear", test_linear);
    run(filter, "shapes", test_shapes);
    run(filter, "world", test_world_section);
    run(filter, "equations", test_equations);
    run(filter, "elimination", test_elimination);
    run(filter, "newton", test_newton);
    run(filter, "broad", test_broad);
    run(filter, "step", test_step);
    run(filter, "contacts", test_contacts);
    run(filter, "advance", test_advance_section);
    run(filter, "fallbacks", test_fallbacks);
    run(filter, "sleep", test_sleep);
    run(filter, "truths", test_truths);
    printf("bits of %s: %08lx\n", sizeof(ecp_real) == 4 ? "float" : "double", state_bits());
    printf("%d passed, %d failed\n", test_passed, test_failed);
    return test_failed > 0;
}
