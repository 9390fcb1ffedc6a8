//! Training and use of networks on systems whose laws are known.

use rand::RngExt;
use spinebench::base::{Rows, Seed};
use spinebench::learn::LearnError;
use spinebench::learn::networks::{Loss, Network, NetworkConfig, NetworkKind, Optimiser, Stopped};

/// `y_t` follows a saturating state that remembers about five inputs: s ← 0.8 s + 0.3 tanh(2 u), y
/// = (s, s u).
fn remembering_system(count: usize) -> (Rows, Rows) {
    let mut rng = Seed(5).child("system").rng();
    let (mut inputs, mut outputs, mut state) = (Rows::new(1), Rows::new(2), 0.0);
    for _ in 0..count {
        let u: f64 = rng.random_range(-0.03..0.03);
        state = 0.8 * state + 0.3 * (60.0 * u).tanh();
        inputs.push(&[u]);
        outputs.push(&[0.02 * state, 0.02 * state * (u / 0.03)]);
    }
    (inputs, outputs)
}

fn quick() -> NetworkConfig {
    NetworkConfig { hidden: 12, max_epochs: 150, ..NetworkConfig::default() }
}

fn spread(outputs: &Rows) -> f64 {
    outputs.values().iter().map(|y| y.abs()).sum::<f64>() / outputs.values().len() as f64
}

#[test]
fn memory_is_learnt_and_a_memoryless_network_cannot() {
    let (inputs, outputs) = remembering_system(2500);
    // Errors must reach back as far as the system remembers: 0.8²⁵ < 1 %.
    let longer = NetworkConfig { window: 25, max_epochs: 600, ..quick() };
    let recurrent = Network::train(&inputs, &outputs, &[], &longer, Seed(1)).unwrap();
    let memoryless = NetworkConfig { window: 1, stride: 1, batch: 64, ..quick() };
    let memoryless = Network::train(&inputs, &outputs, &[], &memoryless, Seed(1)).unwrap();
    let scale = spread(&outputs);
    assert!(recurrent.validation_mae < 0.06 * scale, "{} of {scale}", recurrent.validation_mae);
    assert!(memoryless.validation_mae > 0.3 * scale, "{} of {scale}", memoryless.validation_mae);
    // A network trained on single rows does not look at its state.
    let network = &memoryless.network;
    let (mut fresh, mut used) = (network.state(), network.state());
    let (mut a, mut b) = ([0.0; 2], [0.0; 2]);
    network.step(&mut used, inputs.row(7), &mut b).unwrap();
    network.step(&mut used, inputs.row(8), &mut b).unwrap();
    network.step(&mut fresh, inputs.row(8), &mut a).unwrap();
    assert_eq!(a, b);
}

#[test]
fn every_kind_learns_what_its_memory_reaches() {
    let (inputs, outputs) = remembering_system(2500);
    let scale = spread(&outputs);
    let error = |config: NetworkConfig| {
        Network::train(&inputs, &outputs, &[], &config, Seed(1)).unwrap().validation_mae
    };
    let of = |kind| NetworkConfig { kind, window: 25, max_epochs: 300, ..quick() };
    for kind in [NetworkKind::Gru, NetworkKind::Lstm] {
        let found = error(of(kind));
        assert!(found < 0.06 * scale, "{kind:?}: {found} of {scale}");
    }
    // What a network without memory knows of the past is the history that it is shown.
    let [short, long] = [1, 20]
        .map(|rows| error(NetworkConfig { history: Some(rows), ..of(NetworkKind::FeedForward) }));
    assert!(short > 0.3 * scale && long < 0.5 * short, "{short}, {long} of {scale}");
}

#[test]
fn a_network_without_memory_forgets_what_is_older_than_its_history() {
    let (inputs, outputs) = remembering_system(400);
    let config = NetworkConfig { kind: NetworkKind::FeedForward, max_epochs: 3, ..quick() };
    let network = Network::train(&inputs, &outputs, &[], &config, Seed(1)).unwrap().network;
    assert_eq!((network.kind(), network.inputs()), (NetworkKind::FeedForward, 1));
    let answer = |rows: &[usize]| {
        let (mut state, mut out) = (network.state(), [0.0; 2]);
        rows.iter().for_each(|&row| network.step(&mut state, inputs.row(row), &mut out).unwrap());
        out
    };
    assert_eq!(answer(&[9, 1, 2, 3, 4]), answer(&[7, 8, 1, 2, 3, 4]));
    assert_ne!(answer(&[9, 2, 3, 4]), answer(&[1, 2, 3, 4]));
    // Before the first row stands that row: a robot at rest.
    assert_eq!(answer(&[1, 1, 1, 1]), answer(&[1]));
}

#[test]
fn members_are_trained_apart_and_answer_with_their_mean() {
    let (inputs, outputs) = remembering_system(800);
    let config = NetworkConfig { max_epochs: 40, ..quick() };
    let alone = Network::train(&inputs, &outputs, &[], &config, Seed(1)).unwrap();
    let five = NetworkConfig { members: 5, ..config.clone() };
    let together = Network::train(&inputs, &outputs, &[], &five, Seed(1)).unwrap();
    assert_eq!(together.network.members(), 5);
    assert_eq!(
        together.history[..alone.history.len()],
        alone.history,
        "the first member has the network's own seed"
    );
    let best_alone = |member: usize| {
        let from = together
            .history
            .iter()
            .enumerate()
            .filter(|(_, one)| one.epoch == 1)
            .nth(member)
            .unwrap()
            .0;
        let own = together.history[from..]
            .iter()
            .enumerate()
            .take_while(|(k, one)| *k == 0 || one.epoch > 1);
        own.map(|(_, one)| one.validation_mae).fold(f64::INFINITY, f64::min)
    };
    let mean = (0..5).map(best_alone).sum::<f64>() / 5.0;
    assert!(together.validation_mae < mean, "{} of {mean}", together.validation_mae);
    let text = serde_json::to_string(&together.network).unwrap();
    assert_eq!(serde_json::from_str::<Network>(&text).unwrap(), together.network);
    let again = together.network.retrain(&inputs, &outputs, &[], &config, Seed(2)).unwrap();
    assert_eq!(again.network.members(), 5);
}

#[test]
fn an_optimiser_of_second_order_needs_fewer_steps() {
    let (inputs, outputs) = remembering_system(800);
    let config =
        NetworkConfig { window: 20, optimiser: Optimiser::Lbfgs, max_epochs: 150, ..quick() };
    let found = Network::train(&inputs, &outputs, &[], &config, Seed(1)).unwrap();
    let adam = NetworkConfig {
        optimiser: Optimiser::Adam,
        max_epochs: found.updates.div_ceil(2),
        ..config
    };
    let adam = Network::train(&inputs, &outputs, &[], &adam, Seed(1)).unwrap();
    assert!(adam.updates >= found.updates, "{} {}", adam.updates, found.updates);
    assert!(
        found.validation_mae < adam.validation_mae,
        "{} {}",
        found.validation_mae,
        adam.validation_mae
    );
    assert!(found.history.windows(2).all(|pair| pair[1].training_loss < pair[0].training_loss));
}

#[test]
fn networks_written_before_there_were_kinds_are_read() {
    let (inputs, outputs) = remembering_system(300);
    let config = NetworkConfig { max_epochs: 1, ..quick() };
    let network = Network::train(&inputs, &outputs, &[], &config, Seed(1)).unwrap().network;
    let text = serde_json::to_string(&network).unwrap();
    let old = text.replace(",\"kind\":\"elman\",\"history\":1", "");
    assert!(old.len() < text.len());
    assert_eq!(serde_json::from_str::<Network>(&old).unwrap(), network);
    // Defaults are not written: a setting that nobody made has no part in what a result depends on.
    assert!(!serde_json::to_string(&NetworkConfig::default()).unwrap().contains("kind"));
}

#[test]
fn both_losses_learn() {
    let (inputs, outputs) = remembering_system(1500);
    let config = NetworkConfig { loss: Loss::LastRow, stride: 1, max_epochs: 60, ..quick() };
    let trained = Network::train(&inputs, &outputs, &[], &config, Seed(1)).unwrap();
    assert!(trained.validation_mae < 0.15 * spread(&outputs), "{}", trained.validation_mae);
}

#[test]
fn the_best_weights_are_kept_and_their_error_is_what_is_reported() {
    let (inputs, outputs) = remembering_system(600);
    // A rate far too high for the end: the error jumps about.
    let config = NetworkConfig {
        learning_rate: 0.05,
        decay: 1.0,
        patience: 12,
        decay_patience: 1000,
        max_epochs: 400,
        ..quick()
    };
    let trained = Network::train(&inputs, &outputs, &[], &config, Seed(2)).unwrap();
    assert_eq!(trained.stopped, Stopped::Patience);
    assert_eq!(trained.history.len(), trained.epochs);
    let best = trained.history.iter().map(|e| e.validation_mae).fold(f64::INFINITY, f64::min);
    let last = trained.history.last().unwrap();
    assert_eq!(trained.validation_mae, best);
    assert!(last.validation_mae > best);
    assert_eq!(
        trained.epochs - trained.history.iter().find(|e| e.validation_mae == best).unwrap().epoch,
        12
    );
    // The last 30 % of the rows, run through from a reset.
    let held: Vec<usize> = (420..600).collect();
    let answers = trained.network.predict_rows(&inputs.select(&held), &[]).unwrap();
    let truth = outputs.select(&held);
    let errors = answers.values().iter().zip(truth.values()).map(|(a, b)| (a - b).abs());
    assert!((errors.sum::<f64>() / 360.0 - best).abs() < 1e-15);
}

#[test]
fn training_stops_at_the_error_that_is_asked_for() {
    let (inputs, outputs) = remembering_system(1500);
    let free = Network::train(&inputs, &outputs, &[], &quick(), Seed(3)).unwrap();
    let target = 4.0 * free.validation_mae;
    let config = NetworkConfig { stop_at_validation_mae_m: Some(target), ..quick() };
    let trained = Network::train(&inputs, &outputs, &[], &config, Seed(3)).unwrap();
    assert_eq!(trained.stopped, Stopped::Reached);
    assert!(
        trained.validation_mae <= target && trained.validation_mae > 0.5 * target,
        "{}",
        trained.validation_mae
    );
    assert!(trained.updates < free.updates);
    let never = NetworkConfig { stop_at_validation_mae_m: Some(1e-9), max_epochs: 3, ..quick() };
    assert_eq!(
        Network::train(&inputs, &outputs, &[], &never, Seed(3)).unwrap().stopped,
        Stopped::Epochs
    );
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_does_not() {
    let (inputs, outputs) = remembering_system(400);
    let config = NetworkConfig { max_epochs: 5, ..quick() };
    let text = |seed| {
        serde_json::to_string(&Network::train(&inputs, &outputs, &[], &config, seed).unwrap())
            .unwrap()
    };
    assert_eq!(text(Seed(1)), text(Seed(1)));
    assert_ne!(text(Seed(1)), text(Seed(2)));
}

#[test]
fn what_is_written_is_read_back_to_the_bit() {
    let (inputs, outputs) = remembering_system(300);
    let config = NetworkConfig { max_epochs: 3, ..quick() };
    let trained = Network::train(&inputs, &outputs, &[], &config, Seed(1)).unwrap();
    assert_eq!(trained, serde_json::from_str(&serde_json::to_string(&trained).unwrap()).unwrap());
    let network = trained.network;
    let text = serde_json::to_string(&network).unwrap();
    let back: Network = serde_json::from_str(&text).unwrap();
    assert_eq!(network, back);
    assert_eq!(
        network.predict_rows(&inputs, &[]).unwrap(),
        back.predict_rows(&inputs, &[]).unwrap()
    );
    let broken = text.replacen("\"hidden\":12", "\"hidden\":13", 1);
    assert!(
        serde_json::from_str::<Network>(&broken)
            .unwrap_err()
            .to_string()
            .contains("stored weights")
    );
}

#[test]
fn rows_and_steps_agree_and_a_reset_forgets() {
    let (inputs, outputs) = remembering_system(300);
    let config = NetworkConfig { max_epochs: 3, ..quick() };
    let network = Network::train(&inputs, &outputs, &[], &config, Seed(1)).unwrap().network;
    let rows = network.predict_rows(&inputs, &[100]).unwrap();
    let (mut state, mut out) = (network.state(), [0.0; 2]);
    for (index, row) in inputs.iter().enumerate() {
        if index == 100 {
            state.reset();
        }
        network.step(&mut state, row, &mut out).unwrap();
        assert_eq!(rows.row(index), out);
    }
    assert_ne!(
        rows.row(100),
        network.predict_rows(&inputs, &[]).unwrap().row(100),
        "the state must matter"
    );
}

#[test]
fn answers_stay_bounded_far_outside_the_data() {
    let (inputs, outputs) = remembering_system(600);
    let config = NetworkConfig { max_epochs: 20, ..quick() };
    let network = Network::train(&inputs, &outputs, &[], &config, Seed(1)).unwrap().network;
    let (mut state, mut out) = (network.state(), [0.0; 2]);
    for far in [1e3, -1e9, 1e300, 0.0] {
        network.step(&mut state, &[far], &mut out).unwrap();
        assert!(out.iter().all(|y| y.abs() < 100.0 * spread(&outputs)), "{far}: {out:?}");
    }
}

#[test]
fn retraining_starts_from_the_weights() {
    let (inputs, outputs) = remembering_system(1500);
    let first = Network::train(&inputs, &outputs, &[], &quick(), Seed(1)).unwrap();
    let mut shifted = Rows::new(2);
    outputs.iter().for_each(|y| shifted.push(&[1.1 * y[0] + 0.001, y[1]]));
    let short = NetworkConfig { max_epochs: 8, ..quick() };
    let warm = first.network.retrain(&inputs, &shifted, &[], &short, Seed(4)).unwrap();
    let cold = Network::train(&inputs, &shifted, &[], &short, Seed(4)).unwrap();
    assert!(
        warm.validation_mae < 0.7 * cold.validation_mae,
        "{} {}",
        warm.validation_mae,
        cold.validation_mae
    );
    assert!(first.network.retrain(&outputs, &shifted, &[], &short, Seed(4)).is_err());
}

#[test]
fn bad_input_is_named() {
    let (inputs, outputs) = remembering_system(100);
    let train = |x: &Rows, y: &Rows, c: &NetworkConfig| {
        Network::train(x, y, &[], c, Seed(1)).map(|_| ()).unwrap_err()
    };
    let mut bad = Rows::new(2);
    outputs
        .iter()
        .enumerate()
        .for_each(|(i, y)| bad.push(&[y[0], if i == 9 { f64::INFINITY } else { y[1] }]));
    let refused = train(&inputs, &bad, &quick());
    assert!(
        matches!(refused, LearnError::NotFinite { table: "outputs", row: 9, column: 1, .. }),
        "{refused}"
    );
    let refused = train(&inputs.select(&[0, 1, 2]), &outputs.select(&[0, 1, 2]), &quick());
    assert!(matches!(refused, LearnError::TooFewRows { found: 3, .. }), "{refused}");
    let refused = train(&inputs, &outputs.select(&[0]), &quick());
    assert!(matches!(refused, LearnError::Shape { .. }), "{refused}");
    for (key, config) in [
        ("hidden", NetworkConfig { hidden: 0, ..quick() }),
        ("history", NetworkConfig { history: Some(0), ..quick() }),
        ("members", NetworkConfig { members: 101, ..quick() }),
        ("window", NetworkConfig { window: 0, ..quick() }),
        ("train_share", NetworkConfig { train_share: 1.5, ..quick() }),
        ("learning_rate", NetworkConfig { learning_rate: f64::NAN, ..quick() }),
        (
            "stop_at_validation_mae_m",
            NetworkConfig { stop_at_validation_mae_m: Some(-1.0), ..quick() },
        ),
    ] {
        let refused = train(&inputs, &outputs, &config);
        assert!(
            matches!(refused, LearnError::Setting { key: found, .. } if found == key),
            "{refused}"
        );
    }
    assert!(matches!(
        Network::train(&inputs, &outputs, &[0, 0], &quick(), Seed(1)).unwrap_err(),
        LearnError::Sequences { place: 1, .. }
    ));
    let network = Network::train(
        &inputs,
        &outputs,
        &[],
        &NetworkConfig { max_epochs: 1, ..quick() },
        Seed(1),
    );
    let network = network.unwrap().network;
    let mut state = network.state();
    assert!(matches!(
        network.step(&mut state, &[f64::NAN], &mut [0.0; 2]),
        Err(LearnError::NotFinite { .. })
    ));
    assert!(matches!(
        network.step(&mut state, &[0.0; 2], &mut [0.0; 2]),
        Err(LearnError::Shape { .. })
    ));
    let typo = serde_yaml::from_str::<NetworkConfig>("windows: 10").unwrap_err().to_string();
    assert!(typo.contains("windows"), "{typo}");
    let read: NetworkConfig =
        serde_yaml::from_str("{window: 1, stride: 1, loss: last_row}").unwrap();
    assert_eq!((read.window, read.loss, read.hidden), (1, Loss::LastRow, 30));
}
