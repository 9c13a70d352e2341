#!/usr/bin/env bash
# Tests the output of phalanx with real clients: Python (mcap, Rerun), Node (@mcap/core) and headless Chromium (pages).
# The clients are installed into target/clients and tests/clients/node_modules, and reinstalled when the pinned versions in
# tests/clients change. Requires Python 3.11 with venv, Node 18 with npm, and Chromium or Chrome.
# Usage: tools/clients.sh [setup]        (setup: install only)
# $PHALANX: another binary, $PHALANX_CAMPAIGN: another generator of random scenes, $CHROMIUM: another browser,
# $PHALANX_EXPLORER: an existing module of the explorer.
set -euo pipefail
cd "$(dirname "$0")/.."

# shellcheck source=tools/need.sh
. tools/need.sh
clients="the tests with real clients"

python_works() { python3 -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))'; }
node_works() { npm --version && node -e 'process.exit(parseInt(process.versions.node) < 18 ? 1 : 0)'; }
browser() {
    if [ -n "${CHROMIUM:-}" ]; then
        command -v "$CHROMIUM"
    else
        command -v chromium-headless-shell || command -v chromium || command -v chromium-browser || command -v google-chrome
    fi
}

need "$clients" "Python 3.11 or later with venv" "python3 python3-venv" python_works
need "$clients" "Node 18 or later with npm" "nodejs npm" node_works
# chromium-headless-shell needs less than half of the CPU time of chromium.
need "$clients" "Chromium or Chrome" "chromium-headless-shell|chromium" browser
CHROMIUM=$(browser)
export CHROMIUM

# Whether DIRECTORY was not installed from inputs with this checksum; if so, removes it.
# Usage: stale DIRECTORY SUM
stale() {
    [ "$(cat "$1/.installed-from" 2>/dev/null)" = "$2" ] && return 1
    rm -rf "$1"
}

venv=$PWD/target/clients/venv
checksum=$( (python3 --version; pwd; cat tests/clients/requirements.txt) | cksum)
if stale "$venv" "$checksum"; then
    say "clients: installing tests/clients/requirements.txt"
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check --no-compile -r tests/clients/requirements.txt
    echo "$checksum" >"$venv/.installed-from"
fi

checksum=$( (node --version; cat tests/clients/package-lock.json) | cksum)
if stale tests/clients/node_modules "$checksum"; then
    say "clients: installing tests/clients/package-lock.json"
    (cd tests/clients && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error)
    echo "$checksum" >tests/clients/node_modules/.installed-from
fi

if [ "${1:-}" = setup ]; then
    exit
fi

build_test_program
build_campaign

# The explorer requires a compiler for WebAssembly; all other tests run without it.
scripts=(tests/clients/*.test.mjs)
if [ -z "${PHALANX_EXPLORER:-}" ] && tools/explorer.sh; then
    PHALANX_EXPLORER=$(realpath "${CARGO_TARGET_DIR:-target}")/release/phalanx-explorer.wasm.gz
fi
if [ -n "${PHALANX_EXPLORER:-}" ]; then
    export PHALANX_EXPLORER
else
    echo "clients: the explorer is not tested because there is no compiler for WebAssembly" >&2
    scripts=(tests/clients/log.test.mjs tests/clients/page.test.mjs)
fi

say "clients: Python"
"$venv/bin/python" -m unittest discover --start-directory tests/clients --pattern 'test_*.py'

say "clients: Node"
node --test "${scripts[@]}"
