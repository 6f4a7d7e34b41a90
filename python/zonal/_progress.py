"""Progress of long calls: a function, or a bar of tqdm or rich."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any, TypeAlias

ProgressFunction: TypeAlias = Callable[[str, int, int], object]
"""A function of the stage, the steps done and their number; an exception ends the call."""

Progress: TypeAlias = ProgressFunction | bool | None
"""A function; ``True`` for a bar by tqdm or rich, or lines on standard error without them; ``None`` or ``False`` for none."""


class _TqdmBar:
    def __init__(self, tqdm: Any) -> None:
        self._make = tqdm
        self._bar: Any = None
        self._stage = ("", 0)

    def __call__(self, stage: str, done: int, total: int) -> None:
        if (stage, total) != self._stage:
            self.close()
            self._bar = self._make(total=total, desc=stage, leave=False)
            self._stage = (stage, total)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None


class _RichBar:
    def __init__(self, progress: Any) -> None:
        self._progress = progress(transient=True)
        self._progress.start()
        self._task: Any = None
        self._stage = ("", 0)

    def __call__(self, stage: str, done: int, total: int) -> None:
        if (stage, total) != self._stage:
            if self._task is not None:
                self._progress.remove_task(self._task)
            self._task = self._progress.add_task(stage, total=total)
            self._stage = (stage, total)
        self._progress.update(self._task, completed=done)

    def close(self) -> None:
        self._progress.stop()


class _Lines:
    """The name of each stage on a line of standard error."""

    def __init__(self) -> None:
        self._stage = ""

    def __call__(self, stage: str, done: int, total: int) -> None:
        if stage != self._stage:
            self._stage = stage
            print(f"zonal: {stage}", file=sys.stderr)

    def close(self) -> None:
        pass


def _bar() -> _TqdmBar | _RichBar | _Lines:
    for module, name, bar in (("tqdm.auto", "tqdm", _TqdmBar), ("rich.progress", "Progress", _RichBar)):
        try:
            found = getattr(importlib.import_module(module), name)
        except ImportError:
            continue
        return bar(found)
    return _Lines()


@contextmanager
def observed(progress: Progress) -> Generator[ProgressFunction | None]:
    """The function that a native call reports to."""
    if callable(progress):
        yield progress
    elif progress:
        bar = _bar()
        try:
            yield bar
        finally:
            bar.close()
    else:
        yield None
