"""Studies of an optimisation: the keys of the file, their checks, and the resulting problem."""

from __future__ import annotations

import difflib
import itertools
import math
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from .. import _phalanx
from ..errors import Problem, SceneError, StudyError

CLASSES = ["stable", "semi-stable", "semi-unstable", "unstable"]
"""Classes of a closing, from good to bad."""

MAX_RUNS = 1_000_000
"""Largest number of runs of a search, whose rows are stored in memory."""

# The columns that name the verdict of a run: of a finger, of a gripper of two such fingers, of any other grasp.
_VERDICTS = ("class", "grasp", "fate")


@dataclass(frozen=True)
class _Key:
    """A key of a study file."""

    type: Literal["string", "value", "list", "count", "flag", "scene"]
    description: str
    choices: tuple[str, ...] = ()
    default: str | int | bool | None = None


_SPACING = _Key("string", "Spacing of the values of a range.", ("linear", "log"), "linear")

# Keys of the file by table; the name of a list of tables ends in [].
_KEYS: dict[str, dict[str, _Key]] = {
    "": {
        "name": _Key("string", "Name in reports. Default: the file's name without its extension."),
        "description": _Key("string", "Description of the optimisation."),
        "scene": _Key(
            "scene",
            "Base scene, from which the search starts and with which its results are compared: a file, relative to the "
            "directory of this file, or a table [scene] with the keys of a scene, which may extend a file.",
        ),
        "model": _Key("string", "Simulation model.", ("analytic", "engine"), "analytic"),
    },
    "variables[]": {
        "field": _Key("string", 'Field of a scene, such as "design.base" or "spring.torque".'),
        "from": _Key("value", "One bound of the range."),
        "to": _Key("value", "The other bound of the range."),
        "spacing": _SPACING,
        "start": _Key("value", "Start value of the search. Default: the value in the base scene."),
    },
    "conditions[]": {
        "field": _Key("string", 'Field of a scene, such as "contact.friction.mu_static".'),
        "fields": _Key("list", "Fields that vary together; requires `rows`."),
        "values": _Key("list", "Values, written as in a scene."),
        "rows": _Key("list", "Rows of values, one value for each of `fields`."),
        "from": _Key("value", "First value of a range."),
        "to": _Key("value", "Last value of a range."),
        "count": _Key("count", "Number of values of the range including both ends."),
        "spacing": _SPACING,
    },
    "objectives[]": {
        "column": _Key("string", 'Numeric column of a run, such as "tts_s" or "peak_f21_n".'),
        "columns": _Key("list", "Several columns, aggregated by `of`."),
        "of": _Key("string", "Aggregation of several columns.", ("largest", "smallest", "sum"), "largest"),
        "goal": _Key("string", "Direction: minimise or maximise.", ("min", "max"), "min"),
        "over": _Key("string", "Aggregation over several conditions.", ("worst", "mean"), "worst"),
        "name": _Key(
            "string",
            "Column name in the results; it should end in its unit. Default: the column, or the aggregation followed "
            "by the columns.",
        ),
    },
    "constraints[]": {
        "column": _Key("string", 'Column of a run, such as "class", "form_closed" or "pfp_n".'),
        "at_least": _Key(
            "value",
            "Smallest value allowed: a number in the column's unit or a quantity. For the column `class`: the worst "
            "class allowed.",
        ),
        "at_most": _Key("value", "Largest value allowed."),
        "equals": _Key("value", "Required value of a text or boolean column."),
    },
    "filter": {
        "force_positive": _Key("flag", "Only designs with positive forces at rest."),
        "palm_force_positive": _Key("flag", "Only designs that press the object onto the palm at rest."),
        "form_closed": _Key("flag", "Only form-closed designs."),
    },
    "method": {
        "algorithm": _Key(
            "string",
            '"nsga2" finds the front of several objectives, "cma-es" the best of one. Default: by the number of '
            "objectives.",
            ("nsga2", "cma-es"),
        ),
        "population": _Key(
            "count", "Number of designs per generation. Default: 64 with nsga2, 4 + 3 ln n for n variables with cma-es."
        ),
        "generations": _Key(
            "count",
            "Maximum number of generations; cma-es ends earlier when it has converged. Default: 50 with nsga2, 100 "
            "with cma-es.",
        ),
        "seed": _Key("count", "Seed of the random numbers.", default=1),
    },
}

_SECTIONS = {
    "variables[]": "Fields to vary, with their bounds.",
    "conditions[]": "Conditions under which every design runs, in all combinations, such as friction or offsets.",
    "objectives[]": "Figures to minimise or maximise.",
    "constraints[]": "Requirements under every condition.",
    "filter": "Static criteria of the designs to simulate.",
    "method": "Search method.",
}

_TYPE_NAMES = {
    "string": "a string in quotes",
    "value": "a number, or a string with a unit",
    "list": "a list [.., ..] with at least one entry",
    "count": "a whole number, 0 or more",
    "flag": "true or false",
    "scene": "the path of a scene, or a table [scene]",
}


def schema() -> dict[str, Any]:
    """Returns the JSON Schema of study files, for editors."""
    types: dict[str, dict[str, Any]] = {
        "string": {"type": "string"},
        "value": {"type": ["string", "number", "boolean"]},
        "list": {"type": "array", "minItems": 1},
        "count": {"type": "integer", "minimum": 0},
        "flag": {"type": "boolean"},
        "scene": {"type": ["string", "object"]},
    }

    def table(section: str) -> dict[str, Any]:
        properties = {}
        for name, key in _KEYS[section].items():
            choices = {"enum": list(key.choices)} if key.choices else {}
            default = {} if key.default is None else {"default": key.default}
            properties[name] = {"description": key.description, **types[key.type], **choices, **default}
        return {"type": "object", "additionalProperties": False, "properties": properties}

    document = {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "phalanx optimisation",
        "description": "An optimisation: a base scene, variables, objectives and constraints.",
        **table(""),
    }
    for section, description in _SECTIONS.items():
        content: dict[str, Any] = table(section)
        if section.endswith("[]"):
            content = {"type": "array", "items": content}
        document["properties"][section.removesuffix("[]")] = {"description": description, **content}
    return document


@dataclass(frozen=True)
class Range:
    """A closed interval of a field, interpolated in the unit of the study file."""

    ends: tuple[float, float]
    """Numbers in `unit`."""
    ends_si: tuple[float, float]
    unit: str
    """Unit of the scene values; empty for plain numbers."""
    is_log: bool

    def value_at(self, fraction: float) -> str | float:
        """Returns the value of the field at a fraction of the range, from 0 to 1, as written in a scene."""
        number = self._interpolate(self.ends, fraction)
        return f"{number!r} {self.unit}" if self.unit else number

    def si_at(self, fraction: float) -> float:
        """Returns the SI value at a fraction of the range."""
        return self._interpolate(self.ends_si, fraction)

    def _interpolate(self, ends: tuple[float, float], fraction: float) -> float:
        if fraction in (0.0, 1.0):
            return ends[int(fraction)]
        if self.is_log:
            return float(ends[0] * (ends[1] / ends[0]) ** fraction)
        return ends[0] + (ends[1] - ends[0]) * fraction

    def fraction_of(self, si: float) -> float:
        """Returns the fraction of the range at which an SI value lies."""
        first, last = self.ends_si
        if si in self.ends_si:
            return float(self.ends_si.index(si))
        return math.log(si / first) / math.log(last / first) if self.is_log else (si - first) / (last - first)


@dataclass(frozen=True)
class Variable:
    """A field that the search varies."""

    path: str
    column: str
    """Name of its column in the results: the path with the unit of the SI value."""
    range: Range
    start: Any
    """Start value, as written in a scene."""
    start_fraction: float

    def value_at(self, fraction: float) -> Any:
        """Returns the value at a fraction of the range, as written in a scene."""
        return self.start if fraction == self.start_fraction else self.range.value_at(fraction)


@dataclass(frozen=True)
class Objective:
    """A figure to minimise or maximise."""

    name: str
    columns: list[str]
    of: str
    """Aggregation of the columns: "largest", "smallest" or "sum"."""
    goal: str
    """ "min" or "max"."""
    over: str
    """Aggregation over the conditions: "worst" or "mean"."""


@dataclass(frozen=True)
class Constraint:
    """A requirement under every condition; bounds are numbers in SI."""

    column: str
    at_least: float | None = None
    at_most: float | None = None
    equals: bool | str | None = None
    worst_class: int | None = None
    """Index of the worst class allowed, from good to bad."""


@dataclass(frozen=True)
class Method:
    """Parameters of the search."""

    algorithm: str
    """ "nsga2" or "cma-es"."""
    population: int
    generations: int
    seed: int

    @property
    def name(self) -> str:
        """Name in reports."""
        return {"nsga2": "NSGA-II", "cma-es": "CMA-ES"}[self.algorithm]


@dataclass
class Optimisation:
    """A validated optimisation."""

    name: str
    description: str
    model: Literal["analytic", "engine"]
    scene: _phalanx.Scene
    files: list[Path]
    """The study file, and the file of the base scene if it has one."""
    variables: list[Variable]
    conditions: list[dict[str, Any]]
    """Values of the fields of each condition; one empty condition if there are none."""
    objectives: list[Objective]
    constraints: list[Constraint]
    filter: dict[str, bool]
    method: Method
    verdict: str | None
    """Column with the verdict of a run: "class", "grasp" or "fate"; None for scenes without a grasp."""
    source: dict[str, Any] = field(repr=False, default_factory=dict)
    """Contents of the study file."""

    @property
    def max_designs(self) -> int:
        """Largest number of designs; CMA-ES evaluates the start as a separate generation."""
        return int(self.method.algorithm == "cma-es") + self.method.population * self.method.generations

    @property
    def max_runs(self) -> int:
        """Largest number of runs."""
        return self.max_designs * len(self.conditions)


class _Checker:
    """Collects the problems of a study file."""

    def __init__(self, text: str, file: str) -> None:
        self.text, self.file, self.problems = text, file, list[Problem]()

    def add(self, where: str, message: str, help: str) -> None:
        """Reports a problem at a path such as "objectives[1].column"."""
        line = _line(self.text, where)
        self.problems.append(
            {"file": self.file, "line": line, "column": None, "field": where or None, "message": message, "help": help}
        )

    def finish(self) -> None:
        """Raises StudyError if there are problems."""
        if not self.problems:
            return
        blocks = []
        for problem in self.problems:
            line = f":{problem['line']}" if problem["line"] else ""
            place = f": {problem['field']}" if problem["field"] else ""
            blocks.append(f"error: {problem['message']}\n --> {self.file}{line}{place}\n  = help: {problem['help']}")
        raise StudyError("\n\n".join(blocks), self.problems)

    def section(self, document: dict[str, Any], name: str) -> list[tuple[str, dict[str, Any]]]:
        """Returns the tables of a section with their paths; keys with invalid values are removed."""
        content = document.get(name.removesuffix("[]"), [] if name.endswith("[]") else {})
        tables = content if name.endswith("[]") else [content]
        base = name.removesuffix("[]")
        if not (isinstance(tables, list) and all(isinstance(table, dict) for table in tables)):
            self.add(base, f"`{base}` is not a table", f"write {_brackets(name)} and its keys below it")
            return []
        result = []
        for index, table in enumerate(tables):
            path = f"{base}[{index}]" if name.endswith("[]") else base
            result.append((path, self.read_table(table, name, path)))
        return result

    def read_table(self, table: dict[str, Any], section: str, path: str) -> dict[str, Any]:
        """Checks keys and types of one table, and inserts defaults."""
        keys = _KEYS[section]
        allowed = [*keys, *(section.removesuffix("[]") for section in _SECTIONS)] if section == "" else list(keys)
        values = {}
        for name, value in table.items():
            where = f"{path}.{name}" if path else name
            if name not in allowed:
                place = f"in {_brackets(section)}" if path else "at the top level"
                self.add(where, f"unknown key `{name}` {place}", _suggest(name, allowed, f"keys {place}"))
                continue
            if name not in keys:
                continue
            key = keys[name]
            if not _has_type(value, key.type):
                self.add(where, f"`{name}` is {_describe(value)}, but must be {_TYPE_NAMES[key.type]}", key.description)
            elif key.choices and value not in key.choices:
                self.add(where, f'`{name}` is "{value}"', _suggest(value, key.choices, "allowed"))
            else:
                values[name] = value
        defaults = {name: key.default for name, key in keys.items() if key.default is not None}
        return {**defaults, **values}

    def require(self, table: dict[str, Any], path: str, key: str, help: str) -> Any:
        """Returns a required value, or None after reporting that it is missing."""
        if key not in table:
            self.add(path, f"`{key}` is missing", help)
        return table.get(key)


def _brackets(section: str) -> str:
    """Returns the header of a section in a TOML file."""
    return f"[[{section.removesuffix('[]')}]]" if section.endswith("[]") else f"[{section}]"


def _has_type(value: Any, type_name: str) -> bool:
    match type_name:
        case "string":
            return isinstance(value, str) and value.strip() != "" and "\n" not in value
        case "value":
            return isinstance(value, str | bool) or (isinstance(value, int | float) and math.isfinite(value))
        case "list":
            return isinstance(value, list) and len(value) > 0
        case "count":
            return isinstance(value, int) and not isinstance(value, bool) and value >= 0
        case "flag":
            return isinstance(value, bool)
        case _:
            return isinstance(value, str | dict)


def _describe(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return f"the number {value}"
    if isinstance(value, str):
        return f'the string "{value}"'
    return "an empty list" if value == [] else "a list" if isinstance(value, list) else "a table"


def _suggest(name: str, allowed: Any, title: str) -> str:
    """Returns the most similar name, and all allowed names."""
    names = list(allowed)
    similar = difflib.get_close_matches(name, names, n=1)
    suggestion = f'did you mean "{similar[0]}"? ' if similar else ""
    return f"{suggestion}{title}: {', '.join(names)}"


def _line(text: str, where: str) -> int | None:
    """Returns the line of a path such as "objectives[1].column" in a TOML text, or that of its table."""
    section, counts, nearest = "", dict[str, int](), None
    for number, line in enumerate(text.splitlines(), 1):
        if header := re.match(r"\s*(\[\[?)\s*([^\]]+?)\s*\]", line):
            section = header[2]
            if header[1] == "[[":
                counts[section] = counts.get(section, -1) + 1
                section = f"{section}[{counts[section]}]"
            if where == section or where.startswith(f"{section}.") or section.startswith(f"{where}["):
                nearest = nearest or number if section.startswith(f"{where}[") else number
        elif key := re.match(r"\s*([\w.-]+)\s*=", line):
            path = f"{section}.{key[1]}" if section else key[1]
            if where == path:
                return number
            if re.match(re.escape(path) + r"[.\[]", where):
                nearest = number
    return nearest


def load(path: Path, model: str | None = None) -> Optimisation:
    """Reads and checks a study file and its base scene; `model` overrides the model of the study.

    Raises StudyError or SceneError with file, line and field of the errors.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise StudyError(
            f"error: cannot read {path}: {error}\n  = help: name an existing study file in UTF-8"
        ) from None
    return parse(text, str(path), model)


def parse(text: str, file: str, model: str | None = None) -> Optimisation:
    """Checks the text of a study. `file` appears in messages, and the base scene is relative to its directory."""
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        line = re.search(r"line (\d+)", str(error))
        problem: Problem = {
            "file": file,
            "line": int(line[1]) if line else None,
            "column": None,
            "field": None,
            "message": str(error),
            "help": "correct the TOML",
        }
        raise StudyError(f"error: invalid TOML: {error}\n --> {file}\n  = help: see toml.io", [problem]) from None
    checker = _Checker(text, file)
    top = checker.read_table(document, "", "")
    if model is not None:
        top["model"] = model
    raw = {name.removesuffix("[]"): checker.section(document, name) for name in _SECTIONS}
    if "scene" not in document:
        help = 'name the base scene: scene = "my-scene.toml", or write a table [scene]'
        checker.add("", "`scene` is missing", help)
    for name, example in [
        ("variables", "the fields to vary: [[variables]] with field, from and to"),
        ("objectives", 'a figure to minimise or maximise: [[objectives]] with column = "tts_s"'),
    ]:
        if document.get(name, []) == []:
            checker.add("", f"there are no [[{name}]]", f"add {example}")
    checker.finish()

    scene = _base_scene(top["scene"], raw["variables"], checker)
    columns = _columns(scene, [], checker, "")
    variables = _variables(raw["variables"], scene, checker)
    conditions = _conditions(raw["conditions"], scene, [variable.path for variable in variables], checker)
    objectives = [objective for each in raw["objectives"] if (objective := _objective(*each, columns, checker))]
    constraints = [constraint for each in raw["constraints"] if (constraint := _constraint(*each, columns, checker))]
    (_, filter_) = raw["filter"][0]
    if filter_ and scene.kind != "finger":
        message = f'[filter] concerns the statics of one finger, but the base scene is of kind "{scene.kind}"'
        checker.add("filter", message, "remove it: the results contain the fate of every grasp")
    method = _method(raw["method"][0][1], len(raw["objectives"]), len(variables), checker)
    checker.finish()
    _report_duplicates(variables, objectives, constraints, checker)
    base = top["scene"] if isinstance(top["scene"], str) else top["scene"].get("extends")
    optimisation = Optimisation(
        name=top.get("name", Path(file).stem),
        description=top.get("description", ""),
        model=top["model"],
        scene=scene,
        files=[Path(file), *([Path(file).parent / base] if isinstance(base, str) else [])],
        variables=variables,
        conditions=conditions,
        objectives=objectives,
        constraints=constraints,
        filter=filter_,
        method=method,
        verdict=next((name for name in _VERDICTS if name in columns), None),
        source=document,
    )
    if optimisation.max_runs >= MAX_RUNS:
        message = f"the optimisation has more than {MAX_RUNS} runs: population times generations times conditions"
        checker.add("method", message, "reduce population, generations or conditions")
    checker.finish()
    return optimisation


def _base_scene(scene: str | dict[str, Any], variables: list[tuple[str, Any]], checker: _Checker) -> _phalanx.Scene:
    """Returns the base scene; start values of the study replace its own."""
    if isinstance(scene, str) and not (Path(checker.file).parent / scene).is_file():
        help = "give the path relative to the directory of the study"
        checker.add("scene", f"the base scene {scene} does not exist", help)
        checker.finish()
    table: dict[str, Any] = {"extends": scene} if isinstance(scene, str) else scene
    for _, variable in variables:
        if "start" in variable and "field" in variable:
            table = _inserted(table, variable["field"].split("."), variable["start"])
    try:
        base = _phalanx.Scene.from_dict(table, checker.file)
    except SceneError as error:
        for problem in error.problems:
            if problem["file"] != checker.file:
                raise
            where = f"scene.{problem['field']}" if problem["field"] else "scene"
            checker.add(where, problem["message"], problem["help"])
        checker.finish()
        raise
    except (OverflowError, TypeError, ValueError) as error:
        checker.add("scene", f"a value of the base scene is invalid: {error}", "write strings, numbers, flags or lists")
        checker.finish()
        raise
    return base


def _inserted(table: dict[str, Any], path: list[str], value: Any) -> dict[str, Any]:
    """Returns a copy of nested tables with another value at a path."""
    first, *rest = path
    inner = table.get(first, {})
    return {**table, first: _inserted(inner if isinstance(inner, dict) else {}, rest, value) if rest else value}


def _columns(scene: _phalanx.Scene, fields: list[str], checker: _Checker, where: str) -> dict[str, str]:
    """Returns the columns of a run with these fields, and their types: "number", "flag" or "text"."""
    import pyarrow

    try:
        table = _phalanx.evaluate(scene, {path: [] for path in fields})
    except StudyError as error:
        message, _, help = str(error).removeprefix("error: ").partition("\n  = help: ")
        checker.add(where, message, help)
        return {}
    names = {"double": "number", "int64": "number", "bool": "flag"}
    return {entry.name: names.get(str(entry.type), "text") for entry in pyarrow.table(table).schema}


def _field_column(scene: _phalanx.Scene, path: str, checker: _Checker, where: str) -> tuple[str, str] | None:
    """Returns the column of a field and its type; reports an unknown field."""
    columns = list(_columns(scene, [path], checker, where).items())
    # The columns `run` and `design` precede the fields.
    return columns[2] if columns else None


def _si(checker: _Checker, where: str, column: str, value: Any) -> float | None:
    """Returns the SI value of a number or quantity; reports an invalid one."""
    toml = (
        str(value).lower() if isinstance(value, bool) else repr(value) if not isinstance(value, str) else _quoted(value)
    )
    try:
        return _phalanx._column_value(where.rpartition(".")[2], column, toml)
    except StudyError as error:
        message, _, help = str(error).partition("; ")
        checker.add(where, message, help)
        return None


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _range(table: dict[str, Any], where: str, column: tuple[str, str], checker: _Checker, remedy: str) -> Range | None:
    """Reads the range `from` … `to` of a field."""
    for key in ("from", "to"):
        if key not in table:
            checker.add(where, f"`{key}` is missing", "a range requires both ends: from and to")
            return None
    path = table["field"]
    if column[1] != "number":
        checker.add(f"{where}.from", f"`{path}` has no range, because it is not numeric", remedy)
        return None
    first, last = [_si(checker, f"{where}.{key}", column[0], table[key]) for key in ("from", "to")]
    if first is None or last is None:
        return None
    if first == last:
        checker.add(f"{where}.to", f"the ends of the range of `{path}` are equal", "give another end")
        return None
    is_log = table["spacing"] == "log"
    if is_log and min(first, last) <= 0.0:
        message = f'the range of `{path}` is not above 0, as spacing = "log" requires'
        checker.add(f"{where}.spacing", message, 'change the range, or use spacing = "linear"')
        return None
    # Interpolation in a unit of the file yields the numbers that a user would write.
    parts = [re.fullmatch(r"\s*(\S+?)\s*([A-Za-z%°µ].*?)\s*", str(table[key])) for key in ("from", "to")]
    if parts[0] is None or parts[1] is None:
        return Range((first, last), (first, last), "", is_log)
    numbers, units = [float(part[1]) for part in parts if part], [part[2] for part in parts if part]
    if units[0] != units[1]:
        units[0], numbers = (
            (units[0], [numbers[0], last * numbers[0] / first]) if first else (units[1], [0.0, numbers[1]])
        )
    return Range((numbers[0], numbers[1]), (first, last), units[0], is_log)


def _variables(raw: list[tuple[str, Any]], scene: _phalanx.Scene, checker: _Checker) -> list[Variable]:
    variables: list[Variable] = []
    for where, table in raw:
        if (path := table.get("field")) is None:
            checker.add(where, "`field` is missing", 'name the scene field to vary: field = "design.base"')
            continue
        if any(path == other.path for other in variables):
            checker.add(f"{where}.field", f"`{path}` is declared twice", "remove one of them")
            continue
        column = _field_column(scene, path, checker, f"{where}.field")
        if column is None or (range_ := _range(table, where, column, checker, "vary another field")) is None:
            continue
        try:
            start = table["start"] if "start" in table else scene[path]
        except KeyError:
            message = f"the base scene has no start value for `{path}`"
            checker.add(f"{where}.field", message, "give a start value: start = .., or add the field to the scene")
            continue
        key = "start" if "start" in table else "field"
        if (start_si := _si(checker, f"{where}.{key}", column[0], start)) is None:
            continue
        fraction = range_.fraction_of(start_si) if start_si > 0.0 or not range_.is_log else -1.0
        if not 0.0 <= fraction <= 1.0:
            message = f"the start value of `{path}`, {start}, is outside its range"
            checker.add(f"{where}.{key}", message, "widen the range, or give a start value within it: start = ..")
            continue
        variables.append(Variable(path, column[0], range_, start, fraction))
    return variables


def _conditions(
    raw: list[tuple[str, Any]], scene: _phalanx.Scene, varied: list[str], checker: _Checker
) -> list[dict[str, Any]]:
    """Returns the fields of each condition: all combinations of the axes, the last one fastest."""
    axes: list[list[dict[str, Any]]] = []
    for where, table in raw:
        if ("field" in table) == ("fields" in table):
            message = "a condition needs one of `field` and `fields`"
            checker.add(where, message, 'name the field of the scene: field = "contact.friction.mu_static"')
            continue
        key = "field" if "field" in table else "fields"
        paths = [table["field"]] if key == "field" else table["fields"]
        if not all(isinstance(path, str) for path in paths):
            checker.add(f"{where}.fields", "`fields` must contain names of fields", 'write fields = ["a.b", "c.d"]')
            continue
        needless = ["rows"] if key == "field" else ["values", "from", "to", "count"]
        if "values" in table:
            needless += ["from", "to", "count"]
        for name in needless:
            if name in table:
                checker.add(f"{where}.{name}", f"`{name}` has no effect in this condition", f"remove `{name}`")
        for path in paths:
            if path in varied:
                message = f"`{path}` is both a variable and a condition"
                checker.add(f"{where}.{key}", message, "remove one of them: a field can be either varied or prescribed")
            elif any(path in rows[0] for rows in axes) or paths.count(path) > 1:
                checker.add(f"{where}.{key}", f"`{path}` is given twice", "remove one of them")
        columns = [_field_column(scene, path, checker, f"{where}.{key}") for path in paths]
        if any(column is None for column in columns):
            continue
        rows = _condition_rows(where, table, paths, columns[0], checker)
        for path, column in zip(paths, columns, strict=True):
            if column is not None and column[1] == "number":
                source = "values" if "values" in table else "rows" if "rows" in table else None
                for row in rows if source else []:
                    _si(checker, f"{where}.{source}", column[0], row[path])
        if rows:
            axes.append(rows)
    combinations = itertools.product(*axes)
    return [{path: value for row in rows for path, value in row.items()} for rows in combinations]


def _condition_rows(
    where: str, table: dict[str, Any], paths: list[str], column: Any, checker: _Checker
) -> list[dict[str, Any]]:
    """Returns the values of the fields of one axis of conditions."""
    if "fields" in table:
        rows = checker.require(table, where, "rows", "give a row of values for each condition: rows = [[.., ..], ..]")
        if rows is None:
            return []
        if not all(isinstance(row, list) and len(row) == len(paths) for row in rows):
            checker.add(
                f"{where}.rows",
                f"every row must have {len(paths)} values, one for each of `fields`",
                "correct the rows",
            )
            return []
        return [dict(zip(paths, row, strict=True)) for row in rows]
    path = paths[0]
    if "values" in table:
        values = table["values"]
        if any(value in values[:index] for index, value in enumerate(values)):
            checker.add(f"{where}.values", f"`{path}` has a value twice", "remove one of them")
        return [{path: value} for value in values]
    if "from" not in table and "to" not in table:
        checker.add(where, "`values` is missing", "give values = [..], or a range: from, to and count")
        return []
    range_ = _range(table, where, column, checker, "list its values: values = [..]")
    count = checker.require(table, where, "count", "give the number of values of the range: count = 3")
    if range_ is None or count is None:
        return []
    if not 2 <= count <= MAX_RUNS:
        checker.add(
            f"{where}.count", f"the range of `{path}` has {count} values, but must have 2 or more", "give another count"
        )
        return []
    return [{path: range_.value_at(index / (count - 1))} for index in range(count)]


def _find_column(name: str, columns: dict[str, str], where: str, checker: _Checker) -> bool:
    if name in columns:
        return True
    known = [column for column in columns if column not in ("run", "design") and not column.startswith("check")]
    checker.add(where, f"the results have no column `{name}`", _suggest(name, known, "columns of a run"))
    return False


def _objective(where: str, table: dict[str, Any], columns: dict[str, str], checker: _Checker) -> Objective | None:
    if ("column" in table) == ("columns" in table):
        if "column" in table:
            checker.add(f"{where}.columns", "an objective has both `column` and `columns`", "keep one of them")
        else:
            checker.add(where, "`column` is missing", 'name a column of the results: column = "tts_s"')
        return None
    key = "column" if "column" in table else "columns"
    names = [table["column"]] if key == "column" else table["columns"]
    for name in names:
        if not isinstance(name, str):
            message = f"`columns` contains {_describe(name)}, but must contain column names"
            checker.add(f"{where}.columns", message, 'write columns = ["peak_f21_n", "peak_f22_n"]')
            return None
        if not _find_column(name, columns, f"{where}.{key}", checker):
            return None
        if columns[name] != "number":
            message = f"`{name}` is not numeric, so it cannot be an objective"
            help = "use it as a constraint: [[constraints]] with column and equals or at_least"
            checker.add(f"{where}.{key}", message, help)
            return None
    default = names[0] if len(names) == 1 else f"{table['of']}_{'_'.join(names)}"
    return Objective(table.get("name", default), names, table["of"], table["goal"], table["over"])


def _constraint(where: str, table: dict[str, Any], columns: dict[str, str], checker: _Checker) -> Constraint | None:
    if (column := table.get("column")) is None:
        checker.add(where, "`column` is missing", 'name a column of the results: column = "class"')
        return None
    if not _find_column(column, columns, f"{where}.column", checker):
        return None
    kind = columns[column]
    allowed, help = {
        "number": (["at_least", "at_most"], "give a bound: at_least = .. or at_most = .."),
        "flag": (["equals"], "give the required value: equals = true"),
        "text": (["equals"], 'give the required value: equals = ".."'),
    }[kind]
    if column == "class":
        allowed, help = ["at_least", "equals"], 'give the worst class allowed: at_least = "semi-stable"'
    given = [key for key in ("at_least", "at_most", "equals") if key in table]
    for key in given:
        if key not in allowed:
            checker.add(f"{where}.{key}", f"`{key}` has no effect on the column `{column}`", help)
            return None
    if not given:
        checker.add(where, f"the constraint on `{column}` has no limit", help)
        return None
    if kind == "number":
        # A number is in the unit of the column.
        bounds = {
            key: _si(checker, f"{where}.{key}", column, table[key])
            if isinstance(table[key], str | bool)
            else float(table[key])
            for key in given
        }
        if None in bounds.values():
            return None
        least, most = bounds.get("at_least"), bounds.get("at_most")
        if least is not None and most is not None and least > most:
            message = f"no value is at least {least:g} and at most {most:g}"
            checker.add(f"{where}.at_most", message, "swap the bounds, or give other bounds")
            return None
        return Constraint(column, at_least=least, at_most=most)
    key, value = given[0], table[given[0]]
    if kind == "flag" and not isinstance(value, bool):
        message = f"`{key}` is {_describe(value)}, but `{column}` contains true or false"
        checker.add(f"{where}.{key}", message, "write true or false, without quotes")
        return None
    if kind == "text" and not isinstance(value, str):
        message = f"`{key}` is {_describe(value)}, but `{column}` contains text"
        checker.add(f"{where}.{key}", message, "write the value as in the results, in quotes")
        return None
    if column == "class" and value not in CLASSES:
        checker.add(
            f"{where}.{key}", f'there is no class "{value}"', _suggest(str(value), CLASSES, "classes, from good to bad")
        )
        return None
    if key == "at_least":
        return Constraint(column, worst_class=CLASSES.index(str(value)))
    return Constraint(column, equals=value)


def _method(table: dict[str, Any], objectives: int, variables: int, checker: _Checker) -> Method:
    algorithm = table.get("algorithm", "cma-es" if objectives == 1 else "nsga2")
    if algorithm == "cma-es" and objectives > 1:
        message = f'"cma-es" supports one objective, but the file has {objectives}'
        checker.add("method.algorithm", message, 'use algorithm = "nsga2", or keep one objective')
    population, generations = (64, 50) if algorithm == "nsga2" else (4 + int(3 * math.log(max(variables, 1))), 100)
    population = table.get("population", population)
    if population < 4:
        message = f"`method.population` is {population}, but a generation has at least 4 designs"
        checker.add("method.population", message, "use 4 or more; about ten times the number of variables is usual")
    generations = table.get("generations", generations)
    if generations < 1:
        checker.add("method.generations", f"`method.generations` is {generations}", "use 1 or more")
    return Method(algorithm, population, generations, table["seed"])


def _report_duplicates(
    variables: list[Variable], objectives: list[Objective], constraints: list[Constraint], checker: _Checker
) -> None:
    """Reports columns of the results with equal names."""
    taken = {"design", "generation", "completed", "filtered", "refused", "failed", "violation", "feasible", "front"}
    taken |= {variable.column for variable in variables} | {f"worst_{constraint.column}" for constraint in constraints}
    for index, objective in enumerate(objectives):
        if objective.name in taken:
            message = f"the results would have two columns `{objective.name}`"
            checker.add(f"objectives[{index}]", message, "give the objective another name: name = ..")
        taken.add(objective.name)
    for index, constraint in enumerate(constraints):
        if any(constraint.column == other.column for other in constraints[:index]):
            message = f"there are two constraints on `{constraint.column}`"
            checker.add(f"constraints[{index}].column", message, "combine them in one constraint")
