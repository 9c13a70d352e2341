#!/usr/bin/env python3
"""Validates every scene of scenes/hard and writes the table in src/docs/hard.md.

    tools/hard_cases.py                 all scenes
    tools/hard_cases.py --dry-run       print the table, do not change the page

Builds in release mode, runs `phalanx validate --quick --ladder` and `phalanx run` on every scene, and replaces the text
between the markers of the page. The comment of each scene states the difficulty, and the reason for a bound that is
wider than usual.
"""

import argparse
import json
import re
import subprocess
import sys

from readme_figures import PHALANX, ROOT, call, number, table

PAGE = ROOT / "src" / "docs" / "hard.md"
DEFAULT_BOUNDS = {"angle_rad": 2e-5, "contact_time_s": 5e-7, "final_force": 1e-4, "impulse": 5e-3, "loop_gap_m": 1e-7}
SHORT_NAMES = {"angle_rad": "angle", "contact_time_s": "contact time", "final_force": "force", "impulse": "impulse", "loop_gap_m": "gap"}


def phalanx(*arguments):
    """Returns the exit status, the JSON document and the error output of a command."""
    result = subprocess.run([str(PHALANX), *map(str, arguments), "--json"], cwd=ROOT, capture_output=True, text=True)
    if result.returncode == 2:
        sys.exit(result.stderr)
    return result.returncode, json.loads(result.stdout) if result.stdout else None, result.stderr


def difficulty(path):
    """Returns the difficulty from the comment of a scene, up to its first full stop or colon."""
    comment = " ".join(line[2:].strip() for line in path.read_text().splitlines() if line.startswith("# "))
    return re.match(r"Hard[^:]*: (.*?)(?:[.:;] |\.$| Expect:)", comment).group(1)


def first_contact_ms(contacts, phalanx_name):
    """Returns the time of the first contact in ms, or a dash without a contact."""
    first_s = contacts.get(phalanx_name, {}).get("first_s") if contacts.get(phalanx_name) else None
    return "–" if first_s is None else f"{first_s * 1e3:.3f}"


def row(path):
    """Returns the table cells of a scene and whether its results are as expected."""
    name = path.stem
    status, run, _ = phalanx("run", path)
    contacts = run["contacts"]
    first_contacts = " / ".join(first_contact_ms(contacts, phalanx_name) for phalanx_name in ("proximal", "distal"))
    first_cells = [f"[`{name}`](../../{path.relative_to(ROOT)})", difficulty(path), first_contacts, str(run["steps"])]
    # Status 3: the run ends early, as expected of this scene.
    if status == 3:
        _, engine, _ = phalanx("run", path, "--model", "engine")
        reason = f"ends at {run['error']['time_s'] * 1e3:.3f} ms: {run['error']['reason'].split(':')[0]}"
        engine_time = number(engine["wall_s"] * 1e3, "{:.1f}")
        return first_cells + ["–", "–", "–", "–", str(engine["steps"]), engine_time, f"as expected: {reason}"], True
    status, validation, error_output = phalanx("validate", path, "--quick", "--ladder")
    if validation is None:
        sys.exit(f"{name}: {error_output}")
    checks = {check["bound"]: check for check in validation["verdict"]}
    scene_setting = next(setting for setting in validation["settings"] if setting["own"])
    wider = [
        f"{SHORT_NAMES[bound]} {checks[bound]['limit']:.0e}"
        for bound in DEFAULT_BOUNDS
        if checks[bound]["limit"] > 1.001 * DEFAULT_BOUNDS[bound] and (checks[bound]["measured"] or 0) > DEFAULT_BOUNDS[bound]
    ]
    verdict = "passes" if validation["passed"] else "FAILS: " + ", ".join(c["bound"] for c in validation["verdict"] if not c["passed"])
    if wider:
        verdict += f" (bound: {', '.join(wider)}; the scene gives the reason)"
    errors = [number(checks[bound]["measured"]) for bound in ("angle_rad", "contact_time_s", "final_force", "impulse")]
    last_cells = [str(scene_setting["steps"]), number(scene_setting["wall_s"] * 1e3, "{:.1f}"), verdict]
    return first_cells + errors + last_cells, validation["passed"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--dry-run", action="store_true", help="print the table, do not change the page")
    parser.add_argument("--no-build", action="store_true", help="use the existing release build")
    arguments = parser.parse_args()
    if not arguments.no_build:
        call("cargo", "build", "--release", "--locked", "--quiet")
    header = [
        "scene", "difficulty", "analytic: first contact, proximal / distal (ms)", "steps", "engine: angle (rad)", "contact time (s)", "force",
        "impulse", "steps", "time (ms)", "verdict",
    ]
    rows, passed = [], 0
    # tools/grippers.py measures the grippers.
    scenes = [path for path in sorted((ROOT / "scenes" / "hard").glob("*.toml")) if not path.stem.startswith("gripper-")]
    for path in scenes:
        print(path.stem, file=sys.stderr)
        cells, as_expected = row(path)
        rows.append(cells)
        passed += as_expected
    text = table(header, rows) + f"\n\n{passed} of {len(scenes)} scenes are as expected."
    print(text)
    if arguments.dry_run:
        return
    block = re.compile(r"(<!-- table:begin -->\n).*?(<!-- table:end -->)", re.S)
    page, count = block.subn(lambda match: f"{match.group(1)}{text}\n{match.group(2)}", PAGE.read_text())
    if count != 1:
        sys.exit(f"{PAGE} needs exactly one pair of lines <!-- table:begin --> and <!-- table:end -->")
    PAGE.write_text(page)


if __name__ == "__main__":
    main()
