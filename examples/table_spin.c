/* Example 3, which the paper's source holds but does not print: a table with two legs slides and
   turns. With two patches and spin the equations of a step have solutions of different motion
   (docs/model.md), so it matters which rule selects one: five runs from different guesses for the
   contact points, once with each rule. Writes table_spin.csv.

       cc -O2 -I. examples/table_spin.c -o table_spin -lm && ./table_spin */

#define ECPSIM_IMPLEMENTATION
#include "ecpsim.h"
#include "table.h"

enum { TABLE = 1, LEGS = 2, RUNS = 5, STEPS = 500 };
static const double h = 0.01;

/* Slides to rest; writes the pose after every step to pose[STEPS][7]. */
static void simulate(int run, ecp_rule rule, double pose[][7], FILE *csv)
{
    /* where on the sole of each leg the first guess lies, from the leg's axis, m */
    static const double guess[RUNS][LEGS][2] = {{{0, 0}, {0, 0}},
                                                {{0.06, 0}, {-0.06, 0}},
                                                {{-0.06, 0}, {0.06, 0}},
                                                {{0.05, 0.05}, {0.05, -0.05}},
                                                {{0, -0.07}, {-0.04, 0.03}}};
    const double v0[3] = {4, 3, 0}, w0[3] = {0, 0, 1};
    ecp_options options = ecp_options_default();
    scene s;
    scene_open(&s);
    int first_leg = table_add(s.world, LEGS, 1, v0, w0);
    options.rule = rule;
    for (int leg = 0; leg < LEGS; leg++) {
        double axis[2];
        table_leg_axis(LEGS, leg, axis);
        ecp_real point[3] = {axis[0] + guess[run][leg][0], axis[1] + guess[run][leg][1], 0};
        must(ecp_guess_ecp(s.world, first_leg + leg, 0, point));
    }
    for (int k = 0; k < STEPS; k++) {
        scene_step(&s, h, &options);
        must(ecp_body_get_state(s.world, TABLE, pose[k], pose[k] + 3, NULL, NULL));
        fprintf(csv, "%s,%d,%.2f,%.12f,%.12f,%.12f,%.12f",
                rule == ECP_CENTRED ? "centred" : "nearest", run, (k + 1) * h, pose[k][0],
                pose[k][1], pose[k][2], 2 * atan2(pose[k][6], pose[k][3]));
        for (int leg = 0; leg < LEGS; leg++) {
            ecp_contact c;
            int found = ground_contact(s.world, first_leg + leg, &c);
            fprintf(csv, ",%.9e,%.9f,%.9f", found ? c.p_o : 0,
                    found ? c.point_a[0] - pose[k][0] : 0, found ? c.point_a[1] - pose[k][1] : 0);
        }
        fprintf(csv, ",%.3e,%.3e\n", s.separation, s.printed);
    }
    scene_close(&s);
}

/* The largest difference between the first run and the others of any pose component at any step. */
static double state_spread(ecp_rule rule, FILE *csv)
{
    static double pose[2][STEPS][7];
    double spread = 0;
    for (int run = 0; run < RUNS; run++) {
        simulate(run, rule, pose[run > 0], csv);
        for (int i = 0; run > 0 && i < STEPS * 7; i++) {
            spread = fmax(spread, fabs(pose[1][i / 7][i % 7] - pose[0][i / 7][i % 7]));
        }
    }
    return spread;
}

int main(void)
{
    FILE *csv = fopen("table_spin.csv", "w");
    if (!csv) return 1;
    fprintf(
        csv,
        "rule,run,t,x,y,z,angle,ecp1_po,ecp1_x,ecp1_y,ecp2_po,ecp2_x,ecp2_y,separation,printed\n");
    double centred = state_spread(ECP_CENTRED, csv);
    double nearest = state_spread(ECP_NEAREST, csv);
    printf("example3: runs=%d rule=centred state_spread=%.3e rule=nearest state_spread=%.3e\n",
           RUNS, centred, nearest);
    fclose(csv);
    return 0;
}
