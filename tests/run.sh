#!/bin/sh
# Everything that is tested, from the root of the repository (`make test`); the last line is the
# sum. With the name of a test, as in `tests/run.sh newton`, only that one, in every build.
#
# The program tests/main.c counts its own checks; here every build, link and example line is one
# check more. Output of the builds stays in build/test/.
filter=${1:-}
root=$(pwd)
out=$root/build/test
rm -rf "$out"
mkdir -p "$out" || exit 1

warn='-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wundef
      -Werror'
sanitize='-g -fsanitize=address,undefined -fno-sanitize-recover=all'
passed=0
failed=0

# check NAME COMMAND...: the command succeeds
check() {
    name=$1
    shift
    if "$@" >"$out/check.log" 2>&1; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "failed: $name"
        head -n 20 "$out/check.log"
    fi
}

refuse() { ! "$@"; }

# ---- which compilers are here

c_compilers=
cxx_compilers=
for cc in gcc clang; do
    if command -v $cc >/dev/null; then c_compilers="$c_compilers $cc"; else echo "skipped: no $cc"; fi
done
for cxx in g++ clang++; do
    if command -v $cxx >/dev/null; then
        cxx_compilers="$cxx_compilers $cxx"
    else
        echo "skipped: no $cxx"
    fi
done
[ -n "$c_compilers" ] || c_compilers=" cc"

contract=-ffp-contract=off
echo 'int main(void) { return 0; }' >"$out/empty.c"
${c_compilers##* } $contract "$out/empty.c" -o "$out/empty" 2>/dev/null || contract=

# ---- the builds: one line each, `compiler flags`, what takes longest first. -O2 without asserts, as a user
#      would ship it

for cc in $c_compilers; do
    echo 'int main(void) { return 0; }' >"$out/empty.c"
    # shellcheck disable=SC2086
    if $cc $sanitize "$out/empty.c" -o "$out/empty" 2>/dev/null && "$out/empty" 2>/dev/null; then
        echo "$cc -std=c99 -O1 $sanitize"
        echo "$cc -std=c99 -O1 $sanitize -DECPSIM_FLOAT"
    else
        echo "skipped: $cc has no sanitizers" >&2
    fi
done >"$out/builds"
for flags in -O0 '-O2 -DNDEBUG' '-O2 -DECPSIM_FLOAT'; do
    for cc in $c_compilers; do echo "$cc -std=c99 $flags"; done
    for cxx in $cxx_compilers; do echo "$cxx -x c++ -std=c++11 $flags"; done
done >>"$out/builds"
builds=$(wc -l <"$out/builds")

# builds and runs the line number $1; its sum goes to $out/$1.sum
run_build() {
    flags=$(sed -n "$1p" "$out/builds")
    log=$out/$1.log
    # shellcheck disable=SC2086
    if ! $flags $contract $warn tests/main.c -o "$out/$1" -lm >"$log" 2>&1; then
        echo "0 passed, 1 failed" >"$out/$1.sum"
        head -n 20 "$log"
        echo "not built: $flags"
        return
    fi
    (cd "$out" && "./$1" ${filter:+"$filter"}) >"$log" 2>&1
    status=$?
    last=$(tail -n 1 "$log")
    case $last in
    *' passed, 0 failed') [ $status -eq 0 ] || last= ;;
    *' passed, '*' failed') grep 'failed: ' "$log" | head -n 20 ;;
    *) last= ;;
    esac
    if [ -z "$last" ]; then
        last='0 passed, 1 failed'
        tail -n 20 "$log"
        echo "exit status $status: $flags"
    fi
    echo "$last" >"$out/$1.sum"
    echo "$flags: $last"
}

# as many at a time as there are cores; each takes the next line that no other has
cores=$(getconf _NPROCESSORS_ONLN 2>/dev/null) || cores=2
run_what_is_left() {
    n=1
    while [ "$n" -le "$builds" ]; do
        if mkdir "$out/taken.$n" 2>/dev/null; then run_build "$n"; fi
        n=$((n + 1))
    done
}
begin=$(date +%s)
worker=1
while [ "$worker" -le "$cores" ]; do
    run_what_is_left &
    worker=$((worker + 1))
done
wait
echo "part builds: $(($(date +%s) - begin)) s"
n=1
while [ $n -le "$builds" ]; do
    if read -r p _ f _ <"$out/$n.sum"; then
        passed=$((passed + p))
        failed=$((failed + f))
    else
        failed=$((failed + 1))
    fi
    n=$((n + 1))
done

# ---- the same bits from every build (compilers that contract a * b + c are told not to)

same_bits() { [ "$(grep -h "^bits of $1" "$out"/*.log | sort -u | wc -l)" -eq 1 ]; }

if [ -z "$filter" ]; then
    check 'the same bits in double' same_bits double
    check 'the same bits in float' same_bits float
    grep -h '^T7 in' "$out"/*.log | sort -u
    grep -h '^bits of' "$out"/*.log | sort | uniq -c | sed 's/^/builds with /'
fi

# ---- how the header may be included and linked

cc=${c_compilers# }
cc=${cc%% *}
cxx=${cxx_compilers# }
cxx=${cxx%% *}

# a unit that uses the library, and returns 0 if it works; its function is called $1
unit() {
    cat <<EOF
#include "$root/ecpsim.h"
#ifdef __cplusplus
extern "C"
#endif
int $1(void);
int $1(void)
{
    ecp_shape ball;
    ecp_mass mass;
    if (ecp_shape_sphere(&ball, 1) != ECP_OK) return 1;
    ecp_shape_mass(&ball, 1, &mass);
    return !(mass.mass > (ecp_real)4.18 && mass.mass < (ecp_real)4.19);
}
EOF
}

# one of the two units, compiled: object NAME FUNCTION COMPILER FLAGS...
object() {
    name=$1
    unit "$2" >"$out/$name.c"
    shift 2
    # shellcheck disable=SC2086
    "$@" $warn -c "$out/$name.c" -o "$out/$name.o"
}

# two objects, linked and run by the compiler $1
link() {
    $1 "$out/main.o" "$out/first.o" "$out/second.o" -o "$out/linked" -lm && "$out/linked"
}

test_links() {
    echo 'int first(void), second(void); int main(void) { return first() || second(); }' \
        >"$out/main.c"
    "$cc" -c "$out/main.c" -o "$out/main.o"
    check 'static unit' object first first "$cc" -std=c99 -DECPSIM_STATIC -DECPSIM_IMPLEMENTATION
    check 'static unit' object second second "$cc" -std=c99 -DECPSIM_STATIC -DECPSIM_IMPLEMENTATION
    check 'two static units link' link "$cc"

    check 'implementation' object first first "$cc" -std=c99 -DECPSIM_IMPLEMENTATION
    check 'declarations alone' object second second "$cc" -std=c99
    check 'implementation and declarations link' link "$cc"
    check 'declarations in float' object second second "$cc" -std=c99 -DECPSIM_FLOAT
    check 'units of two real types do not link' refuse link "$cc"
    check 'implementation in float' object first first "$cc" -std=c99 -DECPSIM_FLOAT \
        -DECPSIM_IMPLEMENTATION
    check 'units in float link' link "$cc"

    {
        echo "#include \"$root/ecpsim.h\""
        echo "#include \"$root/ecpsim.h\""
        echo '#define ECPSIM_IMPLEMENTATION'
        echo "#include \"$root/ecpsim.h\""
        unit first
    } >"$out/first.c"
    # shellcheck disable=SC2086
    check 'included four times' "$cc" -std=c99 $warn -c "$out/first.c" -o "$out/first.o"
    check 'declarations alone' object second second "$cc" -std=c99
    check 'included four times, it links' link "$cc"

    if [ -z "$cxx" ]; then
        echo 'skipped: C with C++, there is no C++ compiler'
        return
    fi
    check 'C++ implementation' object first first "$cxx" -x c++ -std=c++11 -DECPSIM_IMPLEMENTATION
    check 'C declarations' object second second "$cc" -std=c99
    check 'C with a C++ implementation' link "$cxx"
    check 'C implementation' object first first "$cc" -std=c99 -DECPSIM_IMPLEMENTATION
    check 'C++ declarations' object second second "$cxx" -x c++ -std=c++11
    check 'C++ with a C implementation' link "$cxx"
}

# what an object defines and what it needs: `symbols FLAGS...` writes lines of nm
symbols() {
    "$cc" -std=c99 -O0 -fno-pic -ffunction-sections "$@" -DECPSIM_IMPLEMENTATION -c "$out/only.c" \
        -o "$out/only.o" && nm "$out/only.o" >"$out/symbols"
}

only() { # every line of the symbols with a type in $1 matches $2
    ! awk -v types="$1" 'index(types, $(NF - 1)) { print $NF }' "$out/symbols" | grep -Ev "$2"
}

test_symbols() {
    if ! command -v nm >/dev/null; then
        echo 'skipped: symbols, there is no nm'
        return
    fi
    echo "#include \"$root/ecpsim.h\"" >"$out/only.c"
    check 'symbols' symbols -DECPSIM_FLOAT
    check 'float: public names have their own prefix' only TDBCRV '^ecp_f32_'
    check 'float: needs sqrtf, memcpy, memset, assert' only U \
        '^(sqrtf|memcpy|memset|memmove|__assert_fail|__stack_chk_fail)$'
    check 'symbols' symbols
    check 'public names begin with ecp_' only TDBCRV '^ecp_'
    check 'and are not private ones' only TDBCRV '^ecp_($|[^i]|i[^_])'
    check 'needs sqrt, memcpy, memset, assert' only U \
        '^(sqrt|memcpy|memset|memmove|__assert_fail|__stack_chk_fail)$'
    check 'no writable data' only dDbBC '^$'
    check 'symbols' symbols -DECPSIM_STATIC
    check 'static: no public names' only TDBCRV '^$'
    check 'with nothing of the C library' symbols -DECPSIM_SQRT=my_sqrt -DECPSIM_MEMCPY=my_memcpy \
        -DECPSIM_MEMSET=my_memset '-DECPSIM_ASSERT(x)=((void)(x))' -include "$out/my.h"
    check 'it needs ours instead' only U '^my_(sqrt|memcpy|memset)$'
    check 'memcpy without memset is refused' refuse symbols -DECPSIM_MEMCPY=my_memcpy -include "$out/my.h"

    # a primitive that is not constructed is not in the program
    object first main "$cc" -std=c99 -O0 -fno-pic -ffunction-sections -fdata-sections \
        -DECPSIM_IMPLEMENTATION >/dev/null 2>&1
    if "$cc" -no-pie -Wl,--gc-sections "$out/first.o" -o "$out/linked" -lm 2>/dev/null; then
        nm "$out/linked" >"$out/symbols"
        check 'the sphere is linked' grep -q ecp_i_sphere_eval "$out/symbols"
        for kind in ellipsoid capsule cylinder frustum box polytope half_space; do
            check "the $kind is not" refuse grep -q "ecp_i_${kind}_eval" "$out/symbols"
        done
        # a step needs its own section, not the ones beside it
        check 'a program that steps' "$cc" -std=c99 -I. -no-pie -ffunction-sections \
            -fdata-sections -Wl,--gc-sections examples/minimal.c -o "$out/linked" -lm
        nm "$out/linked" >"$out/symbols"
        check 'the step is linked' grep -q ' ecp_step$' "$out/symbols"
        for name in dump i_put advance i_macro printed_residual mcp_solve least_squares i_polytope; do
            check "ecp_$name is not" refuse grep -q " ecp_$name" "$out/symbols"
        done
    else
        echo 'skipped: what is linked, the linker has no --gc-sections'
    fi
}

# ---- a step as C source does what the step does

# the two programs of tests/dump.c agree: dump NAME COMPILER FLAGS...
dump() {
    dumped=$out/$1
    shift
    # shellcheck disable=SC2086
    "$@" $contract $warn tests/dump.c -o "$dumped" -lm &&
        "$dumped" "$dumped.c" >"$dumped.log" &&
        "$@" $contract $warn "-DDUMPED=\"$dumped.c\"" tests/dump.c -o "$dumped" -lm &&
        "$dumped" | cmp - "$dumped.log"
}

# in double and in float side by side: dumps COMPILER FLAGS...
dumps() {
    dump dumped_float "$@" -DECPSIM_FLOAT &
    dump dumped "$@"
    code=$?
    wait $! && [ $code -eq 0 ]
}

test_dump() {
    for compiler in $c_compilers; do
        check "a step as source, $compiler" dumps "$compiler" -std=c99 -O1
    done
    for compiler in $cxx_compilers; do
        check "a step as source, $compiler" dumps "$compiler" -x c++ -std=c++11 -O1
    done
}

# ---- examples: short, without warnings, and with the results that are promised

lines_below() { [ "$(wc -l <"$1")" -lt "$2" ]; }

# an example by every C compiler, side by side: what it says itself, so not optimised
every_compiler() {
    jobs=
    code=0
    for compiler in $c_compilers; do
        # shellcheck disable=SC2086
        $compiler -std=c99 -O0 $warn -I. "$1" -o "$out/example.$compiler" -lm &
        jobs="$jobs $!"
    done
    for job in $jobs; do wait "$job" || code=1; done
    return $code
}

test_example_files() {
    for file in examples/*.c; do
        check "$file has under 150 lines" lines_below "$file" 150
        check "$file with$c_compilers" every_compiler "$file"
    done
}

# number EXAMPLE KEY: the number after KEY= in the line of the example
number() { sed -n "s/^$1: \(.* \)\{0,1\}$2=\([^ ]*\).*/\2/p" "$out/run.log"; }

# is $1 a number, and $1 $2 $3?
compare() {
    echo "$1" | grep -Eq '^[-+]?[0-9]+(\.[0-9]*)?([eE][-+]?[0-9]+)?$' || { echo "'$1'"; return 1; }
    awk -v a="$1" -v b="$3" "BEGIN { exit !(a + 0 $2 b + 0) }" || { echo "$1"; return 1; }
}

# bar EXAMPLE KEY RELATION LIMIT
bar() { check "$1 $2 $3 $4" compare "$(number "$1" "$2")" "$3" "$4"; }

test_example_results() {
    check 'make run' make -s run
    cp "$out/check.log" "$out/run.log"
    bar hammer load_N '==' "$(number hammer weight_N)"
    bar example1 steps '>=' 426
    bar example1 max_position_error_m '<=' 1e-12
    bar example1 max_impulse_error_Ns '<=' 1e-12
    bar example1 max_penetration_m '<=' 1e-12
    bar example1 newton_per_step '<=' 1.5
    bar example1_float max_position_error_m '<=' 5e-6
    bar example2 runs '==' 5
    bar example2 final_y_m '<=' 0.533512576
    bar example2 final_y_m '>=' 0.533512574
    bar example2 max_tilt_deg '<=' 44.2115
    bar example2 max_tilt_deg '>=' 44.2105
    bar example2 touch_s '==' 1.72
    bar example2 state_spread_m '<=' 1e-9
    bar example2 ecp_spread_sliding_m '>' 1e-2
    bar example2 ecp_spread_point_m '<=' 1e-9
    bar example2 max_penetration_m '<=' 1e-10
    bar example3 runs '==' 5
    bar example3 'rule=centred state_spread' '<=' 1e-9
    bar example3 'rule=nearest state_spread' '>=' 0
    bar printed_equations max_residual '<=' 1e-9
}

cat >"$out/my.h" <<'EOF'
#include <stddef.h>
double my_sqrt(double x);
void *my_memcpy(void *to, const void *from, size_t bytes);
void *my_memset(void *to, int value, size_t bytes);
EOF

# ---- a sample of the stress run: no step that counts as solved misses a bar, and no more remain
#      unsolved than are known (README, Limits); these numbers may only go down

known_double=0
known_float=0
known_float_advance=1

unsolved_within() {
    [ "$(sed -n 's/^stress:.* unsolved=\([0-9]*\) .*/\1/p' "$1")" -le "$2" ]
}

test_stress() {
    if ! "$cc" -std=c99 -O2 $contract tests/stress.c -o "$out/stress" -lm ||
        ! "$cc" -std=c99 -O2 $contract -DECPSIM_FLOAT tests/stress.c -o "$out/stress_float" -lm; then
        check 'the stress run compiles' false
        return
    fi
    "$out/stress_float" quick >"$out/stress_float.log" 2>&1 &
    "$out/stress" quick >"$out/stress.log" 2>&1
    code=$?
    wait $!
    grep -h '^stress:' "$out/stress.log" "$out/stress_float.log"
    check 'stress: what is solved keeps every bar' [ $((code & 2)) -eq 0 ]
    check 'stress: as many are solved as are known to be' \
        unsolved_within "$out/stress.log" $known_double
    "$out/stress_float" advance >"$out/stress_float_advance.log" 2>&1 &
    check 'stress, to each step'\''s time within a tolerance' "$out/stress" advance
    wait $!
    check 'the same in float' \
        unsolved_within "$out/stress_float_advance.log" $known_float_advance
    check 'stress, float' unsolved_within "$out/stress_float.log" $known_float
}

# every row of `make order` that docs/advance.md has: no more than twice its error (or rounding), and no more than
# 1.1 times its base steps. Scenes are made with the C library's sine, which is not the same everywhere.
order_rows() {
    awk 'NF < 9 || $1 == "scene" { next }
        { row = substr($0, 1, 34); $0 = substr($0, 35) }
        NR == FNR { error[row] = $1; solves[row] = $2; rows++; next }
        row in error {
            if ($1 > 2 * error[row] + 1e-13) print row ": error " $1 ", for " error[row]
            if ($2 > 1.1 * solves[row]) print row ": " $2 " base steps, for " solves[row]
            bad += $1 > 2 * error[row] + 1e-13 || $2 > 1.1 * solves[row]
            seen++
        }
        END { if (rows == 0 || seen < rows) print seen + 0 " rows of " rows; exit bad > 0 || rows == 0 || seen < rows }
        ' "$1" "$2"
}

test_order() {
    check 'order' make -s build/order
    build/order >"$out/order.txt"
    grep -E '^.{29}1e-[0-9]{2} ' docs/advance.md >"$out/order.rows"
    check 'order: as accurate and as cheap as docs/advance.md says' order_rows "$out/order.rows" "$out/order.txt"
}

# what is left out by macros, and the golden hashes of all compilers and machines
test_without() {
    for real in -UECPSIM_FLOAT -DECPSIM_FLOAT; do
        # shellcheck disable=SC2086
        check "what is left out $real" "$cc" -std=c99 -O1 $warn -DECPSIM_NO_PAIRS -DECPSIM_FALLBACKS=0 \
            $contract $real tests/without.c -o "$out/without" -lm
        check "and what is not $real" "$out/without"
        "$out/without" >"$out/without.some"
        # shellcheck disable=SC2086
        check "all that can be left out $real" "$cc" -std=c99 -O1 $warn -DECPSIM_NO_PAIRS \
            -DECPSIM_FALLBACKS=0 -DECPSIM_NO_FRICTION -DECPSIM_NO_SLEEP -DECPSIM_NO_CENTRING \
            $contract $real tests/without.c -o "$out/without" -lm
        check "and what is not $real" "$out/without"
        "$out/without" >"$out/without.all"
        check "the bits of balls without it $real" cmp "$out/without.some" "$out/without.all"
    done
}

test_hashes() {
    tests/hashes.sh >"$out/hashes.log" 2>&1
    code=$?
    grep '^skipped' "$out/hashes.log"
    tail -n 1 "$out/hashes.log"
    check 'golden hashes' sh -c "head -n 20 '$out/hashes.log'; exit $code"
}

# what fuzzing has found, and a sample of what it has tried
test_fuzz() {
    tests/fuzz.sh replay >"$out/fuzz.log" 2>&1
    code=$?
    grep -hE '^(skipped|replay)' "$out/fuzz.log"
    check 'the corpus of the fuzzers' sh -c "cat '$out/fuzz.log'; exit $code"
}

if [ -z "$filter" ]; then
    for part in stress order without fuzz hashes links symbols dump example_files example_results; do
        begin=$(date +%s)
        test_$part
        echo "part $part: $(($(date +%s) - begin)) s"
    done
fi

echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
