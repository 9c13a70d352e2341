"""Exceptions of the package. Their messages are those of the command line, with arguments in place of flags."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, TypedDict

if TYPE_CHECKING:
    from ._phalanx import Result

__all__ = ["ConversionError", "PhalanxError", "Problem", "RunError", "SceneError", "StudyError"]


# Not within a word or a path.
_FLAG = r"(?<![\w/.-])--"
_KEYWORDS = "analytic|engine|engineering|reference|geometric"


def _fields(match: re.Match[str]) -> str:
    fields = re.findall(r'--set ([\w.\[\]]+)=(?:"([^"]*)"|([^\s";,]+))', match[0])
    return "with_({" + ", ".join(f'"{field}": "{text or word}"' for field, text, word in fields) + "})"


def _list(match: re.Match[str]) -> str:
    return f"{match[1]}=[" + ", ".join(f'"{item}"' for item in match[2].split(",")) + "]"


def _argument(flag: str) -> str:
    name = flag.replace("-", "_")
    return "from_" if name == "from" else name


_REPLACEMENTS: tuple[tuple[str, Any], ...] = (
    (r"`phalanx sweep STUDY --shard K/N --out SHARD\.parquet`", "`phalanx.sweep_shard(STUDY, K, N, SHARD)`"),
    (r"`phalanx sweep merge`", "`phalanx.sweep_merge`"),
    # Messages of the search name both.
    (_FLAG + r"[a-z-]+ \((\w+=True)\)", r"\1"),
    (r", delete it, or replace it with --force", " or delete it"),
    (r"replace it with --force", "delete it first"),
    (r"leave the flag out", "leave it out"),
    (r'--set [\w.\[\]]+=(?:"[^"]*"|[^\s";,]+)(?:\s+--set [\w.\[\]]+=(?:"[^"]*"|[^\s";,]+))*', _fields),
    (_FLAG + r"set\b", "with_"),
    (_FLAG + r"shard (\S+)/(\S+)", r"part \1/\2"),
    (_FLAG + r"(along|vibration) (\w+(?:,\w+)+)", _list),
    (_FLAG + rf'([a-z][a-z-]*) (?:"([^"]*)"|({_KEYWORDS})\b)', lambda m: f'{_argument(m[1])}="{m[2] or m[3]}"'),
    (_FLAG + r"(check|force|ladder|move|quick|restart)\b", r"\1=True"),
    (r"`--([a-z][a-z-]*)`|" + _FLAG + r"([a-z][a-z-]*)", lambda m: f"`{_argument(m[1] or m[2])}`"),
)


def _in_python(message: str) -> str:
    """Replaces the flags of the command line in a message by the arguments of the functions."""
    if "--" in message:
        for pattern, replacement in _REPLACEMENTS:
            message = re.sub(pattern, replacement, message)
    return message


def _document_in_python(value: Any) -> Any:
    """Replaces the flags in all texts of a JSON document, such as the reason for which a run ended."""
    if isinstance(value, dict):
        return {key: _document_in_python(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_document_in_python(item) for item in value]
    return _in_python(value) if isinstance(value, str) else value


class Problem(TypedDict):
    """An error in a scene or a study, with its position."""

    file: str
    line: int | None
    """Line number, from 1; None if an entry is missing."""
    column: int | None
    """Column in characters, from 1; None if an entry is missing."""
    field: str | None
    """Path of the field, such as "contact.friction.mu_static"; None if the error does not concern a field."""
    message: str
    help: str
    """Allowed values, or a remedy."""


def _translated(problem: Problem) -> Problem:
    translated = problem.copy()
    translated["message"], translated["help"] = _in_python(problem["message"]), _in_python(problem["help"])
    return translated


class PhalanxError(Exception):
    """Base class of all exceptions of phalanx."""

    def __init__(self, message: str) -> None:
        super().__init__(_in_python(message))
        self._command_message = message


class _LocatedError(PhalanxError, ValueError):
    """An error with a list of problems; its own attributes are those of the first problem."""

    def __init__(self, message: str, problems: list[Problem] | None = None) -> None:
        super().__init__(message)
        self.problems: list[Problem] = [_translated(problem) for problem in problems or []]
        first: Any = self.problems[0] if self.problems else {}
        self.file: str | None = first.get("file")
        """Name of the file with the error; "with_" for a field that was set by `with_`."""
        self.line: int | None = first.get("line")
        """From 1."""
        self.column: int | None = first.get("column")
        """Column in characters, from 1; None if an entry is missing."""
        self.field: str | None = first.get("field")
        """Such as "contact.friction.mu_static"."""
        self.help: str | None = first.get("help")
        """Allowed values, or a remedy."""

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (self.args[0], self.problems))


class SceneError(_LocatedError):
    """Error for an invalid scene or argument; also a ValueError."""


class StudyError(_LocatedError):
    """Error for an invalid study, for invalid fields, rows or result files of a study, or for incomplete parts; also
    a ValueError.
    """


class ConversionError(PhalanxError, ValueError):
    """Error for a model of MuJoCo that cannot be converted into a scene; also a ValueError."""


class RunError(PhalanxError, RuntimeError):
    """Error for a run or a simulation that was not completed, or for a log that cannot be read or written; also a
    RuntimeError.
    """

    def __init__(self, message: str, result: Result | None = None, time_s: float | None = None) -> None:
        super().__init__(message)
        self.result = result
        """The run up to the error; None if the error concerns no run."""
        self.time_s = time_s
        """Time beyond which a `Simulation` cannot advance, s; None for other errors."""

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (self.args[0], self.result, self.time_s))
