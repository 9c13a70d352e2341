#!/usr/bin/env bash
# Real clients read what phalanx writes: Python (mcap, Rerun), Node (@mcap/core) and headless Chromium (the page).
# They are installed once, into target/clients and tests/clients/node_modules, and again when what is pinned in
# tests/clients changes. Needs Python 3.11 with venv, Node 18 with npm, and Chromium or Chrome.
# Usage: tools/clients.sh [setup]        (setup: install, test nothing)
# $PHALANX names another binary, $CHROMIUM another browser, $PHALANX_EXPLORER a module of the explorer that is there.
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
# The shell has no windows to draw, and takes less than half of the processor's time.
need "$clients" "Chromium or Chrome" "chromium-headless-shell|chromium" browser
CHROMIUM=$(browser)
export CHROMIUM

# Whether DIRECTORY has been filled from exactly these inputs; anything else there is thrown away.
# Usage: stale DIRECTORY SUM
stale() {
    [ "$(cat "$1/.installed-from" 2>/dev/null)" = "$2" ] && return 1
    rm -rf "$1"
}

venv=$PWD/target/clients/venv
wanted=$( (python3 --version; pwd; cat tests/clients/requirements.txt) | cksum)
if stale "$venv" "$wanted"; then
    say "clients: installing tests/clients/requirements.txt"
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check --no-compile -r tests/clients/requirements.txt
    echo "$wanted" >"$venv/.installed-from"
fi

wanted=$( (node --version; cat tests/clients/package-lock.json) | cksum)
if stale tests/clients/node_modules "$wanted"; then
    say "clients: installing tests/clients/package-lock.json"
    (cd tests/clients && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error)
    echo "$wanted" >tests/clients/node_modules/.installed-from
fi

if [ "${1:-}" = setup ]; then
    exit
fi

program_as_tested

# The explorer needs a compiler for the browser; all else is tested without one.
scripts=(tests/clients/*.test.mjs)
if [ -z "${PHALANX_EXPLORER:-}" ] && tools/explorer.sh; then
    PHALANX_EXPLORER=$(realpath "${CARGO_TARGET_DIR:-target}")/release/phalanx-explorer.wasm.gz
fi
if [ -n "${PHALANX_EXPLORER:-}" ]; then
    export PHALANX_EXPLORER
else
    echo "clients: the explorer is not tested, for there is no compiler for it" >&2
    scripts=(tests/clients/log.test.mjs tests/clients/page.test.mjs tests/clients/volume.test.mjs)
fi

say "clients: Python"
"$venv/bin/python" -m unittest discover --start-directory tests/clients --pattern 'test_*.py'

say "clients: Node"
node --test "${scripts[@]}"
