//! Made-up rows of plausible shape, for tests of the figures. Their numbers mean nothing.

pub(crate) mod cases;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use spinebench::base::{Outcome, Point3, Seed, distance_m};
use spinebench::report::{Published, SweepTable};
use spinebench::rows::cell::{CellLabel, CellRow};
use spinebench::rows::experiment::{
    ClaimRow, GapRow, GapSample, GpCoverage, GpCoverageRow, PeerRow, ReachTrial, ScalingRow,
    SweepRow, TrackRow, TrackSample, TrialRow, WaypointRow, WorkspaceRow,
};
use spinebench::rows::learning_peers::LearningPeerRow;
use spinebench::rows::population::{RobotClaimRow, RobotRow};
use spinebench::rows::repairs::{MonitorRow, RepairRow, RepairTrialRow};
use spinebench::rows::responses::{PaceLap, PaceRow, ResponseRow, ResponseTrial};

const TRAININGS: [&str; 2] = ["paper", "converged"];

fn noise(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

fn cell(policy: &str, mode: &str, [gp_points, real_points]: [u64; 2]) -> CellLabel {
    CellLabel { policy: policy.to_owned(), mode: mode.to_owned(), gp_points, real_points }
}

fn trial(
    seed: u64,
    training: &str,
    policy: &str,
    mode: &str,
    sizes: [u64; 2],
    target: u64,
) -> TrialRow {
    let name = format!("{seed}{training}{policy}{mode}{sizes:?}{target}");
    let mut rng = Seed(1).child(&name).rng();
    let base = match mode {
        "open" => 0.026,
        "closed" => 0.014,
        _ => 0.029,
    };
    let skill =
        if policy == "c" { 0.75 } else { 1.0 } * if training == "paper" { 1.0 } else { 0.6 };
    let data = 1.0 + 100.0 / (sizes[0] + sizes[1]) as f64;
    let error_m = (base * skill * data * (1.0 + 0.45 * noise(&mut rng))).abs() + 0.001;
    let settled = !target.is_multiple_of(10);
    let trial =
        ReachTrial::new(target, [0.05, 0.0, 0.18], [0.05 + error_m, 0.0, 0.18], Outcome::Ok);
    CellRow {
        seed,
        training: training.to_owned(),
        cell: cell(policy, mode, sizes),
        value: ReachTrial { error_m, steps: 12, settled, ..trial },
    }
}

/// Table I: four policies, three modes, two ways of training.
pub(crate) fn table(seeds: u64) -> Vec<TrialRow> {
    let mut rows = Vec::new();
    for seed in 0..seeds {
        for training in TRAININGS {
            for policy in ["a", "b", "c", "pi_real"] {
                for mode in ["open", "closed", "closed_load"] {
                    let sizes = if policy == "pi_real" { [0, 10_000] } else { [100, 0] };
                    let runs = !(policy == "c" && mode == "open");
                    let targets = if runs { 0..50 } else { 0..0 };
                    rows.extend(
                        targets.map(|target| trial(seed, training, policy, mode, sizes, target)),
                    );
                }
            }
        }
    }
    rows
}

/// Fig. 6: two sweeps.
pub(crate) fn data_sizes(seeds: u64) -> Vec<TrialRow> {
    let mut rows = Vec::new();
    let gp = [50, 100, 200, 400, 600, 800, 1000].map(|size| ("a", [size, 0]));
    let real = [500, 1000, 2000, 3000, 5000, 7500, 10_000].map(|size| ("pi_real", [0, size]));
    for seed in 0..seeds {
        for training in TRAININGS {
            for (policy, sizes) in gp.into_iter().chain(real) {
                for mode in ["open", "closed"] {
                    rows.extend(
                        (0..50).map(|target| trial(seed, training, policy, mode, sizes, target)),
                    );
                }
            }
        }
    }
    rows
}

/// A bent robot's tip: two curvatures to a point.
fn tip(bend_x: f64, bend_y: f64) -> Point3 {
    let bend = bend_x.hypot(bend_y).max(1e-9);
    let side = 0.22 * (1.0 - bend.cos()) / bend;
    [side * bend_x / bend, side * bend_y / bend, 0.22 * bend.sin() / bend]
}

pub(crate) fn gaps(samples: u64) -> Vec<GapRow> {
    let mut rng = Seed(2).rng();
    let row = |sample| {
        let [a, b] =
            [1.4 * (2.0 * rng.random::<f64>() - 1.0), 1.4 * (2.0 * rng.random::<f64>() - 1.0)];
        let sim = tip(a, b);
        let real = tip(0.93 * a - 0.06, 0.97 * b);
        let mut real = real.map(|part| part + 0.0005 * noise(&mut rng));
        real[0] -= 0.004;
        let gap = GapSample {
            sample,
            tendon_1_m: 0.02 * a,
            tendon_2_m: 0.02 * b,
            tendon_3_m: -0.02 * a,
            tendon_4_m: -0.02 * b,
            further_tendons_m: String::new(),
            sim_x_m: sim[0],
            sim_y_m: sim[1],
            sim_z_m: sim[2],
            real_x_m: real[0],
            real_y_m: real[1],
            real_z_m: real[2],
        };
        GapRow { seed: 0, gap }
    };
    (0..samples).map(row).collect()
}

pub(crate) fn waypoints(seed: u64) -> Vec<WaypointRow> {
    let row = |waypoint: u64| {
        let turn = 4.0 * std::f64::consts::PI * waypoint as f64 / 32.0;
        let [x_m, y_m, z_m] = tip(
            (0.3 + 0.02 * waypoint as f64) * turn.cos(),
            (0.3 + 0.02 * waypoint as f64) * turn.sin(),
        );
        WaypointRow { seed, waypoint, x_m, y_m, z_m }
    };
    (0..33).map(row).collect()
}

pub(crate) fn tracks(seeds: u64) -> Vec<TrackRow> {
    let mut rows = Vec::new();
    for seed in 0..seeds {
        for training in TRAININGS {
            for (policy, seconds, swing) in
                [("a", 135, 0.4), ("b", 150, 0.4), ("c", 196, 1.6), ("pi_real", 160, 0.5)]
            {
                rows.extend(track(seed, training, policy, 5 * seconds, swing));
            }
        }
    }
    rows
}

fn track(seed: u64, training: &str, policy: &str, steps: u64, swing: f64) -> Vec<TrackRow> {
    let points = waypoints(seed);
    let mut rng = Seed(seed).child(&format!("{training}{policy}")).rng();
    let mut drift = [if policy == "c" { 0.004 } else { 0.02 }, 0.0, 0.0];
    let mut rows = Vec::new();
    for step in 0..steps {
        let place = 32.0 * step as f64 / steps as f64;
        let (from, share) = (place as usize, place.fract());
        let [a, b] = [&points[from], &points[from + 1]];
        let mix = |one: f64, other: f64| one + share * (other - one);
        let target = [mix(a.x_m, b.x_m), mix(a.y_m, b.y_m), mix(a.z_m, b.z_m)];
        drift = drift.map(|part| 0.93 * part + 0.0008 * noise(&mut rng));
        let wave = 0.0012 * swing * (step as f64 * 0.9).sin();
        let tip = [target[0] + drift[0] + wave, target[1] + drift[1] + 0.003, target[2] + drift[2]];
        let sample = TrackSample {
            step,
            time_s: 0.2 * step as f64,
            path_point: place as u64,
            error_m: distance_m(&tip, &target),
            branch: if policy == "c" && (step / 7) % 2 == 1 { "b" } else { "a" }.to_owned(),
            ..TrackSample::new(target, tip, Outcome::Ok)
        };
        rows.push(TrackRow {
            seed,
            training: training.to_owned(),
            policy: policy.to_owned(),
            sample,
        });
    }
    rows
}

pub(crate) fn claims() -> Vec<ClaimRow> {
    let list = [
        ("c_beats_pi_real_closed", "C errs less than π_real in closed loop", -0.0041, "m"),
        ("closed_beats_open_a", "Closed loop errs less than open loop, A", -0.0113, "m"),
        ("closed_beats_open_b", "Closed loop errs less than open loop, B", -0.0133, "m"),
        ("closed_beats_open_pi_real", "Closed loop errs less than open loop, π_real", -0.0169, "m"),
        ("load_a_beats_pi_real", "With load A errs less than π_real", -0.0032, "m"),
        ("pi_real_falls_with_data", "π_real's error falls with data", f64::NAN, "m/decade"),
        ("gp_100_enough", "More than 100 points do not help the GP", 0.0, "m"),
        ("c_oscillates", "C oscillates around the path", 4.0, "mm"),
        ("c_takes_longer", "C takes longer than A and B", 53.5, "s"),
    ];
    let mut rows = Vec::new();
    for (index, (claim, statement, paper, unit)) in list.into_iter().enumerate() {
        for (turn, training) in TRAININGS.into_iter().enumerate() {
            let ratio = [0.8, 1.3, -0.4, 4.2, 1.0, 0.5, 0.1, 2.2, 0.9][(index + 2 * turn) % 9];
            let reference = if paper == 0.0 || !f64::is_finite(paper) { 0.002 } else { paper };
            let (ours, half) = (ratio * reference, 0.35 * reference.abs());
            rows.push(ClaimRow {
                experiment: "table1".into(),
                claim: claim.to_owned(),
                statement: statement.to_owned(),
                quantity: format!("quantity of {claim}"),
                training: training.to_owned(),
                holds_above: f64::NAN,
                holds_below: 0.0,
                paper,
                ours,
                low_95: ours - half,
                high_95: ours + half,
                unit: unit.to_owned(),
                seeds: 10,
                verdict: ["reproduced", "not reproduced", "undecided"][(index + turn) % 3]
                    .to_owned(),
            });
        }
    }
    rows
}

/// A sweep of these fields (name and values), four policies in two modes.
pub(crate) fn sweep(fields: &[(&str, &[&str])], seeds: u64) -> SweepTable {
    let count: usize = fields.iter().map(|(_, values)| values.len()).product();
    let mut swept = SweepTable {
        fields: fields.iter().map(|(name, _)| ((*name).to_owned(), Vec::new())).collect(),
        rows: Vec::new(),
    };
    for point in 0..count {
        let mut rest = point;
        let digits: Vec<usize> = fields
            .iter()
            .rev()
            .map(|(_, values)| {
                let digit = rest % values.len();
                rest /= values.len();
                digit
            })
            .collect();
        for (place, policy) in ["a", "b", "c", "pi_real"].into_iter().enumerate() {
            for (turn, mode) in ["open", "closed"]
                .into_iter()
                .enumerate()
                .filter(|(_, mode)| policy != "c" || *mode == "closed")
            {
                for (index, digit) in digits.iter().rev().enumerate() {
                    swept.fields[index].1.push(fields[index].1[*digit].to_owned());
                }
                let bowl: f64 = digits.iter().map(|&digit| (digit as f64 - 2.5).powi(2)).sum();
                let mean_m = 1e-3 * (15.0 - place as f64 - 4.0 * turn as f64 + bowl);
                swept.rows.push(SweepRow {
                    task: "reach".to_owned(),
                    training: "paper".to_owned(),
                    cell: cell(
                        policy,
                        mode,
                        if policy == "pi_real" { [0, 10_000] } else { [100, 0] },
                    ),
                    mean_m,
                    sd_over_seeds_m: if seeds > 1 { 0.001 } else { f64::NAN },
                    low_95_m: if seeds > 1 { mean_m - 0.002 } else { f64::NAN },
                    high_95_m: if seeds > 1 { mean_m + 0.002 } else { f64::NAN },
                    seeds,
                    count: 50 * seeds,
                    failed: 0,
                });
            }
        }
    }
    swept
}

/// Robots with two effects each: friction and, on every other robot, a load.
pub(crate) fn robots(seeds: u64) -> Vec<RobotRow> {
    let row = |seed: u64, effect: &str, parameter: &str, unit: &str| RobotRow {
        seed,
        effect: effect.to_owned(),
        strength: 0.5 + 0.1 * seed as f64,
        parameter: parameter.to_owned(),
        value: 0.01,
        unit: unit.to_owned(),
    };
    (0..seeds)
        .flat_map(|seed| {
            let load = (seed % 2 == 0).then(|| row(seed, "tip_load", "mass_kg", "kg"));
            std::iter::once(row(seed, "friction", "moment_nm", "N m")).chain(load)
        })
        .collect()
}

/// Two claims on so many robots.
pub(crate) fn robot_claims(seeds: u64) -> Vec<RobotClaimRow> {
    let names = ["c_beats_pi_real_closed", "a_comparable_with_pi_real"];
    let trainings = ["paper", "converged"];
    let row = |training: &str, (claim, held): (&str, u64)| RobotClaimRow {
        claim: claim.to_owned(),
        statement: format!("the claim {claim}"),
        training: training.to_owned(),
        robots: seeds,
        held,
        share: held as f64 / seeds as f64,
        low_95: 0.2,
        high_95: 0.9,
    };
    trainings
        .iter()
        .flat_map(|training| {
            names.into_iter().zip([seeds, seeds / 2]).map(|pair| row(training, pair))
        })
        .collect()
}

/// Intervals that are somewhat too narrow for few points.
pub(crate) fn gp_coverages(seeds: u64) -> Vec<GpCoverageRow> {
    let row = |seed: u64, points: u64, axis: &str, promised: f64| GpCoverageRow {
        seed,
        training: "any".to_owned(),
        coverage: GpCoverage {
            points,
            kernel: "se_ard".to_owned(),
            axis: axis.to_owned(),
            promised,
            covered: promised.powf(1.0 + 10.0 / points as f64),
            unseen: 1000 - points,
        },
    };
    let shares = [0.5, 0.9, 0.99];
    let of_axis = |seed, points, axis| shares.map(|promised| row(seed, points, axis, promised));
    let of_size = |seed, points| {
        ["x", "y", "z"].into_iter().flat_map(move |axis| of_axis(seed, points, axis))
    };
    (0..seeds)
        .flat_map(|seed| [25, 100, 400].into_iter().flat_map(move |points| of_size(seed, points)))
        .collect()
}

/// Six switching thresholds.
pub(crate) fn thresholds(seeds: u64) -> SweepTable {
    sweep(
        &[("policies.c.switch_threshold_m", &["0.005", "0.01", "0.015", "0.02", "0.025", "0.03"])],
        seeds,
    )
}

/// A campaign on clusters of growing size.
pub(crate) fn scaling() -> Vec<ScalingRow> {
    let row = |(system, share): (&str, f64), workers: u64| ScalingRow {
        system: system.to_owned(),
        workers,
        stages: 5000,
        wall_s: 1e5 / workers as f64 / share,
        efficiency: share,
        store_gb: 3.0,
        store_mb_s: 0.03 * workers as f64,
        bound: "store".to_owned(),
        store_operations: 200_000,
        locks_lost: 5,
        polls: 7,
    };
    let systems = [("ideal cluster", 0.98), ("workers", 0.9)];
    systems
        .into_iter()
        .flat_map(|system| [1, 10, 100, 1000].map(|workers| row(system, workers)))
        .collect()
}

/// Work against precision: simulators on three robots, each at several time steps, and a run that
/// failed.
pub(crate) fn peers() -> Vec<PeerRow> {
    let mut rows = Vec::new();
    for (place, peer) in ["spinebench", "till_2019", "till_2019_tuned", "mujoco", "pyelastica"]
        .into_iter()
        .enumerate()
    {
        for robot in ["till", "paper", "paper_tension"] {
            for step in 0..6 {
                let dt_s = 0.05 / 2f64.powi(step);
                let cpu_s_per_s = 1e-4 * 4f64.powi(place as i32) / dt_s;
                let rms_error_m = 0.2 * (1.0 + place as f64) * dt_s * dt_s;
                rows.push(PeerRow {
                    robot: robot.to_owned(),
                    peer: peer.to_owned(),
                    setting: "order 2".to_owned(),
                    segments_or_nodes: 20.0,
                    dt_s,
                    cpu_s_per_s,
                    real_time_factor: 1.0 / cpu_s_per_s,
                    rms_error_m,
                    max_error_m: 3.0 * rms_error_m,
                    static_error_m: 1e-6,
                    status: Outcome::Ok,
                });
            }
        }
    }
    rows[7].rms_error_m = f64::NAN;
    rows[7].status = Outcome::Failed("not_converged".to_owned());
    rows
}

/// Learning by every package in some rounds, and a fit that failed.
fn learning_peers(rounds: u64) -> Vec<LearningPeerRow> {
    let mut rows = Vec::new();
    let packages = ["spinebench", "scipy", "scikit_learn", "gpy", "gpytorch", "pytorch"];
    let tasks = [
        ("product_f64", 2048, 0.3),
        ("product_f32", 2048, 0.15),
        ("fit", 100, 0.02),
        ("predict_one", 100, 5e-6),
        ("predict_many", 100, 0.05),
        ("fit", 1000, 2.0),
        ("predict_one", 1000, 1e-3),
        ("predict_many", 1000, 1.0),
        ("evaluation", 1000, 0.02),
        ("epoch", 7000, 0.013),
        ("until_error", 7000, 0.4),
    ];
    for round in 1..=rounds {
        for (task, size, cpu_s) in tasks {
            for (place, peer) in packages.into_iter().enumerate() {
                rows.push(LearningPeerRow {
                    task: task.to_owned(),
                    size,
                    peer: peer.to_owned(),
                    round,
                    cpu_s: cpu_s
                        * 3f64.powi(place as i32)
                        * (1.0 + 0.02 * ((round * size) % 7) as f64 * place as f64),
                    likelihood: 481.8 - place as f64,
                    evaluations: 60.0,
                    error_m: 0.0002,
                    status: Outcome::Ok,
                });
            }
        }
    }
    let failed = rows.iter_mut().find(|row| row.task == "fit" && row.peer == "gpy");
    if let Some(row) = failed {
        (row.cpu_s, row.status) = (f64::NAN, Outcome::Failed("LinAlgError".to_owned()));
    }
    rows
}

/// Trials of fixed duration: three policies with and without a load.
fn responses(seeds: u64) -> Vec<ResponseRow> {
    let each = table(seeds)
        .into_iter()
        .filter(|row| row.cell.policy != "pi_real" && row.cell.mode != "open" && row.target < 6);
    let respond = |row: TrialRow| {
        let value = ResponseTrial {
            distance_m: 0.06,
            limit_s: 1.4,
            within_5mm_s: 2.0,
            within_3mm_s: if row.target == 0 { f64::NAN } else { 3.2 },
            within_2mm_s: f64::NAN,
            error_1s_m: 4.0 * row.error_m,
            error_2s_m: 2.0 * row.error_m,
            error_5s_m: 1.2 * row.error_m,
            error_end_m: row.error_m,
            tracked_end_m: row.error_m + 3e-4,
            overshoot_m: 0.002,
            tendon_travel_m: 0.08,
            ..ResponseTrial::unmeasured(row.target, Outcome::Ok)
        };
        CellRow { seed: row.seed, training: row.training, cell: row.cell, value }
    };
    each.map(respond).collect()
}

/// Laps at three speeds.
fn paces(seeds: u64) -> Vec<PaceRow> {
    let lap = |(row, speed): (ResponseRow, f64)| CellRow {
        seed: row.seed,
        training: row.training,
        cell: row.cell,
        value: PaceLap {
            speed,
            lap_s: 40.0 / speed,
            rms_m: 0.002 * speed,
            largest_m: 0.006 * speed,
            tracked_rms_m: 0.0022 * speed,
            tendon_travel_m: 0.4,
            status: Outcome::Ok,
        },
    };
    let first = responses(seeds).into_iter().filter(|row| row.target == 1);
    first.flat_map(|row| [1.0, 2.0, 4.0].map(|speed| (row.clone(), speed))).map(lap).collect()
}

/// Three changes, noticed and told.
fn repairs(seeds: u64) -> Vec<RepairRow> {
    let changes = ["load", "tilted_base", "friction"];
    let row = |(seed, change): (u64, &str)| RepairRow {
        seed,
        training: "converged".to_owned(),
        change: change.to_owned(),
        truth: "tip_load: {mass_kg: 0.02}".to_owned(),
        alarm_s: if change == "friction" { f64::NAN } else { 1.5 + seed as f64 },
        samples: 100,
        verdict: if change == "friction" { "unexplained" } else { "named" }.to_owned(),
        named: if change == "friction" { "" } else { "tip_load: {mass_kg: 0.021}" }.to_owned(),
        nearest_m: 0.0008,
        gap_before_m: 0.012,
        gap_after_m: 0.0011,
        noise_floor_m: 0.0009,
        status: Outcome::Ok,
    };
    (0..seeds).flat_map(|seed| changes.map(|change| (seed, change))).map(row).collect()
}

/// Goal reaching before and after these changes.
fn repair_trials(seeds: u64) -> Vec<RepairTrialRow> {
    let variants = [
        ("before", 0.003),
        ("changed", 0.011),
        ("repaired", 0.004),
        ("moved_points", 0.0042),
        ("new_points", 0.0045),
    ];
    let mut rows = Vec::new();
    for repair in repairs(seeds) {
        for mode in ["open", "closed"] {
            for policy in ["a", "b", "integral"] {
                for (variant, base_m) in
                    variants.into_iter().take(if policy == "integral" { 2 } else { variants.len() })
                {
                    for target in 0..4 {
                        let mut rng = Seed(3)
                            .child(&format!("{repair:?}{mode}{policy}{variant}{target}"))
                            .rng();
                        rows.push(RepairTrialRow {
                            seed: repair.seed,
                            training: repair.training.clone(),
                            change: repair.change.clone(),
                            variant: variant.to_owned(),
                            cell: cell(
                                policy,
                                mode,
                                [if policy == "integral" { 0 } else { 100 }, 0],
                            ),
                            target,
                            error_m: base_m * (1.0 + 0.3 * noise(&mut rng)).abs(),
                            steps: 30,
                            settled: true,
                            status: Outcome::Ok,
                        });
                    }
                }
            }
        }
    }
    rows
}

/// Everything, each figure's own rows.
pub(crate) fn published(figure: &str, seeds: u64) -> Published {
    let mut published = Published::default();
    match figure {
        "table1" => published.trials = table(seeds),
        "fig5" => published.gaps = gaps(3000),
        "fig6" => published.trials = data_sizes(seeds),
        "fig8" => {
            published.tracks = tracks(seeds);
            let seen = gaps(1000).into_iter();
            let place = |row: GapRow| WorkspaceRow {
                seed: 0,
                x_m: row.gap.real_x_m,
                y_m: row.gap.real_y_m,
                z_m: row.gap.real_z_m,
            };
            published.workspace = seen.map(place).collect();
            published.waypoints = (0..seeds).flat_map(waypoints).collect();
        }
        "claims" => published.claims = claims(),
        "sweep" => published.sweep = thresholds(seeds),
        "peers" => published.peers = peers(),
        "peers_learning" => published.learning_peers = learning_peers(seeds),
        "scaling" => published.scaling = scaling(),
        "discovery" => published.cases = cases::cases(seeds),
        "population" => {
            published.trials = table(seeds);
            published.robots = robots(seeds);
            published.robot_claims = robot_claims(seeds);
        }
        "gp_coverage" => published.gp_coverages = gp_coverages(seeds),
        "data_efficiency" => published.responses = responses(seeds),
        "controllers" => {
            published.responses = responses(seeds);
            published.paces = paces(seeds);
        }
        "repair" => {
            let watched = |seed| MonitorRow {
                seed,
                training: "converged".to_owned(),
                threshold: 150.0,
                watched_s: 36_000.0,
                false_alarms: 0,
                status: Outcome::Ok,
            };
            published.monitors = (0..seeds).map(watched).collect();
            published.repairs = repairs(seeds);
            published.repair_trials = repair_trials(seeds);
        }
        // A figure that is added: whatever it is made of.
        _ => {
            published.trials = table(seeds);
            published.gaps = gaps(1000);
            published.tracks = tracks(seeds);
            published.scaling = scaling();
        }
    }
    published
}
