/* MuJoCo, as an engine of the report. Built when MUJOCO_DIR has include/mujoco and lib. */

#include "../report.h"

#include <mujoco/mujoco.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define QUOTE(x) #x
#define TEXT(x) QUOTE(x)

typedef struct mujoco {
    mjModel *model;
    mjData *data;
    const report_world *scene;
    double h;
} mujoco;

typedef struct mujoco_method {
    const char *cone;
    int stiff, slow_friction;
} mujoco_method;

static const mujoco_method with[] = {{"elliptic", 0, 0},
                                     {"elliptic", 1, 0},
                                     {"elliptic", 1, 1},
                                     {"pyramidal", 0, 0},
                                     {"pyramidal", 1, 0}};

static const report_method methods[] = {
    {"MuJoCo elliptic", "elliptic cone, default contacts (solref 0.02 1)", 0, 0},
    {"MuJoCo elliptic stiff", "elliptic cone, stiff contacts", 0, 0},
    {"MuJoCo elliptic slow",
     "elliptic cone, stiff contacts, solreffriction with a time constant of 50 h", 0, 0},
    {"MuJoCo pyramidal", "pyramidal cone, default contacts", 0, 0},
    {"MuJoCo pyramidal stiff", "pyramidal cone, stiff contacts", 0, 0},
};

/* text for the model's XML, at the end of what is there */
static void put(char **at, const char *format, ...)
{
    va_list values;
    va_start(values, format);
    *at += vsprintf(*at, format, values);
    va_end(values);
}

/* every pair that may touch, with its own solver parameters */
static void put_pair(char **at, const char *a, const char *b, const report_world *scene,
                     const mujoco_method *m, double h)
{
    put(at, "<pair geom1='%s' geom2='%s' condim='3' friction='%.17g %.17g 0 0 0'", a, b, scene->mu,
        scene->mu);
    /* at least two steps, as the manual says; 0.9999 and a narrow transition: as hard as it goes */
    if (m->stiff) put(at, " solref='%.17g 1' solimp='0.9999 0.9999 0.001 0.5 2'", 2 * h);
    if (m->slow_friction) put(at, " solreffriction='%.17g 1'", 50 * h);
    put(at, "/>");
}

static char *describe(const report_world *scene, const mujoco_method *m, double h)
{
    char *text = (char *)malloc(1 << 20), *at = text, geom[32], below[32];
    int i, j;
    put(&at,
        "<mujoco><compiler angle='radian' autolimits='true'/>"
        "<option timestep='%.17g' gravity='%.17g %.17g %.17g' cone='%s' solver='Newton' "
        "iterations='100' tolerance='1e-12' impratio='%d'/><worldbody>"
        "<geom name='g' type='plane' size='0 0 1'/>",
        h, scene->g[0], scene->g[1], scene->g[2], m->cone, m->cone[0] == 'e' ? 10 : 1);
    for (i = 0; i < scene->bodies; i++) {
        const report_body *b = scene->body + i;
        const report_state *s = &b->start;
        put(&at,
            "<body pos='%.17g %.17g %.17g' quat='%.17g %.17g %.17g %.17g'><freejoint/><inertial "
            "pos='0 0 0' mass='%.17g' diaginertia='%.17g %.17g %.17g'/>",
            s->x[0], s->x[1], s->x[2], s->q[0], s->q[1], s->q[2], s->q[3], b->mass, b->inertia[0],
            b->inertia[1], b->inertia[2]);
        for (j = 0; j < b->parts; j++) {
            const report_part *p = b->part + j;
            static const char *const kinds[] = {"box", "cylinder", "sphere"};
            if (!(p->who & REPORT_PEERS)) continue;
            put(&at,
                "<geom name='b%d_%d' type='%s' size='%.17g %.17g %.17g' pos='%.17g %.17g %.17g' "
                "contype='0' conaffinity='0'/>",
                i, j, kinds[p->kind], p->size[0], p->size[1], p->size[2], p->at[0], p->at[1],
                p->at[2]);
        }
        put(&at, "</body>");
    }
    put(&at, "</worldbody><contact>");
    for (i = 0; i < scene->bodies; i++) {
        for (j = 0; j < scene->body[i].parts; j++) {
            if (!(scene->body[i].part[j].who & REPORT_PEERS)) continue;
            sprintf(geom, "b%d_%d", i, j);
            sprintf(below, "b%d_%d", i - 1, j);
            put_pair(&at, scene->stacked && i > 0 ? below : "g", geom, scene, m, h);
        }
    }
    put(&at, "</contact></mujoco>");
    return text;
}

static void *mujoco_open(const report_world *scene, int method, double h)
{
    mujoco *w = (mujoco *)calloc(1, sizeof *w);
    char *text = describe(scene, with + method, h), error[500] = "";
    mjVFS vfs;
    int i, k;
    mj_defaultVFS(&vfs);
    mj_addBufferVFS(&vfs, "scene.xml", text, (int)strlen(text));
    w->model = mj_loadXML("scene.xml", &vfs, error, sizeof error);
    mj_deleteVFS(&vfs);
    free(text);
    if (!w->model) {
        fprintf(stderr, "MuJoCo: %s\n", error);
        exit(2);
    }
    w->data = mj_makeData(w->model);
    w->scene = scene;
    w->h = h;
    for (i = 0; i < scene->bodies; i++) {
        /* a free joint's angular velocity is in the body's frame */
        mjtNum back[4], spin[3];
        mju_negQuat(back, scene->body[i].start.q);
        mju_rotVecQuat(spin, scene->body[i].start.w, back);
        for (k = 0; k < 3; k++) {
            w->data->qvel[6 * i + k] = scene->body[i].start.v[k];
            w->data->qvel[6 * i + 3 + k] = spin[k];
        }
    }
    return w;
}

static int mujoco_step(void *world, double t)
{
    mujoco *w = (mujoco *)world;
    int k;
    if (w->scene->load) {
        report_load l;
        w->scene->load(t, w->h, &l);
        for (k = 0; k < 3; k++) {
            w->data->xfrc_applied[6 + k] = l.force[k];
            w->data->xfrc_applied[9 + k] = l.torque[k] + l.angular_impulse[k] / w->h;
        }
    }
    mj_step(w->model, w->data);
    return w->data->warning[mjWARN_BADQACC].number > 0;
}

static void mujoco_state(void *world, int body, report_state *out)
{
    const mujoco *w = (const mujoco *)world;
    int k;
    memcpy(out->x, w->data->qpos + 7 * body, sizeof out->x);
    memcpy(out->q, w->data->qpos + 7 * body + 3, sizeof out->q);
    for (k = 0; k < 3; k++) out->v[k] = w->data->qvel[6 * body + k];
    mju_rotVecQuat(out->w, w->data->qvel + 6 * body + 3, out->q);
}

static int mujoco_unknowns(void *world) { return ((const mujoco *)world)->data->nefc; }

static void mujoco_close(void *world)
{
    mujoco *w = (mujoco *)world;
    mj_deleteData(w->data);
    mj_deleteModel(w->model);
    free(w);
}

const report_engine report_peer = {
    "MuJoCo",
    "mjVERSION_HEADER " TEXT(mjVERSION_HEADER),
    "Newton solver, up to 100 iterations, tolerance 1e-12, Euler integrator, impratio 10 with the "
    "elliptic cone, contacts as explicit pairs with condim 3; stiff: solref of two steps, solimp "
    "0.9999",
    0,
    (int)(sizeof methods / sizeof methods[0]),
    methods,
    mujoco_open,
    mujoco_step,
    mujoco_state,
    mujoco_unknowns,
    mujoco_close,
    REPORT_STEPS,
    NULL};
