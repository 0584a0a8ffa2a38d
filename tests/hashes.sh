#!/bin/sh
# The same bits everywhere (`make hashes`): the scenes of tests/firmware/scenes.h (a table that slides,
# one that is hit, a box that falls, a union, pairs of all primitives, a stack, and steps that need the
# fallbacks), hashed over all states of all bodies, in double and in float, by every compiler and
# machine that is here, against one table, tests/hashes.txt. Also that ecp_arithmetic() tells the
# builds and modes in which they would differ.
#
# `tests/hashes.sh accept` (make hashes-accept) writes the table anew, if all builds agree: for a change
# that is meant to change bits, in the same commit. Without a golden line a scene fails. With QUICK=1 in
# the environment only -O2 of each compiler and machine; make test takes all.
root=$(pwd)
out=$root/build/hashes
rm -rf "$out"
mkdir -p "$out" || exit 1
golden=$root/tests/hashes.txt
builds=0
failed=0
cd tests/firmware || exit 1

warn='-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wundef
      -Werror'
common="-std=c99 -DALL_SCENES -ffp-contract=off -fno-math-errno $warn"
# no C library: the functions of bare.h, and the compiler's own headers
bare='-DNDEBUG -ffreestanding -nostdlib -fno-builtin -DECPSIM_MEMCPY=__builtin_memcpy
      -DECPSIM_MEMSET=__builtin_memset -DECPSIM_ASSERT(x)=((void)(x))'

here() { command -v "$1" >/dev/null || { echo "skipped: no $1"; return 1; }; }

# REAL NAME, the hashes on standard input, with the line ends of any system: notes them, and says what the
# table has otherwise
note() {
    builds=$((builds + 1))
    tr -d '\r' | sed -n "s/^\([a-z0-9_]* step=.* hash=.*\)/$1 \1/p" >"$out/now"
    grep "^$1 " "$golden" >"$out/golden" 2>/dev/null
    sed "s/^/$2: /" "$out/now" >>"$out/all"
    cat "$out/now" >>"$out/lines"
    [ -s "$out/now" ] && cmp -s "$out/golden" "$out/now" && return
    [ "$accept" = accept ] && [ -s "$out/now" ] && return
    failed=$((failed + 1))
    echo "other bits: $2, $1"
    diff "$out/golden" "$out/now" | grep '^[<>]' | head -n 4
}

# run REAL NAME COMMAND...
run() {
    real=$1 name=$2
    shift 2
    timeout 600 "$@" </dev/null >"$out/text" 2>&1 || echo "exit status $?: $name"
    sed -n "s/^stack: bytes=/stack in $real, $name: bytes=/p" "$out/text"
    note "$real" "$name" <"$out/text"
}

# runs PROGRAM: sets via to what this machine runs it with: nothing, or an emulator of 32-bit x86 where the
# processor or the kernel has no such mode
runs() {
    via=
    timeout 60 sh -c 'exec "$1"' sh "$1" >/dev/null 2>&1 && return
    via=qemu-i386
    timeout 60 qemu-i386 "$1" >/dev/null 2>&1
}

# build NAME COMPILER FLAGS...
build() {
    name=$1
    shift
    "$@" -o "$out/program" >"$out/log" 2>&1 && return
    failed=$((failed + 1))
    echo "not built: $name"
    head -n 5 "$out/log"
    return 1
}

accept=$1
hosts=
for cc in gcc clang; do
    here $cc || continue
    for flags in -O2 -O0 '-O3 -march=native' '-O2 -m32 -msse2 -mfpmath=sse'; do
        if [ -n "$QUICK" ] && [ "$flags" != -O2 ]; then continue; fi
        echo 'int main(void) { return 0; }' >"$out/empty.c"
        # shellcheck disable=SC2086
        if ! $cc $flags "$out/empty.c" -lm -o "$out/empty" 2>/dev/null || ! runs "$out/empty"; then
            echo "skipped: $cc $flags does not link, or what it makes does not run"
            continue
        fi
        hosts="$hosts$via|$cc $flags
"
    done
done
echo "$hosts" >"$out/hosts"

# every compiler and machine in this real, in a directory of its own
of_real() {
    real=$1
    define=-UECPSIM_FLOAT sqrt=__builtin_sqrt
    [ "$real" = float ] && define=-DECPSIM_FLOAT sqrt=__builtin_sqrtf
    hosts=$out/hosts
    out=$out/$real
    mkdir "$out" || return
    : >"$out/all"
    : >"$out/lines"
    while IFS='|' read -r via host; do
        [ -n "$host" ] || continue
        # shellcheck disable=SC2086
        build "$host" $host $common $define main.c port_hosted.c -lm &&
            run "$real" "$host${via:+ under $via}" $via "$out/program"
    done <"$hosts"
    if here arm-none-eabi-gcc && here qemu-system-arm; then
        # shellcheck disable=SC2086
        build cortex-m7 arm-none-eabi-gcc -O2 $common $define -DNDEBUG -nostdlib -mcpu=cortex-m7 -mthumb \
            -mfloat-abi=hard -mfpu=fpv5-d16 -fno-tree-loop-distribute-patterns -Tmps2.ld \
            port_mps2.c main.c -lgcc &&
            run "$real" 'arm-none-eabi-gcc Cortex-M7 under qemu' qemu-system-arm -M mps2-an500 -nographic \
                -monitor none -serial none -semihosting-config enable=on,target=native \
                -kernel "$out/program"
    fi
    # other machines with an operating system; s390x has the other byte order, and with -std=c99 alone
    # computes expressions of floats in double (which ecp_arithmetic tells)
    for machine in aarch64 riscv64 s390x; do
        here $machine-linux-gnu-gcc && here qemu-$machine || continue
        # shellcheck disable=SC2086
        build $machine $machine-linux-gnu-gcc -O2 -static -fexcess-precision=fast $common $define \
            main.c port_hosted.c -lm &&
            run "$real" "$machine-linux-gnu-gcc under qemu" qemu-$machine "$out/program"
    done
    if here x86_64-w64-mingw32-gcc && here wine; then
        # shellcheck disable=SC2086
        build windows x86_64-w64-mingw32-gcc -O2 $common $define main.c port_hosted.c -lm &&
            run "$real" 'x86_64-w64-mingw32-gcc under wine' env WINEDEBUG=-all WINEPREFIX="$out/wine" \
                wine "$out/program"
    fi
    if here clang && here wasm-ld && here node; then
        # shellcheck disable=SC2086
        build wasm clang --target=wasm32 -O2 $common $bare $define -DECPSIM_SQRT=$sqrt -mbulk-memory \
            -Wl,--no-entry -Wl,-z,stack-size=262144 main.c port_wasm.c &&
            run "$real" 'clang WebAssembly in node' node ../wasm.js "$out/program"
    fi
    echo "$builds $failed" >"$out/sum"
}

# side by side; a real that has left no sum has failed
(of_real double) &
(of_real float)
wait
for real in double float; do
    if read -r made lost <"$out/$real/sum"; then
        builds=$((builds + made))
        failed=$((failed + lost))
    else
        failed=$((failed + 1))
    fi
done
cat "$out/double/lines" "$out/float/lines" >"$out/lines"
cat "$out/double/all" "$out/float/all" >"$out/all"

# ---- what makes other bits is told. Flags of ecp_arithmetic: excess 2, contracted 16, NaN 64
# arithmetic MUST MAY COMPILER FLAGS...
arithmetic() {
    must=$1 may=$2
    shift 2
    echo 'int main(void) { return 0; }' >"$out/empty.c"
    "$@" "$out/empty.c" -o "$out/empty" 2>/dev/null && runs "$out/empty" || return
    builds=$((builds + 1))
    if ! "$@" -std=c99 ../arithmetic.c -lm -o "$out/program" 2>"$out/log" ||
        ! $via "$out/program" "$must" "$may" >"$out/text"; then
        failed=$((failed + 1))
        echo "ecp_arithmetic: $*: $(tr '\n' ' ' <"$out/text")"
    fi
}
for cc in gcc clang; do
    here $cc >/dev/null || continue
    for define in -UECPSIM_FLOAT -DECPSIM_FLOAT; do
        arithmetic 0 0 $cc $define -O0 -ffp-contract=off
        arithmetic 0 0 $cc $define -O3 -ffp-contract=off
        [ "$(uname -m)" = x86_64 ] || continue
        arithmetic 2 32 $cc $define -O2 -m32 -mno-sse -mfpmath=387
        arithmetic 66 42 $cc $define -O2 -ffast-math
        arithmetic 32 0 $cc $define -O2 -freciprocal-math
        grep -q ' fma ' /proc/cpuinfo && arithmetic 16 0 $cc $define -O2 -mfma -ffp-contract=fast
    done
done

# ---- the table
cd "$root" || exit 1
different=$(sort -u "$out/lines" | awk '{ $NF = ""; print }' | sort | uniq -d | wc -l)
if [ "$accept" = accept ]; then
    if [ "$different" -gt 0 ] || [ $failed -gt 0 ] || [ ! -s "$out/lines" ]; then
        echo "not accepted: the builds do not agree ($out/all)"
        failed=$((failed + 1))
    else
        awk '!seen[$0]++' "$out/lines" >"$golden"
    fi
fi
echo "hashes: builds=$builds lines=$(wc -l <"$golden") failed=$failed"
[ $failed -eq 0 ]
