/* Open Dynamics Engine, as an engine of the report. */

#include "../report.h"

#include <math.h>
#include <ode/ode.h>
#include <stdarg.h>
#include <stdlib.h>

typedef struct ode {
    dWorldID world;
    dSpaceID space;
    dGeomID plane;
    dJointGroupID contacts;
    dBodyID body[REPORT_BODIES];
    const report_world *scene;
    double h;
    int method, along; /* along: the first friction direction is that of the motion */
} ode;

typedef struct ode_method {
    int quick; /* iterations of dWorldQuickStep; 0: dWorldStep */
    int along;
} ode_method;

static const ode_method with[] = {{0, 0}, {0, 1}, {20, 0}, {20, 1}, {100, 1}};

static const report_method methods[] = {
    {"ODE step", "dWorldStep, default friction directions", 0, 0},
    {"ODE step along", "dWorldStep, fdir1 along the motion", 1, 0},
    {"ODE quick 20", "dWorldQuickStep, 20 iterations, default friction directions", 0, 0},
    {"ODE quick 20 along", "dWorldQuickStep, 20 iterations, fdir1 along the motion", 1, 0},
    {"ODE quick 100 along", "dWorldQuickStep, 100 iterations, fdir1 along the motion", 0, 0},
};

static int complaints;

/* what ODE has to say about its steps: they count as not solved */
static void complain(int number, const char *text, va_list values)
{
    (void)number, (void)text, (void)values;
    complaints++;
}

static const double inside = 1e-8; /* a start that touches exactly makes no contact */

static void add_body(ode *w, const report_body *b, int index)
{
    dBodyID body = dBodyCreate(w->world);
    dMass mass;
    int i;
    dMassSetParameters(&mass, b->mass, 0, 0, 0, b->inertia[0], b->inertia[1], b->inertia[2], 0, 0,
                       0);
    dBodySetMass(body, &mass);
    /* every interface of a stack is 10 nm inside */
    dBodySetPosition(body, b->start.x[0], b->start.x[1], b->start.x[2] - inside * (index + 1));
    dBodySetQuaternion(body, b->start.q);
    dBodySetLinearVel(body, b->start.v[0], b->start.v[1], b->start.v[2]);
    dBodySetAngularVel(body, b->start.w[0], b->start.w[1], b->start.w[2]);
    for (i = 0; i < b->parts; i++) {
        const report_part *p = b->part + i;
        dGeomID geom;
        if (!(p->who & REPORT_PEERS)) continue;
        if (p->kind == REPORT_BOX) {
            geom = dCreateBox(w->space, 2 * p->size[0], 2 * p->size[1], 2 * p->size[2]);
        } else if (p->kind == REPORT_CYLINDER) {
            geom = dCreateCylinder(w->space, p->size[0], 2 * p->size[1]);
        } else {
            geom = dCreateSphere(w->space, p->size[0]);
        }
        dGeomSetBody(geom, body);
        dGeomSetOffsetPosition(geom, p->at[0], p->at[1], p->at[2]);
        dGeomSetCategoryBits(geom, 1);
        dGeomSetCollideBits(geom, w->scene->bodies > 1 ? 3 : 2);
    }
    w->body[index] = body;
}

static void *ode_open(const report_world *scene, int method, double h)
{
    static int ready;
    ode *w = (ode *)calloc(1, sizeof *w);
    int i;
    if (!ready) {
        dInitODE2(0);
        dSetMessageHandler(complain);
        dAllocateODEDataForThread(dAllocateMaskAll);
        ready = 1;
    }
    dRandSetSeed(1); /* the order of dWorldQuickStep's rows */
    w->scene = scene;
    w->h = h;
    w->method = method;
    w->along = with[method].along;
    w->world = dWorldCreate();
    w->space = dSimpleSpaceCreate(0);
    w->contacts = dJointGroupCreate(0);
    w->plane = dCreatePlane(w->space, 0, 0, 1, 0);
    dGeomSetCategoryBits(w->plane, 2);
    dGeomSetCollideBits(w->plane, 1);
    dWorldSetGravity(w->world, scene->g[0], scene->g[1], scene->g[2]);
    dWorldSetAutoDisableFlag(w->world, 0);
    if (with[method].quick) dWorldSetQuickStepNumIterations(w->world, with[method].quick);
    for (i = 0; i < scene->bodies; i++) add_body(w, scene->body + i, i);
    return w;
}

/* the first friction direction: where the point of contact moves, or would begin to */
static int direction(const ode *w, dBodyID body, const dContactGeom *at, dReal *fdir)
{
    dVector3 v;
    double along, size;
    int k;
    dBodyGetPointVel(body, at->pos[0], at->pos[1], at->pos[2], v);
    for (k = 0; k < 3; k++) v[k] += w->h * w->scene->g[k];
    along = v[0] * at->normal[0] + v[1] * at->normal[1] + v[2] * at->normal[2];
    for (k = 0; k < 3; k++) v[k] -= along * at->normal[k];
    size = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(size > 1e-12)) return 0;
    for (k = 0; k < 3; k++) fdir[k] = v[k] / size;
    return 1;
}

static void touch(void *data, dGeomID a, dGeomID b)
{
    ode *w = (ode *)data;
    dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    dContactGeom geom[8];
    dContact contact;
    int i, count;
    if (body_a == body_b) return;
    count = dCollide(a, b, 8, geom, sizeof geom[0]);
    for (i = 0; i < count; i++) {
        contact.geom = geom[i];
        contact.surface.mode = dContactApprox1; /* else mu is a force, not a coefficient */
        contact.surface.mu = w->scene->mu;
        if (w->along && direction(w, body_a ? body_a : body_b, geom + i, contact.fdir1)) {
            contact.surface.mode |= dContactFDir1;
        }
        dJointAttach(dJointCreateContact(w->world, w->contacts, &contact), body_a, body_b);
    }
}

static int ode_step(void *world, double t)
{
    ode *w = (ode *)world;
    int solved = 1;
    complaints = 0;
    if (w->scene->load) {
        report_load l;
        const double *p = l.angular_impulse;
        w->scene->load(t, w->h, &l);
        dBodyAddForce(w->body[0], l.force[0], l.force[1], l.force[2]);
        dBodyAddTorque(w->body[0], l.torque[0] + p[0] / w->h, l.torque[1] + p[1] / w->h,
                       l.torque[2] + p[2] / w->h);
    }
    dSpaceCollide(w->space, w, touch);
    if (with[w->method].quick) {
        solved = dWorldQuickStep(w->world, w->h);
    } else {
        solved = dWorldStep(w->world, w->h);
    }
    dJointGroupEmpty(w->contacts);
    return !solved || complaints > 0;
}

static void ode_state(void *world, int body, report_state *out)
{
    dBodyID b = ((ode *)world)->body[body];
    const dReal *x = dBodyGetPosition(b), *q = dBodyGetQuaternion(b);
    const dReal *v = dBodyGetLinearVel(b), *turn = dBodyGetAngularVel(b);
    int k;
    for (k = 0; k < 3; k++) {
        out->x[k] = x[k];
        out->v[k] = v[k];
        out->w[k] = turn[k];
    }
    for (k = 0; k < 4; k++) out->q[k] = q[k];
}

static void ode_close(void *world)
{
    ode *w = (ode *)world;
    dJointGroupDestroy(w->contacts);
    dSpaceDestroy(w->space);
    dWorldDestroy(w->world);
    free(w);
}

const report_engine report_peer = {
    "ODE",
    VERSION,
    "double precision; dContactApprox1 (Coulomb's law, by a pyramid), a start 10 nm inside what "
    "is below, ERP 0.2 and CFM 1e-10 (the defaults), no slip, no softness, automatic disabling "
    "off; a simple space; up to 8 contacts a pair",
    0,
    (int)(sizeof methods / sizeof methods[0]),
    methods,
    ode_open,
    ode_step,
    ode_state,
    NULL,
    ode_close,
    REPORT_STEPS,
    NULL};
