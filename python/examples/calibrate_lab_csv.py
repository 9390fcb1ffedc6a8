"""Calibrate a model from a laboratory's CSV: other names, millimetres, y up, semicolons and decimal commas."""

import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

import spinebench as sb

model = sb.Model()
modulus = "robot.backbone.youngs_modulus_pa"

# The laboratory's file; here it is made from a robot that is 12 % stiffer.
rng = np.random.default_rng(0)
bend = rng.uniform(-0.012, 0.012, (40, 2))
poses = pd.DataFrame(np.column_stack([bend, -bend]), columns=[f"tendon_{i}_m" for i in range(1, 5)])
poses.insert(0, "time_s", np.arange(40.0))
poses.insert(0, "trial", 0)
seen = sb.simulate(model.with_value(modulus, 1.12 * model.value(modulus)), poses, static=True, noise_m=5e-4)
lab = pd.DataFrame({f"motor{i} [mm]": 1e3 * poses[f"tendon_{i}_m"] for i in range(1, 5)})
lab["px [mm]"], lab["py [mm]"], lab["pz [mm]"] = -1e3 * seen.tip_y_m, 1e3 * seen.tip_x_m, 1e3 * seen.tip_z_m
file = Path(tempfile.mkdtemp()) / "lab.csv"
lab.to_csv(file, sep=";", decimal=",", index=False)

# Read it, and give its columns the names, units and axes of a recording: x up, z along the straight robot.
read = pd.read_csv(file, sep=";", decimal=",")
recording = pd.DataFrame({"trial": 0, "time_s": np.arange(float(len(read)))})
for i in range(1, 5):
    recording[f"tendon_{i}_m"] = 1e-3 * read[f"motor{i} [mm]"]
recording["tip_x_m"], recording["tip_y_m"] = 1e-3 * read["py [mm]"], -1e-3 * read["px [mm]"]
recording["tip_z_m"] = 1e-3 * read["pz [mm]"]

found = sb.calibrate(model, recording, fit=[modulus], static=True)
for number in found.numbers:
    print(f"{number.name}: {number.value:.4g} {number.unit}, 95 % interval {number.low:.4g} to {number.high:.4g}")
print(f"rms error: {1e3 * found.before_m:.2f} mm before, {1e3 * found.after_m:.2f} mm after")
found.model.save(file.with_name("model.yaml"))
