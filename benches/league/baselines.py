"""Baselines of the league: writes submissions, has `spinebench league` score them, and makes the board.

usage: python3 benches/league/baselines.py OUT [--program spinebench] [--work DIR] [--track TRACK]… [--family FAMILY]… [--season FILE …]

Run it in the root of a checkout, with requirements.txt installed. Arguments that it does not know go to `spinebench league
robots` and `score`. It writes OUT/TRACK/METHOD, a submission each with its score, and a board in OUT. Questions,
simulations and answers that DIR has already of the same program, tracks and arguments are kept: an interrupted run goes on.

reach, track, change
    CONTROLLERS         those of this program
    gaussian_process    gaussian_process.py, with 100 samples of each robot
    ppo                 python/examples/train_ppo.py, on the paper robot alone; only where the Python package is installed

identify: tips under commands that were not seen
    nominal             simulation of the nominal model
    constant_curvature  a chain of arcs, by least squares                               these maps: fits.py
    linear, cubic       ridge regression from the last commands
    gaussian_process    one for each coordinate, from the last commands
    model_gp            the nominal model, and Gaussian processes for what it leaves
    calibrated          `spinebench calibrate` fits the CALIBRATED numbers of the model, then simulation
    discover            simulation of the model that `spinebench discover` writes
    mujoco              MuJoCo's own system identification; only where `mujoco[sysid]` is installed

name: the missing effect, or none
    always_nothing      none
    gp_detect           a Gaussian process finds that something is missing (BIC against noise alone), but not what: answers
                        FREQUENT. All effects are equally frequent: it names a missing one by chance, once in 17 to 25 times
    sparse_regression   what the nominal model leaves, regressed on the differences that single effects of usual size make
                        (SIZES); stepwise by BIC, at most MOST_NAMED. `contact` is not linear and not tried
    discover            `spinebench discover`, at most MOST_NAMED effects, as the track says. `named`: these effects;
                        `ambiguous`: the likeliest; `consistent`: none; `unexplained`: the first that it lists, else none

Where a method fails on a robot, a line says so, and the answer is that of `nominal` or of `always_nothing`. A line also says
where a method is left out on a real robot (`--measured`): `constant_curvature` needs displacements of tendons, `discover` a
baseline of the same robot, `mujoco` a chain of robots.py. On real robots `calibrated` fits the numbers of `make real`, which were
chosen on all rows; their values come from given.csv alone.
"""

import argparse
import csv
import hashlib
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import time
from multiprocessing import Pool
from pathlib import Path

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ[variable] = "1"

import fits
import numpy as np
import yaml
from robots import ROBOTS, Segmented

WORKERS = 2
TRIALS = ("reach", "track", "change")
CONTROLLERS = (
    "integral", "online_jacobian", "model_integral", "mpc", "a", "b", "c", "pi_real", "a_integral", "c_hysteresis", "a_online",
    "dagger",
)  # fmt: skip
HERE = Path(__file__).resolve().parent
CALIBRATED = "youngs_modulus_pa,damping_time_s,tendon_radius_m,robot.tendons.pretension_m"
MOST_NAMED, FREQUENT, UNTRAINED = 1, "tip_load", ("nominal", "always_nothing")
# Usual sizes in the catalogue, as columns that are fitted together. "at": at each tendon, segment or second section in turn.
SIZES = {
    "tip_load": [{"mass_kg": 0.005}], "distributed_mass": [{"scale": 1.2}], "bending_stiffness": [{"scale": 1.1}],
    "tip_force": [{"force_n": [0.03, 0, 0]}, {"force_n": [0, 0.03, 0]}, {"force_n": [0, 0, 0.1]}],
    "base_tilt": [{"tilt_x_rad": 0.01, "tilt_y_rad": 0}, {"tilt_x_rad": 0, "tilt_y_rad": 0.01}],
    "frame_shift": [{"shift_m": [0.002, 0, 0]}, {"shift_m": [0, 0.002, 0]}, {"shift_m": [0, 0, 0.002]}],
    "anisotropic_stiffness": [{"ratio": 0.1, "angle_rad": 0}, {"ratio": 0.1, "angle_rad": 0.7853981633974483}],
    "precurvature": [{"kappa_x_rad_m": 0.2, "kappa_y_rad_m": 0}, {"kappa_x_rad_m": 0, "kappa_y_rad_m": 0.2}],
    "soft_section": [{"position_m": "at", "scale": 0.7}], "spine_compressibility": [{"scale": 1.2}],
    "friction": [{"moment_nm": 0.01}], "hysteresis": [{"share": 0.1, "range_rad_m": 5}],
    "creep": [{"share": 0.15, "time_s": 3}], "damping": [{"time_s": 0.08}], "delay": [{"time_s": 0.05}],
    "backlash": [{"width_m": 0.001}], "actuator_gain": [{"tendon": "at", "scale": 1.04}],
    "actuator_offset": [{"tendon": "at", "offset_m": 0.001}], "tendon_stretch": [{"compliance_m_per_n": 1e-4}],
    "tendon_angle": [{"angle_rad": 0.04}], "tendon_radius": [{"scale": 1.04}], "tendon_friction": [{"coefficient": 0.05}],
    "servo_lag": [{"time_s": 0.05}], "pretension": [{"segment": "at", "change_m": 0.001}],
}  # fmt: skip
NEED_SECTIONS = ("soft_section", "spine_compressibility")


class LeftOut(Exception):
    """A method cannot answer for a robot; says why."""


class Questions:
    """What is known of one robot, and what the program makes of it."""

    def __init__(self, program, folder, work):
        self.program, self.folder, self.work = program, folder, work
        work.mkdir(parents=True, exist_ok=True)
        self.model, self.given_file, self.asked_file = (folder / name for name in ("model.yaml", "given.csv", "asked.csv"))
        self.given = fits.Recording(self.given_file)
        self.asked = fits.Recording(self.asked_file) if self.asked_file.exists() else None
        self.is_real = self.given.at_rest
        self.family = folder.name if self.is_real else family_of(folder)
        self.robot = None if self.is_real else ROBOTS[self.family]()

    def make(self, out, command, *arguments):
        """What a command writes, unless it is there."""
        if not (out / "findings.json" if command == "discover" else out).exists():
            at_rest = ["--static"] * self.is_real
            call = [self.program, command, "--quiet", *at_rest, "--model", *map(str, arguments), "--out", out]
            one_each = {**os.environ, "RAYON_NUM_THREADS": "1"}
            done = subprocess.run(call, check=False, capture_output=True, text=True, env=one_each)
            if done.returncode:
                raise RuntimeError(f"spinebench {command}: {done.stderr.strip()}")
        return out

    def asked_tips_m(self, name, model):
        """Tips of a model under the commands that are asked."""
        played = self.make(self.work / f"{name}_asked.csv", "simulate", model, "--commands", self.asked_file)
        return fits.Recording(played).tips_m

    def given_tips_m(self, name, effects=()):
        """The same under the commands that are given, of the nominal model with these effects."""
        text, model = self.model.read_text(), self.work / f"{name}.yaml"
        if effects and "effects: []" not in text:
            raise RuntimeError(f"{self.model}: found effects, expected `effects: []`")
        model.write_text(text.replace("effects: []", f"effects: {json.dumps(effects)}"))
        played = self.make(self.work / f"{name}_given.csv", "simulate", model, "--commands", self.given_file)
        return fits.Recording(played).tips_m

    def found(self, *options):
        if self.is_real:
            raise LeftOut("it needs a baseline of the same robot")
        return self.make(self.work / "found", "discover", self.model, "--measured", self.given_file, *options)


def family_of(folder):
    return next((family for family in ROBOTS if folder.name.startswith(family)), folder.name)


def geometry(model_file):
    """Tendons and length of the robot of a model, place of its base, and displacements of tendons per command."""
    model = yaml.safe_load(model_file.read_text())
    robot, tendons, drives = model["robot"], model["robot"]["tendons"], model.get("drives", {})
    gains = np.eye(len(tendons["angles_deg"]))
    if drives:
        gains = np.zeros((len(drives), len(gains)))
        for row, name in enumerate(sorted(drives)):
            gains[row, np.array(drives[name]["tendons"]) - 1] = drives[name]["gains"]
    numbers = {"length_m": robot["backbone"]["length_m"], "tendon_radius_m": tendons["radius_m"]}
    angles_rad = tuple(np.radians(tendons["angles_deg"]))
    known = Segmented(**numbers, tendon_angles_rad=angles_rad, tendon_ends_m=tuple(tendons["ends_m"]))
    return known, np.array(robot.get("base_m", [0.0, 0.0, 0.0])), gains


def real_robots():
    """Robots of benches/real/robots.py, a namesake of ours, by name."""
    file = HERE.parent / "real" / "robots.py"
    sys.path.append(str(file.parent))
    spec = importlib.util.spec_from_file_location("real_robots", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return {robot.name: robot for robot in module.ROBOTS}


def constant_curvature(q):
    if not q.is_real:
        return fits.arcs(q.robot, q.given, q.asked)
    if "tendon_1_n" in q.given_file.read_text():
        raise LeftOut("it needs displacements of tendons")
    robot, base_m, gains = geometry(q.model)
    return fits.arcs(robot, q.given, q.asked, base_m, gains)


def calibrated(q):
    numbers = real_robots()[q.family].fit if q.is_real else CALIBRATED
    out = q.make(q.work / "calibrated.yaml", "calibrate", q.model, "--measured", q.given_file, "--fit", numbers)
    return q.asked_tips_m("calibrated", out)


def mujoco(q):
    if q.is_real:
        raise LeftOut("robots.py has no chain of it")
    return fits.mujoco_sysid(q.family, q.given, q.asked)


def model_gp(q):
    left_m = q.given.tips_m - q.given_tips_m("nominal")
    return q.asked_tips_m("nominal", q.model) + fits.processes(q.given, left_m, q.asked)


def gp_detect(q):
    x, gain = q.given.commands_m / q.given.commands_m.std(), 0.0
    for left_m in (q.given.tips_m - q.given_tips_m("nominal")).T:
        process, count = fits.GaussianProcess(x, left_m), len(left_m)
        noise = -0.5 * count * (1 + np.log(2 * np.pi * np.mean(left_m**2)))
        # One more number than noise for each command, and those of the mean and the signal.
        gain += process.evidence - count * np.log(process.spread) - noise - 0.5 * (x.shape[1] + 2) * np.log(count)
    return FREQUENT if gain > 0 else ""


def alternatives(robot, effect, columns):
    """An effect at each place that it may be at: lists of parameters that are fitted together."""
    if effect in NEED_SECTIONS and not robot.sections:
        return []
    places = {
        "tendon": range(1, 1 + len(robot.tendon_angles_rad)),
        "segment": range(1, 1 + len(set(robot.tendon_ends_m or [0]))),
        "position_m": robot.section_middles_m()[::2].tolist(),
    }
    at = next((key for key, value in columns[0].items() if value == "at"), None)
    return [[{**columns[0], at: place}] for place in places[at]] if at else [columns]


def sparse_regression(q):
    nominal_m, choices = q.given_tips_m("nominal"), []
    for effect, columns in SIZES.items():
        for i, chosen in enumerate(alternatives(q.robot, effect, columns)):
            played = [q.given_tips_m(f"{effect}_{i}_{j}", [{effect: parameters}]) for j, parameters in enumerate(chosen)]
            choices.append((effect, np.column_stack([(tips_m - nominal_m).ravel() for tips_m in played])))
    return " ".join(fits.stepwise(choices, (q.given.tips_m - nominal_m).ravel(), MOST_NAMED))


def discovered(q):
    (q.work / "options.yaml").write_text(f"most_effects: {MOST_NAMED}\n")
    findings = json.loads((q.found("--options", q.work / "options.yaml") / "findings.json").read_text())
    names = [effect["name"] for effect in findings["effects"]]
    return " ".join({"consistent": [], "unexplained": names[:1]}.get(findings["verdict"], names))


METHODS = {
    "identify": {
        "nominal": lambda q: q.asked_tips_m("nominal", q.model),
        "constant_curvature": constant_curvature,
        "linear": lambda q: fits.ridge(q.given, q.asked, 1), "cubic": lambda q: fits.ridge(q.given, q.asked, 3),
        "gaussian_process": lambda q: fits.processes(q.given, q.given.tips_m, q.asked),
        "model_gp": model_gp, "calibrated": calibrated,
        "discover": lambda q: q.asked_tips_m("found", q.found() / "model.yaml"), "mujoco": mujoco,
    },
    "name": {
        "always_nothing": lambda q: "", "gp_detect": gp_detect, "sparse_regression": sparse_regression, "discover": discovered,
    },
}  # fmt: skip


def answered(task):
    """What is known of a robot, the answer of a method, how long it took, and why it failed; failures are not kept."""
    program, track, method, folder, work = task
    q, kept, began = Questions(program, folder, work), work / f"answer_{method}.json", time.perf_counter()
    if kept.exists():
        return q, json.loads(kept.read_text())
    try:
        answer, failed = METHODS[track][method](q), None
    except LeftOut as needs:
        return q, {"left_out": str(needs)}
    except Exception as error:  # noqa: BLE001
        answer, failed = next(iter(METHODS[track].values()))(q), str(error)
    answer = answer if isinstance(answer, str) else answer.tolist()
    result = {"answer": answer, "took_s": time.perf_counter() - began, "failed": failed}
    if not failed:
        kept.write_text(json.dumps(result))
    return q, result


def write_submission(out, track, name, trained_on, **keys):
    """The folder of a submission with its description."""
    folder = out / track / name
    folder.mkdir(parents=True, exist_ok=True)
    described = {
        "name": name, "authors": ["spinebench"], "track": track, "trained_on": trained_on, "real_samples": 0,
        "licence": "MIT OR Apache-2.0", **keys,
    }  # fmt: skip
    (folder / "submission.yaml").write_text(json.dumps(described, indent=2) + "\n")
    return folder


def trained_network(work):
    """The network of python/examples/train_ppo.py; none without the Python package."""
    network = work / "ppo.onnx"
    if not network.exists():
        work.mkdir(parents=True, exist_ok=True)
        call = [sys.executable, HERE.parents[1] / "python" / "examples" / "train_ppo.py"]
        done = subprocess.run(call, check=False, cwd=work, capture_output=True, text=True)
        if done.returncode:
            print(f"`ppo` is left out: {done.stderr.strip().splitlines()[-1]}")
            return None
    return network


def write_policies(out, work, track, families):
    """Submissions with policies, which play some `families` if any: their folders."""
    robots = {"robots": families} if families else {}
    trained_on = "the nominal model; some also on samples of each robot"
    folders = [write_submission(out, track, name, trained_on, policy={"builtin": name}, **robots) for name in CONTROLLERS]
    process = {"file": "gaussian_process.py", "class": "GaussianProcess", "samples": 100}
    trained_on = "100 samples of each robot, which the policy takes before the trials"
    folders.append(write_submission(out, track, "gaussian_process", trained_on, policy={"python": process}, **robots))
    shutil.copy(HERE / process["file"], folders[-1])
    if (not families or "paper" in families) and (network := trained_network(work)):
        onnx = {"file": network.name, "inputs": ["error"], "output": "changes"}
        folders.append(write_submission(out, track, "ppo", "the nominal model", policy={"onnx": onnx}, robots=["paper"]))
        shutil.copy(network, folders[-1])
    return folders


def write_answers(out, track, method, answers, robots):
    """A submission; `answers`: [(what is known of a robot, answer)]; `robots`: its families, unless it answers all."""
    rows = sum(len(q.given.trial) for q, _ in answers) * (method not in UNTRAINED)
    trained_on = f"given.csv of each robot, {rows} rows in all" if rows else "nothing"
    out = write_submission(out, track, method, trained_on, answers="answers", **robots)
    (out / "answers").mkdir(exist_ok=True)
    tables = {"names": [("robot", "effects"), *((q.folder.name, answer) for q, answer in answers)]}
    if track == "identify":
        head = ("trial", "time_s", "tip_x_m", "tip_y_m", "tip_z_m")
        tables = {
            q.folder.name: [head, *((*row, *tip_m) for *row, tip_m in zip(q.asked.trial, q.asked.time_s, tips_m))]
            for q, tips_m in answers
        }
    for name, rows in tables.items():
        with open(out / "answers" / f"{name}.csv", "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(rows)
    return out


def answer(out, work, track, families, program, passed):
    """Answers of all methods to the questions of a track, to those of some `families` if any: the folders of the submissions."""
    questions, answers = work / "questions" / track, {}
    if not questions.exists():
        unfinished = work / "unfinished" / track
        subprocess.run([program, "league", "robots", track, "--out", unfinished, *passed], check=True)
        questions.parent.mkdir(parents=True, exist_ok=True)
        unfinished.rename(questions)
    every = {folder: family_of(folder) for folder in sorted(questions.iterdir())}
    folders = [(folder, work / "work" / track / folder.name) for folder in every if every[folder] in (families or every.values())]
    tasks = [(program, track, method, *both) for method in METHODS[track] for both in folders]
    with Pool(WORKERS, os.nice, (10,)) as pool:
        for (_, _, method, folder, _), (q, kept) in zip(tasks, pool.imap(answered, tasks)):
            if "left_out" in kept:
                print(f"{track}, {method}, {folder.name}: left out: {kept['left_out']}", flush=True)
                continue
            failed = f": failed: {kept['failed']}" if kept["failed"] else ""
            print(f"{track}, {method}, {folder.name}: {kept['took_s']:.1f} s{failed}", flush=True)
            answers.setdefault(method, []).append((q, kept["answer"]))
    submissions = []
    for method, of_robots in answers.items():
        answered_families = {q.family for q, _ in of_robots}
        robots = {} if answered_families == set(every.values()) else {"robots": sorted(answered_families)}
        submissions.append(write_answers(out, track, method, of_robots, robots))
    return submissions


def kept_for(program, passed):
    """Name of the folder of what is kept: other programs, tracks, models or arguments have another."""
    version = subprocess.run([program, "--version"], check=True, capture_output=True).stdout
    files = [*Path("experiments/league").glob("*.yaml"), *HERE.glob("*.py"), *HERE.glob("*.yaml")]
    parts = [version, *map(str.encode, passed), *(file.read_bytes() for file in sorted(files))]
    return hashlib.blake2b(b"\0".join(parts), digest_size=8).hexdigest()


def main():
    parser, began = argparse.ArgumentParser(usage=__doc__), time.perf_counter()
    parser.add_argument("out", type=Path)
    parser.add_argument("--program", default="spinebench")
    parser.add_argument("--work", type=Path, default=Path("target/league"))
    parser.add_argument("--track", action="append", choices=(*TRIALS, *METHODS))
    parser.add_argument("--family", action="append")
    given, passed = parser.parse_known_args()
    if not hasattr(fits.sysid, "optimize"):
        print("mujoco[sysid] is not installed: `mujoco` is left out")
        del METHODS["identify"]["mujoco"]
    failed, work = False, given.work / kept_for(given.program, passed)
    for track in given.track or (*TRIALS, *METHODS):
        if track in TRIALS:
            folders = write_policies(given.out, work, track, given.family)
        else:
            folders = answer(given.out, work, track, given.family, given.program, passed)
        for folder in folders:
            print(folder, flush=True)
            call = [given.program, "league", "score", "--quiet", folder, *passed]
            failed |= subprocess.run(call, check=False).returncode != 0
    subprocess.run([given.program, "league", "table", given.out], check=True)
    print(f"in all: {time.perf_counter() - began:.0f} s")
    sys.exit(failed)


if __name__ == "__main__":
    main()
