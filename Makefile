# The commands of the project; `make help` lists them.
# On Debian, what is missing is installed (by sudo where that is needed).

SHELL := /bin/bash
.DEFAULT_GOAL := help
export PATH := $(HOME)/.cargo/bin:$(PATH)

# CHOLMOD, METIS and BLAS; CGAL; what cargo needs to bind and link them.
PACKAGES := libsuitesparse-dev libmetis-dev libopenblas-dev libcgal-dev libclang-dev g++ pkg-config
# What reads the VTK files back in the tests.
TEST_PACKAGES := python3-venv
# What the comparison runs beside ours, and what checks both.
YADE_PACKAGES := yade python3-numpy python3-mpmath

# What else the contest runs. PARDISO comes from PyPI, faer from crates.io.
LAMMPS_PACKAGES := lammps openmpi-bin
PEER_PACKAGES := $(YADE_PACKAGES) $(LAMMPS_PACKAGES) python3-venv
PARDISO := pypardiso==0.4.7

MEMCHECK_PACKAGES := valgrind
VALGRIND := ["valgrind", "-q", "--error-exitcode=9", "--leak-check=full", "--show-leak-kinds=definite", \
	"--errors-for-leak-kinds=definite"]
UNDER_VALGRIND = cargo test --locked --config 'target."cfg(unix)".runner = $(VALGRIND)'

DEMO := out/oedometer
COMPARISON := out/compare-yade
CONTEST := out/compare-peers
PAPER := out/paper
EVERY_STEP := out/every-step
EFFECT_COSTS := out/effect-costs
ACCURACY := out/accuracy
ACCURACY_SCENES := caulk2020 oedometer impact sedimentation triaxial-undrained permeability
# Seconds that each reference may take.
ACCURACY_SECONDS := 10
# `--quick` has 1,000 spheres and a few intervals; without it YADE alone takes most of an hour.
ACCURACY_YADE := --quick
BUNDLE := out/bundle
WHEELS := out/wheels
PYTHON_VENV := out/python

# Everything with GPU support is built beside the rest: the features differ.
WITH_CUDA := --locked --features cuda --target-dir target/cuda
DEMPFV := target/release/dempfv

.PHONY: help build demo test lint torture fuzz vtk-test demo-test docs-test package-test memcheck racecheck \
	compare compare-test compare-yade yade-test paper every-step effect-costs accuracy cuda cuda-test bundle bench wheel python-test install-packages \
	install-test-packages install-yade install-lammps install-memcheck-packages install-peers

help: ## List these commands
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-14s %s\n", $$1, $$2}'

build: install-packages ## Build the program: target/release/dempfv
	cargo build --release --locked

demo: build ## Consolidate a saturated packing and compare it with Terzaghi (minutes)
	$(DEMPFV) run scenes/oedometer.toml --out $(DEMO) --force
	@echo "Pictures:     $(DEMO)/consolidation.png, profiles.png, section.png (and .svg)"
	@echo "Table:        $(DEMO)/consolidation.csv"
	@echo "For ParaView: $(DEMO)/pores.pvd, spheres.pvd"

test: install-packages install-test-packages ## Run every test that needs no GPU and no YADE
	cargo test --workspace --locked
	cargo test --workspace --locked --no-default-features --test without_evidence
	tests/vtk_read_back.sh

# Not part of `make test`: other compilers have other lints.
lint: install-packages
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked

# How much of each: `make torture DEMPFV_KILLS=1000 DEMPFV_SEED=7`, `make fuzz DEMPFV_INPUTS=10000000`.
TORTURE := DEMPFV_KILLS=200 DEMPFV_CHAINS=40 DEMPFV_SIGNALS=20 DEMPFV_CUTS=200 DEMPFV_FLIPS=2000 \
	DEMPFV_DISK_STRIDE=1 DEMPFV_ALLOCATIONS=400

torture: install-packages ## Kill runs, fill disks, starve memory, feed hostile input; nothing may be lost (a quarter of an hour)
	env $(TORTURE) $(MAKEOVERRIDES) cargo test --locked --test torture -- --nocapture --test-threads=1
	env DEMPFV_INPUTS=100000 $(MAKEOVERRIDES) cargo test --locked -p dempfv --test fuzz -- --nocapture
	env DEMPFV_PROPERTIES=2000 $(MAKEOVERRIDES) cargo test --locked -p dempfv --test properties

fuzz: install-packages ## A million hostile inputs through the readers and on to results (minutes)
	env DEMPFV_INPUTS=1000000 $(MAKEOVERRIDES) cargo test --locked -p dempfv --test fuzz -- --nocapture

# What `make demo` promises: the curve against Terzaghi, and files that VTK reads.
demo-test: demo install-test-packages
	python3 tests/check_demo.py $(DEMO)/summary.json
	tests/vtk_read_back.sh $(DEMO)

# docs.rs has none of the native libraries.
docs-test: install-packages
	tests/docs_rs.sh

# The crates are ready to publish: they build from their own packages.
package-test: install-packages
	tests/package.sh

compare: build install-peers ## Run YADE, LAMMPS, CHOLMOD, PARDISO, faer and ours; writes benches/report.md (an hour, goes on where it stopped)
	$(DEMPFV) compare peers --out $(CONTEST)
	mkdir -p benches/report
	rm -f benches/report/*.png
	cp $(CONTEST)/report/*.png benches/report/
	cp $(CONTEST)/report.md benches/report.md
	@echo "Report: benches/report.md; raw points in $(CONTEST)/points/"

# The contest on small packings, with what Debian has: that it works, not who wins.
compare-test: build install-yade install-lammps
	$(DEMPFV) compare peers --quick --without pardiso faer --force

compare-yade: build install-yade ## Run YADE on the same input, side by side; writes docs/yade.md (long)
	$(DEMPFV) compare yade --out $(COMPARISON) --force
	mkdir -p docs/yade
	rm -f docs/yade/*.png
	cp $(COMPARISON)/yade/*.png docs/yade/
	cp $(COMPARISON)/yade.md docs/yade.md
	@echo "Report: docs/yade.md, its figures in docs/yade/"

# The comparison on the two smallest packings, times left out, and remesh intervals on the smallest; fails
# where a bound does.
yade-test: build install-yade
	$(DEMPFV) compare yade packings/oedometer-1000.txt packings/oedometer-5000.txt \
	    --part network --part edges --part injection --part compressible --part periodic \
	    --part dry --part coupled --out out/yade-test --force
	$(DEMPFV) accuracy-yade --quick --out out/yade-test/accuracy --force

# Every way into CGAL, CHOLMOD and METIS, in the foreground and in the background, failures
# included. One thread for OpenBLAS: its others are valgrind's to run in turn.
memcheck: install-packages install-memcheck-packages ## Look for memory errors and leaks, under valgrind (minutes)
	OPENBLAS_NUM_THREADS=1 $(UNDER_VALGRIND) -p cgal-sys -p cholmod-sys
	OPENBLAS_NUM_THREADS=1 $(UNDER_VALGRIND) -p dempfv --test pfv_renewal --test coupling_failures -- --test-threads=1

# Needs a nightly toolchain with rust-src. What C++ and C do among themselves is not seen.
racecheck: install-packages ## Look for data races in the hand-over to the background, by ThreadSanitizer (minutes)
	RUSTFLAGS="-Zsanitizer=thread" TSAN_OPTIONS="halt_on_error=1" CARGO_TARGET_DIR=target/races \
		cargo +nightly test -Zbuild-std --target $(shell rustc -vV | sed -n 's/host: //p') --locked -p dempfv \
		--test coupling_background --test coupling_failures --test coupling_endurance

paper: build ## Measure the figures of Caulk et al. (2020); writes docs/paper.md (hours, goes on where it stopped)
	$(DEMPFV) paper --out $(PAPER)
	mkdir -p docs/paper
	rm -f docs/paper/*.png docs/paper/*.csv
	cp $(PAPER)/paper/*.png $(PAPER)/paper/*.csv docs/paper/
	cp $(PAPER)/paper.md docs/paper.md
	@echo "Report: docs/paper.md, its figures in docs/paper/; raw points in $(PAPER)/points/"

every-step: build ## Measure what following the spheres at every step costs and gains; writes docs/evidence/every-step.md (half an hour)
	$(DEMPFV) every-step --out $(EVERY_STEP) --force
	mkdir -p docs/evidence/every-step
	cp $(EVERY_STEP)/every-step/*.png $(EVERY_STEP)/every-step/*.csv docs/evidence/every-step/
	cp $(EVERY_STEP)/every-step.md docs/evidence/every-step.md

effect-costs: build ## Measure what each effect adds to the time of a step; writes docs/effect-costs.md (a quarter of an hour)
	$(DEMPFV) effect-costs --out $(EFFECT_COSTS) --force
	cp $(EFFECT_COSTS)/effect-costs.md $(EFFECT_COSTS)/effect-costs.csv docs/
	DEMPFV_WRITE_DOCS=1 cargo test --locked --test effects_page

accuracy: build install-yade ## Measure what accuracy costs in six scenes, YADE beside; fills docs/accuracy/ (an hour, goes on where it stopped)
	set -e; for scene in $(ACCURACY_SCENES); do \
	    test -f $(ACCURACY)/$$scene/accuracy.json || \
	        $(DEMPFV) accuracy scenes/$$scene.toml --seconds $(ACCURACY_SECONDS) --out $(ACCURACY)/$$scene; \
	    mkdir -p docs/accuracy/$$scene; \
	    cp $(ACCURACY)/$$scene/accuracy.md $(ACCURACY)/$$scene/*.png $(ACCURACY)/$$scene/accuracy.csv docs/accuracy/$$scene/; \
	done
	test -f $(ACCURACY)/yade/yade.json || $(DEMPFV) accuracy-yade $(ACCURACY_YADE) --out $(ACCURACY)/yade
	test -f $(ACCURACY)/volume/representative-volume.json || \
	    $(DEMPFV) representative-volume --out $(ACCURACY)/volume
	mkdir -p docs/accuracy/yade docs/accuracy/volume
	cp $(ACCURACY)/yade/yade.md $(ACCURACY)/yade/yade.csv $(ACCURACY)/yade/*.png docs/accuracy/yade/
	cp $(ACCURACY)/volume/*.md $(ACCURACY)/volume/*.csv $(ACCURACY)/volume/*.png docs/accuracy/volume/

cuda: install-packages install-test-packages ## Build with GPU support: target/cuda/release/dempfv (fetches what is missing)
	cholmod-sys/cuda/fetch.sh cuda
	cargo build --release $(WITH_CUDA)

# CHOLMOD's GPU code, walked on the CPU by a stand-in for CUDA. No GPU is needed,
# and one that is there is not used.
cuda-test: install-packages install-test-packages
	cholmod-sys/cuda/fetch.sh cuda
	cuda="$$(cholmod-sys/cuda/find.sh cuda)" && \
		cholmod-sys/cuda/standin/build.sh "$$cuda/include" target/cuda/standin
	cargo clippy --workspace --all-targets $(WITH_CUDA) -- -D warnings
	DEMPFV_CUDA_LIBRARIES=$(CURDIR)/target/cuda/standin OPENBLAS_NUM_THREADS=1 \
		cargo test $(WITH_CUDA) -p cholmod-sys -p dempfv -p dempfv-cli \
		--test solver --test solver_gpu --test solver_gpu_memory --test gpu --lib

bundle: cuda ## Pack the GPU program with its libraries for another machine: out/bundle
	gpu/bundle.sh target/cuda/release/dempfv $(BUNDLE)

# The wheel of this machine's libraries. Its Python is the system's: any from 3.11 on loads it.
wheel: install-packages install-test-packages ## Build the Python package: out/wheels
	@test -x $(WHEELS)/venv/bin/maturin || /usr/bin/python3 -m venv $(WHEELS)/venv
	$(WHEELS)/venv/bin/pip install --quiet --disable-pip-version-check 'maturin>=1.10,<2'
	cd python && ../$(WHEELS)/venv/bin/maturin build --release --locked --auditwheel skip --out ../$(WHEELS)

# Against the installed wheel and the program, from a folder without sources.
python-test: wheel build ## Test the Python package
	rm -rf $(PYTHON_VENV)
	/usr/bin/python3 -m venv $(PYTHON_VENV)
	$(PYTHON_VENV)/bin/pip install --quiet --disable-pip-version-check numpy scipy networkx tqdm pytest mypy
	$(PYTHON_VENV)/bin/pip install --quiet --disable-pip-version-check --no-deps --no-index \
	    --find-links $(WHEELS) dempfv
	DEMPFV_PROGRAM=$(CURDIR)/$(DEMPFV) $(PYTHON_VENV)/bin/pytest python/tests
	cd $(PYTHON_VENV) && bin/python -m mypy.stubtest dempfv --ignore-disjoint-bases

bench: install-packages ## Time a step, a network, a solve by criterion, beside the machine's limits (minutes)
	cargo bench --locked -p dempfv-evidence --bench dem --bench coupled

install-packages:
	@tests/install.sh $(PACKAGES)

install-test-packages:
	@tests/install.sh $(TEST_PACKAGES)

install-yade:
	@tests/install.sh $(YADE_PACKAGES)

install-lammps:
	@tests/install.sh $(LAMMPS_PACKAGES)

install-peers:
	@tests/install.sh $(PEER_PACKAGES)
	@test -x $(CONTEST)/venv/bin/python || /usr/bin/python3 -m venv $(CONTEST)/venv
	@$(CONTEST)/venv/bin/python -c "import pypardiso" 2>/dev/null || \
		$(CONTEST)/venv/bin/pip install --quiet --disable-pip-version-check $(PARDISO)
	cargo build --release --locked --manifest-path evidence/peers/faer/Cargo.toml --target-dir target/peers

install-memcheck-packages:
	@tests/install.sh $(MEMCHECK_PACKAGES)
