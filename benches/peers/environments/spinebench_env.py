"""spinebench: its environments, alone and as a vector, and the same commands without Python between the steps."""

import tempfile
from pathlib import Path

import gymnasium
import numpy as np
import pandas as pd
import worker

import spinebench as sb

# Fine in space and in time: what errors are measured against.
FINE = (
    "{cell_m: 0.005, bending_modes: 12, torsion_modes: 8, shear_modes: 8, axial_modes: 8, motion_tolerance_m: .inf, "
    "scheme: sdirk2, time_step_s: TIME_STEP_S}"
)
STEP_S = 0.2
ENDLESS = {"max_steps": 10**9, "within_m": None, "action": "tendons"}
#: Steps between two changes from one way of calling to the other.
BLOCK = 250


def gridded(text, resolution):
    """The model with a resolution of its own; none is the shipped grid."""
    if resolution:
        text = text.replace("\neffects:", f"\n  resolution: {resolution}\neffects:")
    return sb.Model.from_yaml(text)


def fine(text, time_step_s):
    return gridded(text, FINE.replace("TIME_STEP_S", str(time_step_s)))


def limit(model_text, pulls):
    """Tips at the limit of fine grids and steps, and how far twice the steps are from them, metres."""
    pulls = np.array([pulls])
    tips, coarser = (sb.Rods([fine(model_text, step_s)]).play(pulls, STEP_S)[0] for step_s in (0.0005, 0.001))
    apart = np.linalg.norm(tips - coarser, axis=1)
    return {"tips_m": tips.tolist(), "apart_m": float(np.sqrt((apart**2).mean()))}


class Environments:
    """Environments, made when they are first asked for."""

    def __init__(self):
        self.made = {}

    def alone(self, key, **options):
        if key not in self.made:
            self.made[key] = gymnasium.make("spinebench/Reach-v0", disable_env_checker=True, **options, **ENDLESS)
        self.made[key].reset(seed=0)
        return self.made[key]

    def vector_of(self, robots):
        if robots not in self.made:
            self.made[robots] = gymnasium.make_vec(
                "spinebench/Reach-v0", num_envs=robots, vectorization_mode="vector_entry_point", **ENDLESS
            )
        self.made[robots].reset(seed=0)
        return self.made[robots]

    def steps(self, actions, model_text, setting):
        """Environment steps of one robot through Gymnasium."""
        env = self.alone(setting, model=gridded(model_text, setting))
        actions = np.array(actions, dtype=np.float32)
        tips = []

        def run():
            for action in actions:
                tips.append(env.step(action)[4]["tip_m"])

        _, times = worker.timed(run)
        return {**times, "steps": len(actions), "tips_m": np.array(tips).tolist()}

    def overhead(self, actions, many):
        """Environment steps of a robot whose own arithmetic is next to nothing: what Python and Gymnasium cost."""
        if "overhead" not in self.made:
            plant = Path(tempfile.mkdtemp()) / "plant.yaml"
            plant.write_text("constant_curvature: {}\n")
            self.alone("overhead", plant=plant)
            plant.unlink()
            plant.parent.rmdir()
        env = self.alone("overhead")
        actions = np.array(actions, dtype=np.float32)

        def run():
            for _ in range(many):
                for action in actions:
                    env.step(action)

        _, times = worker.timed(run)
        return {**times, "steps": many * len(actions)}

    def vector(self, actions, robots):
        """Steps of a vector of robots, then the same commands without Python in between."""
        env = self.vector_of(robots)
        actions = [np.tile(np.array(action, dtype=np.float32), (robots, 1)) for action in actions]
        seen = []

        def run():
            for action in actions:
                seen.append(env.step(action)[4]["pulls_m"])

        _, stepped = worker.timed(run)
        rods = sb.Rods([sb.Model()] * robots)
        rods.settle(np.zeros((robots, 4)))
        pulls = np.array(seen).transpose(1, 0, 2).copy()
        _, played = worker.timed(lambda: rods.play(pulls, STEP_S))
        steps = robots * len(actions)
        return {"stepped": {**stepped, "steps": steps}, "played": {**played, "steps": steps}}


def call(pulls, many):
    """Calls of `Rod.step`, and the same steps of which one call asks for many; by turns, so that both see the same computer."""
    pulls = np.array(pulls * many)
    rod, rods = sb.Rod(sb.Model()), sb.Rods([sb.Model()])
    rod.settle(np.zeros(4))
    rods.settle(np.zeros((1, 4)))
    sums = {"stepped": {"cpu_s": 0.0, "wall_s": 0.0}, "played": {"cpu_s": 0.0, "wall_s": 0.0}}
    for start in range(0, len(pulls), BLOCK):
        part = pulls[start : start + BLOCK]
        batch = part[np.newaxis].copy()
        _, stepped = worker.timed(lambda part=part: [rod.step(row, STEP_S) for row in part])
        _, played = worker.timed(lambda batch=batch: rods.play(batch, STEP_S))
        for name, times in (("stepped", stepped), ("played", played)):
            for key, value in times.items():
                sums[name][key] += value
    return {name: {**times, "steps": len(pulls)} for name, times in sums.items()}


def tensions(model_text, values, row_s, setting):
    """A robot under tensions that are held for `row_s`, and its tips every 0.05 s; without a setting, the limit."""
    model = fine(model_text, 0.0005) if setting is None else gridded(model_text, setting)
    frame = pd.DataFrame(values, columns=[f"tendon_{i}_n" for i in range(1, 5)])
    frame.insert(0, "time_s", row_s * np.arange(len(frame)))
    frame.insert(0, "trial", 0)
    found, times = worker.timed(lambda: sb.simulate(model, frame))
    each = round(0.05 / row_s)
    tips = found[["tip_x_m", "tip_y_m", "tip_z_m"]].to_numpy()[::each]
    return {**times, "simulated_s": row_s * (len(frame) - 1), "tips_m": tips.tolist()}


if __name__ == "__main__":
    own = Environments()
    tasks = {
        "limit": limit, "steps": own.steps, "overhead": own.overhead, "vector": own.vector, "call": call,
        "tensions": tensions,
    }  # fmt: skip
    worker.serve(tasks, ["spinebench", "gymnasium", "numpy"])
