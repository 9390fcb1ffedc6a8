//! Networks of ONNX files: one that PyTorch 2.15 exported, with the output that ONNX Runtime 1.32
//! computes, and damage.

use spinebench::learn::onnx::{OnnxError, OnnxMemory, OnnxNetwork};

const TORCH: &[u8] = include_bytes!("../data/onnx/torch_policy.onnx");

/// The input at which the network was asked elsewhere.
fn input() -> Vec<f64> {
    (0..10).map(|index| -0.3 + 0.6 * f64::from(index) / 9.0).collect()
}

#[test]
fn a_network_of_pytorch_computes_what_onnx_runtime_computes() {
    let network = OnnxNetwork::read(TORCH, 0).unwrap();
    assert_eq!((network.inputs(), network.outputs()), (10, 4));
    let found = network.evaluate(&input()).unwrap();
    let expected = [0.344_365_48, -0.053_408_235, -0.122_799_546, 0.147_298_81];
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-6, "{found} against {expected}");
    }
    // The last operator cuts at a half.
    let far = network.evaluate(&[1e3; 10]).unwrap();
    assert!(far.iter().all(|value| value.abs() <= 0.5), "{far:?}");
    assert!(matches!(network.evaluate(&[0.0; 9]), Err(OnnxError::Shape { .. })));
}

/// What PyTorch 2.15 computes after five rows, and for the last two files ONNX Runtime 1.32, of
/// networks that begin with a recurrent layer of six units: RNN, GRU and LSTM that keep their state
/// within, an LSTM that is given its state back, and a GRU that sees the five rows at once.
const RECURRENT: [(&[u8], [f64; 4]); 5] = [
    (
        include_bytes!("../data/onnx/torch_rnn.onnx"),
        [0.141_876_24, -0.197_341_83, -0.295_166_08, -0.023_076_46],
    ),
    (
        include_bytes!("../data/onnx/torch_gru.onnx"),
        [0.411_566_26, 0.260_422_65, -0.516_127_23, 0.449_918_33],
    ),
    (
        include_bytes!("../data/onnx/torch_lstm.onnx"),
        [0.115_471_73, 0.086_543_67, 0.465_083_99, 0.093_297_29],
    ),
    (
        include_bytes!("../data/onnx/torch_lstm_states.onnx"),
        [0.339_925_56, 0.208_538, 0.313_274_65, -0.469_036_52],
    ),
    (
        include_bytes!("../data/onnx/torch_gru_window.onnx"),
        [0.226_709_38, 0.122_148_52, 0.343_519_42, -0.392_006_49],
    ),
];

/// The rows that those networks saw.
fn rows() -> Vec<Vec<f64>> {
    let number = |tick: usize, k: usize| -0.3 + 0.6 * ((7 * k + 3 * tick) % 10) as f64 / 9.0;
    (0..5).map(|tick| (0..10).map(|k| number(tick, k)).collect()).collect()
}

#[test]
fn recurrent_networks_remember_the_rows_before() {
    for (number, (bytes, expected)) in RECURRENT.into_iter().enumerate() {
        let is_window = number == 4;
        let network = OnnxNetwork::read(bytes, 0).unwrap();
        assert_eq!(network.outputs(), 4);
        let mut memory = OnnxMemory::default();
        let mut last = Vec::new();
        let inputs = if is_window { vec![rows().concat()] } else { rows() };
        assert_eq!(network.inputs(), inputs[0].len());
        for row in &inputs {
            last = network.evaluate_next(row, &mut memory).unwrap();
        }
        for (found, expected) in last.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{number}: {last:?}");
        }
        // A fresh memory begins anew, and the memory is what makes the difference.
        let again = network.evaluate(&inputs[0]).unwrap();
        assert_eq!(again, network.evaluate_next(&inputs[0], &mut OnnxMemory::default()).unwrap());
        assert!(network.has_memory());
        if !is_window {
            assert_ne!(network.evaluate(inputs.last().unwrap()).unwrap(), last);
        }
    }
    assert!(!OnnxNetwork::read(TORCH, 0).unwrap().has_memory());
}

#[test]
fn an_unknown_operator_is_named() {
    let mut bytes = TORCH.to_vec();
    let places: Vec<usize> =
        (0..bytes.len() - 4).filter(|&place| &bytes[place..place + 4] == b"Tanh").collect();
    for place in places {
        bytes[place..place + 4].copy_from_slice(b"Tahn");
    }
    let error = OnnxNetwork::read(&bytes, 0).unwrap_err();
    assert_eq!(error, OnnxError::Operator("Tahn".into()));
    let words = error.to_string();
    assert!(words.contains("Tanh") && words.contains("run it from a Python class"), "{words}");
}

#[test]
fn damage_is_an_error_and_never_a_panic() {
    // The graph ends a little before the file.
    for end in 0..TORCH.len() - 200 {
        assert!(OnnxNetwork::read(&TORCH[..end], 10).is_err(), "cut at {end}");
    }
    for place in 0..TORCH.len() {
        let mut bytes = TORCH.to_vec();
        bytes[place] ^= 0x55;
        if let Ok(network) = OnnxNetwork::read(&bytes, 10)
            && network.inputs() == 10
        {
            let _ = network.evaluate(&input());
        }
    }
    for (bytes, _) in RECURRENT {
        for place in 0..bytes.len() {
            let mut bytes = bytes.to_vec();
            bytes[place] ^= 0x55;
            let _ = OnnxNetwork::read(&bytes, 10);
        }
    }
    assert!(matches!(OnnxNetwork::read(b"trial,time_s\n", 10), Err(OnnxError::NotOnnx(_))));
}
