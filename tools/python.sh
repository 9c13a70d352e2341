#!/usr/bin/env bash
# Tests the installed Python package. `pip install ./python`, the command of a user, installs it into
# target/python/venv, and again when its sources change; it uses the build profile of the tests to share compiled
# crates. Needs Python 3.10 with venv.
# Usage: tools/python.sh [setup | requirements]        (setup: install only; requirements: without the package)
# $PHALANX names another binary.
set -euo pipefail
cd "$(dirname "$0")/.."

# shellcheck source=tools/need.sh
. tools/need.sh

python_works() { python3 -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 10))'; }
need "the tests of the Python package" "Python 3.10 or later with venv" "python3 python3-venv" python_works

export CARGO_INCREMENTAL=0
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target}
venv=$PWD/target/python/venv
mkdir -p target/python

requirements=$( (python3 --version; pwd; cat python/tests/requirements.txt python/pyproject.toml) | cksum)
if [ "$(cat "$venv/.installed-from" 2>/dev/null)" != "$requirements" ]; then
    say "Python: installing python/tests/requirements.txt"
    rm -rf "$venv"
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check --no-compile -r python/tests/requirements.txt
    echo "$requirements" >"$venv/.installed-from"
fi
if [ "${1:-}" = requirements ]; then
    exit
fi

# All files that are compiled into the package.
sources=$( (find src crates python/src python/phalanx -type f ! -path '*/__pycache__/*' -print0 | sort -z | xargs -0 cat
    cat Cargo.toml Cargo.lock python/Cargo.toml python/pyproject.toml python/README.md) | cksum)
if [ "$(cat "$venv/.phalanx-from" 2>/dev/null)" != "$sources" ]; then
    say "Python: pip install ./python"
    rm -f "$venv/.phalanx-from"
    MATURIN_PEP517_ARGS="--profile dev --features phalanx/png" "$venv/bin/pip" install --quiet --disable-pip-version-check --force-reinstall --no-deps ./python
    echo "$sources" >"$venv/.phalanx-from"
fi

if [ "${1:-}" = setup ]; then
    exit
fi

build_test_program
# Without a cache mypy needs a minute to analyse numpy and pandas.
export MYPY_CACHE_DIR=$PWD/target/python/mypy

say "Python: tests"
"$venv/bin/python" -m unittest discover --start-directory python/tests --pattern 'test_*.py'
