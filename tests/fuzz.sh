#!/bin/sh
# Hostile use of the public API (tests/fuzz/target.c) under the address and undefined-behaviour
# sanitizers, in double and in float.
#
#   tests/fuzz.sh quick   80,000 random changes to tests/fuzz/corpus, the same on every machine: what is
#                         said of a commit is not to depend on luck (make fuzz-quick)
#   tests/fuzz.sh         libFuzzer, and random changes to what it has learnt, until FUZZ_CALLS calls (10,000,000)
#                         are made; a line every few minutes, ^C ends it; what it has learnt stays in
#                         build/fuzz/corpus and is where the next run goes on (make fuzz)
#   tests/fuzz.sh afl     AFL++ for FUZZ_SECONDS (600), from the same corpus (make fuzz-afl)
#   tests/fuzz.sh replay  tests/fuzz/corpus and what build/fuzz/corpus has, once, with gcc or clang and
#                         its sanitizers, and with the memory sanitizer of clang or valgrind for reads of
#                         what nobody wrote (part of make test)
#
# What is found is build/fuzz/crash-..., timeout-..., slow-unit-... or last-...; `build/fuzz/double FILE` and
# `build/fuzz/replay-double FILE` show it again.
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
    "$@" -std=c99 -g1 -ffp-contract=off -o "$out/$program" -lm >"$out/$program.log" 2>&1 && return
    echo "not built: $program"
    head -n 5 "$out/$program.log"
    return 1
}

fuzzer() { build "$1" clang -O2 "$(real "$1")" -fsanitize=fuzzer,address,undefined \
    -fno-sanitize-recover=all tests/fuzz/target.c; }

# result LOG STATUS: adds to calls and failed
result() {
    made=$(sed -n 's/^fuzz: calls=\([0-9]*\) .*/\1/p' "$1" | tail -n 1)
    calls=$((calls + ${made:-0}))
    [ "$2" -eq 0 ] && return
    failed=$((failed + 1))
    grep -E 'broken|ERROR|runtime error|Test unit' "$1" | head -n 4
}

# round REAL SECONDS: of libFuzzer
round() {
    (cd "$out" && exec "./$1" -max_total_time="$2" -timeout=60 -report_slow_units=60 -max_len=600 -verbosity=0 \
        corpus "$root/tests/fuzz/corpus") >"$out/$1.log" 2>&1
    result "$out/$1.log" $?
}

# mutate REAL ROUNDS SEED FILES...: random changes, by the plain program; mutated REAL: what came of it
mutate() {
    name=$1 rounds=$2 seed=$3
    shift 3
    rm -f "$out/$name.code"
    "$out/replay-$name" -mutate "$rounds" "$seed" "$out/last-$name" "$@" >"$out/$name.log" 2>&1
    code=$?
    echo $code >"$out/$name.code"
}

mutated() {
    read -r code <"$out/$1.code" || code=1
    result "$out/$1.log" "$code"
    [ "$code" -eq 0 ] || echo "the input is build/fuzz/last-$1"
}

# the plain program, with the sanitizers of gcc or clang
replayer() {
    for cc in gcc clang; do
        command -v $cc >/dev/null || continue
        echo 'int main(void) { return 0; }' >"$out/empty-$1.c"
        $cc -fsanitize=address,undefined "$out/empty-$1.c" -o "$out/empty-$1" 2>/dev/null || continue
        build "replay-$1" $cc -O2 "$(real "$1")" -fsanitize=address,undefined \
            -fno-sanitize-recover=all tests/fuzz/replay.c
        return
    done
    build "replay-$1" "${CC:-cc}" -O2 "$(real "$1")" tests/fuzz/replay.c
}

# every file of the corpora through the plain programs of a real
replay() {
    name=$1
    replayer "$name" || failed=$((failed + 1))
    "$out/replay-$name" tests/fuzz/corpus/* $(find "$out/corpus" -type f | sort | head -n 2000) \
        >"$out/$name.log" 2>&1 || { failed=$((failed + 1)); tail -n 20 "$out/$name.log"; }
    sed -n 's/^fuzz: /replay: /p' "$out/$name.log"
    if build "memory-$name" clang -O1 "$(real "$name")" -fsanitize=memory -fno-sanitize-recover=all \
        tests/fuzz/replay.c >/dev/null; then
        memory=$out/memory-$name
    elif command -v valgrind >/dev/null &&
        build "memory-$name" "${CC:-cc}" -O1 "$(real "$name")" -DFUZZ_UNINITIALISED tests/fuzz/replay.c; then
        memory="valgrind -q --error-exitcode=9 $out/memory-$name"
    else
        echo 'skipped: no memory sanitizer and no valgrind'
        return $failed
    fi
    $memory tests/fuzz/corpus/* >"$out/$name.log" 2>&1 ||
        { failed=$((failed + 1)); tail -n 20 "$out/$name.log"; }
    return $failed
}

case ${1:-long} in
replay) # the two reals side by side
    replay double &
    (replay float) || failed=1
    wait $! || failed=1
    ;;
quick)
    for name in double float; do
        replayer $name || exit 1
    done
    mutate double "${FUZZ_ROUNDS:-40000}" 1 tests/fuzz/corpus/* &
    (mutate float "${FUZZ_ROUNDS:-40000}" 1 tests/fuzz/corpus/*)
    wait
    for name in double float; do
        mutated $name
    done
    echo "fuzz: calls=$calls failures=$failed"
    ;;
long)
    for name in double float; do
        replayer $name || exit 1
        fuzzer $name || { echo "skipped: fuzzing, clang has no libFuzzer"; exit 0; }
    done
    seed=1
    while [ $failed -eq 0 ] && [ $calls -lt "${FUZZ_CALLS:-10000000}" ]; do
        for name in double float; do
            [ $failed -eq 0 ] && round $name "${FUZZ_ROUND:-60}"
            # shellcheck disable=SC2046
            [ $failed -eq 0 ] && mutate $name "${FUZZ_ROUNDS:-60000}" $((seed += 1)) tests/fuzz/corpus/* \
                $(find "$out/corpus" -type f | sort | head -n 4000) && mutated $name
        done
        echo "calls=$calls corpus=$(find "$out/corpus" -type f | wc -l) $(date +%H:%M:%S)"
    done
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
