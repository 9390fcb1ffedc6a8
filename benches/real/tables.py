"""Tables of `make real`: errors of the calibrated models beside other models, and where they err. Millimetres throughout."""

import csv
import json
import math
from pathlib import Path

#: Names in calibration.json, and columns of summary.csv.
MODELS = {
    "this model, fitted": "rod",
    "this model, as given": "as_given",
    "constant curvature": "constant_curvature",
    "linear regression": "linear",
    "quadratic regression": "quadratic",
    "Gaussian process": "gaussian_process",
}
#: The same as headings.
HEADINGS = ["rod", "rod, as given", "constant curvature", "linear", "quadratic", "Gaussian process"]


def read(path):
    """Rows of a CSV file."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write_csv(path, rows):
    """Rows to a CSV file; all have the keys of the first."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def markdown(header, rows):
    """A table; all but the first column are aligned to the right."""
    lines = [header, ["---"] + ["---:"] * (len(header) - 1)] + rows
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def mm(size_m):
    """Millimetres, with two decimals; empty where there is no number."""
    return "" if size_m is None or math.isnan(size_m) else f"{1e3 * size_m:.2f}"


def cell(text):
    """A length of a table on a page: one decimal, none from 100 mm on."""
    if text in ("", None):
        return "–"
    size = float(text)
    return f"{size:.0f}" if size >= 100 else f"{size:.1f}"


def findings(folder):
    """The calibration's own findings."""
    return json.loads((Path(folder) / "calibration.json").read_text(encoding="utf-8"))


def summary_row(robot, found):
    """One row of summary.csv."""
    held = found["held_out"]
    row = {
        "robot": robot.title,
        "points": " ".join(held["points"]),
        "numbers_fitted": len(found["numbers"]),
        "fitted_positions": found["positions"],
        "held_out_positions": held["positions"],
        "held_out": held["how"],
    }
    models = {model["name"]: model for model in held["models"]}
    for size, end in (("rms_m", "_mm"), ("rms_without_mean_m", "_without_mean_mm")):
        row.update({name + end: mm(models.get(model, {}).get(size)) for model, name in MODELS.items()})
    row["fitted_rows_mm"] = mm(found["after_m"])
    row["noise_mm"] = mm((found["noise"] or {}).get("noise_m"))
    return row


def summary_page(rows):
    """summary.csv as a table of a page."""
    header = ["robot", "numbers", "held-out positions", *HEADINGS, "noise"]
    cells = [
        [row["robot"], str(row["numbers_fitted"]), str(row["held_out_positions"])]
        + [f"{cell(row[f'{name}_mm'])} ({cell(row[f'{name}_without_mean_mm'])})" for name in MODELS.values()]
        + [cell(row["noise_mm"])]
        for row in rows
    ]
    return markdown(header, cells)


def points_page(found):
    """Held-out error of each tracked point under each model."""
    held = found["held_out"]
    rows = [
        [model["name"], str(model["numbers"] or "–"), cell(mm(model["rms_m"])), cell(mm(model["rms_without_mean_m"]))]
        + [cell(mm(size)) for size in model["by_point_m"]]
        for model in held["models"]
    ]
    return markdown(["rms error on unseen positions, mm", "numbers", "all", "all, mean error off", *held["points"]], rows)


def numbers_page(rows):
    """What was fitted, and how sure it is."""
    def size(text):
        return f"{float(text):.4g}" if text not in ("", "inf", "-inf") else "–"

    cells = [
        [f"`{row['name']}`", row["unit"], size(row["start"]), size(row["value"])]
        + [f"{size(row['low'])} to {size(row['high'])}" if row["determined"] == "true" else "not determined"]
        for row in rows
    ]
    return markdown(["number", "unit", "start", "value", "95 % interval"], cells)


def weight_row(true_g, found):
    """One row of weights.csv: the weight, and what `discover` told of it. Grams; empty where no load was told."""
    told = next((effect for effect in found["effects"] if effect["name"] == "tip_load"), None)
    grams = [told["parameters"]["mass_kg"], *told["interval_95"]["mass_kg"]] if told else []
    cells = [f"{1e3 * mass_kg:.0f}" for mass_kg in grams] or [""] * 3
    joint = " or " if found["verdict"] == "ambiguous" else " and "
    names = joint.join(effect["name"] for effect in found["effects"])
    row = {"true_g": true_g, "verdict": found["verdict"], "named": names}
    return row | dict(zip(("told_g", "low_g", "high_g"), cells))


def weights_page(rows):
    """weights.csv as a table of a page."""
    cells = [
        [f"{row['true_g']} g", row["verdict"], row["named"] or "–", row["told_g"] or "–"]
        + [f"{row['low_g']} to {row['high_g']}" if row["told_g"] else "–"]
        for row in rows
    ]
    return markdown(["true", "verdict", "named", "told, g", "95 % interval, g"], cells)


def errors(measured, simulated, held):
    """Errors of the rows whose pattern `held` accepts: a list of pattern, point, measured place and simulated minus measured."""
    names = [name[:-4] for name in measured[0] if name.endswith("_x_m")]
    found = []
    for row, model in zip(measured, simulated):
        if not held(row["pattern"]):
            continue
        for name in names:
            at = [float(row[f"{name}_{axis}_m"]) for axis in "xyz"]
            said = [float(model[f"{name}_{axis}_m"] or "nan") for axis in "xyz"]
            if all(math.isfinite(x) for x in at + said):
                error = [model_at - seen for model_at, seen in zip(said, at)]
                found.append((row["pattern"], name.removeprefix("point_"), at, error))
    return found


def fitted_errors(residuals):
    """The same of the rows that were fitted, from residuals.csv."""

    def three(row, name):
        return [float(row[f"{name}{axis}_m"] or "nan") for axis in "xyz"]

    all_rows = [(row["block"], row["point"], three(row, ""), three(row, "error_")) for row in residuals]
    return [row for row in all_rows if all(math.isfinite(x) for x in row[3])]


def rms_m(rows):
    """Root mean square length of the errors."""
    return math.sqrt(sum(sum(x * x for x in row[3]) for row in rows) / len(rows))


def kind(pattern):
    """The kind of motion: the label without its repetition, direction and level."""
    parts = [part for part in pattern.split("_") if not part.startswith(("rep", "dir", "u0", "id"))]
    return " ".join(parts)


#: Thirds of the positions by distance from the middle, in the order of the table.
THIRDS = ("third nearest to the middle", "middle third", "third farthest out")


def thirds(rows):
    """Third of each row by the distance of its point from the point's mean place."""
    mean = {}
    for point in {row[1] for row in rows}:
        own = [row[2] for row in rows if row[1] == point]
        mean[point] = [sum(column) / len(own) for column in zip(*own)]
    far = {point: sorted(math.dist(row[2], mean[point]) for row in rows if row[1] == point) for point in mean}

    def third(row):
        own = far[row[1]]
        rank = sum(distance < math.dist(row[2], mean[row[1]]) for distance in own)
        return THIRDS[min(3 * rank // len(own), 2)]

    return third


def groups(rows):
    """Errors by point, kind of motion and place: rows of where.csv."""
    out = []
    for what, of in (("point", lambda row: row[1]), ("motion", lambda row: kind(row[0])), ("place", thirds(rows))):
        names = THIRDS if what == "place" else list(dict.fromkeys(of(row) for row in rows))
        if what == "motion" and len(names) == 1:
            continue
        for name in names:
            own = [row for row in rows if of(row) == name]
            mean = [sum(row[3][axis] for row in own) / len(own) for axis in range(3)]
            out.append(
                {"by": what, "name": name, "positions": len(own), "rms_mm": mm(rms_m(own))}
                | {f"mean_{axis}_mm": mm(mean[k]) for k, axis in enumerate("xyz")}
            )
    return out


def where_page(rows):
    """where.csv as a table of a page."""
    cells = [
        [f"{row['by']}: {row['name']}", str(row["positions"]), cell(row["rms_mm"])]
        + [", ".join(f"{float(row[f'mean_{axis}_mm']):.1f}" for axis in "xyz")]
        for row in rows
    ]
    return markdown(["where", "positions", "rms error, mm", "mean error x, y, z, mm"], cells)
