#!/bin/sh
# What scenes cost (`make size`), built as a user with little room would build them: -Os, single
# precision, nothing linked that is not named, no C library. Each scene of tests/firmware/footprint.c
# is an image of its own, startup code included, for a Cortex-M4F and for x86-64 (Linux, without libc).
#
#   flash   code, constants and initial values of the image
#   ram     the world with its work memory (ecp_world_memsize) and the stack that a run of 200 steps,
#           with a fall, a landing and rest, was seen to use (under qemu on the Cortex-M4F)
#   used    of the world's block, the high-water mark of the run
#   unknowns, paper   of the step with the most: ours, and the paper's for the same contacts
#   failed  steps that were not solved
#
# Each scene leaves out what it can do without by the macros of the manual (`without`); a step that is
# not solved for it shows in `failed`. Then what each of them saves in the image of the table, and last
# the figures against what issue 5 asks for (`bar`) and against what has been reached (`limit`): more than
# the latter is a failure, so that code and structures do not grow unseen.
# No double-precision routine (__aeabi_d..) may be linked. What is large in an image:
# arm-none-eabi-nm --size-sort -S --radix=d build/size/arm-TABLE | tail -40
root=$(pwd)
out=$root/build/size
rm -rf "$out"
mkdir -p "$out" || exit 1
cd tests/firmware || exit 1

warn='-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wundef
      -Werror'
small='-std=c99 -Os -DECPSIM_FLOAT -DECPSIM_STATIC -DNDEBUG -ffp-contract=off -fno-math-errno -ffunction-sections
       -fdata-sections -fno-tree-loop-distribute-patterns
       -fno-asynchronous-unwind-tables
       -nostdlib -Wl,--gc-sections'
arm=${ARM_CC:-arm-none-eabi-gcc}
arm_flags='-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -Tmps2.ld port_mps2.c'
linux=${CC:-gcc}
linux_flags='-DECPSIM_SQRT=__builtin_sqrtf -fno-stack-protector -fno-pie -no-pie -static -Wl,--build-id=none port_linux.c'
failed=0

# image NAME COMPILER FLAGS...: 0 if it is built
image() {
    name=$1
    shift
    # shellcheck disable=SC2086
    "$@" $small $warn footprint.c -lgcc -o "$out/$name" >"$out/$name.log" 2>&1 && return
    echo "not built: $name"
    head -n 5 "$out/$name.log"
    failed=$((failed + 1))
    return 1
}

run_arm() {
    timeout 300 qemu-system-arm -M mps2-an386 -nographic -monitor none -serial none \
        -semihosting-config enable=on,target=native -kernel "$1" </dev/null
}

run_linux() { timeout 300 "$1"; }

# field NAME of a line of name=value
field() { echo "$2" | tr ' ' '\n' | sed -n "s/^$1=//p"; }

# measure TARGET SIZE SCENE COMPILER FLAGS...
measure() {
    target=$1 size=$2 scene=$3
    shift 3
    without=
    case $scene in
    BALL | BOX | TABLE) without='-DECPSIM_NO_PAIRS -DECPSIM_NO_SLEEP -DECPSIM_FALLBACKS=0' ;;
    esac
    case $scene in
    BALL) without="$without -DECPSIM_NO_FRICTION -DECPSIM_NO_CENTRING" ;;
    esac
    # shellcheck disable=SC2086
    image "$target-$scene" "$@" $without -DSCENE="$scene" || return
    # shellcheck disable=SC2086
    image "$target-$scene-run" "$@" $without -DSCENE="$scene" -DMEASURE || return
    flash=$("$size" "$out/$target-$scene" | awk 'NR == 2 { print $1 + $2 }')
    line=$("run_$target" "$out/$target-$scene-run" 2>&1)
    world=$(field world_bytes "$line")
    stack=$(field stack_bytes "$line")
    if [ -z "$world" ] || [ -z "$stack" ]; then
        echo "$target-$scene did not run: $line"
        failed=$((failed + 1))
        ram='?'
    else
        ram=$((world + stack))
    fi
    row "$target" "$scene" "$flash" "$ram" "$world" "$(field used_bytes "$line")" "$stack" \
        "$(field unknowns "$line")" "$(field full_mncp "$line")" "$(field not_solved "$line")"
    eval "flash_${target}_$scene=$flash ram_${target}_$scene=$ram"
}

row() { printf '%-6s %-11s %6s %7s %7s %7s %7s %9s %6s %7s\n' "$@"; }

# double precision by software: there must be none
no_doubles() {
    ! "${arm%gcc}nm" "$1" | grep -E '__aeabi_(d|cd|f2d|i2d|ui2d|l2d)'
}

# macro FLAGS: what the image of the table is smaller by with it
macro() {
    # shellcheck disable=SC2086
    image arm-macro "$arm" $arm_flags -DSCENE=TABLE $1 || return
    printf '  %-44s %6s\n' "$1" \
        $((whole - $("${arm%gcc}size" "$out/arm-macro" | awk 'NR == 2 { print $1 + $2 }')))
}

macros() {
    # shellcheck disable=SC2086
    image arm-whole "$arm" $arm_flags -DSCENE=TABLE || return
    whole=$("${arm%gcc}size" "$out/arm-whole" | awk 'NR == 2 { print $1 + $2 }')
    echo "the table with everything: $whole bytes"
    macro -DECPSIM_NO_PAIRS
    macro -DECPSIM_NO_FRICTION
    macro -DECPSIM_NO_SLEEP
    macro -DECPSIM_NO_CENTRING
    macro '-DECPSIM_FALLBACKS=(127&~ECP_FALLBACK_SUBSTEPS)'
    macro -DECPSIM_FALLBACKS=ECP_FALLBACK_GEOMETRIC
    macro -DECPSIM_FALLBACKS=0
    macro '-DECPSIM_NO_PAIRS -DECPSIM_NO_SLEEP -DECPSIM_FALLBACKS=0'
}

# limit WHAT VALUE BAR LIMIT: the limit is for arm-none-eabi-gcc 12.2.1; another version gets a tenth more
limit() {
    most=$4
    [ "$("$arm" -dumpversion)" = 12.2.1 ] || most=$(($4 * 11 / 10))
    verdict=reached
    [ "$2" -le "$3" ] || verdict='not reached'
    if [ "$2" -gt "$most" ]; then
        verdict="$verdict, and GROWN"
        failed=$((failed + 1))
    fi
    printf '  %-24s %6s   bar %6s   limit %6s   %s\n' "$1" "$2" "$3" "$most" "$verdict"
}

scenes='BALL BOX TABLE BOX_ON_BOX EVERYTHING'
row target scene flash ram world used stack unknowns paper failed
for scene in $scenes; do
    # shellcheck disable=SC2086
    measure linux size "$scene" "$linux" $linux_flags
done
if command -v "$arm" >/dev/null && command -v qemu-system-arm >/dev/null; then
    for scene in $scenes; do
        # shellcheck disable=SC2086
        measure arm "${arm%gcc}size" "$scene" "$arm" $arm_flags
        no_doubles "$out/arm-$scene" || failed=$((failed + 1))
    done
    macros
    limit 'flash, ball' "${flash_arm_BALL:-999999}" 12000 23900
    limit 'flash, table' "${flash_arm_TABLE:-999999}" 20000 29700
    limit 'RAM, table' "${ram_arm_TABLE:-999999}" 8000 12020
else
    echo "skipped: Cortex-M4F, no $arm or no qemu-system-arm"
fi

echo "size: flash_table_bytes=${flash_arm_TABLE:-0} ram_table_bytes=${ram_arm_TABLE:-0}" \
    "flash_ball_bytes=${flash_arm_BALL:-0}"
[ $failed -eq 0 ]
