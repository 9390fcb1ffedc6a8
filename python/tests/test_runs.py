"""Runs: planned, followed, compared."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from test_policies import own

import spinebench as sb

SPEC = (
    "name: tiny\ncontrol_hz: 5\nexplore: {points: 100}\n"
    "plant: {constant_curvature: {}}\nmodel: {constant_curvature: {}}\n"
    "training: {paper: {}}\nruns: {gap: {rows: 20}}\n"
)


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    file = tmp_path / "tiny.yaml"
    file.write_text(SPEC)
    return file


def test_a_plan_is_what_the_run_does(spec: Path, root: Path, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    before = sb.plan(spec, cache=cache)
    assert not before.runs.stored.any() and before.stages.stored.sum() == 0
    result = sb.run(spec, out=tmp_path / "out", cache=cache)
    assert result.computed == before.stages.left.sum()
    after = sb.plan(spec, cache=cache)
    assert after.runs.stored.all() and after.stages.left.sum() == 0
    assert len(sb.plan(spec, cache=cache, seeds=2).runs) == 2 * len(after.runs)
    assert not (tmp_path / "out2").exists() and "stored" in after._repr_html_()
    program = root / "target" / "release" / "spinebench"
    if program.is_file():
        said = subprocess.run([program, "plan", spec, "--cache", cache], capture_output=True, text=True, check=True)
        runs = [line.split(maxsplit=1)[1] for line in said.stdout.splitlines() if line.startswith(("  left ", "  stored "))]
        assert sorted(runs) == sorted(after.runs.run)


def test_plans_refuse_what_runs_refuse(spec: Path) -> None:
    with pytest.raises(sb.InputError, match="specs"):
        sb.plan()
    with pytest.raises(sb.InputError, match="gp.strats"):
        sb.plan(spec, set={"gp.strats": 3})


def test_runs_are_compared_value_by_value(spec: Path, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    one = sb.run(spec, out=tmp_path / "one", cache=cache)
    again = sb.run(spec, out=tmp_path / "again", cache=tmp_path / "other_cache")
    same = sb.compare(one, again)
    assert same.equal and same.tables > 1 and same.first_stage is None, same.differences
    assert sb.compare(tmp_path / "one", tmp_path / "again").equal
    assert "no difference" in repr(same)
    other = sb.run(spec, out=tmp_path / "other", cache=cache, set={"seed": 7})
    found = sb.compare(one, other["tiny"])
    assert not found.equal and found.first_stage is not None
    gap = found.differences[found.differences.table == "gap"]
    assert len(gap) > 0 and {"row", "column", "first", "second", "difference"} <= set(gap.columns)
    row = gap.iloc[0]
    assert one["tiny"].table("gap").loc[row.row, row.column] == row["first"]
    assert other["tiny"].table("gap").loc[row.row, row.column] == row["second"]
    assert "<table" in found._repr_html_()
    with pytest.raises(sb.InputError, match="expected a folder that a run wrote to"):
        sb.compare(one, tmp_path / "nowhere")
    with pytest.raises(sb.InputError, match="tolerance"):
        sb.compare(one, again, tolerance=-1.0)


def test_a_comparison_finds_one_changed_number_and_what_is_missing(spec: Path, tmp_path: Path) -> None:
    one = sb.run(spec, out=tmp_path / "one", cache=tmp_path / "cache")
    two = sb.run(spec, out=tmp_path / "two", cache=tmp_path / "cache")
    file = two["tiny"].folder / "gap.csv"
    table = pd.read_csv(file)
    number = table.select_dtypes("float").columns[-1]
    table[number] = table[number] * np.where(table.index == 3, 1.0 + 1e-6, 1.0)
    table.drop(columns=table.columns[0]).to_csv(file, index=False)
    found = sb.compare(one, two).differences
    assert set(found.column) == {number, table.columns[0]}
    assert found[found.column == number].row.tolist() == [3]
    assert set(sb.compare(one, two, tolerance=1e-5).differences.column) == {table.columns[0]}
    file.unlink()
    (row,) = sb.compare(one, two).differences.itertuples()
    assert (row.table, row.first, row.second) == ("gap", "there", None)


def test_progress_counts_stages_to_the_end(spec: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("tqdm")
    result = sb.run(spec, out=tmp_path / "out", cache=tmp_path / "cache", progress=True)
    told = capsys.readouterr().err
    assert f"{result.computed}/{result.computed}" in told, told
    sb.run(spec, out=tmp_path / "out", cache=tmp_path / "cache2")
    assert capsys.readouterr().err == "", "no terminal, no bar"


def test_progress_without_tqdm_is_refused_where_it_is_asked_for(spec: Path, tmp_path: Path) -> None:
    script = (
        "import sys; sys.modules['tqdm'] = None; sys.modules['tqdm.auto'] = None\n"
        "import spinebench as sb\n"
        f"sb.run({str(spec)!r}, out={str(tmp_path / 'out')!r}, cache={str(tmp_path / 'cache')!r})\n"
        "try:\n"
        f"    sb.run({str(spec)!r}, progress=True)\n"
        "except sb.InputError as error:\n"
        "    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, env=os.environ)
    assert "pip install tqdm" in done.stdout


def test_results_of_runs_are_shown(spec: Path, tmp_path: Path) -> None:
    result = sb.run(spec, out=tmp_path / "out", cache=tmp_path / "cache")
    shown = [result, result["tiny"], sb.plan(spec, cache=tmp_path / "cache")]
    assert all("\n" not in repr(each) for each in shown)
    assert "tiny" in result._repr_html_() and "<table>" in result._repr_html_()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("Nobody", "found `Nobody`, which mine.py does not define, expected a class with a method act.., such as `Fine`"),
        ("Idle", "found `Idle`, which has no method act"),
        ("NUMBER", "found `NUMBER`, which has no method act"),
    ],
)
def test_a_class_is_checked_before_anything_runs(tmp_path: Path, name: str, words: str) -> None:
    (tmp_path / "mine.py").write_text(
        "class Fine:\n    def act(self, tip_m, target_m, pulls_m, time_s):\n        return pulls_m\n\n\n"
        "class Idle:\n    pass\n\n\nNUMBER = 3\n"
    )
    spec = tmp_path / "mine.yaml"
    spec.write_text(own(f"{{python: {{file: mine.py, class: {name}}}}}"))
    for call in (lambda: sb.run(spec, out=tmp_path / "out", cache=tmp_path / "cache"), lambda: sb.plan(spec)):
        with pytest.raises(sb.InputError, match=words) as error:
            call()
        assert error.value.file == str(spec) and error.value.line is not None
        assert error.value.key == "policies.outside.mine.python.class"
    assert not (tmp_path / "out").exists() and not (tmp_path / "cache").exists()


def test_a_file_that_cannot_be_imported_is_refused_before_anything_runs(tmp_path: Path) -> None:
    spec = tmp_path / "mine.yaml"
    spec.write_text(own("{python: {file: mine.py, class: Fine}}"))
    for text, words in (("import nothing_of_this_name\n", "nothing_of_this_name"), ("class Fine\n", "SyntaxError")):
        (tmp_path / "mine.py").write_text(text)
        with pytest.raises(sb.InputError, match=words):
            sb.run(spec, out=tmp_path / "out", cache=tmp_path / "cache")
    assert not (tmp_path / "out").exists()


def test_a_class_of_this_process_without_act_is_refused(spec: Path) -> None:
    class Idle:
        """Decides nothing."""

    with pytest.raises(sb.InputError, match="found the class Idle for 'mine', expected one with a method act"):
        sb.run(spec, policies={"mine": Idle})  # type: ignore[dict-item]
