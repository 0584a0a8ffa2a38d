# make run     builds and runs the paper's examples
# make test    the tests, with every compiler that is here: on two cores about three quarters of an hour
# make stress  three million steps of extreme scenes in double, and as many in float (stress-quick: a sample;
#              build/stress advance: a sample by ecp_advance)
# make order   error and cost of ecp_advance against closed forms, for tolerances 1e-3 .. 1e-10
# make scale   time a step over the size of the scene
# make size    flash and RAM of scenes on a Cortex-M4F and x86-64 (needs gcc-arm-none-eabi, qemu)
# make firmware  programs without an operating system; firmware-test runs them under qemu
# make hashes  the bits of fixed scenes for all compilers and machines that are here against
#              tests/hashes.txt; hashes-accept writes that table, after a change that is meant
# make fuzz    the public API with hostile bytes, 10 million calls (fuzz-quick: some minutes; fuzz-afl: AFL++)
# make matrix  the header compiled in every way: compilers, standards, reals, linkage, macros
# make report  error against run time, ours and the peers' that are here: docs/report.md
#              (SCENE=t3: that scene alone, to build/report_out; build/report quick: a sample)
# make plots   the examples' CSV as SVG (needs gnuplot)
# make clean   removes build/

CC ?= cc
CFLAGS ?= -O2
WARN = -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion \
       -Wundef -Werror
EXAMPLES = minimal hammer table_translate table_rock table_spin push_stool contact_modes solve_mcp advance

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

order: build/order
	@build/order

scale: build/scale
	@build/scale

build/stress: tests/stress.c tests/scene.h tests/distance.h ecpsim.h | build
	$(CC) -std=c99 $(CFLAGS) $(WARN) tests/stress.c -o $@ -lm

build/stress_float: tests/stress.c tests/scene.h tests/distance.h ecpsim.h | build
	$(CC) -std=c99 $(CFLAGS) $(WARN) -DECPSIM_FLOAT tests/stress.c -o $@ -lm

build/order: tests/order.c tests/truths.h ecpsim.h | build
	$(CC) -std=c99 $(CFLAGS) -Wall -Wextra -Wpedantic -Wshadow tests/order.c -o $@ -lm

build/scale: tests/scale.c tests/scene.h ecpsim.h | build
	$(CC) -std=c99 $(CFLAGS) $(WARN) tests/scale.c -o $@ -lm

size:
	@tests/size.sh

firmware:
	@tests/firmware.sh build

firmware-test:
	@tests/firmware.sh

hashes:
	@tests/hashes.sh

hashes-accept:
	@tests/hashes.sh accept

fuzz:
	@tests/fuzz.sh

fuzz-quick:
	@tests/fuzz.sh quick

fuzz-afl:
	@tests/fuzz.sh afl

matrix:
	@tests/matrix.sh

plots: run
	@cd build && for p in ../examples/*.gp; do gnuplot $$p || exit 1; done

# ---- the report. What it compares us with is looked for when it is asked for, and named if absent

report: build/report
	@OPENBLAS_NUM_THREADS=1 build/report $(SCENE)

REPORT_FLAGS = -std=c99 $(CFLAGS) -Wall -Wextra
REPORT_SOURCES = tests/report.c tests/report_write.c tests/report_scenes.c
REPORT_HEADERS = tests/report.h tests/report_scenes.h tests/report_table.h tests/truths.h

# the name of each peer that pkg-config, or the compiler, or MUJOCO_DIR knows
peers = $(shell pkg-config --exists ode && echo ode; \
	pkg-config --exists bullet && echo bullet; pkg-config --exists bullet-float64 && echo bullet64; \
	echo '#include <siconos/numerics/NonSmoothDrivers.h>' | $(CC) $(SICONOS) -E - >/dev/null 2>&1 && \
	echo siconos; test -e "$(MUJOCO_DIR)/include/mujoco/mujoco.h" && echo mujoco)
SICONOS = -isystem /usr/include/siconos -isystem /usr/include/siconos/numerics
SICONOS_VERSION = $(shell dpkg-query -W -f '$${Version}' libsiconos-numerics-dev 2>/dev/null || \
	echo version unknown)
version_of = $(shell pkg-config --modversion $(1))
flags_of = $(patsubst -I%,-isystem %,$(shell pkg-config --cflags $(1))) -DVERSION='"$(call version_of,$(1))"'
libs_of = $(shell pkg-config --libs $(1))
PEER = $(CC) $(REPORT_FLAGS) -D_GNU_SOURCE -fPIC -shared
PEER_CXX = $(CXX) $(CFLAGS) -Wall -Wextra -fPIC -shared

build/report_double.o: tests/report_ours.c tests/report.h ecpsim.h | build
	$(CC) $(REPORT_FLAGS) -c $< -o $@

build/report_float.o: tests/report_ours.c tests/report.h ecpsim.h | build
	$(CC) $(REPORT_FLAGS) -DECPSIM_FLOAT -c $< -o $@

build/peer_ode.so: tests/peers/ode.c tests/report.h | build
	$(PEER) $(call flags_of,ode) $< -o $@ $(call libs_of,ode)

build/peer_bullet.so: tests/peers/bullet.cpp tests/report.h | build
	$(PEER_CXX) $(call flags_of,bullet) $< -o $@ $(call libs_of,bullet)

build/peer_bullet64.so: tests/peers/bullet.cpp tests/report.h | build
	$(PEER_CXX) $(call flags_of,bullet-float64) $< -o $@ $(call libs_of,bullet-float64)

build/peer_siconos.so: tests/peers/siconos.c tests/report.h | build
	$(PEER) $(SICONOS) -DVERSION='"$(SICONOS_VERSION)"' $< -o $@ -lsiconos_numerics -lm

build/peer_mujoco.so: tests/peers/mujoco.c tests/report.h | build
	$(PEER) -isystem $(MUJOCO_DIR)/include $< -o $@ -L$(MUJOCO_DIR)/lib -Wl,-rpath,$(MUJOCO_DIR)/lib -lmujoco

.SECONDEXPANSION:
build/report: $(REPORT_SOURCES) $(REPORT_HEADERS) build/report_double.o build/report_float.o \
		$$(addsuffix .so,$$(addprefix build/peer_,$$(peers)))
	$(CC) $(REPORT_FLAGS) -D_GNU_SOURCE -DCOMPILER='"$(CC)"' -DFLAGS='"$(REPORT_FLAGS)"' \
		$(REPORT_SOURCES) build/report_double.o build/report_float.o -o $@ -lm -ldl

clean:
	rm -rf build

.PHONY: run test stress stress-quick order scale size firmware firmware-test hashes \
	hashes-accept fuzz fuzz-quick fuzz-afl matrix report plots clean
