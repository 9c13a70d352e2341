"""What a conversion could not carry over, what it changed, and what in the model is suspicious."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass, field
from typing import Literal

_HEADINGS: dict[Literal["lost", "changed", "warning"], str] = {
    "lost": "Not carried over",
    "changed": "Carried over with a change",
    "warning": "Suspicious in the model",
}
_WIDTH = 120


@dataclass(frozen=True)
class Note:
    """An item of the report."""

    kind: Literal["lost", "changed", "warning"]
    """ "lost": not in the scene; "changed": in the scene, but different; "warning": suspicious in the model."""
    name: str
    """The element of the model, such as "tendon split"."""
    text: str
    """What is missing or different, and its effect."""

    def __str__(self) -> str:
        return f"{self.name}: {self.text}"


@dataclass
class Report:
    """All items of a conversion, in the order in which they were found."""

    notes: list[Note] = field(default_factory=list)

    def add(self, kind: Literal["lost", "changed", "warning"], name: str, text: str) -> None:
        """Adds an item; an item that is already in the report is not repeated."""
        note = Note(kind, name, text)
        if note not in self.notes:
            self.notes.append(note)

    def lost(self, name: str, text: str) -> None:
        """Adds an element that the scene does not have."""
        self.add("lost", name, text)

    def changed(self, name: str, text: str) -> None:
        """Adds an element that the scene has in another form."""
        self.add("changed", name, text)

    def warn(self, name: str, text: str) -> None:
        """Adds an element that is suspicious in the model itself."""
        self.add("warning", name, text)

    def of(self, kind: Literal["lost", "changed", "warning"]) -> list[Note]:
        """Items of a kind."""
        return [note for note in self.notes if note.kind == kind]

    def lines(self, width: int = _WIDTH) -> list[str]:
        """The report as lines of text, without empty sections."""
        found = []
        for kind, heading in _HEADINGS.items():
            notes = self.of(kind)
            if notes:
                found.append(f"{heading}:")
                for note in _joined(notes):
                    found += textwrap.wrap(str(note), width, initial_indent="  ", subsequent_indent="    ", break_long_words=False)
        return found


def _joined(notes: list[Note]) -> list[Note]:
    """Notes with the same text as one."""
    names: dict[str, list[str]] = {}
    for note in notes:
        names.setdefault(note.text, []).append(note.name)
    return [Note(notes[0].kind, ", ".join(_short(owners)), text) for text, owners in names.items()]


def _short(names: list[str]) -> list[str]:
    """Names with their kind only at the first: "joint a", "b"."""
    kind = names[0].rpartition(" ")[0] + " "
    return names[:1] + [name.removeprefix(kind) for name in names[1:]]
