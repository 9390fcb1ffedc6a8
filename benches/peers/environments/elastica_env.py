"""PyElastica: the rod of `benches/peers/elastica_rod.py` under tensions that are held for a while."""

import sys
from pathlib import Path

import numpy as np
import worker

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import elastica_rod  # noqa: E402

# A held tension changes within this time, s: the table that the rod reads has straight lines.
EDGE_S = 1e-4


def tensions(values, row_s, setting):
    elements, dt_s, inertia_factor = setting
    case = worker.case("paper_tension")
    rows = round(row_s / EDGE_S)
    held = np.repeat(np.array(values), rows, axis=0)
    case["times_s"] = (EDGE_S * np.arange(len(held))).tolist()
    case["values"] = held.tolist()
    case["sample_s"] = 0.05
    case["samples"] = round(row_s * (len(values) - 1) / 0.05) + 1
    found, times = worker.timed(lambda: elastica_rod.timed(case, elements, dt_s, inertia_factor))
    if found["status"] != "ok":
        raise ArithmeticError(found["status"])
    # Coming to rest before is not counted; the wall clock has it.
    return {**times, "cpu_s": found["cpu_s"], "simulated_s": found["simulated_s"], "tips_m": found["tips_m"]}


if __name__ == "__main__":
    worker.serve({"tensions": tensions}, ["pyelastica", "numpy"])
