//! The rows of the comparison.

use nalgebra::Vector3;
use spinebench::rows::experiment::PeerRow;

use crate::drive::Case;

/// Tips at the samples of a case, metres.
#[derive(Clone, Debug)]
pub struct Tips(pub Vec<Vector3<f64>>);

impl Tips {
    /// Root mean square and largest distance from `limit` over the samples that both have, and the
    /// first distance: that at rest before anything moves.
    pub fn errors(&self, limit: &Tips) -> (f64, f64, f64) {
        let distances: Vec<f64> =
            self.0.iter().zip(&limit.0).map(|(one, other)| (one - other).norm()).collect();
        let square: f64 = distances.iter().map(|d| d * d).sum();
        let most = distances.iter().copied().fold(0.0, f64::max);
        (
            (square / distances.len() as f64).sqrt(),
            most,
            distances.first().copied().unwrap_or(f64::NAN),
        )
    }
}

/// A row in the making.
pub struct Row(pub PeerRow);

impl Row {
    pub fn new(case: &Case, peer: &str, setting: &str, segments_or_nodes: f64, dt_s: f64) -> Row {
        Row(PeerRow {
            robot: case.name.to_owned(),
            peer: peer.to_owned(),
            setting: setting.to_owned(),
            segments_or_nodes,
            dt_s,
            cpu_s_per_s: f64::NAN,
            real_time_factor: f64::NAN,
            rms_error_m: f64::NAN,
            max_error_m: f64::NAN,
            static_error_m: f64::NAN,
            status: "ok".to_owned(),
        })
    }

    /// Fills in what a run of `simulated_s` seconds gave.
    pub fn ended(
        mut self,
        result: Result<Tips, String>,
        limit: &Tips,
        cpu_s: f64,
        simulated_s: f64,
    ) -> Row {
        let row = &mut self.0;
        match result {
            Ok(tips) if tips.0.iter().all(|tip| tip.iter().all(|x| x.is_finite())) => {
                (row.rms_error_m, row.max_error_m, row.static_error_m) = tips.errors(limit);
                row.cpu_s_per_s = cpu_s / simulated_s;
                row.real_time_factor = simulated_s / cpu_s;
            }
            Ok(_) => row.status = "not finite".to_owned(),
            Err(reason) => row.status = reason,
        }
        self
    }
}

/// Prints a heading and the names of the columns.
pub fn print_header(heading: &str) {
    println!("\n{heading}");
    println!(
        "{:15} {:36} {:>5} {:>8} {:>10} {:>8} {:>9} {:>9} {:>9}  status",
        "peer", "setting", "nodes", "dt ms", "cpu ms/s", "x real", "rms mm", "max mm", "rest mm"
    );
}

/// Prints a row, as soon as it is known.
pub fn print(row: &PeerRow) {
    println!(
        "{:15} {:36} {:5.0} {:8.3} {:10.4} {:8.1} {:9.4} {:9.4} {:9.4}  {}",
        row.peer,
        row.setting,
        row.segments_or_nodes,
        1e3 * row.dt_s,
        1e3 * row.cpu_s_per_s,
        row.real_time_factor,
        1e3 * row.rms_error_m,
        1e3 * row.max_error_m,
        1e3 * row.static_error_m,
        row.status
    );
}
