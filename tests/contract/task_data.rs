//! Explorations, points of the error model, targets and the path.

use crate::support::policies::{ConstantError, negative, robot};
use proptest::prelude::*;
use spinebench::base::{
    Observation, Plant, PlantError, Point3, Rows, Seed, TendonCommand, distance_m,
};
use spinebench::learn::selection::Selection;
use spinebench::plants::{ConstantCurvature, ConstantCurvatureOptions};
use spinebench::tasks::{
    ExploreOptions, GpPointsOptions, GridOptions, PathOptions, PointLayout, TargetOptions,
    TaskError, Transitions, correct_samples, draw_targets, explore, explore_trajectory, gp_points,
    interpolate, replay, spread_targets, target_pool, waypoints,
};

const SHIFT_M: Point3 = [-0.012, 0.004, 0.001];

fn noisy() -> ConstantCurvature {
    ConstantCurvature::new(ConstantCurvatureOptions {
        noise_m: 0.0005,
        ..ConstantCurvatureOptions::default()
    })
    .unwrap()
}

fn at_once(shift_m: Point3) -> ConstantCurvature {
    ConstantCurvature::new(ConstantCurvatureOptions {
        lag_s: 0.0,
        shift_m,
        ..ConstantCurvatureOptions::default()
    })
    .unwrap()
}

#[test]
fn exploration_pulls_two_neighbours_in_small_steps_and_the_others_follow() {
    let options = ExploreOptions { points: 5_000, ..ExploreOptions::default() };
    let samples = explore(&mut at_once([0.0; 3]), &options, Seed(3)).unwrap();
    assert_eq!(samples.len(), 5_000);
    let mut last = vec![0.0; 4];
    let mut largest_m = 0.0_f64;
    for pulls_m in samples.pulls_m.iter() {
        let pulled = pulls_m.iter().filter(|pull| **pull > 0.0).count();
        assert_eq!(pulled, 2);
        assert!(
            pulls_m[0].min(pulls_m[2]) <= 0.0 && pulls_m[1].min(pulls_m[3]) <= 0.0,
            "opposite ones never both"
        );
        // This robot follows at once: what an opposite tendon let out is what its partner pulled.
        assert!((pulls_m[0] + pulls_m[2]).abs() < 1e-12 && (pulls_m[1] + pulls_m[3]).abs() < 1e-12);
        for (now, before) in pulls_m.iter().zip(&last) {
            assert!((now - before).abs() <= 0.003 + 1e-12);
            assert!(now.abs() <= 0.03 + 1e-12);
            largest_m = largest_m.max(now.abs());
        }
        last = pulls_m.to_vec();
    }
    assert!(largest_m > 0.025, "the walk gets about: {largest_m} m");
}

#[test]
fn points_move_as_the_model_does() {
    let options = GpPointsOptions {
        layout: PointLayout::Grid(GridOptions { rows: 3, columns: 3, ..GridOptions::default() }),
        ..GpPointsOptions::default()
    };
    let pool = gp_points(&mut at_once([0.0; 3]), &mut at_once(SHIFT_M), &options, Seed(7)).unwrap();
    let changed = replay(&mut at_once([0.001, 0.0, -0.002]), &pool.steps, Seed(0)).unwrap();
    let mut moved = pool.moved(&changed);
    assert_eq!(
        moved.inputs,
        pool.points().inputs,
        "the model that controllers have stays as it is"
    );
    for error_m in moved.errors_m.iter() {
        for (found_m, expected_m) in error_m.iter().zip([0.011, -0.004, 0.001]) {
            assert!((found_m - expected_m).abs() < 1e-12, "{error_m:?}");
        }
    }
    moved.extend(&pool.steps, &changed);
    assert_eq!(moved.errors_m.len(), 9 + pool.steps.len());
    let last_m = moved.errors_m.row(moved.errors_m.len() - 1);
    assert!((last_m[0] + 0.001).abs() < 1e-12 && (last_m[2] - 0.002).abs() < 1e-12, "{last_m:?}");
}

#[test]
fn samples_are_a_continuous_recording() {
    let options = ExploreOptions { points: 103, trajectories: 4, ..ExploreOptions::default() };
    let samples = explore(&mut noisy(), &options, Seed(3)).unwrap();
    let ranges = samples.trajectories();
    assert_eq!(ranges.iter().map(ExactSizeIterator::len).collect::<Vec<_>>(), [26, 26, 26, 25]);
    for range in ranges {
        for index in range.start + 1..range.end {
            assert_eq!(samples.from_m.row(index), samples.to_m.row(index - 1));
        }
        let home_m: Point3 = samples.from_m.row(range.start).try_into().unwrap();
        assert!(distance_m(&home_m, &[0.0, 0.0, 0.22]) < 0.004, "each begins at home");
    }
}

#[test]
fn trajectories_do_not_depend_on_who_records_them_and_when() {
    let options = ExploreOptions { points: 90, trajectories: 3, ..ExploreOptions::default() };
    let whole = explore(&mut noisy(), &options, Seed(5)).unwrap();
    let mut apart: Vec<Transitions> = [2, 0, 1]
        .into_iter()
        .map(|index| explore_trajectory(&mut noisy(), &options, Seed(5), index).unwrap())
        .collect();
    apart.rotate_left(1);
    assert_eq!(Transitions::concat(&apart), whole);
    assert_ne!(explore(&mut noisy(), &options, Seed(6)).unwrap(), whole);
}

#[test]
fn a_replay_has_the_same_inputs_and_the_other_robots_tips() {
    let options = ExploreOptions { points: 300, trajectories: 2, ..ExploreOptions::default() };
    let model = explore(&mut at_once([0.0; 3]), &options, Seed(7)).unwrap();
    let real = replay(&mut at_once(SHIFT_M), &model, Seed(7)).unwrap();
    assert_eq!((&real.pulls_m, &real.starts), (&model.pulls_m, &model.starts));
    for (real_m, model_m) in real.to_m.iter().zip(model.to_m.iter()) {
        for axis in 0..3 {
            assert!((real_m[axis] - model_m[axis] - SHIFT_M[axis]).abs() < 1e-12);
        }
    }
}

/// A robot that follows at once, whose tracker sees nothing at some of its looks (the one at home
/// is number 0).
struct Blinking {
    robot: ConstantCurvature,
    looks: usize,
    sees: fn(usize) -> bool,
}

impl Blinking {
    fn new(sees: fn(usize) -> bool) -> Blinking {
        Blinking { robot: at_once(SHIFT_M), looks: 0, sees }
    }

    fn look(&mut self, there: Observation) -> Observation {
        let valid = (self.sees)(self.looks);
        self.looks += 1;
        if valid {
            there
        } else {
            Observation { valid, tip_m: [f64::NAN; 3], tip_quaternion: None, ..there }
        }
    }
}

impl Plant for Blinking {
    fn tendons(&self) -> usize {
        self.robot.tendons()
    }
    fn step_s(&self) -> f64 {
        self.robot.step_s()
    }
    fn reset(&mut self, seed: Seed) -> Result<Observation, PlantError> {
        let there = self.robot.reset(seed)?;
        Ok(self.look(there))
    }
    fn drive(&mut self, commands: &[TendonCommand]) -> Result<Observation, PlantError> {
        let there = self.robot.drive(commands)?;
        Ok(self.look(there))
    }
}

/// On a robot that follows at once a command that is held ends where it did: nothing is missing and
/// nothing else moves.
#[test]
fn where_the_tip_is_not_seen_the_tick_is_repeated() {
    let walk = ExploreOptions { points: 200, trajectories: 2, ..ExploreOptions::default() };
    let sweep = GridOptions { rows: 5, columns: 7, ..GridOptions::default() };
    let points = GpPointsOptions { layout: PointLayout::Grid(sweep), ..GpPointsOptions::default() };
    let targets = TargetOptions { pool: 20, drawn: 5, sweep };
    let path = PathOptions { points: 9, hold_steps: 0, ..PathOptions::default() };
    let record = |robot: &mut dyn Plant| {
        let samples = explore(robot, &walk, Seed(7)).unwrap();
        let played = replay(robot, &samples, Seed(7)).unwrap();
        let pool = gp_points(&mut at_once([0.0; 3]), robot, &points, Seed(7)).unwrap();
        let simulated = gp_points(robot, &mut at_once([0.0; 3]), &points, Seed(7)).unwrap();
        assert_eq!((&samples.starts[..], &played.starts[..]), (&[0, 100][..], &[0, 100][..]));
        let mut tips = target_pool(robot, &targets, Seed(7)).unwrap();
        tips.extend(waypoints(robot, &path, Seed(7)).unwrap());
        let recorded = [samples, played, pool.steps, simulated.steps];
        let rows =
            recorded.iter().flat_map(|samples| [&samples.from_m, &samples.pulls_m, &samples.to_m]);
        let numbers =
            rows.chain([&pool.real_m, &simulated.real_m]).flat_map(|rows| rows.values().to_vec());
        numbers.chain(tips.into_iter().flatten()).collect::<Vec<f64>>()
    };
    let whole = record(&mut at_once(SHIFT_M));
    let sees: [fn(usize) -> bool; 3] =
        [|look| look % 5 != 0, |look| look % 11 == 10, |look| look % 2 == 1];
    for sees in sees {
        let blinked = record(&mut Blinking::new(sees));
        assert_eq!(blinked.len(), whole.len());
        assert!(
            blinked.iter().zip(&whole).all(|(a, b)| (a - b).abs() < 1e-12),
            "not the same recordings"
        );
    }
    let mut gone = Blinking::new(|look| look < 30);
    let error = explore(&mut gone, &walk, Seed(7)).unwrap_err();
    assert_eq!(error, TaskError::Plant(PlantError::Unseen { steps: 10 }));
    assert_eq!(gone.looks, 30 + 1 + 10, "it is not waited for ever");
    assert!(error.to_string().starts_with("tracking lost: "), "{error}");
}

#[test]
fn generated_samples_are_the_real_ones_where_the_error_model_is_exact() {
    let options = ExploreOptions { points: 300, trajectories: 2, ..ExploreOptions::default() };
    let model = explore(&mut at_once([0.0; 3]), &options, Seed(7)).unwrap();
    let real = replay(&mut at_once(SHIFT_M), &model, Seed(7)).unwrap();
    let generated = correct_samples(&model, &ConstantError(negative(SHIFT_M))).unwrap();
    assert_eq!((&generated.pulls_m, &generated.starts), (&real.pulls_m, &real.starts));
    for (found, expected) in [(&generated.from_m, &real.from_m), (&generated.to_m, &real.to_m)] {
        assert_eq!(found.len(), expected.len());
        assert!(found.values().iter().zip(expected.values()).all(|(a, b)| (a - b).abs() < 1e-12));
    }
    assert_eq!(
        correct_samples(&model, &ConstantError([f64::NAN; 3])),
        Err(TaskError::NotFinite("error model"))
    );
}

#[test]
fn the_first_samples_keep_their_trajectories() {
    let options = ExploreOptions { points: 100, trajectories: 4, ..ExploreOptions::default() };
    let samples = explore(&mut noisy(), &options, Seed(3)).unwrap().first(60);
    assert_eq!((samples.len(), samples.starts.as_slice()), (60, &[0, 25, 50][..]));
}

#[test]
fn gp_points_hold_the_gap_and_their_inputs() {
    for layout in [
        PointLayout::Grid(GridOptions::default()),
        PointLayout::Walk { points: 1_000, every: 3, max_step_m: 0.003, max_pull_m: 0.03 },
    ] {
        let options = GpPointsOptions { layout, ..GpPointsOptions::default() };
        let points = gp_points(&mut at_once([0.0; 3]), &mut at_once(SHIFT_M), &options, Seed(9))
            .unwrap()
            .points();
        assert_eq!(
            (points.inputs.len(), points.inputs.width(), points.errors_m.len()),
            (1_000, 7, 1_000)
        );
        for index in 0..points.inputs.len() {
            for (axis, shift_m) in SHIFT_M.into_iter().enumerate() {
                assert!(
                    (points.errors_m.row(index)[axis] + shift_m).abs() < 1e-12,
                    "e = p_sim - p_exp"
                );
                let simulated_m = points.inputs.row(index)[4 + axis];
                assert!((simulated_m - points.real_m.row(index)[axis] + shift_m).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn consecutive_grid_points_are_neighbours_and_cover_the_square() {
    let options = GpPointsOptions::default();
    let points = gp_points(&mut at_once([0.0; 3]), &mut at_once([0.0; 3]), &options, Seed(9))
        .unwrap()
        .points();
    let bends: Vec<[f64; 2]> = points.inputs.iter().map(|row| [row[0], row[1]]).collect();
    for pair in bends.windows(2) {
        assert!((0..2).all(|axis| (pair[1][axis] - pair[0][axis]).abs() <= 0.003 + 1e-12));
    }
    for corner in [[-0.03, -0.03], [-0.03, 0.03], [0.03, -0.03], [0.03, 0.03]] {
        assert!(
            bends.iter().any(|bend| (0..2).all(|axis| (bend[axis] - corner[axis]).abs() < 1e-12))
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn one_point_of_each_cluster(count in 1..=1_000_usize, seed in any::<u64>()) {
        let mut rows = Rows::new(1);
        (0..1_000).map(f64::from).for_each(|x| rows.push(&[x]));
        let chosen = Selection::Clusters.choose(&rows, count, Seed(seed)).unwrap();
        prop_assert_eq!(chosen.len(), count);
        for (cluster, index) in chosen.iter().enumerate() {
            prop_assert!((cluster * 1_000 / count..(cluster + 1) * 1_000 / count).contains(index));
        }
    }
}

#[test]
fn targets_are_unique_equally_spaced_and_reachable() {
    let pool = target_pool(&mut robot(SHIFT_M), &TargetOptions::default(), Seed(11)).unwrap();
    assert_eq!(pool.len(), 960);
    let nearest_m: Vec<f64> = (0..pool.len())
        .map(|index| {
            (0..pool.len())
                .filter(|other| *other != index)
                .map(|other| distance_m(&pool[index], &pool[other]))
                .fold(f64::INFINITY, f64::min)
        })
        .collect();
    let (least_m, most_m) =
        nearest_m.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
    assert!(
        least_m > 0.002 && most_m < 2.0 * least_m,
        "nearest neighbours {least_m} to {most_m} m apart"
    );
    for target_m in &pool {
        let unshifted_m = std::array::from_fn(|axis| target_m[axis] - SHIFT_M[axis]);
        let options = ConstantCurvatureOptions::default();
        let pulls_m = ConstantCurvature::pulls_m(&options, &unshifted_m);
        let radius_m = options.tendon_radius_m;
        let again_m =
            ConstantCurvature::tip_m(&options, [pulls_m[0] / radius_m, pulls_m[1] / radius_m]);
        assert!(
            distance_m(&again_m, &unshifted_m) < 1e-9
                && pulls_m.iter().all(|pull| pull.abs() <= 0.03 + 1e-12)
        );
    }
}

#[test]
fn targets_are_drawn_by_the_experiment_and_are_not_training_points() {
    let options = TargetOptions::default();
    let mut plant = robot(SHIFT_M);
    let pool = target_pool(&mut plant, &options, Seed(11)).unwrap();
    let drawn = draw_targets(&pool, options.drawn, Seed(11)).unwrap();
    assert_eq!(drawn.len(), 50);
    assert_eq!(drawn, draw_targets(&pool, 50, Seed(11)).unwrap());
    assert_ne!(drawn, draw_targets(&pool, 50, Seed(12)).unwrap());
    assert_eq!(drawn[..20], draw_targets(&pool, 20, Seed(11)).unwrap()[..]);
    let mut numbers: Vec<usize> = drawn.iter().map(|(index, _)| *index).collect();
    numbers.sort_unstable();
    numbers.dedup();
    assert_eq!(numbers.len(), 50);
    let walk = explore(&mut robot([0.0; 3]), &ExploreOptions::default(), Seed(11)).unwrap();
    let real = replay(&mut plant, &walk, Seed(11)).unwrap();
    let gp = gp_points(&mut robot([0.0; 3]), &mut plant, &GpPointsOptions::default(), Seed(11))
        .unwrap()
        .points();
    for (_, target_m) in &drawn {
        assert!(real.to_m.iter().chain(gp.real_m.iter()).all(|tip_m| tip_m != target_m));
    }
}

#[test]
fn sizes_larger_than_the_data_are_errors_that_name_the_key() {
    let key = |result: Result<(), TaskError>| match result {
        Err(TaskError::Option(bad)) => bad.key,
        other => panic!("{other:?}"),
    };
    let mut targets = TargetOptions { pool: 5_000, ..TargetOptions::default() };
    assert_eq!(key(target_pool(&mut robot(SHIFT_M), &targets, Seed(1)).map(drop)), "pool");
    targets.pool = 40;
    assert_eq!(key(target_pool(&mut robot(SHIFT_M), &targets, Seed(1)).map(drop)), "drawn");
    let walk = ExploreOptions { points: 3, trajectories: 4, ..ExploreOptions::default() };
    assert_eq!(key(explore(&mut robot(SHIFT_M), &walk, Seed(1)).map(drop)), "trajectories");
    let walk = ExploreOptions { max_step_m: 0.04, ..ExploreOptions::default() };
    assert_eq!(key(explore(&mut robot(SHIFT_M), &walk, Seed(1)).map(drop)), "max_step_m");
    let path = PathOptions { spacing_m: f64::NAN, ..PathOptions::default() };
    assert_eq!(key(interpolate(&[[0.0; 3]], &path).map(drop)), "spacing_m");
    assert!(matches!(
        draw_targets(&[[0.0; 3]; 4], 5, Seed(1)),
        Err(TaskError::TooFew { required: 5, available: 4, .. })
    ));
    assert!(matches!(
        spread_targets(&[[0.0; 3]; 4], 2),
        Err(TaskError::TooFew { required: 2, available: 1, .. })
    ));
}

#[test]
fn the_path_passes_through_33_tips_and_closes() {
    let options = PathOptions::default();
    let points = waypoints(&mut robot(SHIFT_M), &options, Seed(1)).unwrap();
    assert_eq!(points.len(), 33);
    let path = interpolate(&points, &options).unwrap();
    assert!(
        path.windows(2).all(|pair| distance_m(&pair[0], &pair[1]) <= options.spacing_m + 1e-12)
    );
    assert!(points.iter().all(|point| path.contains(point)));
    assert_eq!(path.first(), path.last());
    let open = interpolate(&points, &PathOptions { closed: false, ..options }).unwrap();
    assert_eq!(open.last(), points.last());
    assert!(robot(SHIFT_M).reset(Seed(1)).unwrap().valid);
}
