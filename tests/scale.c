/* The scaling run: scale [scene] [most]

   Times a step, and fits time ~ size^exponent by least squares over all sizes of a scene: patches
   (1 to 64 under one body), stack (1 to 200 boxes), grid (1 to 1000 separate boxes), pile (10 to
   500 mixed bodies). `most` leaves out larger sizes. Every scene is timed twice, because a world at
   rest costs little more than the look at it:

     rest       as it stands
     disturbed  every body gets a small random impulse before each step, so that Newton iterates;
                the grid slides instead, and the pile, which never rests quite, is timed as it
                settles

   The exponent is that of the disturbed scene; the grid's is the worse of both. Times are medians
   over blocks of steps, of processor time; of a pile that settles each step is another problem, so
   up to 160 bodies the median is over the blocks of five piles.

   And sleep: what 200 boxes at rest cost that stand alone, and that stand in stacks of ten: awake,
   asleep while another box is pushed, and asleep as all is. */
#define ECPSIM_IMPLEMENTATION
#include "../ecpsim.h"

#include "scene.h"

#include <time.h>

#define BLOCKS 7
#define PILES 5
#define SIZES 12

typedef struct curve {
    double size[SIZES], time[SIZES];
    int count;
} curve;

static const double step_h = 0.01;

/* ---- scenes of a size n; body 0 is the ground */

static void stand(scene *s, const solid *b, double x, double y, double z, const double *v)
{
    double at[3];
    at[0] = x;
    at[1] = y;
    at[2] = z;
    body_add(s, b, 1, at, NULL, v, NULL, NULL);
}

/* n cylinders in a ring carry a board that is not a part of the patches */
static void open_patches(scene *s, int n)
{
    solid b;
    ecp_shape foot;
    int i;
    memset(&b, 0, sizeof b);
    must(ecp_shape_cylinder(&foot, (ecp_real)(1.0 / (n + 2)), (ecp_real)0.1));
    for (i = 0; i < n; i++) {
        double angle = 2 * scene_pi * i / n;
        solid_add(&b, &foot, cos(angle), sin(angle), 0, NULL);
    }
    solid_close(&b);
    scene_open(s, 2, n + 1, n, 3, 9.8);
    ground(s, 0, 0, 1, NULL);
    stand(s, &b, 0, 0, 0.1, NULL);
}

static void open_stack(scene *s, int n)
{
    solid b;
    int i;
    solid_box(&b, 0.1, 0.1, 0.05);
    scene_open(s, n + 1, n + 1, 3 * n, 12, 9.8);
    ground(s, 0, 0, 1, NULL);
    for (i = 0; i < n; i++) stand(s, &b, 0, 0, 0.1 * i + 0.05, NULL);
}

static void open_squares(scene *s, int n, const double *v)
{
    int across = (int)ceil(sqrt(n)), i;
    solid b;
    solid_box(&b, 0.1, 0.1, 0.1);
    scene_open(s, n + 1, n + 1, 2 * n, 12, 9.8);
    ground(s, 0, 0, 1, NULL);
    for (i = 0; i < n; i++) stand(s, &b, 0.5 * (i % across), 0.5 * (i / across), 0.1, v);
}

static void open_grid(scene *s, int n) { open_squares(s, n, NULL); }

static void open_sliding(scene *s, int n)
{
    const double v[3] = {100, 50, 0}; /* none stops while it is timed */
    open_squares(s, n, v);
}

/* n boxes in stacks of so many, and one that stands aside */
static void open_stacks_of(scene *s, int n, int high)
{
    const int across = (int)ceil(sqrt(n / high));
    solid b;
    int i;
    solid_box(&b, 0.1, 0.1, 0.05);
    scene_open(s, n + 2, n + 2, 3 * n + 4, 12, 9.8);
    ground(s, 0, 0, 1, NULL);
    for (i = 0; i < n; i++) {
        int stack = i / high;
        stand(s, &b, 0.5 * (stack % across), 0.5 * (stack / across), 0.1 * (i % high) + 0.05, NULL);
    }
    stand(s, &b, -5, -5, 0.05, NULL);
}

static void open_singles(scene *s, int n) { open_stacks_of(s, n, 1); }
static void open_stacks(scene *s, int n) { open_stacks_of(s, n, 10); }

/* layers of boxes, balls, capsules and cylinders, dropped between four walls half as wide as the
   layers are high */
static void open_pile(scene *s, int n)
{
    int across = (int)ceil(cbrt(0.5 * n)), i;
    double pitch = 0.21, wide = pitch * across, far[3];
    solid kinds[4];
    solid_box(kinds, 0.1, 0.08, 0.06);
    solid_round(kinds + 1, ECP_SPHERE, 0.09, 0, 0);
    solid_round(kinds + 2, ECP_CAPSULE, 0.06, 0, 0.05);
    solid_round(kinds + 3, ECP_CYLINDER, 0.08, 0, 0.07);
    scene_open(s, n + 5, n + 5, 12 * n, 12, 9.8);
    far[0] = far[1] = far[2] = wide;
    ground(s, 0, 0, 1, NULL);
    ground(s, 1, 0, 0, NULL);
    ground(s, 0, 1, 0, NULL);
    ground(s, -1, 0, 0, far);
    ground(s, 0, -1, 0, far);
    for (i = 0; i < n; i++) {
        int layer = i / (across * across), row = i / across % across;
        double x = pitch * (i % across + 0.5) + uniform(s, -0.004, 0.004);
        double y = pitch * (row + 0.5) + uniform(s, -0.004, 0.004);
        stand(s, kinds + pick(s, 4), x, y, 0.13 + 0.24 * layer, NULL);
    }
}

/* ---- timing */

/* left alone, or every body disturbed before each step, or the last one; left alone or the last one
   disturbed where bodies may sleep */
typedef enum manner { REST, DISTURBED, SLEEP, SLEEP_BESIDE } manner;

/* a hundredth of the impulse of gravity, in any direction, on the bodies from `first` on */
static void disturb(scene *s, int first)
{
    int i;
    for (i = first; i < ecp_world_body_count(s->world); i++) {
        double v[3];
        ecp_real p[3];
        random_vector(s, 0.01 * 9.8 * step_h, v);
        to_real(v, 3, p);
        must(ecp_body_apply_impulse(s->world, i, p, NULL));
    }
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Microseconds of a step: of BLOCKS blocks of steps that last about 10 ms each. What comes between the
   steps is a disturbance at most. Adds the mean iterations of the blocks to *newton, and the steps that
   were not solved to *unsolved. */
static void time_steps(scene *s, manner how, int settle, int most_steps, ecp_report *r,
                       double *block, double *newton, int *unsolved)
{
    int steps = 1, i, k, first = how == DISTURBED ? 1 : ecp_world_body_count(s->world) - 1;
    ecp_options o = ecp_options_default();
    o.sleep = how == SLEEP || how == SLEEP_BESIDE;
    for (k = 0; k < settle; k++) ecp_step(s->world, (ecp_real)step_h, &o, r);
    for (i = 0; i < BLOCKS; i++) {
        clock_t begin = clock();
        double iterations = 0;
        for (k = 0; k < steps; k++) {
            if (how == DISTURBED || how == SLEEP_BESIDE) disturb(s, first);
            *unsolved += ecp_step(s->world, (ecp_real)step_h, &o, r) != ECP_OK;
            iterations += (double)r->iterations / steps;
        }
        block[i] = 1e6 * (double)(clock() - begin) / CLOCKS_PER_SEC / steps;
        if (i == 0 && block[0] * steps < 1e4 && steps < most_steps) {
            steps *= 4;
            if (steps > most_steps) steps = most_steps;
            i = -1;
            continue;
        }
        *newton += iterations / BLOCKS;
    }
}

/* one line: so many scenes of one size */
static void measure(const char *name, const char *how, void (*open)(scene *, int), int n,
                    int scenes, manner moved, int settle, int most_steps, curve *c)
{
    static scene s;
    ecp_report r;
    double block[PILES * BLOCKS], us, newton = 0;
    int unsolved = 0, i;
    for (i = 0; i < scenes; i++) {
        memset(&s, 0, sizeof s);
        s.seed = scene_seed(name, n) + (unsigned)i;
        open(&s, n);
        time_steps(&s, moved, settle, most_steps, &r, block + BLOCKS * i, &newton, &unsolved);
        scene_close(&s);
    }
    qsort(block, (size_t)(BLOCKS * scenes), sizeof block[0], by_size);
    us = block[BLOCKS * scenes / 2];
    newton /= scenes;
    printf("%-8s %-9s %5d %11.2f us  unknowns %6d  patches %5d  islands %5d  newton %6.2f", name,
           how, n, us, r.unknowns, r.patches_kept, r.islands, newton);
    if (r.asleep) printf("  asleep %d", r.asleep);
    printf("%s\n", unsolved ? "  NOT SOLVED" : "");
    fflush(stdout);
    if (us > 0) {
        c->size[c->count] = n;
        c->time[c->count++] = us;
    }
}

/* the slope of log(time) over log(size) */
static double exponent(const curve *c)
{
    double n = c->count, sx = 0, sy = 0, sxx = 0, sxy = 0;
    int i;
    for (i = 0; i < c->count; i++) {
        double x = log(c->size[i]), y = log(c->time[i]);
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/* a figure of the last line; a run with a filter has not measured all of them */
static void figure(const char *name, double value)
{
    if (isfinite(value)) {
        printf(" %s=%.3f", name, value);
    } else {
        printf(" %s=-", name);
    }
}

/* the time at this size, NAN if it was not measured */
static double time_of(const curve *c, double size)
{
    int i;
    for (i = 0; i < c->count; i++) {
        if (c->size[i] >= size && c->size[i] <= size) return c->time[i];
    }
    return (double)NAN;
}

int main(int argc, char **argv)
{
    static const int patches[] = {1, 2, 4, 8, 16, 32, 64, 0};
    static const int stack[] = {1, 2, 5, 10, 20, 50, 100, 200, 0};
    static const int grid[] = {1, 2, 5, 10, 30, 100, 300, 1000, 0};
    static const int pile[] = {10, 20, 40, 80, 160, 320, 500, 0};
    const char *filter = argc > 1 ? argv[1] : "";
    int most = argc > 2 ? atoi(argv[2]) : 1000, i;
    curve rest[3], moved[4], sleep[1];
    double worse;
    memset(rest, 0, sizeof rest);
    memset(moved, 0, sizeof moved);
    memset(sleep, 0, sizeof sleep);
    for (i = 0; strstr("patches", filter) && patches[i] && patches[i] <= most; i++) {
        measure("patches", "rest", open_patches, patches[i], 1, REST, 10, 10000, rest);
        measure("patches", "disturbed", open_patches, patches[i], 1, DISTURBED, 10, 1000, moved);
    }
    for (i = 0; strstr("stack", filter) && stack[i] && stack[i] <= most; i++) {
        measure("stack", "rest", open_stack, stack[i], 1, REST, 50, 10000, rest + 1);
        measure("stack", "disturbed", open_stack, stack[i], 1, DISTURBED, 0, 100, moved + 1);
    }
    for (i = 0; strstr("grid", filter) && grid[i] && grid[i] <= most; i++) {
        measure("grid", "rest", open_grid, grid[i], 1, REST, 10, 10000, rest + 2);
        measure("grid", "sliding", open_sliding, grid[i], 1, REST, 10, 100, moved + 2);
    }
    for (i = 0; strstr("pile", filter) && pile[i] && pile[i] <= most; i++) {
        measure("pile", "settling", open_pile, pile[i], pile[i] <= 160 ? PILES : 1, REST, 60, 5,
                moved + 3);
    }
    for (i = 0; strstr("sleep", filter) && most >= 200 && i < 2; i++) {
        static const char *names[2] = {"alone", "stacks"};
        void (*open)(scene *, int) = i ? open_stacks : open_singles;
        measure(names[i], "awake", open, 200, 1, REST, 100, 1000, sleep);
        measure(names[i], "beside", open, 200, 1, SLEEP_BESIDE, 100, 1000, sleep);
        measure(names[i], "asleep", open, 200, 1, SLEEP, 100, 10000, sleep);
    }
    worse = fmax(exponent(rest + 2), exponent(moved + 2));
    printf("scale:");
    figure("exponent_patches", exponent(moved));
    figure("exponent_stack", exponent(moved + 1));
    figure("exponent_grid", worse);
    figure("exponent_pile", exponent(moved + 3));
    figure("us_cube_at_rest", time_of(rest + 2, 1));
    figure("us_stack10_settled", time_of(rest + 1, 10));
    puts("");
    return 0;
}
