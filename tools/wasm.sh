#!/usr/bin/env bash
# The core is built for the browser, and closes a finger and a gripper in Node as the program does on this machine, to the last digit;
# and so does the explorer's module with every scene that its page brings along, every column.
# That it builds says that there is no C in it; that it runs with nothing at hand, that a closing asks for no file, thread or clock.
# Takes the compiler that tools/explorer.sh takes; the module has both models for once. Needs Node 18 too.
# $PHALANX names another binary to compare with.
set -euo pipefail
cd "$(dirname "$0")/.."

# shellcheck source=tools/need.sh
. tools/need.sh

node_works() { node -e 'process.exit(parseInt(process.versions.node) < 18 ? 1 : 0)'; }

need "the checks of the core in the browser" "Node 18 or later" "nodejs" node_works

built=$(realpath -m "${CARGO_TARGET_DIR:-target}")
FEATURES=figures tools/explorer.sh
export EXPLORER=$built/release/phalanx-explorer.wasm.gz

program_as_tested
node --test tests/wasm/*.test.mjs
