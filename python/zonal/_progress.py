"""Progress and timings of long calls: a function, a bar of tqdm or rich, or the phases of the calls."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
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
            self._bar = self._make(total=total or None, desc=stage, leave=False)
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
            self._task = self._progress.add_task(stage, total=total or None)
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


@dataclass(frozen=True)
class Phase:
    """Times of a phase of a call."""

    name: str
    """Name of the stage; ``other`` is the time outside all stages."""
    count: int
    """How often it began."""
    wall: float
    """Wall time, s."""
    processor: float | None
    """Processor time of all threads of the process, s; ``None`` where the system does not tell."""

    @property
    def threads(self) -> float | None:
        """Threads at work: processor time over wall time. About 1 in a serial phase."""
        return None if self.processor is None or self.wall == 0 else self.processor / self.wall


class Timings:
    """Where the time of long calls goes, by phase: give it as ``progress`` of a call.

    Phases add up to the wall time of the call. A stage inside another is a phase of its own.

    Parameters
    ----------
    progress : callable or bool, optional
        Progress that is shown as well.

    Examples
    --------
    >>> import zonal as zn
    >>> scene = zn.Scene()
    >>> scene.surface(room=([0, 0, 0], [1, 1, 1]), name="walls", reflectance=0.5, emission=1)
    >>> timings = zn.Timings()
    >>> solution = scene.solve(progress=timings)
    >>> [phase.name for phase in timings.phases][0], timings.wall > 0
    ('zones', True)
    """

    phases: tuple[Phase, ...] = ()
    """The phases of the last call, in the order in which they began."""

    def __init__(self, progress: Progress = None) -> None:
        self._progress = progress
        self._function: ProgressFunction | None = None
        self._shown = ExitStack()

    def __enter__(self) -> Timings:
        self._function = self._shown.enter_context(observed(self._progress))
        return self

    def __exit__(self, *exception: object) -> None:
        self._function = None
        self._shown.close()

    def __call__(self, stage: str, done: int, total: int) -> None:
        if self._function is not None:
            self._function(stage, done, total)

    def _record(self, rows: list[tuple[str, int, float, float | None]]) -> None:
        self.phases = tuple(Phase(*row) for row in rows)

    @property
    def wall(self) -> float:
        """Wall time of the call, s."""
        return sum(phase.wall for phase in self.phases)

    @property
    def processor(self) -> float | None:
        """Processor time of the call, s; ``None`` where the system does not tell."""
        times = [phase.processor for phase in self.phases if phase.processor is not None]
        return sum(times) if len(times) == len(self.phases) else None

    def __str__(self) -> str:
        rows = [*self.phases, Phase("total", 1, self.wall, self.processor)]
        lines = [f"{'timings':<40}{'wall, s':>9}{'processor, s':>14}{'threads':>10}"]
        for row in rows:
            name = f"{row.name} ({row.count} times)" if row.count > 1 else row.name
            processor = "unknown" if row.processor is None else f"{row.processor:.3f}"
            threads = "unknown" if row.threads is None else f"{row.threads:.2f}"
            lines.append(f"  {name:<38}{row.wall:>9.3f}{processor:>14}{threads:>10}")
        return "\n".join(lines)


@contextmanager
def observed(progress: Progress) -> Generator[ProgressFunction | None]:
    """The function that a native call reports to."""
    if isinstance(progress, Timings):
        with progress:
            yield progress
    elif callable(progress):
        yield progress
    elif progress:
        bar = _bar()
        try:
            yield bar
        finally:
            bar.close()
    else:
        yield None
