//! Till, Aloi & Rucker's scheme as a peer.

use nalgebra::Vector3;

use crate::clock;
use crate::drive::Case;
use crate::table::{Row, Tips};
use crate::till::{Settings, Solver, Space, Till};

/// Tips at the samples; the time step must divide the time between them.
pub fn tips(case: &Case, settings: Settings) -> Result<Vec<Vector3<f64>>, String> {
    match case.params.tendons.len() {
        1 => tips_of::<1>(case, settings),
        4 => tips_of::<4>(case, settings),
        other => Err(format!("{other} tendons")),
    }
}

fn tips_of<const T: usize>(case: &Case, settings: Settings) -> Result<Vec<Vector3<f64>>, String> {
    let mut rod = Till::<T>::new(&case.params, settings)?;
    rod.settle(&case.series.drives(0.0)).map_err(|error| format!("{error} at rest"))?;
    let mut tips = vec![rod.tip_m()];
    for pair in case.samples_s().windows(2) {
        let steps = ((pair[1] - pair[0]) / settings.time_step_s).round().max(1.0) as usize;
        for k in 1..=steps {
            let t = pair[0] + (pair[1] - pair[0]) * k as f64 / steps as f64;
            rod.step(&case.series.drives(t)).map_err(|error| format!("{error} at {t:.3} s"))?;
        }
        tips.push(rod.tip_m());
    }
    Ok(tips)
}

/// Runs and times one setting. With the authors' solver the peer is called by their article; a kept
/// derivative makes it another peer, so that the two curves stay apart.
pub fn run(case: &Case, limit: &Tips, settings: Settings) -> Row {
    let peer = match settings.solver {
        Solver::LevenbergMarquardt => "till_2019",
        Solver::Newton => "till_2019_tuned",
    };
    let (result, cpu_s) = clock::best(|| tips(case, settings));
    let row = Row::new(case, peer, &name(&settings), settings.nodes as f64, settings.time_step_s);
    row.ended(result.map(Tips), limit, cpu_s, case.duration_s)
}

fn name(settings: &Settings) -> String {
    let space = if settings.space == Space::Euler { "Euler" } else { "RK4" };
    let solver = match settings.solver {
        Solver::LevenbergMarquardt => "Levenberg-Marquardt",
        Solver::Newton => "kept Jacobian",
    };
    format!("{space}, BDF2, {solver}")
}
