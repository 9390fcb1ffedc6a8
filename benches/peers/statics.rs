//! One equilibrium under given tendon lengths: time per solve, cold from straight and warm from a
//! millimetre away.

use nalgebra::Vector3;
use spinebench::rod::{Drive, Rod, RodParams, SolveStatus};

use crate::clock;
use crate::drive::{self, Case};
use crate::suite::Results;
use crate::table::Row;
use crate::till::{Settings, Solver, Space, Till};

/// Solves that are timed together.
const BATCH: usize = 10;
const PULLS_M: [f64; 2] = [0.015, 0.010];
const FURTHER_M: f64 = 0.001;

fn drives(further: bool) -> Vec<Drive> {
    let [x, y] = [PULLS_M[0] + if further { FURTHER_M } else { 0.0 }, PULLS_M[1]];
    [x, y, -x, -y].map(Drive::Pull).to_vec()
}

/// Something that finds equilibria.
trait Statics {
    fn cold(&mut self) -> Result<Vector3<f64>, String>;
    fn warm(&mut self, further: bool) -> Result<Vector3<f64>, String>;
}

impl Statics for Rod {
    fn cold(&mut self) -> Result<Vector3<f64>, String> {
        self.restart();
        self.warm(false)
    }

    fn warm(&mut self, further: bool) -> Result<Vector3<f64>, String> {
        match self.settle(&drives(further)) {
            SolveStatus::Converged => Ok(self.tip_m()),
            failure => Err(failure.to_string()),
        }
    }
}

impl Statics for Till<4> {
    fn cold(&mut self) -> Result<Vector3<f64>, String> {
        self.forget();
        self.warm(false)
    }

    fn warm(&mut self, further: bool) -> Result<Vector3<f64>, String> {
        self.settle(&drives(further)).map(|()| self.tip_m())
    }
}

/// Times ours and shooting.
///
/// # Errors
/// A missing model, or ours without a solution.
pub fn run(results: &mut Results) -> Result<(), String> {
    let case = Case { name: "paper_statics", ..drive::paper()? };
    let limit = Rod::new(fine(&case.params)).cold()?;
    let mut ours = Rod::new(case.params.clone());
    let nodes = (case.params.length_m() / case.params.resolution.cell_m).ceil();
    time(results, &case, "spinebench", "", nodes, &mut ours, limit);
    let published =
        Settings { rotary_inertia: false, linear_damping: true, ..Settings::published() };
    let tuned = Settings { space: Space::Rk4, solver: Solver::Newton, ..published };
    for (peer, settings) in [
        ("till_2019", published),
        ("till_2019", Settings { space: Space::Rk4, nodes: 48, ..published }),
        ("till_2019_tuned", Settings { nodes: 24, ..tuned }),
    ] {
        let mut shooting = Till::<4>::new(&case.params, settings)?;
        let space = if settings.space == Space::Euler { "Euler, " } else { "RK4, " };
        time(results, &case, peer, space, settings.nodes as f64, &mut shooting, limit);
    }
    Ok(())
}

fn fine(params: &RodParams) -> RodParams {
    let mut params = params.clone();
    params.resolution.cell_m = 0.002;
    params.resolution.bending_modes = 16;
    params.resolution.torsion_modes = 12;
    params.resolution.shear_modes = 12;
    params.resolution.axial_modes = 12;
    params
}

fn time(
    results: &mut Results,
    case: &Case,
    peer: &str,
    prefix: &str,
    nodes: f64,
    solver: &mut dyn Statics,
    limit: Vector3<f64>,
) {
    let (tip, cold_s) = clock::best(|| {
        (0..BATCH).map(|_| solver.cold()).last().unwrap_or_else(|| Err(String::new()))
    });
    report(results, case, (peer, &format!("{prefix}cold")), nodes, tip, cold_s, limit);
    let warm = |solver: &mut dyn Statics| {
        // An even number: it ends where the cold solve ends.
        (0..BATCH).map(|k| solver.warm(k % 2 == 0)).last().unwrap_or_else(|| Err(String::new()))
    };
    let (tip, warm_s) = clock::best(|| warm(solver));
    report(results, case, (peer, &format!("{prefix}1 mm further")), nodes, tip, warm_s, limit);
}

fn report(
    results: &mut Results,
    case: &Case,
    (peer, setting): (&str, &str),
    nodes: f64,
    tip: Result<Vector3<f64>, String>,
    batch_s: f64,
    limit: Vector3<f64>,
) {
    let mut row = Row::new(case, peer, setting, nodes, f64::NAN);
    match tip {
        Ok(tip) => {
            row.0.static_error_m = (tip - limit).norm();
            row.0.cpu_s_per_s = batch_s / BATCH as f64;
        }
        Err(reason) => row.0.status = reason,
    }
    results.add(row);
}
