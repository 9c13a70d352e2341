#!/usr/bin/env python3
"""Whether two builds say the same, to the last digit: every shipped scene in both models, and every study.

    tools/same_numbers.py BEFORE AFTER [--only WORD] [--jobs N] [--logs]

BEFORE and AFTER are two `phalanx` programs. Both run the same commands, each in a directory of its own; what they print and what they
write is compared byte by byte: `run --json` and the text of it, the samples of `replay --csv`, `scene show` and `check`, `statics`,
`size`, the pages of runs, then `scene schema`, `volume`, `sweep` and `select`, `capture`, `hold`, `optimize` and `reproduce`. Left out
is what a clock says, and what names the program itself. Logs name the versions of what wrote them: of programs of one version --logs
compares their bytes too. Exit status 1 if anything differs; every difference is named.
"""

import argparse
import concurrent.futures
import difflib
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
# What a clock says, and how many threads there were.
CLOCK = re.compile(
    r'"[a-z_]*(wall|cpu|simulations_per_s|threads|speed)[a-z_]*":.*|[;,]? *[0-9.e]+ [mµn]?s of wall time|in [0-9.]+ s on [0-9]+ threads?.*'
)


def commands():
    """Names of what is run, each with its arguments; {} stands for a directory of the program's own."""
    for scene in sorted(ROOT.glob("scenes/**/*.toml")):
        at = scene.relative_to(ROOT)
        if "studies" in at.parts:
            continue
        for model in ("analytic", "engine"):
            log = "{}/" + f"{'-'.join(at.with_suffix('').parts)}-{model}.mcap"
            yield f"run {at} {model}", ["run", at, "--model", model, "--json", "--log", log], ["replay", log, "--csv", "-"]
            yield f"text {at} {model}", ["run", at, "--model", model, "--html", log.replace(".mcap", ".html")]
        for command in (["scene", "show"], ["scene", "check"], ["statics"], ["statics", "--json"], ["size"], ["size", "--json"]):
            yield f"{' '.join(command)} {at}", [*command[:2], at] if command[0] == "scene" else [command[0], at, *command[1:]]
    yield "schema", ["scene", "schema"]
    yield "volume", ["volume", "--json"]
    yield "volume text", ["volume"]
    yield "sweep", ["sweep", "scenes/studies/sample.toml", "--out", "{}/sample.csv"], ["select", "{}/sample.csv", "--json"]
    thesis = ["select", "{}/thesis.csv"]
    yield "thesis", ["sweep", "scenes/studies/thesis.toml", "--out", "{}/thesis.csv"], thesis, [*thesis, "--json"]
    yield "capture", ["capture", "scenes/gripper/design-95.toml", "--json"]
    yield "hold", ["hold", "scenes/gripper/hold.toml", "--json"]
    yield "optimize", ["optimize", "scenes/studies/optimize-95.toml", "--out", "{}/best.csv", "--json"]
    yield "reproduce", ["reproduce", "--out", "{}/reproduce"]


def said(program, steps, place, logs):
    """What a program prints for some commands and leaves in its directory; of its logs a digest, if at all."""
    answer = []
    for step in steps:
        arguments = [str(part).replace("{}", place) for part in step]
        done = subprocess.run([program, "--quiet", *arguments], cwd=ROOT, capture_output=True, env={**os.environ, "COLUMNS": "1000"})
        # A program is named in usages and hints.
        errors = done.stderr.decode().replace(pathlib.Path(program).name, "phalanx")
        answer.append(f"$ {' '.join(map(str, step))}\n{done.stdout.decode()}{errors}exit {done.returncode}\n")
    for file in sorted(path for path in pathlib.Path(place).rglob("*") if path.is_file()):
        if file.suffix == ".mcap":
            if logs:
                answer.append(f"# {file.relative_to(place)}\n{hashlib.sha256(file.read_bytes()).hexdigest()}\n")
        elif file.suffix != ".lock":
            answer.append(f"# {file.relative_to(place)}\n{file.read_text(errors='replace')}")
    lines = "\n".join(answer).replace(place, "DIR").splitlines()
    return [CLOCK.sub("", line) for line in lines]


def compare(before, after, name, steps, logs):
    """The first lines that differ; none if all are the same."""
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
        old, new = said(before, steps, one, logs), said(after, steps, two, logs)
    changes = difflib.unified_diff(old, new, "before", "after", lineterm="", n=0)
    return name, len(old), [line[:240] for _, line in zip(range(12), changes)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", type=os.path.abspath)
    parser.add_argument("after", type=os.path.abspath)
    parser.add_argument("--only", default="", help="commands with this word in their names")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="so many at once")
    parser.add_argument("--logs", action="store_true", help="logs byte by byte too")
    asked = parser.parse_args()
    wanted = [(name, steps) for name, *steps in commands() if asked.only in name]
    different = lines = 0
    with concurrent.futures.ThreadPoolExecutor(asked.jobs) as pool:
        runs = [pool.submit(compare, asked.before, asked.after, name, steps, asked.logs) for name, steps in wanted]
        for run in runs:
            name, count, changes = run.result()
            lines += count
            if changes:
                different += 1
                print(f"{name} differs:", *changes, sep="\n    ", flush=True)
    print(f"{len(wanted)} commands, {lines} lines: " + (f"{different} differ" if different else "all the same"))
    sys.exit(bool(different))


if __name__ == "__main__":
    main()
