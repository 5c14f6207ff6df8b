"""Options of a call: progress and number of threads."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple, Union

from . import _core
from ._options import whole

if TYPE_CHECKING:
    from collections.abc import Iterator

#: ``True`` for a bar, or a function that is called with the completed share, from 0 to 1.
Progress = Union[bool, Callable[[float], object], None]


class State(NamedTuple):
    """The state of a run, as passed to a ``callback``.

    Attributes
    ----------
    phase : str
        The current phase: ``"collapse"``, ``"fit"``, ``"greedy"``, ...
    fraction : float
        The completed share, from 0 to 1, as far as it is known.
    faces : int or None
        Number of remaining faces, if they change.
    steps : int
        Collapses, flips or patches so far.
    cost : float or None
        The cost so far, if there is one.
    """

    phase: str
    fraction: float
    faces: int | None
    steps: int
    cost: float | None


Callback = Callable[[State], object]


class _Bar:
    """A bar of tqdm, or a line of text without tqdm."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.done = 0.0
        try:
            from tqdm.auto import tqdm

            self.bar = tqdm(total=1.0, desc=name, bar_format="{desc}: {percentage:3.0f}%|{bar}| {elapsed}")
        except ImportError:
            self.bar = None

    def tell(self, fraction: float) -> None:
        step = max(fraction - self.done, 0.0)
        self.done += step
        if self.bar is not None:
            self.bar.update(step)
        else:
            import sys

            print(f"\r{self.name}: {100 * self.done:3.0f} %", end="", file=sys.stderr, flush=True)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.close()
        else:
            import sys

            print(file=sys.stderr)


@contextmanager
def calling(
    name: str,
    progress: Progress = None,
    threads: int | None = None,
    callback: Callback | None = None,
    keep_partial: bool = False,
) -> Iterator[_core.Call]:
    """The call of the compiled part, with a bar that is closed at the end."""
    tell = None
    if callback is not None:
        given = callback

        def tell(
            phase: str, fraction: float, faces: int | None, steps: int, cost: float | None
        ) -> object:
            return given(State(phase, fraction, faces, steps, cost))

    if progress is True:
        bar = _Bar(name)
        try:
            yield _core.Call(bar.tell, tell, threads, keep_partial)
        finally:
            bar.close()
    else:
        yield _core.Call(progress or None, tell, threads, keep_partial)


def plain(threads: int | None = None) -> _core.Call:
    """A call without progress."""
    return _core.Call(None, None, None if threads is None else whole("threads", threads), False)
