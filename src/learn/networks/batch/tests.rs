//! Losses and gradients by definition, by finite differences and beside a peer's.

use super::super::kinds::NetworkKind;
use super::*;
use crate::base::Seed;

/// The units' formulas as they are printed: value and memory after a step.
fn unit(kind: NetworkKind, sums: &[f64], value: f64, memory: f64) -> (f64, f64) {
    let sigma = |x: f64| 1.0 / (1.0 + (-x).exp());
    match kind {
        NetworkKind::Elman | NetworkKind::FeedForward => (sums[0].tanh(), 0.0),
        NetworkKind::Gru => {
            let update = sigma(sums[1]);
            let candidate = (sums[2] + sigma(sums[0]) * sums[3]).tanh();
            ((1.0 - update) * candidate + update * value, 0.0)
        }
        NetworkKind::Lstm => {
            let memory = sigma(sums[1]) * memory + sigma(sums[0]) * sums[2].tanh();
            (sigma(sums[3]) * memory.tanh(), memory)
        }
    }
}

/// Plain recurrences, one sample at a time.
fn loss_by_definition(
    w: &Weights<f64>,
    x: &[f64],
    y: &[f64],
    starts: &[u32],
    window: usize,
    loss: Loss,
) -> f64 {
    let Sizes { kind, inputs, hidden, outputs } = w.sizes;
    let (units, ports, stride) = (w.sizes.units(), w.sizes.ports(), w.sizes.row_len());
    let [from_inputs, from_state, bias] = w.hidden();
    let (mut sum, mut count) = (0.0, 0.0);
    for &start in starts {
        let mut state = vec![(0.0, 0.0); hidden];
        for t in 0..window {
            let row = start as usize + t;
            let sum_of = |column: usize| {
                bias[column]
                    + (0..inputs)
                        .map(|i| from_inputs[i * stride + column] * x[row * inputs + i])
                        .sum::<f64>()
                    + (0..hidden).map(|k| from_state[k * stride + column] * state[k].0).sum::<f64>()
            };
            state = (0..hidden)
                .map(|u| {
                    let sums: Vec<f64> = (0..kind.weighted_sums().len())
                        .map(|block| sum_of(block * units + u))
                        .collect();
                    unit(kind, &sums, state[u].0, state[u].1)
                })
                .collect();
            if loss == Loss::EveryRow || t + 1 == window {
                for o in 0..outputs {
                    let weight = |r: usize| w.output()[r * ports + o];
                    let out =
                        weight(hidden) + (0..hidden).map(|k| weight(k) * state[k].0).sum::<f64>();
                    sum += (out - y[row * outputs + o]).powi(2);
                    count += 1.0;
                }
            }
        }
    }
    sum / count
}

fn samples(count: usize, phase: f64) -> Vec<f64> {
    (0..count).map(|i| (i as f64 * 0.7 + phase).sin()).collect()
}

fn check(sizes: Sizes, window: usize, windows: usize, loss: Loss) {
    let rows = windows + window;
    let (x, y) = (samples(rows * sizes.inputs, 0.1), samples(rows * sizes.outputs, 1.3));
    let starts: Vec<u32> = (0..windows as u32).collect();
    let mut weights = Weights::<f64>::random(sizes, Seed(3));
    let mut gradient = Weights::zeros(sizes);
    let mut batch = SequenceBatch::new(sizes, window, windows + 5, loss);
    batch.load(&x, &y, &starts);
    let value = batch.loss_and_gradient(&weights, &mut gradient);
    assert!((value - loss_by_definition(&weights, &x, &y, &starts, window, loss)).abs() < 1e-14);
    let mut used = 0;
    for k in 0..weights.values.len() {
        if weights.values[k] == 0.0 {
            assert_eq!(gradient.values[k], 0.0, "padding must not move");
            continue;
        }
        let (saved, e) = (weights.values[k], 1e-5);
        weights.values[k] = saved + e;
        let above = loss_by_definition(&weights, &x, &y, &starts, window, loss);
        weights.values[k] = saved - e;
        let below = loss_by_definition(&weights, &x, &y, &starts, window, loss);
        weights.values[k] = saved;
        let expected = (above - below) / (2.0 * e);
        assert!(
            (gradient.values[k] - expected).abs() < 1e-9,
            "{k}: {} {expected}",
            gradient.values[k]
        );
        used += usize::from(expected != 0.0);
    }
    assert!(used > sizes.hidden * sizes.inputs);
}

#[test]
fn gradient_is_the_finite_difference() {
    for &kind in NetworkKind::ALL {
        check(Sizes { kind, inputs: 3, hidden: 5, outputs: 2 }, 6, 19, Loss::EveryRow);
        check(Sizes { kind, inputs: 2, hidden: 9, outputs: 3 }, 4, 16, Loss::LastRow);
        check(Sizes { kind, inputs: 7, hidden: 30, outputs: 5 }, 1, 3, Loss::EveryRow);
    }
}

#[test]
fn gradients_are_those_of_a_peer() {
    let wave = |scale: f64, angle: f64| scale * angle.sin();
    let x: Vec<f64> =
        (0..15).map(|at| wave(1.0, 1.7 * f64::from(at / 3) + 0.6 * f64::from(at % 3))).collect();
    let y: Vec<f64> = (0..10)
        .map(|at| wave(1.0, 0.9 * f64::from(at / 2) + 1.2 * f64::from(at % 2) + 0.3))
        .collect();
    let text = std::fs::read_to_string("tests/reference/networks/gradients.csv").unwrap();
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let mut compared = 0;
    for kind in [NetworkKind::Elman, NetworkKind::Gru, NetworkKind::Lstm] {
        let sizes = Sizes { kind, inputs: 3, hidden: 4, outputs: 2 };
        let (units, ports, stride) = (sizes.units(), sizes.ports(), sizes.row_len());
        let place = |weights: &str, block: usize, row: usize, column: usize| match weights {
            "inputs" => column * stride + block * units + row,
            "state" => (3 + column) * stride + block * units + row,
            "bias" => 7 * stride + block * units + row,
            "outputs" => sizes.hidden_len() + column * ports + row,
            "output_bias" => sizes.hidden_len() + 4 * ports + row,
            other => panic!("{other}"),
        };
        let own =
            |row: &&Vec<&str>| serde_json::to_string(&kind).unwrap().trim_matches('"') == row[0];
        let (loss, gradients): (Vec<_>, Vec<_>) =
            rows.iter().filter(own).partition(|row| row[1] == "loss");
        let mut weights = Weights::<f64>::zeros(sizes);
        let kinds: Vec<(usize, f64)> = gradients
            .iter()
            .map(|row| {
                let [block, r, c]: [usize; 3] =
                    std::array::from_fn(|k| row[2 + k].parse().unwrap());
                let [b, u, v] = [block, r, c].map(|number| number as f64);
                weights.values[place(row[1], block, r, c)] = match row[1] {
                    "inputs" => wave(0.5, 1.0 + b + 1.7 * u + 0.9 * v),
                    "state" => wave(0.5, 2.0 + 1.1 * b + 0.6 * u + 1.3 * v),
                    "bias" => wave(0.3, 3.0 + b + u),
                    "outputs" => wave(0.5, 4.0 + u + 0.8 * v),
                    _ => wave(0.2, 5.0 + u),
                };
                (place(row[1], block, r, c), row[5].parse().unwrap())
            })
            .collect();
        let mut gradient = Weights::zeros(sizes);
        let mut batch = SequenceBatch::new(sizes, 5, 1, Loss::EveryRow);
        batch.load(&x, &y, &[0]);
        let value = batch.loss_and_gradient(&weights, &mut gradient);
        assert!((value - loss[0][5].parse::<f64>().unwrap()).abs() < 1e-13, "{kind:?}: {value}");
        for (at, expected) in kinds {
            assert!(
                (gradient.values[at] - expected).abs() < 1e-13,
                "{kind:?}: {} {expected}",
                gradient.values[at]
            );
            compared += 1;
        }
    }
    assert_eq!(compared, rows.len() - 3);
}
