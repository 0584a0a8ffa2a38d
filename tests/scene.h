/* Scenes for the programs that measure: a world that is described tightly, solids of one or more
   primitives of equal density, and random numbers of the scene's own. Built in double. */

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct scene {
    ecp_world *world;
    ecp_material material;   /* of the solids that are added next */
    ecp_real store[64 * 20]; /* planes and vertices of polytopes */
    int stored;
    uint64_t seed;
    double g[3];
} scene;

/* one body: its primitives, in a frame with the origin at the centre of mass once it is closed */
typedef struct solid {
    ecp_shape shape[65];
    double at[65][3];
    ecp_real turn[65][4];
    int parts;
    double inertia[9]; /* of 1 kg */
} solid;

static const double scene_pi = 3.14159265358979323846;

/* A scene cannot be built: an error of this program. */
static inline void must(ecp_status status)
{
    if (status == ECP_OK) return;
    fprintf(stderr, "%s\n", ecp_status_string(status));
    exit(2);
}

/* ---- numbers */

static inline uint64_t scene_bits(scene *s)
{
    s->seed ^= s->seed >> 12;
    s->seed ^= s->seed << 25;
    s->seed ^= s->seed >> 27;
    return s->seed * UINT64_C(2685821657736338717);
}

/* (never two draws in the arguments of one call: compilers make them in different order, and other scenes of that) */
static inline double uniform(scene *s, double lo, double hi)
{
    return lo + (hi - lo) * ((double)(scene_bits(s) >> 11) / 9007199254740992.0);
}

/* one of 0, 1, ..., n - 1 */
static inline int pick(scene *s, int n) { return (int)((scene_bits(s) >> 33) % (uint64_t)n); }

static inline double log_uniform(scene *s, double lo, double hi)
{
    return lo * pow(hi / lo, uniform(s, 0, 1));
}

/* a vector of length up to `most`, every direction alike */
static inline void random_vector(scene *s, double most, double v[3])
{
    double r2;
    int k;
    do {
        for (k = 0, r2 = 0; k < 3; k++) {
            v[k] = uniform(s, -1, 1);
            r2 += v[k] * v[k];
        }
    } while (r2 > 1 || r2 < 1e-3);
    for (k = 0; k < 3; k++) v[k] *= most;
}

static inline void normalise(double *v, int n)
{
    double size = 0;
    int k;
    for (k = 0; k < n; k++) size += v[k] * v[k];
    for (k = 0; k < n; k++) v[k] /= sqrt(size);
}

static inline void random_turn(scene *s, double q[4])
{
    int k;
    for (k = 0; k < 4; k++) q[k] = uniform(s, -1, 1) + uniform(s, -1, 1) + uniform(s, -1, 1);
    normalise(q, 4);
}

/* the quaternion of a turn about the unit axis */
static inline void turn_about(double x, double y, double z, double angle, double q[4])
{
    q[0] = cos(angle / 2);
    q[1] = x * sin(angle / 2);
    q[2] = y * sin(angle / 2);
    q[3] = z * sin(angle / 2);
}

static inline void turned(const double q[4], const double v[3], double out[3])
{
    double t[3];
    int k;
    for (k = 0; k < 3; k++) {
        t[k] = 2 * (q[1 + (k + 1) % 3] * v[(k + 2) % 3] - q[1 + (k + 2) % 3] * v[(k + 1) % 3]);
    }
    for (k = 0; k < 3; k++) {
        out[k] = v[k] + q[0] * t[k] + q[1 + (k + 1) % 3] * t[(k + 2) % 3] -
                 q[1 + (k + 2) % 3] * t[(k + 1) % 3];
    }
}

/* the quaternion of the turn a after the turn b; out may be a or b */
static inline void turn_after(const double a[4], const double b[4], double out[4])
{
    double q[4];
    int k;
    q[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    for (k = 0; k < 3; k++) {
        q[1 + k] = a[0] * b[1 + k] + b[0] * a[1 + k] + a[1 + (k + 1) % 3] * b[1 + (k + 2) % 3] -
                   a[1 + (k + 2) % 3] * b[1 + (k + 1) % 3];
    }
    memcpy(out, q, sizeof q);
}

/* the shortest turn that takes the unit vector a to the unit vector b; for opposites, some half turn */
static inline void turn_between(const double a[3], const double b[3], double q[4])
{
    int k;
    for (k = 0; k < 3; k++) {
        q[1 + k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    }
    q[0] = 1 + a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    if (q[0] < 1e-12) {
        q[0] = q[3] = 0;
        q[1] = fabs(a[0]) > fabs(a[2]) ? -a[1] : 0;
        q[2] = fabs(a[0]) > fabs(a[2]) ? a[0] : -a[2];
        q[3] = fabs(a[0]) > fabs(a[2]) ? 0 : a[1];
    }
    normalise(q, 4);
}

static inline void to_real(const double *from, int n, ecp_real *to)
{
    int k;
    for (k = 0; k < n; k++) to[k] = (ecp_real)from[k];
}

/* ---- solids */

static inline void solid_add(solid *b, const ecp_shape *shape, double x, double y, double z,
                             const double *turn)
{
    const double none[4] = {1, 0, 0, 0};
    b->shape[b->parts] = *shape;
    b->at[b->parts][0] = x;
    b->at[b->parts][1] = y;
    b->at[b->parts][2] = z;
    to_real(turn ? turn : none, 4, b->turn[b->parts++]);
}

/* moves the origin to the centre of mass */
static inline void solid_close(solid *b)
{
    ecp_mass sum, part;
    int i, k;
    memset(&sum, 0, sizeof sum);
    for (i = 0; i < b->parts; i++) {
        ecp_real at[3];
        to_real(b->at[i], 3, at);
        ecp_shape_mass(b->shape + i, 1, &part);
        ecp_mass_add(&sum, &part, at, b->turn[i]);
    }
    for (i = 0; i < b->parts; i++) {
        for (k = 0; k < 3; k++) b->at[i][k] -= (double)sum.centre[k];
    }
    for (k = 0; k < 9; k++) b->inertia[k] = (double)(sum.inertia[k] / sum.mass);
}

/* how far the solid, turned by q, reaches along n from its centre of mass, and where */
static inline double solid_reach(const solid *b, const double q[4], const double n[3],
                                 double point[3])
{
    double best = -1e300;
    int i, k;
    for (i = 0; i < b->parts; i++) {
        double both[4], local[3], back[4], p[3], along, turn[4];
        ecp_real m[3], at[3];
        for (k = 0; k < 4; k++) turn[k] = (double)b->turn[i][k];
        turn_after(q, turn, both);
        for (k = 0; k < 4; k++) back[k] = k ? -both[k] : both[k];
        turned(back, n, local);
        to_real(local, 3, m);
        b->shape[i].cls->support(b->shape + i, m, 0, at);
        for (k = 0; k < 3; k++) local[k] = (double)at[k];
        turned(turn, local, p);
        for (k = 0; k < 3; k++) local[k] = p[k] + b->at[i][k];
        turned(q, local, p);
        along = n[0] * p[0] + n[1] * p[1] + n[2] * p[2];
        if (along <= best) continue;
        best = along;
        memcpy(point, p, sizeof p);
    }
    return best;
}

static inline void solid_box(solid *b, double x, double y, double z)
{
    ecp_real half[3];
    ecp_shape shape;
    memset(b, 0, sizeof *b);
    half[0] = (ecp_real)x;
    half[1] = (ecp_real)y;
    half[2] = (ecp_real)z;
    must(ecp_shape_box(&shape, half));
    solid_add(b, &shape, 0, 0, 0, NULL);
    solid_close(b);
}

/* a ball, capsule or cylinder about the z axis, or a frustum if `top` is not the radius */
static inline void solid_round(solid *b, ecp_shape_kind kind, double radius, double top,
                               double half)
{
    ecp_real r = (ecp_real)radius, h = (ecp_real)half;
    ecp_shape shape;
    memset(b, 0, sizeof *b);
    if (kind == ECP_SPHERE) must(ecp_shape_sphere(&shape, r));
    if (kind == ECP_CAPSULE) must(ecp_shape_capsule(&shape, r, h));
    if (kind == ECP_CYLINDER) must(ecp_shape_cylinder(&shape, r, h));
    if (kind == ECP_FRUSTUM) must(ecp_shape_frustum(&shape, r, (ecp_real)top, h));
    solid_add(b, &shape, 0, 0, 0, NULL);
    solid_close(b);
}

/* a polytope from rows (normal of any length, offset along the unit normal) */
static inline void solid_hull(scene *s, solid *b, double (*rows)[4], int count)
{
    ecp_real *planes = s->store + s->stored, *vertices = planes + 4 * count;
    ecp_shape shape;
    int i;
    memset(b, 0, sizeof *b);
    if (s->stored + 10 * count > (int)(sizeof s->store / sizeof s->store[0])) {
        must(ECP_CAPACITY);
    }
    for (i = 0; i < count; i++) {
        normalise(rows[i], 3);
        to_real(rows[i], 4, planes + 4 * i);
    }
    must(ecp_shape_polytope(&shape, planes, count, vertices, 2 * count));
    s->stored += 10 * count;
    solid_add(b, &shape, 0, 0, 0, NULL);
    solid_close(b);
}

/* ---- worlds */

static inline uint64_t scene_seed(const char *name, int number)
{
    uint64_t hash = UINT64_C(14695981039346656037);
    for (; *name; name++) hash = (hash ^ (uint64_t)*name) * UINT64_C(1099511628211);
    return (hash ^ (uint64_t)number) * UINT64_C(1099511628211) | 1;
}

/* ecp_world_desc.advance_order of the worlds to come */
static int scene_advance_order = 0;

/* an empty world with room for exactly this, and gravity g downwards */
static inline void scene_open(scene *s, int bodies, int shapes, int patches, int inequalities,
                              double g)
{
    ecp_world_desc d = ecp_world_desc_default();
    size_t bytes;
    void *mem;
    d.max_bodies = bodies;
    d.max_shapes = shapes;
    d.max_patches = patches;
    d.max_inequalities = inequalities;
    d.advance_order = scene_advance_order;
    d.gravity[2] = (ecp_real)-g;
    s->g[0] = s->g[1] = 0;
    s->g[2] = -g;
    bytes = ecp_world_memsize(&d);
    mem = malloc(bytes);
    if (bytes == 0 || !mem) {
        fprintf(stderr, "no memory for %d bodies\n", bodies);
        exit(2);
    }
    must(ecp_world_init(&s->world, &d, mem, bytes));
    s->material = ecp_material_default();
}

static inline void scene_close(scene *s) { free(s->world); }

static inline void friction(scene *s, double mu, double e_r)
{
    s->material.mu = (ecp_real)mu;
    s->material.e_r = (ecp_real)e_r;
}

/* a static half-space whose surface passes through this point */
static inline int ground(scene *s, double nx, double ny, double nz, const double *point)
{
    ecp_body_desc d = ecp_body_desc_default();
    double n[3];
    ecp_real normal[3];
    ecp_shape shape;
    int body;
    n[0] = nx;
    n[1] = ny;
    n[2] = nz;
    to_real(n, 3, normal);
    d.kind = ECP_STATIC;
    if (point) to_real(point, 3, d.position);
    must(ecp_body_add(s->world, &d, &body));
    must(ecp_shape_half_space(&shape, normal, 0));
    must(ecp_body_add_shape(s->world, body, &shape, NULL, NULL, &s->material, NULL));
    return body;
}

/* Adds a solid of this mass; NULL: no turn, at rest. The body's description goes to *out. */
static inline int body_add(scene *s, const solid *b, double mass, const double x[3],
                           const double *q, const double *v, const double *w, ecp_body_desc *out)
{
    ecp_body_desc d = ecp_body_desc_default();
    int body, i, k;
    d.kind = ECP_DYNAMIC;
    d.mass = (ecp_real)mass;
    for (k = 0; k < 9; k++) d.inertia[k] = (ecp_real)(mass * b->inertia[k]);
    to_real(x, 3, d.position);
    if (q) to_real(q, 4, d.rotation);
    if (v) to_real(v, 3, d.velocity);
    if (w) to_real(w, 3, d.angular_velocity);
    must(ecp_body_add(s->world, &d, &body));
    for (i = 0; i < b->parts; i++) {
        ecp_real at[3];
        to_real(b->at[i], 3, at);
        must(ecp_body_add_shape(s->world, body, b->shape + i, at, b->turn[i], &s->material, NULL));
    }
    if (out) *out = d;
    return body;
}
