/* What the report and the engines that it compares share. A scene is described once, without any
   engine's types; each engine is a table of functions. Ours is linked twice (double and float); a
   peer is a shared object that exports `report_peer`, so that a peer that is not installed is only
   a file that is not there. */

#ifndef REPORT_H
#define REPORT_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { REPORT_BODIES = 10, REPORT_PARTS = 128 };

typedef enum report_kind { REPORT_BOX, REPORT_CYLINDER, REPORT_SPHERE } report_kind;

/* who has a part: the peers get what serves them best where a shape of ours does not */
enum { REPORT_OURS = 1, REPORT_PEERS = 2, REPORT_ALL = 3 };

/* A primitive, not turned in its body's frame. */
typedef struct report_part {
    report_kind kind;
    int who;
    double size[3]; /* box: half sizes; cylinder about z: radius, half height; sphere: radius */
    double at[3];
} report_part;

/* Rotation as a quaternion (w, x, y, z), body to world; v and w in world axes. */
typedef struct report_state {
    double x[3], q[4], v[3], w[3];
} report_state;

/* A point that may touch what is below, for engines that know points only: of the body's frame,
   lowered by `radius` in world axes (a ball's). */
typedef struct report_point {
    double at[3], radius;
} report_point;

typedef struct report_body {
    double mass, inertia[3]; /* principal, body axes */
    int parts, points;
    report_part part[REPORT_PARTS];
    report_point point[REPORT_PARTS];
    report_state start;
} report_body;

typedef struct report_load {
    double force[3], torque[3], angular_impulse[3]; /* world axes, at the centre of mass */
} report_load;

/* Bodies over the plane z = 0, which carries the same friction as they do. */
typedef struct report_world {
    double g[3], mu, e_r; /* e_t = e_o = 1 */
    int bodies;
    int stacked; /* each body stands on the one before it */
    report_body body[REPORT_BODIES];
    void (*load)(double t, double h, report_load *load); /* on body 0, from t to t + h; or NULL */
    double kick; /* load is nothing but an angular impulse at this time, s; 0: a function of time */
} report_world;

typedef struct report_method {
    const char *name;
    const char *settings; /* a sentence */
    int motion;           /* only where something moves: it differs from another one there alone */
    int patches;          /* only where a body has several patches */
} report_method;

/* What a method is run over: sizes of its step, or of a macro step of an order that is fixed, or
   tolerances. All three are called its size. */
typedef enum report_pace { REPORT_STEPS, REPORT_MACRO_STEPS, REPORT_TOLERANCES } report_pace;

/* what calls of `advance` have taken so far */
typedef struct report_cost {
    int solves;      /* base steps */
    int first_order; /* macro steps that were passed at first order */
    int forced;      /* of these, not within the tolerance */
    int refused;     /* the tolerance is below what rounding leaves */
} report_cost;

typedef struct report_engine {
    const char *name;
    const char *version;
    const char *setup; /* what holds for all its methods */
    int ours;
    int count;
    const report_method *methods;

    /* A world that is ready for steps of h, or that size; the scene outlives it. NULL: it cannot be
       had. */
    void *(*open)(const report_world *scene, int method, double h);

    /* The step from time t, loads included. 0: solved to the method's own tolerance. */
    int (*step)(void *world, double t);

    void (*state)(void *world, int body, report_state *out);
    int (*unknowns)(void *world); /* of the last step; NULL: not known */
    void (*close)(void *world);
    report_pace pace;

    /* From t to t + duration, without steps that the caller sees; a kick is at the beginning or not in
       between. 0: it is there. NULL where the pace is REPORT_STEPS. */
    int (*advance)(void *world, double t, double duration, report_cost *cost);
} report_engine;

/* what a peer's shared object exports */
extern const report_engine report_peer;

#ifdef __cplusplus
}
#endif

#endif /* REPORT_H */
