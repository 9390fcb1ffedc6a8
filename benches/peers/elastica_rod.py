"""PyElastica: the robot as its Cosserat rod, with tendons under given tensions as a forcing class.

usage: elastica_rod.py CASE.json RUNS.json
The case comes from the benchmark: robot, tensions, sample times, and settings [elements, time step, factor on the
rotary inertia]. The runs go back to it. docs/evidence/peers.md says what PyElastica cannot do of the full robot.
"""

import json
import sys
import time
from importlib.metadata import version

import elastica as ea
import numpy as np
from numba import njit

# Time to come to rest before the drive starts, s, and the damping rate meanwhile, 1/s (critical for the first mode).
SETTLE_S = 0.5
SETTLING_RATE = 50.0


@njit(cache=True)
def tension_at(table, step_s, now, out):
    """Straight lines between the rows of a table with equal steps."""
    place = min(max(now / step_s, 0.0), table.shape[0] - 1.0)
    row = min(int(place), table.shape[0] - 2)
    share = place - row
    for i in range(table.shape[1]):
        out[i] = (1 - share) * table[row, i] + share * table[row + 1, i]


@njit(cache=True)
def pull(position, director, forces, torques, tensions, offsets):
    """Tendons on straight lines from eye to eye, one eye an element and one at each end: at every eye the tension
    pulls along both sides. The force goes to the element's two nodes, its moment to the element."""
    n = director.shape[2]
    eyes = np.empty((n + 2, 3))
    force = np.empty(3)
    local = np.empty(3)
    for i in range(tensions.shape[0]):
        if tensions[i] == 0.0:
            continue
        for eye in range(n + 2):
            k = min(max(eye - 1, 0), n - 1)
            for a in range(3):
                if eye == 0:
                    centre = position[a, 0]
                elif eye == n + 1:
                    centre = position[a, n]
                else:
                    centre = 0.5 * (position[a, k] + position[a, k + 1])
                # Rows of the director are the body axes.
                eyes[eye, a] = centre + director[0, a, k] * offsets[i, 0] + director[1, a, k] * offsets[i, 1]
        for eye in range(1, n + 2):
            k = min(eye - 1, n - 1)
            force[:] = 0.0
            for side in (-1, 1):
                if eye + side > n + 1:
                    continue
                line = eyes[eye + side] - eyes[eye]
                force += tensions[i] * line / np.sqrt(line[0] ** 2 + line[1] ** 2 + line[2] ** 2)
            for a in range(3):
                if eye == n + 1:
                    forces[a, n] += force[a]
                else:
                    forces[a, k] += 0.5 * force[a]
                    forces[a, k + 1] += 0.5 * force[a]
                local[a] = director[a, 0, k] * force[0] + director[a, 1, k] * force[1] + director[a, 2, k] * force[2]
            x, y = offsets[i]
            torques[0, k] += y * local[2]
            torques[1, k] -= x * local[2]
            torques[2, k] += x * local[1] - y * local[0]


class Tendons(ea.NoForces):
    def __init__(self, case, settling):
        super().__init__()
        values = np.array(case["values"])
        self.table = np.repeat(values[:1], 2, axis=0) if settling else values
        self.step_s = case["times_s"][1] - case["times_s"][0]
        self.offsets = np.array(case["offsets_m"])
        self.now = np.empty(self.offsets.shape[0])

    def apply_forces(self, system, time=0.0):
        tension_at(self.table, self.step_s, time, self.now)
        pull(
            system.position_collection, system.director_collection,
            system.external_forces, system.external_torques, self.now, self.offsets,
        )  # fmt: skip


class Simulator(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping):
    pass


def nodes_m(case, n):
    """Where the nodes stand. What is clamped is the middle of the first element, so that is the base: with its first
    node there, the rod would be half an element too stiff and the error of first order."""
    half = 0.5 * case["length_m"] / (n - 0.5)
    return np.linspace(-half, case["length_m"], n + 1)


def mass_per_element(case, n):
    """Mass of the rod in each element."""
    ends = nodes_m(case, n)
    mass = np.zeros(n)
    for span in case["spans"]:
        overlap = np.minimum(ends[1:], span["end_m"]) - np.maximum(ends[:-1], span["start_m"])
        mass += span["mass_kg_m"] * np.maximum(overlap, 0)
    return mass


def build(case, n, inertia_factor, settling, start=None):
    span, places = case["spans"][0], nodes_m(case, n)
    length = places[-1] - places[0]
    radius = case["radius_m"]
    area = np.pi * radius**2
    mass = mass_per_element(case, n)
    rod = ea.CosseratRod.straight_rod(
        n, np.array([0.0, 0.0, places[0]]), np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), length, radius,
        density=mass.sum() / (area * length), youngs_modulus=span["axial_n"] / area,
        shear_modulus=span["shear_n"] / area,
    )  # fmt: skip
    rod.mass[:] = 0.0
    rod.mass[:-1] += 0.5 * mass
    rod.mass[1:] += 0.5 * mass
    # Exactly the stiffnesses of the case; PyElastica has its own shear correction.
    for k, value in enumerate((span["shear_n"], span["shear_n"], span["axial_n"])):
        rod.shear_matrix[k, k, :] = value
    for k, value in enumerate((span["bending_n_m2"], span["bending_n_m2"], span["torsion_n_m2"])):
        rod.bend_matrix[k, k, :] = value
    rod.mass_second_moment_of_inertia[:] *= inertia_factor
    rod.inv_mass_second_moment_of_inertia[:] /= inertia_factor
    if start is not None:
        rod.position_collection[:], rod.director_collection[:] = start
    simulator = Simulator()
    simulator.append(rod)
    simulator.constrain(rod).using(ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    simulator.add_forcing_to(rod).using(ea.GravityForces, acc_gravity=np.array(case["gravity_m_s2"]))
    simulator.add_forcing_to(rod).using(Tendons, case=case, settling=settling)
    if settling:
        simulator.dampen(rod).using(ea.AnalyticalLinearDamper, uniform_damping_constant=SETTLING_RATE, time_step=settling)
    simulator.finalize()
    return simulator, rod


def march(simulator, rod, dt, samples, each):
    """Tips after every `each` steps."""
    stepper = ea.PositionVerlet()
    now = np.float64(0.0)
    tips = [rod.position_collection[:, -1].tolist()]
    for _ in range(samples - 1):
        for _ in range(each):
            now = stepper.step(simulator, now, np.float64(dt))
        tips.append(rod.position_collection[:, -1].tolist())
    return tips


def timed(case, n, dt, inertia_factor):
    each = int(round(case["sample_s"] / dt))
    dt = case["sample_s"] / each
    simulator, rod = build(case, n, inertia_factor, settling=dt)
    march(simulator, rod, dt, int(round(SETTLE_S / case["sample_s"])) + 1, each)
    start = rod.position_collection.copy(), rod.director_collection.copy()
    simulator, rod = build(case, n, inertia_factor, settling=None, start=start)
    began = time.thread_time()
    tips = march(simulator, rod, dt, case["samples"], each)
    spent = time.thread_time() - began
    return {
        "peer": "pyelastica",
        "setting": f"position Verlet, rotary inertia x {inertia_factor:g}",
        "segments": n,
        "dt_s": dt,
        "cpu_s": spent,
        "simulated_s": case["sample_s"] * (case["samples"] - 1),
        "tips_m": np.nan_to_num(np.array(tips), nan=1e9).tolist(),
        "status": "ok" if np.isfinite(tips).all() else "unstable",
    }


def main(case_file, runs_file):
    with open(case_file) as file:
        case = json.load(file)
    runs = [timed(case, *setting) for setting in case["settings"]]
    versions = {"pyelastica": version("pyelastica"), "numpy": np.__version__}
    with open(runs_file, "w") as file:
        json.dump({"versions": versions, "runs": runs}, file)


if __name__ == "__main__":
    main(*sys.argv[1:3])
