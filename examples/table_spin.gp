# Figures of the paper's Example 3. From build/: gnuplot ../examples/table_spin.gp
set datafile separator ","
set terminal svg size 900,960 font "Helvetica,14" background "white"
set output "../docs/plots/table_spin.svg"
set multiplot layout 3,1 margins 0.11,0.97,0.07,0.92 spacing 0,0.09 \
    title "Example 3: a table of two legs slides and turns, five initial guesses (h = 0.01 s)"
file = "table_spin.csv"
set grid lc rgb "#dddddd"
set border 3
set tics nomirror
WIDTH(run) = 7 - 1.4 * run # curves that coincide stay visible, one on the other
ACROSS(x, y) = 1000 * (0.8 * y - 0.6 * x)
array colour[5] = ["#c0392b", "#2060a0", "#27864a", "#d08020", "#7d3c98"]

# the runs of one rule differ by millimetres in metres: shown across the line y = 3 x / 4
set key bottom left reverse Left
set xlabel "x (m)"
set ylabel "distance from y = 3 x / 4 (mm)"
plot for [run = 0:4] file using 4:(strcol(1) eq "nearest" && $2 == run ? ACROSS($4, $5) : 1/0) \
    with lines lw WIDTH(run) lc rgb colour[run + 1] title sprintf("rule nearest, guess %d", run + 1), \
    file using 4:(strcol(1) eq "centred" && $2 == 0 ? ACROSS($4, $5) : 1/0) \
    with lines lw 2 dt 2 lc rgb "black" title "rule centred, all guesses"

set xlabel ""
set xrange [0:5]
set ylabel "angle about the vertical (rad)"
plot for [run = 0:4] file using 3:(strcol(1) eq "nearest" && $2 == run ? $7 : 1/0) \
    with lines lw WIDTH(run) lc rgb colour[run + 1] notitle, \
    file using 3:(strcol(1) eq "centred" && $2 == 0 ? $7 : 1/0) \
    with lines lw 2 dt 2 lc rgb "black" notitle

set xlabel "t (s)"
set ylabel "p_{o}  of patch 1 (N s)"
plot for [run = 0:4] file using 3:(strcol(1) eq "nearest" && $2 == run ? $8 : 1/0) \
    with lines lw WIDTH(run) lc rgb colour[run + 1] notitle, \
    file using 3:(strcol(1) eq "centred" && $2 == 0 ? $8 : 1/0) \
    with lines lw 2 dt 2 lc rgb "black" notitle
unset multiplot
