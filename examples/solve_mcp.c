/* The complementarity solver by itself, on the problem of Kojima and Shindo: find x >= 0 with
   F(x) >= 0 and x_i F_i(x) = 0. It has two solutions, one of them degenerate (x_3 = F_3 = 0), and
   Newton's method alone fails from some of these starts.

       cc -O2 -I. examples/solve_mcp.c -o solve_mcp -lm && ./solve_mcp */

#define ECPSIM_IMPLEMENTATION
#include "ecpsim.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void function(void *user, const ecp_real *x, ecp_real *F)
{
    ecp_real a = x[0], b = x[1], c = x[2], d = x[3];
    (void)user;
    F[0] = 3 * a * a + 2 * a * b + 2 * b * b + c + 3 * d - 6;
    F[1] = 2 * a * a + a + b * b + 10 * c + 2 * d - 2;
    F[2] = 3 * a * a + a * b + 2 * b * b + 2 * c + 9 * d - 9;
    F[3] = a * a + 3 * b * b + 2 * c + 3 * d - 3;
}

static void jacobian(void *user, const ecp_real *x, ecp_real *J)
{
    ecp_real a = x[0], b = x[1];
    const ecp_real rows[16] = {6 * a + 2 * b, 2 * a + 4 * b, 1,  3,  /* dF_1 */
                               4 * a + 1,     2 * b,         10, 2,  /* dF_2 */
                               6 * a + b,     a + 4 * b,     2,  9,  /* dF_3 */
                               2 * a,         6 * b,         2,  3}; /* dF_4 */
    (void)user;
    memcpy(J, rows, sizeof rows);
}

/* x as it is printed: no minus sign before a zero. */
static double shown(double x) { return x < 0 && x > -5e-10 ? 0 : x; }

int main(void)
{
    static const ecp_real starts[8][4] = {{0, 0, 0, 0}, {1, 1, 1, 1},     {100, 100, 100, 100},
                                          {1, 0, 1, 0}, {1, 0, 0, 0},     {0, 1, 1, 0},
                                          {0, 1, 0, 1}, {1.25, 0, 0, 0.5}};
    /* no equations, four complementarities */
    const ecp_mcp problem = {0, 4, function, jacobian, NULL};
    size_t bytes = ecp_mcp_memsize(problem.n, problem.m);
    void *mem = malloc(bytes);
    int failed = 0;
    if (!mem) return 1;
    for (int i = 0; i < 8; i++) {
        ecp_mcp_report report = {0, 0, 0, 0, 0};
        ecp_real x[4];
        memcpy(x, starts[i], sizeof x);
        ecp_status status = ecp_mcp_solve(&problem, NULL, x, mem, bytes, &report);
        failed += status != ECP_OK;
        printf("solve_mcp: start=(%g,%g,%g,%g) x=(%.9f,%.9f,%.9f,%.9f) iterations=%d fallbacks=%d "
               "residual=%.3e %s\n",
               starts[i][0], starts[i][1], starts[i][2], starts[i][3], shown(x[0]), shown(x[1]),
               shown(x[2]), shown(x[3]), report.iterations, report.fallbacks,
               report.natural_residual, ecp_status_string(status));
    }
    free(mem);
    return failed;
}
