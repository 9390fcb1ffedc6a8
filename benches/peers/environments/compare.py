"""Environments beside those of others: steps a second, simulated time over processor time, and what Python costs.

usage: compare.py CASES OUT [ROUNDS]
CASES is the folder that `cargo bench --bench peers -- cases CASES` has filled; OUT gets environments.csv, .md and .yaml. Every
package has a process of its own that stays up; in each round all take their turns, so that a ratio is taken within a round.
"""

import csv
import json
import math
import os
import platform
import random
import statistics
import subprocess
import sys
from pathlib import Path

import tables

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
STEP_S = 0.2
#: Steps of a run, and the largest change of a command in one as a share of the environment's.
STEPS, CHANGE = 50, 0.5
#: Robots of the vector and its steps; steps of the loops that find what Python costs.
ROBOTS, VECTOR_STEPS, LOOPS = 256, 20, 20
#: Tensions are held for this long, s.
ROW_S = 0.01
#: Names and scripts.
PEERS = {
    "spinebench": "spinebench_env.py",
    "MuJoCo hinge chain": "mujoco_env.py",
    "PyElastica": "elastica_env.py",
    "soromox": "soromox_env.py",
    "gym-softrobot": "softrobot_env.py",
}
#: Grids of ours: the shipped one, and the one that `benches/peers/suite.rs` has for 0.1 mm, with steps in time as long as
#: two errors allow.
COARSE = "cell_m: 0.02, bending_modes: 4, torsion_modes: 2, shear_modes: 2, axial_modes: 3"
GRIDS = {
    "shipped grid": "",
    "coarse grid": f"{{{COARSE}}}",
    "coarse grid, 1 mm a time step": f"{{{COARSE}, motion_tolerance_m: 1.0e-3}}",
}
#: Segments and time steps of the chain, s; elements, time steps and factors on the rotary inertia of the rod.
CHAINS = [
    (11, 0.025), (11, 0.01), (11, 0.005), (11, 0.002), (11, 0.001), (22, 0.01), (22, 0.005), (22, 0.002), (22, 0.001)
]  # fmt: skip
RODS = [(11, 5e-5, 100.0), (22, 2e-5, 100.0), (44, 5e-6, 100.0)]
#: Pieces of constant strain and time steps, s.
PIECES = [(4, 2e-4), (8, 1e-4)]
OWN = ["TendonArmReach-v0", "SoftArmTracking-v0", "SoftPendulum-v0"]
#: The accuracy at which the goals are.
WANTED_MM = 0.1


class Peer:
    """A script that stays up."""

    def __init__(self, name, cases, word="", all_cores=False):
        environment = dict(os.environ)
        environment |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
        if not all_cores:
            environment["RAYON_NUM_THREADS"] = "1"
        self.log = (cases / f"{name.replace(' ', '_')}{word}.log").open("w")
        self.process = subprocess.Popen(
            [sys.executable, HERE / PEERS[name], cases], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.log,
            text=True, env=environment,
        )  # fmt: skip
        self.versions = self.read()["versions"]

    def read(self):
        line = self.process.stdout.readline()
        if not line:
            self.log.flush()
            lines = Path(self.log.name).read_text().splitlines()
            raise RuntimeError(lines[-1] if lines else "it ended without a word")
        return json.loads(line)

    def ask(self, task, **request):
        self.tell(task, **request)
        return self.read()

    def tell(self, task, **request):
        print(json.dumps({"task": task, **request}), file=self.process.stdin, flush=True)

    def end(self):
        self.process.stdin.close()
        self.process.wait()


def rms_m(tips, limit):
    squares = [sum((a - b) ** 2 for a, b in zip(tip, other, strict=True)) for tip, other in zip(tips, limit, strict=True)]
    return math.sqrt(statistics.fmean(squares))


def actions_and_pulls():
    """Random changes of two antagonistic pairs, and the commands that they give."""
    rng = random.Random(1)
    actions, pulls, now = [], [], [0.0] * 4
    for _ in range(STEPS):
        a, b = rng.uniform(-CHANGE, CHANGE), rng.uniform(-CHANGE, CHANGE)
        # What an environment reads: single precision.
        action = [float(f"{x:.4f}") for x in (a, b, -a, -b)]
        now = [min(max(x + 0.006 * y, -0.03), 0.03) for x, y in zip(now, action, strict=True)]
        actions.append(action)
        pulls.append(now)
    return actions, pulls


def held_tensions():
    """Tensions that rise smoothly from zero, where all robots hang at rest, to the last ones of `benches/peers/drive.rs`, in
    N, held for a while each."""

    def rise(t):
        return 0.5 - 0.5 * math.cos(math.pi * min(max(t, 0.0), 1.0))

    times = [ROW_S * k for k in range(round(1 / ROW_S) + 1)]
    return [[7 * rise(t), 4 * rise(2 * t - 0.5), 0.0, 0.0] for t in times]


def checked(answer):
    if "failed" in answer:
        raise SystemExit(f"peers: {answer['failed']}")
    return answer


def tension_model(text):
    """The paper's robot without compressible spine and damping."""
    kept = [line for line in text.splitlines() if not line.lstrip().startswith("sections:")]
    return "\n".join("  damping_time_s: 0.0" if line.lstrip().startswith("damping_time_s:") else line for line in kept)


class Comparison:
    def __init__(self, cases, rounds):
        self.rows, self.versions, self.skipped, self.rounds = [], {"python": platform.python_version()}, {}, rounds
        self.cases, self.peers = cases, {}
        for name in PEERS:
            try:
                self.peers[name] = Peer(name, cases)
                self.versions |= self.peers[name].versions
            except (RuntimeError, OSError) as error:
                self.skipped[name] = str(error)
                print(f"{name}: skipped: {error}")
        if "spinebench" not in self.peers:
            raise SystemExit(f"peers: found no spinebench ({self.skipped['spinebench']}), expected `pip install ./python`")
        self.all_cores = Peer("spinebench", cases, "_all_cores", all_cores=True)
        self.actions, pulls = actions_and_pulls()
        self.model_text = (ROOT / "models" / "nominal.yaml").read_text()
        self.tensions = {"values": held_tensions(), "row_s": ROW_S}
        ours = self.peers["spinebench"]
        limit = checked(ours.ask("limit", model_text=self.model_text, pulls=pulls))
        still = checked(ours.ask("tensions", model_text=tension_model(self.model_text), setting=None, **self.tensions))
        self.limits = {"lengths": limit["tips_m"], "tensions": still["tips_m"]}
        self.apart_m = limit["apart_m"]

    def note(self, number, task, peer, setting, answer, robots=1, processes=1, threads=1):
        """A row; `answer` is that of one process, or the mean over processes."""
        row = {
            "round": number, "task": task, "peer": peer, "setting": setting, "robots": robots, "processes": processes,
            "threads": threads, "cpu_s_per_step": math.nan, "wall_s_per_step": math.nan,
            "simulated_s_per_cpu_s": math.nan, "rms_error_m": math.nan, "status": answer.get("failed", "ok"),
        }  # fmt: skip
        if "failed" not in answer:
            steps = answer["steps"] if "steps" in answer else answer["simulated_s"] / STEP_S
            row["cpu_s_per_step"], row["wall_s_per_step"] = answer["cpu_s"] / steps, answer["wall_s"] / steps
            row["simulated_s_per_cpu_s"] = answer.get("simulated_s", steps * STEP_S) / answer["cpu_s"]
            if task in self.limits:
                row["rms_error_m"] = rms_m(answer["tips_m"], self.limits[task])
        self.rows.append(row)
        print(
            f"{number:2} {task:9} {peer:19} {setting:31} {processes} process(es) {1e6 * row['cpu_s_per_step']:11.1f} µs/step "
            f"{row['simulated_s_per_cpu_s']:9.3f} x {1e3 * row['rms_error_m']:8.4f} mm {row['status']}",
            flush=True,
        )

    def runs(self):
        """Task, peer, setting in words, and request of every run."""
        still = tension_model(self.model_text)
        for name, grid in GRIDS.items():
            request = {"task": "steps", "actions": self.actions, "model_text": self.model_text, "setting": grid}
            yield "lengths", "spinebench", name, request
        for segments, dt_s in CHAINS:
            request = {"task": "steps", "actions": self.actions, "setting": [segments, dt_s]}
            yield "lengths", "MuJoCo hinge chain", f"{segments} segments, {1e3 * dt_s:g} ms", request
        for name, grid in GRIDS.items():
            yield "tensions", "spinebench", name, {"task": "tensions", "model_text": still, "setting": grid, **self.tensions}
        for elements, dt_s, factor in RODS:
            request = {"task": "tensions", **self.tensions, "setting": [elements, dt_s, factor]}
            yield "tensions", "PyElastica", f"{elements} elements, {1e3 * dt_s:g} ms", request
        for pieces, dt_s in PIECES:
            request = {"task": "tensions", **self.tensions, "setting": [pieces, dt_s]}
            yield "tensions", "soromox", f"{pieces} pieces, {1e3 * dt_s:g} ms", request
        for name in OWN:
            yield "own", "gym-softrobot", name, {"task": "own", "name": name, "steps": 50}

    def measure(self):
        """The rounds; in each, whoever begins is another."""
        runs = [run for run in self.runs() if run[1] in self.peers]
        for _, peer, _, request in runs:
            self.peers[peer].ask(**request)  # what is made or compiled once is not timed
        for number in range(1, self.rounds + 1):
            for task, peer, setting, request in runs:
                self.note(number, task, peer, setting, self.peers[peer].ask(**request))
            self.overheads(number)
            runs = runs[1:] + runs[:1]
        self.side_by_side()

    def overheads(self, number):
        """What Python costs: a call, a step of an environment, and a step of a vector on one core and on all."""
        ours, cores = self.peers["spinebench"], os.cpu_count() or 1
        pulls = [[0.02 * x for x in action] for action in self.actions]
        vector = {"task": "vector", "actions": self.actions[:VECTOR_STEPS], "robots": ROBOTS}
        for task, robots, threads, found in (
            ("call", 1, 1, checked(ours.ask("call", pulls=pulls, many=LOOPS))),
            ("vector", ROBOTS, 1, checked(ours.ask(**vector))),
            ("vector", ROBOTS, cores, checked(self.all_cores.ask(**vector))),
        ):
            for key, setting in (("stepped", "one call a step"), ("played", "one call for all steps")):
                self.note(number, task, "spinebench", setting, found[key], robots, threads=threads)
        found = checked(ours.ask("overhead", actions=self.actions, many=LOOPS))
        self.note(number, "overhead", "spinebench", "constant curvature", found)

    def side_by_side(self):
        """The fastest setting within the wanted error (or the first one) in two processes at the same time."""
        chosen = {}
        for task, peer in (("lengths", "spinebench"), ("lengths", "MuJoCo hinge chain"), ("tensions", "PyElastica")):
            best = tables.fastest_within(self.rows, task, peer, WANTED_MM)
            runs = [run for run in self.runs() if run[:2] == (task, peer) and peer in self.peers]
            runs = [run for run in runs if best and run[2] == best[0]["setting"]] or runs[:1]
            chosen |= {peer: run for run in runs}
        second = {peer: Peer(peer, self.cases, "_second") for peer in chosen}
        for peer, (_, _, _, request) in chosen.items():
            second[peer].ask(**request)
        for number in range(1, self.rounds + 1):
            for peer, (task, _, setting, request) in chosen.items():
                pair = [self.peers[peer], second[peer]]
                for one in pair:
                    one.tell(**request)
                answers = [one.read() for one in pair]
                if all("failed" not in answer for answer in answers):
                    mean = {key: statistics.fmean(answer[key] for answer in answers) for key in ("cpu_s", "wall_s")}
                    self.note(number, task, peer, setting, {**answers[0], **mean}, processes=2)
        for one in second.values():
            one.end()

    def end(self):
        for peer in [*self.peers.values(), self.all_cores]:
            peer.end()


def load():
    try:
        return f"{os.getloadavg()[0]:.1f}"
    except OSError:
        return "unknown"


def processor():
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or "unknown"
    return next((line.split(": ")[1] for line in lines if line.startswith("model name")), "unknown")


def main(cases, out, rounds=5):
    cases, out = Path(cases).resolve(), Path(out)
    before = load()
    comparison = Comparison(cases, int(rounds))
    comparison.measure()
    comparison.end()
    out.mkdir(parents=True, exist_ok=True)
    with (out / "environments.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, comparison.rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(comparison.rows)
    (out / "environments.md").write_text(tables.markdown(comparison.rows, WANTED_MM))
    facts = {
        "processor": processor(), "cores": os.cpu_count(), "load": [before, load()], "rounds": comparison.rounds,
        "versions": comparison.versions, "skipped": comparison.skipped, "limit_apart_m": comparison.apart_m,
    }  # fmt: skip
    (out / "environments.yaml").write_text(json.dumps(facts, indent=1) + "\n")
    print(f"environments: {out / 'environments.md'}")


if __name__ == "__main__":
    main(*sys.argv[1:4])
