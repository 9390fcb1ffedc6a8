//! The limits that errors are measured against, and how well they are known.

use spinebench::rod::{Resolution, Scheme};

use crate::drive::{self, Case};
use crate::environment::Facts;
use crate::ours::{self, Setting};
use crate::peer_till;
use crate::table::Tips;
use crate::till::{Settings, Solver, Space};

/// Fine in space, at a given step.
fn fine(time_step_s: f64, base: Resolution) -> Setting {
    let mut resolution = base;
    resolution.cell_m = 0.005;
    resolution.bending_modes = 12;
    resolution.torsion_modes = 8;
    resolution.shear_modes = 8;
    resolution.axial_modes = 8;
    resolution.time_step_s = time_step_s;
    resolution.motion_tolerance_m = f64::INFINITY;
    resolution.scheme = Scheme::Sdirk2;
    Setting { name: "limit".into(), resolution }
}

/// The limit of a case from our own rod at tiny steps, checked against twice the steps and against
/// the other scheme.
///
/// # Errors
/// A run that did not end.
pub fn of(case: &Case, time_step_s: f64, facts: &mut Facts) -> Result<Tips, String> {
    let at = |step| {
        ours::tips(&ours::with(case, &fine(step, case.params.resolution)), case)
            .map(|(tips, _)| Tips(tips))
    };
    let limit = at(time_step_s)?;
    let (rms, most, _) = at(2.0 * time_step_s)?.errors(&limit);
    note(facts, format!("{}: ours, step doubled to {} s, rms", case.name, 2.0 * time_step_s), rms);
    note(facts, format!("{}: ours, step doubled, largest", case.name), most);
    Ok(limit)
}

/// How far the other scheme, refined in space and time, is from the limit of the paper's robot; its
/// own Richardson extrapolation in time (second order) as well.
///
/// # Errors
/// A run that did not end.
pub fn cross_check(case: &Case, limit: &Tips, facts: &mut Facts) -> Result<(), String> {
    let at = |nodes, time_step_s| {
        let settings = Settings {
            space: Space::Rk4,
            nodes,
            time_step_s,
            solver: Solver::Newton,
            tolerance: 1e-16,
            rotary_inertia: false,
            linear_damping: true,
            ..Settings::published()
        };
        peer_till::tips(case, settings).map(Tips)
    };
    let [coarse, mid, fine] =
        [(48, 0.0025), (96, 0.0025), (96, 0.00125)].map(|(nodes, step)| at(nodes, step));
    let (coarse, mid, fine) = (coarse?, mid?, fine?);
    note(
        facts,
        format!("{}: Till's scheme, 48 against 96 nodes, rms", case.name),
        coarse.errors(&mid).0,
    );
    note(
        facts,
        format!("{}: Till's scheme, 2.5 against 1.25 ms, rms", case.name),
        mid.errors(&fine).0,
    );
    let extrapolated =
        fine.0.iter().zip(&mid.0).map(|(fine, mid)| fine + (fine - mid) / 3.0).collect();
    let (rms, most, rest) = fine.errors(limit);
    note(facts, format!("{}: Till's scheme, 96 nodes, 1.25 ms, against ours, rms", case.name), rms);
    note(facts, format!("{}: the same, largest", case.name), most);
    note(facts, format!("{}: the same, at rest", case.name), rest);
    note(
        facts,
        format!("{}: extrapolated in time, against ours, rms", case.name),
        Tips(extrapolated).errors(limit).0,
    );
    Ok(())
}

/// The published series of Till's example.
///
/// # Errors
/// A file that cannot be read.
pub fn published_till() -> Result<Tips, String> {
    drive::till_limit().map(Tips)
}

fn note(facts: &mut Facts, what: String, value_m: f64) {
    println!("  {what}: {:.5} mm", 1e3 * value_m);
    facts.limits_m.push((what, value_m));
}
