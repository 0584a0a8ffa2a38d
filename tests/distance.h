/* How far apart two posed primitives are, found without the solver: Gilbert, Johnson and Keerthi's
   method on support functions, in double.

   Along any unit vector n the supports of two convex solids are apart by a number that bounds their
   distance from below, and where they overlap the largest of these numbers is the penetration with
   its sign turned. So every number here is a bound that is certain, and what is searched for is the
   best n: the reported contact normal, the normals of faces, then the method's last direction, also
   with one solid moved off a little, then small turns, because between solids that touch within
   rounding the method's directions are noise. */

typedef struct distance_solid {
    const ecp_shape *shape;
    double x[3], Q[9];
    double size; /* the reach of its body from the centre of mass; 0: a half-space */
    int body;
} distance_solid;

typedef struct distance_set {
    distance_solid *solid;
    int count;
} distance_set;

/* the worst pair of a set: shape indices, separation (negative: penetration), and that over the
   size of the smaller body */
typedef struct distance_worst {
    int a, b;
    double gap, relative;
} distance_worst;

static double distance_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* the point of the solid that is farthest along n, seen from the solid's origin */
static void distance_farthest(const distance_solid *s, const double n[3], double out[3])
{
    ecp_real local[3], at[3];
    int i, k;
    for (k = 0; k < 3; k++) {
        local[k] = (ecp_real)(s->Q[k] * n[0] + s->Q[3 + k] * n[1] + s->Q[6 + k] * n[2]);
    }
    s->shape->cls->support(s->shape, local, 0, at);
    for (i = 0; i < 3; i++) {
        out[i] = s->Q[3 * i] * (double)at[0] + s->Q[3 * i + 1] * (double)at[1] +
                 s->Q[3 * i + 2] * (double)at[2];
    }
}

/* how far a lies beyond b along the unit vector n; w: from the farthest point of b to that of a */
static double distance_along(const distance_solid *a, const distance_solid *b, const double n[3],
                             double w[3])
{
    double back[3], pa[3], pb[3];
    int k;
    for (k = 0; k < 3; k++) back[k] = -n[k];
    distance_farthest(a, back, pa);
    distance_farthest(b, n, pb);
    for (k = 0; k < 3; k++) w[k] = (a->x[k] - b->x[k]) + (pa[k] - pb[k]);
    return distance_dot(n, w);
}

/* how far a lies above the half-space b, which only its own normal bounds */
static double distance_above(const distance_solid *a, const distance_solid *b)
{
    double n[3], back[3], p[3];
    int i, k;
    for (i = 0; i < 3; i++) {
        for (k = 0, n[i] = 0; k < 3; k++) n[i] += b->Q[3 * i + k] * (double)b->shape->size[k];
        back[i] = -n[i];
    }
    distance_farthest(a, back, p);
    for (k = 0; k < 3; k++) p[k] += a->x[k] - b->x[k];
    return distance_dot(n, p) - (double)b->shape->size[3];
}

/* Weights l of the points p[0..m) whose sum is nearest to the origin on the plane through them all;
   0 if the points are dependent. Gauss on the Gram matrix of the edges from p[0]. */
static int distance_weights(double (*const p[4])[3], int m, double l[4])
{
    double edge[3][3], G[3][4];
    int i, j, k;
    for (i = 1; i < m; i++) {
        for (k = 0; k < 3; k++) edge[i - 1][k] = (*p[i])[k] - (*p[0])[k];
    }
    for (i = 0; i < m - 1; i++) {
        for (j = 0; j < m - 1; j++) G[i][j] = distance_dot(edge[i], edge[j]);
        G[i][3] = -distance_dot(edge[i], *p[0]);
    }
    for (i = 0; i < m - 1; i++) {
        if (!(G[i][i] > 1e-14 * distance_dot(edge[i], edge[i]))) return 0;
        for (j = i + 1; j < m - 1; j++) {
            double f = G[j][i] / G[i][i];
            for (k = i; k < 4; k++) G[j][k] -= f * G[i][k];
        }
    }
    for (i = m - 2, l[0] = 1; i >= 0; i--) {
        l[i + 1] = G[i][3];
        for (j = i + 1; j < m - 1; j++) l[i + 1] -= G[i][j] * l[j + 1];
        l[i + 1] /= G[i][i];
        l[0] -= l[i + 1];
    }
    return 1;
}

/* The point v of the hull of p[0..m) that is nearest to the origin, tried over all 15 faces; keeps
   the corners of its face, and returns how many. */
static int distance_nearest(double p[4][3], int m, double v[3])
{
    double best = 1e300, kept[4][3];
    int set, i, k, n = 0;
    for (set = 1; set < 1 << m; set++) {
        double(*corner[4])[3] = {NULL, NULL, NULL, NULL}, l[4] = {1, 0, 0, 0}, at[3] = {0, 0, 0};
        int corners = 0, inside = 1;
        for (i = 0; i < m; i++) {
            if (set >> i & 1) corner[corners++] = &p[i];
        }
        if (!distance_weights(corner, corners, l)) continue;
        for (i = 0; i < corners; i++) {
            if (!(l[i] >= 0)) inside = 0;
            for (k = 0; k < 3; k++) at[k] += l[i] * (*corner[i])[k];
        }
        if (!inside || !(distance_dot(at, at) < best)) continue;
        best = distance_dot(at, at);
        memcpy(v, at, sizeof at);
        for (i = 0; i < corners; i++) memcpy(kept[i], *corner[i], sizeof kept[i]);
        n = corners;
    }
    memcpy(p, kept, (size_t)n * sizeof kept[0]);
    return n;
}

/* takes n over if it gives a better bound than *best */
static void distance_try(const distance_solid *a, const distance_solid *b, const double n[3],
                         double *best, double best_n[3])
{
    double w[3], size = sqrt(distance_dot(n, n)), unit[3], gap;
    int k;
    if (!(size > 0)) return;
    for (k = 0; k < 3; k++) unit[k] = n[k] / size;
    gap = distance_along(a, b, unit, w);
    if (gap <= *best) return;
    *best = gap;
    memcpy(best_n, unit, sizeof unit);
}

/* the method; every direction that it passes is tried */
static void distance_gjk(const distance_solid *a, const distance_solid *b, double *best,
                         double best_n[3])
{
    double p[4][3], v[3], w[3], n[3], length, last = 1e300;
    double noise = 1e-15 * (double)(a->shape->radius + b->shape->radius);
    int m = 0, i, k;
    for (k = 0; k < 3; k++) v[k] = a->x[k] - b->x[k];
    for (i = 0; i < 64 && m < 4; i++) {
        length = sqrt(distance_dot(v, v));
        if (!(length > noise) || !(length < last)) return;
        if (i > 0) last = length; /* the first v is not a point of the difference */
        for (k = 0; k < 3; k++) n[k] = v[k] / length;
        distance_try(a, b, n, best, best_n);
        if (i > 0 && length - distance_along(a, b, n, w) < noise) return;
        distance_along(a, b, n, p[m]);
        m = distance_nearest(p, m + 1, v);
    }
}

/* turns n by less and less to where the bound is largest nearby, until it is above `enough` */
static void distance_refine(const distance_solid *a, const distance_solid *b, double enough,
                            double *best, double n[3])
{
    double turn = 0.03, angle = 0;
    int round, i, k;
    for (round = 0; round < 200 && turn > 1e-15 && *best < enough; round++) {
        double before = *best, centre[3], t[3], o[3], size, direction[3];
        memcpy(centre, n, sizeof centre);
        k = fabs(n[0]) < 0.6 ? 0 : fabs(n[1]) < 0.6 ? 1 : 2;
        for (i = 0; i < 3; i++) t[i] = (i == k) - n[k] * n[i];
        size = sqrt(distance_dot(t, t));
        for (i = 0; i < 3; i++) t[i] /= size;
        for (i = 0; i < 3; i++) {
            o[i] = n[(i + 1) % 3] * t[(i + 2) % 3] - n[(i + 2) % 3] * t[(i + 1) % 3];
        }
        for (i = 0; i < 8; i++, angle += 0.8) { /* not a whole turn: each round looks elsewhere */
            for (k = 0; k < 3; k++) {
                direction[k] = centre[k] + turn * (cos(angle) * t[k] + sin(angle) * o[k]);
            }
            distance_try(a, b, direction, best, n);
        }
        turn *= *best > before ? 1.5 : 0.5;
    }
}

/* the direction of the shortest way between them once a has moved along n until they are apart */
static void distance_apart(const distance_solid *a, const distance_solid *b, double *best,
                           double n[3])
{
    distance_solid moved = *a;
    double bound = -1e300, direction[3] = {0, 0, 1}, small = a->size < b->size ? a->size : b->size;
    int k;
    for (k = 0; k < 3; k++) moved.x[k] += (1e-3 * small - *best) * n[k];
    distance_gjk(&moved, b, &bound, direction);
    distance_try(a, b, direction, best, n);
}

/* Tries the normals of the faces of one of them: its gradients at its centre. Those of curved constraints are no normals
   of faces, but what they give is a bound as well, if they are not next to nothing there. */
static void distance_faces(const distance_solid *a, const distance_solid *b, int of_a, double *best,
                           double best_n[3])
{
    enum { MOST = 64 };
    const distance_solid *s = of_a ? a : b;
    ecp_real f[MOST], g[3 * MOST];
    int i, k;
    if (s->shape->inequalities > MOST) return;
    s->shape->cls->eval(s->shape, s->shape->centre, f, g);
    for (i = 0; i < s->shape->inequalities; i++) {
        double n[3];
        for (k = 0; k < 3; k++) {
            n[k] = s->Q[3 * k] * (double)g[3 * i] + s->Q[3 * k + 1] * (double)g[3 * i + 1] +
                   s->Q[3 * k + 2] * (double)g[3 * i + 2];
            if (of_a) n[k] = -n[k];
        }
        if (distance_dot(n, n) > 0.25) distance_try(a, b, n, best, best_n);
    }
}

/* the direction from j to i of their contact in the last step; 0 if there is none */
static int distance_normal(const ecp_world *world, int i, int j, double n[3])
{
    ecp_contact c;
    int at, k;
    for (at = 0; at < ecp_contact_count(world); at++) {
        if (ecp_contact_get(world, at, &c) != ECP_OK) continue;
        if (c.shape_a + c.shape_b != i + j || (c.shape_a != i && c.shape_a != j)) continue;
        for (k = 0; k < 3; k++) n[k] = (c.shape_a == i ? 1 : -1) * (double)c.normal[k];
        return 1;
    }
    return 0;
}

/* The separation of two solids, or a bound of it that is no less than `enough`. */
static double distance_pair(const distance_set *set, const ecp_world *world, int i, int j,
                            double enough)
{
    const distance_solid *a = set->solid + i, *b = set->solid + j;
    double n[3] = {0, 0, 0}, best_n[3] = {0, 0, 1}, best = -1e300, other, other_n[3] = {0, 0, 1};
    int round;
    if (a->size <= 0) return distance_above(b, a);
    if (b->size <= 0) return distance_above(a, b);
    if (distance_normal(world, i, j, n)) distance_try(a, b, n, &best, best_n);
    distance_faces(a, b, 1, &best, best_n);
    distance_faces(a, b, 0, &best, best_n);
    if (best >= enough) return best;
    distance_refine(a, b, enough, &best, best_n);
    if (best >= enough) return best;
    other = -1e300;
    distance_gjk(a, b, &other, other_n);
    for (round = 0; round < 4 && other < enough; round++) distance_apart(a, b, &other, other_n);
    if (other < enough) distance_refine(a, b, enough, &other, other_n);
    return other > best ? other : best;
}

/* the poses as they are now */
static void distance_update(distance_set *set, const ecp_world *world)
{
    int i, k;
    for (i = 0; i < set->count; i++) {
        ecp_real x[3] = {0}, Q[9] = {0};
        distance_solid *s = set->solid + i;
        ecp_shape_get(world, i, &s->shape, &s->body, x, Q);
        for (k = 0; k < 3; k++) s->x[k] = (double)x[k];
        for (k = 0; k < 9; k++) s->Q[k] = (double)Q[k];
    }
}

static distance_set distance_open(const ecp_world *world)
{
    distance_set set;
    int i, j, k;
    set.count = ecp_world_shape_count(world);
    set.solid = (distance_solid *)calloc((size_t)set.count, sizeof *set.solid);
    if (!set.solid) exit(2);
    distance_update(&set, world);
    for (i = 0; i < set.count; i++) {
        distance_solid *s = set.solid + i;
        ecp_real x[3] = {0};
        double arm = 0;
        if (s->shape->kind == ECP_HALF_SPACE) continue;
        ecp_body_get_state(world, s->body, x, NULL, NULL, NULL);
        for (k = 0; k < 3; k++) arm += (s->x[k] - (double)x[k]) * (s->x[k] - (double)x[k]);
        arm = sqrt(arm) + (double)s->shape->radius;
        for (j = 0; j < set.count; j++) {
            distance_solid *other = set.solid + j;
            if (other->body == s->body && other->size < arm) other->size = arm;
        }
    }
    return set;
}

static void distance_close(distance_set *set) { free(set->solid); }

/* can a ball about each tell that they are apart? */
static int distance_balls_apart(const distance_solid *a, const distance_solid *b)
{
    double reach = 0, d2 = 0;
    int i, k;
    if (a->size <= 0 || b->size <= 0) return 0;
    for (k = 0; k < 3; k++) {
        double d = a->x[k] - b->x[k];
        for (i = 0; i < 3; i++) {
            d += a->Q[3 * k + i] * (double)a->shape->centre[i] -
                 b->Q[3 * k + i] * (double)b->shape->centre[i];
        }
        d2 += d * d;
    }
    reach = (double)a->shape->radius + (double)b->shape->radius;
    return d2 > reach * reach;
}

/* The pair of different bodies that is nearest, or most overlapping, in relation to the smaller
   body. Bounds above -enough times that size are not improved. */
static distance_worst distance_least(distance_set *set, const ecp_world *world, double enough)
{
    distance_worst worst = {-1, -1, 1e300, 1e300};
    int i, j;
    distance_update(set, world);
    for (i = 0; i < set->count; i++) {
        for (j = i + 1; j < set->count; j++) {
            const distance_solid *a = set->solid + i, *b = set->solid + j;
            double size, gap;
            if (a->body == b->body || (a->size <= 0 && b->size <= 0)) continue;
            if (distance_balls_apart(a, b)) continue;
            size = a->size <= 0 || (b->size > 0 && b->size < a->size) ? b->size : a->size;
            gap = distance_pair(set, world, i, j, -enough * size);
            if (gap / size >= worst.relative) continue;
            worst.a = i;
            worst.b = j;
            worst.gap = gap;
            worst.relative = gap / size;
        }
    }
    return worst;
}
