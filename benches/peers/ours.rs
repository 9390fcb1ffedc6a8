//! The rod of this project.

use nalgebra::Vector3;
use spinebench::rod::{Resolution, Rod, RodParams, SolveStatus};

use crate::clock;
use crate::drive::Case;
use crate::table::{Row, Tips};

/// A setting of the rod and its name.
pub struct Setting {
    pub name: String,
    pub resolution: Resolution,
}

/// Tips at the samples, and the mean length of the time steps, s.
pub fn tips(params: &RodParams, case: &Case) -> Result<(Vec<Vector3<f64>>, f64), String> {
    let mut rod = Rod::new(params.clone());
    let converged = |status: SolveStatus, t: f64| {
        if status == SolveStatus::Converged { Ok(()) } else { Err(format!("{status} at {t:.3} s")) }
    };
    converged(rod.settle(&case.series.drives(0.0)), 0.0)?;
    let mut tips = vec![rod.tip_m()];
    for pair in case.samples_s().windows(2) {
        let mut now = pair[0];
        // A step ends wherever the drive changes its speed.
        let inside =
            |kink: &f64| case.series.kinks && *kink > pair[0] + 1e-9 && *kink < pair[1] - 1e-9;
        let kinks: Vec<f64> = case.series.times_s.iter().copied().filter(inside).collect();
        for end in kinks.into_iter().chain([pair[1]]) {
            let start = now;
            converged(rod.advance_with(&|dt| case.series.drives(start + dt), end - start), end)?;
            now = end;
        }
        tips.push(rod.tip_m());
    }
    let mean_step_s = case.duration_s / rod.effort().steps.max(1) as f64;
    Ok((tips, mean_step_s))
}

/// The rod of `case` at a setting.
pub fn with(case: &Case, setting: &Setting) -> RodParams {
    RodParams { resolution: setting.resolution, ..case.params.clone() }
}

/// Runs and times one setting.
pub fn run(case: &Case, limit: &Tips, setting: &Setting) -> Row {
    let params = with(case, setting);
    let (result, cpu_s) = clock::best(|| tips(&params, case));
    let cells = (params.length_m() / params.resolution.cell_m).ceil().max(1.0);
    let mean_step_s = result.as_ref().map_or(params.resolution.time_step_s, |(_, step)| *step);
    let row = Row::new(case, "spinebench", &setting.name, cells, mean_step_s);
    row.ended(result.map(|(tips, _)| Tips(tips)), limit, cpu_s, case.duration_s)
}
