/* Example 1 of the paper: the three-legged table slides to rest without turning, and every step is
   compared with the closed form of equation:impulse_t to _n. Writes table_translate.csv.

       cc -O2 -I. examples/table_translate.c -o table_translate -lm && ./table_translate

   With -DECPSIM_FLOAT the library works in single precision; what it is compared with stays double. */

#define ECPSIM_IMPLEMENTATION
#include "ecpsim.h"
#include "table.h"
#include <time.h>

#ifdef ECPSIM_FLOAT
#define NAME "example1_float"
#define CSV "table_translate_float.csv"
#else
#define NAME "example1"
#define CSV "table_translate.csv"
#endif

enum { TABLE = 1, STEPS = 500 };
static const double h = 0.01, g = 9.8, v0[3] = {4, 3, 0}, w0[3] = {0, 0, 0};

/* The exact solution of the time-stepping scheme after k steps. Each step takes mu g h from the
   speed, and the one that could take more takes what is left. */
static void exact_step(int k, double x[3], double impulse[3])
{
    double speed = sqrt(v0[0] * v0[0] + v0[1] * v0[1]), loss = TABLE_MU * g * h;
    double slides = floor(speed / loss), n = fmin(k, slides);
    double way = h * (n * speed - loss * n * (n + 1) / 2);
    double lost = k <= slides ? loss : k <= slides + 1 ? speed - slides * loss : 0;
    for (int i = 0; i < 2; i++) {
        x[i] = way * v0[i] / speed;
        impulse[i] = -TABLE_MASS * lost * v0[i] / speed;
    }
    x[2] = TABLE_HEIGHT;
    impulse[2] = TABLE_MASS * g * h;
}

/* The sum of the contact impulses on the table, in world axes. */
static void sum_impulse(const ecp_world *world, double sum[3])
{
    ecp_contact c;
    sum[0] = sum[1] = sum[2] = 0;
    for (int i = 0; i < ecp_contact_count(world); i++) {
        must(ecp_contact_get(world, i, &c));
        for (int k = 0; k < 3; k++) {
            sum[k] += (double)c.p_n * (double)c.normal[k] +
                      (double)c.p_t * (double)c.direction_t[k] +
                      (double)c.p_o * (double)c.direction_o[k];
        }
    }
}

/* Time of one step: the step loop alone, always from the same start, in the fastest of ten batches of
   runs, which is the one least disturbed by others. A copy of the state restores a world. */
static double microseconds_per_step(ecp_world *world, const void *start)
{
    enum { BATCHES = 10, RUNS = 5 };
    double best = 1e300;
    for (int batch = 0; batch < BATCHES; batch++) {
        clock_t begin = clock();
        for (int run = 0; run < RUNS; run++) {
            memcpy(world, start, ecp_world_state_size(world));
            for (int k = 0; k < STEPS; k++) must(ecp_step(world, (ecp_real)h, NULL, NULL));
        }
        best = fmin(best, 1e6 * (double)(clock() - begin) / CLOCKS_PER_SEC / (RUNS * STEPS));
    }
    return best;
}

int main(void)
{
    scene s;
    double position_error = 0, impulse_error = 0;
    int iterations = 0;
    scene_open(&s);
    table_add(s.world, 3, 1, v0, w0);
    void *start = malloc(ecp_world_state_size(s.world));
    FILE *csv = fopen(CSV, "w");
    if (!start || !csv) return 1;
    memcpy(start, s.world, ecp_world_state_size(s.world));
    fprintf(csv, "t,x,y,z,px,py,pz,exact_x,exact_y,exact_z,exact_px,exact_py,exact_pz,"
                 "iterations,separation,printed\n");

    for (int k = 1; k <= STEPS; k++) {
        ecp_real position[3];
        double x[3], p[3], exact_x[3], exact_p[3], distance = 0;
        scene_step(&s, h, NULL);
        must(ecp_body_get_state(s.world, TABLE, position, NULL, NULL, NULL));
        sum_impulse(s.world, p);
        exact_step(k, exact_x, exact_p);
        for (int i = 0; i < 3; i++) {
            x[i] = (double)position[i];
            distance += (x[i] - exact_x[i]) * (x[i] - exact_x[i]);
            impulse_error = fmax(impulse_error, fabs(p[i] - exact_p[i]));
        }
        position_error = fmax(position_error, sqrt(distance));
        iterations += s.report.iterations;
        fprintf(csv, "%.2f,%.12f,%.12f,%.12f,%.9e,%.9e,%.9e,", k * h, x[0], x[1], x[2], p[0], p[1],
                p[2]);
        fprintf(csv, "%.12f,%.12f,%.12f,%.9e,%.9e,%.9e,", exact_x[0], exact_x[1], exact_x[2],
                exact_p[0], exact_p[1], exact_p[2]);
        fprintf(csv, "%d,%.3e,%.3e\n", s.report.iterations, s.separation, s.printed);
    }
    printf(NAME ": steps=%d max_position_error_m=%.3e max_impulse_error_Ns=%.3e "
                "max_penetration_m=%.3e newton_per_step=%.3e us_per_step=%.3e\n",
           STEPS, position_error, impulse_error, scene_penetration(&s), (double)iterations / STEPS,
           microseconds_per_step(s.world, start));
    fclose(csv);
    free(start);
    scene_close(&s);
    return 0;
}
