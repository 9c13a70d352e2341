#!/usr/bin/env python3
"""Writes THIRD-PARTY.txt: name, version, licence and licence texts of all packages that are compiled into the program, the
explorer's module and the Python package, for all systems of a release. The texts come from cargo's copies of the packages.

Usage: tools/third_party.py [--check]      (--check: only compares; exit status 1 if the file is out of date)
"""

import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUTPUT = ROOT / "THIRD-PARTY.txt"
# Those of .github/workflows/release.yml.
TARGETS = [
    "x86_64-unknown-linux-gnu",
    "aarch64-unknown-linux-gnu",
    "x86_64-apple-darwin",
    "aarch64-apple-darwin",
    "x86_64-pc-windows-msvc",
]
PROGRAMS = [
    ("Cargo.toml", ["phalanx", "phalanx-python"], TARGETS),
    ("crates/explorer/Cargo.toml", ["phalanx-explorer"], ["wasm32-unknown-unknown"]),
]
# Licences under which phalanx may use a package. A package that offers several is used under the first.
ALLOWED = ["MIT", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause", "Zlib", "Unicode-3.0"]
# Other licences of sources inside a package that phalanx does not use it under: of zstd, which offers BSD instead, and of
# the command-line programs of lz4, which are not compiled.
NOT_USED = "GNU GENERAL PUBLIC LICENSE"
# A sentence of each licence text.
MARKS = {
    "MIT": "Permission is hereby granted, free of charge, to any person obtaining",
    "Apache-2.0": "Apache License",
    "Zlib": "freely, subject to the following restrictions",
    "Unlicense": "This is free and unencumbered software",
    "BSL-1.0": "Boost Software License",
    "0BSD": "Permission to use, copy, modify, and/or distribute",
    "CC0-1.0": "CC0 1.0",
}
LICENCE_FILE = re.compile(r"(licen[cs]e|copying|copyright|notice|unlicense)([-._].*)?", re.IGNORECASE)
# Directories of a package with files that are not compiled.
NOT_COMPILED = {"tests", "test", "benches", "examples", "fuzz", "contrib", "programs", "doc", "docs", "build"}

HEADER = """\
Third-party packages of phalanx

phalanx is distributed under the MIT License or the Apache License, Version 2.0
(LICENSE-MIT, LICENSE-APACHE). Its binaries contain the packages below, and the
standard library of Rust (MIT or Apache-2.0, https://rust-lang.org). Where a
package may be used under one of several licences, the text of only one of them
follows. Written by tools/third_party.py.
"""


def metadata(manifest, target):
    command = ["cargo", "metadata", "--locked", "--all-features", "--format-version", "1", "--manifest-path", ROOT / manifest, "--filter-platform", target]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)


def compiled_packages():
    """Returns the packages of registries that are linked into the programs, by name and version."""
    found = {}
    for manifest, programs, targets in PROGRAMS:
        for target in targets:
            data = metadata(manifest, target)
            packages = {package["id"]: package for package in data["packages"]}
            nodes = {node["id"]: node for node in data["resolve"]["nodes"]}
            pending = [key for key, package in packages.items() if package["name"] in programs]
            seen = set(pending)
            while pending:
                for dependency in nodes[pending.pop()]["deps"]:
                    key = dependency["pkg"]
                    # Procedural macros and build scripts run in the compiler.
                    is_macro = any("proc-macro" in target["kind"] for target in packages[key]["targets"])
                    is_linked = any(kind["kind"] is None for kind in dependency["dep_kinds"])
                    if is_linked and not is_macro and key not in seen:
                        seen.add(key)
                        pending.append(key)
            for key in seen:
                package = packages[key]
                if package["source"]:
                    found[package["name"], package["version"]] = package
    return [found[key] for key in sorted(found)]


def choices(expression):
    """Returns the sets of licences that an SPDX expression offers."""
    expression = expression.replace("/", " OR ")
    tokens = re.findall(r"\(|\)|AND|OR|[^\s()]+(?: WITH [^\s()]+)?", expression)

    def any_of():
        sets = all_of()
        while tokens and tokens[0] == "OR":
            tokens.pop(0)
            sets = sets + all_of()
        return sets

    def all_of():
        sets = one()
        while tokens and tokens[0] == "AND":
            tokens.pop(0)
            sets = [left | right for right in one() for left in sets]
        return sets

    def one():
        token = tokens.pop(0)
        if token != "(":
            return [{token}]
        sets = any_of()
        tokens.pop(0)
        return sets

    return any_of()


def chosen_licences(package):
    allowed = [choice for choice in choices(package["license"] or "") if choice <= set(ALLOWED)]
    if not allowed:
        name = f"{package['name']} {package['version']}"
        sys.exit(f"{name} has the licence {package['license']!r}; allowed are {', '.join(ALLOWED)}")
    return min(allowed, key=lambda choice: sorted(map(ALLOWED.index, choice)))


def licence_files(package):
    directory = Path(package["manifest_path"]).parent
    found = []
    for path in sorted(directory.rglob("*")):
        parts = path.relative_to(directory).parts[:-1]
        is_named = LICENCE_FILE.fullmatch(path.name) and path.suffix not in (".rs", ".html")
        if is_named and path.is_file() and not NOT_COMPILED.intersection(parts):
            found.append(path)
    return found


def is_of(text, licence):
    """Whether a text is that of a licence; None if the licence has no mark."""
    mark = MARKS.get(licence.split(" WITH ")[0])
    return mark in " ".join(text.split()) if mark else None


def texts_of(package, licences):
    """Returns the texts of the chosen licences, and all notices."""
    directory = Path(package["manifest_path"]).parent
    others = set(MARKS) - {name.split(" WITH ")[0] for name in licences}
    kept = []
    for path in licence_files(package):
        text = path.read_text(encoding="utf-8", errors="replace").strip("\n\f ")
        is_chosen = any(is_of(text, name) for name in licences)
        # Sources of others inside a package, such as a C library, have licences of their own.
        is_alternative = path.parent == directory and any(is_of(text, name) for name in others)
        if text and (is_chosen or not is_alternative) and NOT_USED not in text[:200]:
            kept.append(text)
    for licence in sorted(licences):
        if any(is_of(text, licence) is not False for text in kept):
            continue
        authors = ", ".join(re.sub(r" *<.*>", "", author) for author in package["authors"])
        authors = authors or f"the authors of {package['name']}"
        if licence == "MIT":
            text = (ROOT / "LICENSE-MIT").read_text(encoding="utf-8").strip()
            kept.append(re.sub(r"Copyright .*", f"Copyright (c) {authors}", text))
        elif licence.startswith("Apache-2.0"):
            kept.append((ROOT / "LICENSE-APACHE").read_text(encoding="utf-8").strip())
        else:
            sys.exit(f"{package['name']} {package['version']} ({licence}) has no licence text")
    return kept


def document():
    numbers, texts, lines = {}, [], []
    for package in compiled_packages():
        licences = chosen_licences(package)
        own = []
        for text in texts_of(package, licences):
            key = re.sub(r"\W+", " ", text)
            if key not in numbers:
                texts.append("\n".join(line.rstrip() for line in text.splitlines()))
                numbers[key] = len(texts)
            own.append(numbers[key])
        numbers_of = ", ".join(map(str, sorted(set(own))))
        name = f"{package['name']} {package['version']}"
        lines.append(f"{name:<40} {package['license']}; text {numbers_of}")
    sections = [f"{'=' * 79}\nText {number}\n\n{text}\n" for number, text in enumerate(texts, 1)]
    return "\n".join([HEADER, *lines, "", *sections])


def main():
    text = document()
    if sys.argv[1:] == ["--check"]:
        if not OUTPUT.is_file() or OUTPUT.read_text(encoding="utf-8") != text:
            sys.exit("THIRD-PARTY.txt is out of date; run: tools/third_party.py")
    else:
        OUTPUT.write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
