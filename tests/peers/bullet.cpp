/* Bullet Physics, as an engine of the report. Compiled twice: in single precision, as it comes, and
   in double. */

#include "../report.h"

#include <btBulletDynamicsCommon.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>

#include <math.h>

#ifdef BT_USE_DOUBLE_PRECISION
#define NAME "Bullet double"
#define REAL "double precision"
#else
#define NAME "Bullet"
#define REAL "single precision, as it comes"
#endif

namespace
{

struct bullet_method {
    int iterations; /* of the sequential impulse solver; 0: Dantzig */
};

const bullet_method with[] = {{10}, {50}, {200}, {0}};

const report_method methods[] = {
    {NAME " 10", "sequential impulses, 10 iterations (the default)", 0, 0},
    {NAME " 50", "sequential impulses, 50 iterations", 0, 0},
    {NAME " 200", "sequential impulses, 200 iterations", 0, 0},
    {NAME " Dantzig", "btMLCPSolver with btDantzigSolver", 0, 0},
};

btVector3 vector(const double *v)
{
    return btVector3(btScalar(v[0]), btScalar(v[1]), btScalar(v[2]));
}

struct bullet {
    const report_world *scene;
    double h;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher;
    btDbvtBroadphase broadphase;
    btDantzigSolver dantzig;
    btSequentialImpulseConstraintSolver *solver;
    btDiscreteDynamicsWorld *world;
    btAlignedObjectArray<btCollisionShape *> shapes;
    btAlignedObjectArray<btRigidBody *> bodies;

    bullet(const report_world *s, int method, double step)
        : scene(s), h(step), configuration(), dispatcher(&configuration), broadphase(), dantzig(),
          solver(0), world(0), shapes(), bodies()
    {
        /* a plane meets a body in all its corners at once */
        configuration.setPlaneConvexMultipointIterations(4, 4);
        solver = with[method].iterations ? new btSequentialImpulseConstraintSolver
                                         : new btMLCPSolver(&dantzig);
        world = new btDiscreteDynamicsWorld(&dispatcher, &broadphase, solver, &configuration);
        world->setGravity(vector(s->g));
        btContactSolverInfo &info = world->getSolverInfo();
        if (with[method].iterations) info.m_numIterations = with[method].iterations;
        info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
        add_ground();
        for (int i = 0; i < s->bodies; i++) add_body(s->body[i]);
    }

    ~bullet()
    {
        for (int i = 0; i < bodies.size(); i++) {
            world->removeRigidBody(bodies[i]);
            delete bodies[i];
        }
        delete world;
        delete solver;
        for (int i = 0; i < shapes.size(); i++) delete shapes[i];
    }

    bullet(const bullet &);
    bullet &operator=(const bullet &);

    void add(btRigidBody::btRigidBodyConstructionInfo &info)
    {
        /* the two coefficients of a contact are multiplied */
        info.m_friction = btScalar(sqrt(scene->mu));
        info.m_restitution = 0;
        info.m_linearDamping = info.m_angularDamping = 0;
        btRigidBody *body = new btRigidBody(info);
        body->setActivationState(DISABLE_DEACTIVATION);
        world->addRigidBody(body);
        bodies.push_back(body);
    }

    void add_ground()
    {
        btCollisionShape *plane = new btStaticPlaneShape(btVector3(0, 0, 1), 0);
        btRigidBody::btRigidBodyConstructionInfo info(0, 0, plane);
        shapes.push_back(plane);
        add(info);
    }

    void add_body(const report_body &b)
    {
        btCompoundShape *all = 0;
        btCollisionShape *one = 0;
        int parts = 0;
        for (int i = 0; i < b.parts; i++) parts += (b.part[i].who & REPORT_PEERS) != 0;
        for (int i = 0; i < b.parts; i++) {
            const report_part &p = b.part[i];
            if (!(p.who & REPORT_PEERS)) continue;
            if (p.kind == REPORT_BOX) one = new btBoxShape(vector(p.size));
            if (p.kind == REPORT_SPHERE) one = new btSphereShape(btScalar(p.size[0]));
            if (p.kind == REPORT_CYLINDER) {
                one = new btCylinderShapeZ(
                    btVector3(btScalar(p.size[0]), btScalar(p.size[0]), btScalar(p.size[1])));
            }
            shapes.push_back(one);
            bool centred = p.at[0] * p.at[0] + p.at[1] * p.at[1] + p.at[2] * p.at[2] <= 0;
            if (parts == 1 && centred) break;
            if (!all) {
                all = new btCompoundShape();
                shapes.push_back(all);
            }
            btTransform at;
            at.setIdentity();
            at.setOrigin(vector(p.at));
            all->addChildShape(at, one);
        }
        if (all) one = all;
        btRigidBody::btRigidBodyConstructionInfo info(btScalar(b.mass), 0, one, vector(b.inertia));
        const double *q = b.start.q;
        info.m_startWorldTransform.setOrigin(vector(b.start.x));
        info.m_startWorldTransform.setRotation(
            btQuaternion(btScalar(q[1]), btScalar(q[2]), btScalar(q[3]), btScalar(q[0])));
        add(info);
        bodies[bodies.size() - 1]->setLinearVelocity(vector(b.start.v));
        bodies[bodies.size() - 1]->setAngularVelocity(vector(b.start.w));
    }

    int step(double t)
    {
        if (scene->load) {
            report_load l;
            scene->load(t, h, &l);
            bodies[1]->applyCentralForce(vector(l.force));
            bodies[1]->applyTorque(vector(l.torque));
            bodies[1]->applyTorqueImpulse(vector(l.angular_impulse));
        }
        world->stepSimulation(btScalar(h), 0);
        return 0;
    }
};

void *bullet_open(const report_world *scene, int method, double h)
{
    return new bullet(scene, method, h);
}

int bullet_step(void *world, double t) { return static_cast<bullet *>(world)->step(t); }

void bullet_state(void *world, int body, report_state *out)
{
    const btRigidBody *b = static_cast<bullet *>(world)->bodies[body + 1];
    const btVector3 &x = b->getWorldTransform().getOrigin();
    const btQuaternion q = b->getWorldTransform().getRotation();
    for (int k = 0; k < 3; k++) {
        out->x[k] = x[k];
        out->v[k] = b->getLinearVelocity()[k];
        out->w[k] = b->getAngularVelocity()[k];
        out->q[k + 1] = q[k];
    }
    out->q[0] = q.w();
}

void bullet_close(void *world) { delete static_cast<bullet *>(world); }

} // namespace

extern "C" const report_engine report_peer = {
    NAME,
    VERSION,
    REAL "; the square root of mu in each body (they are multiplied), no damping, no "
         "deactivation, two friction directions, a plane with setPlaneConvexMultipointIterations, "
         "stepSimulation(h, 0)",
    0,
    int(sizeof methods / sizeof methods[0]),
    methods,
    bullet_open,
    bullet_step,
    bullet_state,
    0,
    bullet_close,
    REPORT_STEPS,
    0};
