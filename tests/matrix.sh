#!/bin/sh
# The header in every way it may be compiled (`make matrix`): compilers, standards, both reals, how it
# is linked, and in units where min, max, EPS, near, far and small are macros and where it is included
# more than once. Each build is a program of two units that drops a box; all of the same real must end
# with the same bits. Compilers that are not here are named and left out.
root=$(pwd)
out=$root/build/matrix
rm -rf "$out"
mkdir -p "$out" || exit 1
cd "$out" || exit 1

strict='-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wundef'
builds=0
warnings=0
failures=0
bad=0

# ---- the two units

# macros that a program may have; the C library's headers, which C++ would break on them, come first
cat >hostile.h <<'EOT'
#ifndef WITHOUT_LIBC
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#endif
#define min(a, b) ((a) < (b) ? (a) : (b))
#define max(a, b) ((a) > (b) ? (a) : (b))
#define EPS 1e-6
#define near
#define far
#define small char
EOT

# first.c has the implementation, second.c the declarations, or its own implementation with ECPSIM_STATIC
cat >first.c <<'EOT'
#include "hostile.h"
#include "../../../ecpsim.h"
#define ECPSIM_IMPLEMENTATION
#include "../../../ecpsim.h"
#include "../../../ecpsim.h"
#include "unit.h"
UNIT(first)

#ifndef WITHOUT_LIBC
int main(void)
{
    unsigned long a = first(), b = second();
    printf("%lu %lx\n", (unsigned long)(sizeof(ecp_real) * 8), a);
    return a != b || a == 0;
}
#endif
EOT
cat >second.c <<'EOT'
#include "hostile.h"
#ifdef ECPSIM_STATIC
#define ECPSIM_IMPLEMENTATION
#endif
#include "../../../ecpsim.h"
#include "../../../ecpsim.h"
#include "unit.h"
UNIT(second)
EOT
cat >unit.h <<'EOT'
/* a function that drops a box and gives the hash of where it is after 50 steps, or 0 */
#define UNIT(name)                                                                                 \
    static union {                                                                                 \
        double align;                                                                              \
        unsigned char bytes[100000];                                                               \
    } name##_memory __attribute__((aligned(8))); /* a double may have 4 */                         \
    unsigned long name(void)                                                                       \
    {                                                                                              \
        const ecp_real up[3] = {0, 0, 1}, half[3] = {1, (ecp_real)0.5, (ecp_real)0.25};            \
        ecp_world_desc desc = ecp_world_desc_default();                                            \
        ecp_body_desc body = ecp_body_desc_default();                                              \
        ecp_real x[3];                                                                             \
        unsigned char *bytes = (unsigned char *)x;                                                 \
        unsigned long hash = 2166136261ul;                                                         \
        ecp_world *world;                                                                          \
        ecp_shape shape;                                                                           \
        unsigned k;                                                                                \
        desc.max_bodies = desc.max_shapes = 2;                                                     \
        desc.max_patches = 1;                                                                      \
        if (ecp_world_init(&world, &desc, name##_memory.bytes, sizeof name##_memory.bytes)) {      \
            return 0;                                                                              \
        }                                                                                          \
        body.kind = ECP_STATIC;                                                                    \
        ecp_body_add(world, &body, NULL);                                                          \
        ecp_shape_half_space(&shape, up, 0);                                                       \
        ecp_body_add_shape(world, 0, &shape, NULL, NULL, NULL, NULL);                              \
        body.kind = ECP_DYNAMIC;                                                                   \
        body.position[2] = 1;                                                                      \
        body.velocity[0] = 1;                                                                      \
        body.angular_velocity[1] = 2;                                                              \
        ecp_body_add(world, &body, NULL);                                                          \
        ecp_shape_box(&shape, half);                                                               \
        ecp_body_add_shape(world, 1, &shape, NULL, NULL, NULL, NULL);                              \
        for (k = 0; k < 50; k++) {                                                                 \
            if (ecp_step(world, (ecp_real)0.02, NULL, NULL) != ECP_OK) return 0;                   \
        }                                                                                          \
        ecp_body_get_state(world, 1, x, NULL, NULL, NULL);                                         \
        for (k = 0; k < sizeof x; k++) hash = ((hash ^ bytes[k]) * 16777619ul) & 0xfffffffful;     \
        return hash;                                                                               \
    }
#ifdef __cplusplus
extern "C" {
#endif
unsigned long first(void);
unsigned long second(void);
#ifdef __cplusplus
}
#endif
EOT

# ---- a build

# note STATUS NAME: counts a build, and the warnings in its log
note() {
    found=$(grep -c 'warning:' log)
    builds=$((builds + 1))
    warnings=$((warnings + found))
    if [ "$1" -ne 0 ]; then failures=$((failures + 1)); fi
    if [ "$1" -ne 0 ] || [ "$found" -gt 0 ]; then
        bad=$((bad + 1))
        if [ $bad -gt 5 ]; then return; fi
        echo "failed or warned: $2"
        grep -E 'error|warning' log | head -n 3
    fi
}

# program FLAGS... with the compiler first: compiled, linked, run
program() {
    rm -f first.o second.o program
    : >result
    "$@" -I. -c first.$end -o first.o >log 2>&1 && "$@" -I. -c second.$end -o second.o >>log 2>&1 &&
        "$@" first.o second.o -o program -lm >>log 2>&1 && $via ./program >result 2>&1
    status=$?
    cat result >>log
    note $status "$*"
    if [ $status -eq 0 ]; then echo "$(cat result) $*" >>results; fi
}

# both reals, and each of them as two static units
programs() {
    program "$@"
    program "$@" -DECPSIM_FLOAT
    program "$@" -DECPSIM_STATIC
    program "$@" -DECPSIM_STATIC -DECPSIM_FLOAT
}

reals() {
    program "$@"
    program "$@" -DECPSIM_FLOAT
}

cat >overrides.h <<'EOT'
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif
double my_sqrt(double x);
float my_sqrtf(float x);
void *my_memcpy(void *to, const void *from, size_t bytes);
void *my_memset(void *to, int value, size_t bytes);
#ifdef __cplusplus
}
#endif
#ifdef ECPSIM_FLOAT
#define ECPSIM_SQRT my_sqrtf
#else
#define ECPSIM_SQRT my_sqrt
#endif
#define ECPSIM_MEMCPY my_memcpy
#define ECPSIM_MEMSET my_memset
#define ECPSIM_ASSERT(x) ((void)(x))
EOT

# freestanding HEADERS COMPILER FLAGS...: only the compiler's own headers, and nothing needed at the
# end but what a freestanding compiler may ask for
freestanding() {
    headers=$1
    shift
    for real in -UECPSIM_FLOAT -DECPSIM_FLOAT; do
        "$@" $real -ffreestanding -nostdinc -isystem "$headers" -DWITHOUT_LIBC -include overrides.h \
            -I. -c first.$end -o first.o >log 2>&1 &&
            nm -u first.o | awk '{ print $NF }' |
            grep -Ev '^(my_.*|mem(cpy|set|move|cmp)|_GLOBAL_OFFSET_TABLE_)$' >>log
        # grep finds nothing where all is well
        if [ $? -eq 1 ]; then note 0 "$*"; else note 1 "freestanding: $* $real"; fi
    done
}

here() { command -v "$1" >/dev/null || { echo "skipped: no $1"; return 1; }; }

# can this compiler link a program with these flags, and can it be run? Sets via to what runs it: nothing, or
# an emulator of 32-bit x86 where the processor or the kernel has no such mode
can() {
    echo 'int main(void) { return 0; }' >empty.c
    via=
    if "$@" empty.c -o empty >/dev/null 2>&1; then
        timeout 60 sh -c 'exec ./empty' >/dev/null 2>&1 && return
        via=qemu-i386
        timeout 60 $via ./empty >/dev/null 2>&1 && return
    fi
    via=
    echo "skipped: $*"
    return 1
}

# ---- all of them

contract=-ffp-contract=off

c_builds() {
    cc=$1
    here $cc || return
    for std in c99 c11; do
        # shellcheck disable=SC2086
        programs $cc -std=$std -O0 $contract $strict
    done
    for flags in '-Os' '-O3 -DNDEBUG' '-O1 -m32 -msse2 -mfpmath=sse'; do
        # shellcheck disable=SC2086
        can $cc $flags || continue
        # shellcheck disable=SC2086
        reals $cc -std=c99 $flags $contract $strict
    done
    via=
    # what a program leaves out does not change the rest
    # shellcheck disable=SC2086
    reals $cc -std=c99 -O1 -DECPSIM_NO_PAIRS $contract $strict
    # shellcheck disable=SC2086
    reals $cc -std=c99 -O1 -DECPSIM_NO_PAIRS -DECPSIM_NO_SLEEP -DECPSIM_NO_CENTRING $contract $strict
    # shellcheck disable=SC2086
    reals $cc -std=c99 -O1 -DECPSIM_FALLBACKS=ECP_FALLBACK_GEOMETRIC $contract $strict
    lto=-flto
    [ $cc = gcc ] && lto=-flto=2 # without a number it warns that it takes one, and with 1 that there are more parts
    # shellcheck disable=SC2086
    if can $cc $lto; then program $cc -std=c99 -O2 $lto $contract $strict; fi
    include=$($cc -print-file-name=include)
    # shellcheck disable=SC2086
    freestanding "$include" $cc -std=c99 -O1 $strict
}

cxx_builds() {
    cxx=$1
    here $cxx || return
    for std in c++11 c++20; do
        # shellcheck disable=SC2086
        programs $cxx -std=$std -O0 $contract $strict
    done
    # shellcheck disable=SC2086
    reals $cxx -std=c++11 -Os $contract $strict
    include=$($cxx -print-file-name=include)
    # shellcheck disable=SC2086
    freestanding "$include" $cxx -std=c++11 -O0 $strict
}

# what two compilers of a house build, in a directory of their own
house() {
    mkdir $1 && cp ./*.h first.* second.* $1 && cd $1 || return
    : >results
    end=c
    c_builds $1
    end=cc
    cxx_builds $2
    echo $builds $warnings $failures >sum
}

cp first.c first.cc
cp second.c second.cc
via=
# side by side; a house that has left no sum has failed
house gcc g++ &
(house clang clang++)
wait
for cc in gcc clang; do
    if read -r b w f <$cc/sum; then
        builds=$((builds + b))
        warnings=$((warnings + w))
        failures=$((failures + f))
    else
        failures=$((failures + 1))
    fi
done
if here tcc; then
    mkdir tcc && cp ./*.h first.c second.c tcc && cd tcc || exit 1
    : >results
    end=c
    programs tcc -std=c99 -Wall
    cd ..
fi
cat ./*/results >results

# ---- the same bits in all of them
for bits in 32 64; do
    hashes=$(awk -v b=$bits '$1 == b { print $2 }' results | sort | uniq -c | sort -rn)
    echo "bits of real $bits: $(echo "$hashes" | awk '{ printf "%s%s in %s builds", sep, $2, $1; sep = ", " }')"
    if [ "$(echo "$hashes" | wc -l)" -ne 1 ]; then
        failures=$((failures + 1))
        common=$(echo "$hashes" | awk 'NR == 1 { print $2 }')
        awk -v b=$bits -v c="$common" '$1 == b && $2 != c' results
    fi
done
echo "matrix: builds=$builds warnings=$warnings failures=$failures"
[ $warnings -eq 0 ] && [ $failures -eq 0 ]
