/* What ECPSIM_NO_PAIRS and ECPSIM_FALLBACKS=0 do, to be compiled with both: balls fall on the ground and
   pass through each other, as the manual says; fallbacks that are not there can not be asked for. */
#define ECPSIM_IMPLEMENTATION
#include "../ecpsim.h"

#include <stdio.h>

static union {
    double align;
    unsigned char bytes[200000];
} memory __attribute__((aligned(8)));

static int failed;

static void check(int ok, const char *what)
{
    if (ok) return;
    failed = 1;
    printf("failed: %s\n", what);
}

int main(void)
{
    const ecp_real up[3] = {0, 0, 1};
    ecp_world_desc d = ecp_world_desc_default();
    ecp_body_desc b = ecp_body_desc_default();
    ecp_options o = ecp_options_default();
    ecp_report r;
    ecp_world *w;
    ecp_shape s;
    ecp_real x[3], above[3];
    int i;
    d.max_bodies = 3;
    d.max_shapes = 3;
    d.max_patches = 3;
    d.max_inequalities = 1;
    check(ecp_world_init(&w, &d, memory.bytes, sizeof memory) == ECP_OK, "a world");
    b.kind = ECP_STATIC;
    ecp_body_add(w, &b, NULL);
    ecp_shape_half_space(&s, up, 0);
    ecp_body_add_shape(w, 0, &s, NULL, NULL, NULL, NULL);
    b.kind = ECP_DYNAMIC;
    ecp_shape_sphere(&s, (ecp_real)0.5);
    for (i = 1; i < 3; i++) {
        b.position[2] = (ecp_real)(0.5 + 2 * (i - 1));
        ecp_body_add(w, &b, NULL);
        ecp_body_add_shape(w, i, &s, NULL, NULL, NULL, NULL);
    }
    check(o.fallbacks == 0, "no fallback by default");
    o.fallbacks = ECP_FALLBACK_GEOMETRIC;
    check(ecp_step(w, (ecp_real)0.01, &o, &r) == ECP_BAD_OPTION, "none to be asked for");
    for (i = 0; i < 200; i++) {
        check(ecp_step(w, (ecp_real)0.01, NULL, &r) == ECP_OK, "a step");
        check(r.fallbacks == 0 && r.patches_kept <= 2, "patches with the ground alone");
    }
    ecp_body_get_state(w, 1, x, NULL, NULL, NULL);
    ecp_body_get_state(w, 2, above, NULL, NULL, NULL);
    check(x[2] > (ecp_real)0.4999 && x[2] < (ecp_real)0.5001, "the lower ball rests");
    check(above[2] > (ecp_real)0.4999 && above[2] < (ecp_real)0.5001, "and the upper one in it");
    return failed;
}
