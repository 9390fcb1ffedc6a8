//! Networks of ONNX files: one that PyTorch 2.15 exported, with the output that ONNX Runtime 1.32
//! computes, and damage.

use spinebench::learn::onnx::{OnnxError, OnnxNetwork};

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
    assert!(error.to_string().contains("Tanh"), "{error}");
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
    assert!(matches!(OnnxNetwork::read(b"trial,time_s\n", 10), Err(OnnxError::NotOnnx(_))));
}
