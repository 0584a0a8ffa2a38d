/* Figure 1 of the paper: a robot pushes a three-legged stool. The robot's finger is a kinematic
   sphere that moves along x at constant speed and then stops; it pushes a leg off the stool's
   centre, so the stool slides and turns, and it stops when the finger does. Writes push_stool.csv.

       cc -O2 -I. examples/push_stool.c -o push_stool -lm && ./push_stool */

#define ECPSIM_IMPLEMENTATION
#include "ecpsim.h"
#include "table.h"

enum { STOOL = 1, FINGER = 2, STEPS = 400, STOP_STEP = 300 };
static const double h = 0.01, speed = 0.2, radius = 0.05; /* s, m/s, m */

/* Adds the finger a centimetre short of the leg A1, on the line of its axis, at mid-height. */
static int add_finger(ecp_world *world)
{
    ecp_body_desc finger = ecp_body_desc_default();
    ecp_material rubber = ecp_material_default();
    ecp_shape ball;
    double leg[2];
    int shape;
    table_leg_axis(3, 0, leg);
    finger.kind = ECP_KINEMATIC;
    finger.position[0] = leg[0] - TABLE_LEG_RADIUS - radius - 0.01;
    finger.position[1] = leg[1];
    finger.position[2] = TABLE_LEG_LENGTH / 2;
    finger.velocity[0] = speed;
    rubber.mu = 0.8;
    must(ecp_shape_sphere(&ball, radius));
    must(ecp_body_add(world, &finger, NULL));
    must(ecp_body_add_shape(world, FINGER, &ball, NULL, NULL, &rubber, &shape));
    return shape;
}

/* The normal impulse of the finger on the stool. */
static double push(const ecp_world *world, int finger_shape)
{
    double sum = 0;
    for (int i = 0; i < ecp_contact_count(world); i++) {
        ecp_contact c;
        must(ecp_contact_get(world, i, &c));
        if (c.shape_a == finger_shape || c.shape_b == finger_shape) sum += c.p_n;
    }
    return sum;
}

int main(void)
{
    const double rest[3] = {0, 0, 0};
    const ecp_real halt[3] = {0, 0, 0};
    double turned = 0, touched = 0, stopped = 0;
    ecp_real x[3], q[4], v[3], w[3], finger[3];
    scene s;
    FILE *csv = fopen("push_stool.csv", "w");
    if (!csv) return 1;
    fprintf(csv, "t,x,y,z,angle_deg,vx,vy,wz,finger_x,finger_y,push,separation,printed\n");
    scene_open(&s);
    table_add(s.world, 3, 1, rest, rest);
    int finger_shape = add_finger(s.world);

    for (int k = 1; k <= STEPS; k++) {
        if (k == STOP_STEP) must(ecp_body_set_state(s.world, FINGER, NULL, NULL, halt, NULL));
        scene_step(&s, h, NULL);
        must(ecp_body_get_state(s.world, STOOL, x, q, v, w));
        must(ecp_body_get_state(s.world, FINGER, finger, NULL, NULL, NULL));
        double p = push(s.world, finger_shape), pi = acos(-1.0);
        double pace = sqrt(v[0] * v[0] + v[1] * v[1]) + TABLE_LEG_AXIS * fabs(w[2]);
        turned = 2 * atan2(q[3], q[0]) * 180 / pi;
        if (p > 0 && touched == 0) touched = k * h;
        if (pace > 1e-9) stopped = (k + 1) * h; /* not yet: at the next step's end, if at all */
        fprintf(csv, "%.2f,%.12f,%.12f,%.12f,%.9f,%.9f,%.9f,%.9f,%.6f,%.6f,%.6e,%.3e,%.3e\n", k * h,
                x[0], x[1], x[2], turned, v[0], v[1], w[2], finger[0], finger[1], p, s.separation,
                s.printed);
    }
    printf("push_stool: x_m=%.6f y_m=%.6f z_m=%.6f turned_deg=%.4f touched_s=%.2f "
           "finger_stopped_s=%.2f stool_stopped_s=%.2f max_penetration_m=%.3e\n",
           x[0], x[1], x[2], turned, touched, (STOP_STEP - 1) * h, stopped, scene_penetration(&s));
    fclose(csv);
    scene_close(&s);
    return 0;
}
