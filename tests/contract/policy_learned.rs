//! Learned models as the parts of policies, on the constant-curvature robot.

use std::sync::Arc;

use crate::support::policies::{policy, reachable, robot};
use spinebench::base::{Point3, Rows, Seed};
use spinebench::learn::LearnError;
use spinebench::learn::gp::{Gp, GpConfig};
use spinebench::learn::networks::{Network, NetworkConfig};
use spinebench::learn::selection::Selection;
use spinebench::policies::{
    ErrorModel, ForwardModel, GpError, INVERSE, INVERSE_B, InverseModel, NetworkForward,
    NetworkInverse, PolicyOptions, PolicyParts,
};
use spinebench::tasks::{
    ExploreOptions, GpPointsOptions, LoopMode, ReachOptions, Transitions, correct_samples, explore,
    gp_points, reach, rollout,
};

const SHIFT_M: Point3 = [-0.012, 0.004, 0.0];

fn pairs(samples: &Transitions) -> Rows {
    let mut inputs = Rows::new(6);
    for (from_m, to_m) in samples.from_m.iter().zip(samples.to_m.iter()) {
        inputs.push(&[from_m, to_m].concat());
    }
    inputs
}

fn train(samples: &Transitions) -> Arc<Network> {
    let config = NetworkConfig { max_epochs: 40, ..NetworkConfig::default() };
    let trained =
        Network::train(&pairs(samples), &samples.pulls_m, &samples.starts, &config, Seed(2))
            .unwrap();
    Arc::new(trained.network)
}

fn exploration(points: usize) -> Transitions {
    explore(&mut robot([0.0; 3]), &ExploreOptions { points, ..ExploreOptions::default() }, Seed(1))
        .unwrap()
}

fn error_model() -> GpError {
    let points =
        gp_points(&mut robot([0.0; 3]), &mut robot(SHIFT_M), &GpPointsOptions::default(), Seed(1))
            .unwrap()
            .points();
    let sparse = points.select(&Selection::Clusters.choose(&points.inputs, 100, Seed(1)).unwrap());
    GpError::new(Gp::fit(&sparse.inputs, &sparse.errors_m, &GpConfig::default()).unwrap(), 4)
        .unwrap()
}

#[test]
fn within_a_tick_the_network_answers_alike_and_over_ticks_as_in_a_sequence() {
    let samples = exploration(400);
    let network = train(&samples);
    let inputs = pairs(&samples).select(&[0, 1, 2, 3]);
    let expected = network.predict_rows(&inputs, &[]).unwrap();
    let mut inverse = NetworkInverse::new(network).unwrap();
    for _ in 0..2 {
        inverse.reset();
        for (row, expected) in inputs.iter().zip(expected.iter()) {
            let (from_m, to_m) = ([row[0], row[1], row[2]], [row[3], row[4], row[5]]);
            inverse.pulls(&to_m, &from_m).unwrap();
            assert_eq!(inverse.pulls(&from_m, &to_m).unwrap(), expected);
            assert_eq!(inverse.pulls(&from_m, &to_m).unwrap(), expected);
            inverse.tick();
        }
    }
}

/// Trained on (u_i, x_i) → x_{i+1}, eq. (17).
fn forward_network(samples: &Transitions) -> Arc<Network> {
    let config = NetworkConfig { max_epochs: 200, ..NetworkConfig::default() };
    let mut inputs = Rows::new(7);
    for (pulls_m, from_m) in samples.pulls_m.iter().zip(samples.from_m.iter()) {
        inputs.push(&[pulls_m, from_m].concat());
    }
    Arc::new(
        Network::train(&inputs, &samples.to_m, &samples.starts, &config, Seed(3)).unwrap().network,
    )
}

#[test]
fn a_forward_network_stands_for_the_rod_in_the_points_of_the_error_model() {
    let network = forward_network(&exploration(6_000));
    let pool =
        gp_points(&mut robot([0.0; 3]), &mut robot(SHIFT_M), &GpPointsOptions::default(), Seed(1))
            .unwrap();
    let imagined =
        rollout(&pool.steps, &mut NetworkForward::new(network.clone(), 4).unwrap()).unwrap();

    // It starts at the recorded home and is then fed with what it predicted itself.
    let mut model = NetworkForward::new(network, 4).unwrap();
    let home = imagined.from_m.row(0);
    assert_eq!(home, pool.steps.from_m.row(0));
    model.reset(&[home[0], home[1], home[2]]);
    for index in 0..imagined.len() {
        assert_eq!(imagined.to_m.row(index), model.next_m(pool.steps.pulls_m.row(index)).unwrap());
        let follows = index + 1 == imagined.len()
            || imagined.from_m.row(index + 1) == imagined.to_m.row(index);
        assert!(follows, "step {index}");
    }

    // Same commands, same measurements, another p_sim; e is the difference to what was measured.
    let (rod, network) = (pool.points(), pool.points_by(&imagined));
    assert_eq!((&rod.real_m, rod.inputs.len()), (&network.real_m, network.inputs.len()));
    let mut apart_m: f64 = 0.0;
    for index in 0..rod.inputs.len() {
        assert_eq!(rod.inputs.row(index)[..4], network.inputs.row(index)[..4]);
        for axis in 0..3 {
            let p_sim_m = network.inputs.row(index)[4 + axis];
            assert_eq!(
                network.errors_m.row(index)[axis],
                p_sim_m - network.real_m.row(index)[axis]
            );
            apart_m = apart_m.max((p_sim_m - rod.inputs.row(index)[4 + axis]).abs());
        }
    }
    assert!(
        apart_m > 0.0 && apart_m < 0.03,
        "the network follows the rod, not exactly: {apart_m} m"
    );
}

#[test]
fn models_of_the_wrong_width_are_refused() {
    let samples = exploration(400);
    let config = NetworkConfig { max_epochs: 1, ..NetworkConfig::default() };
    let forward =
        Network::train(&samples.pulls_m, &samples.to_m, &[], &config, Seed(2)).unwrap().network;
    let forward = Arc::new(forward);
    assert!(matches!(
        NetworkForward::new(forward.clone(), 4),
        Err(LearnError::Shape { found: 4, expected: 7, .. })
    ));
    assert!(matches!(
        NetworkInverse::new(forward),
        Err(LearnError::Shape { found: 4, expected: 6, .. })
    ));
    let few = samples.first(30);
    let gp =
        Gp::fit(&few.pulls_m, &few.to_m, &GpConfig { starts: 1, ..GpConfig::default() }).unwrap();
    assert!(matches!(GpError::new(gp, 4), Err(LearnError::Shape { found: 4, expected: 7, .. })));
}

#[test]
fn a_hundred_points_find_a_constant_gap() {
    let error = error_model();
    for (x_m, y_m) in [(0.01, 0.005), (-0.02, 0.01), (0.0, -0.015)] {
        let found_m = error.error_m(&[x_m, y_m, -x_m, -y_m], &reachable(x_m, y_m, [0.0; 3]));
        for (found, shift) in found_m.iter().zip(SHIFT_M) {
            assert!((found + shift).abs() < 1e-4, "{found} m against {} m", -shift);
        }
    }
    assert!(error.error_m(&[0.0; 3], &[0.0; 3]).iter().all(|value| value.is_nan()));
}

#[test]
fn learned_policies_come_close_and_repeat_to_the_bit() {
    let samples = exploration(3_000);
    let error: Arc<dyn ErrorModel> = Arc::new(error_model());
    let simulated = train(&samples);
    let generated = train(&correct_samples(&samples, error.as_ref()).unwrap());
    let run = |name: &str| {
        let parts = PolicyParts::default()
            .with_inverse(&INVERSE, Box::new(NetworkInverse::new(simulated.clone()).unwrap()))
            .with_inverse(&INVERSE_B, Box::new(NetworkInverse::new(generated.clone()).unwrap()))
            .with_error(error.clone());
        let mut policy = policy(name, parts, &PolicyOptions::default());
        [(0.012, 0.0), (-0.01, 0.01), (0.005, -0.014)].map(|(x_m, y_m)| {
            let target_m = reachable(x_m, y_m, SHIFT_M);
            let options = ReachOptions::default();
            reach(
                &mut robot(SHIFT_M),
                policy.as_mut(),
                &target_m,
                LoopMode::Closed,
                &options,
                Seed(1),
            )
            .unwrap()
        })
    };
    for name in ["a", "b", "c"] {
        let outcomes = run(name);
        assert_eq!(outcomes, run(name), "{name}");
        for outcome in outcomes {
            assert!(outcome.status.is_ok(), "{}", outcome.status);
            // Home is 0.05 to 0.08 m away from these targets and the gap is 12.6 mm.
            assert!(outcome.error_m < 0.0126, "{name}: {} m", outcome.error_m);
        }
    }
}
