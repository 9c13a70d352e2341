#!/usr/bin/env bash
# Packs a release for one system: the program with the explorer's module, built from the lock file, manual pages,
# completions, licences (also of third parties) and README, into target/dist/phalanx-VERSION-TARGET.tar.gz (.zip for Windows), and its SHA-256
# into a separate file. The same commit gives the same archive: names are sorted, and all file times are the commit
# time.
# `tools/release.sh crates` instead packs the crates for crates.io into target/package, builds them from there against each
# other, and checks that the program's crate contains the explorer's module.
# Usage: tools/release.sh [TARGET | crates]      (default: the host of `rustc -vV`)
set -euo pipefail
cd "$(dirname "$0")/.."

# shellcheck source=tools/need.sh
. tools/need.sh

host=$(rustc -vV | sed -n 's/^host: //p')
target=${1:-$host}
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"$/\1/p' Cargo.toml)
[ -n "$version" ] || { echo "Cargo.toml has no version under [workspace.package]" >&2; exit 1; }
# The tag and the version must agree.
case ${GITHUB_REF_NAME:-} in
v*) [ "$GITHUB_REF_NAME" = "v$version" ] || { echo "the tag is $GITHUB_REF_NAME, but the version in Cargo.toml is $version" >&2; exit 1; } ;;
esac

if [ "${1:-}" = crates ]; then
    say "release: the crates of phalanx $version"
    # cargo refuses the module, which git ignores, without --allow-dirty, so the check for changes is made here.
    if [ -n "$(git status --porcelain)" ]; then
        echo "the checkout has changes that are not committed" >&2
        exit 1
    fi
    tools/explorer.sh
    trap 'rm -f explorer.wasm.gz' EXIT
    cp "${CARGO_TARGET_DIR:-target}/release/phalanx-explorer.wasm.gz" explorer.wasm.gz
    # The package of Python is published as wheels.
    cargo package --workspace --exclude phalanx-python --locked --allow-dirty
    crate=${CARGO_TARGET_DIR:-target}/package/phalanx-$version.crate
    if ! tar -tzf "$crate" "phalanx-$version/explorer.wasm.gz" >/dev/null; then
        echo "phalanx-$version.crate does not contain the module of the explorer" >&2
        exit 1
    fi
    ls -l "${CARGO_TARGET_DIR:-target}"/package/*-"$version".crate
    exit
fi

say "release: phalanx $version for $target"
# The module is the same for every system; the program contains it.
tools/explorer.sh
PHALANX_EXPLORER_MODULE=$(cd "${CARGO_TARGET_DIR:-target}/release" && pwd)/phalanx-explorer.wasm.gz
export PHALANX_EXPLORER_MODULE
build_dir=${CARGO_TARGET_DIR:-target}
if [ "$target" = "$host" ]; then
    cargo build --release --locked --features png --bin phalanx
    build_dir=$build_dir/release
else
    cargo build --release --locked --features png --bin phalanx --target "$target"
    build_dir=$build_dir/$target/release
fi
case $target in
*windows*) program=phalanx.exe ;;
*) program=phalanx ;;
esac

name=phalanx-$version-$target
dist=target/dist
rm -rf "${dist:?}/$name" "$dist/$name".*
mkdir -p "$dist/$name/completions"
cp "$build_dir/$program" README.md CHANGELOG.md CITATION.cff LICENSE-APACHE LICENSE-MIT THIRD-PARTY.txt "$dist/$name"
# A cross-compiled program does not run here; the host's program writes the same manual pages and completions.
generator=$build_dir/$program
if ! "$generator" --version >/dev/null 2>&1; then
    cargo build --release --locked --features png --bin phalanx
    generator=${CARGO_TARGET_DIR:-target}/release/phalanx
fi
"$generator" man "$dist/$name/man/man1" >/dev/null
for shell in bash elvish fish powershell zsh; do
    "$generator" completions "$shell" >"$dist/$name/completions/phalanx.$shell"
done

timestamp=$(git log -1 --format=%ct 2>/dev/null || date +%s)
cd "$dist"
case $target in
*windows*)
    archive=$name.zip
    python3 - "$name" "$archive" "$timestamp" <<'PYTHON'
import sys, time, zipfile
from pathlib import Path

name, archive, date_time = sys.argv[1], sys.argv[2], time.gmtime(int(sys.argv[3]))[:6]
with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as out:
    for path in sorted(path for path in Path(name).rglob("*") if path.is_file()):
        entry = zipfile.ZipInfo(path.as_posix(), date_time)
        entry.compress_type = zipfile.ZIP_DEFLATED
        entry.external_attr = 0o644 << 16
        out.writestr(entry, path.read_bytes())
PYTHON
    ;;
*)
    archive=$name.tar.gz
    # Python's tarfile, because the tar of macOS can neither sort names nor set owners.
    python3 - "$name" "$archive" "$timestamp" <<'PYTHON'
import gzip, sys, tarfile
from pathlib import Path

name, archive, timestamp = sys.argv[1], sys.argv[2], int(sys.argv[3])


def normalize(entry):
    entry.uid = entry.gid = 0
    entry.uname = entry.gname = ""
    entry.mtime = timestamp
    entry.mode = 0o755 if entry.isdir() or entry.mode & 0o100 else 0o644
    return entry


with open(archive, "wb") as file, gzip.GzipFile("", "wb", mtime=timestamp, fileobj=file) as packed:
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as out:
        for path in [Path(name), *sorted(Path(name).rglob("*"))]:
            out.add(path, path.as_posix(), recursive=False, filter=normalize)
PYTHON
    ;;
esac
rm -rf "$name"
python3 - "$archive" <<'PYTHON'
import hashlib, sys
from pathlib import Path

archive = Path(sys.argv[1])
digest = hashlib.sha256(archive.read_bytes()).hexdigest()
# The format of `sha256sum --check`, with a line feed on Windows too.
Path(archive.name + ".sha256").write_bytes(f"{digest}  {archive.name}\n".encode())
PYTHON
echo "$dist/$archive"
