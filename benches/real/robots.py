"""The four robots: the model to start from, its recording, and how `spinebench calibrate` is asked."""

import json
import math
from pathlib import Path

import convert

#: Mass of the robot is spread over this many disks.
DISKS = 30
#: v6's owners count its tendons from the opposite side of v4's: a single pull of tendon 1 moves the tip towards -x.
TURNED_DEG = {"v4": 0.0, "v6": 180.0}
#: Markers on the tentacle: distance from the base and offset (their code's numbers).
MARKERS = {
    "p1": (0.1291, [0.0, 0.025, 0.0]),
    "p2": (0.2195, [0.0, -0.021, 0.0]),
    "p3": (0.28, [0.0, 0.02, 0.0]),
    "p4": (0.36, [0.0, 0.0, 0.008]),
}
#: Tendon per servo angle of the trunk to start from, m/rad (models/trunk.yaml).
TRUNK_GAINS = (0.03143, 0.03599, 0.01759, 0.0333, 0.01861, 0.03611)
#: The trunk's tracked points on disks 1 and 2 beyond their centres (models/trunk.yaml), metres.
TRUNK_POINTS = {"disk1": (0.105, [0.0, 0.0, 0.00281]), "disk2": (0.21, [0.0, 0.0, -0.00849])}


class Robot:
    """One robot: what `make real` does with it. `published` is its measured file below REAL_DATA."""

    def __init__(self, name, title, fit, convert, start, published, hold_out=(), kept_apart=None):
        self.name = name
        self.title = title
        #: Numbers that `spinebench calibrate` fits.
        self.fit = fit
        self._convert = convert
        self._start = start
        self._published = published
        #: Options of `spinebench calibrate` that hold rows out of the fit.
        self._hold_out = list(hold_out)
        #: File of rows that its publisher keeps apart: it judges where it is there.
        self._kept_apart = kept_apart

    def _judge(self, data):
        path = Path(data) / self._kept_apart if self._kept_apart else None
        return path if path and path.is_file() else None

    def options(self, data):
        """Options of `spinebench calibrate` beside the files."""
        hold_out = ["--hold-out-patterns", "val_*"] if self._judge(data) else self._hold_out
        return ["--static", "--fit", self.fit, *hold_out]

    def prepare(self, data, work, with_kept_apart=True):
        """Writes the recording and the model to start from into `work`."""
        kept_apart = self._judge(data) if with_kept_apart else None
        files = [path for path in (Path(data) / self._published, kept_apart) if path]
        self._convert(files, Path(work) / f"{self.name}.csv")
        (Path(work) / f"{self.name}_start.yaml").write_text(self._start(Path(data)), encoding="utf-8")


def _points(places):
    each = (f"{name}: {{s_m: {s}, offset_m: {offset}}}" for name, (s, offset) in places.items())
    return f"tracking: {{points: {{{', '.join(each)}}}}}\n"


def _shipped(name):
    """A model of this repository, without its comments."""
    text = (Path("models") / name).read_text(encoding="utf-8")
    return "".join(line + "\n" for line in text.splitlines() if not line.startswith("#"))


def ftdcr_start(data, version):
    """What the owners believe of FTDCR `version`: lengths, angles of the holes, modulus and mass from their geometry file.
    Nothing of what they fitted to forces (tensions) is used, and no measured position."""
    geometry = json.loads((data / f"opencr/ftdcr_{version}_geometry.json").read_text(encoding="utf-8"))
    material = geometry["material_properties"]
    radius = material["outer_radius"]
    stiffness = material["youngs_modulus"] * math.pi / 4 * radius**4
    hole = geometry["actuation_details"]["segments"][0]["distance_to_backbone"]
    lengths = [geometry["segment_lengths"][str(k)] for k in (1, 2, 3)]
    ends = [round(sum(lengths[: k + 1]), 6) for k in range(3)]
    angles = []
    for segment in range(3):
        for tendon in range(3):
            turn = geometry["seg_offsets"][segment] + geometry["tendon_angle_deltas"][segment][tendon]
            angle = math.degrees(turn) + 120.0 * tendon + TURNED_DEG[version]
            angles.append(round(angle % 360.0, 3))
    pieces = "".join(f"      - {{end_m: {end}, bending_stiffness_n_m2: {stiffness:.5f}}}\n" for end in ends)
    each = [0.0003] * 9
    return (
        "robot:\n"
        "  backbone:\n"
        f"    length_m: {ends[-1]}\n"
        f"    radius_m: {radius}\n"
        f"    youngs_modulus_pa: {material['youngs_modulus']:.4e}\n"
        f"    poisson_ratio: {material['poisson_ratio']}\n"
        "    density_kg_m3: 8000\n"
        f"    pieces:\n{pieces}"
        f"  disks: {{count: {DISKS}, mass_kg: {geometry['mass'] / DISKS:.5f}}}\n"
        "  tendons:\n"
        f"    radius_m: {hole}\n"
        f"    radii_m: {[hole] * 9}\n"
        f"    angles_deg: {angles}\n"
        f"    ends_m: {[end for end in ends for _ in range(3)]}\n"
        f"    pretension_m: {each}\n"
        "    compliance_m_per_n: 0.0001\n"
        "  gravity_m_s2: [0.0, 0.0, 0.0]\n"
        f"{HYSTERESIS if version == 'v4' else ''}"
    )


def trunk_start(_data):
    """The shipped model of the trunk, fitted to 63 poses of the first half of the run, with its servos as drives."""
    drives = "".join(
        f"  servo_{k + 1}: {{tendons: [{2 * k + 1}, {2 * k + 2}], gains: [{gain}, {-gain}]}}\n"
        for k, gain in enumerate(TRUNK_GAINS)
    )
    return _shipped("trunk.yaml") + _points(TRUNK_POINTS) + "drives:\n" + drives


def tentacle_start(_data):
    """The shipped shape of the tentacle with the modulus and the density that its owners start from: the shipped ones are fitted
    to half of the shapes, which a cross-validation must not know."""
    text = _shipped("tentacle.yaml")
    for ours, theirs in (("youngs_modulus_pa: 373e3", "youngs_modulus_pa: 505e3"), ("_m3: 1099", "_m3: 1500")):
        assert ours in text, f"models/tentacle.yaml has no `{ours}`"
        text = text.replace(ours, theirs)
    return text + _points(MARKERS)


#: Memory of the backbone of v4, to start from.
HYSTERESIS = "effects:\n  - hysteresis: {share: 1.0, range_rad_m: 0.5}\n"
#: Pose, stiffness and rest shape of each segment, and with weak priors (10 degrees, a tenth of the distance) each hole and the
#: zero of each tendon.
_FTDCR_FIT = (
    "robot.base_m[*],robot.base_rotation_rad[*],robot.backbone.pieces[*].bending_stiffness_n_m2,"
    "robot.tendons.pretension_m[*]~0.002,robot.tendons.angles_deg[*]~10,robot.tendons.radii_m[*]~0.00045,"
)
V4_FIT = _FTDCR_FIT + (
    "robot.tendons.compliance_m_per_n,robot.backbone.pieces[*].rest_curvature_rad_m[*]~2,effects[0].hysteresis.*"
)
#: The groups that `--fit auto` keeps for v6, but for anisotropy and mass, which bring least. Its segments are turned against each other.
V6_FIT = _FTDCR_FIT + "robot.backbone.pieces[*].rest_curvature_rad_m[*]~20,robot.gravity_m_s2[*]~3"
#: Pose, gains, stiffness, compliance, pretension, and where the disks' tracked points sit (prior 5 mm).
TRUNK_FIT = (
    "robot.base_m[*],robot.base_rotation_rad[*],drives.*.gains[*]~0.004,robot.backbone.bending_stiffness_n_m2,"
    "robot.tendons.compliance_m_per_n,robot.tendons.pretension_m,tracking.points.*.offset_m[*]~0.005"
)
#: Pose, material, where the markers sit (prior 10 mm), the tendons' angles and their distance: the latter two lower the
#: cross-validated error from 11.2 to 9.8 mm. The last marker sits at the tip: its place along the backbone and its offset are one
#: number.
TENTACLE_FIT = (
    "robot.base_m[*],robot.base_rotation_rad[*],robot.backbone.youngs_modulus_pa,robot.backbone.density_kg_m3,"
    "tracking.points.*.offset_m[*]~0.01,tracking.points.p1.s_m~0.01,tracking.points.p2.s_m~0.01,tracking.points.p3.s_m~0.01,"
    "robot.tendons.angles_deg[*]~10,robot.tendons.radius_m"
)

ROBOTS = [
    Robot(
        "v4",
        "FTDCR v4",
        V4_FIT,
        convert.ftdcr,
        lambda data: ftdcr_start(data, "v4"),
        "opencr/v4_train.csv",
        kept_apart="opencr/v4_val.csv",
    ),
    Robot(
        "v6",
        "FTDCR v6",
        V6_FIT,
        convert.ftdcr,
        lambda data: ftdcr_start(data, "v6"),
        "opencr/v6_train.csv",
        kept_apart="opencr/v6_val.csv",
    ),
    Robot(
        "trunk",
        "Stanford ASL trunk",
        TRUNK_FIT,
        convert.trunk,
        trunk_start,
        "trunk/0g.csv",
        hold_out=["--hold-out-patterns", "late"],
    ),
    Robot("tentacle", "soromox tentacle", TENTACLE_FIT, convert.tentacle, tentacle_start, "tentacle/static_shapes.csv"),
]
