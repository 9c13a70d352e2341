"""Exceptions of the package, with the messages of the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypedDict

if TYPE_CHECKING:
    from ._phalanx import Result

__all__ = ["PhalanxError", "Problem", "RunError", "SceneError", "StudyError"]


class Problem(TypedDict):
    """An error in a scene or a study, with its position."""

    file: str
    line: int | None
    """From 1; None for a missing entry."""
    column: int | None
    """Characters, from 1."""
    field: str | None
    """Such as "contact.friction.mu_static"; None if the error concerns no field."""
    message: str
    help: str
    """Allowed values, or a remedy."""


class PhalanxError(Exception):
    """Base class of all exceptions of phalanx."""


class _LocatedError(PhalanxError):
    """An error with a list of problems; its own attributes are those of the first problem."""

    def __init__(self, message: str, problems: list[Problem] | None = None) -> None:
        super().__init__(message)
        self.problems: list[Problem] = problems or []
        first: Any = self.problems[0] if self.problems else {}
        self.file: str | None = first.get("file")
        """Name of the file with the error; "with_" for a field that was set by `with_`."""
        self.line: int | None = first.get("line")
        """From 1."""
        self.column: int | None = first.get("column")
        """Characters, from 1."""
        self.field: str | None = first.get("field")
        """Such as "contact.friction.mu_static"."""
        self.help: str | None = first.get("help")
        """Allowed values, or a remedy."""

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (self.args[0], self.problems))


class SceneError(_LocatedError):
    """A scene or an argument is invalid."""


class StudyError(_LocatedError):
    """A study, its fields, rows or result files are invalid, or its parts are incomplete."""


class RunError(PhalanxError):
    """A run or a simulation was not completed, or a log cannot be read or written."""

    def __init__(self, message: str, result: Result | None = None, time_s: float | None = None) -> None:
        super().__init__(message)
        self.result = result
        """The run up to the error; None if the error concerns no run."""
        self.time_s = time_s
        """Time beyond which a `Simulation` cannot advance, s; None for other errors."""

    def __reduce__(self) -> tuple[Any, ...]:
        # A result cannot be pickled.
        return (type(self), (self.args[0], None, self.time_s))
