/* Figure 2 of the paper: the ways in which a body touches a plane. A ball, a lying and a standing
   cylinder, and tables of two and three legs slide a little and come to rest: contact in a point, on
   a line, on a surface, on two patches and on three. Then a box falls on a vertex and passes through
   all of them. One model and one solver for all: nothing below tells the library what to expect.
   Writes contact_modes.csv.

       cc -O2 -I. examples/contact_modes.c -o contact_modes -lm && ./contact_modes */

#define ECPSIM_IMPLEMENTATION
#include "ecpsim.h"
#include "table.h"

enum { BODY = 1 };
static const double h = 0.01;
static FILE *csv;

/* What a shape touches the ground with, found by its support function: its lowest points as seen
   from eight directions tilted by 1e-6 coincide, or lie on a line, or span a surface. */
static const char *touching_set(const ecp_world *world, int shape)
{
    double x[8][3], length = 0, area = 0;
    for (int i = 0; i < 8; i++) {
        const double angle = i * acos(-1.0) / 4 + 0.1;
        const double n[3] = {1e-6 * cos(angle), 1e-6 * sin(angle), -1};
        farthest(world, shape, n, x[i]);
    }
    for (int i = 0; i < 8; i++) {
        for (int j = 0; j < 8; j++) {
            double a[2] = {x[i][0] - x[0][0], x[i][1] - x[0][1]};
            double b[2] = {x[j][0] - x[0][0], x[j][1] - x[0][1]};
            length = fmax(length, sqrt(a[0] * a[0] + a[1] * a[1]));
            area = fmax(area, fabs(a[0] * b[1] - a[1] * b[0]));
        }
    }
    return length < 1e-3 ? "point" : area < 1e-5 ? "line" : "surface";
}

/* x as it is printed with five digits: no minus sign before a zero. */
static double shown(double x) { return fabs(x) < 5e-6 ? 0 : x; }

/* Prints the contacts of the last step that carry load. */
static void print_contacts(const char *name, const scene *s, double t)
{
    static const char *const modes[] = {"apart", "stick", "slip"};
    for (int i = 0; i < ecp_contact_count(s->world); i++) {
        ecp_contact c;
        must(ecp_contact_get(s->world, i, &c));
        if (!(c.p_n > 0)) continue;
        printf("contact_modes: %-14s t=%.2f shape=%d %-7s %-5s ecp=(%8.5f,%8.5f,%8.5f) gap=%8.1e "
               "p_n=%.5f p_t=%8.5f p_o=%8.5f p_r=%8.5f sigma=%.5f\n",
               name, t, c.shape_a, touching_set(s->world, c.shape_a), modes[c.mode],
               shown(c.point_a[0]), shown(c.point_a[1]), shown(c.point_a[2]), c.gap, c.p_n,
               shown(c.p_t), shown(c.p_o), shown(c.p_r), c.sigma);
    }
}

/* Runs a scene; prints the contacts after the first step and the last or, if every_change is set,
   whenever something else touches the ground than before. */
static void run(const char *name, scene *s, int steps, int every_change)
{
    char now[80] = "", last[80];
    for (int k = 1; k <= steps; k++) {
        ecp_real x[3], q[4];
        scene_step(s, h, NULL);
        must(ecp_body_get_state(s->world, BODY, x, q, NULL, NULL));
        strcpy(last, now);
        strcpy(now, "");
        for (int shape = 1; shape < ecp_world_shape_count(s->world); shape++) {
            ecp_contact c;
            if (!ground_contact(s->world, shape, &c) || !(c.p_n > 0)) continue;
            strcat(now, " ");
            strcat(now, touching_set(s->world, shape));
        }
        if (every_change ? strcmp(now, last) != 0 : k == 1 || k == steps) {
            print_contacts(name, s, k * h);
        }
        fprintf(csv, "%s,%.2f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%s,%.3e,%.3e\n", name, k * h, x[0],
                x[1], x[2], q[0], q[1], q[2], q[3], now + (*now != 0), s->separation, s->printed);
    }
    printf("contact_modes: %-14s max_penetration_m=%.3e\n", name, scene_penetration(s));
    scene_close(s);
}

/* A scene with one body of this shape and the density of wood. */
static void open_with(scene *s, const ecp_shape *shape, double height, const ecp_real *rotation)
{
    ecp_material material = table_material();
    ecp_body_desc body = ecp_body_desc_default();
    ecp_mass mass;
    material.e_r = 0.01;
    ecp_shape_mass(shape, 500, &mass);
    body.mass = mass.mass;
    memcpy(body.inertia, mass.inertia, sizeof body.inertia);
    if (rotation) memcpy(body.rotation, rotation, sizeof body.rotation);
    body.position[2] = height;
    body.velocity[0] = 0.2;
    scene_open(s);
    must(ecp_body_add(s->world, &body, NULL));
    must(ecp_body_add_shape(s->world, BODY, shape, NULL, NULL, &material, NULL));
}

int main(void)
{
    const double v0[3] = {0.2, 0.1, 0}, w0[3] = {0, 0, 0};
    const ecp_real half[3] = {0.2, 0.15, 0.1};
    const ecp_real lying[4] = {1, 1, 0, 0}, tilted[4] = {1, 0.3, 0.2, 0.1};
    ecp_shape ball, cylinder, box;
    scene s;
    must(ecp_shape_sphere(&ball, 0.1));
    must(ecp_shape_cylinder(&cylinder, 0.1, 0.2));
    must(ecp_shape_box(&box, half));
    csv = fopen("contact_modes.csv", "w");
    if (!csv) return 1;
    fprintf(csv, "body,t,x,y,z,qw,qx,qy,qz,touching,separation,printed\n");
    open_with(&s, &ball, 0.1, NULL);
    run("ball", &s, 50, 0);
    open_with(&s, &cylinder, 0.1, lying);
    run("lying_cylinder", &s, 50, 0);
    open_with(&s, &cylinder, 0.2, NULL);
    run("cylinder", &s, 50, 0);
    for (int legs = 2; legs <= 3; legs++) {
        scene_open(&s);
        table_add(s.world, legs, 1, v0, w0);
        run(legs == 2 ? "two_legs" : "three_legs", &s, 50, 0);
    }
    open_with(&s, &box, 0.5, tilted);
    run("box", &s, 200, 1);
    fclose(csv);
    return 0;
}
