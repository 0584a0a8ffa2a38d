/* The tables of the report: what was measured, and how it was run. */

#ifndef REPORT_TABLE_H
#define REPORT_TABLE_H

#include "report_scenes.h"

#include <stdio.h>

enum { RUNS = 5, WINDOWS = 8, ENGINES = 12 };

/* one line of a scene's table: a method at a size */
typedef struct row {
    const report_engine *engine;
    int method;
    double h;  /* its size: of the step or the macro step, s, or the tolerance */
    int steps; /* 1 for what is timed as a whole */
    report_cost cost;
    double continuous, discrete, penetration, creep, energy, momentum;
    int unsolved, unknowns, failed; /* failed: no end state, or not a number */
    double first_us;                /* per step, in the run that is watched */
    double us[RUNS], median, q1, q3;
    double instructions; /* per step; < 0: not counted */
    int front, beats;    /* not dominated by anything; a peer's that none of ours dominates */
    int legs;            /* of the table over the number of patches */
    int start[WINDOWS];
    report_state *starts; /* of each window, where a run is too long to be timed as a whole */
} row;

typedef struct table {
    row *rows;
    int count;
    int left_out; /* rows that would take too long */
    int fronts, peer_fronts;
} table;

/* how this run was made */
typedef struct report_run {
    int quick, pinned, progress;
    const char *only, *self, *out;
    double budget; /* s of a timed run */
    double cap;    /* s of a run that is watched; longer ones are left out */
    double timer;  /* s that reading the clock takes */
    const report_engine *engines[ENGINES];
    int engine_count, ours_count; /* ours come first */
    const char *absent[ENGINES];  /* peers that were not built */
    int absent_count;
} report_run;

extern report_run the;

const char *method_name(const row *r);
int is_size(double a, double b);
int at_a_hundredth(const row *r);
double run_ms(const row *r);

/* the error, not less than what the truth is known to */
double effective(const report_scene *scene, const row *r);

/* docs/report/NAME.csv: every row of a scene, and of the table over the number of patches */
void write_scene(const report_scene *scene, const table *t);
void write_legs(const table *t);

/* the non-dominated methods, for the terminal */
void print_scene(const report_scene *scene, const table *t);

/* docs/report.md, and the last line of the report */
void write_report(const report_scene *scenes, const table *tables, int count, const table *patches);
void print_last_line(FILE *f, const report_scene *scenes, const table *tables, int count);

#endif /* REPORT_TABLE_H */
