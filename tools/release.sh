#!/usr/bin/env bash
# A release for one system: the program, built from the lock file, packed with the explorer's module, manual pages, completions,
# licences and README into target/dist/phalanx-VERSION-TARGET.tar.gz (.zip for Windows), with its SHA-256 beside it. The same commit gives the same
# archive: names are sorted, and times are that of the commit.
# Usage: tools/release.sh [TARGET]      (default: this machine's, as `rustc -vV` says it)
set -euo pipefail
cd "$(dirname "$0")/.."

# shellcheck source=tools/need.sh
. tools/need.sh

host=$(rustc -vV | sed -n 's/^host: //p')
target=${1:-$host}
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"$/\1/p' Cargo.toml)
[ -n "$version" ] || { echo "Cargo.toml says no version under [workspace.package]" >&2; exit 1; }
# The archive of a tag is the tag's.
case ${GITHUB_REF_NAME:-} in
v*) [ "$GITHUB_REF_NAME" = "v$version" ] || { echo "the tag is $GITHUB_REF_NAME, but Cargo.toml says $version" >&2; exit 1; } ;;
esac

say "release: phalanx $version for $target"
built=${CARGO_TARGET_DIR:-target}
if [ "$target" = "$host" ]; then
    cargo build --release --locked --bin phalanx
    built=$built/release
else
    cargo build --release --locked --bin phalanx --target "$target"
    built=$built/$target/release
fi
case $target in
*windows*) program=phalanx.exe ;;
*) program=phalanx ;;
esac

name=phalanx-$version-$target
dist=target/dist
rm -rf "${dist:?}/$name" "$dist/$name".*
mkdir -p "$dist/$name/completions"
# The module is of no system; it lies beside the program, where that looks for it.
tools/explorer.sh
cp "$built/$program" "${CARGO_TARGET_DIR:-target}/release/phalanx-explorer.wasm.gz" README.md CHANGELOG.md LICENSE-APACHE LICENSE-MIT "$dist/$name"
# The program of another system does not run here; its pages are the same as those of this one's.
teller=$built/$program
if ! "$teller" --version >/dev/null 2>&1; then
    cargo build --release --locked --bin phalanx
    teller=${CARGO_TARGET_DIR:-target}/release/phalanx
fi
"$teller" man "$dist/$name/man/man1" >/dev/null
# What a command leaves beside its files so that it knows them again.
rm -f "$dist/$name/man/man1/.phalanx"
for shell in bash elvish fish powershell zsh; do
    "$teller" completions "$shell" >"$dist/$name/completions/phalanx.$shell"
done

when=$(git log -1 --format=%ct 2>/dev/null || date +%s)
cd "$dist"
case $target in
*windows*)
    archive=$name.zip
    python3 - "$name" "$archive" "$when" <<'PYTHON'
import sys, time, zipfile
from pathlib import Path

name, archive, when = sys.argv[1], sys.argv[2], time.gmtime(int(sys.argv[3]))[:6]
with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as out:
    for path in sorted(path for path in Path(name).rglob("*") if path.is_file()):
        entry = zipfile.ZipInfo(path.as_posix(), when)
        entry.compress_type = zipfile.ZIP_DEFLATED
        entry.external_attr = 0o644 << 16
        out.writestr(entry, path.read_bytes())
PYTHON
    ;;
*)
    archive=$name.tar.gz
    # Python's, for the tar of macOS knows neither sorting nor owners.
    python3 - "$name" "$archive" "$when" <<'PYTHON'
import gzip, sys, tarfile
from pathlib import Path

name, archive, when = sys.argv[1], sys.argv[2], int(sys.argv[3])


def plain(entry):
    entry.uid = entry.gid = 0
    entry.uname = entry.gname = ""
    entry.mtime = when
    entry.mode = 0o755 if entry.isdir() or entry.mode & 0o100 else 0o644
    return entry


with open(archive, "wb") as file, gzip.GzipFile("", "wb", mtime=when, fileobj=file) as packed:
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as out:
        for path in [Path(name), *sorted(Path(name).rglob("*"))]:
            out.add(path, path.as_posix(), recursive=False, filter=plain)
PYTHON
    ;;
esac
rm -rf "$name"
python3 - "$archive" <<'PYTHON'
import hashlib, sys
from pathlib import Path

archive = Path(sys.argv[1])
digest = hashlib.sha256(archive.read_bytes()).hexdigest()
# As `sha256sum --check` reads it; with a line feed on Windows too.
Path(archive.name + ".sha256").write_bytes(f"{digest}  {archive.name}\n".encode())
PYTHON
echo "$dist/$archive"
