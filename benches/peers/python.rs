//! The peers that are Python packages: a script each, which reads a case and writes its runs, both
//! JSON.

use std::path::{Path, PathBuf};
use std::process::Command;

use nalgebra::Vector3;
use serde_json::{Value, json};

use crate::drive::{self, Case, SAMPLE_S};
use crate::table::{Row, Tips};

/// Where a script runs.
pub struct Python {
    program: PathBuf,
    scratch: PathBuf,
}

/// What a script gave.
pub struct Runs {
    pub rows: Vec<Row>,
    /// Package and version.
    pub versions: Vec<(String, String)>,
}

impl Python {
    /// The interpreter of the virtual environment that `make peers` fills, named by `PEERS_PYTHON`.
    ///
    /// # Errors
    /// Why there is none.
    pub fn find() -> Result<Python, String> {
        let program = std::env::var_os("PEERS_PYTHON").filter(|name| !name.is_empty());
        let program =
            PathBuf::from(program.ok_or("no Python environment (PEERS_PYTHON is not set)")?);
        let scratch = Path::new(env!("CARGO_TARGET_TMPDIR")).join("peers");
        std::fs::create_dir_all(&scratch)
            .map_err(|error| format!("{}: {error}", scratch.display()))?;
        Ok(Python { program, scratch })
    }

    /// Runs `script` on a case at settings that the script understands.
    ///
    /// # Errors
    /// What the script or the system said.
    pub fn run(
        &self,
        script: &str,
        case: &Case,
        limit: &Tips,
        settings: &Value,
    ) -> Result<Runs, String> {
        let stem = script.trim_end_matches(".py");
        let file = |kind: &str| self.scratch.join(format!("{stem}_{}_{kind}.json", case.name));
        let (input, output) = (file("case"), file("runs"));
        let failed = |error: std::io::Error| error.to_string();
        std::fs::write(&input, describe(case, settings).to_string()).map_err(failed)?;
        let _ = std::fs::remove_file(&output); // of an earlier run
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers").join(script);
        let ended = Command::new(&self.program)
            .arg(path)
            .args([&input, &output])
            // One thread each: nothing else may help.
            .envs([
                ("OMP_NUM_THREADS", "1"),
                ("OPENBLAS_NUM_THREADS", "1"),
                ("NUMBA_NUM_THREADS", "1"),
            ])
            .envs([("NUMBA_CACHE_DIR", &self.scratch), ("PYTHONPYCACHEPREFIX", &self.scratch)])
            .current_dir(&self.scratch)
            .output()
            .map_err(|error| format!("{}: {error}", self.program.display()))?;
        if !ended.status.success() {
            let said = String::from_utf8_lossy(&ended.stderr);
            return Err(said.lines().last().unwrap_or("no word").to_owned());
        }
        let text = std::fs::read_to_string(&output).map_err(failed)?;
        let value: Value = serde_json::from_str(&text).map_err(|error| error.to_string())?;
        Ok(read(&value, case, limit))
    }
}

/// Writes the robots that scripts of environments drive.
///
/// # Errors
/// A missing model, or a file that cannot be written.
pub fn write_cases(folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for case in [drive::paper()?, drive::tension()?] {
        let file = folder.join(format!("{}.json", case.name));
        let text = describe(&case, &Value::Null).to_string();
        std::fs::write(&file, text).map_err(|error| format!("{}: {error}", file.display()))?;
    }
    Ok(())
}

/// The case as a script sees it.
fn describe(case: &Case, settings: &Value) -> Value {
    let params = &case.params;
    let mut start_m = 0.0;
    let spans: Vec<Value> = params
        .spans
        .iter()
        .map(|span| {
            let from = std::mem::replace(&mut start_m, span.end_m);
            json!({
                "start_m": from, "end_m": span.end_m, "bending_n_m2": span.bending_n_m2[0],
                "torsion_n_m2": span.torsion_n_m2, "shear_n": span.shear_n, "axial_n": span.axial_n,
                "mass_kg_m": span.mass_kg_m + span.spread_mass_kg_m,
            })
        })
        .collect();
    let sections: Vec<Value> = params
        .sections
        .iter()
        .map(|section| {
            json!({
                "start_m": section.start_m, "end_m": section.start_m + section.length_m,
                "compliance_per_n": section.compliance_m_per_n / section.length_m, "saturation_n": section.saturation_n,
            })
        })
        .collect();
    let mut cuts_m: Vec<f64> = params.spans.iter().map(|span| span.end_m).collect();
    cuts_m.extend(params.sections.iter().flat_map(|s| [s.start_m, s.start_m + s.length_m]));
    // EI / EA = r² / 4 for a round backbone.
    let first = &params.spans[0];
    let radius_m = 2.0 * (first.bending_n_m2[0] / first.axial_n).sqrt();
    json!({
        "name": case.name, "length_m": params.length_m(), "radius_m": radius_m, "spans": spans, "sections": sections,
        "cuts_m": cuts_m, "damping_time_s": params.damping_time_s, "drag_n_s2_m3": params.drag_n_s2_m3,
        "gravity_m_s2": params.gravity_m_s2.as_slice(),
        "offsets_m": params.tendons.iter().map(|t| t.path.at(0.0).0).collect::<Vec<_>>(),
        "compliance_m_per_n": params.tendons[0].compliance_m_per_n, "pretension_m": params.tendons[0].pretension_m,
        "times_s": case.series.times_s, "values": case.series.values, "tensions": case.series.tensions,
        "sample_s": SAMPLE_S, "samples": case.samples_s().len(), "settings": settings,
    })
}

fn read(value: &Value, case: &Case, limit: &Tips) -> Runs {
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let words = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let row = |run: &Value| {
        let point = |tip: &Value| Vector3::new(number(&tip[0]), number(&tip[1]), number(&tip[2]));
        let tips = Tips(run["tips_m"].as_array().into_iter().flatten().map(point).collect());
        let status = words(&run["status"]);
        let result = if status == "ok" { Ok(tips) } else { Err(status) };
        Row::new(
            case,
            &words(&run["peer"]),
            &words(&run["setting"]),
            number(&run["segments"]),
            number(&run["dt_s"]),
        )
        .ended(result, limit, number(&run["cpu_s"]), number(&run["simulated_s"]))
    };
    let versions = value["versions"].as_object().into_iter().flatten();
    Runs {
        rows: value["runs"].as_array().into_iter().flatten().map(row).collect(),
        versions: versions.map(|(name, version)| (name.clone(), words(version))).collect(),
    }
}
