"""Fixtures of all tests."""

from __future__ import annotations

from pathlib import Path

import pytest

import spinebench

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def root() -> Path:
    """The repository."""
    return ROOT


@pytest.fixture(scope="session")
def model() -> spinebench.Model:
    """The paper's robot."""
    return spinebench.Model.load(ROOT / "models" / "nominal.yaml")
