/* The scenes of the report, their truths, and what is watched while they run. */

#ifndef REPORT_SCENES_H
#define REPORT_SCENES_H

#include "report.h"

enum { REPORT_TRUTHS = 50 };

typedef struct report_scene report_scene;

/* What is seen of one run. Errors grow while it goes on. */
typedef struct report_watch {
    const report_scene *scene;
    double h;
    int steps, at_end;
    double continuous, discrete; /* errors against the two truths, in the scene's unit */
} report_watch;

struct report_scene {
    const char *name, *title, *unit;
    const char *measure, *truth_is; /* what the error is of, and what it is measured against */
    const char *remark;             /* for the reader of the report, or NULL */
    double end;                     /* s */
    void (*build)(report_world *w);
    void (*watch)(report_watch *w, int k, double t, const report_state *s);
    int has_discrete; /* there is an exact solution of the time step */
    int rests;        /* at the end: what moves then is creep */
    int patches;      /* a body has several patches, so that our two rules differ */
    int moves;
    double floor; /* to which the truth is known; errors below it are alike */

    report_world world;
    int own_truth, truth_known, truth_of_velocity;
    report_state truth[REPORT_TRUTHS]; /* after every 0.1 s */
    double truth_h, lift_off;          /* own_truth: the step; T2: w_x after the kick */
};

/* all scenes, built */
report_scene *report_scenes(int *count);

/* w_x just after the kick of Example 2 (T2), as h -> 0: the table turns over its leg's edge, sliding */
double report_lift_off(void);

/* a body that slides on n legs */
void report_legs(report_world *w, int n);

/* the deepest penetration of the plane and of the bodies by each other, m; >= 0 */
double report_penetration(const report_world *w, const report_state *s, int who);

#endif /* REPORT_SCENES_H */
