//! Shared by the integration tests: reference robots and a small CSV reader.
#![allow(dead_code, unreachable_pub, missing_docs)]

pub mod oracle;
pub mod random_robot;

use nalgebra::{Matrix3, Vector3};
use spinebench::effects::{EffectSpec, Model};
use spinebench::rod::{ContactSurface, Resolution, RodParams, Span, Tendon, TipWrench};
use std::collections::HashMap;

/// Rows of a reference file by column name.
pub fn reference(name: &str) -> Vec<HashMap<String, f64>> {
    read(&format!("tests/reference/rod/{name}"))
}

/// Rows of a CSV file of numbers below the project's folder.
pub fn read(name: &str) -> Vec<HashMap<String, f64>> {
    let path = format!("{}/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    lines
        .map(|line| {
            let values = line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN));
            names.iter().map(|name| name.to_string()).zip(values).collect()
        })
        .collect()
}

/// A round rod of one material with tendons at the given offsets.
pub fn round_rod(length_m: f64, radius_m: f64, e_pa: f64, g_pa: f64, mass_kg_m: f64) -> RodParams {
    RodParams {
        spans: vec![Span::round(length_m, radius_m, e_pa, g_pa, mass_kg_m)],
        sections: vec![],
        masses: vec![],
        tendons: vec![],
        gravity_m_s2: Vector3::zeros(),
        base_m: Vector3::zeros(),
        base_rotation_rad: Vector3::zeros(),
        damping_time_s: 0.0,
        drag_n_s2_m3: 0.0,
        tip_load: TipWrench::default(),
        point_loads: vec![],
        line_loads: vec![],
        contact: ContactSurface::default(),
        moment_laws: vec![],
        rested_s: f64::INFINITY,
        resolution: Resolution::default(),
    }
}

/// Four tendons at 0, 90, 180 and 270 degrees.
pub fn four_tendons(offset_m: f64, end_m: f64, compliance_m_per_n: f64) -> Vec<Tendon> {
    [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]
        .iter()
        .map(|[x, y]| Tendon {
            compliance_m_per_n,
            ..Tendon::parallel([x * offset_m, y * offset_m], end_m)
        })
        .collect()
}

/// The rod of a shipped model file.
pub fn shipped(name: &str) -> RodParams {
    model(name).rod(&[])
}

/// A shipped model file.
pub fn model(name: &str) -> Model {
    let path = format!("{}/models/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
    spinebench::specs::read_model(std::path::Path::new(&path))
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Effects as a model file lists them; nothing for nothing.
pub fn effects(yaml: &str) -> Vec<EffectSpec> {
    let text = if yaml.is_empty() { "[]" } else { yaml };
    serde_yaml::with::singleton_map_recursive::deserialize(serde_yaml::Deserializer::from_str(text))
        .unwrap()
}

pub fn vector(row: &HashMap<String, f64>, names: [&str; 3]) -> Vector3<f64> {
    Vector3::new(row[names[0]], row[names[1]], row[names[2]])
}

pub fn rotation(row: &HashMap<String, f64>, prefix: &str) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| row[&format!("{prefix}R{}{}", i + 1, j + 1)])
}

/// Central differences of `residuals` with steps of `step` in every parameter, as [`fit`] wants
/// them.
///
/// [`fit`]: spinebench::math::optimise::least_squares::fit
pub fn differences<'a>(
    residuals: &'a dyn Fn(&[f64]) -> Option<Vec<f64>>,
    step: f64,
) -> impl Fn(&[f64]) -> Option<nalgebra::DMatrix<f64>> + 'a {
    move |at| {
        let shifted = |k: usize, sign: f64| {
            let mut moved = at.to_vec();
            moved[k] += sign * step;
            residuals(&moved)
        };
        let column = |k: usize| {
            let pair = shifted(k, 1.0)?.into_iter().zip(shifted(k, -1.0)?);
            Some(nalgebra::DVector::from_iterator(
                pair.len(),
                pair.map(|(after, before)| (after - before) / (2.0 * step)),
            ))
        };
        Some(nalgebra::DMatrix::from_columns(
            &(0..at.len()).map(column).collect::<Option<Vec<_>>>()?,
        ))
    }
}
