"""Recordings of `spinebench` from the files that the laboratories publish. Lengths in metres, angles in radians."""

import csv
import math
from pathlib import Path

#: Rows of the trunk's files that are left out between two that are used: 0.4 s between rows.
TRUNK_STEP = 4
#: The first half of the trunk's run ends here, seconds.
TRUNK_HALF_S = 75.0
#: Levels of motors 1 and 2 of the tentacle in its file names: m1_u015 is motor 1 at 0.15.
TENTACLE_BOTH = {
    "m12_u00050010": (0.05, 0.1),
    "m12_u001": (0.1, 0.1),
    "m12_u00100005": (0.1, 0.05),
    "m12_u001002": (0.1, 0.2),
    "m12_u0015002": (0.15, 0.2),
    "m12_u002": (0.2, 0.2),
    "m12_u002001": (0.2, 0.1),
    "m12_u0020015": (0.2, 0.15),
}
#: Tension of a motor is its level over this radius (their code).
TENTACLE_PULLEY_M = 0.0325
#: The tentacle's base beside its marker, in the tracker's axes y and z.
TENTACLE_BASE_M = (-0.03, -0.013)


def _rows(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _write(path, header, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def ftdcr(sources, target):
    """FTDCR v4 or v6: displacements of the servos (mm, in the order of the tendons), tip (mm), Unix time. Rows whose times do
    not increase are 10 ms apart: a pose at rest has no use for them. The rest at the end of a motion belongs to it. Each file
    is a trial; patterns of the second, which its publisher keeps apart, begin with `val_`."""
    servos = [name for name in _rows(sources[0])[0] if name.startswith("servo_")]
    header = ["trial", "time_s"] + [f"tendon_{k + 1}_m" for k in range(len(servos))]
    header += ["tip_x_m", "tip_y_m", "tip_z_m", "pattern"]
    out = []
    for trial, (source, prefix) in enumerate(zip(sources, ("", "val_"))):
        rows = _rows(source)
        begin, last = float(rows[0]["timestamp"]), -1.0
        for row in rows:
            time = float(row["timestamp"]) - begin
            last = time if time > last else last + 0.01
            lengths = [f"{float(row[name]) / 1e3:.9f}" for name in servos + ["tip_x", "tip_y", "tip_z"]]
            out.append([trial, f"{last:.6f}"] + lengths + [prefix + row["pattern_label"].replace("_hold", "")])
    _write(target, header, out)


def trunk(sources, target, halves=True):
    """The trunk: measured servo angles (degrees), three disks (m; y points up, z of the model down). The `halves` of the run are
    its patterns."""
    rows = _rows(sources[0])[::TRUNK_STEP]
    header = ["trial", "time_s"] + [f"drive_servo_{k}_rad" for k in range(1, 7)] + ["tip_x_m", "tip_y_m", "tip_z_m"]
    header += [f"point_disk{disk}_{axis}_m" for disk in (1, 2) for axis in "xyz"] + ["pattern"] * halves
    begin, out = float(rows[0]["t"]), []
    for row in rows:
        time = float(row["t"]) - begin
        angles = [f"{math.radians(float(row[f'phi{k}'])):.8f}" for k in range(1, 7)]
        places = [[row[f"x{d}"], row[f"z{d}"], f"{-float(row[f'y{d}']):.6f}"] for d in (3, 1, 2)]
        half = ["early" if time < TRUNK_HALF_S else "late"] * halves
        out.append([0, f"{time:.3f}"] + angles + sum(places, []) + half)
    _write(target, header, out)


def tentacle_levels(name):
    """Levels of both motors from the name of a file."""
    if name in TENTACLE_BOTH:
        return TENTACLE_BOTH[name]
    motor, digits = name[1], name.split("_u")[1]
    level = float(f"{digits[0]}.{digits[1:]}")
    return (level, 0.0) if motor == "1" else (0.0, level)


def tentacle(sources, target):
    """The tentacle: mean places of four markers (m) under two tensions, the base at the origin. The tracker's y runs along the
    hanging tentacle, which is z of the model; its z is the model's x."""
    header = ["trial", "time_s", "tendon_1_n", "tendon_2_n"]
    header += [f"point_p{k}_{axis}_m" for k in (1, 2, 3, 4) for axis in "xyz"] + ["pattern"]
    out = []
    for number, row in enumerate(_rows(sources[0])):
        name = Path(row["file"]).stem
        tensions = [f"{level / TENTACLE_PULLEY_M:.6f}" for level in tentacle_levels(name)]

        def at(marker):
            return [float(row[f"{marker}_{axis}"]) for axis in "zxy"]

        across, beside, along = at("pb")
        base = (across, beside + TENTACLE_BASE_M[0], along + TENTACLE_BASE_M[1])
        places = [f"{x - zero:.6f}" for k in (1, 2, 3, 4) for x, zero in zip(at(f"p{k}"), base)]
        out.append([0, number] + tensions + places + [name])
    _write(target, header, out)
