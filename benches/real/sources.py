"""The measured files: who publishes them, where, and under which licence. None of them is part of this repository."""

import sys
from pathlib import Path


class Source:
    """Files of one laboratory, at one revision of its repository."""

    def __init__(self, publisher, repository, revision, licence, files):
        self.publisher = publisher
        self.repository = repository
        self.revision = revision
        self.licence = licence
        #: Path below REAL_DATA, and where it is published.
        self.files = files

    def words(self):
        """Repository, revision and licence, in one line."""
        return f"{self.publisher}, {self.repository} at {self.revision}, {self.licence}"


_OPENCR = "data/sysid/ftdcr_{0}/{1}_analysis/{1}_train.csv"
_RUNS = {"v4": "tdcr_sysid_20260511-183002", "v6": "tdcrv6_sysid_20260406-181730"}

SOURCES = {
    robot: Source(
        "Continuum Robotics Laboratory, University of Toronto",
        "https://github.com/ContinuumRoboticsLab/opencr-mujoco",
        "17fff8b",
        "MIT licence",
        {
            f"opencr/{robot}_train.csv": _OPENCR.format(robot, _RUNS[robot]),
            f"opencr/ftdcr_{robot}_geometry.json": f"the geometry of ftdcr_{robot}, below data/sysid",
        },
    )
    for robot in _RUNS
}
SOURCES["trunk"] = Source(
    "Autonomous Systems Laboratory, Stanford University",
    "https://github.com/StanfordASL/trunk-stack",
    "8b4b9234",
    "MIT licence",
    {
        "trunk/0g.csv": "every tenth row of observations_controlled_1.csv, with the commands of control_inputs_controlled_1.csv, "
        "below servo_motor_archive",
        "trunk/100g.csv": "the same of the run with 100 g at the tip",
    },
)
SOURCES["tentacle"] = Source(
    "Physical Human-robot interaction and Soft Robotics, TU Delft",
    "https://github.com/tud-phi/soromox",
    "4f03054a",
    "MIT licence",
    {"tentacle/static_shapes.csv": "mean marker positions of each file in paper_results/secVa_system_identification/data"},
)


def check(folder):
    """Stops with status 2 when a file is missing below `folder`, and says who publishes it."""
    missing = [
        f"  {path}\n    published by {source.publisher} ({source.licence})\n"
        f"    {source.repository}, revision {source.revision}: {origin}"
        for source in SOURCES.values()
        for path, origin in source.files.items()
        if not (Path(folder) / path).is_file()
    ]
    if missing:
        print(
            f"found no measured files of these robots in REAL_DATA={folder}, expected:\n" + "\n".join(missing),
            file=sys.stderr,
        )
        sys.exit(2)
