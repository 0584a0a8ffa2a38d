# make run     builds and runs the paper's examples
# make test    everything that is tested, with every compiler that is here
# make plots   the examples' CSV as SVG (needs gnuplot)
# make clean   removes build/

CC ?= cc
CFLAGS ?= -O2
WARN = -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion \
       -Wundef -Werror
EXAMPLES = minimal table_translate table_rock table_spin push_stool contact_modes solve_mcp

run: $(EXAMPLES:%=build/%) build/table_translate_float
	@cd build && ../examples/run.sh

build/%: examples/%.c examples/table.h ecpsim.h | build
	$(CC) -std=c99 $(CFLAGS) $(WARN) -I. $< -o $@ -lm

build/%_float: examples/%.c examples/table.h ecpsim.h | build
	$(CC) -std=c99 $(CFLAGS) $(WARN) -DECPSIM_FLOAT -I. $< -o $@ -lm

build:
	mkdir -p build

test: run
	@tests/run.sh

plots: run
	@cd build && for p in ../examples/*.gp; do gnuplot $$p || exit 1; done

clean:
	rm -rf build

.PHONY: run test plots clean
