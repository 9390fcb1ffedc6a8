//! Made-up cases of a blind benchmark. Their numbers mean nothing.

use rand::RngExt;
use spinebench::base::Seed;
use spinebench::data::findings::CaseRow;

/// The catalogue's names.
pub(crate) const EFFECTS: [&str; 21] = [
    "tip_load",
    "distributed_mass",
    "tip_force",
    "base_tilt",
    "frame_shift",
    "bending_stiffness",
    "anisotropic_stiffness",
    "precurvature",
    "soft_section",
    "spine_compressibility",
    "friction",
    "hysteresis",
    "creep",
    "damping",
    "delay",
    "backlash",
    "actuator_gain",
    "actuator_offset",
    "tendon_stretch",
    "tendon_angle",
    "tendon_radius",
];

const UNKNOWN: [&str; 4] = ["wall contact", "step loss", "thermal drift", "mullins"];

fn case(number: u64, group: &str, truth: &str, verdict: &str, answer: &str) -> CaseRow {
    let mut rng = Seed(7).child(&number.to_string()).rng();
    let mut share = || rng.random::<f64>();
    let right = match group {
        "nothing" => verdict == "consistent",
        "outside" => verdict == "unexplained",
        "inside" => verdict == "ambiguous" || verdict == "unexplained",
        _ => verdict == "named" && answer == truth,
    };
    let in_group = right || (verdict == "ambiguous" && answer.contains(truth));
    let floor_m = [0.00087, 0.00173][(number % 5 == 4) as usize];
    let before_m = if group == "nothing" { 1.01 * floor_m } else { 0.002 + 0.01 * share() };
    CaseRow {
        case: number,
        group: group.to_owned(),
        truth: truth.to_owned(),
        shift_m: if group == "nothing" { 0.0 } else { 0.0006 + 0.008 * share() },
        noise_m: [0.0005, 0.001][(number % 5 == 4) as usize],
        correlation: [0.0, 0.6][(number % 2) as usize],
        samples: [400, 100][(number % 3 == 2) as usize],
        verdict: verdict.to_owned(),
        answer: answer.to_owned(),
        right,
        in_group,
        imitations: if group == "inside" {
            ["friction", "friction or creep"][(number % 2) as usize]
        } else {
            ""
        }
        .to_owned(),
        strength_error: if right && group == "single" { 0.06 * share() } else { f64::NAN },
        intervals: 2,
        covered: u64::from(share() < 0.96) + u64::from(share() < 0.96),
        before_m,
        after_m: if right { floor_m * (1.0 + 0.1 * share()) } else { before_m },
        stiffness_only_m: 0.8 * before_m,
        gp_m: if number.is_multiple_of(7) { f64::NAN } else { 0.4 * before_m },
        floor_m,
        isolation: match group {
            "single" | "pair" => share(),
            _ => f64::NAN,
        },
        sparse_answer: if share() < 0.7 { "friction" } else { "" }.to_owned(),
        sparse_isolation: if group == "single" { share() } else { f64::NAN },
        sparse_m: 0.5 * before_m,
        ridge_detects: share() < 0.8,
        ridge_isolation: if group == "single" { share() } else { f64::NAN },
        ridge_m: 0.6 * before_m,
        library_detects: share() < 0.9,
        library_m: 0.5 * before_m,
        gp_detects: share() < 0.9,
    }
}

/// Every effect in turn, pairs, nothing, unknown ones.
pub(crate) fn cases(repeats: u64) -> Vec<CaseRow> {
    let mut rows: Vec<CaseRow> = Vec::new();
    let mut add = |group: &str, truth: &str, verdict: &str, answer: &str| {
        let number = rows.len() as u64;
        rows.push(case(number, group, truth, verdict, answer));
    };
    for repeat in 0..5 * repeats {
        for (index, effect) in EFFECTS.iter().enumerate() {
            let rival = EFFECTS[(index + 1) % EFFECTS.len()];
            let pair = format!("{effect} + {rival}");
            match (repeat as usize + 3 * index) % 13 {
                0 => add("single", effect, "ambiguous", &pair),
                1 => add("single", effect, "named", rival),
                2 => add("single", effect, "consistent", ""),
                3 => add("single", effect, "named", &pair),
                _ => add("single", effect, "named", effect),
            }
            if repeat % 2 == 0 {
                add("pair", &pair, "named", if index % 6 == 0 { effect } else { &pair });
                add("nothing", "", if index == 4 { "unexplained" } else { "consistent" }, "");
            }
        }
        for (index, truth) in UNKNOWN.iter().enumerate() {
            let group = if index < 2 { "outside" } else { "inside" };
            match (repeat as usize + index) % 5 {
                0 => add(group, truth, "named", "friction"),
                1 => add(group, truth, "ambiguous", "friction + backlash"),
                2 => add(group, truth, "failed: no convergence", ""),
                _ => add(group, truth, "unexplained", ""),
            }
        }
    }
    rows
}
