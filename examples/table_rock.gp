# Figure "Example 2" of the paper, for both inertias. From build/: gnuplot ../examples/table_rock.gp
set datafile separator ","
set terminal svg size 900,960 font "Helvetica,14" background "white"
set grid lc rgb "#dddddd"
set border 3
set tics nomirror
set xrange [0:2.4]
WIDTH(run) = 7 - 1.4 * run # curves that coincide stay visible, one on the other
array colour[5] = ["#c0392b", "#2060a0", "#27864a", "#d08020", "#7d3c98"]

do for [name in "table_rock table_rock_x3"] {
    file = name . ".csv"
    # the phases, from which legs carry load (A1 = 1, A2 = 2, A3 = 4)
    stats file using ($1 == 0 && int($7) == 4 ? $2 : 1/0) name "TILT" nooutput
    stats file using ($1 == 0 && $2 > TILT_min && int($7) & 1 ? $2 : 1/0) name "BACK" nooutput
    stats file using ($1 == 0 && $2 >= BACK_min && int($7) & 4 ? $2 : 1/0) name "FLAT" nooutput
    rocks_on = FLAT_min > BACK_min + 0.05
    hit = TILT_min - 0.01

    set output "../docs/plots/" . name . ".svg"
    set multiplot layout 3,1 margins 0.11,0.97,0.07,0.91 spacing 0,0.07 \
        title "Example 2: the table slides, is hit at 0.75 s, tilts on A_{3}  and rocks back (h = 0.01 s" \
        . (name eq "table_rock" ? ")" : ", three times the inertia)")
    unset arrow
    unset label
    set arrow 1 from hit, graph 0 to hit, graph 1 nohead dt 2 lw 1.5 lc rgb "#555555"
    set arrow 2 from BACK_min, graph 0 to BACK_min, graph 1 nohead dt 2 lw 1.5 lc rgb "#555555"
    if (rocks_on) {
        set arrow 3 from FLAT_min, graph 0 to FLAT_min, graph 1 nohead dt 2 lw 1.5 lc rgb "#555555"
        set label 3 "A_1, A_2" at (BACK_min + FLAT_min) / 2, graph 1.04 center
    }
    set label 1 "sliding" at hit / 2, graph 1.04 center
    set label 2 "A_3" at (hit + BACK_min) / 2, graph 1.04 center
    set label 4 "all three" at ((rocks_on ? FLAT_min : BACK_min) + 2.4) / 2, graph 1.04 center
    set xlabel ""
    set key bottom right horizontal opaque

    set ylabel "x of ECP 1 (m)"
    set yrange [-0.40:-0.15]
    plot for [run = 0:4] file using 2:($1 == run ? $8 : 1/0) with lines lw WIDTH(run) lc rgb colour[run + 1] \
        title sprintf("guess %d", run + 1)
    unset key
    set ylabel "y of ECP 1 (m)"
    set yrange [-0.3:0.6]
    plot for [run = 0:4] file using 2:($1 == run ? $9 : 1/0) with lines lw WIDTH(run) lc rgb colour[run + 1] \
        title sprintf("guess %d", run + 1)
    set xlabel "t (s)"
    set ylabel "z of the centre (m)"
    set yrange [0.28:*]
    plot for [run = 0:4] file using 2:($1 == run ? $5 : 1/0) with lines lw WIDTH(run) lc rgb colour[run + 1] \
        title sprintf("guess %d", run + 1)
    unset multiplot
}
