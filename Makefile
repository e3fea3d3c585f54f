# Everything runs in a local .venv; the targets need Python >= 3.11, make, and nothing else.
PYTHON ?= python3
BIN := .venv/bin

# Blender as a Python package, 800 MB, in an environment of its own: it exists for one version of Python alone.
BLENDER ?= 4.5.15
BLENDER_PYTHON ?= python3.11

.PHONY: demo test floors docs figures pictures engines trust lint viewer lock clean

demo: .venv/ready
	$(BIN)/facezip demo -o out/demo --overwrite

test: .venv/ready
	$(BIN)/python -m pytest -rs --numprocesses auto --dist loadfile

# The same with the lowest versions that pyproject.toml allows, in an environment of its own: needs uv. The site has floors of its own.
FLOORS := .venv-floors/bin/python
floors:
	uv venv --quiet --clear --python python3.11 .venv-floors
	uv pip install --quiet --python $(FLOORS) --resolution lowest-direct --requirements pyproject.toml --extra dev
	uv pip install --quiet --python $(FLOORS) --no-deps --no-build-isolation --editable .
	NUMBA_CACHE_DIR=$(CURDIR)/.venv-floors/kernels $(FLOORS) -m facezip.commands.prepare
	NUMBA_CACHE_DIR=$(CURDIR)/.venv-floors/kernels $(FLOORS) -m pytest -rs --numprocesses auto --dist loadfile --ignore tests/test_site.py

# The site, out/site/index.html: strictly, so that a dead link or anchor is an error.
docs: .venv/ready
	$(BIN)/python -m reports.site

# Errors, bytes and times of every method and benchmark, benchmarks/*.csv, and the numbers of README.md and docs/: minutes.
figures: .venv/ready
	$(BIN)/python -m reports.kept

# The pictures of the documentation anew, of the demo's head: after a change of the head, the renderer or the pages.
SCANS_AND_PACK := out/demo/character out/demo/character.facezip
pictures: demo
	$(BIN)/facezip animate $(SCANS_AND_PACK) -o out/talk --resolution 288 --overwrite
	cp out/talk/animation.webp docs/talking.webp
	$(BIN)/python -m reports.portrait $(SCANS_AND_PACK) docs/portrait.webp
	$(BIN)/python -m reports.portrait $(SCANS_AND_PACK) docs/maps.webp side
	$(BIN)/python -m reports.people docs/people.webp studio
	$(BIN)/python -m reports.people docs/people_side.webp side
	$(BIN)/python -m reports.misplaced docs/alignment.webp
	$(BIN)/python -m tests.browser.pictures out/demo docs
	$(BIN)/python -m reports.timeline 2048 docs/timeline.svg

# Exports in Blender, USD and MaterialX, the verdict of the demo once more in Cycles, and a picture: tens of minutes.
engines: .venv/ready .venv-engines/ready
	$(BIN)/python -m pytest -rs tests/engines/test_blender.py tests/engines/test_judge.py tests/engines/test_usd.py
	test -d out/demo || $(MAKE) demo
	$(BIN)/python -m tests.engines.figures out/demo/character.facezip
	$(BIN)/python -m tests.engines.judge out/demo
	$(BIN)/python -m tests.engines.pictures out/demo docs/editors.webp

# Damage, kills, power cuts, refused calls, size claims, hostile names, mutants and fuzzing, as one table: 20 minutes.
trust: .venv/ready
	$(BIN)/python -m tests.trust

lint: .venv/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo --no-cache

# Setting up bundles the viewer where it can; this says why where it cannot, and checks the types too.
viewer: .venv/ready
	$(BIN)/python -m facezip.viewer.build --check

# The build warns of an editable installation, and of the viewer's bundle, which is data: both are meant.
.venv/ready: requirements.txt pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.txt
	PYTHONWARNINGS=ignore $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	$(BIN)/python -m facezip.commands.prepare
	touch $@

.venv-engines/ready: Makefile
	$(BLENDER_PYTHON) -m venv .venv-engines
	.venv-engines/bin/python -m pip install --quiet --disable-pip-version-check bpy==$(BLENDER)
	touch $@

# Pins the dependencies of pyproject.toml for every Python from 3.11 on, with hashes and without addresses.
lock:
	uv pip compile pyproject.toml --extra dev --extra docs --extra fuzz --universal --python-version 3.11 --fork-strategy fewest \
	  --generate-hashes --no-emit-index-url --no-annotate --no-header --output-file requirements.txt

clean:
	rm -rf .venv .venv-engines .venv-floors out build *.egg-info facezip/viewer/bundle
