"""Progress of long calls, by tqdm where it is installed."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ._errors import InputError


def _tqdm() -> Any | None:
    """tqdm for a notebook or a terminal."""
    try:
        return importlib.import_module("tqdm.auto").tqdm
    except ImportError:
        return None


def _is_watched() -> bool:
    """Whether a person looks on: in a notebook or a terminal."""
    return "ipykernel" in sys.modules or (sys.stderr is not None and sys.stderr.isatty())


class Bar:
    """A bar that appears with the first news."""

    def __init__(self, make: Any, what: str) -> None:
        self._make, self._what = make, what
        self._bar: Any = None

    def count(self, done: int, total: int) -> None:
        """So many stages of all are done."""
        if self._bar is None:
            self._bar = self._make(total=total, desc=self._what, unit="stage")
        self._bar.total, self._bar.n = total, done
        self._bar.refresh()

    def step(self, number: int, text: str) -> None:
        """A step begins; nobody knows how many there are."""
        if self._bar is None:
            self._bar = self._make(desc=self._what, unit="step", bar_format="{desc}: {postfix} [{elapsed}]")
        self._bar.n = number
        self._bar.set_postfix_str(text, refresh=True)

    def close(self) -> None:
        """Nothing more comes."""
        if self._bar is not None:
            self._bar.close()


@contextmanager
def shown(progress: bool | None, what: str) -> Iterator[Bar | None]:
    """A bar: with True, or with None where a person looks on and tqdm is installed."""
    make = None if progress is False or (progress is None and not _is_watched()) else _tqdm()
    if progress and make is None:
        raise InputError("progress: found no tqdm, expected tqdm to be installed (pip install tqdm)")
    if make is None:
        yield None
        return
    bar = Bar(make, what)
    try:
        yield bar
    finally:
        bar.close()
