"""What can go wrong. Messages are those of the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypedDict

if TYPE_CHECKING:
    from ._phalanx import Result

__all__ = ["PhalanxError", "Problem", "RunError", "SceneError", "StudyError"]


class Problem(TypedDict):
    """One thing that is wrong with a scene or a study, and where."""

    file: str
    line: int | None
    """From 1; None where something is missing altogether."""
    column: int | None
    """Characters, from 1."""
    field: str | None
    """Such as "contact.friction.mu_static"; None where there is none."""
    message: str
    help: str
    """What is allowed, or what to do."""


class PhalanxError(Exception):
    """Base of everything that phalanx raises."""


class _Placed(PhalanxError):
    """What is wrong has a place: that of the first problem, and all of them in `problems`."""

    def __init__(self, message: str, problems: list[Problem] | None = None) -> None:
        super().__init__(message)
        self.problems: list[Problem] = problems or []
        first: Any = self.problems[0] if self.problems else {}
        self.file: str | None = first.get("file")
        """What the text is called that is wrong; "with_" for a field that was set by it."""
        self.line: int | None = first.get("line")
        """From 1."""
        self.column: int | None = first.get("column")
        """Characters, from 1."""
        self.field: str | None = first.get("field")
        """Such as "contact.friction.mu_static"."""
        self.help: str | None = first.get("help")
        """What is allowed, or what to do."""

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (self.args[0], self.problems))


class SceneError(_Placed):
    """A scene, or an argument about one, is wrong."""


class StudyError(_Placed):
    """A study, its fields and rows, or the place of its results is wrong; parts do not make up a study."""


class RunError(PhalanxError):
    """A run did not get to its end, or a log cannot be read or written."""

    def __init__(self, message: str, result: Result | None = None) -> None:
        super().__init__(message)
        self.result = result
        """The run up to there, if there is any of it."""

    def __reduce__(self) -> tuple[Any, ...]:
        # A result stays where it is.
        return (type(self), (self.args[0],))
