"""sphere_motion.csv, sphere_recording*.csv and sphere_truth.csv: the MuJoCo chain of benches/twin beside a fixed sphere.

Method: benches/twin (docs/evidence/twin.md) with its effect `contact_sphere`: the body is a capsule along each piece, the sphere is
smooth (condim 1, solref 0.004 s, solimp 0.99 0.999 0.0001). A row is in contact when a contact pushed in the last step
of 1 ms before it. Nothing is fitted to the rod of this project.

usage: sphere_chain.py            writes all files
       sphere_chain.py --check    only says how much the motion depends on the step and on the stiffness of the contact
"""

import csv
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "twin"))

import mujoco
import numpy as np

import chain
from drives import Drives
from effects import hide
from record import COLUMNS, PERIOD_S, drawn, noise, write

OUT = Path(__file__).resolve().parents[2] / "tests" / "reference" / "stability"
BODY_RADIUS_M = 0.002
# Name, seed of commands and noise, centre and radius of the sphere.
RECORDINGS = (
    ("sphere_recording", 301, (-0.018, -0.031, 0.150), 0.020),
    ("sphere_recording_2", 302, (0.017, 0.029, 0.120), 0.030),
    ("sphere_recording_3", 303, (-0.038, -0.014, 0.180), 0.025),
)
MOTION = ((0.028, 0.006, 0.140), 0.020)
MOTION_ROWS, IN_AND_OUT_ROWS = 60, 20
PULL_M, ACROSS_M = 0.019, 0.006


class Touching(chain.Chain):
    """A chain that notes at each row what the sphere's contacts do."""

    def __init__(self, *arguments, **more):
        super().__init__(*arguments, **more)
        self.forces_n, self.inside_m = [], []

    def tip_m(self):
        total, inside = np.zeros(3), 0.0
        for k, contact in enumerate(self.data.contact[: self.data.ncon]):
            force = np.zeros(6)
            mujoco.mj_contactForce(self.model, self.data, k, force)
            # The normal is the frame's first row, from the first geom (of the lower number, the sphere) to the second.
            total += force[0] * contact.frame[:3]
            if force[0] > 0:
                inside = max(inside, -contact.dist)
        self.forces_n.append(total)
        self.inside_m.append(inside)
        return super().tip_m()


def played(effects, commands, dt_s=chain.TIME_STEP_S):
    """(tips, forces on the body, depths) of trials, each trials x rows."""
    hidden = hide(effects)
    robot = Touching(hidden.robot, hidden.laws, dt_s)
    robot.rest(np.zeros(4))
    tips = [
        robot.trial(Drives(rows, PERIOD_S, hidden.faults, k), len(rows), PERIOD_S) for k, rows in enumerate(commands)
    ]
    shape = len(commands), len(commands[0])
    return np.array(tips), np.array(robot.forces_n).reshape(*shape, 3), np.array(robot.inside_m).reshape(shape)


def beside(center_m, radius_m):
    return [{"contact_sphere": {"center_m": list(center_m), "radius_m": radius_m, "body_radius_m": BODY_RADIUS_M}}]


def motion_commands():
    """Towards +x into the sphere and out again, three times, while swaying along y."""
    row = np.arange(MOTION_ROWS)
    towards = PULL_M * (1 - np.cos(2 * np.pi * row / IN_AND_OUT_ROWS)) / 2
    across = -ACROSS_M * np.sin(2 * np.pi * row / (2.5 * IN_AND_OUT_ROWS))
    pulls = np.stack([towards, across], axis=1).round(6)
    return np.hstack([pulls, -pulls])


def text(numbers, digits=6):
    zero = f"{0:.{digits}f}"
    return [f"{x:.{digits}f}".replace("-" + zero, zero) for x in numbers]


def motion():
    commands = motion_commands()
    (tips,), (forces,), (inside,) = played(beside(*MOTION), commands[None])
    with open(OUT / "sphere_motion.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*COLUMNS, "contact", "force_x_n", "force_y_n", "force_z_n"])
        for row, (pulls, tip, force) in enumerate(zip(commands, tips, forces)):
            touching = int(np.linalg.norm(force) > 0)
            writer.writerow([0, f"{row * PERIOD_S:.3f}", *text(pulls), *text(tip, 9), touching, *text(force)])
    return tips, forces, inside


def recordings():
    lines = []
    for name, seed, center_m, radius_m in RECORDINGS:
        commands, rng = drawn(seed)
        tips, forces, inside = played(beside(center_m, radius_m), commands)
        alone, _, _ = played([], commands)
        write(OUT / f"{name}.csv", commands, [trial + noise(rng, 0.0) for trial in tips])
        touching = np.linalg.norm(forces, axis=2) > 0
        shift_m = np.sqrt(((tips - alone) ** 2).sum(axis=2).mean())
        lines.append([f"{name}.csv", *center_m, radius_m, BODY_RADIUS_M, touching.mean(), shift_m])
        with open(OUT / f"{name}_contact.csv", "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["trial", "time_s", "contact", "force_x_n", "force_y_n", "force_z_n"])
            for trial, forces_n in enumerate(forces):
                for row, force in enumerate(forces_n):
                    writer.writerow([trial, f"{row * PERIOD_S:.3f}", int(np.linalg.norm(force) > 0), *text(force, 4)])
        strong = np.linalg.norm(forces, axis=2)
        print(
            name,
            "share",
            touching.mean(),
            "by trial",
            touching.mean(axis=1),
            "shift",
            shift_m,
            "force",
            strong.max(),
            "inside",
            inside.max(),
            flush=True,
        )
    with open(OUT / "sphere_truth.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(
            "file,center_x_m,center_y_m,center_z_m,radius_m,body_radius_m,share_in_contact,rms_shift_m".split(",")
        )
        writer.writerows(
            [[name, *map(repr, numbers[:-2]), *(f"{x:.6f}" for x in numbers[-2:])] for name, *numbers in lines]
        )


def check():
    commands = motion_commands()[None]
    tips, forces, inside = played(beside(*MOTION), commands)
    print("inside at most", inside.max(), "force at most", np.linalg.norm(forces, axis=2).max())

    def against(label, other):
        off = np.linalg.norm(other - tips, axis=2)
        print(label, "rms", np.sqrt((off**2).mean()), "at most", off.max())

    against("half the step", played(beside(*MOTION), commands, chain.TIME_STEP_S / 2)[0])
    against("no sphere", played([], commands)[0])
    for time_s in (0.002, 0.008):
        chain.SPHERE_TIME_S = time_s
        against(f"solref {time_s}", played(beside(*MOTION), commands)[0])


if __name__ == "__main__":
    if sys.argv[1:] == ["--check"]:
        check()
    else:
        OUT.mkdir(parents=True, exist_ok=True)
        motion()
        recordings()
