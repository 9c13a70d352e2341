"""The thesis' four design variables and criteria, for the optimisation and sensitivity examples."""

from __future__ import annotations

from typing import Any

import numpy as np
import phalanx

# Spring and motor are sized separately for each design, as in the thesis' grid (§4.2).
SCENE = """
name = "design"
sizing = "rigid"
contact.friction.mu_static = 0.8

[design]
base = "15.5 mm"
l21_fraction = 1.0
phi22 = "120 deg"
arm_ratio = 0.5
"""

# Ranges of the grid: m, 1, rad, 1.
VARIABLES = {
    "design.base": (12e-3, 22.5e-3),
    "design.l21_fraction": (0.0, 1.0),
    "design.phi22": (np.radians(90), np.radians(120)),
    "design.arm_ratio": (1 / 3, 2 / 3),
}
LOWER = np.array([low for low, _ in VARIABLES.values()])
UPPER = np.array([high for _, high in VARIABLES.values()])

DESIGN_95 = np.array([15.5e-3, 1.0, np.radians(120), 0.5])

CLASSES = ["stable", "semi-stable", "semi-unstable", "unstable"]
# Duration of a run, s; also the time to stability of a design that never becomes stable.
DURATION_S = 20e-3
# Peak force of a design without results: far above any real one, and finite, because some optimisers reject NaN.
NO_RESULT_FORCE_N = 1e7

COLUMNS = ["status", "reason", "tts_s", "class", "force_positive", "form_closed", "pfp_n", "peak_f21_n", "peak_f22_n"]


def load_scene() -> phalanx.Scene:
    """Returns the scene whose variables are changed."""
    return phalanx.Scene.from_toml(SCENE, "design.toml")


def is_false(flags: np.ndarray[Any, Any]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """1 for each flag that is missing or False."""
    return np.array([value is not True and value is not np.True_ for value in flags], dtype=np.float64)


def evaluate_designs(base: phalanx.Scene, designs: np.ndarray, threads: int = 0) -> dict[str, np.ndarray]:
    """Returns time to stability (s), peak force (N) and violation of the thesis' criteria (0 if met) of each row.

    The criteria are those of `phalanx thesis select`: force positive, form closed, stable or semi-stable, and pressed on the
    palm.
    """
    fields: dict[str, Any] = dict(zip(VARIABLES, np.atleast_2d(designs).T, strict=True))
    table = phalanx.evaluate(base, fields, columns=COLUMNS, threads=threads)
    tts_s = np.where(np.isnan(table["tts_s"]), DURATION_S, table["tts_s"])
    peak_n = np.fmax(table["peak_f21_n"], table["peak_f22_n"])
    missing = np.isnan(peak_n)
    peak_n = np.where(missing, NO_RESULT_FORCE_N, peak_n)
    classes = np.array([CLASSES.index(name) if name in CLASSES else len(CLASSES) for name in table["class"]])
    pfp_n = np.where(np.isnan(table["pfp_n"]), -100.0, table["pfp_n"])
    violation = is_false(table["force_positive"]) + is_false(table["form_closed"])
    violation += np.maximum(classes - 1, 0) + np.maximum(-pfp_n, 0) / 10.0
    return {"tts_s": tts_s, "peak_n": peak_n, "violation": violation + missing}
