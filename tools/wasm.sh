#!/usr/bin/env bash
# Builds the core for WebAssembly and runs it in Node: closings of a finger and a gripper must equal the program on this machine
# exactly, and so must every column of every preset in the explorer's module.
# This also shows that the core contains no C code, and that a closing needs no files, threads or clock.
# Uses the compiler of tools/explorer.sh and a module with both models. Requires Node 18.
# $PHALANX: another binary for the comparison.
set -euo pipefail
cd "$(dirname "$0")/.."

# shellcheck source=tools/need.sh
. tools/need.sh

node_works() { node -e 'process.exit(parseInt(process.versions.node) < 18 ? 1 : 0)'; }

need "the checks of the core in the browser" "Node 18 or later" "nodejs" node_works

built=$(realpath -m "${CARGO_TARGET_DIR:-target}")
FEATURES=figures tools/explorer.sh
export EXPLORER=$built/release/phalanx-explorer.wasm.gz

build_test_program
node --test tests/wasm/*.test.mjs
