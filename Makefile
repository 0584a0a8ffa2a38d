# make run     builds and runs the paper's examples
# make test    everything that is tested, with every compiler that is here
# make stress  two million steps of extreme scenes, in double and in float (stress-quick: a sample)
# make scale   time a step over the size of the scene
# make size    flash and RAM of scenes on a Cortex-M4F and x86-64 (needs gcc-arm-none-eabi, qemu)
# make firmware  programs without an operating system; firmware-test runs them under qemu
# make matrix  the header compiled in every way: compilers, standards, reals, linkage, macros
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

stress: build/stress build/stress_float
	@$(call both,full)

stress-quick: build/stress build/stress_float
	@$(call both,quick)

# both builds side by side, float to a file that follows; ^C ends the two
both = build/stress_float $(1) >build/stress_float.out 2>&1 & float=$$!; \
	trap 'kill $$float 2>/dev/null' EXIT; trap 'exit 130' INT TERM; \
	build/stress $(1) >build/stress.out; double=$$?; cat build/stress.out; \
	wait $$float; float_failed=$$?; cat build/stress_float.out; \
	exit $$((double | float_failed))

scale: build/scale
	@build/scale

build/stress: tests/stress.c tests/scene.h tests/distance.h ecpsim.h | build
	$(CC) -std=c99 $(CFLAGS) $(WARN) tests/stress.c -o $@ -lm

build/stress_float: tests/stress.c tests/scene.h tests/distance.h ecpsim.h | build
	$(CC) -std=c99 $(CFLAGS) $(WARN) -DECPSIM_FLOAT tests/stress.c -o $@ -lm

build/scale: tests/scale.c tests/scene.h ecpsim.h | build
	$(CC) -std=c99 $(CFLAGS) $(WARN) tests/scale.c -o $@ -lm

size:
	@tests/size.sh

firmware:
	@tests/firmware.sh build

firmware-test:
	@tests/firmware.sh

matrix:
	@tests/matrix.sh

plots: run
	@cd build && for p in ../examples/*.gp; do gnuplot $$p || exit 1; done

clean:
	rm -rf build

.PHONY: run test stress stress-quick scale size firmware firmware-test matrix plots clean
