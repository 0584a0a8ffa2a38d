#!/bin/sh
# Hostile use of the public API (tests/fuzz/target.c) under the address and undefined-behaviour
# sanitizers, in double and in float.
#
#   tests/fuzz.sh quick   a minute (make fuzz-quick)
#   tests/fuzz.sh         until FUZZ_CALLS calls (10,000,000) are made, a line every two minutes, ^C ends it; what
#                         it has learnt stays in build/fuzz/corpus and is where the next run goes on (make fuzz)
#   tests/fuzz.sh afl     AFL++ for FUZZ_SECONDS (600), from the same corpus (make fuzz-afl)
#   tests/fuzz.sh replay  tests/fuzz/corpus and what build/fuzz/corpus has, once, with gcc or clang and
#                         its sanitizers, and with the memory sanitizer of clang or valgrind for reads of
#                         what nobody wrote (part of make test)
#
# What is found is build/fuzz/crash-..., timeout-... or slow-unit-...; `build/fuzz/double FILE` shows it again.
# When it is mended the file goes to tests/fuzz/corpus, under the name of what was wrong.
root=$(pwd)
out=$root/build/fuzz
mkdir -p "$out/corpus" || exit 1
calls=0
failed=0

real() { [ "$1" = float ] && echo -DECPSIM_FLOAT || echo -UECPSIM_FLOAT; }

# build NAME COMPILER FLAGS...
build() {
    program=$1
    shift
    "$@" -std=c99 -g1 -ffp-contract=off -o "$out/$program" -lm >"$out/log" 2>&1 && return
    echo "not built: $program"
    head -n 5 "$out/log"
    return 1
}

fuzzer() { build "$1" clang -O2 "$(real "$1")" -fsanitize=fuzzer,address,undefined \
    -fno-sanitize-recover=all tests/fuzz/target.c; }

# round REAL SECONDS: adds to calls
round() {
    (cd "$out" && exec "./$1" -max_total_time="$2" -timeout=60 -report_slow_units=60 -max_len=600 -verbosity=0 \
        corpus "$root/tests/fuzz/corpus") >"$out/$1.log" 2>&1
    status=$?
    made=$(sed -n 's/^fuzz: calls=\([0-9]*\) .*/\1/p' "$out/$1.log" | tail -n 1)
    calls=$((calls + ${made:-0}))
    if [ $status -ne 0 ]; then
        failed=$((failed + 1))
        grep -E 'broken|ERROR|runtime error|Test unit' "$out/$1.log" | head -n 4
    fi
}

# every file of the corpora through a plain program
replay() {
    for name in double float; do
        for cc in gcc clang; do
            command -v $cc >/dev/null || continue
            echo 'int main(void) { return 0; }' >"$out/empty.c"
            $cc -fsanitize=address,undefined "$out/empty.c" -o "$out/empty" 2>/dev/null || continue
            build "replay-$name" $cc -O1 "$(real $name)" -fsanitize=address,undefined \
                -fno-sanitize-recover=all tests/fuzz/replay.c || failed=$((failed + 1))
            break
        done
        "$out/replay-$name" tests/fuzz/corpus/* $(find "$out/corpus" -type f | sort | head -n 2000) \
            >"$out/replay.log" 2>&1 || { failed=$((failed + 1)); tail -n 20 "$out/replay.log"; }
        sed -n 's/^fuzz: /replay: /p' "$out/replay.log"
        memory=
        if build "memory-$name" clang -O1 "$(real $name)" -fsanitize=memory -fno-sanitize-recover=all \
            tests/fuzz/replay.c >/dev/null; then
            memory=$out/memory-$name
        elif command -v valgrind >/dev/null &&
            build "memory-$name" "${CC:-cc}" -O1 "$(real $name)" -DFUZZ_UNINITIALISED tests/fuzz/replay.c; then
            memory="valgrind -q --error-exitcode=9 $out/memory-$name"
        else
            echo 'skipped: no memory sanitizer and no valgrind'
            continue
        fi
        $memory tests/fuzz/corpus/* >"$out/replay.log" 2>&1 ||
            { failed=$((failed + 1)); tail -n 20 "$out/replay.log"; }
    done
}

case ${1:-long} in
replay) replay ;;
quick | long)
    for name in double float; do
        fuzzer $name || { echo "skipped: fuzzing, clang has no libFuzzer"; exit 0; }
    done
    if [ "$1" = quick ]; then
        round double 30
        round float 30
    else
        while [ $failed -eq 0 ] && [ $calls -lt "${FUZZ_CALLS:-10000000}" ]; do
            round double "${FUZZ_ROUND:-60}"
            [ $failed -eq 0 ] && round float "${FUZZ_ROUND:-60}"
            echo "calls=$calls corpus=$(find "$out/corpus" -type f | wc -l) $(date +%H:%M:%S)"
        done
    fi
    echo "fuzz: calls=$calls failures=$failed"
    ;;
afl)
    command -v afl-clang-fast >/dev/null || { echo 'skipped: no afl-clang-fast'; exit 0; }
    build afl-target afl-clang-fast -O2 -fsanitize=fuzzer tests/fuzz/target.c || exit 1
    AFL_SKIP_CPUFREQ=1 AFL_NO_UI=1 AFL_I_DONT_CARE_ABOUT_MISSING_CRASHES=1 afl-fuzz -V "${FUZZ_SECONDS:-600}" \
        -t 20000 -i tests/fuzz/corpus -o "$out/afl" -- "$out/afl-target" >"$out/afl.log" 2>&1
    grep -hE 'execs_done|saved_crashes|saved_hangs|unique_crashes' "$out/afl/default/fuzzer_stats"
    found=$(find "$out/afl/default/crashes" -name 'id*' 2>/dev/null | wc -l)
    failed=$found
    ;;
esac
[ $failed -eq 0 ]
