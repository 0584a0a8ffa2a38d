/* What ECPSIM_NO_PAIRS and ECPSIM_FALLBACKS=0 do, to be compiled with both: balls fall on the ground
   and pass through each other, as the manual says; fallbacks that are not there can not be asked for.

   And with ECPSIM_NO_FRICTION, ECPSIM_NO_SLEEP and ECPSIM_NO_CENTRING, or with none of them: what
   these leave out can not be asked for, and a box slides on without friction. It prints the state of
   balls without friction after 200 steps, which is the same to the last bit either way. */
#define ECPSIM_IMPLEMENTATION
#include "../ecpsim.h"

#include <stdio.h>
#include <string.h>

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

/* the bodies of a world of two balls, or of a ball and a box with friction, that slide on the ground */
static ecp_world *slide(int box, ecp_real mu)
{
    const ecp_real up[3] = {0, 0, 1}, half[3] = {(ecp_real)0.5, (ecp_real)0.5, (ecp_real)0.5};
    ecp_world_desc d = ecp_world_desc_default();
    ecp_body_desc b = ecp_body_desc_default();
    ecp_material m = ecp_material_default();
    ecp_world *w;
    ecp_shape s;
    int i;
    check(ecp_world_init(&w, &d, memory.bytes, sizeof memory) == ECP_OK, "a world to slide in");
    m.mu = mu;
    b.kind = ECP_STATIC;
    ecp_body_add(w, &b, NULL);
    ecp_shape_half_space(&s, up, 0);
    ecp_body_add_shape(w, 0, &s, NULL, NULL, &m, NULL);
    b.kind = ECP_DYNAMIC;
    b.velocity[0] = 3;
    for (i = 0; i < 2; i++) {
        b.position[1] = (ecp_real)(3 * i);
        b.position[2] = (ecp_real)(0.5 + i * !box);
        ecp_body_add(w, &b, NULL);
        ecp_shape_sphere(&s, (ecp_real)0.5);
        if (box) ecp_shape_box(&s, half);
        ecp_body_add_shape(w, 1 + i, &s, NULL, NULL, &m, NULL);
    }
    for (i = 0; i < 200; i++) check(ecp_step(w, (ecp_real)0.01, NULL, NULL) == ECP_OK, "slides");
    return w;
}

/* FNV-1a of what ecp_body_get_state gives of the two */
static unsigned long hash_of(const ecp_world *w)
{
    unsigned long hash = 2166136261ul;
    ecp_real x[13];
    unsigned char bytes[sizeof x];
    size_t k;
    int i;
    for (i = 1; i < 3; i++) {
        ecp_body_get_state(w, i, x, x + 3, x + 7, x + 10);
        memcpy(bytes, x, sizeof x);
        for (k = 0; k < sizeof x; k++) hash = ((hash ^ bytes[k]) * 16777619ul) & 0xfffffffful;
    }
    return hash;
}

static void check_options(void)
{
    ecp_options o = ecp_options_default();
    ecp_world *w = slide(1, (ecp_real)0.5);
    ecp_real v[3];
    int less;
    ecp_body_get_state(w, 1, NULL, NULL, v, NULL);
#ifdef ECPSIM_NO_FRICTION
    less = 1;
#else
    less = 0;
#endif
    check(less ? v[0] > (ecp_real)2.999 : v[0] < (ecp_real)0.001, "friction, or none");
    o.sleep = 1;
#ifdef ECPSIM_NO_SLEEP
    less = 1;
#else
    less = 0;
#endif
    check((ecp_step(w, (ecp_real)0.01, &o, NULL) == ECP_BAD_OPTION) == less, "sleep, or none");
    o.sleep = 0;
    o.rule = ECP_CENTRED;
#ifdef ECPSIM_NO_CENTRING
    less = 1;
#else
    less = 0;
#endif
    check((ecp_step(w, (ecp_real)0.01, &o, NULL) == ECP_BAD_OPTION) == less, "the rule, or none");
    o.rule = ECP_NEAREST;
    check(ecp_step(w, (ecp_real)0.01, &o, NULL) == ECP_OK, "the other rule");
    check((ecp_options_default().rule == ECP_NEAREST) == less, "the default rule");
    printf("%lx\n", hash_of(slide(0, 0)));
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
    check(ecp_guess_ecp(w, 1, 2, up) == ECP_BAD_KIND, "no patch of two balls");
    check(ecp_guess_ecp(w, 1, 0, up) == ECP_OK, "one with the ground");
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
    check_options();
    return failed;
}
