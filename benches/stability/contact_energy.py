"""Check of contact.py: least energy of a discrete rod with its nodes outside the obstacle, by an augmented Lagrangian.

Segments have a turn theta, a stretch and a shear each; bending acts between neighbours (and half a segment at the clamp).
Newton's method on the energy; second order in the segment's length. Prints what differs from the CSV files.
"""

import csv
import sys

import numpy as np

from contact import CENTRE_M, CIRCLE_M, PLANE_X_M
from planar_rod import OUT, R0


class Discrete:
    def __init__(self, rod, segments):
        self.rod, self.n, self.h = rod, segments, rod.length_m / segments

    def places(self, y):
        theta, e, g = y.reshape(3, -1)
        sin, cos = np.sin(theta), np.cos(theta)
        dx, dz = (1 + e) * sin + g * cos, (1 + e) * cos - g * sin
        return self.h * np.cumsum(dx), self.h * np.cumsum(dz), (sin, cos, dx, dz)

    def rest(self, tip, line, obstacle):
        """obstacle(x, z) gives gaps, their first derivatives (2 x n) and second ones (xx, xz, zz)."""
        n, h, rod = self.n, self.h, self.rod
        y, push = np.zeros(3 * n), np.zeros(n)
        load = np.full(n, line * h)
        load[-1] = line * h / 2 + tip
        bend = rod.bending_n_m2 / h * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
        bend[0, 0] += rod.bending_n_m2 / h
        bend[-1, -1] -= rod.bending_n_m2 / h
        sums = np.tril(np.ones((n, n)))
        elastic = np.zeros((3 * n, 3 * n))
        elastic[:n, :n] = bend
        for part, stiff in ((1, rod.stretch_n), (2, rod.shear_n)):
            elastic[part * n : (part + 1) * n, part * n : (part + 1) * n] = h * stiff * np.eye(n)
        stiff = 3e4

        def whole(y, second=True):
            x, z, (sin, cos, dx, dz) = self.places(y)
            gap, first, curved = obstacle(x, z)
            force = np.maximum(push - stiff * gap, 0.0)
            energy = 0.5 * y @ elastic @ y - load @ x + (force**2).sum() / (2 * stiff)
            fx, fz = -load - force * first[0], -force * first[1]
            # Jacobians of x and z by theta, e, g of each segment, before the sums along the rod.
            jx, jz = np.stack([dz, sin, cos]), np.stack([-dx, cos, -sin])
            up_x, up_z = np.cumsum(fx[::-1])[::-1], np.cumsum(fz[::-1])[::-1]
            slope = elastic @ y + h * (jx * up_x + jz * up_z).ravel()
            if not second:
                return energy, slope, force
            active = force > 0
            kxx = active * stiff * first[0] ** 2 - force * curved[0]
            kxz = active * stiff * first[0] * first[1] - force * curved[1]
            kzz = active * stiff * first[1] ** 2 - force * curved[2]
            full_x = np.hstack([h * sums * j for j in jx])
            full_z = np.hstack([h * sums * j for j in jz])
            curve = elastic + full_x.T @ (kxx[:, None] * full_x + kxz[:, None] * full_z)
            curve += full_z.T @ (kzz[:, None] * full_z + kxz[:, None] * full_x)
            i = np.arange(n)
            curve[i, i] += h * (-dx * up_x - dz * up_z)
            for part, value in ((1, cos * up_x - sin * up_z), (2, -sin * up_x - cos * up_z)):
                curve[i, part * n + i] += h * value
                curve[part * n + i, i] += h * value
            return energy, slope, curve

        def settle(y):
            for _ in range(200):
                energy, slope, curve = whole(y)
                if abs(slope).max() < 1e-12:
                    break
                step = np.linalg.solve(curve, -slope)
                if step @ slope > 0:
                    step = np.linalg.solve(curve + 1e-2 * np.diag(np.diag(elastic)), -slope)
                size = min(1.0, 0.3 / abs(step).max())
                while whole(y + size * step, False)[0] > energy + 1e-14 and size > 1e-6:
                    size *= 0.5
                y = y + size * step
            return y

        for part in np.linspace(0.1, 1, 10):
            load = load / load[-1] * (line * h / 2 + tip) * part
            y = settle(y)
        for _ in range(60):
            y = settle(y)
            new = whole(y, False)[2]
            change, push = abs(new - push).max(), new
            if change < 1e-9:
                break
        x, z, _ = self.places(y)
        gap, first, _ = obstacle(x, z)
        at = h * (np.arange(n) + 1)
        total = np.array([push @ first[0], push @ first[1]])
        return x, z, push, at, total, gap


def plane(x, z):
    nothing = np.zeros_like(x)
    return x - PLANE_X_M, np.stack([nothing + 1, nothing]), (nothing, nothing, nothing)


def circle(x, z):
    a, b = x - CENTRE_M[0], z - CENTRE_M[1]
    r = np.hypot(a, b)
    return r - CIRCLE_M, np.stack([a / r, b / r]), (b * b / r**3, -a * b / r**3, a * a / r**3)


def main(segments):
    for name, obstacle in (("contact_plane.csv", plane), ("contact_cylinder.csv", circle)):
        for row in csv.DictReader((OUT / name).read_text().splitlines()):
            tip, line = float(row["tip_force_x_n"]), float(row.get("line_force_x_n_m", 0))
            # Only nodes touch: on the cylinder take a number of segments that has a node where the rod touches.
            count = segments
            if row.get("contact_s_m"):
                share = float(row["contact_s_m"]) / R0.length_m
                count = min(range(segments, 2 * segments), key=lambda n: abs(n * share - round(n * share)))
            x, z, push, at, total, gap = Discrete(R0, count).rest(tip, line, obstacle)
            touching = at[push > 1e-9]
            where = (push @ at / push.sum() if obstacle is circle else touching[0]) if len(touching) else None
            off = [x[-1] - float(row["tip_x_m"]), z[-1] - float(row["tip_z_m"])]
            print(
                name, tip, line, row["contact"], "tip off m", *(f"{v:.2e}" for v in off), "force", np.hypot(*total),
                row["contact_force_n"], "start or s", where, row.get("contact_start_m", row.get("contact_s_m")),
                "nodes", len(touching), "gap", f"{gap.min():.1e}", flush=True,
            )  # fmt: skip


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 300)
