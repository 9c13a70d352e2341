#!/usr/bin/env bash
# Builds the release wheel of the Python package for this machine into OUT (default: target/wheels). One wheel serves
# every Python from 3.10 on (abi3). Its name contains the platform; on Linux this includes the oldest supported C
# library, which maturin determines from the linked symbols. Needs Rust, and Python 3.10 with venv.
# On Linux, `--compatibility manylinux2014 --zig` links against an older C library than that of this machine (glibc 2.17), so
# that the wheel runs on all present distributions; zig comes from PyPI.
# Usage: tools/wheels.sh [OUT] [maturin's options]
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
tools=(ziglang==0.17.1 twine==7.0.0)
venv=$PWD/target/python/maturin
if [ "$(cat "$venv/.installed-from" 2>/dev/null)" != "$pinned ${tools[*]}" ]; then
    rm -rf "$venv"
    python3 -m venv "$venv"
    scripts=$([ -d "$venv/Scripts" ] && echo Scripts || echo bin)
    "$venv/$scripts/python" -m pip install --quiet --disable-pip-version-check "$pinned" "${tools[@]}"
    echo "$pinned ${tools[*]}" >"$venv/.installed-from"
fi
scripts=$([ -d "$venv/Scripts" ] && echo Scripts || echo bin)

# For the zig of the environment.
PATH=$venv/$scripts:$PATH CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target} \
    "$venv/$scripts/maturin" build --profile wheel --locked --sdist --manifest-path python/Cargo.toml --out "$out" "$@"
# The metadata for PyPI, and the licences: links in python/, which are texts without meaning in a checkout without links.
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"$/\1/p' Cargo.toml)
"$venv/$scripts/python" -m twine check --strict "$out"/phalanx-"$version"*
"$venv/$scripts/python" - "$out" "$version" <<'PYTHON'
import sys, zipfile
from pathlib import Path

out, version = Path(sys.argv[1]), sys.argv[2]
for wheel in out.glob(f"phalanx-{version}-*.whl"):
    with zipfile.ZipFile(wheel) as archive:
        for name in ["LICENSE-APACHE", "LICENSE-MIT", "THIRD-PARTY.txt"]:
            packed = archive.read(f"phalanx-{version}.dist-info/licenses/{name}")
            if packed.splitlines() != Path(name).read_bytes().splitlines():
                sys.exit(f"{wheel}: {name} is not that of the repository")
PYTHON
ls -l "$out"
