# Figure "Example 1" of the paper. From build/: gnuplot ../examples/table_translate.gp
set datafile separator ","
set terminal svg size 900,720 font "Helvetica,14" background "white"
set output "../docs/plots/table_translate.svg"
file = "table_translate.csv"
set multiplot layout 2,1 margins 0.11,0.97,0.09,0.92 spacing 0,0.13 \
    title "Example 1: the three-legged table slides to rest (h = 0.01 s)"
set grid lc rgb "#dddddd"
set border 3
set tics nomirror
set key top left reverse Left

set xlabel "t (s)"
set ylabel "contact impulse per step (N s)"
set xrange [0:5]
set yrange [-0.055:0.005]
plot file using 1:11 with lines lw 2 lc rgb "#c0392b" title "{/Symbol S} p_t, closed form", \
     "" using 1:5 every 12 with points pt 6 ps 0.7 lc rgb "#c0392b" title "{/Symbol S} p_t, ecpsim", \
     "" using 1:12 with lines lw 2 lc rgb "#2060a0" title "{/Symbol S} p_o, closed form", \
     "" using 1:6 every 12 with points pt 6 ps 0.7 lc rgb "#2060a0" title "{/Symbol S} p_o, ecpsim"

set key bottom right noreverse Right
set xlabel "x (m)"
set ylabel "y (m)"
set xrange [0:9]
set yrange [0:7]
plot file using 8:9 with lines lw 2 lc rgb "#c0392b" title "closed form", \
     "" using 2:3 every 12 with points pt 6 ps 0.7 lc rgb "#2060a0" title "ecpsim, every 12th step"
unset multiplot
