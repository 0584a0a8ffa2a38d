/* The report: report [quick] [scene]

   Measures error against run time, of this library and of the engines that are here. It writes to
   build/report_out; when all scenes are done docs/report.md and docs/report are replaced by that and
   the plots are drawn, but not with a scene, or quick. An interrupted run leaves docs as they were.

       report count SCENE METHOD H   runs the steps once, for callgrind */

#include "report_table.h"

#include <dlfcn.h>
#include <float.h>
#include <math.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <time.h>
#include <unistd.h>

enum { WARM = 20, GIVE_UP = 20, LEGS = 7 };

extern const report_engine report_ours_double, report_ours_float, report_advance_double,
    report_advance_float, report_paced_double;

report_run the;

/* of each pace, up to a zero; quick: those marked 1 */
enum { SIZES = 12 };
static const struct {
    double h;
    int quick;
} sizes[][SIZES] = {{{1e-1, 1},
                     {5e-2, 0},
                     {2e-2, 0},
                     {1e-2, 1},
                     {5e-3, 0},
                     {2e-3, 0},
                     {1e-3, 1},
                     {5e-4, 0},
                     {2e-4, 0},
                     {1e-4, 0},
                     {1e-5, 0},
                     {0, 0}},
                    {{2e-1, 0},
                     {1e-1, 1},
                     {5e-2, 0},
                     {2e-2, 0},
                     {1e-2, 1},
                     {5e-3, 0},
                     {2e-3, 0},
                     {1e-3, 0},
                     {0, 0}},
                    {{1e-2, 0},
                     {1e-3, 1},
                     {1e-4, 0},
                     {1e-5, 0},
                     {1e-6, 1},
                     {1e-7, 0},
                     {1e-8, 0},
                     {1e-9, 1},
                     {1e-10, 0},
                     {0, 0}}};

/* ---- engines */

/* the peers that were built lie beside this program */
static void find_engines(void)
{
    static const char *const peers[] = {"ode", "bullet", "bullet64", "siconos", "mujoco"};
    static const char *const names[] = {"ODE", "Bullet", "Bullet double", "Siconos", "MuJoCo"};
    char path[4096];
    int i;
    the.engines[the.engine_count++] = &report_ours_double;
    the.engines[the.engine_count++] = &report_ours_float;
    the.engines[the.engine_count++] = &report_advance_double;
    the.engines[the.engine_count++] = &report_advance_float;
    the.engines[the.engine_count++] = &report_paced_double;
    the.ours_count = the.engine_count;
    for (i = 0; i < 5; i++) {
        const char *slash = strrchr(the.self, '/');
        const void *peer = NULL;
        void *library;
        snprintf(path, sizeof path, "%.*s/peer_%s.so", slash ? (int)(slash - the.self) : 1,
                 slash ? the.self : ".", peers[i]);
        library = access(path, R_OK) ? NULL : dlopen(path, RTLD_NOW | RTLD_LOCAL);
        if (library) {
            peer = dlsym(library, "report_peer");
        } else if (!access(path, R_OK)) {
            fprintf(stderr, "%s\n", dlerror());
        }
        if (peer) {
            the.engines[the.engine_count++] = (const report_engine *)peer;
        } else {
            the.absent[the.absent_count++] = names[i];
        }
    }
}

const char *method_name(const row *r) { return r->engine->methods[r->method].name; }

/* ---- time */

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* what two readings of the clock differ by when nothing lies between them */
static void measure_timer(void)
{
    double cost[101];
    int i;
    for (i = 0; i < 101; i++) {
        double begin = now();
        cost[i] = now() - begin;
    }
    qsort(cost, 101, sizeof cost[0], ascending);
    the.timer = cost[50];
}

/* this process on one core: the last one it may use */
static void pin(void)
{
    cpu_set_t may, one;
    int i, last = -1;
    if (sched_getaffinity(0, sizeof may, &may)) return;
    for (i = 0; i < CPU_SETSIZE; i++) last = CPU_ISSET(i, &may) ? i : last;
    if (last < 0) return;
    CPU_ZERO(&one);
    CPU_SET(last, &one);
    the.pinned = !sched_setaffinity(0, sizeof one, &one);
}

static void progress(const char *what, const report_scene *s, const row *r, int i, int n)
{
    if (!the.progress) return;
    if (!s) {
        fprintf(stderr, "\r\033[K");
    } else {
        fprintf(stderr, "\r\033[K%s: %s %d/%d %s h=%g", s->name, what, i + 1, n,
                r ? method_name(r) : "", r ? r->h : 0);
    }
    fflush(stderr);
}

/* ---- runs */

/* n steps from step k; returns how many were not solved. Callgrind counts what it calls. */
__attribute__((noinline)) int report_steps(const report_engine *e, void *world, int k, int n,
                                           double h);
int report_steps(const report_engine *e, void *world, int k, int n, double h)
{
    int i, unsolved = 0;
    for (i = 0; i < n; i++) unsolved += e->step(world, (k + i) * h) != 0;
    return unsolved;
}

int is_size(double a, double b) { return fabs(a - b) < 1e-9 * b; }

/* a row of steps of 0.01 s */
int at_a_hundredth(const row *r) { return r->engine->pace == REPORT_STEPS && is_size(r->h, 0.01); }

static int steps_to(double end, double h) { return (int)(end / h + 0.5); }

static void states(const row *r, void *world, int bodies, report_state *s)
{
    int i;
    for (i = 0; i < bodies; i++) r->engine->state(world, i, s + i);
}

static int finite_state(const report_state *s, int bodies)
{
    int i, k;
    for (i = 0; i < bodies; i++) {
        for (k = 0; k < 3; k++) {
            if (!isfinite(s[i].x[k]) || !isfinite(s[i].v[k])) return 0;
        }
    }
    return 1;
}

/* The run that is watched: errors, penetration, creep, and the states from which windows start. */
static void watch(const report_scene *scene, row *r)
{
    int bodies = scene->world.bodies, stride = r->h < 1e-3 ? (int)(1e-3 / r->h + 0.5) : 1;
    int who = r->engine->ours ? REPORT_OURS : REPORT_PEERS, k, i, window = 0;
    report_state s[REPORT_BODIES], late[REPORT_BODIES];
    report_watch w;
    double spent = 0, late_t = -1;
    void *world = r->engine->open(&scene->world, r->method, r->h);
    memset(&w, 0, sizeof w);
    w.scene = scene;
    w.h = r->h;
    w.steps = r->steps;
    r->starts = (report_state *)malloc(sizeof(report_state) * (size_t)(WINDOWS * bodies));
    if (!r->starts) exit(2);
    for (k = 0; k < r->steps && !r->failed;) {
        int n = stride < r->steps - k ? stride : r->steps - k;
        double begin = now();
        if (k >= (int)((double)window * r->steps / WINDOWS) && window < WINDOWS) {
            r->start[window] = k;
            states(r, world, bodies, r->starts + window++ * bodies);
        }
        r->unsolved += report_steps(r->engine, world, k, n, r->h);
        spent += now() - begin;
        k += n;
        states(r, world, bodies, s);
        w.at_end = k == r->steps;
        scene->watch(&w, k, k * r->h, s);
        r->penetration = fmax(r->penetration, report_penetration(&scene->world, s, who));
        if (late_t < 0 && k >= 0.95 * r->steps) {
            memcpy(late, s, sizeof s);
            late_t = k * r->h;
        }
        r->failed = !finite_state(s, bodies) || (r->engine->ours && r->unsolved > GIVE_UP) ||
                    spent > 3 * the.cap;
    }
    r->first_us = 1e6 * spent / k;
    r->continuous = r->failed ? INFINITY : w.continuous;
    r->discrete = r->failed ? INFINITY : w.discrete;
    r->energy = w.energy;
    r->momentum = w.momentum;
    for (i = 0; i < bodies; i++) {
        double d[3];
        int j;
        for (j = 0; j < 3; j++) d[j] = s[i].x[j] - late[i].x[j];
        if (late_t >= 0 && scene->rests && scene->end > late_t) {
            r->creep = fmax(r->creep,
                            sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / (scene->end - late_t));
        }
    }
    if (r->engine->unknowns) r->unknowns = r->engine->unknowns(world);
    r->engine->close(world);
}

/* until where a call of `advance` that begins at t may go */
static double next_stop(const report_scene *scene, double t, double longest)
{
    double end = scene->end, kick = scene->world.kick;
    if (scene->sample > 0) end = scene->sample * (floor(t / scene->sample + 1e-6) + 1);
    if (end > scene->end * (1 - 1e-9)) end = scene->end;
    if (kick > t * (1 + 1e-9) && kick < end) end = kick;
    return end > t + longest * 1.5 ? t + longest : end;
}

/* The whole of a scene by calls of `advance`, not longer than `longest`; `see` is called after each.
   Returns the seconds that these calls took, or less than 0 if one of them failed. */
static double advance_all(const report_scene *scene, const row *r, double longest,
                          report_cost *cost,
                          void (*see)(report_watch *w, const row *r, void *world), report_watch *w)
{
    void *world = r->engine->open(&scene->world, r->method, r->h);
    double spent = 0;
    int failed = 0;
    memset(cost, 0, sizeof *cost);
    w->t = 0;
    while (w->t < scene->end && !failed) {
        double to = next_stop(scene, w->t, longest), begin = now();
        failed = r->engine->advance(world, w->t, to - w->t, cost);
        spent += now() - begin - the.timer;
        w->t = to;
        w->at_end = to >= scene->end;
        if (see && !failed) see(w, r, world);
    }
    r->engine->close(world);
    return failed ? -1 : fmax(spent, 0);
}

static void see_error(report_watch *w, const row *r, void *world)
{
    report_state s[REPORT_BODIES];
    states(r, world, w->scene->world.bodies, s);
    w->scene->watch(w, 0, w->t, s);
}

static void see_penetration(report_watch *w, const row *r, void *world)
{
    report_state s[REPORT_BODIES];
    states(r, world, w->scene->world.bodies, s);
    w->penetration = fmax(w->penetration, report_penetration(&w->scene->world, s, REPORT_OURS));
}

/* Errors of a run as it is timed, and penetration after each fiftieth of another one. */
static void watch_advance(const report_scene *scene, row *r)
{
    report_watch w;
    report_cost ignored;
    double spent;
    memset(&w, 0, sizeof w);
    w.scene = scene;
    spent = advance_all(scene, r, scene->end, &r->cost, see_error, &w);
    r->first_us = 1e6 * spent;
    r->failed = spent < 0;
    if (!r->failed) advance_all(scene, r, scene->end / 50, &ignored, see_penetration, &w);
    r->continuous = r->failed ? INFINITY : w.continuous;
    r->discrete = INFINITY;
    r->penetration = w.penetration;
    r->energy = w.energy;
    r->momentum = w.momentum;
}

static double time_advance(const report_scene *scene, const row *r)
{
    double spent = 0, begin = now();
    report_cost cost;
    report_watch w;
    int n = 0;
    do {
        spent += advance_all(scene, r, scene->end, &cost, NULL, &w);
        n++;
    } while (spent < the.budget && now() - begin < 4 * the.budget);
    return 1e6 * spent / n;
}

/* One timed stretch: a new world, `warm` steps before the clock starts. */
static double time_stretch(const report_world *w, const row *r, int k, int warm, int n)
{
    void *world = r->engine->open(w, r->method, r->h);
    double begin, end;
    report_steps(r->engine, world, k, warm, r->h);
    begin = now();
    report_steps(r->engine, world, k + warm, n, r->h);
    end = now();
    r->engine->close(world);
    return end - begin - the.timer;
}

/* Microseconds of a step. A short run is repeated as a whole; of one that lasts much longer than the
   budget, stretches that begin at eight of its states are timed, each after some steps of warm-up. */
static double time_row(report_scene *scene, const row *r)
{
    double length = 1e-6 * r->first_us * r->steps, spent = 0, begin = now();
    int bodies = scene->world.bodies, i, j, n = 0;
    if (r->engine->advance) return time_advance(scene, r);
    if (length <= 2 * the.budget || r->steps < 4 * WINDOWS * WARM) {
        do {
            int warm = scene->moves ? 0 : WARM;
            spent += time_stretch(&scene->world, r, 0, warm, r->steps);
            n += r->steps;
        } while (spent < the.budget && now() - begin < 4 * the.budget);
        return 1e6 * spent / n;
    }
    for (i = 0; i < WINDOWS; i++) {
        report_state was[REPORT_BODIES];
        int some = (int)(the.budget / WINDOWS / (1e-6 * r->first_us)) + 1;
        int most = r->steps / WINDOWS - WARM;
        if (some > most) some = most;
        for (j = 0; j < bodies; j++) {
            was[j] = scene->world.body[j].start;
            scene->world.body[j].start = r->starts[i * bodies + j];
        }
        spent += time_stretch(&scene->world, r, r->start[i], WARM, some);
        n += some;
        for (j = 0; j < bodies; j++) scene->world.body[j].start = was[j];
    }
    return 1e6 * spent / n;
}

/* ---- instructions, by callgrind */

static int count_steps(const report_scene *scene, double h)
{
    int n = steps_to(scene->end, h);
    return n < 500 ? n : 500;
}

/* the child of count_instructions: `report count SCENE METHOD H` */
static int run_count(const report_scene *scene, const char *method, double h)
{
    int i, j;
    for (i = 0; i < 2; i++) {
        for (j = 0; j < the.engines[i]->count; j++) {
            void *world;
            if (strcmp(the.engines[i]->methods[j].name, method)) continue;
            world = the.engines[i]->open(&scene->world, j, h);
            if (!scene->moves) {
                int k;
                for (k = 0; k < WARM; k++) the.engines[i]->step(world, k * h);
            }
            report_steps(the.engines[i], world, 0, count_steps(scene, h), h);
            the.engines[i]->close(world);
            return 0;
        }
    }
    return 1;
}

static double count_instructions(const report_scene *scene, const row *r)
{
    char command[8192], line[512];
    double count = -1;
    FILE *pipe;
    snprintf(command, sizeof command,
             /* of a block that is set or copied by one `rep` callgrind would count every byte */
             "GLIBC_TUNABLES=glibc.cpu.x86_rep_stosb_threshold=1000000000:"
             "glibc.cpu.x86_rep_movsb_threshold=1000000000 "
             "valgrind --tool=callgrind --callgrind-out-file=/dev/null "
             "--toggle-collect=report_steps '%s' count '%s' '%s' %g 2>&1",
             the.self, scene->name, method_name(r), r->h);
    pipe = popen(command, "r");
    while (pipe && fgets(line, sizeof line, pipe)) {
        const char *at = strstr(line, "Collected : ");
        if (at) count = atof(at + 12) / count_steps(scene, r->h);
    }
    if (pipe) pclose(pipe);
    return count;
}

/* where the report goes, and the tables beside it */
static void make_directory(const char *name)
{
    char path[4096];
    mkdir(name, 0777);
    snprintf(path, sizeof path, "%s/report", name);
    mkdir(path, 0777);
}

/* ---- a scene */

static int takes(const report_scene *scene, const report_method *m)
{
    return (!m->motion || scene->moves) && (!m->patches || scene->patches);
}

double effective(const report_scene *scene, const row *r)
{
    return fmax(r->continuous, scene->floor);
}

double run_ms(const row *r) { return 1e-3 * r->median * r->steps; }

/* a is at least as good in both, and better in one */
static int dominates(const report_scene *scene, const row *a, const row *b)
{
    double error_a = effective(scene, a), error_b = effective(scene, b);
    if (a->failed) return 0;
    if (error_a > error_b || run_ms(a) > run_ms(b)) return 0;
    return error_a < error_b || run_ms(a) < run_ms(b);
}

static void find_fronts(const report_scene *scene, table *t)
{
    int i, j;
    for (i = 0; i < t->count; i++) {
        row *r = t->rows + i;
        r->front = !r->failed;
        r->beats = !r->engine->ours && r->front;
        for (j = 0; j < t->count; j++) {
            if (!dominates(scene, t->rows + j, r)) continue;
            r->front = 0;
            if (t->rows[j].engine->ours) r->beats = 0;
        }
        t->fronts += r->front;
        t->peer_fronts += r->beats;
    }
}

/* our own motion from the start with steps of h: the states after every 0.1 s */
static void own_motion(report_scene *scene, double h, report_state *out)
{
    const report_engine *e = &report_ours_double;
    void *world = e->open(&scene->world, 0, h);
    int i, n = steps_to(scene->end, 0.1), each = steps_to(0.1, h);
    for (i = 0; i < n; i++) {
        progress("truth", scene, NULL, i, n);
        if (report_steps(e, world, i * each, each, h)) {
            fprintf(stderr, "%s: the truth has unsolved steps\n", scene->name);
        }
        e->state(world, 0, out + i);
    }
    e->close(world);
}

/* how far apart the velocities of two truths are at the end */
static double truths_apart(const report_scene *scene, const report_state *a, const report_state *b)
{
    int k, last = steps_to(scene->end, 0.1) - 1;
    double worst = 0;
    for (k = 0; k < 3; k++) {
        double v = fabs(a[last].v[k] - b[last].v[k]);
        worst = fmax(worst, fmax(v, 0.25 * fabs(a[last].w[k] - b[last].w[k])));
    }
    return worst;
}

/* Where modes do not change (T4): Neville's extrapolation of four step sizes, and as its worth what it
   differs by from that of three. */
static void find_truth(report_scene *scene)
{
    enum { ORDER = 4 };
    static report_state table[ORDER][REPORT_TRUTHS];
    int i, j, k, m;
    scene->truth_h = (the.quick ? 1e-2 : 2e-3) / 8;
    for (i = 0; i < ORDER; i++) {
        own_motion(scene, scene->truth_h * (8 >> i), table[i]);
        for (j = i - 1; j >= 0; j--) {
            double weight = 1 / (pow(2, i - j) - 1);
            for (m = 0; m < REPORT_TRUTHS; m++) {
                report_state *a = &table[j][m], *b = &table[j + 1][m];
                for (k = 0; k < 3; k++) {
                    a->v[k] = b->v[k] + (b->v[k] - a->v[k]) * weight;
                    a->w[k] = b->w[k] + (b->w[k] - a->w[k]) * weight;
                }
            }
        }
    }
    memcpy(scene->truth, table[0], sizeof scene->truth);
    scene->floor = truths_apart(scene, table[0], table[1]);
    scene->truth_known = 1;
}

/* how long a run will take, from the last step size of this method; 0: not known */
static double expected(const table *t, const row *r)
{
    double us = 0;
    int i;
    if (r->engine->advance) return 0;
    for (i = 0; i < t->count; i++) {
        const row *o = t->rows + i;
        if (o->engine == r->engine && o->method == r->method) us = o->failed ? 0 : o->first_us;
    }
    return 1e-6 * us * r->steps;
}

/* one method at one size, watched; it stays in the table unless it takes too long or is refused */
static void watch_one(report_scene *scene, table *t, int engine, int method, double h, int most)
{
    row *r = t->rows + t->count;
    /* our two defaults are worth a wait */
    double cap = engine < 2 && method == 0 ? 4 * the.cap : the.cap;
    memset(r, 0, sizeof *r);
    r->engine = the.engines[engine];
    r->method = method;
    r->h = h;
    r->steps = r->engine->advance ? 1 : steps_to(scene->end, h);
    r->instructions = -1;
    if (expected(t, r) > cap) {
        t->left_out++;
        return;
    }
    progress("run", scene, r, t->count, most);
    if (r->engine->advance) {
        watch_advance(scene, r);
        if (r->cost.refused) return;
    } else {
        watch(scene, r);
    }
    t->count++;
}

/* every method at every size */
static void watch_all(report_scene *scene, table *t, int most)
{
    int i, e, j;
    for (i = 0; i < SIZES; i++) {
        for (e = 0; e < the.engine_count; e++) {
            report_pace pace = the.engines[e]->pace;
            if (!(sizes[pace][i].h > 0) || (the.quick && !sizes[pace][i].quick)) continue;
            for (j = 0; j < the.engines[e]->count; j++) {
                if (!takes(scene, the.engines[e]->methods + j)) continue;
                watch_one(scene, t, e, j, sizes[pace][i].h, most);
            }
        }
    }
}

static void find_medians(table *t)
{
    int i;
    for (i = 0; i < t->count; i++) {
        row *r = t->rows + i;
        qsort(r->us, RUNS, sizeof r->us[0], ascending);
        r->median = r->us[RUNS / 2];
        r->q1 = r->us[RUNS / 4];
        r->q3 = r->us[RUNS - 1 - RUNS / 4];
    }
}

/* every row once, and again: what disturbs the machine disturbs all methods */
static void time_all(report_scene *scene, table *t)
{
    int run, i;
    for (run = 0; run < RUNS; run++) {
        for (i = 0; i < t->count; i++) {
            progress("time", scene, t->rows + i, run * t->count + i, RUNS * t->count);
            if (!t->rows[i].failed) t->rows[i].us[run] = time_row(scene, t->rows + i);
        }
    }
    find_medians(t);
}

static void measure_scene(report_scene *scene, table *t)
{
    int most = 0, i;
    for (i = 0; i < the.engine_count; i++) most += the.engines[i]->count * SIZES;
    t->rows = (row *)calloc((size_t)most, sizeof *t->rows);
    if (!t->rows) exit(2);
    if (scene->own_truth) find_truth(scene);
    watch_all(scene, t, most);
    time_all(scene, t);
    for (i = 0; i < t->count; i++) {
        row *r = t->rows + i;
        /* ours at h = 0.01, as it comes */
        if (!the.quick && at_a_hundredth(r) && r->engine->ours && r->method == 0) {
            progress("count", scene, r, i, t->count);
            r->instructions = count_instructions(scene, r);
        }
        free(r->starts);
    }
    find_fronts(scene, t);
    progress(NULL, NULL, NULL, 0, 0);
}

/* ---- time over the number of patches: a body that slides on n legs */

static const int legs[LEGS] = {1, 2, 4, 8, 16, 32, 64};

static void measure_legs(table *t)
{
    static report_scene scenes[LEGS];
    int i, e, j, run, most = 0, last = the.quick ? 4 : LEGS;
    for (i = 0; i < the.engine_count; i++) most += the.engines[i]->count * LEGS;
    t->rows = (row *)calloc((size_t)most, sizeof *t->rows);
    if (!t->rows) exit(2);
    for (i = 0; i < last; i++) {
        report_legs(&scenes[i].world, legs[i]);
        scenes[i].name = "legs";
        scenes[i].end = 1;
        scenes[i].moves = scenes[i].patches = 1;
        for (e = 0; e < the.engine_count; e++) {
            for (j = 0; j < the.engines[e]->count; j++) {
                row *r = t->rows + t->count;
                void *world;
                memset(r, 0, sizeof *r);
                r->engine = the.engines[e];
                r->method = j;
                r->h = 0.01;
                r->legs = legs[i];
                r->steps = 100;
                if (r->engine->advance || expected(t, r) > 1e-2 * the.cap) continue;
                progress("run", scenes + i, r, i, last);
                world = the.engines[e]->open(&scenes[i].world, j, r->h);
                r->first_us = now();
                r->unsolved = report_steps(the.engines[e], world, 0, 100, r->h);
                r->first_us = 1e4 * (now() - r->first_us);
                if (the.engines[e]->unknowns) r->unknowns = the.engines[e]->unknowns(world);
                the.engines[e]->close(world);
                t->count++;
            }
        }
    }
    for (run = 0; run < RUNS; run++) {
        for (i = 0; i < t->count; i++) {
            row *r = t->rows + i;
            for (j = 0; legs[j] < r->legs; j++) continue;
            progress("time", scenes + j, r, run * t->count + i, RUNS * t->count);
            r->us[run] = time_row(scenes + j, r);
        }
    }
    find_medians(t);
    progress(NULL, NULL, NULL, 0, 0);
}

int main(int argc, char **argv)
{
    static table tables[32], patches;
    report_scene *scenes;
    int count, i;
    the.self = argv[0];
    scenes = report_scenes(&count);
    find_engines();
    if (argc == 5 && !strcmp(argv[1], "count")) {
        for (i = 0; i < count; i++) {
            if (strcmp(scenes[i].name, argv[2])) continue;
            return run_count(scenes + i, argv[3], atof(argv[4]));
        }
        return 1;
    }
    for (i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "quick")) {
            the.quick = 1;
        } else {
            the.only = argv[i];
        }
    }
    the.budget = the.quick ? 3e-4 : 4e-3;
    the.cap = the.quick ? 0.1 : 3;
    the.out = "build/report_out";
    the.progress = isatty(2);
    make_directory(the.out);
    pin();
    measure_timer();
    for (i = 0; i < count; i++) {
        if (the.only && strncmp(scenes[i].name, the.only, strlen(the.only))) continue;
        measure_scene(scenes + i, tables + i);
        write_scene(scenes + i, tables + i);
        print_scene(scenes + i, tables + i);
    }
    if (!the.only || !strcmp(the.only, "legs")) {
        measure_legs(&patches);
        write_legs(&patches);
    }
    write_report(scenes, tables, count, &patches);
    if (!the.quick && !the.only) {
        make_directory("docs");
        if (system("cp build/report_out/report.md docs/ && cp build/report_out/report/*.csv "
                   "docs/report/")) {
            return 1;
        }
    }
    if (!the.quick && !the.only &&
        system("command -v gnuplot >/dev/null && gnuplot tests/report.gp")) {
        fprintf(stderr, "no plots: gnuplot is not here, or failed\n");
    }
    print_last_line(stdout, scenes, tables, count);
    return 0;
}
