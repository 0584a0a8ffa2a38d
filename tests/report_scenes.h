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
    double t, penetration;       /* of a run by calls of `advance` */
    double continuous, discrete; /* errors against the two truths, in the scene's unit */
    double energy, momentum;     /* drift, where they are conserved: relative */
} report_watch;

struct report_scene {
    const char *name, *title, *unit;
    const char *measure, *truth_is; /* what the error is of, and what it is measured against */
    const char *remark;             /* for the reader of the report, or NULL */
    double end;                     /* s */
    double sample;                  /* the error is taken after every so many s; 0: at the end */
    void (*build)(report_world *w);
    void (*watch)(report_watch *w, int k, double t, const report_state *s);
    int has_discrete; /* there is an exact solution of the time step */
    int rests;        /* at the end: what moves then is creep */
    int patches;      /* a body has several patches, so that our two rules differ */
    int moves;
    int conserves; /* energy and angular momentum */
    double floor;  /* to which the truth is known; errors below it are alike */

    report_world world;
    int own_truth, truth_known;
    report_state truth[REPORT_TRUTHS]; /* after every 0.1 s */
    double truth_h;                    /* own_truth: the smallest step */
};

/* all scenes, built */
report_scene *report_scenes(int *count);

/* a body that slides on n legs */
void report_legs(report_world *w, int n);

/* the deepest penetration of the plane and of the bodies by each other, m; >= 0 */
double report_penetration(const report_world *w, const report_state *s, int who);

#endif /* REPORT_SCENES_H */
