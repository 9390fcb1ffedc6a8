"""Records a robot of MuJoCo with effects hidden in it, as recordings (CSV).

usage: record.py OUT_DIR [NAME ...]     records those of plan.json (all), and writes OUT_DIR/truth.csv of what is there
       record.py --plan PLAN.json ...   the same with another plan (plan_11.json: a chain of 11 pieces with softer tendons)
       record.py --shift NAME ...       how far the effects move the tip on two trials, and records nothing
       record.py --agree REC.csv ...    plays a recording's commands on the robot as built and compares the tips
"""

import csv
import json
import sys
from pathlib import Path

import numpy as np

from chain import Chain
from drives import Drives
from effects import Hidden, hide

PLAN = Path(__file__).with_name("plan.json")
TRIALS, ROWS, PERIOD_S = 8, 50, 0.2
# How far effects move the tip is told from these first trials.
SHIFT_TRIALS = 4
LARGEST_STEP_M, LARGEST_PULL_M = 0.003, 0.030
NOISE_M = 0.0005
COLUMNS = ["trial", "time_s", *(f"tendon_{i}_m" for i in range(1, 5)), "tip_x_m", "tip_y_m", "tip_z_m"]


def explore(rng):
    """Commands of a trial: each of two tendons goes on about as it went, at most 3 mm a step, and the opposite one is
    let out; together they stay within 30 mm of home."""
    place, step = np.zeros(2), np.zeros(2)
    commands = [np.zeros(4)]
    for _ in range(ROWS - 1):
        wanted = np.full(2, np.inf)
        while abs(wanted).max() > LARGEST_STEP_M:
            wanted = 0.7 * step + rng.normal(0.0, 0.0013, 2)
        new = (place + wanted) * min(1.0, LARGEST_PULL_M / max(np.linalg.norm(place + wanted), 1e-12))
        place, step = new.round(6), wanted
        commands.append(np.concatenate([place, -place]))
    return np.array(commands)


def noise(rng, correlation):
    """Tracking noise of a trial, rows x 3, of the same size whatever its correlation."""
    white = rng.normal(0.0, NOISE_M, (ROWS, 3))
    for row in range(1, ROWS):
        white[row] = correlation * white[row - 1] + np.sqrt(1 - correlation**2) * white[row]
    return white


def tips(hidden, commands):
    """Noise-free tips of trials on a robot, trials x rows x 3."""
    chain = Chain(hidden.robot, hidden.laws)
    chain.rest(np.zeros(4))
    out = []
    for trial, rows in enumerate(commands):
        seen = chain.trial(Drives(rows, PERIOD_S, hidden.faults, trial), len(rows), PERIOD_S)
        out.append(seen + hidden.shift_m + hidden.drift_m_per_s * PERIOD_S * np.arange(len(rows))[:, None])
    return np.array(out)


def rms(differences):
    return float(np.sqrt((differences**2).sum(axis=-1).mean()))


def drawn(number):
    """Commands of all trials of a recording, and the generator of its noise."""
    commands = [explore(np.random.default_rng([number, trial])) for trial in range(TRIALS)]
    return np.array(commands), np.random.default_rng([number, TRIALS])


def write(path, commands, seen):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for trial, (pulls, places) in enumerate(zip(commands, seen)):
            for row in range(ROWS):
                numbers = [f"{x:.6f}".replace("-0.000000", "0.000000") for x in (*pulls[row], *places[row])]
                writer.writerow([trial, f"{row * PERIOD_S:.3f}", *numbers])


def record(folder, entry):
    """Writes a recording; returns how far its effects move the tip."""
    commands, rng = drawn(entry["seed"])
    chain = entry.get("chain")
    hidden = hide(entry["effects"], chain)
    seen = tips(hidden, commands)
    shift_m = rms(seen[:SHIFT_TRIALS] - tips(hide([], chain), commands[:SHIFT_TRIALS])) if entry["effects"] else 0.0
    noisy = [trial + noise(rng, hidden.noise_correlation) for trial in seen]
    write(folder / f"{entry['file']}.csv", commands, noisy)
    return shift_m


def labels(entry, shift_m):
    names = [name for effect in entry["effects"] for name in effect]
    said = json.dumps(entry["effects"], separators=(", ", ": "))
    return [f"{entry['file']}.csv", "+".join(names) or "nothing", said, f"{shift_m:.6f}"]


def write_truth(folder, plan, found):
    """Labels of what has been recorded, in the order of the names; keeps those of earlier runs."""
    path = folder / "truth.csv"
    lines = {}
    if path.exists():
        with open(path, newline="") as file:
            lines = {line[0]: line for line in list(csv.reader(file))[1:]}
    lines.update({f"{entry['file']}.csv": labels(entry, found[entry["file"]]) for entry in plan if entry["file"] in found})
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["file", "effects", "parameters", "rms_shift_m"])
        writer.writerows(lines[name] for name in sorted(lines))


def agree(paths):
    """The robot as built against recordings in which nothing is hidden."""
    for path in paths:
        rows = np.loadtxt(path, delimiter=",", skiprows=1)
        trials = [rows[rows[:, 0] == trial] for trial in np.unique(rows[:, 0])]
        own = tips(Hidden(), [trial[:, 2:6] for trial in trials])
        off = own - np.array([trial[:, 6:9] for trial in trials])
        axes = ", ".join(f"{1e3 * x:.3f}" for x in np.sqrt((off**2).mean(axis=(0, 1))))
        print(f"{path}: {1e3 * rms(off):.3f} mm rms ({axes} mm by axis)", flush=True)


def main(arguments):
    file = PLAN
    if arguments[0] == "--plan":
        file, arguments = Path(arguments[1]), arguments[2:]
    plan = json.loads(file.read_text())
    if arguments[0] == "--agree":
        return agree(arguments[1:])
    names = arguments[1:] or [entry["file"] for entry in plan]
    unknown = set(names) - {entry["file"] for entry in plan}
    if unknown:
        sys.exit(f"{file.name}: found no recording {sorted(unknown)}")
    chosen = [entry for entry in plan if entry["file"] in names]
    chosen.sort(key=lambda entry: names.index(entry["file"]))
    for entry in chosen:
        if arguments[0] == "--shift":
            commands = drawn(entry["seed"])[0][:2]
            shift_m = rms(tips(hide(entry["effects"]), commands) - tips(Hidden(), commands))
        else:
            shift_m = record(Path(arguments[0]), entry)
            write_truth(Path(arguments[0]), plan, {entry["file"]: shift_m})
        print(f"{entry['file']}: {1e3 * shift_m:.2f} mm, {json.dumps(entry['effects'])}", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1:])
