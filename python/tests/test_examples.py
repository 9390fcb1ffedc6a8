"""The examples of docs/reference/python.md run as they stand."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).resolve().parents[1] / "examples").glob("*.py"))


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda script: script.stem)
def test_example_runs_and_is_in_the_docs(script: Path, root: Path, tmp_path: Path) -> None:
    assert script.name in (root / "docs" / "reference" / "python.md").read_text()
    if "stable_baselines3" in script.read_text():
        pytest.importorskip("stable_baselines3")
    done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()
