#!/usr/bin/env python3
"""Validates every scene of scenes/hard and puts the table into src/docs/hard.md.

    tools/hard_cases.py                 all scenes
    tools/hard_cases.py --dry-run       print the table, leave the page alone

Builds in release mode, runs `phalanx validate --quick --ladder` and `phalanx run` on every scene, and replaces what stands between
the page's markers. What is hard, and why a bound is wider than usual, is said by the comment of each scene.
"""

import argparse
import json
import re
import subprocess
import sys
from pathlib import Path

from readme_figures import PHALANX, ROOT, call, number, table

PAGE = ROOT / "src" / "docs" / "hard.md"
USUAL = {"angle_rad": 2e-5, "contact_time_s": 5e-7, "final_force": 1e-4, "impulse": 5e-3, "loop_gap_m": 1e-7}
SHORT = {"angle_rad": "angle", "contact_time_s": "touch", "final_force": "force", "impulse": "impulse", "loop_gap_m": "gap"}


def phalanx(*arguments):
    """Status and JSON document of a command."""
    result = subprocess.run([str(PHALANX), *map(str, arguments), "--json"], cwd=ROOT, capture_output=True, text=True)
    if result.returncode == 2:
        sys.exit(result.stderr)
    return result.returncode, json.loads(result.stdout) if result.stdout else None, result.stderr


def hard(path):
    """What the scene's comment says is hard, up to its first full stop or colon."""
    comment = " ".join(line[2:].strip() for line in path.read_text().splitlines() if line.startswith("# "))
    return re.match(r"Hard[^:]*: (.*?)(?:[.:;] |\.$| Expect:)", comment).group(1)


def milliseconds(contacts, site):
    first_s = contacts.get(site, {}).get("first_s") if contacts.get(site) else None
    return "–" if first_s is None else f"{first_s * 1e3:.3f}"


def row(path):
    name = path.stem
    status, run, complaint = phalanx("run", path)
    contacts = run["contacts"]
    touched = " / ".join(milliseconds(contacts, site) for site in ("proximal", "distal"))
    front = [f"[`{name}`](../../{path.relative_to(ROOT)})", hard(path), touched, str(run["steps"])]
    if status == 3:
        _, engine, _ = phalanx("run", path, "--model", "engine")
        reason = f"ends at {run['error']['time_s'] * 1e3:.3f} ms: {run['error']['reason'].split(':')[0]}"
        engine_time = number(engine["wall_s"] * 1e3, "{:.1f}")
        return front + ["–", "–", "–", "–", str(engine["steps"]), engine_time, f"as expected: {reason}"], True
    status, found, complaint = phalanx("validate", path, "--quick", "--ladder")
    if found is None:
        sys.exit(f"{name}: {complaint}")
    measured = {check["bound"]: check for check in found["verdict"]}
    own = next(setting for setting in found["settings"] if setting["own"])
    wider = [
        f"{SHORT[bound]} {measured[bound]['limit']:.0e}"
        for bound in USUAL
        if measured[bound]["limit"] > 1.001 * USUAL[bound] and (measured[bound]["measured"] or 0) > USUAL[bound]
    ]
    verdict = "passes" if found["passed"] else "FAILS: " + ", ".join(c["bound"] for c in found["verdict"] if not c["passed"])
    if wider:
        verdict += f" (bound: {', '.join(wider)}; the scene says why)"
    errors = [number(measured[bound]["measured"]) for bound in ("angle_rad", "contact_time_s", "final_force", "impulse")]
    return front + errors + [str(own["steps"]), number(own["wall_s"] * 1e3, "{:.1f}"), verdict], found["passed"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--dry-run", action="store_true", help="print the table, leave the page alone")
    parser.add_argument("--no-build", action="store_true", help="measure the release build that is there")
    arguments = parser.parse_args()
    if not arguments.no_build:
        call("cargo", "build", "--release", "--locked", "--quiet")
    header = [
        "scene", "what is hard", "analytic: first touch, proximal / distal (ms)", "steps", "engine: angle (rad)", "touch (s)", "force",
        "impulse", "steps", "time (ms)", "verdict",
    ]
    rows, passed = [], 0
    # Grippers are measured by tools/grippers.py.
    scenes = [path for path in sorted((ROOT / "scenes" / "hard").glob("*.toml")) if not path.stem.startswith("gripper-")]
    for path in scenes:
        print(path.stem, file=sys.stderr)
        cells, fine = row(path)
        rows.append(cells)
        passed += fine
    text = table(header, rows) + f"\n\n{passed} of {len(scenes)} scenes are as expected."
    print(text)
    if arguments.dry_run:
        return
    block = re.compile(r"(<!-- table:begin -->\n).*?(<!-- table:end -->)", re.S)
    page, found = block.subn(lambda found: f"{found.group(1)}{text}\n{found.group(2)}", PAGE.read_text())
    if found != 1:
        sys.exit(f"{PAGE} has no place for the table: it needs the lines <!-- table:begin --> and <!-- table:end -->")
    PAGE.write_text(page)


if __name__ == "__main__":
    main()
