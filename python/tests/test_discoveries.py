"""Answers of discover: saved as the program saves them, pickled, shown."""

from __future__ import annotations

import copy
import pickle
import subprocess
from pathlib import Path

import pandas as pd
import pytest
from test_calculations import commands

import spinebench as sb

COLUMNS = ["trial", "time_s", *[f"tendon_{i}_m" for i in range(1, 5)], "tip_x_m", "tip_y_m", "tip_z_m"]


@pytest.fixture(scope="module")
def measured(model: sb.Model) -> pd.DataFrame:
    real = model.with_effects([{"tip_load": {"mass_kg": 0.02}}])
    return sb.simulate(real, commands(), noise_m=3e-4)[COLUMNS]


@pytest.fixture(scope="module")
def answer(model: sb.Model, measured: pd.DataFrame) -> sb.Discovery:
    return sb.discover(model, measured)


def contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def test_it_is_saved_byte_for_byte_as_by_the_program(root: Path, tmp_path: Path, measured: pd.DataFrame) -> None:
    program = root / "target" / "release" / "spinebench"
    if not program.is_file():
        pytest.skip("the program is not built")
    # A model with comments keeps them; two recordings are renumbered.
    model = tmp_path / "model.yaml"
    model.write_text("# ours\n" + (root / "models" / "nominal.yaml").read_text() + "\n# to the end\n")
    parts = [tmp_path / "first.csv", tmp_path / "second.csv"]
    measured[measured.trial < 3].to_csv(parts[0], index=False)
    measured[measured.trial >= 3].assign(trial=lambda part: part.trial - 3).to_csv(parts[1], index=False)
    places = ["--model", str(model), "--measured", *map(str, parts), "--out", str(tmp_path / "program")]
    subprocess.run([str(program), "discover", "--quiet", *places], check=True)
    answer = sb.discover(model, parts)
    answer.save(tmp_path / "package")
    wanted, found = contents(tmp_path / "program"), contents(tmp_path / "package")
    assert sorted(found) == sorted(wanted) and {"findings.json", "model.yaml", "report.html"} <= set(found)
    assert [name for name in wanted if wanted[name] != found[name]] == []
    assert "# ours" in found["model.yaml"].decode() and "tip_load" in found["model.yaml"].decode()
    assert any("first.csv" in one for one in answer.findings["limitations"])
    # Also after a pickle, and of a model that was sent along.
    sent = pickle.loads(pickle.dumps(sb.Model(model)))
    pickle.loads(pickle.dumps(sb.discover(sent, parts))).save(tmp_path / "sent")
    assert contents(tmp_path / "sent") == wanted


def test_a_model_without_a_file_is_saved_whole(answer: sb.Discovery, tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "findings.json").write_text('{"proposals": [{"file": "next_1_old.csv"}]}')
    (tmp_path / "there" / "next_1_old.csv").write_text("trial\n")
    answer.save(tmp_path / "there")
    assert sb.Model(tmp_path / "there" / "model.yaml").effect_names == answer.model.effect_names
    assert not (tmp_path / "there" / "next_1_old.csv").exists()
    (tmp_path / "file").write_text("")
    with pytest.raises(sb.InputError, match="file"):
        answer.save(tmp_path / "file" / "below")


def test_it_is_pickled_copied_and_hashed(answer: sb.Discovery) -> None:
    for again in (pickle.loads(pickle.dumps(answer)), copy.deepcopy(answer), copy.copy(answer)):
        assert again == answer and len({again, answer}) == 1 and again.model == answer.model
        pd.testing.assert_frame_equal(again.residuals, answer.residuals)
        assert again.files == answer.files
    assert answer != "an answer"


def test_it_is_shown(answer: sb.Discovery) -> None:
    assert "\n" not in repr(answer) and repr(answer).startswith(f"Discovery({answer.verdict}: ")
    page = answer._repr_html_()
    assert "tip_load" in page and "mass_kg" in page and "95 % interval" in page


def test_progress_tells_the_steps(model: sb.Model, measured: pd.DataFrame, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("tqdm")
    sb.discover(model, measured[measured.trial < 3], progress=True)
    told = capsys.readouterr().err
    assert "discover: " in told and "[00:" in told, told
