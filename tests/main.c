/* All tests in one program: tests/main.c [name] runs those whose name contains `name`. */
#include "test.h"

#include "test_linear.c"
#include "test_shapes.c"
#include "test_world.c"
#include "test_equations.c"
#include "test_newton.c"
#include "test_step.c"
#include "test_contacts.c"
#include "test_truths.c"

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
    run(filter, "newton", test_newton);
    run(filter, "step", test_step);
    run(filter, "contacts", test_contacts);
    run(filter, "truths", test_truths);
    printf("%d passed, %d failed\n", test_passed, test_failed);
    return test_failed > 0;
}
