"""Reports of an optimisation: text, JSON document, picture, page, and scenes of the front."""

from __future__ import annotations

import html
import io
import json
import math
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from .. import __version__
from .search import STATUSES, ArrowTable, Found, require
from .study import CLASSES, Constraint, Objective, Optimisation

MARK = f"phalanx {__version__}"
"""Mark of the files that this package writes."""

# Unit of a column by the suffix of its name, the longest suffixes first, with the factor from SI.
_UNITS = {
    "n_m_s_per_rad": ("N·m·s/rad", 1.0),
    "n_m_per_rad": ("N·mm/rad", 1e3),
    "n_s_per_m": ("N·s/m", 1.0),
    "kg_m3": ("kg/m³", 1.0),
    "kg_m2": ("g·mm²", 1e9),
    "rad_s": ("rad/s", 1.0),
    "m_s2": ("m/s²", 1.0),
    "n_m": ("N·mm", 1e3),
    "m_s": ("m/s", 1.0),
    "percent": ("%", 1.0),
    "rad": ("°", 180.0 / math.pi),
    "hz": ("Hz", 1.0),
    "pa": ("MPa", 1e-6),
    "kg": ("g", 1e3),
    "m": ("mm", 1e3),
    "s": ("ms", 1e3),
    "n": ("N", 1.0),
}

# Colours of pictures and their replacements on a dark background.
_DARK = {"#ffffff": "#1b1f26", "#000000": "#eceff3", "#b2b2b2": "#6b7480", "#1f77b4": "#56b4e9", "#ff7f0e": "#ff9a52"}


class _Quantity:
    """Display format of a column of SI values."""

    def __init__(self, column: str) -> None:
        last = column.rpartition(".")[2]
        suffix = next((suffix for suffix in _UNITS if last.endswith(f"_{suffix}")), None)
        self.name = last.removesuffix(f"_{suffix}") if suffix else last
        self.unit, self.scale = _UNITS[suffix] if suffix else ("", 1.0)
        self.label = f"{self.name}, {self.unit}" if self.unit else self.name

    def value(self, value: Any, digits: int) -> str:
        """Formats a value without its unit; a missing value is a dash."""
        if isinstance(value, bool | np.bool_):
            return "yes" if value else "no"
        if isinstance(value, str):
            return value
        return "–" if value is None or not math.isfinite(value) else format_number(float(value) * self.scale, digits)


def format_number(value: float, digits: int) -> str:
    """Formats a number with `digits` significant digits and without trailing zeros; it has an exponent beyond 1e-3
    to 1e6.
    """
    scientific = f"{value:.{digits - 1}e}"
    exponent = int(scientific.partition("e")[2])
    if value == 0.0:
        return "0"
    if not -3 <= exponent < 6:
        return scientific
    text = f"{value:.{max(digits - 1 - exponent, 0)}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def _table(rows: list[list[str]]) -> str:
    """Aligns rows in columns: the first column left, the others right."""
    widths = [max(len(row[index]) for row in rows) for index in range(len(rows[0]))]
    lines = []
    for first, *others in rows:
        cells = [first.ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(others, widths[1:], strict=True))]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines) + "\n"


def _variable_labels(optimisation: Optimisation) -> list[str]:
    """Returns names with units: the last part of the path, after its parent if the name is not unique."""
    labels = [_Quantity(variable.column).label for variable in optimisation.variables]
    return [
        f"{variable.path.split('.')[-2]}.{label}" if labels.count(label) > 1 and "." in variable.path else label
        for variable, label in zip(optimisation.variables, labels, strict=True)
    ]


def _constraint_label(constraint: Constraint) -> str:
    quantity = _Quantity(constraint.column)
    if constraint.worst_class is not None:
        return f"at least {CLASSES[constraint.worst_class]}"
    if constraint.equals is not None:
        if isinstance(constraint.equals, bool):
            return quantity.name if constraint.equals else f"not {quantity.name}"
        return f"{quantity.name} {constraint.equals}"
    least, most = (
        None if bound is None else f"{quantity.value(bound, 6)} {quantity.unit}".strip()
        for bound in (constraint.at_least, constraint.at_most)
    )
    if least is not None and most is not None:
        return f"{quantity.name} from {least} to {most}"
    return f"{quantity.name} ≥ {least}" if least is not None else f"{quantity.name} ≤ {most}"


def _headline(optimisation: Optimisation) -> str:
    method = optimisation.method
    return (
        f"{optimisation.name}: {optimisation.model} model, {method.name}, generations of {method.population} designs, "
        f"{_count(len(optimisation.conditions), 'condition')}"
    )


def _count(count: int, name: str) -> str:
    return f"one {name}" if count == 1 else f"{count} {name}s"


def plan_text(optimisation: Optimisation) -> str:
    """Describes the search space, objectives and constraints without running the search."""
    rows = [["variable", "from", "to", "start"]]
    for variable, label in zip(optimisation.variables, _variable_labels(optimisation), strict=True):
        quantity = _Quantity(variable.column)
        values = (*variable.ends_si, variable.si_at(variable.start_fraction))
        rows.append([label, *(quantity.value(value, 4) for value in values)])

    def line(objective: Objective) -> str:
        goal = "small" if objective.goal == "min" else "large"
        over = f", {objective.over} of all conditions" if len(optimisation.conditions) > 1 else ""
        return f"objective   {objective.name} {goal}{over}"

    lines = [line(objective) for objective in optimisation.objectives]
    lines += [f"constraint  {_constraint_label(constraint)}" for constraint in optimisation.constraints]
    most = f"at most {optimisation.max_designs} designs, {optimisation.max_runs} runs"
    return "\n".join([f"{_headline(optimisation)}\n", _table(rows), *lines, "", most, ""])


def selected(found: Found) -> list[tuple[str, int]]:
    """Returns the designs that are compared with the start: the best design for each objective, and the compromise."""
    objectives = found.optimisation.objectives
    roles = [f"best {objective.name}" if len(objectives) > 1 else "best" for objective in objectives]
    designs = [*((role, found.best(index)) for index, role in enumerate(roles)), ("compromise", found.compromise())]
    return [(role, index) for role, index in designs if index is not None]


def scene_file(found: Found, index: int) -> str:
    """Returns the file name of the scene of a design. In alphabetical order, the names are in the order of the
    numbers.
    """
    return f"design-{index + 1:0{len(str(len(found.generation)))}}.toml"


def reasons(runs: ArrowTable) -> list[dict[str, Any]]:
    """Groups the runs that were not completed or have no verdict. Runs in a group have the same status and, apart
    from numbers, the same reason.
    """
    groups: dict[tuple[str, str], dict[str, Any]] = {}
    counts: dict[tuple[str, str], int] = defaultdict(int)
    for run, status, reason in zip(*(runs[name].to_pylist() for name in ("run", "status", "reason")), strict=True):
        if reason is None:
            continue
        words = ["#" if any(map(str.isdigit, word)) and word[0] != "`" else word for word in reason.split()]
        key = (status, " ".join(words))
        groups.setdefault(key, {"status": status, "reason": reason, "runs": 0, "first_run": run})
        counts[key] += 1
    listed = [{**group, "runs": counts[key]} for key, group in groups.items()]
    return sorted(listed, key=lambda group: (STATUSES.index(group["status"]), -group["runs"], group["first_run"]))


def _comparison(found: Found, has_scenes: bool) -> list[list[str]]:
    """Returns a table of the start and the selected designs."""
    optimisation, scores, chosen = found.optimisation, found.scores, selected(found)
    designs = [0, *(index for _, index in chosen)]
    titles = {
        f"best {objective.name}": f"best {_Quantity(objective.name).name}" for objective in optimisation.objectives
    }
    rows = [["design", "start", *(titles.get(role, role) for role, _ in chosen)]]
    rows.append(["number", *(str(index + 1) for index in designs)])
    points = [found.point(index) for index in designs]
    for variable, label in zip(optimisation.variables, _variable_labels(optimisation), strict=True):
        quantity = _Quantity(variable.column)
        rows.append([label, *(quantity.value(point[variable.column], 4) for point in points)])
    gains = [found.gains(index) for index in designs]
    for number, objective in enumerate(optimisation.objectives):
        quantity = _Quantity(objective.name)
        rows.append([quantity.label, *(quantity.value(scores.values[index, number], 5) for index in designs)])
        texts = ["" if gain[number] is None else f"{100 * (gain[number] or 0.0):+.1f}" for gain in gains[1:]]
        rows.append(["  gain, %", "", *(text.replace("-", "−") for text in texts)])
    for constraint, worst in zip(optimisation.constraints, scores.worst, strict=True):
        quantity = _Quantity(constraint.column)
        rows.append([_constraint_label(constraint), *(quantity.value(worst[index], 4) for index in designs)])
    rows.append(["meets all", *("yes" if scores.feasible[index] else "no" for index in designs)])
    if has_scenes:
        rows.append(["scene", "start.toml", *(scene_file(found, index) for index in designs[1:])])
    return rows


def _front(found: Found, indices: list[int]) -> list[list[str]]:
    """Returns a table of designs with their objectives and variables."""
    optimisation = found.optimisation
    objectives = [_Quantity(objective.name) for objective in optimisation.objectives]
    variables = [_Quantity(variable.column) for variable in optimisation.variables]
    rows = [["design", *(quantity.label for quantity in objectives), *_variable_labels(optimisation)]]
    for index in indices:
        values = zip(objectives, found.scores.values[index], strict=True)
        point = zip(variables, found.point(index).values(), strict=True)
        rows.append(
            [str(index + 1), *(q.value(value, 5) for q, value in values), *(q.value(value, 4) for q, value in point)]
        )
    return rows


def _evenly_spaced(indices: list[int], count: int) -> list[int]:
    """Selects at most `count` entries, evenly spaced and with both ends."""
    if len(indices) <= count or count < 2:
        return indices[: max(count, 1)]
    return [indices[index * (len(indices) - 1) // (count - 1)] for index in range(count)]


def _no_front(found: Found) -> str:
    """Explains why there is no front."""
    optimisation, scores = found.optimisation, found.scores
    index = int(np.argmin(scores.violation))
    limits = [
        f"{_constraint_label(constraint)} ({_Quantity(constraint.column).value(worst[index], 4)})"
        for constraint, worst in zip(optimisation.constraints, scores.worst, strict=True)
    ]
    violation, counts = format_number(scores.violation[index], 3), scores.by_status[index]
    return (
        f"None of {len(found.generation)} designs meets all constraints. The closest is design {index + 1} (violation "
        f"{violation}, {counts[0]} of {counts.sum()} runs completed){': ' if limits else ''}{'; '.join(limits)}. Widen "
        "the variables, relax a constraint, or search longer."
    )


def text(found: Found, best: int = 10, has_scenes: bool = False) -> str:
    """Returns the report: comparison with the start, `best` designs of the front, and counts of runs."""
    parts = [f"{_headline(found.optimisation)}\n", _table(_comparison(found, has_scenes))]
    if not found.front:
        parts.append(f"{_no_front(found)}\n")
    elif len(found.optimisation.objectives) > 1:
        shown = _evenly_spaced(found.front, best)
        count = f", {len(shown)} shown" if len(shown) < len(found.front) else ""
        parts.append(f"front: {len(found.front)} designs{count}\n{_table(_front(found, shown))}")
    if groups := reasons(found.runs):
        lines = [
            f"{group['runs']:7} {group['status']}, first run {group['first_run']}: {group['reason']}"
            for group in groups
        ]
        parts.append("\n".join(["reasons (numbers from the first run)", *lines, ""]))
    return "\n".join([*parts, f"{_summary(found)}\n{_work(found)}"])


def _summary(found: Found) -> str:
    counts = found.scores.by_status.sum(axis=0)
    statuses = [f"{count} {status}" for count, status in zip(counts, STATUSES, strict=True) if count]
    front = f", {len(found.front)} on the front" if len(found.optimisation.objectives) > 1 else ""
    volume = found.hypervolume()
    converged = ", converged" if found.converged else ""
    lines = [
        f"{len(found.generation)} designs in {found.generation[-1] + 1} generations{converged}: "
        f"{found.scores.feasible.sum()} meet all constraints{front}. {len(found.runs)} runs: {', '.join(statuses)}."
    ]
    if volume is not None:
        lines.append(
            f"Hypervolume {format_number(volume, 5)} (start alone: 1; reference: every objective worse by 100 %)."
        )
    return "\n".join(lines)


def _work(found: Found) -> str:
    """Describes the work of this call."""
    text = ""
    if found.new_runs < len(found.runs):
        text += f"{len(found.runs) - found.new_runs} runs existed already.\n"
    if found.simulations:
        rate, wall_s = format_number(found.simulations / found.wall_s, 3), format_number(found.wall_s, 3)
        threads = _count(found.threads, "thread").replace("one", "1")
        text += f"{found.simulations} simulations in {wall_s} s on {threads}: {rate} per second.\n"
    return text


def document(found: Found) -> dict[str, Any]:
    """Returns the report as a JSON document. Its keys contain the SI units."""
    optimisation, scores, compromise = found.optimisation, found.scores, found.compromise()
    rate = found.simulations / found.wall_s if found.wall_s else 0.0

    def design(index: int) -> dict[str, Any]:
        values = zip(optimisation.objectives, scores.values[index], strict=True)
        worst = zip(optimisation.constraints, scores.worst, strict=True)
        return {
            "design": index + 1,
            "generation": int(found.generation[index]),
            "feasible": bool(scores.feasible[index]),
            "violation": float(scores.violation[index]),
            "variables": found.point(index),
            "objectives": {objective.name: float(value) if np.isfinite(value) else None for objective, value in values},
            "constraints": {constraint.column: row[index] for constraint, row in worst},
        }

    def gains(index: int) -> dict[str, float | None]:
        pairs = zip(optimisation.objectives, found.gains(index), strict=True)
        return {objective.name: None if gain is None else 100.0 * gain for objective, gain in pairs}

    def limit(constraint: Constraint) -> dict[str, Any]:
        worst = constraint.worst_class
        at_least = constraint.at_least if worst is None else CLASSES[worst]
        return {
            "column": constraint.column,
            "at_least": at_least,
            "at_most": constraint.at_most,
            "equals": constraint.equals,
        }

    return {
        "name": optimisation.name,
        "model": optimisation.model,
        "algorithm": optimisation.method.name,
        "population": optimisation.method.population,
        "seed": optimisation.method.seed,
        "generations": int(found.generation[-1]) + 1,
        "converged": found.converged,
        "conditions": len(optimisation.conditions),
        "designs": len(found.generation),
        "feasible_designs": int(scores.feasible.sum()),
        "runs": len(found.runs),
        "by_status": {
            status: int(count) for status, count in sorted(zip(STATUSES, scores.by_status.sum(axis=0), strict=True))
        },
        "reasons": reasons(found.runs),
        "variables": [
            {
                "column": variable.column,
                "from": variable.ends_si[0],
                "to": variable.ends_si[1],
                "spacing": "log" if variable.is_log else "linear",
            }
            for variable in optimisation.variables
        ],
        "objectives": [
            {"name": objective.name, "columns": objective.columns, "goal": objective.goal, "over": objective.over}
            for objective in optimisation.objectives
        ],
        "constraints": [limit(constraint) for constraint in optimisation.constraints],
        "start": design(0),
        "front": [design(index) for index in found.front],
        "compromise": None if compromise is None else compromise + 1,
        "hypervolume": found.hypervolume(),
        "gains": [{"of": role, "design": index + 1, "percent": gains(index)} for role, index in selected(found)],
        "now": {
            "runs": found.new_runs,
            "simulations": found.simulations,
            "threads": found.threads,
            "wall_s": found.wall_s,
            "simulations_per_s": rate,
            "simulations_per_s_per_thread": rate / found.threads,
        },
    }


def scenes(found: Found) -> dict[str, str]:
    """Returns the scene files of the start and of the front, by file name. A comment in each file states the
    objectives.
    """
    return {"start.toml": _scene(found, 0), **{scene_file(found, index): _scene(found, index) for index in found.front}}


def _scene(found: Found, index: int) -> str:
    optimisation = found.optimisation
    rank = ", the compromise" if found.compromise() == index else ""
    first = ", under the first of its conditions" if len(optimisation.conditions) > 1 else ""
    values = zip(optimisation.objectives, found.scores.values[index], strict=True)
    figures = "".join(f" {objective.name} {value!r}," for objective, value in ((o, float(v)) for o, v in values))
    verdict = "meets all constraints" if found.scores.feasible[index] else "misses a constraint"
    scene = optimisation.scene.with_({**found.fields[index], **optimisation.conditions[0]})
    head = f'# Design {index + 1} of the search "{optimisation.name}" ({MARK}){rank}{first}'
    return f"{head}:{figures} {verdict}.\n{scene.toml}"


def picture(found: Found, format: str, has_links: bool = False) -> bytes:
    """Draws the designs that meet all constraints, the front, the start and the compromise.

    With several objectives, the first one is plotted against each of the others. With one objective, designs are
    plotted in the order of their evaluation. `format` is "svg" or "png". With `has_links`, points of the front link to
    `#design-N`.
    """
    require("matplotlib", "a picture")
    import matplotlib
    from matplotlib.figure import Figure

    optimisation, feasible = found.optimisation, np.flatnonzero(found.scores.feasible)
    quantities = [_Quantity(objective.name) for objective in optimisation.objectives]
    values = found.scores.values * [quantity.scale for quantity in quantities]
    labels = [quantity.label for quantity in quantities]
    if len(quantities) == 1:
        values = np.column_stack([np.arange(1, len(values) + 1), values])
        labels = ["design, in the order of evaluation", *labels]
    front, compromise = found.front, found.compromise()
    panels = len(labels) - 1
    figure = Figure(figsize=(8.0, 4.8 * panels), layout="constrained")
    for panel, axes in enumerate(figure.subplots(panels, 1, squeeze=False)[:, 0], 1):
        points = values[:, [0, panel]]
        axes.plot(
            *points[feasible].T, ".", color="0.7", markersize=3, label="other designs", rasterized=len(feasible) > 2000
        )
        if panels == 1 and len(quantities) > 1:
            axes.plot(*points[front].T, color="C0", alpha=0.4)
        marks = axes.scatter(
            *points[front].T, s=22, color="C0", zorder=3, label="front" if len(quantities) > 1 else "best"
        )
        if has_links:
            marks.set_urls([f"#design-{index + 1}" for index in front])
        start = "start" if found.scores.feasible[0] else "start, violates a constraint"
        axes.plot(*points[0], "^", color="C1", markersize=9, zorder=4, label=start)
        if compromise is not None:
            axes.plot(
                *points[compromise], "o", color="C2", markersize=12, fillstyle="none", zorder=4, label="compromise"
            )
        # Distant designs would compress the front: the range is that of the front and the start, enlarged by half.
        visible = points[[0, *front]]
        visible = visible[np.all(np.isfinite(visible), axis=1)]
        if len(visible):
            low, extent = visible.min(axis=0), np.ptp(visible, axis=0)
            margin = np.where(extent > 0.0, 0.5 * extent, 0.2 * np.abs(low))
            limits = np.array([low - margin, low + extent + margin])
            if len(quantities) > 1:
                axes.set_xlim(*limits[:, 0])
            axes.set_ylim(*limits[:, 1])
            outside = np.sum(np.any((points[feasible] < limits[0]) | (points[feasible] > limits[1]), axis=1))
            axes.set_xlabel(
                labels[0] + (f" ({outside} designs lie outside)" if outside and len(quantities) > 1 else "")
            )
        axes.set_ylabel(labels[panel])
        axes.legend(frameon=False)
    figure.suptitle(f"{optimisation.name}: designs that meet all constraints ({len(feasible)} of {len(values)})")
    buffer = io.BytesIO()
    # Without a salt and with a date, the same picture would have other bytes.
    with matplotlib.rc_context({"svg.hashsalt": "phalanx", "svg.fonttype": "none"}):
        metadata = {"Creator": MARK, "Date": None} if format == "svg" else {"Software": MARK}
        figure.savefig(buffer, format=format, dpi=120, metadata=metadata)
    return _with_dark_scheme(buffer.getvalue()) if format == "svg" else buffer.getvalue()


def _with_dark_scheme(svg: bytes) -> bytes:
    """Adds the colours of a standalone picture for viewers with a dark scheme."""
    rules = [
        f'svg:root [style*="{attribute}: {light}"] {{ {attribute}: {dark} !important; }}'
        for light, dark in _DARK.items()
        for attribute in ("fill", "stroke")
    ]
    # Matplotlib omits the fill of black text and markers.
    rules.append(f'svg:root :is(text, use):not([style*="fill:"]) {{ fill: {_DARK["#000000"]}; }}')
    style = "<style>@media (prefers-color-scheme: dark) {\n" + "\n".join(rules) + "\n}</style>\n"
    return svg.replace(b" <defs>", f" {style} <defs>".encode(), 1)


def page(found: Found) -> str:
    """Returns an HTML page with the picture, the tables and the scenes of the front."""

    def table(rows: list[list[str]], has_links: bool = False) -> str:
        lines = []
        for number, row in enumerate(rows):
            tag = "th" if number == 0 else "td"
            cells = [html.escape(cell) for cell in row]
            if has_links and number:
                cells[0] = f'<a href="#design-{cells[0]}">{cells[0]}</a>'
            lines.append("<tr>" + "".join(f"<{tag}>{cell}</{tag}>" for cell in cells) + "</tr>")
        return "<table>\n" + "\n".join(lines) + "\n</table>"

    title, description = html.escape(found.optimisation.name), html.escape(found.optimisation.description)
    svg = picture(found, "svg", has_links=True).decode()
    details = [
        f'<details id="design-{index + 1}" open><summary>Design {index + 1}</summary>'
        f"<pre>{html.escape(_scene(found, index))}</pre></details>"
        for index in found.front
    ]
    return "\n".join(
        [
            "<!doctype html>",
            f'<html lang="en"><head><meta charset="utf-8"><meta name="generator" content="{MARK}">',
            f"<title>{title}</title>",
            "<style>body{font:15px sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color-scheme:light dark}"
            "td,th{text-align:right;padding:.1em .7em}td:first-child,th:first-child{text-align:left}svg{max-width:100%}"
            "pre{overflow-x:auto}</style></head><body>",
            f"<h1>{title}</h1><p>{description}</p><pre>{html.escape(_headline(found.optimisation))}\n\n"
            f"{html.escape(_summary(found))}</pre>",
            f"<h2>Designs</h2>{svg[svg.index('<svg') :]}",
            f"<h2>Gains</h2><p>The start and the best designs; below each objective, the gain over the start.</p>"
            f"{table(_comparison(found, False))}",
            "<h2>Pareto front</h2><p>The number of a design, and its point in the picture, lead to its scene.</p>"
            f"{table(_front(found, found.front), has_links=True)}",
            *details,
            "</body></html>\n",
        ]
    )


def json_text(found: Found) -> str:
    """Returns the JSON document as text."""
    return json.dumps(document(found), indent=2, ensure_ascii=False) + "\n"


def table_bytes(path: Path, table: ArrowTable, fingerprint: str, generation: Any = None) -> bytes:
    """Returns the contents of a table file, as CSV or Parquet according to the suffix of the path.

    If `generation` is given, a table of runs gets a column with the generation of each design.
    """
    import pyarrow.csv
    import pyarrow.parquet

    buffer = io.BytesIO()
    if generation is not None:
        table = table.append_column("generation", [np.repeat(generation, len(table) // len(generation))])
    if path.suffix == ".parquet":
        metadata = {"phalanx.optimize": fingerprint}
        pyarrow.parquet.write_table(table.replace_schema_metadata(metadata), buffer)
    else:
        buffer.write(",".join(table.column_names).encode() + b"\n")
        options = pyarrow.csv.WriteOptions(include_header=False, quoting_style="needed")
        pyarrow.csv.write_csv(table, buffer, options)
    return buffer.getvalue()
