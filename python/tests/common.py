"""Paths and helpers of the tests."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"
ANCHOR = SCENES / "experiment-95.toml"
GRIPPER = SCENES / "gripper" / "offset.toml"
DISCS = SCENES / "laws" / "spring.toml"
THESIS = SCENES / "studies" / "thesis.toml"


def command(*arguments: object, status: int = 0) -> str:
    """Runs a command of the program $PHALANX; returns its output, or its error output if it is expected to fail."""
    call = [os.environ["PHALANX"], *map(str, arguments)]
    result = subprocess.run(call, capture_output=True, text=True, check=False)
    if result.returncode != status:
        raise AssertionError(f"{' '.join(call)} ended with {result.returncode}:\n{result.stderr}")
    return result.stdout if status == 0 else result.stderr


def document(*arguments: object) -> dict:
    """Returns the JSON output of a command."""
    return json.loads(command(*arguments, "--json"))
