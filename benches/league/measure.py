"""How far the robots of the league are from the rod model of the same numbers and from finer chains, and time per step.

usage: measure.py SPINEBENCH        the compiled program; models from models/ and from this folder

Chain and rod at rest, distance of the tips in mm, for the five POSES_MM of each robot:

    paper         0.10  0.28  0.36  0.29  0.60
    two_segment   0.23  0.13  0.28  0.44  0.32
    nine_tendon   0.01  0.03  0.04  0.18  0.10

A walk of 10 s (the tip moves 23, 74 and 75 mm rms), rms distance in mm, and ms per step of 0.2 s on two busy cores. The
finest chain has 22, 40 and 36 pieces and 0.5 ms; it is 0.34, 0.36 and 0.22 mm from the rod. Stars: what serve.py uses.

    robot         pieces  time step  from the finest  from the rod  ms per step
    paper         11      1 ms *     0.10             0.33          5
    paper         11      2 ms       0.11             0.33          3
    paper         22      1 ms       0.01             0.34          17
    two_segment   14      2 ms       2.29             2.57          3
    two_segment   20      1 ms *     0.97             1.26          12
    two_segment   20      2 ms       0.97             1.27          6
    nine_tendon   12      2 ms       1.85             1.82          4
    nine_tendon   18      1 ms *     0.75             0.74          13
    nine_tendon   18      2 ms       0.75             0.74          6
"""

import csv
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from trial import Trial

HERE = Path(__file__).resolve().parent
MODELS = {
    "paper": HERE.parents[1] / "models" / "nominal.yaml",
    "two_segment": HERE / "two_segment.yaml",
    "nine_tendon": HERE / "nine_tendon.yaml",
}
STEP_S = 0.2
# Pulls in mm at which both are at rest.
POSES_MM = {
    "paper": ([0, 0, 0, 0], [5, 0, -5, 0], [0, 10, 0, -10], [14, -14, -14, 14], [20, 0, -20, 0]),
    "two_segment": (
        [0, 0, 0, 0, 0, 0],
        [2, -1, -1, 0, 0, 0],
        [0, 0, 0, 3, -3, -1],
        [5, -3, -3, 2, -4, 2],
        [-4, 4, 0, -4, 10, -6],
    ),
    "nine_tendon": (
        [0] * 9,
        [2, -1, -1, 0, 0, 0, 0, 0, 0],
        [0, 0, 0, 3, -2, -1, 3, -2, -1],
        [3, -2, -1, 5, -4, -1, 7, -6, -1],
        [-3, 4, -1, -3, 8, -5, -3, 12, -9],
    ),
}
FINER = {"paper": (22, 0.0005), "two_segment": (40, 0.0005), "nine_tendon": (36, 0.0005)}
OTHERS = {
    "paper": ((11, 0.001), (11, 0.002), (22, 0.001)),
    "two_segment": ((14, 0.002), (20, 0.001), (20, 0.002)),
    "nine_tendon": ((12, 0.002), (18, 0.001), (18, 0.002)),
}


def rod(spinebench, robot, pulls_m, static):
    """Tips of the rod model under the commands of one trial, rows x 3."""
    with tempfile.TemporaryDirectory() as folder:
        asked, given = Path(folder) / "in.csv", Path(folder) / "out.csv"
        with open(asked, "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["trial", "time_s", *(f"tendon_{i + 1}_m" for i in range(len(pulls_m[0])))])
            writer.writerows([0, f"{row * STEP_S:.3f}", *pulls] for row, pulls in enumerate(pulls_m))
        command = [spinebench, "simulate", "--quiet", "--model", MODELS[robot], "--commands", asked, "--out", given]
        subprocess.run([*command, "--static"] if static else command, check=True, stdout=subprocess.DEVNULL)
        with open(given, newline="") as file:
            return np.array([[float(row[f"tip_{axis}_m"]) for axis in "xyz"] for row in csv.DictReader(file)])


def walk(robot, rows=50):
    """A trial at 5 Hz: pulls bend each segment about as before, and opposite tendons are let out."""
    rng, pulls = np.random.default_rng(1), [np.zeros(len(POSES_MM[robot][0]))]
    angles = {"paper": [0, 90, 180, 270], "two_segment": [0, 120, 240], "nine_tendon": [0, 120, 240]}[robot]
    sides = np.stack([np.cos(np.radians(angles)), np.sin(np.radians(angles))], axis=1)
    segments = len(pulls[0]) // len(angles)
    place, step = np.zeros((segments, 2)), np.zeros((segments, 2))
    size_m = 0.0013 if robot == "paper" else 0.0005
    for _ in range(rows - 1):
        step = 0.7 * step + rng.normal(0.0, size_m, (segments, 2))
        place = 0.97 * (place + step)
        pulls.append(np.concatenate([sides @ np.sum(place[: k + 1], axis=0) for k in range(segments)]).round(6))
    return np.array(pulls)


def played(trial, pulls_m, steps=1):
    """Tips after each command, held for so many steps."""
    trial.reset()
    tips = []
    for pulls in pulls_m:
        for _ in range(steps):
            trial.command(pulls)
        tips.append(trial.observe()["tip_m"])
    return np.array(tips)


def main(spinebench):
    for robot, poses in POSES_MM.items():
        pulls_m = 1e-3 * np.array(poses, dtype=float)
        off = played(Trial(robot, None, [], None, STEP_S, None), pulls_m, 20) - rod(spinebench, robot, pulls_m, True)
        for pose, distance in zip(poses, np.linalg.norm(off, axis=1)):
            print(f"{robot}, at rest under {pose} mm: chain and rod {1e3 * distance:.2f} mm apart", flush=True)
        commands = walk(robot)
        moving = rod(spinebench, robot, commands, False)
        pieces, dt_s = FINER[robot]
        fine = played(Trial(robot, pieces, [], None, STEP_S, dt_s), commands[:-1])
        spread, off = rms(fine - fine.mean(axis=0)), rms(fine - moving[1:])
        print(f"{robot}, walk: the tip moves {1e3 * spread:.1f} mm rms; finest and rod {1e3 * off:.2f} mm rms apart")
        for pieces, dt_s in OTHERS[robot]:
            started = time.perf_counter()
            trial = Trial(robot, pieces, [], None, STEP_S, dt_s)
            ready = time.perf_counter()
            tips = played(trial, commands[:-1])
            each_ms = 1e3 * (time.perf_counter() - ready) / len(tips)
            print(
                f"{robot}, walk, {pieces} pieces, {1e3 * dt_s} ms: {1e3 * rms(tips - fine):.2f} mm rms from the finest,"
                f" {1e3 * rms(tips - moving[1:]):.2f} from the rod; {each_ms:.1f} ms a step, {ready - started:.1f} s to start",
                flush=True,
            )


def rms(off):
    return float(np.sqrt((off**2).sum(axis=-1).mean()))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
