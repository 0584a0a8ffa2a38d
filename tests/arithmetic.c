/* What ecp_arithmetic() says in a build and in modes of the machine: `arithmetic FLAGS` fails where it
   is not FLAGS as things are, or where it does not tell rounding upwards and subnormals that count as
   zero. With GOOD as the first argument it must be 0. */
#define ECPSIM_STATIC /* so that compilers drop all the rest at once */
#define ECPSIM_IMPLEMENTATION
#include "../ecpsim.h"

#include <fenv.h>
#include <stdio.h>
#include <stdlib.h>

#if defined(__x86_64__) || defined(__SSE2__)
#include <xmmintrin.h>
static void flush_to_zero(int on)
{
    _mm_setcsr(on ? _mm_getcsr() | 0x8040u : _mm_getcsr() & ~0x8040u);
}
#define FLUSHES 1
#else
static void flush_to_zero(int on) { (void)on; }
#define FLUSHES 0
#endif

/* all of `must`, and nothing but what is in `may` besides */
static int check(const char *when, int must, int may)
{
    int flags = ecp_arithmetic();
    printf("%s: %d\n", when, flags);
    return (flags & must) != must || (flags & ~(must | may)) != 0;
}

int main(int argc, char **argv)
{
    static const int modes[3] = {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO};
    int must = argc > 1 ? atoi(argv[1]) : 0, may = argc > 2 ? atoi(argv[2]) : 0, failed, i;
    failed = check("as compiled", must, may);
    if (must) return failed;
    for (i = 0; i < 3; i++) {
        fesetround(modes[i]);
        failed += check("rounding", ECP_ARITHMETIC_ROUNDING, ECP_ARITHMETIC_INEXACT);
    }
    fesetround(FE_TONEAREST);
    flush_to_zero(1);
    if (FLUSHES) failed += check("flushed", ECP_ARITHMETIC_SUBNORMAL, 0);
    flush_to_zero(0);
    return failed + check("again", 0, 0);
}
