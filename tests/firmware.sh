#!/bin/sh
# Programs without an operating system (tests/firmware/), in single precision: `tests/firmware.sh
# build` builds them, `tests/firmware.sh` also runs them under qemu and compares the hashes of all
# states with those of the same program on this machine. Instructions are counted by qemu.
root=$(pwd)
out=$root/build/firmware
mkdir -p "$out" || exit 1
cd tests/firmware || exit 1

warn='-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wundef
      -Werror'
# -fno-tree-loop-distribute-patterns: see bare.h
bare='-std=c99 -O2 -DECPSIM_FLOAT -DNDEBUG -ffp-contract=off -fno-math-errno -ffunction-sections
      -fdata-sections -fno-tree-loop-distribute-patterns -nostdlib -Wl,--gc-sections'
# no header of a C library either
overrides='-ffreestanding -DECPSIM_SQRT=__builtin_sqrtf -DECPSIM_MEMCPY=__builtin_memcpy
           -DECPSIM_MEMSET=__builtin_memset -DECPSIM_ASSERT(x)=((void)(x))'
cortex_m4='-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -Tmps2.ld port_mps2.c'
riscv='-march=rv32imafc -mabi=ilp32f -mcmodel=medany -Triscv.ld port_riscv.c'
failed=0

# build NAME COMMAND...
build() {
    name=$1
    shift
    if ! command -v "$1" >/dev/null; then
        echo "skipped: $name, no $1"
        rm -f "$out/$name"
        return 1
    fi
    if ! "$@" -o "$out/$name" >"$out/$name.log" 2>&1; then
        echo "not built: $name"
        head -n 10 "$out/$name.log"
        failed=$((failed + 1))
        return 1
    fi
}

# shellcheck disable=SC2086
build host "${CC:-cc}" -std=c99 -O2 -DECPSIM_FLOAT -ffp-contract=off $warn main.c port_hosted.c -lm
# shellcheck disable=SC2086
build mps2.elf arm-none-eabi-gcc $bare $warn $cortex_m4 main.c -lgcc &&
    arm-none-eabi-size "$out/mps2.elf"
# shellcheck disable=SC2086
build riscv.elf riscv64-unknown-elf-gcc $bare $overrides $warn $riscv main.c -lgcc &&
    riscv64-unknown-elf-size "$out/riscv.elf"
if [ "$1" = build ]; then
    exit $failed
fi

# run NAME EMULATOR FLAGS...: shows what the program prints, and compares its hashes
run() {
    name=$1
    shift
    : >"$out/$name.txt"
    if [ ! -f "$out/$name" ] || ! command -v "$1" >/dev/null; then
        echo "skipped: $name does not run, there is no $1"
        return 1
    fi
    timeout 300 "$@" -nographic -monitor none -serial none \
        -semihosting-config enable=on,target=native -icount shift=0 -kernel "$out/$name" \
        >"$out/$name.txt" 2>&1 </dev/null || failed=$((failed + 1))
    echo "$name:"
    cat "$out/$name.txt"
    grep hash= "$out/$name.txt" >"$out/$name.hashes"
    if ! cmp -s "$out/host.hashes" "$out/$name.hashes"; then
        equal=no
        diff "$out/host.hashes" "$out/$name.hashes" | head -n 6
    fi
}

equal=yes
"$out/host" >"$out/host.txt" || failed=$((failed + 1))
grep hash= "$out/host.txt" >"$out/host.hashes" || equal=no
run riscv.elf qemu-system-riscv32 -M virt -bios none
run mps2.elf qemu-system-arm -M mps2-an386 || equal=no
[ $equal = yes ] || failed=$((failed + 1))
echo "firmware: scenes=$(grep -c 'steps=' "$out/mps2.elf.txt")" \
    "hash_equal_to_host=$equal" \
    "stack_bytes=$(sed -n 's/^stack: bytes=//p' "$out/mps2.elf.txt")"
[ $failed -eq 0 ]
