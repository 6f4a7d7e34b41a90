"""Exceptions of the package."""

from __future__ import annotations

__all__ = ["Error", "FileError", "InputError", "Interrupted", "MemoryLimitError"]


class Error(Exception):
    """An error of zonal: one line that states the defect and, after a semicolon, the remedy.

    Attributes
    ----------
    file : str or None
        The file at fault.
    place : str or None
        The place in it: ``line:column`` of a scene file, a row, an entry; for scenes in memory the key.
    key : str or None
        The key of the faulty value, such as ``medium.cells`` or ``surface 'wall'.emissivity``.

    Examples
    --------
    >>> import zonal as zn
    >>> scene = zn.Scene()
    >>> scene.surface(room=([0, 0, 0], [1, 1, 1]), reflectance=2.0)
    >>> try:
    ...     scene.check()
    ... except zn.Error as error:
    ...     print(error.key, "->", error.remedy)
    surface 'surface1'.reflectance -> give a value from 0 to 1
    """

    file: str | None
    place: str | None
    key: str | None

    def __init__(
        self, message: str, file: str | None = None, place: str | None = None, key: str | None = None
    ) -> None:
        super().__init__(message, file, place, key)
        self.file = file
        self.place = place
        self.key = key

    def __str__(self) -> str:
        return self.message

    @property
    def message(self) -> str:
        """The whole message: file, place, defect and remedy."""
        return str(self.args[0])

    @property
    def remedy(self) -> str | None:
        """What to do: the part of the message after its first semicolon."""
        _, semicolon, remedy = self.message.partition("; ")
        return remedy if semicolon else None


class InputError(Error, ValueError):
    """A scene, an array or an argument is not valid."""


class FileError(Error, OSError):
    """A solution, a table or a picture cannot be read or written."""

    def __init__(
        self, message: str, file: str | None = None, place: str | None = None, key: str | None = None
    ) -> None:
        Error.__init__(self, message, file, place, key)


class MemoryLimitError(Error, MemoryError):
    """A solve would exceed its memory limit."""


class Interrupted(Error):
    """A computation was interrupted by its observer."""
