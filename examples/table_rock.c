/* Example 2 of the paper: the table slides along y, an angular impulse tilts it onto its front leg
   (A3), and it rocks back. Five runs from different guesses for the contact points: the points
   differ as long as a leg stands flat, the motion does not, and when A3 touches in a point that
   point is unique. Done for the inertia of the table and for three times that, with which it rocks
   on to the legs A1 and A2. Writes table_rock.csv and table_rock_x3.csv.

       cc -O2 -I. examples/table_rock.c -o table_rock -lm && ./table_rock */

#define ECPSIM_IMPLEMENTATION
#include "ecpsim.h"
#include "table.h"

enum { TABLE = 1, RUNS = 5, STEPS = 300, IMPULSE_STEP = 76, A1 = 0, A2 = 1, A3 = 2 };
static const double h = 0.01; /* step 76 starts at t = 0.75 s */

/* One step of one run. */
typedef struct frame {
    double pose[7];   /* position (m) and quaternion of the table */
    double tilt;      /* of its axis from the vertical, degrees */
    double ecp[3][3]; /* equivalent contact points of the legs; in the air, their lowest points */
    int touching;     /* bit i: leg i carries load */
} frame;

static frame frames[RUNS][STEPS + 1];

static void record(const scene *s, int first_leg, frame *f)
{
    const double down[3] = {0, 0, -1};
    ecp_real x[3], q[4];
    ecp_contact c;
    must(ecp_body_get_state(s->world, TABLE, x, q, NULL, NULL));
    for (int k = 0; k < 3; k++) f->pose[k] = (double)x[k];
    for (int k = 0; k < 4; k++) f->pose[3 + k] = (double)q[k];
    f->tilt = 2 * asin(sqrt((double)(q[1] * q[1] + q[2] * q[2]))) * 180 / acos(-1.0);
    f->touching = 0;
    for (int leg = 0; leg < 3; leg++) {
        farthest(s->world, first_leg + leg, down, f->ecp[leg]);
        if (!ground_contact(s->world, first_leg + leg, &c) || !(c.p_n > 0)) continue;
        f->touching |= 1 << leg;
        for (int k = 0; k < 3; k++) f->ecp[leg][k] = (double)c.point_a[k];
    }
}

/* Slides, is hit, rocks, comes to rest. Returns the deepest penetration. */
static double simulate(int run, double inertia_scale, FILE *csv)
{
    /* first guesses: the centres of the soles, or 0.05 m off in a direction that turns by a third of
       a circle from leg to leg */
    const double turn = 2 * acos(-1.0), off = run == 0 ? 0 : 0.05;
    const double v0[3] = {0, 1, 0}, w0[3] = {0, 0, 0};
    const ecp_real hit[3] = {-5, 0, 0}; /* N m s */
    ecp_options options = ecp_options_default();
    scene s;
    scene_open(&s);
    int first_leg = table_add(s.world, 3, inertia_scale, v0, w0);
    options.rule = ECP_NEAREST; /* to the guess: this is what makes the runs differ */
    for (int leg = 0; leg < 3; leg++) {
        double axis[2], angle = turn * (0.07 + run / 4.0 + leg / 3.0);
        table_leg_axis(3, leg, axis);
        ecp_real point[3] = {axis[0] + off * cos(angle), axis[1] + off * sin(angle), 0};
        must(ecp_guess_ecp(s.world, first_leg + leg, 0, point));
    }
    record(&s, first_leg, &frames[run][0]);
    for (int k = 1; k <= STEPS; k++) {
        frame *f = &frames[run][k];
        if (k == IMPULSE_STEP) must(ecp_body_apply_angular_impulse(s.world, TABLE, hit));
        scene_step(&s, h, &options);
        record(&s, first_leg, f);
        fprintf(csv, "%d,%.2f,%.12f,%.12f,%.12f,%.6f,%d", run, k * h, f->pose[0], f->pose[1],
                f->pose[2], f->tilt, f->touching);
        for (int leg = 0; leg < 3; leg++) {
            fprintf(csv, ",%.9f,%.9f", f->ecp[leg][0], f->ecp[leg][1]);
        }
        fprintf(csv, ",%.3e,%.3e\n", s.separation, s.printed);
    }
    double penetration = scene_penetration(&s);
    scene_close(&s);
    return penetration;
}

/* The largest difference between two runs of any of n numbers. */
static double spread(int n, const double *a, const double *b)
{
    double worst = 0;
    for (int i = 0; i < n; i++) worst = fmax(worst, fabs(a[i] - b[i]));
    return worst;
}

/* The first step from `from` on in which these legs, and maybe others, carry load. */
static int touch_step(int from, int legs)
{
    while (from < STEPS && (frames[0][from].touching & legs) != legs) from++;
    return from;
}

static double largest_tilt(int from, int to)
{
    double tilt = 0;
    for (int k = from; k < to; k++) tilt = fmax(tilt, frames[0][k].tilt);
    return tilt;
}

static void show(const char *name, double inertia_scale, const char *file, int rocks_on)
{
    double state = 0, sliding = 0, point = 0, penetration = 0;
    FILE *csv = fopen(file, "w");
    if (!csv) exit(1);
    fprintf(csv, "run,t,x,y,z,tilt,touching,ecp1_x,ecp1_y,ecp2_x,ecp2_y,ecp3_x,ecp3_y,"
                 "separation,printed\n");
    for (int run = 0; run < RUNS; run++) {
        penetration = fmax(penetration, simulate(run, inertia_scale, csv));
    }
    fclose(csv);
    for (int k = 1; k <= STEPS; k++) {
        for (int pair = 0; pair < RUNS * RUNS; pair++) {
            const frame *a = &frames[pair / RUNS][k], *b = &frames[pair % RUNS][k];
            state = fmax(state, spread(7, a->pose, b->pose));
            if (k < IMPULSE_STEP && (a->touching & b->touching) == 7) {
                sliding = fmax(sliding, spread(9, a->ecp[0], b->ecp[0]));
            }
            if (k >= IMPULSE_STEP && a->touching == 1 << A3 && b->touching == 1 << A3) {
                point = fmax(point, spread(3, a->ecp[A3], b->ecp[A3]));
            }
        }
    }
    int back = touch_step(IMPULSE_STEP, 1 << A1 | 1 << A2);
    printf("%s: runs=%d final_y_m=%.12f max_tilt_deg=%.4f touch_s=%.3f", name, RUNS,
           frames[0][STEPS].pose[1], largest_tilt(0, STEPS), back * h);
    if (rocks_on) {
        int front = touch_step(back, 1 << A3);
        printf(" tilt_back_deg=%.4f touch_a3_s=%.3f", largest_tilt(back, front), front * h);
    }
    printf(" state_spread_m=%.3e ecp_spread_sliding_m=%.3e ecp_spread_point_m=%.3e "
           "max_penetration_m=%.3e\n",
           state, sliding, point, penetration);
}

int main(void)
{
    show("example2", 1, "table_rock.csv", 0);
    show("example2_x3_inertia", 3, "table_rock_x3.csv", 1);
    return 0;
}
