//! Who runs on which robot, at which settings.

use serde_json::{Value, json};
use spinebench::rod::{Resolution, Scheme};
use spinebench::rows::experiment::PeerRow;

use crate::drive::{self, Case};
use crate::environment::Facts;
use crate::ours::{self, Setting};
use crate::python::Python;
use crate::table::{self, Row, Tips};
use crate::till::{Settings, Solver, Space};
use crate::{limits, peer_till, statics};

/// Everything that a run found.
#[derive(Default)]
pub struct Results {
    pub rows: Vec<PeerRow>,
    pub facts: Facts,
}

impl Results {
    pub fn add(&mut self, row: Row) {
        table::print(&row.0);
        self.rows.push(row.0);
    }

    fn python(&mut self, script: &str, case: &Case, limit: &Tips, settings: &Value) {
        let runs = Python::find().and_then(|python| python.run(script, case, limit, settings));
        match runs {
            Ok(runs) => {
                self.facts.versions.extend(runs.versions);
                runs.rows.into_iter().for_each(|row| self.add(row));
            }
            Err(reason) => {
                println!("{script} on {}: skipped: {reason}", case.name);
                self.facts.skipped.push((format!("{script} on {}", case.name), reason));
            }
        }
    }
}

/// All of it, or one robot.
///
/// # Errors
/// What makes a comparison impossible: a missing model, a limit that was not reached.
pub fn run(only: Option<&str>) -> Result<Results, String> {
    let mut results = Results::default();
    let wanted = |name: &str| only.is_none_or(|only| only == name);
    if wanted("till") {
        till(&mut results)?;
    }
    if wanted("paper") {
        paper(&mut results)?;
    }
    if wanted("paper_tension") {
        tension(&mut results)?;
    }
    if wanted("paper_statics") {
        table::print_header("paper, one equilibrium (time per solve)");
        statics::run(&mut results)?;
    }
    Ok(results)
}

/// A grid that is as fine as it needs to be for 0.1 mm rather than a micrometre.
fn coarse(base: Resolution, cell_m: f64) -> Resolution {
    Resolution {
        cell_m,
        bending_modes: 4,
        torsion_modes: 2,
        shear_modes: 2,
        axial_modes: 3,
        ..base
    }
}

/// Our own curves: steps by their error, as shipped, and steps of one length.
fn ours(results: &mut Results, case: &Case, limit: &Tips, steps_ms: &[f64], coarse_cell_m: f64) {
    let shipped = case.params.resolution;
    let coarse = coarse(shipped, coarse_cell_m);
    for (name, base) in
        [("steps by error, shipped grid", shipped), ("steps by error, coarse grid", coarse)]
    {
        for motion_tolerance_m in [3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 1e-6, 3e-7] {
            let resolution = Resolution { time_step_s: 0.1, motion_tolerance_m, ..base };
            results.add(ours::run(case, limit, &Setting { name: name.into(), resolution }));
        }
    }
    for (name, scheme) in
        [("SDIRK2, coarse grid", Scheme::Sdirk2), ("SDIRK3, coarse grid", Scheme::Sdirk3)]
    {
        equal_steps(results, case, limit, (name, scheme, coarse), steps_ms);
    }
}

/// A curve of steps of one length.
fn equal_steps(
    results: &mut Results,
    case: &Case,
    limit: &Tips,
    (name, scheme, base): (&str, Scheme, Resolution),
    steps_ms: &[f64],
) {
    for step_ms in steps_ms {
        let time_step_s = 1e-3 * step_ms;
        let resolution =
            Resolution { time_step_s, scheme, motion_tolerance_m: f64::INFINITY, ..base };
        results.add(ours::run(case, limit, &Setting { name: name.into(), resolution }));
    }
}

fn till(results: &mut Results) -> Result<(), String> {
    table::print_header("Till, Aloi & Rucker's tendon example");
    let case = drive::till()?;
    let limit = limits::published_till()?;
    ours(results, &case, &limit, &[50.0, 25.0, 10.0, 5.0, 2.5, 1.0], 0.05);
    let published = Settings::published();
    let mut scheme = |settings: Settings| results.add(peer_till::run(&case, &limit, settings));
    scheme(published);
    for (nodes, step_ms) in [(50, 50.0), (100, 50.0), (200, 25.0), (200, 10.0), (200, 5.0)] {
        scheme(Settings { nodes, time_step_s: 1e-3 * step_ms, ..published });
    }
    let tuned =
        Settings { space: Space::Rk4, solver: Solver::Newton, extrapolate: true, ..published };
    for (nodes, step_ms) in
        [(20, 50.0), (20, 25.0), (20, 10.0), (40, 5.0), (40, 2.5), (80, 2.5), (80, 1.0)]
    {
        scheme(Settings { nodes, time_step_s: 1e-3 * step_ms, ..tuned });
    }
    // Segments, time step, tendons through sites.
    let settings = json!([
        [11, 0.01, false],
        [11, 0.005, false],
        [11, 0.002, false],
        [11, 0.001, false],
        [11, 0.001, true],
        [22, 0.002, false],
        [22, 0.001, false],
        [22, 0.0005, false],
        [22, 0.001, true],
        [44, 0.001, false],
    ]);
    results.python("chain.py", &case, &limit, &settings);
    Ok(())
}

fn paper(results: &mut Results) -> Result<(), String> {
    println!("\nlimit of the paper's robot");
    let case = drive::paper()?;
    let limit = limits::of(&case, 0.0005, &mut results.facts)?;
    limits::cross_check(&case, &limit, &mut results.facts)?;
    table::print_header("the paper's robot, lengths explored at random");
    ours(results, &case, &limit, &[50.0, 25.0, 10.0, 5.0, 2.5], 0.02);
    let published =
        Settings { rotary_inertia: false, linear_damping: true, ..Settings::published() };
    let mut scheme = |settings: Settings| results.add(peer_till::run(&case, &limit, settings));
    for (nodes, step_ms) in [(100, 50.0), (200, 50.0), (200, 10.0)] {
        scheme(Settings { nodes, time_step_s: 1e-3 * step_ms, ..published });
    }
    let tuned = Settings { space: Space::Rk4, solver: Solver::Newton, ..published };
    for (nodes, step_ms) in
        [(24, 50.0), (24, 25.0), (24, 10.0), (24, 5.0), (24, 2.5), (48, 2.5), (48, 1.25)]
    {
        scheme(Settings { nodes, time_step_s: 1e-3 * step_ms, ..tuned });
    }
    let settings = json!([
        [11, 0.025, false],
        [11, 0.01, false],
        [11, 0.005, false],
        [11, 0.002, false],
        [11, 0.001, false],
        [11, 0.002, true],
        [22, 0.005, false],
        [22, 0.002, false],
        [22, 0.001, false],
        [44, 0.002, false],
    ]);
    results.python("chain.py", &case, &limit, &settings);
    Ok(())
}

fn tension(results: &mut Results) -> Result<(), String> {
    println!("\nlimit of the paper's robot without compressible spine and damping, under tensions");
    let case = drive::tension()?;
    let limit = limits::of(&case, 0.0005, &mut results.facts)?;
    table::print_header("the same, 1 s");
    let base = case.params.resolution;
    for (name, scheme) in
        [("SDIRK2, shipped grid", Scheme::Sdirk2), ("SDIRK3, shipped grid", Scheme::Sdirk3)]
    {
        equal_steps(results, &case, &limit, (name, scheme, base), &[25.0, 10.0, 5.0, 2.5, 1.0]);
    }
    // Elements, time step, factor on the rotary inertia.
    let settings = json!([
        [11, 5e-5, 100.0],
        [11, 2e-5, 20.0],
        [22, 5e-5, 100.0],
        [22, 2e-5, 100.0],
        [44, 5e-6, 100.0]
    ]);
    results.python("elastica_rod.py", &case, &limit, &settings);
    Ok(())
}
