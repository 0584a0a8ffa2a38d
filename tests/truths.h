/* Motions that are known: closed forms, and ordinary differential equations of one body with the
   contact that it has, integrated by the classical method of Runge and Kutta in long double. None of
   it knows the library or its time step. For order.c and the report. */

#ifndef TRUTHS_H
#define TRUTHS_H

#include <math.h>
#include <string.h>

static const long double truth_g = 9.8L;

enum { TRUTH_UNKNOWNS = 7 };

typedef void (*truth_rate)(const long double *y, long double *d);

static void truth_integrate(truth_rate rate, int n, long double *y, long double duration, int steps)
{
    long double k[4][TRUTH_UNKNOWNS], z[TRUTH_UNKNOWNS], h = duration / steps;
    int i, j, s;
    for (i = 0; i < steps; i++) {
        for (s = 0; s < 4; s++) {
            for (j = 0; j < n; j++) {
                z[j] = y[j] + (s == 0 ? 0 : (s == 3 ? h : h / 2) * k[s - 1][j]);
            }
            rate(z, k[s]);
        }
        for (j = 0; j < n; j++) y[j] += h / 6 * (k[0][j] + 2 * k[1][j] + 2 * k[2][j] + k[3][j]);
    }
}

/* ---- T2: the table of Example 2, in the plane of y and z: it slides, is hit at 0.75 s by an angular
   impulse of -5 about x, pivots on the outermost point of a leg, which slips and may stick, falls
   back on all legs at once, slides on and stops. The angle is that about x. */

static const long double truth_t2_m = 5, truth_t2_I = 0.3327L, truth_t2_mu = 0.12L,
                         truth_t2_H = 0.3L, truth_t2_a = 0.4L;
static const long double truth_t2_kick = 0.75L;

typedef struct truth_t2_state {
    long double y[4]; /* of the centre: y and its rate; the angle and its rate */
    long double t;
    long double landed; /* when; 0: not yet */
    int slip;           /* which way the point goes: 1, -1, 0 sticks */
    int phases;
} truth_t2_state;

static int truth_t2_way; /* that of the rate below */

/* from the centre to the point that carries */
static void truth_t2_arm(long double angle, long double r[2])
{
    r[0] = truth_t2_a * cosl(angle) + truth_t2_H * sinl(angle);
    r[1] = truth_t2_a * sinl(angle) - truth_t2_H * cosl(angle);
}

/* velocity of that point */
static long double truth_t2_slip(const long double *y)
{
    long double r[2];
    truth_t2_arm(y[2], r);
    return y[1] - r[1] * y[3];
}

/* Load and friction, and the rates. The point keeps its height; it slips one way, or stays. */
static void truth_t2_forces(const long double *y, int way, long double force[2], long double *d)
{
    long double r[2], w2 = y[3] * y[3], N, F;
    truth_t2_arm(y[2], r);
    if (way) {
        N = (truth_t2_m * truth_g + truth_t2_m * r[1] * w2) /
            (1 + truth_t2_m * r[0] * (r[0] + way * truth_t2_mu * r[1]) / truth_t2_I);
        F = -way * truth_t2_mu * N;
    } else {
        /* both accelerations of the point are zero: two equations for N and F */
        long double a = 1 / truth_t2_m + r[0] * r[0] / truth_t2_I, b = -r[0] * r[1] / truth_t2_I;
        long double c = 1 / truth_t2_m + r[1] * r[1] / truth_t2_I, p = truth_g + r[1] * w2,
                    q = r[0] * w2;
        N = (p * c - b * q) / (a * c - b * b);
        F = (a * q - b * p) / (a * c - b * b);
    }
    force[0] = N;
    force[1] = F;
    d[0] = y[1];
    d[1] = F / truth_t2_m;
    d[2] = y[3];
    d[3] = (r[0] * N - r[1] * F) / truth_t2_I;
}

static void truth_t2_rate(const long double *y, long double *d)
{
    long double force[2];
    truth_t2_forces(y, truth_t2_way, force, d);
}

/* where a phase ends, one of these is below zero: the tilt, slip that goes on, friction to spare */
static long double truth_t2_left(const truth_t2_state *s)
{
    long double force[2], d[4], left = -s->y[2], more;
    truth_t2_forces(s->y, s->slip, force, d);
    more = s->slip ? s->slip * truth_t2_slip(s->y) : truth_t2_mu * force[0] - fabsl(force[1]);
    return more < left ? more : left;
}

/* which way the point goes on where its slip has come to an end, or friction does not hold it */
static int truth_t2_next(const truth_t2_state *s)
{
    long double force[2], d[4];
    truth_t2_forces(s->y, 0, force, d);
    if (s->slip && fabsl(force[1]) <= truth_t2_mu * force[0]) return 0;
    return force[1] > 0 ? -1 : 1;
}

/* on all legs: slides to a stop */
static void truth_t2_slide(truth_t2_state *s, long double duration)
{
    long double stop = fabsl(s->y[1]) / (truth_t2_mu * truth_g), sign = s->y[1] > 0 ? 1 : -1;
    if (duration > stop) duration = stop;
    s->y[0] += s->y[1] * duration - sign * truth_t2_mu * truth_g * duration * duration / 2;
    s->y[1] = stop > duration ? s->y[1] - sign * truth_t2_mu * truth_g * duration : 0;
}

/* all legs at once: no velocity of them down remains, and friction is what the impulse allows */
static void truth_t2_land(truth_t2_state *s)
{
    long double loss = truth_t2_mu * truth_t2_a * s->y[3], v = s->y[1];
    s->y[2] = s->y[3] = 0;
    s->y[1] = fabsl(v) <= loss ? 0 : v - (v > 0 ? loss : -loss);
    s->landed = s->t;
}

/* pivots until `t` or until it has landed */
static void truth_t2_pivot(truth_t2_state *s, long double t)
{
    const long double step = 5e-5L;
    while (s->t < t && s->landed <= 0) {
        long double h = t - s->t < step ? t - s->t : step, lo = 0, hi = h;
        truth_t2_state from = *s;
        int k;
        truth_t2_way = s->slip;
        truth_integrate(truth_t2_rate, 4, s->y, h, 1);
        s->t += h;
        if (truth_t2_left(s) >= 0) continue;
        for (k = 0; k < 60; k++) {
            h = (lo + hi) / 2;
            *s = from;
            truth_integrate(truth_t2_rate, 4, s->y, h, 1);
            if (truth_t2_left(s) >= 0) {
                lo = h;
            } else {
                hi = h;
            }
        }
        s->t = from.t + h;
        s->phases++;
        if (-s->y[2] < 1e-12L && s->y[3] > 0) {
            truth_t2_land(s);
        } else {
            s->slip = truth_t2_next(s);
            if (s->slip && from.slip) s->slip = -from.slip;
            /* past the end of slip, which the next step would see again */
            truth_t2_way = s->slip;
            truth_integrate(truth_t2_rate, 4, s->y, 1e-9L, 1);
            s->t += 1e-9L;
        }
    }
}

static truth_t2_state truth_t2_at(long double t)
{
    truth_t2_state s;
    memset(&s, 0, sizeof s);
    s.y[1] = 1;
    truth_t2_slide(&s, t < truth_t2_kick ? t : truth_t2_kick);
    if (t > truth_t2_kick) {
        /* the point slips to -y after the impulse, against a friction of mu times the load's */
        s.t = truth_t2_kick;
        s.y[3] =
            -5 / (truth_t2_I + truth_t2_m * truth_t2_a * (truth_t2_a + truth_t2_mu * truth_t2_H));
        s.y[1] -= truth_t2_mu * truth_t2_a * s.y[3];
        s.slip = -1;
        truth_t2_pivot(&s, t);
        if (s.landed > 0) truth_t2_slide(&s, t - s.landed);
    }
    return s;
}

/* ---- T3: one patch spins and slides: m = 3, I = 0.125, H = 0.25, mu = 0.22, e_r = 0.1. From the
   velocity (1, 0) and the spin 5: velocity, spin, position, angle */

static void truth_t3_rate(const long double *y, long double *d)
{
    const long double m = 3, I = 0.125L, H = 0.25L, mu = 0.22L, er = 0.1L;
    long double A = y[0] * y[0] + y[1] * y[1], B = er * er * y[2] * y[2];
    long double C = mu * H * y[2] * mu * H * y[2], b = A + B - C;
    long double s = sqrtl((b + sqrtl(b * b + 4 * B * C)) / 2);
    long double k = mu * m * truth_g / s, a = mu * H * y[2] / s, f = -k / (1 + a * a) / m;
    d[0] = f * (y[0] - a * y[1]);
    d[1] = f * (y[1] + a * y[0]);
    d[2] = -er * er * mu * m * truth_g * y[2] / s / I;
    d[3] = y[0];
    d[4] = y[1];
    d[5] = y[2];
}

static void truth_t3(double t, double y_out[6])
{
    long double y[6] = {1, 0, 5, 0, 0, 0};
    int k;
    truth_integrate(truth_t3_rate, 6, y, t, 3000);
    for (k = 0; k < 6; k++) y_out[k] = (double)y[k];
}

/* ---- T5: a block of half sizes 0.1 x 0.3 rocks, released at half its critical angle:
   theta'' = -p^2 sin(al - theta) about either edge, and in the impact momentum about the new edge
   leaves 1 - 3/2 sin^2(al) of the angular velocity. The angle is signed by the edge. */

static long double truth_rock_al(void) { return atan2l(0.1L, 0.3L); }

static void truth_rock_rate(const long double *y, long double *d)
{
    d[0] = y[1];
    d[1] = -3 * truth_g / (4 * sqrtl(0.1L)) * sinl(truth_rock_al() - y[0]);
}

/* the time from the release to the impact, and the angular velocity then */
static long double truth_rock_quarter(long double *rate)
{
    long double y[2], t = 0.27L;
    int k;
    y[0] = truth_rock_al() / 2;
    y[1] = 0;
    truth_integrate(truth_rock_rate, 2, y, t, 4000);
    for (k = 0; k < 8; k++) {
        long double d = -y[0] / y[1];
        truth_integrate(truth_rock_rate, 2, y, d, 10);
        t += d;
    }
    *rate = y[1];
    return t;
}

/* until the second impact */
static void truth_rock(double t, double *theta, double *rate)
{
    long double y[2], hit, quarter = truth_rock_quarter(&hit), sign = 1;
    y[0] = truth_rock_al() / 2;
    y[1] = 0;
    if (t > quarter) {
        y[0] = 0;
        y[1] = -hit * (1 - 1.5L * 0.1L);
        sign = -1;
    }
    truth_integrate(truth_rock_rate, 2, y, sign < 0 ? t - quarter : t, 4000);
    *theta = (double)(sign * y[0]);
    *rate = (double)(sign * y[1]);
}

/* ---- T7: free rotation of a body with the moments of inertia 1, 2, 3 from (0.01, 1, 0.01), nearly
   about the axis in the middle: angular velocity in the body's axes and the quaternion, by Euler's
   equations */

static void truth_t7_rate(const long double *y, long double *d)
{
    const long double *w = y, *q = y + 3;
    d[0] = -w[1] * w[2];
    d[1] = w[2] * w[0];
    d[2] = -w[0] * w[1] / 3;
    d[3] = -(q[1] * w[0] + q[2] * w[1] + q[3] * w[2]) / 2;
    d[4] = (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]) / 2;
    d[5] = (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]) / 2;
    d[6] = (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]) / 2;
}

/* q: body to world; w: in world axes */
static void truth_t7(double t, double q[4], double w[3])
{
    long double y[7] = {0.01L, 1, 0.01L, 1, 0, 0, 0}, u[3];
    int k;
    truth_integrate(truth_t7_rate, 7, y, t, 20000);
    for (k = 0; k < 4; k++) q[k] = (double)y[3 + k];
    /* w + 2 u x (u x w + q0 w), u the vector of q */
    for (k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        u[k] = y[4 + i] * y[j] - y[4 + j] * y[i] + y[3] * y[k];
    }
    for (k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        w[k] = (double)(y[k] + 2 * (y[4 + i] * u[j] - y[4 + j] * u[i]));
    }
}

/* ---- a box falls 0.5 m with a velocity of 2 across, and slides: mu = 0.2; the impact takes mu times
   its impulse of that velocity, as sliding does. The way across, and the velocity */

static void truth_landing(double t, double *way, double *v)
{
    double g = (double)truth_g, fall = sqrt(2 * 0.5 / g), slide = t - fall;
    *v = 2 - 0.2 * g * fall;
    *way = 2 * fall + *v * slide - 0.1 * g * slide * slide;
    *v -= 0.2 * g * slide;
}

#endif /* TRUTHS_H */
