/* What every test file uses: counted checks, scenes, and a certificate that does not trust the
   solver. The library is included with its implementation, so that tests reach private functions.
   All numbers are compared as long double or double; in a float build tolerances are in `by`. */
#ifndef TEST_H
#define TEST_H

#define ECPSIM_IMPLEMENTATION
#include "../ecpsim.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int test_passed, test_failed;

#define CHECK(condition) test_check((condition) != 0, #condition, __FILE__, __LINE__)
#define CHECK_NEAR(a, b, tolerance)                                                                \
    test_near((double)(a), (double)(b), (double)(tolerance), #a, #b, __FILE__, __LINE__)

static void test_check(int ok, const char *text, const char *file, int line)
{
    if (ok) {
        test_passed++;
        return;
    }
    test_failed++;
    printf("%s:%d: failed: %s\n", file, line, text);
}

static void test_near(double a, double b, double tolerance, const char *text_a, const char *text_b,
                      const char *file, int line)
{
    if (fabs(a - b) <= tolerance) {
        test_passed++;
        return;
    }
    test_failed++;
    printf("%s:%d: failed: %s = %.17g, %s = %.17g, apart by %.3e > %.3e\n", file, line, text_a, a,
           text_b, b, fabs(a - b), tolerance);
}

/* a tolerance: one for double, one for float */
static double test_by(double in_double, double in_float)
{
    return sizeof(ecp_real) == sizeof(double) ? in_double : in_float;
}

/* a fixed sequence of numbers in [-1, 1] */
static unsigned test_seed = 1;
static double test_random(void)
{
    test_seed = (test_seed * 1103515245u + 12345u) & 0x7fffffffu;
    return (double)test_seed / 1073741823.5 - 1;
}

/* A new world in fresh memory; free(world) when done. */
static ecp_world *test_world(const ecp_world_desc *desc)
{
    ecp_world_desc d = desc ? *desc : ecp_world_desc_default();
    size_t bytes = ecp_world_memsize(&d);
    ecp_world *world = NULL;
    CHECK(ecp_world_init(&world, &d, malloc(bytes), bytes) == ECP_OK);
    return world;
}

/* A static body with the half-space below the plane through `point` with this normal. */
static int test_ground(ecp_world *world, double nx, double ny, double nz, const ecp_material *m)
{
    ecp_body_desc b = ecp_body_desc_default();
    ecp_real normal[3];
    ecp_shape shape;
    int body = -1;
    normal[0] = (ecp_real)nx;
    normal[1] = (ecp_real)ny;
    normal[2] = (ecp_real)nz;
    b.kind = ECP_STATIC;
    CHECK(ecp_body_add(world, &b, &body) == ECP_OK);
    CHECK(ecp_shape_half_space(&shape, normal, 0) == ECP_OK);
    CHECK(ecp_body_add_shape(world, body, &shape, NULL, NULL, m, NULL) == ECP_OK);
    return body;
}

#include "certificate.h"

#endif
