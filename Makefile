# `make help` lists what there is. Needed: a Rust toolchain (rustup's, with rustfmt and clippy) and a C linker.

SHELL := bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
.PHONY: help build pack pages plots unpack reproduce controllers sweeps population data-efficiency repair check robot test test-python test-browser wheel dist bench blind campaign peers peers-learning peers-environments scaling real verify

# Repetitions of every experiment, data and training included. Claims need ten, and only ten replace the published results;
# any other number is a look, which goes to out/.
SEEDS ?= 10
OUT := $(if $(filter 10,$(SEEDS)),.,out)
FIRST := $(addprefix experiments/,table1.yaml fig6.yaml)
SPECS := $(FIRST) $(addprefix experiments/,fig5.yaml fig8.yaml no_gap.yaml)
# The blind cases of a look: of each batch of experiments/discovery.yaml the share that SEEDS is of ten.
share = --set 'runs.discovery.batches[$(1)].cases='$$(( ($(2) * $(SEEDS) + 9) / 10 ))
BLIND_LOOK := $(if $(filter 10,$(SEEDS)),,$(call share,0,4) $(call share,1,23) $(call share,2,2) $(call share,3,3) \
  $(call share,4,2) $(call share,5,23))
PEERS_VENV := target/peers-venv
PYTHON_VENV := target/python-venv
# Where there is Python (3.10 or later), its package is compiled and looked at beside the program.
PACKAGES := $(if $(shell python3 -c 'import sys; assert sys.version_info >= (3, 10)' 2>/dev/null && echo yes),--workspace)
SPINEBENCH := cargo run --release --quiet --

help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## /  make \1\t/p' $(MAKEFILE_LIST) | expand -t 20

build:
	cargo build --release

# Published rows of single trials, steps and samples are Parquet, but for Table I and Fig. 6; git ignores those of population.
RAW = $(filter-out $(patsubst %,results/%/trials.csv,table1 fig6 population),\
  $(wildcard $(patsubst %,results/*/%.csv,trials tracks responses repair_trials gap)))
PACK = $(if $(filter .,$(OUT)),@$(MAKE) --no-print-directory pack)
pack: build ## rows of results/ to Parquet, as they are published
	@# Figs 5 and 8 have one gap: the second table is a link to the first.
	@! [ -L results/fig8/gap.parquet ] || { cp results/fig8/gap.parquet results/fig8/gap && mv results/fig8/gap{,.parquet}; }
	$(if $(RAW),$(SPINEBENCH) pack $(RAW))
	@if cmp -s results/fig{5,8}/gap.parquet; then ln -sf ../fig5/gap.parquet results/fig8/gap.parquet; fi

# Pages with generated parts: tables, pictures with captions, effects, help.
PAGES = $(shell grep -rl --include='*.md' 'begin:' README.md docs)
UPDATE_PAGES = @$(MAKE) --no-print-directory pages
pages: build ## the generated parts of README.md and docs/
	$(SPINEBENCH) effects --plots plots/effects
	$(SPINEBENCH) page $(PAGES)

plots: build ## the published figures again, from results/ alone (a minute)
	$(SPINEBENCH) plot

unpack: build ## rows of results/ back to CSV, byte for byte
	$(SPINEBENCH) pack --undo $(wildcard results/*/*.parquet)

reproduce: build ## Table I, Figs 5, 6 and 8 and the claims, into results/ and plots/; SEEDS=1 for a look, into out/
	$(SPINEBENCH) run $(FIRST) --seeds $(SEEDS) --out $(OUT)
	@echo "Table I is in $(OUT)/results/table1/table1.md and $(OUT)/plots/table1.png, Fig. 6 in $(OUT)/plots/fig6.png."
	$(SPINEBENCH) run $(SPECS) --seeds $(SEEDS) --out $(OUT)
	$(SPINEBENCH) run experiments/discovery.yaml $(BLIND_LOOK) --out $(OUT)
	$(SPINEBENCH) report --results $(OUT)
ifeq ($(OUT),.)
	@$(MAKE) --no-print-directory pack
	@$(MAKE) --no-print-directory pages
else
	@echo "A look at $(SEEDS) of ten repetitions is in $(OUT)/; the published results/ and plots/ are as they were."
endif

# Rows of the real robots as benches/real/real.py --convert writes them; without them, these robots do not play.
REAL_ROWS ?=
league: build ## baselines of the league and its board, into results/league (hours; needs Python with venv, and PyPI); REAL_ROWS=DIR with the real robots
	python3 -m venv $(PYTHON_VENV)
	$(PYTHON_VENV)/bin/python -m pip install --quiet --disable-pip-version-check ./python -r benches/league/requirements.txt "mujoco[sysid]"
	PATH="$(CURDIR)/$(PYTHON_VENV)/bin:$$PATH" python3 -B benches/league/baselines.py $(OUT)/results/league --program target/release/spinebench $(if $(REAL_ROWS),--measured $(REAL_ROWS))
	mkdir -p $(OUT)/plots/league && mv $(OUT)/results/league/board_*_* $(OUT)/plots/league
	$(if $(filter .,$(OUT)),$(UPDATE_PAGES))

ROBOT := target/tmp/robot
robot: build ## the README's moving picture, plots/robot.gif: Fig. 8's path under two policies, and `discover` before and after
	$(SPINEBENCH) discover --model models/nominal.yaml --measured tests/data/twin/r12.csv --baseline tests/data/twin/baseline.csv --out $(ROBOT)
	$(SPINEBENCH) view --record plots/robot.gif results/fig8 tests/data/twin/r12.csv --training paper --policy a --policy c \
	  --model models/nominal.yaml --model $(ROBOT)/model.yaml

controllers: build ## further controllers beside the paper's, and what tells them apart (docs/method/control.md); SEEDS=1 for a look, into out/
	$(SPINEBENCH) run experiments/controllers.yaml experiments/perfect_model.yaml --seeds $(SEEDS) --out $(OUT)
	$(PACK)
	$(if $(filter .,$(OUT)),$(UPDATE_PAGES))

SWEEPS := $(sort $(wildcard experiments/sweeps/*.yaml)) experiments/gp_intervals.yaml
sweeps: build ## kernels, sizes, thresholds, noise, gaps … swept (half an hour; docs/evidence/sweeps.md); SEEDS=1 for a look, into out/
	$(SPINEBENCH) run $(SWEEPS) --seeds $(SEEDS) --out $(OUT)
	$(PACK)

# Claims are judged robot by robot: a hundred of them, not ten repetitions.
ROBOTS ?= 100
population: build ## Table I on a hundred robots (an hour; docs/evidence/population.md); ROBOTS=10 for a look, into out/
	@# A drawn robot that cannot be simulated is a row with its status, of which exit status 1 tells.
	$(SPINEBENCH) run experiments/population.yaml --seeds $(ROBOTS) --out $(if $(filter 100,$(ROBOTS)),.,out) || [ $$? = 1 ]
	$(if $(filter 100,$(ROBOTS)),$(UPDATE_PAGES))

data-efficiency: build ## error against the number of real points, every policy (a quarter of an hour; docs/evidence/data_efficiency.md); SEEDS=1 for a look
	$(SPINEBENCH) run experiments/data_efficiency.yaml --seeds $(SEEDS) --out $(OUT)
	$(PACK)
	$(if $(filter .,$(OUT)),$(UPDATE_PAGES))

repair: build ## a robot changes and nobody says so: noticed, named and mended (docs/evidence/repair.md); SEEDS=1 for a look, into out/
	$(SPINEBENCH) run experiments/repair.yaml --seeds $(SEEDS) --out $(OUT)
	$(PACK)
	$(if $(filter .,$(OUT)),$(UPDATE_PAGES))

# `cargo fmt` does not follow the modules that registries declare.
SOURCES := $(shell find src -name '*.rs')

# Tests run side by side under `cargo nextest` where it is installed, program by program under `cargo test` where not.
# Incremental compilation keeps a rebuild after an edit short.
check test test-browser campaign: export CARGO_INCREMENTAL = 1
NEXTEST := $(shell cargo nextest --version 2>/dev/null | head -1)

check: ## while you work (3 minutes): format, lints, unit and contract tests, one `discover` per verdict
	cargo fmt --check
	rustfmt --check --edition 2024 $(SOURCES)
	cargo clippy --release $(PACKAGES) --all-targets -- -D warnings
ifdef NEXTEST
	cargo nextest run --release --lib --test contract --test discovery -E 'not binary(discovery) or test(/^per_verdict::/)'
else
	cargo test --release --lib --test contract
	cargo test --release --test discovery per_verdict::
endif

test: ## all tests (12 minutes): format, lints, all tests, documentation
	cargo fmt --check
	rustfmt --check --edition 2024 $(SOURCES)
	cargo clippy --release $(PACKAGES) --all-targets -- -D warnings
ifdef NEXTEST
	cargo nextest run --release
else
	cargo test --release --no-fail-fast --lib --bins --tests
endif
	cargo test --release --doc
	RUSTDOCFLAGS="-D warnings" cargo doc --release --no-deps

# The package is built like the program, into the same folder, and tested in an environment of its own.
test-python: ## the Python package: build, tests, types (needs Python 3.10 or later with venv, and PyPI)
	python3 -m venv $(PYTHON_VENV)
	$(PYTHON_VENV)/bin/python -m pip install --quiet --disable-pip-version-check "./python[test]"
	cd python && ../$(PYTHON_VENV)/bin/python -m pytest -q
	$(PYTHON_VENV)/bin/python -m mypy --strict -p spinebench
	cd python/tests && ../../$(PYTHON_VENV)/bin/python -m mypy --strict .
	@# The robots of another engine, and a submission that learns from its samples of each.
	$(PYTHON_VENV)/bin/python -m pip install --quiet --disable-pip-version-check -r benches/league/requirements.txt
	$(PYTHON_VENV)/bin/python -B benches/league/test_serve.py
	PATH="$(CURDIR)/$(PYTHON_VENV)/bin:$$PATH" $(SPINEBENCH) league check experiments/league/example
	rm -rf target/tmp/league{,_cache} && mkdir -p target/tmp && cp -r experiments/league/example target/tmp/league
	echo 'robots: [paper]' >> target/tmp/league/submission.yaml
	PATH="$(CURDIR)/$(PYTHON_VENV)/bin:$$PATH" $(SPINEBENCH) league score target/tmp/league --cache target/tmp/league_cache

BROWSER_VENV := target/browser-venv
test-browser: build ## pages in a browser: live view, player, reports (needs Python with venv, PyPI, and Chromium or $$CHROMIUM)
	python3 -m venv $(BROWSER_VENV)
	$(BROWSER_VENV)/bin/python -m pip install --quiet --disable-pip-version-check "playwright>=1.50,<2" "axe-playwright-python>=0.1,<0.2" "pytest>=8,<10"
	$(BROWSER_VENV)/bin/python -B -m pytest -q -p no:cacheprovider tests/browser

BOOK := target/book
REPOSITORY := https://github.com/spinebench/spinebench/blob/main
book: ## the manual as HTML, into target/book/html (compiles mdBook the first time)
	@[ -x target/tools/bin/mdbook ] || cargo install --quiet mdbook --version 0.5.4 --locked --root target/tools
	rm -rf $(BOOK) && mkdir -p $(BOOK)/src && cp -r docs plots $(BOOK)/src && cp docs/book.toml $(BOOK)
	@# mdBook has the pages and plots; links to other files lead to the repository.
	sed -e 's#](#](docs/#' -e 's#docs/README#README#' docs/SUMMARY.md > $(BOOK)/src/SUMMARY.md
	sed -e 's#\[SUMMARY.md\](SUMMARY.md) lists#The list on the left has#' -e 's#](#](docs/#g' docs/README.md > $(BOOK)/src/README.md
	rm $(BOOK)/src/docs/{README,SUMMARY}.md
	find $(BOOK)/src/docs -name '*.md' -exec perl -pi -e \
	  's#\]\((?:\.\./)++((?!plots|guide|reference|method|evidence)[^)]*)\)#]($(REPOSITORY)/$$1)#g' {} +
	target/tools/bin/mdbook build $(BOOK)
	$(if $(PACKAGES),python3 tests/browser/book_links.py $(BOOK)/html)
	@echo "$(BOOK)/html/index.html"

# What one installs without Rust.
DIST := dist
TRIPLE := $(shell rustc -vV | sed -n 's/^host: //p')
VERSION := $(shell sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
RELEASE := spinebench-$(VERSION)-$(TRIPLE)

wheel: ## the Python package as a wheel for Python 3.10 and later, into dist/ (needs Python with venv, and PyPI)
	python3 -m venv $(PYTHON_VENV)
	$(PYTHON_VENV)/bin/python -m pip install --quiet --disable-pip-version-check "maturin>=1.8,<2"
	$(PYTHON_VENV)/bin/maturin build --release --locked --manifest-path python/Cargo.toml --out $(DIST)

dist: ## the program, which needs no library on Linux, with models and experiments, into dist/ with checksums
	@# The flag is the program's alone, so that compiled dependencies serve here, too.
	cargo rustc --release --locked --bin spinebench -- -C target-feature=+crt-static
	rm -rf $(DIST)/$(RELEASE) && mkdir -p $(DIST)/$(RELEASE)
	cp -r $${CARGO_TARGET_DIR:-target}/release/spinebench README.md LICENSE-* docs models experiments $(DIST)/$(RELEASE)
	strip $(DIST)/$(RELEASE)/spinebench
	tar -C $(DIST) -czf $(DIST)/$(RELEASE).tar.gz $(RELEASE) && rm -r $(DIST)/$(RELEASE)
	cd $(DIST) && files=(*.tar.gz *.whl) && \
	for file in "$${files[@]}"; do [ ! -f "$$file" ] || openssl dgst -sha256 -r "$$file"; done > SHA256SUMS
	@echo "$(DIST)/$(RELEASE).tar.gz, $(DIST)/SHA256SUMS"

bench: build ## microbenchmarks, then one repetition of everything from nothing: where the time goes, by stage
	cargo bench
	@scratch=$$(mktemp -d) && trap 'rm -rf "$$scratch"' EXIT && \
	$(SPINEBENCH) run $(SPECS) --seeds 1 --out "$$scratch" --cache "$$scratch/cache"

# Parts of the blind benchmark, 164 cases each.
PARTS ?= 7
blind: build ## `discover` on 1,148 blind cases (hours; PARTS=1 for a seventh): docs/evidence/blind_benchmark.md
	$(SPINEBENCH) run experiments/discovery_full.yaml --seeds $(PARTS) --out $(if $(filter 7,$(PARTS)),.,out)
	$(SPINEBENCH) run experiments/discovery_twin.yaml --out $(if $(filter 7,$(PARTS)),.,out)
	$(if $(filter 7,$(PARTS)),$(UPDATE_PAGES))

campaign: ## the long tests (hours): 200 kills, every case of `discover`, 100,000 random robots (CAMPAIGN_DRAWS=1000 for a look)
	mkdir -p results/robustness
	KILLS=200 cargo test --release --test program kills
	cargo test --release --test program -- --ignored
	cargo test --release --test discovery -- --ignored
	cargo test --release --test hardware campaign_ -- --ignored
	cargo test --release --test rod a_hundred_intervals -- --ignored
	cargo test --release --test rod ten_thousand -- --ignored --nocapture
	WORKSPACE_STEPS=100000 cargo test --release --test rod inside_the_workspace
	CAMPAIGN_OUT=results/robustness/campaign.csv cargo test --release --test rod full_campaign -- --ignored --nocapture

# What others wrote, in an environment of its own, one package after the other: what cannot be installed is named and skipped.
PEER_LISTS := benches/peers/requirements.txt benches/peers/learning/requirements.txt benches/peers/environments/requirements.txt
define peer-packages
	@python3 -m venv $(PEERS_VENV) || echo "peers: there is no Python with venv"
	@for package in $$(sed 's/#.*//' $(1)); do \
	  $(PEERS_VENV)/bin/python -m pip install --quiet --disable-pip-version-check $(PEER_LISTS:%=--constraint %) "$$package" || \
	  echo "peers: $$package could not be installed"; done
endef
# Ours is measured as its users have it: installed, from Python.
define measure-environments
	$(PEERS_VENV)/bin/python -m pip install --quiet --disable-pip-version-check ./python
	$(PEERS) -- cases $(CURDIR)/target/tmp/environments
	$(PEERS_VENV)/bin/python -B benches/peers/environments/compare.py target/tmp/environments \
	  $(if $(filter-out 5,$(or $(ROUNDS),5)),target/tmp/environments/look,results/peers) $(or $(ROUNDS),5)
endef
PEERS := PEERS_PYTHON=$(CURDIR)/$(PEERS_VENV)/bin/python cargo bench --bench peers

peers: build ## other simulators and other packages for learning: results/peers, plots/peers* (docs/evidence/peers.md)
	$(call peer-packages,$(PEER_LISTS))
	$(PEERS)
	$(measure-environments)
	$(UPDATE_PAGES)

peers-learning: build ## the packages for learning alone (ROUNDS=1 for a look, which publishes nothing)
	$(call peer-packages,benches/peers/learning/requirements.txt)
	$(PEERS) -- learning
	$(UPDATE_PAGES)

peers-environments: build ## environments of others alone (ROUNDS=1 for a look, which publishes nothing)
	$(call peer-packages,benches/peers/requirements.txt benches/peers/environments/requirements.txt)
	$(measure-environments)
	$(UPDATE_PAGES)

scaling: build ## runs on one and two threads, and a cluster on paper: results/scaling, plots/scaling (docs/evidence/scaling.md)
	cargo bench --bench scaling
	$(UPDATE_PAGES)

# Files that others published, which are not part of this repository; benches/real/sources.py says where they are.
REAL_DATA ?= ../shared/recordings
real: ## models of four published robots from REAL_DATA (10 minutes): models/real, results/real, plots/real (docs/evidence/real_robots.md)
	@python3 -B benches/real/real.py --check $(REAL_DATA)
	@$(MAKE) --no-print-directory build
	python3 -B benches/real/real.py $(REAL_DATA) target/release/spinebench
	$(UPDATE_PAGES)

verify: build ## rerun from nothing what `reproduce` makes and compare with the published results/ and plots/, byte for byte
	$(SPINEBENCH) verify $(notdir $(basename $(SPECS))) discovery
