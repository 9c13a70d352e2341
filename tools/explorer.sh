#!/usr/bin/env bash
# Builds the explorer's module for the browser, packs it, and puts it beside the program, where `phalanx explore` finds it; with a
# program there, writes the page too. With --install it puts it beside the program that `cargo install` has installed.
# Usage: tools/explorer.sh [--install | OUT.html]
# Takes the target of the toolchain where it is installed (rustup target add wasm32-unknown-unknown), and otherwise Debian's
# compiler, which builds std from its source. Where Binaryen's wasm-opt is at hand (Debian: binaryen), $OPTIMISE=1 makes the module a
# tenth smaller, in a minute. $FEATURES are more of its features: `figures` is what tests the core.
set -euo pipefail
cd "$(dirname "$0")/.."

# shellcheck source=tools/need.sh
. tools/need.sh
# shellcheck source=tools/browser_target.sh
. tools/browser_target.sh

if [ "${1:-}" = --install ]; then
    PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
    if ! program=$(command -v phalanx); then
        echo "tools/explorer.sh --install: there is no phalanx beside which to put the module; first: cargo install --path . --locked" >&2
        exit 2
    fi
fi
browser_target "the explorer"
# Whole, without the realpath of GNU: releases are made on macOS too.
built=${CARGO_TARGET_DIR:-target}
mkdir -p "$built"
built=$(cd "$built" && pwd)
say "explorer: the module"
"${build[@]}" --release --locked --quiet --manifest-path crates/explorer/Cargo.toml ${FEATURES:+--features "$FEATURES"} --target "$target" --target-dir "$built/wasm"
module=$built/wasm/$target/release/phalanx_explorer.wasm
if [ -n "${OPTIMISE:-}" ]; then
    wasm-opt -O2 --enable-bulk-memory --enable-nontrapping-float-to-int --enable-sign-ext --enable-mutable-globals "$module" -o "$module.small"
    module=$module.small
fi

# For programs of every profile: each looks beside itself.
packed=phalanx-explorer.wasm.gz
mkdir -p "$built/debug" "$built/release"
gzip -9 --no-name --stdout "$module" >"$built/$packed.partial"
cp "$built/$packed.partial" "$built/debug/$packed"
mv "$built/$packed.partial" "$built/release/$packed"
echo "$built/release/$packed: $(stat --format=%s "$built/release/$packed" 2>/dev/null || stat -f %z "$built/release/$packed") bytes"

if [ -n "${program:-}" ]; then
    cp "$built/release/$packed" "$(dirname "$program")/$packed"
    echo "$(dirname "$program")/$packed: beside the installed program"
elif [ -n "${1:-}" ]; then
    PHALANX=${PHALANX:-$built/release/phalanx}
    [ -x "$PHALANX" ] || cargo build --release --locked --quiet
    "$PHALANX" explore --module "$built/release/$packed" --out "$1"
fi
