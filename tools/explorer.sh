#!/usr/bin/env bash
# Builds the explorer's WebAssembly module, compresses it, and copies it next to the program, where `phalanx explore` finds it.
# With OUT.html it also writes the page. With --install it copies the module next to the program installed by `cargo install`.
# Usage: tools/explorer.sh [--install | OUT.html]
# Uses the toolchain's target if it is installed (rustup target add wasm32-unknown-unknown), otherwise Debian's compiler, which
# builds std from source. $OPTIMISE=1 runs Binaryen's wasm-opt (Debian: binaryen), which makes the module a tenth smaller in a
# minute. $FEATURES: additional features; `figures` is for tests of the core. $EXPLORER_PROFILE: another profile of Cargo than `release`;
# `checks` builds faster.
set -euo pipefail
cd "$(dirname "$0")/.."

# shellcheck source=tools/need.sh
. tools/need.sh
# shellcheck source=tools/browser_target.sh
. tools/browser_target.sh

if [ "${1:-}" = --install ]; then
    PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin
    if ! program=$(command -v phalanx); then
        echo "tools/explorer.sh --install: no installed phalanx was found; first run: cargo install --path . --locked" >&2
        exit 2
    fi
fi
browser_target "the explorer"
# An absolute path without GNU realpath, because releases are also built on macOS.
built=${CARGO_TARGET_DIR:-target}
mkdir -p "$built"
built=$(cd "$built" && pwd)
profile=${EXPLORER_PROFILE:-release}
say "explorer: the module"
"${build[@]}" --profile "$profile" --locked --quiet --manifest-path crates/explorer/Cargo.toml ${FEATURES:+--features "$FEATURES"} --target "$target" --target-dir "$built/wasm"
module=$built/wasm/$target/$profile/phalanx_explorer.wasm
if [ -n "${OPTIMISE:-}" ]; then
    wasm-opt -O2 --enable-bulk-memory --enable-nontrapping-float-to-int --enable-sign-ext --enable-mutable-globals "$module" -o "$module.small"
    module=$module.small
fi

# For the programs of both profiles: each searches its own directory.
packed=phalanx-explorer.wasm.gz
mkdir -p "$built/debug" "$built/release"
gzip -9 --no-name --stdout "$module" >"$built/$packed.partial"
cp "$built/$packed.partial" "$built/debug/$packed"
mv "$built/$packed.partial" "$built/release/$packed"
echo "$built/release/$packed: $(stat --format=%s "$built/release/$packed" 2>/dev/null || stat -f %z "$built/release/$packed") bytes"

if [ -n "${program:-}" ]; then
    cp "$built/release/$packed" "$(dirname "$program")/$packed"
    echo "$(dirname "$program")/$packed: next to the installed program"
elif [ -n "${1:-}" ]; then
    PHALANX=${PHALANX:-$built/release/phalanx}
    [ -x "$PHALANX" ] || cargo build --release --locked --quiet
    "$PHALANX" explore --module "$built/release/$packed" --out "$1"
fi
