"""Exceptions: one hierarchy."""

from __future__ import annotations


class SpinebenchError(Exception):
    """Base of all errors of this package."""


class InputError(SpinebenchError, ValueError):
    """Bad input. The message states in one sentence the place, what was found and what was expected."""

    file: str | None = None
    """File with the error, if any."""
    line: int | None = None
    """Line in it (from 1)."""
    key: str | None = None
    """Key of a model or spec, column of a recording, or argument of a call."""
    found: str | None = None
    """What was found."""
    expected: str | None = None
    """What was expected."""


class SolverError(SpinebenchError, ArithmeticError):
    """A robot could not be solved or moved."""

    status: str = ""
    """Named status: `not_converged`, `crushed`, `unstable`, `under_resolved`, …"""


class RunError(SpinebenchError, RuntimeError):
    """A computation ran and failed, or its results could not be written."""


class InternalError(SpinebenchError, RuntimeError):
    """An internal error of the program."""
