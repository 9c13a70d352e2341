#!/usr/bin/env bash
# Builds the release wheel of the Python package for this machine into OUT (default: target/wheels). One wheel serves
# every Python from 3.10 on (abi3). Its name contains the platform; on Linux this includes the oldest supported C
# library, which maturin determines from the linked symbols. Needs Rust, and Python 3.10 with venv.
# Usage: tools/wheels.sh [OUT] [maturin's options, such as --target aarch64-unknown-linux-gnu --zig]
set -euo pipefail
cd "$(dirname "$0")/.."

out=target/wheels
if [ $# -gt 0 ] && [ "${1#-}" = "$1" ]; then
    out=$1
    shift
fi
mkdir -p "$out" target/python
out=$(cd "$out" && pwd)

# The same version that pip uses.
pinned=$(sed -n 's/^requires = \["\(maturin==[0-9.]*\)"\]$/\1/p' python/pyproject.toml)
venv=$PWD/target/python/maturin
if [ "$(cat "$venv/.installed-from" 2>/dev/null)" != "$pinned" ]; then
    rm -rf "$venv"
    python3 -m venv "$venv"
    scripts=$([ -d "$venv/Scripts" ] && echo Scripts || echo bin)
    "$venv/$scripts/python" -m pip install --quiet --disable-pip-version-check "$pinned"
    echo "$pinned" >"$venv/.installed-from"
fi
scripts=$([ -d "$venv/Scripts" ] && echo Scripts || echo bin)

CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target} \
    "$venv/$scripts/maturin" build --profile wheel --locked --manifest-path python/Cargo.toml --out "$out" "$@"
ls -l "$out"
