# ldbench.  `make` needs gfortran and LAPACK only; the rest uses .venv, made by ./bootstrap.
FC      = gfortran
LIBS    = -llapack -lblas
WARN    = -Wall -Wextra -std=f2018 -fimplicit-none
ifeq ($(DEBUG),1)
  BUILD  = build/debug
  FFLAGS = -Og -g -fopenmp -frecursive -fcheck=all,no-array-temps -ffpe-trap=invalid,zero,overflow -fbacktrace
else
  BUILD  = build/release
  FFLAGS = -O3 -g -fopenmp -flto=auto -frecursive -ffp-contract=off
endif
# -frecursive: no local variable is static, runs may go on in several threads.
# -ffp-contract=off: the same numbers whatever was inlined where.
PYTHON  = .venv/bin/python

# The modules in the order of a run.
MODULES = kinds errors system text progress terminal case curve formats parts mending profile measures hertz \
          geometry halfspace patches contact bspline potential reach samples refine ratios table accuracy table_file \
          bracket rigid wheelset modes newmark \
          gaps bilateral unilateral rigid_motion events columns simulation report
OBJECTS = $(MODULES:%=$(BUILD)/%.o)
EXE     = $(if $(filter 1,$(DEBUG)),ldbench-debug,ldbench)
WRAPPER = build/wrapper/installed

# For what Python runs.
export LDBENCH = $(CURDIR)/$(EXE)
export LDBENCH_TESTS = $(CURDIR)/$(BUILD)/tests

.PHONY: all wrapper test report validate bench reference clean help
all: $(EXE) $(if $(wildcard $(PYTHON)),$(WRAPPER))

$(EXE): $(BUILD)/ldbench.o $(OBJECTS)
	$(FC) $(FFLAGS) -o $@ $^ $(LIBS)

$(BUILD)/%.o: fortran/%.f90 Makefile | $(BUILD)
	$(FC) $(FFLAGS) $(WARN) -fPIC -J $(BUILD) -c -o $@ $<

$(BUILD):
	mkdir -p $@

# A module's object is made after those of the modules it uses.
$(BUILD)/depend.mk: $(MODULES:%=fortran/%.f90) fortran/ldbench.f90 | $(BUILD)
	@for m in $(MODULES) ldbench; do \
	  for u in $$(sed -n 's/^ *use  *\([a-z_0-9]*\).*/\1/p' fortran/$$m.f90 | sort -u); do \
	    if test -f fortran/$$u.f90; then echo "$(BUILD)/$$m.o: $(BUILD)/$$u.o"; fi; \
	  done; \
	done > $@
ifeq ($(filter clean help,$(MAKECMDGOALS)),)
-include $(BUILD)/depend.mk
endif

# Programs that the tests run on the modules themselves.
SHARED = $(BUILD)/tests/shared.o
TESTS  = $(patsubst tests/fortran/%.f90,$(BUILD)/tests/%,$(filter-out %/shared.f90,$(wildcard tests/fortran/*.f90)))

$(BUILD)/tests/%: tests/fortran/%.f90 $(SHARED) $(OBJECTS)
	$(FC) $(FFLAGS) $(WARN) -I $(BUILD) -J $(BUILD)/tests -o $@ $< $(SHARED) $(OBJECTS) $(LIBS)

$(SHARED): tests/fortran/shared.f90 $(OBJECTS) | $(BUILD)/tests
	$(FC) $(FFLAGS) $(WARN) -I $(BUILD) -J $(BUILD)/tests -c -o $@ $<

$(BUILD)/tests:
	mkdir -p $@

# The Python extension, built in place by the same meson.build as `pip install .`; .venv finds the package here.
wrapper: $(WRAPPER)

$(WRAPPER): build/wrapper/build.ninja $(MODULES:%=fortran/%.f90) $(wildcard wrappers/ldbench/*.f90)
	MAKEFLAGS= PATH="$(CURDIR)/.venv/bin:$$PATH" ninja -C build/wrapper --quiet
	install build/wrapper/_flat*.so wrappers/ldbench/
	echo $(CURDIR)/wrappers > $$($(PYTHON) -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/ldbench.pth
	touch $@

build/wrapper/build.ninja: meson.build .venv/stamp
	rm -rf build/wrapper
	PATH="$(CURDIR)/.venv/bin:$$PATH" meson setup build/wrapper

.venv/stamp:
	@echo 'no .venv: run ./bootstrap' >&2; exit 1

test: $(EXE) $(TESTS) $(WRAPPER)
	$(PYTHON) -m pytest tests

report: all
	$(PYTHON) -m ldbench report

validate: all $(TESTS)
	$(PYTHON) tests/validation

bench: all $(TESTS)
	$(PYTHON) tests/bench $(if $(FULL),--full)
	$(PYTHON) tests/view_speed.py

reference: $(EXE) $(WRAPPER)
	$(if $(filter 1,$(DEBUG)),$(error references are those of the release build))$(PYTHON) tests/reference.py --store
	$(PYTHON) tests/rigid_reference.py --store

clean:
	rm -rf build ldbench ldbench-debug wrappers/ldbench/_flat*.so

help:
	@echo 'make            the executable ldbench; where .venv is, the Python extension too'
	@echo 'make wrapper    the Python extension (after ./bootstrap)'
	@echo 'make test       the tests (after ./bootstrap)'
	@echo 'make report     the submission in outputs/: columns, plots, abstract, summary, a page'
	@echo 'make validate   every result against an independent answer: outputs/ldbench_validation.pdf, validation.csv'
	@echo 'make bench      what a run costs, against other integrators and the floor: outputs/ldbench_bench.pdf, bench.csv; speed of pages;'
	@echo '                FULL=1: all cases, methods and members'
	@echo 'make reference  run the ten cases and store compact references in outputs/reference'
	@echo 'make clean      remove everything that make made'
	@echo 'DEBUG=1         with make, test, report, validate: run-time checks and floating-point traps'
