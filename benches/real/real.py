"""`make real`: calibrates models of four published robots with `spinebench` and publishes models, results and figures.

Usage: python3 benches/real/real.py DATA PROGRAM   (from the root of the repository)
       python3 benches/real/real.py --check DATA
       python3 benches/real/real.py --convert DATA OUT    writes the recordings and the models to start from, for the league

DATA holds the measured files (sources.py says which). Recordings and reports are written to target/real; what is published,
models/real, results/real and plots/real, is written at the end, when every robot has succeeded. Needs nothing but Python 3.
"""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import convert
import sources
import tables
from robots import ROBOTS

WORK = Path("target/real")
#: Parts of a report that are published. residuals.csv holds measured positions and stays out.
TABLES = ("calibration.json", "numbers.csv", "residual_groups.csv", "stages.csv", "trade_offs.csv")
#: Weights at the tip of the trunk, of which recordings are published.
WEIGHTS_G = (100, 200, 300, 400)


def run(program, *arguments):
    """Runs a command of spinebench and returns what it prints."""
    words = [str(word) for word in (program, *arguments)]
    print("spinebench", *words[1:], flush=True)
    done = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(done.returncode)
    return done.stdout


def command(robot, data):
    """Arguments of the calibration of a robot."""
    files = ["--model", WORK / f"{robot.name}_start.yaml", "--measured", WORK / f"{robot.name}.csv"]
    return ["calibrate", *files, *robot.options(data), "--out", WORK / f"{robot.name}.yaml", "--report", WORK / robot.name]


def calibrate(robot, data, program):
    """Recording, calibration and simulation of a robot, into WORK."""
    robot.prepare(data, WORK)
    said = run(program, *command(robot, data))
    (WORK / f"{robot.name}.txt").write_text(said, encoding="utf-8")
    simulated = WORK / f"{robot.name}_simulated.csv"
    rows = ["--commands", WORK / f"{robot.name}.csv", "--out", simulated]
    run(program, "simulate", "--static", "--model", WORK / f"{robot.name}.yaml", *rows)


def header(robot, data):
    """Comment above a calibrated model."""
    source = sources.SOURCES[robot.name]
    words = " ".join(f"'{word}'" if set("*,~[") & set(str(word)) else str(word) for word in command(robot, data))
    return (
        f"# {robot.title}, calibrated by `make real` (docs/evidence/real_robots.md) from a recording that others published:\n"
        f"# {source.words()}.\n"
        f"# spinebench {words}\n"
        "# The recording and the model to start from are made by benches/real.\n"
    )


def weigh(data, program):
    """What `discover` tells of weights at the tip of the trunk, beside its run without one. Without patterns tenths of a run
    count as its trials."""

    def recorded(mass_g):
        measured, target = Path(data) / f"trunk/{mass_g}g.csv", WORK / f"trunk_{mass_g}g.csv"
        if measured.is_file():
            convert.trunk([measured], target, halves=False)
        return target if measured.is_file() else None

    baseline, rows = recorded(0), []
    for mass_g in WEIGHTS_G:
        measured = recorded(mass_g)
        if measured is None:
            continue
        out = WORK / f"trunk_{mass_g}g"
        files = ["--model", WORK / "trunk_start.yaml", "--measured", measured, "--baseline", baseline]
        run(program, "discover", "--static", *files, "--out", out)
        rows.append(tables.weight_row(mass_g, json.loads((out / "findings.json").read_text(encoding="utf-8"))))
    return rows


def errors(robot, found):
    """Errors of the positions that were held out, or of all that were fitted where the error is cross-validated."""
    names = set(found["held_out"]["names"])
    if not names:
        return tables.fitted_errors(tables.read(WORK / robot.name / "residuals.csv"))
    measured = tables.read(WORK / f"{robot.name}.csv")
    simulated = tables.read(WORK / f"{robot.name}_simulated.csv")
    return tables.errors(measured, simulated, names.__contains__)


def publish(robot, data):
    """Model, tables and figures of a robot; its row of the summary."""
    found = tables.findings(WORK / robot.name)
    model = header(robot, data) + (WORK / f"{robot.name}.yaml").read_text(encoding="utf-8")
    Path(f"models/real/{robot.name}.yaml").write_text(model, encoding="utf-8")
    results = Path("results/real") / robot.name
    shutil.rmtree(results, ignore_errors=True)
    results.mkdir(parents=True)
    for name in TABLES:
        if (WORK / robot.name / name).is_file():
            shutil.copyfile(WORK / robot.name / name, results / name)
    where = tables.groups(errors(robot, found))
    tables.write_csv(results / "where.csv", where)
    (results / "where.md").write_text(tables.where_page(where), encoding="utf-8")
    (results / "held_out.md").write_text(tables.points_page(found), encoding="utf-8")
    numbers = tables.numbers_page(tables.read(results / "numbers.csv"))
    (results / "numbers.md").write_text(numbers, encoding="utf-8")
    for figure in ("errors", "map"):
        for end in (".png", ".svg", "_column.svg", ".md"):
            shutil.copyfile(WORK / robot.name / f"{figure}{end}", f"plots/real/{robot.name}_{figure}{end}")
    return tables.summary_row(robot, found)


def main():
    """All robots."""
    if sys.argv[1:2] == ["--check"]:
        sources.check(sys.argv[2])
        return
    if sys.argv[1:2] == ["--convert"]:
        data, out = sys.argv[2:4]
        sources.check(data)
        Path(out).mkdir(parents=True, exist_ok=True)
        for robot in ROBOTS:
            # Rows that a publisher keeps apart are not among those of the league.
            robot.prepare(data, out, with_kept_apart=False)
        return
    data, program = sys.argv[1:3]
    sources.check(data)
    WORK.mkdir(parents=True, exist_ok=True)
    for robot in ROBOTS:
        calibrate(robot, data, program)
    weights = weigh(data, program)
    for folder in ("models/real", "results/real", "plots/real"):
        Path(folder).mkdir(parents=True, exist_ok=True)
    rows = [publish(robot, data) for robot in ROBOTS]
    tables.write_csv(Path("results/real/trunk/weights.csv"), weights)
    Path("results/real/trunk/weights.md").write_text(tables.weights_page(weights), encoding="utf-8")
    tables.write_csv(Path("results/real/summary.csv"), rows)
    page = tables.summary_page(rows)
    Path("results/real/summary.md").write_text(page, encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
