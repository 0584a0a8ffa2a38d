#!/bin/sh
# Runs the examples that stand in the current directory (`make run` calls this from build/), shows
# what they print, and gathers the paper's own equations over all their steps.
set -e

show() {
    printf '\n%s\n' "$1"
    shift
    for program in "$@"; do "./$program"; done
}

show 'A box dropped on a plane' minimal
show 'A hammer: a body of two primitives, on an edge of its head and the end of its handle' hammer
show 'Example 1: a table slides to rest, against the exact solution' table_translate table_translate_float
show 'Example 2: a table is hit, tilts on one leg and rocks back; five initial guesses' table_rock
show 'Example 3: a table of two legs slides and turns; five initial guesses' table_spin
show 'Figure 1: a finger pushes a stool and stops' push_stool
show 'Figure 2: point, line, surface, two and three patches, and a box that passes through them' \
    contact_modes
show 'The complementarity solver by itself' solve_mcp
show 'A rocking block to a time within a tolerance, against steps' advance

# the last column of every CSV file is the scaled residual of the printed equations after that step
printf '\nThe equations as the paper prints them, over all steps of the CSV files\n'
awk -F, 'FNR == 1 { if ($NF != "printed") bad = FILENAME; next }
         $NF !~ /^[0-9]/ { bad = FILENAME ": " $0 }
         $NF + 0 > worst { worst = $NF + 0 }
         END { if (bad) { print "not a residual in " bad; exit 1 }
               printf "printed_equations: max_residual=%.3e\n", worst }' \
    table_translate.csv table_rock.csv table_rock_x3.csv table_spin.csv push_stool.csv contact_modes.csv
