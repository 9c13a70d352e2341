#!/usr/bin/env python3
"""Compares the output of two builds on every shipped scene, in both models, and on every study.

    tools/same_numbers.py BEFORE AFTER [--only WORD] [--jobs N] [--logs] [--figures]

BEFORE and AFTER are two `phalanx` programs. Both run the same commands, each in its own directory. The script compares what they print
and write, byte by byte: `run --json` and the text output, the samples of `replay --csv`, `scene show` and `check`, `statics`, `size`,
the pages of runs, then `schema scene`, `volume`, `sweep` and `select`, `capture`, `hold` and `reproduce`. Times and the
name of the program are removed first. Logs contain the version of the program, so they are compared only with --logs. With --figures,
only numbers and JSON keys are compared, without the program of pages and without checksums, so that a change of wording is not a
difference. The exit status is 1 if anything differs; every difference is printed.
"""

import argparse
import concurrent.futures
import difflib
import functools
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Wall times and thread counts.
CLOCK = re.compile(
    r'"[a-z_]*(wall|cpu|simulations_per_s|threads|speed)[a-z_]*":.*|[;,]? *[0-9.e]+ [mµn]?s of wall time|in [0-9.]+ s on [0-9]+ threads?.*'
)
# A JSON key, or a number that is not part of a name such as q11.
FIGURE = re.compile(r'"[A-Za-z_0-9.%-]+":|(?<![\w.])[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?')


# Program and style of a page, which contain no results.
PAGE_CODE = re.compile(r"<script nonce.*?</script>|<style.*?</style>|nonce-[0-9a-f]+", re.DOTALL)


def commands():
    """Yields the name and the argument lists of every comparison; {} is replaced by the program's own directory."""
    for path in sorted(ROOT.glob("scenes/**/*.toml")):
        scene = path.relative_to(ROOT)
        if "studies" in scene.parts:
            continue
        for model in ("analytic", "engine"):
            log = "{}/" + f"{'-'.join(scene.with_suffix('').parts)}-{model}.mcap"
            yield f"run {scene} {model}", ["run", scene, "--model", model, "--json", "--log", log], ["replay", log, "--csv", "-"]
            yield f"text {scene} {model}", ["run", scene, "--model", model, "--plot", log.replace(".mcap", ".html")]
        for command in (["scene", "show"], ["scene", "check"], ["statics"], ["statics", "--json"], ["size"], ["size", "--json"]):
            yield f"{' '.join(command)} {scene}", [*command[:2], scene] if command[0] == "scene" else [command[0], scene, *command[1:]]
    yield "schema", ["schema", "scene"]
    yield "volume", ["thesis", "volume", "--json"]
    yield "volume text", ["thesis", "volume"]
    yield "sweep", ["sweep", "scenes/studies/sample.toml", "--out", "{}/sample.csv"], ["thesis", "select", "{}/sample.csv", "--json"]
    thesis = ["thesis", "select", "{}/thesis.csv"]
    yield "thesis", ["sweep", "scenes/studies/thesis.toml", "--out", "{}/thesis.csv"], thesis, [*thesis, "--json"]
    yield "capture", ["capture", "scenes/gripper/design-95.toml", "--json"]
    yield "hold", ["hold", "scenes/gripper/hold.toml", "--json"]
    yield "reproduce", ["thesis", "reproduce", "--out", "{}/reproduce"]


# Present names, and those before version 0.3.
FORMER = {("thesis",): (), ("schema", "scene"): ("scene", "schema"), ("--plot",): ("--html",)}


@functools.cache
def is_former(program):
    """Whether a program has the commands before version 0.3."""
    return b"thesis" not in subprocess.run([program, "thesis", "--help"], capture_output=True).stdout


def arguments_for(program, step):
    """Returns the arguments of a command, with the former names for a former program."""
    arguments = [str(part) for part in step]
    for present, former in FORMER.items() if is_former(program) else ():
        for index in range(len(arguments)):
            if tuple(arguments[index : index + len(present)]) == present:
                arguments[index : index + len(present)] = former
    return arguments


def output(program, steps, directory, options):
    """Returns the lines that a program prints and writes for some commands; a log is represented by its digest."""
    parts = []
    for step in steps:
        arguments = [part.replace("{}", directory) for part in arguments_for(program, step)]
        done = subprocess.run([program, "--quiet", *arguments], cwd=ROOT, capture_output=True, env={**os.environ, "COLUMNS": "1000"})
        # Usages and hints contain the name of the program.
        errors = done.stderr.decode().replace(pathlib.Path(program).name, "phalanx")
        parts.append(f"$ {' '.join(map(str, step))}\n{done.stdout.decode()}{errors}exit {done.returncode}\n")
    for file in sorted(path for path in pathlib.Path(directory).rglob("*") if path.is_file()):
        if file.suffix == ".mcap":
            if options.logs:
                parts.append(f"# {file.relative_to(directory)}\n{hashlib.sha256(file.read_bytes()).hexdigest()}\n")
        elif file.suffix != ".lock":
            text = file.read_text(errors="replace")
            if options.figures and file.suffix == ".html":
                text = PAGE_CODE.sub("", text)
            parts.append(f"# {file.relative_to(directory)}\n{text}")
    lines = "\n".join(parts).replace(directory, "DIR").splitlines()
    lines = [CLOCK.sub("", line) for line in lines]
    if options.figures:
        # Rewording moves line breaks, so the figures are one sequence.
        lines = [figure for line in lines for figure in FIGURE.findall(line)]
    return lines


def compare(name, steps, options):
    """Returns the name, the number of lines, and the first differing lines (none if the outputs are equal)."""
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
        before, after = output(options.before, steps, one, options), output(options.after, steps, two, options)
    if before == after:
        return name, len(before), []
    changes = difflib.unified_diff(before, after, "before", "after", lineterm="", n=0)
    return name, len(before), [line[:240] for _, line in zip(range(12), changes)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", type=os.path.abspath)
    parser.add_argument("after", type=os.path.abspath)
    parser.add_argument("--only", default="", help="run only commands whose name contains this word")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="commands that run at the same time")
    parser.add_argument("--logs", action="store_true", help="also compare logs byte by byte")
    parser.add_argument("--figures", action="store_true", help="compare only numbers and JSON keys")
    options = parser.parse_args()
    selected = [(name, steps) for name, *steps in commands() if options.only in name]
    different = lines = 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for run in [pool.submit(compare, name, steps, options) for name, steps in selected]:
            name, count, changes = run.result()
            lines += count
            if changes:
                different += 1
                print(f"{name} differs:", *changes, sep="\n    ", flush=True)
    unit = "figures" if options.figures else "lines"
    print(f"{len(selected)} commands, {lines} {unit}: " + (f"{different} differ" if different else "all the same"))
    sys.exit(bool(different))


if __name__ == "__main__":
    main()
