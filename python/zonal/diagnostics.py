"""Notes and warnings of a solve."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, cast

__all__ = ["Diagnostic"]


@dataclass(frozen=True)
class Diagnostic:
    """A note or a warning; as a text, the line that the command prints.

    Examples
    --------
    >>> import zonal as zn
    >>> print(zn.Diagnostic("open-scene", "warning", "the enclosure is open", "wall"))
    warning: wall: the enclosure is open
    """

    code: str
    """Kind of the message, on which scripts may rely: ``open-scene``, ``heat-balance``, …"""
    severity: Literal["note", "warning"]
    """``note``: the stated numbers are valid. ``warning``: one may be wrong, an error is unknown or exceeds the tolerance, or an input has no effect."""
    text: str
    """The message and a remedy."""
    part: str | None = None
    """The subject: a surface, a file, a key of the scene; ``None`` for the whole scene."""

    def __str__(self) -> str:
        place = f"{self.part}: " if self.part else ""
        return f"{self.severity}: {place}{self.text}"


def of_rows(rows: Iterable[tuple[str, str, str, str]], severity: str) -> list[Diagnostic]:
    """The diagnostics of a severity among rows of severity, code, part and text."""
    named = cast('Literal["note", "warning"]', severity)
    return [Diagnostic(code, named, text, part or None) for found, code, part, text in rows if found == severity]
