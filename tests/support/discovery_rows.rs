//! A made-up discovery of plausible shape, for tests of what people see of one. Its numbers mean
//! nothing.

use serde_json::json;
use spinebench::base::Seed;
use spinebench::data::findings::{
    Candidate, Disagreement, Findings, FoundEffect, Gap, MissingTest, Noise, PlaceRow, Proposal,
    ResidualRow, Verdict,
};
use spinebench::data::scene::Scene;
use spinebench::report::discovery::{DiscoveryReport, DiscoverySources, EffectText};

use rand::RngExt;

/// Everything that a page is made of.
pub(crate) struct Made {
    pub(crate) sources: DiscoverySources,
    pub(crate) findings: Findings,
    pub(crate) residuals: Vec<ResidualRow>,
    pub(crate) places: Vec<PlaceRow>,
    pub(crate) effects: Vec<EffectText>,
    pub(crate) model_before: String,
    pub(crate) model_after: String,
    pub(crate) scenes: Vec<Scene>,
}

impl Made {
    pub(crate) fn story(&self) -> DiscoveryReport<'_> {
        DiscoveryReport {
            sources: &self.sources,
            findings: &self.findings,
            residuals: &self.residuals,
            places: &self.places,
            calibrated: false,
            effects: &self.effects,
            model_before: &self.model_before,
            model_after: &self.model_after,
            scenes: &self.scenes,
        }
    }
}

const SIGMA_M: f64 = 0.0005;
const FLOOR_M: f64 = 0.00087;

/// A load was found.
pub(crate) fn named() -> Made {
    let residuals = residuals();
    Made {
        sources: DiscoverySources {
            model: "nominal.yaml".into(),
            measured: vec!["measured.csv".into()],
            baseline: Some("baseline.csv".into()),
            options: Vec::new(),
        },
        findings: findings(),
        places: places(&residuals),
        residuals,
        effects: vec![
            text(
                "tip_load",
                "a mass at the tip",
                "F = m g at s = L, and m in the inertia there",
                "paper, section V-C",
            ),
            text(
                "friction",
                "dry friction (the path depends on the direction)",
                "m = m_f sign(κ')",
                "Do et al. 2014",
            ),
        ],
        model_before: MODEL.to_owned() + "effects: []\n",
        scenes: Vec::new(),
        model_after: MODEL.to_owned() + "effects:\n- tip_load:\n    mass_kg: 0.01968\n",
    }
}

/// Nothing was found to be missing: the two models are one.
pub(crate) fn consistent() -> Made {
    let mut made = named();
    made.findings.verdict = Verdict::Consistent;
    made.findings.effects.clear();
    made.findings.disagreement.clear();
    made.findings.summary = "Model and recording agree within the noise of 0.87 mm.".to_owned();
    (made.findings.gap.before_m, made.findings.gap.after_m) = (0.00089, 0.00089);
    for row in &mut made.residuals {
        (row.before_x_m, row.before_y_m, row.before_z_m) =
            (row.after_x_m, row.after_y_m, row.after_z_m);
    }
    for row in &mut made.places {
        (row.mean_before_m, row.rms_before_m, row.p_before) =
            (row.mean_after_m, row.rms_after_m, row.p_after);
    }
    made.findings.missing_before = made.findings.missing_after.clone();
    made.model_after = made.model_before.clone();
    made
}

/// Two rivals that cannot be told apart, and what to record.
pub(crate) fn ambiguous() -> Made {
    let mut made = named();
    made.findings.verdict = Verdict::Ambiguous;
    made.findings.effects.push(FoundEffect {
        name: "distributed_mass".to_owned(),
        parameters: serde_json::from_value(json!({"scale": 1.61})).unwrap(),
        interval_95: serde_json::from_value(json!({"scale": [1.52, 1.70]})).unwrap(),
        confidence: 0.47,
        confusable_with: vec!["tip_load".to_owned()],
    });
    made.findings.effects[0].confidence = 0.53;
    made.findings.next_measurement =
        "Hang 20 g on the tip for half of the run: it separates the two by 21 standard deviations."
            .to_owned();
    made.model_after = made.model_before.clone();
    made
}

/// A gap that no effect closes.
pub(crate) fn unexplained() -> Made {
    let mut made = named();
    made.findings.verdict = Verdict::Unexplained;
    made.findings.effects.clear();
    made.findings.summary =
        "The tip is off by 12.1 mm, and no effect of the catalogue closes the gap.".to_owned();
    made.findings.pattern = "along x, history: jumps by 3 mm at 5 s and stays there".to_owned();
    made.findings.gap.after_m = made.findings.gap.before_m;
    for row in &mut made.residuals {
        (row.after_x_m, row.after_y_m, row.after_z_m) =
            (row.before_x_m, row.before_y_m, row.before_z_m);
    }
    for row in &mut made.places {
        (row.mean_after_m, row.rms_after_m, row.p_after) =
            (row.mean_before_m, row.rms_before_m, row.p_before);
    }
    made.findings.missing_after = made.findings.missing_before.clone();
    made.model_after = made.model_before.clone();
    made
}

fn text(name: &str, missing: &str, equation: &str, source: &str) -> EffectText {
    EffectText {
        name: name.to_owned(),
        missing: missing.to_owned(),
        equation: equation.to_owned(),
        source: source.to_owned(),
    }
}

const MODEL: &str = "robot:\n  backbone:\n    length_m: 0.22\n    radius_m: 0.002\n    \
                     youngs_modulus_pa: 2330000000.0\n  disks:\n    count: 12\n    mass_kg: \
                     0.004\n";

fn findings() -> Findings {
    Findings {
        verdict: Verdict::Named,
        effects: vec![FoundEffect {
            name: "tip_load".to_owned(),
            parameters: serde_json::from_value(json!({"mass_kg": 0.01968})).unwrap(),
            interval_95: serde_json::from_value(json!({"mass_kg": [0.0188, 0.0206]})).unwrap(),
            confidence: 0.994,
            confusable_with: vec!["distributed_mass".to_owned()],
        }],
        noise_floor_m: FLOOR_M,
        explained_share: Some(0.994),
        explained_share_interval_95: Some([0.99, 0.997]),
        left_m: 0.0003,
        complete: true,
        model_form_m: 0.0,
        gap: Gap {
            metric: "rms tip error on held-out trials".to_owned(),
            held_out_trials: vec![6, 7],
            before_m: 0.0121,
            after_m: 0.00094,
        },
        disagreement: vec![
            disagreement("x above 0.05 m", "x", 0.0151, 0.44, 1e-9),
            disagreement("first third", "x", 0.0098, 0.21, 2e-4),
            disagreement("tension below 3 N", "z", 0.0019, 0.03, 0.004),
        ],
        candidates: candidates(),
        next_measurement:
            "Nothing is needed; 20 g on the tip for half of the run would halve the interval."
                .to_owned(),
        summary: "A mass of 19.7 g hangs on the tip that the model does not know of.".to_owned(),
        noise: Noise {
            sigma_m: [SIGMA_M, 1.02 * SIGMA_M, 0.96 * SIGMA_M],
            correlation: 0.03,
            from: "differences between neighbouring samples".to_owned(),
        },
        missing_before: MissingTest { rms_m: 0.0117, foretold_m: 0.0112, p_value: 1e-12 },
        missing_after: MissingTest { rms_m: 0.00091, foretold_m: 0.0001, p_value: 0.41 },
        pattern: String::new(),
        excluded_rows: Vec::new(),
        clock_offset_s: None,
        clock_offset_interval_95: None,
        limitations: vec![
            "Two rows without tracking were left out.".to_owned(),
            "No base markers: a tilted base cannot be told from a turned tracking frame."
                .to_owned(),
        ],
        proposals: vec![
            proposal(
                "known_weight",
                "Hang 20 g on the tip for half of the run",
                6.0,
                21.6,
                "next_known_weight.csv",
            ),
            proposal(
                "base_remounted",
                "Mount the base turned by a quarter and repeat",
                15.0,
                10.8,
                "next_base.csv",
            ),
        ],
    }
}

fn disagreement(place: &str, axis: &str, rms_m: f64, share: f64, p_value: f64) -> Disagreement {
    Disagreement { place: place.to_owned(), axis: axis.to_owned(), rms_m, share, p_value }
}

fn proposal(name: &str, what: &str, minutes: f64, separation: f64, file: &str) -> Proposal {
    Proposal {
        name: name.to_owned(),
        what: what.to_owned(),
        minutes,
        separation,
        file: file.to_owned(),
    }
}

fn candidates() -> Vec<Candidate> {
    let list = [
        ("tip_load", 5210.4, 0.00095, ""),
        ("distributed_mass", 5102.0, 0.0013, "explains less: 2 ln lower by 108"),
        ("tip_force", 5198.8, 0.00095, "explains as much with two parameters more"),
        ("bending_stiffness", 3120.0, 0.0072, "leaves 7.2 mm"),
        ("tip_load + friction", 5204.1, 0.00096, "the second effect is not needed"),
        ("base_tilt", 2800.0, 0.0081, "leaves 8.1 mm"),
        ("precurvature", 2410.0, 0.0088, "leaves 8.8 mm"),
        ("spine_compressibility", 310.0, 0.0117, "leaves 11.7 mm"),
        ("delay", -12.0, 0.0121, "changes nothing that can be seen"),
        ("nothing missing", 0.0, 0.0121, "leaves 12.1 mm"),
    ];
    let one = |(name, score, after_m, why_not): (&str, f64, f64, &str)| Candidate {
        name: name.to_owned(),
        score,
        after_m,
        why_not: why_not.to_owned(),
        parameters: format!("{name}.size={score}"),
    };
    list.into_iter().map(one).collect()
}

/// Eight trials of fifty samples, the last two held out.
fn residuals() -> Vec<ResidualRow> {
    let mut rng = Seed(5).rng();
    let mut noise = || SIGMA_M * ((0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0);
    let mut rows = Vec::new();
    for trial in 0..8u64 {
        let (mut a, mut b) = (0.0, 0.0);
        for sample in 0..50 {
            a = 0.95 * a + 200.0 * noise();
            b = 0.95 * b + 200.0 * noise();
            let bend = f64::hypot(a, b).max(1e-9);
            let side = 0.22 * (1.0 - bend.cos()) / bend;
            let after = [noise(), noise(), noise()];
            let sag = 0.009 + 0.05 * side * a / bend;
            rows.push(ResidualRow {
                trial,
                time_s: 0.2 * f64::from(sample),
                held_out: trial >= 6,
                point: String::new(),
                tip_x_m: side * a / bend,
                tip_y_m: side * b / bend,
                tip_z_m: 0.22 * bend.sin() / bend,
                before_x_m: after[0] - sag,
                before_y_m: after[1] + 0.002 * b,
                before_z_m: after[2] + 0.2 * sag * a,
                after_x_m: after[0],
                after_y_m: after[1],
                after_z_m: after[2],
            });
        }
    }
    rows
}

/// Places as a discovery looks at them.
fn places(residuals: &[ResidualRow]) -> Vec<PlaceRow> {
    type Test = fn(&ResidualRow) -> bool;
    let list: [(&str, &str, Test); 16] = [
        ("all", "every sample", |_| true),
        ("workspace", "x above 0.02 m", |row| row.tip_x_m > 0.02),
        ("workspace", "x within ±0.02 m", |row| row.tip_x_m.abs() <= 0.02),
        ("workspace", "x below −0.02 m", |row| row.tip_x_m < -0.02),
        ("workspace", "y above 0.02 m", |row| row.tip_y_m > 0.02),
        ("workspace", "y below −0.02 m", |row| row.tip_y_m < -0.02),
        ("time in trial", "first third", |row| row.time_s < 3.3),
        ("time in trial", "second third", |row| (3.3..6.6).contains(&row.time_s)),
        ("time in trial", "last third", |row| row.time_s >= 6.6),
        ("direction of motion", "x rising", |row| row.before_y_m > 0.0),
        ("direction of motion", "x falling", |row| row.before_y_m <= 0.0),
        ("tension", "below 3 N", |row| row.tip_z_m > 0.21),
        ("tension", "3 to 6 N", |row| (0.19..0.21).contains(&row.tip_z_m)),
        ("tension", "above 6 N", |row| row.tip_z_m < 0.19),
        ("history", "new ground", |row| row.trial.is_multiple_of(2)),
        ("history", "been there before", |row| !row.trial.is_multiple_of(2)),
    ];
    let mut rows = Vec::new();
    for (by, place, test) in list {
        let here: Vec<&ResidualRow> = residuals.iter().filter(|row| test(row)).collect();
        for (index, axis) in ["x", "y", "z", "all"].into_iter().enumerate() {
            rows.push(place_row(by, place, axis, index, &here));
        }
    }
    rows
}

fn place_row(by: &str, place: &str, axis: &str, index: usize, here: &[&ResidualRow]) -> PlaceRow {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let sizes = |parts: fn(&ResidualRow) -> [f64; 3]| -> Vec<f64> {
        let one = |row: &&ResidualRow| match parts(row) {
            parts if index < 3 => parts[index],
            parts => parts.iter().map(|part| part * part).sum::<f64>().sqrt(),
        };
        here.iter().map(one).collect()
    };
    let rms =
        |values: &[f64]| mean(&values.iter().map(|value| value * value).collect::<Vec<_>>()).sqrt();
    let before = sizes(|row| [row.before_x_m, row.before_y_m, row.before_z_m]);
    let after = sizes(|row| [row.after_x_m, row.after_y_m, row.after_z_m]);
    let floor_m = if index < 3 { SIGMA_M } else { FLOOR_M };
    let p = |rms_m: f64| if rms_m > 1.3 * floor_m { 1e-6 } else { 0.6 };
    PlaceRow {
        by: by.to_owned(),
        place: place.to_owned(),
        axis: axis.to_owned(),
        samples: here.len() as u64,
        mean_before_m: if index < 3 { mean(&before) } else { f64::NAN },
        rms_before_m: rms(&before),
        p_before: p(rms(&before)),
        mean_after_m: if index < 3 { mean(&after) } else { f64::NAN },
        rms_after_m: rms(&after),
        p_after: p(rms(&after)),
        floor_m,
    }
}
