"""Simulate a robot at rest and in motion, and plot its shape."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import spinebench as sb

model = sb.Model()
rod = sb.Rod(model)
figure, (side, motion) = plt.subplots(1, 2, figsize=(9, 3.5))
for pull in (0.0, 0.005, 0.010, 0.015):
    rod.settle([pull, 0, -pull, 0])
    shape = rod.shape(60)
    side.plot(1e3 * shape[:, 2], 1e3 * shape[:, 0], label=f"{1e3 * pull:.0f} mm")
side.set(xlabel="z (mm)", ylabel="x (mm)", title="at rest, by pull of tendon 1")
side.legend()

# Sixteen robots of different stiffness follow the same command, on all cores.
path = "robot.backbone.youngs_modulus_pa"
scales = np.linspace(0.7, 1.3, 16)
rods = sb.Rods([model.with_value(path, scale * model.value(path)) for scale in scales])
pulls = np.zeros((16, 40, 4))
pulls[:, :20, 0], pulls[:, :20, 2] = 0.01, -0.01
tips = rods.play(pulls, dt_s=0.05)
motion.plot(0.05 * np.arange(1, 41), 1e3 * tips[:, :, 0].T, color="tab:blue", alpha=0.5)
motion.set(xlabel="time (s)", ylabel="tip x (mm)", title="step of 1 s, 16 robots")
figure.tight_layout()
figure.savefig("shape.png", dpi=120)
print("tips range from", np.round(1e3 * np.nanmin(tips[:, :, 0]), 1), "to", np.round(1e3 * np.nanmax(tips[:, :, 0]), 1), "mm")
print("wrote shape.png")
