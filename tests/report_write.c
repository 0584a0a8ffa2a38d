/* The report's files: CSV, Markdown, and what it prints. */

#include "report_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <time.h>
#include <unistd.h>

static FILE *open_out(const char *name)
{
    char path[4096];
    FILE *f;
    snprintf(path, sizeof path, "%s/%s", the.out, name);
    f = fopen(path, "w");
    if (f) return f;
    perror(path);
    exit(2);
}

/* ---- CSV */

/* a number, nothing where there is none */
static void put(FILE *f, int known, double value)
{
    if (known && isfinite(value)) {
        fprintf(f, ",%.4g", value);
    } else {
        fprintf(f, ",");
    }
}

/* the rows of a table in the order of the methods */
static const row *next_row(const table *t, const row *last)
{
    int i, e, j, found = last == NULL;
    for (e = 0; e < the.engine_count; e++) {
        for (j = 0; j < the.engines[e]->count; j++) {
            for (i = 0; i < t->count; i++) {
                const row *r = t->rows + i;
                if (r->engine != the.engines[e] || r->method != j) continue;
                if (found) return r;
                found = r == last;
            }
        }
    }
    return NULL;
}

void write_scene(const report_scene *scene, const table *t)
{
    char name[64];
    const row *r;
    FILE *f;
    snprintf(name, sizeof name, "report/%s.csv", scene->name);
    f = open_out(name);
    fprintf(f, "scene,method,h_s,steps,us_per_step,us_q1,us_q3,run_ms,error_continuous,"
               "error_discrete,penetration_m,creep_m_per_s,unsolved_steps,unknowns,"
               "instructions_per_step,macro_step_s,tolerance,energy_drift,momentum_drift,"
               "first_order,forced\n");
    for (r = next_row(t, NULL); r; r = next_row(t, r)) {
        int ok = !r->failed, whole = r->engine->advance != NULL;
        fprintf(f, "%s,%s", scene->name, method_name(r));
        put(f, !whole, r->h);
        fprintf(f, ",%d", whole ? r->cost.solves : r->steps);
        put(f, ok && !whole, r->median);
        put(f, ok && !whole, r->q1);
        put(f, ok && !whole, r->q3);
        put(f, ok, run_ms(r));
        put(f, ok, r->continuous);
        put(f, ok && scene->has_discrete, r->discrete);
        put(f, ok, r->penetration);
        put(f, ok && scene->rests && !whole, r->creep);
        fprintf(f, ",%d", r->unsolved);
        put(f, r->unknowns > 0, r->unknowns);
        put(f, r->instructions > 0, r->instructions);
        put(f, r->engine->pace == REPORT_MACRO_STEPS, r->h);
        put(f, r->engine->pace == REPORT_TOLERANCES, r->h);
        put(f, ok && scene->conserves, r->energy);
        put(f, ok && scene->conserves, r->momentum);
        put(f, ok && whole, r->cost.first_order);
        put(f, ok && whole, r->cost.forced);
        fprintf(f, "\n");
    }
    fclose(f);
}

void write_legs(const table *t)
{
    FILE *f = open_out("report/legs.csv");
    const row *r;
    fprintf(f, "scene,method,patches,unknowns,us_per_step,us_q1,us_q3,unsolved_steps\n");
    for (r = next_row(t, NULL); r; r = next_row(t, r)) {
        fprintf(f, "legs,%s,%d", method_name(r), r->legs);
        put(f, r->unknowns > 0, r->unknowns);
        put(f, 1, r->median);
        put(f, 1, r->q1);
        put(f, 1, r->q3);
        fprintf(f, ",%d\n", r->unsolved);
    }
    fclose(f);
}

/* ---- a scene's front */

/* where a method's rows that count begin and end, by run time */
typedef struct span {
    const row *fast, *good;
    int count;
} span;

static span find_span(const table *t, const report_engine *e, int method, int peers)
{
    span s = {NULL, NULL, 0};
    int i;
    for (i = 0; i < t->count; i++) {
        const row *r = t->rows + i;
        if (r->engine != e || r->method != method || !(peers ? r->beats : r->front)) continue;
        s.count++;
        if (!s.fast || run_ms(r) < run_ms(s.fast)) s.fast = r;
        if (!s.good || run_ms(r) > run_ms(s.good)) s.good = r;
    }
    return s;
}

static void put_point(FILE *f, const report_scene *scene, const row *r)
{
    static const char *const size[] = {"h = ", "macro steps of ", "tolerance "};
    fprintf(f, "%.3g ms %.2g %s (%s%g)", run_ms(r), r->continuous, scene->unit,
            size[r->engine->pace], r->h);
}

/* one line for each method that has a point of the front (peers: one that none of ours dominates) */
static void put_front(FILE *f, const char *bullet, const report_scene *scene, const table *t,
                      int peers)
{
    int e, j;
    for (e = 0; e < the.engine_count; e++) {
        for (j = 0; j < the.engines[e]->count; j++) {
            span s = find_span(t, the.engines[e], j, peers);
            if (!s.count) continue;
            fprintf(f, "%s%s: ", bullet, the.engines[e]->methods[j].name);
            put_point(f, scene, s.fast);
            if (s.count > 1) {
                fprintf(f, s.count > 2 ? " to " : " and ");
                put_point(f, scene, s.good);
            }
            fprintf(f, "\n");
        }
    }
}

void print_scene(const report_scene *scene, const table *t)
{
    printf("%s\n", scene->title);
    printf("  error: %s, against %s\n", scene->measure, scene->truth_is);
    printf("  not dominated by any method:\n");
    put_front(stdout, "    ", scene, t, 0);
    if (t->peer_fronts) {
        printf("  peers that no point of ours dominates:\n");
        put_front(stdout, "    ", scene, t, 1);
    } else {
        printf("  every point of every peer is dominated by one of ours\n");
    }
    fflush(stdout);
}

/* ---- figures that are compared */

/* ours as it comes, or the fastest peer, at h = 0.01 */
static const row *find_row(const table *t, int ours)
{
    const row *best = NULL;
    int i;
    for (i = 0; i < t->count; i++) {
        const row *r = t->rows + i;
        if (!at_a_hundredth(r) || r->failed) continue;
        if (ours ? r->engine != the.engines[0] || r->method : r->engine->ours) continue;
        if (!best || r->median < best->median) best = r;
    }
    return best;
}

/* ecp_advance at this tolerance */
static const row *find_advance(const table *t, double tolerance)
{
    int i;
    for (i = 0; i < t->count; i++) {
        const row *r = t->rows + i;
        if (r->engine->pace == REPORT_TOLERANCES && !r->failed && is_size(r->h, tolerance))
            return r;
    }
    return NULL;
}

/* the peer with the least error, and of these the fastest */
static const row *find_best_peer(const report_scene *scene, const table *t)
{
    const row *best = NULL;
    int i;
    for (i = 0; i < t->count; i++) {
        const row *r = t->rows + i;
        double e = effective(scene, r), least = best ? effective(scene, best) : 0;
        if (r->failed || r->engine->ours) continue;
        if (!best || e < least || (e <= least && run_ms(r) < run_ms(best))) best = r;
    }
    return best;
}

static double us_of(const report_scene *scenes, const table *tables, int count, const char *name,
                    int ours)
{
    int i;
    for (i = 0; i < count; i++) {
        const row *r = tables[i].count ? find_row(tables + i, ours) : NULL;
        if (r && !strcmp(scenes[i].name, name)) return r->median;
    }
    return (double)NAN;
}

/* some peer has less error than anything of ours */
static int peer_is_best(const report_scene *scene, const table *t)
{
    const row *peer = find_best_peer(scene, t);
    int i, ours = 0;
    for (i = 0; i < t->count; i++) {
        const row *r = t->rows + i;
        ours |=
            peer && r->engine->ours && !r->failed && effective(scene, r) <= effective(scene, peer);
    }
    return peer && !ours;
}

void print_last_line(FILE *f, const report_scene *scenes, const table *tables, int count)
{
    int i, e, measured = 0, methods = 0, lead = 0, better = 0;
    double example1 = us_of(scenes, tables, count, "t1", 1);
    for (i = 0; i < count; i++) {
        measured += tables[i].count > 0;
        lead += tables[i].peer_fronts > 0;
        better += peer_is_best(scenes + i, tables + i);
    }
    for (e = 0; e < the.engine_count; e++) methods += the.engines[e]->count;
    fprintf(f,
            "report: scenes=%d methods=%d scenes_where_a_peer_is_not_dominated=%d "
            "scenes_where_a_peer_has_less_error=%d "
            "us_example1=%.3g ratio_to_fastest_peer_example1=%.3g "
            "ratio_to_fastest_peer_cube=%.3g\n",
            measured, methods, lead, better, example1,
            example1 / us_of(scenes, tables, count, "t1", 0),
            us_of(scenes, tables, count, "cube", 1) / us_of(scenes, tables, count, "cube", 0));
}

/* ---- Markdown */

static void put_machine(FILE *f)
{
    char line[512], cpu[256] = "unknown", date[64];
    double load[3] = {0, 0, 0};
    struct utsname system;
    time_t now = time(NULL);
    FILE *info = fopen("/proc/cpuinfo", "r");
    while (info && fgets(line, sizeof line, info)) {
        const char *colon = strstr(line, ": ");
        if (strncmp(line, "model name", 10) || !colon) continue;
        snprintf(cpu, sizeof cpu, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
        break;
    }
    if (info) fclose(info);
    uname(&system);
    getloadavg(load, 3);
    strftime(date, sizeof date, "%Y-%m-%d", gmtime(&now));
    fprintf(f, "| | |\n|---|---|\n");
    fprintf(f, "| date | %s |\n", date);
    fprintf(f, "| machine | %s, %ld cores, %s %s %s |\n", cpu, sysconf(_SC_NPROCESSORS_ONLN),
            system.sysname, system.release, system.machine);
    fprintf(f, "| load while it ran | %.1f, %.1f, %.1f (1, 5, 15 minutes) |\n", load[0], load[1],
            load[2]);
    fprintf(f, "| compiler | %s %s |\n", COMPILER, __VERSION__);
    fprintf(f,
            "| flags | `%s`, for us and for the peers' drivers; the peers themselves as Debian "
            "built them%s |\n",
            FLAGS,
            the.engine_count - the.ours_count > 4 ? " (MuJoCo: as found in MUJOCO_DIR)" : "");
    fprintf(f,
            "| clock | processor time of the thread, %s; reading it takes %.2g us, which is "
            "subtracted |\n\n",
            the.pinned ? "pinned to one core" : "NOT pinned to one core", 1e6 * the.timer);
}

static void put_peers(FILE *f)
{
    int e, j;
    fprintf(f, "## Methods\n\n");
    for (e = 0; e < the.engine_count; e++) {
        const report_engine *engine = the.engines[e];
        fprintf(f, "**%s** (%s): %s.\n\n", engine->name, engine->version, engine->setup);
        fprintf(f, "| method | |\n|---|---|\n");
        for (j = 0; j < engine->count; j++) {
            fprintf(f, "| %s | %s |\n", engine->methods[j].name, engine->methods[j].settings);
        }
        fprintf(f, "\n");
    }
    for (e = 0; e < the.absent_count; e++) {
        fprintf(f, "%s was not here when this was written.\n\n", the.absent[e]);
    }
}

/* a cell of a table */
static void cell(FILE *f, int known, const char *format, double value)
{
    fprintf(f, " ");
    if (known) {
        fprintf(f, isfinite(value) ? format : "-", value);
    }
    fprintf(f, " |");
}

/* the rows of ecp_advance: all tolerances, and two macro steps */
static void put_advance(FILE *f, const report_scene *scene, const table *t)
{
    const char *drifts = scene->conserves ? "energy drift | momentum drift | " : "";
    const row *r;
    fprintf(f,
            "\nBy ecp_advance(), the whole run:\n\n"
            "| method | tolerance | macro step, s | ms | quartiles | base steps | error | "
            "%spenetration, m | at first order | forced |\n|---|---|---|---|---|---|---|%s---|---|"
            "---|\n",
            drifts, scene->conserves ? "---|---|" : "");
    for (r = next_row(t, NULL); r; r = next_row(t, r)) {
        int paced = r->engine->pace == REPORT_MACRO_STEPS;
        if (!r->engine->advance) continue;
        if (paced && !is_size(r->h, 0.1) && !is_size(r->h, 0.01)) continue;
        fprintf(f, "| %s |", method_name(r));
        cell(f, !paced, "%.0e", r->h);
        cell(f, paced, "%g", r->h);
        cell(f, !r->failed, "%.3g", run_ms(r));
        if (r->failed) {
            fprintf(f, " |");
        } else {
            fprintf(f, " %.3g, %.3g |", 1e-3 * r->q1, 1e-3 * r->q3);
        }
        cell(f, !r->failed, "%.0f", r->cost.solves);
        cell(f, 1, "%.2g", r->continuous);
        if (scene->conserves) cell(f, !r->failed, "%.1e", r->energy);
        if (scene->conserves) cell(f, !r->failed, "%.1e", r->momentum);
        cell(f, !r->failed, "%.1e", r->penetration);
        cell(f, !r->failed, "%.0f", r->cost.first_order);
        cell(f, !r->failed, "%.0f", r->cost.forced);
        fprintf(f, "\n");
    }
}

static void put_scene(FILE *f, const report_scene *scene, const table *t)
{
    const row *r;
    fprintf(f, "## %s\n\n", scene->title);
    fprintf(f, "Error: %s, against %s", scene->measure, scene->truth_is);
    if (scene->own_truth) {
        fprintf(f, " (extrapolated from four step sizes down to %g s), known to %.1g %s",
                scene->truth_h, scene->floor, scene->unit);
    }
    fprintf(f, ".%s%s\n", scene->remark ? " " : "", scene->remark ? scene->remark : "");
    fprintf(f, "\n![%s](report/%s.svg)\n\nNot dominated by any method:\n\n", scene->title,
            scene->name);
    put_front(f, "- ", scene, t, 0);
    fprintf(f, t->peer_fronts ? "\nPeers that no point of ours dominates:\n\n"
                              : "\nEvery point of every peer is dominated by one of ours.\n");
    if (t->peer_fronts) put_front(f, "- ", scene, t, 1);
    put_advance(f, scene, t);
    fprintf(f,
            "\nBy steps of h = 0.01 s:\n\n| method | us a step | quartiles | error | %s%s%s| "
            "penetration, m "
            "| %sunsolved | instructions |\n",
            scene->has_discrete ? "error of the step, " : "",
            scene->has_discrete ? (strcmp(scene->unit, "m") ? "m/s " : "m ") : "",
            scene->conserves ? "energy drift | momentum drift " : "",
            scene->rests ? "creep, m/s | " : "");
    fprintf(f, "|---|---|---|---|%s%s---|%s---|---|\n", scene->has_discrete ? "---|" : "",
            scene->conserves ? "---|---|" : "", scene->rests ? "---|" : "");
    for (r = next_row(t, NULL); r; r = next_row(t, r)) {
        if (!at_a_hundredth(r)) continue;
        fprintf(f, "| %s |", method_name(r));
        cell(f, !r->failed, "%.3g", r->median);
        if (r->failed) {
            fprintf(f, " |");
        } else {
            fprintf(f, " %.3g, %.3g |", r->q1, r->q3);
        }
        cell(f, 1, "%.2g", r->continuous);
        if (scene->has_discrete) cell(f, 1, "%.1e", r->discrete);
        if (scene->conserves) cell(f, 1, "%.1e", r->energy);
        if (scene->conserves) cell(f, 1, "%.1e", r->momentum);
        cell(f, 1, "%.1e", r->penetration);
        if (scene->rests) cell(f, 1, "%.1e", r->creep);
        cell(f, 1, "%.0f", r->unsolved);
        cell(f, r->instructions > 0, "%.0f", r->instructions);
        fprintf(f, "\n");
    }
    if (t->left_out) {
        fprintf(f, "\n%d runs were left out because they would take longer than %g s.\n",
                t->left_out, the.cap);
    }
    fprintf(f, "\n");
}

/* the peers with a point that none of ours dominates, and the end of a table's line */
static void put_undominated(FILE *f, const table *t)
{
    int e, j, listed = 0;
    for (e = 0; e < the.engine_count; e++) {
        int lead = 0;
        for (j = 0; j < t->count; j++) {
            const row *r = t->rows + j;
            lead += r->beats && r->engine == the.engines[e];
        }
        if (lead) fprintf(f, "%s%s", listed++ ? ", " : "", the.engines[e]->name);
    }
    fprintf(f, "%s |\n", listed ? "" : "none");
}

static void put_overview(FILE *f, const report_scene *scenes, const table *tables, int count)
{
    int i;
    fprintf(f, "## At a glance\n\nThe whole run: ours by ecp_advance() at the tolerance 1e-6, and "
               "the peer that has the least error at any of its step sizes. The peers with a point "
               "in the plane of error and run time that no point of ours dominates.\n\n");
    fprintf(f, "| scene | unit | ms | error | most exact peer | its ms | its error | peers not "
               "dominated |\n|---|---|---|---|---|---|---|---|\n");
    for (i = 0; i < count; i++) {
        const row *us = find_advance(tables + i, 1e-6);
        const row *peer = find_best_peer(scenes + i, tables + i);
        if (!tables[i].count) continue;
        fprintf(f, "| %s | %s |", scenes[i].name, scenes[i].unit);
        cell(f, us != NULL, "%.3g", us ? run_ms(us) : 0);
        cell(f, us != NULL, "%.1e", us ? us->continuous : 0);
        fprintf(f, " %s |", peer ? method_name(peer) : "");
        cell(f, peer != NULL, "%.3g", peer ? run_ms(peer) : 0);
        cell(f, peer != NULL, "%.1e", peer ? peer->continuous : 0);
        fprintf(f, " ");
        put_undominated(f, tables + i);
    }
    fprintf(f,
            "\nA step of h = 0.01 s: ours with its default tolerance in double, and the peer that "
            "takes the least time.\n\n");
    fprintf(f, "| scene | us a step | error | instructions a step | fastest peer | its us | its "
               "error |\n|---|---|---|---|---|---|---|\n");
    for (i = 0; i < count; i++) {
        const row *us = find_row(tables + i, 1), *peer = find_row(tables + i, 0);
        if (!us) continue;
        fprintf(f, "| %s |", scenes[i].name);
        cell(f, 1, "%.3g", us->median);
        cell(f, 1, "%.2g", us->continuous);
        cell(f, us->instructions > 0, "%.0f", us->instructions);
        fprintf(f, " %s |", peer ? method_name(peer) : "");
        cell(f, peer != NULL, "%.3g", peer ? peer->median : 0);
        cell(f, peer != NULL, "%.2g", peer ? peer->continuous : 0);
        fprintf(f, "\n");
    }
    fprintf(f, "\n");
}

static void put_legs(FILE *f, const table *t)
{
    const row *r;
    int i, n, most = 0;
    if (!t->count) return;
    for (i = 0; i < t->count; i++) most = t->rows[i].legs > most ? t->rows[i].legs : most;
    fprintf(f, "## Time over the number of patches\n\nA body slides on a ring of legs (the peers: "
               "balls) at h = 0.01 s; us a step, and our unknowns.\n\n![us a step over the number "
               "of patches](report/legs.svg)\n\n| method |");
    for (n = 1; n <= most; n *= 2) fprintf(f, " %d |", n);
    fprintf(f, "\n|---|");
    for (n = 1; n <= most; n *= 2) fprintf(f, "---|");
    fprintf(f, "\n| unknowns |");
    for (i = 0; i < t->count; i++) {
        r = t->rows + i;
        if (r->engine == the.engines[0] && r->method == 0) fprintf(f, " %d |", r->unknowns);
    }
    n = 0;
    for (r = next_row(t, NULL); r; r = next_row(t, r)) {
        if (r->legs == 1) fprintf(f, "\n| %s |", method_name(r));
        fprintf(f, " %.3g |", r->median);
    }
    fprintf(f, "\n\n");
}

void write_report(const report_scene *scenes, const table *tables, int count, const table *patches)
{
    FILE *f = open_out("report.md");
    int i;
    fprintf(f, "# Error against run time\n\nWritten by `make report` (tests/report.c), numbers and "
               "all; the rows of every plot are in docs/report, one CSV file a scene.\n\n");
    put_machine(f);
    fprintf(f,
            "Every method runs every scene once and is watched: its error at the end, or the worst "
            "on the way, against the continuous motion; its error against the exact solution of "
            "the time step, the worst of all steps, where there is one (a peer whose step is "
            "another one shows the difference of the two); penetration, from the poses alone; "
            "creep, the speed over the last twentieth of a scene that ends at rest; steps that it "
            "says it has not solved. Then all methods and step sizes of the scene are timed in "
            "turn, %d times over, each from new worlds: medians and quartiles are over these "
            "turns. A run longer than %g ms is timed in %d stretches that begin at states of the "
            "first run, after %d steps of warm-up. Run time is the median time of a step times "
            "the steps of the run. Instructions are counted by callgrind, for ours as it comes, "
            "over the first 500 steps at most.\n\n"
            "Peers go by steps of a size that is chosen for them, and so do we; and we go by "
            "ecp_advance() as well: over tolerances from 1e-2 to 1e-10 (the black line of the "
            "plots), for which it chooses step and order, and over macro steps of the orders 2, 4 "
            "and 6 (grey lines). These runs are timed as a whole, and their time and error are of "
            "the same calls; their penetration is the worst after each fiftieth of another run. "
            "Forced: macro steps that were accepted although not within the tolerance, as the "
            "library reports them.\n\n"
            "A point is dominated by another one that has no more error and takes no more time, "
            "and less of one of the two. Errors below what a truth is known to are alike.\n\n",
            RUNS, 2e3 * the.budget, WINDOWS, 20);
    put_overview(f, scenes, tables, count);
    for (i = 0; i < count; i++) {
        if (tables[i].count) put_scene(f, scenes + i, tables + i);
    }
    put_legs(f, patches);
    put_peers(f);
    fprintf(f, "    ");
    print_last_line(f, scenes, tables, count);
    fclose(f);
}
