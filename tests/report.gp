# Plots of the report. From the root: gnuplot tests/report.gp
set datafile separator ","
set terminal svg size 980,620 font "Helvetica,13" background "white"
set grid lc rgb "#e4e4e4"
set border 3
set tics nomirror
set logscale xy
set format x "10^{%L}"
set format y "10^{%L}"
set key outside right top reverse Left font ",10" samplen 2 maxrows 40 spacing 0.85
FLOOR(x) = x < 1e-17 ? 1e-17 : x

# names of the methods that have something in a column, as words: blanks are written as ~
methods(file, column) = system("awk -F, 'NR > 1 && $" . column . " != \"\" && !seen[$2]++ { gsub(/ /, \"~\", $2); print $2 }' " . file)
NAME(m) = system("printf %s '" . m . "' | tr '~' ' '")
# the rows of one method
ROWS(file, m) = "< awk -F, -v OFS=, -v m='" . m . "' '{ gsub(/ /, \"~\", $2) } $2 == m' " . file
is(m, start) = strstrt(m, start) == 1
# ours in blue, by ecp_advance in black and greys, the peers each in a hue of its own
HUE(m) = is(m, "ours~advance") ? 0x000000 : is(m, "ours~float~advance") ? 0x909090 : \
    is(m, "ours~order") ? 0x606060 : is(m, "ours~float") ? 0x30a0a0 : is(m, "ours") ? 0x1848c8 : is(m, "ODE") ? 0xe08020 : \
    is(m, "Bullet~double") ? 0x60a030 : is(m, "Bullet") ? 0x207830 : is(m, "Siconos") ? 0xc02030 : 0x904098
POINT(m, i) = 1 + i % 13
WIDTH(m) = is(m, "ours~advance") ? 2.2 : is(m, "ours~order") ? 1.4 : 1

titles = "t1 t2 t2_rest t3 t4_one t4_four t5_stick t5_slip t5_slip_30 t5_rock t5_impact t6 t7 fall landing cube stack"
do for [scene in titles] {
    file = "docs/report/" . scene . ".csv"
    all = methods(file, 9)
    set output "docs/report/" . scene . ".svg"
    set title system("grep -A 2 -n -m 1 -F 'report/" . scene . ".svg' docs/report.md | sed -n 's/.*!\\[\\(.*\\)\\](.*/\\1/p'") noenhanced
    set xlabel "run time (ms)"
    set ylabel "error against the continuous motion" offset 1
    plot for [i = 1:words(all)] ROWS(file, word(all, i)) using 8:(FLOOR($9)) \
        with linespoints lc rgb HUE(word(all, i)) pt POINT(word(all, i), i) ps 0.6 \
        lw WIDTH(word(all, i)) title NAME(word(all, i)) noenhanced
}

file = "docs/report/legs.csv"
all = methods(file, 5)
set output "docs/report/legs.svg"
set multiplot layout 1,2 title "A body slides on n legs"
set title ""
set logscale x 2
set format x "%g"
set xlabel "patches"
set ylabel "us a step"
unset key
plot for [i = 1:words(all)] ROWS(file, word(all, i)) using 3:5 \
    with linespoints lc rgb HUE(word(all, i)) pt POINT(word(all, i), i) ps 0.6 notitle
set ylabel "unknowns"
set key outside right top reverse Left font ",9" samplen 2
all = methods(file, 4)
plot for [i = 1:words(all)] ROWS(file, word(all, i)) using 3:4 \
    with linespoints lc rgb HUE(word(all, i)) pt POINT(word(all, i), i) ps 0.6 \
    title NAME(word(all, i)) noenhanced
unset multiplot
