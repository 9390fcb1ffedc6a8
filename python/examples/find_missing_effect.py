"""What does the model lack? Compare it with a recording in a pandas frame."""

import numpy as np
import pandas as pd

import spinebench as sb

model = sb.Model()

# A "real" robot that carries 20 g more than the model knows, recorded with 0.3 mm of tracking noise.
rng = np.random.default_rng(3)
trials = []
for trial in range(8):
    bend = np.clip(np.cumsum(rng.uniform(-0.006, 0.006, (16, 2)), axis=0), -0.015, 0.015)
    bend[0] = 0.0
    frame = pd.DataFrame(np.column_stack([bend, -bend]), columns=[f"tendon_{i}_m" for i in range(1, 5)])
    frame.insert(0, "time_s", 0.2 * np.arange(16))
    frame.insert(0, "trial", trial)
    trials.append(frame)
commands = pd.concat(trials, ignore_index=True)
robot = model.with_effects([{"tip_load": {"mass_kg": 0.02}}])
measured = sb.simulate(robot, commands, noise_m=3e-4)
measured = measured[[*commands.columns, "tip_x_m", "tip_y_m", "tip_z_m"]]

found = sb.discover(model, measured)
print(found.verdict, "-", found.summary)
for effect in found.effects:
    print(f"{effect.name}: {effect.parameters}, 95 % interval {effect.interval_95}")
print(f"held-out error: {1e3 * found.before_m:.2f} mm before, {1e3 * found.after_m:.2f} mm after")
print(found.candidates[["name", "score", "after_m"]].head())
