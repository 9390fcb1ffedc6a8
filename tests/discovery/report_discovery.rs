//! What people see of a discovery: the page, its figures and its tables.

use std::path::Path;

use crate::support::discovery_rows::{Made, ambiguous, consistent, named, unexplained};
use crate::support::text_overlap as overlap;
use serde_json::{Value, json};
use spinebench::data::findings::{Candidate, FoundEffect, Verdict};
use spinebench::data::scene::{Scene, SceneFrame};
use spinebench::report::discovery::{DiscoveryReport, EffectText, artifacts};
use spinebench::report::{Artifact, write};

fn files(made: &Made) -> Vec<Artifact> {
    artifacts(&made.story()).unwrap()
}

fn file(made: &Made, name: &str) -> Vec<u8> {
    files(made).into_iter().find(|file| file.name == name).unwrap().bytes
}

fn page(made: &Made) -> String {
    String::from_utf8(file(made, "report.html")).unwrap()
}

/// Every tag is closed in the order in which it was opened.
fn assert_well_formed(page: &str) {
    let mut open: Vec<&str> = Vec::new();
    let body = page.split_once("<!DOCTYPE html>").unwrap().1;
    for piece in body.split('<').skip(1) {
        let (tag, _) = piece
            .split_once('>')
            .unwrap_or_else(|| panic!("`<` in text: {}", &piece[..piece.len().min(60)]));
        let name = tag.split([' ', '\n', '/']).next().unwrap();
        if let Some(end) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(end), "</{end}>");
        } else if !(tag.ends_with('/') || name == "meta") {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn the_same_findings_give_the_same_bytes() {
    let all = [
        ("named", named()),
        ("consistent", consistent()),
        ("ambiguous", ambiguous()),
        ("unexplained", unexplained()),
    ];
    for (name, made) in all {
        let first = files(&made);
        assert!(first == files(&made), "{name}");
        // Left there to be looked at.
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("discovery").join(name);
        write(&first, &folder, &folder).unwrap();
    }
}

#[test]
fn the_page_says_what_was_found_and_stands_alone() {
    let page = page(&named());
    assert_well_formed(&page);
    for words in [
        "<h1>The model lacks: a mass at the tip</h1>",
        "A mass of 19.7 g hangs on the tip",
        "<strong>19.7 g</strong>",
        "18.8 to 20.6 g",
        "<code>distributed_mass</code>",
        "F = m g at s = L",
        "12.1\u{a0}mm",
        "0.940\u{a0}mm",
        "0.870\u{a0}mm",
        "Measured on trials 6 and 7, held out",
        "x above 0.05 m",
        "explains less: 2 ln lower by 108",
        "Two rows without tracking were left out.",
        "next_known_weight.csv",
        "<ins>+ - tip_load:</ins>\n<ins>+     mass_kg: 0.01968</ins>",
        "<del>- effects: []</del>",
        "<strong>no evidence</strong>",
    ] {
        assert!(page.contains(words), "{words}");
    }
    for foreign in ["<script", "http-equiv", "href=", "src=", "url(", "@import", "<link", "<iframe"]
    {
        assert!(!page.contains(foreign), "{foreign}");
    }
    // What looks like an address is the name of SVG's language alone.
    assert_eq!(
        page.matches("http").count(),
        page.matches("xmlns=\"http://www.w3.org/2000/svg\"").count()
    );
}

#[test]
fn the_page_shows_the_robot_and_fetches_nothing() {
    let mut made = named();
    let frame = SceneFrame { tip_m: Some([0.0, 0.0, 0.2]), ..SceneFrame::default() };
    let names = ["Trial 6: model as given", "Trial 6: with tip_load"];
    let scene = |name: &str| Scene {
        name: name.to_owned(),
        frames: vec![frame.clone()],
        ..Scene::default()
    };
    made.scenes = names.map(scene).to_vec();
    let page = page(&made);
    for name in names {
        assert!(page.contains(&format!("<h4>{name}</h4>")), "{name}");
    }
    assert_eq!(page.matches("<canvas").count(), 2);
    // A still for readers without scripts.
    assert_eq!(page.matches("aria-label=\"last frame\"").count(), 2);
    assert_eq!(page.matches("<script").count(), 2);
    for foreign in ["http-equiv", "href=", "src=", "url(", "@import", "<link", "<iframe", "fetch("]
    {
        assert!(!page.contains(foreign), "{foreign}");
    }
    let without = page.len();
    made.scenes.clear();
    assert!(without - self::page(&made).len() < 60_000, "a player is small");
}

#[test]
fn each_verdict_has_its_words() {
    for (made, title) in [
        (consistent(), "<h1>These data show no missing effect</h1>"),
        (
            ambiguous(),
            "<h1>An effect is missing; these data do not determine which of several</h1>",
        ),
        (unexplained(), "<h1>The model has an error that no effect of the catalogue explains</h1>"),
    ] {
        let page = page(&made);
        assert_well_formed(&page);
        assert!(page.contains(title), "{title}");
        assert!(page.contains("The model was not changed: "), "{title}");
    }
    let same = page(&consistent());
    assert!(
        !same.contains("Error with the effects") && !same.contains(">after<"),
        "no second model, no second number"
    );
    assert!(page(&unexplained()).contains("jumps by 3 mm at 5 s"));
}

#[test]
fn with_a_baseline_it_is_the_calibrated_model_that_errs() {
    let made = named();
    let files = artifacts(&DiscoveryReport { calibrated: true, ..made.story() }).unwrap();
    for (name, words) in [
        ("report.html", "Error of the calibrated model"),
        ("gap.svg", "calibrated model"),
        ("map.svg", "calibrated model"),
    ] {
        let file = files.iter().find(|file| file.name == name).unwrap();
        let text = String::from_utf8(file.bytes.clone()).unwrap();
        assert!(text.contains(words) && !text.contains("model as given"), "{name}");
    }
}

#[test]
fn whatever_the_words_are_they_stay_words() {
    let nasty = "<b onload=\"x('1')\">&amp;\u{0}\u{7}</b>".to_owned() + &"long ".repeat(300);
    let mut made = named();
    let findings = &mut made.findings;
    let texts = [
        &mut findings.summary,
        &mut findings.next_measurement,
        &mut findings.pattern,
        &mut findings.noise.from,
    ];
    for words in
        texts.into_iter().chain(&mut findings.limitations).chain([&mut findings.gap.metric])
    {
        words.clone_from(&nasty);
    }
    let effect = &mut findings.effects[0];
    effect.name.clone_from(&nasty);
    effect.confusable_with.push(nasty.clone());
    effect.parameters.insert(nasty.clone(), Value::String(nasty.clone()));
    for one in &mut findings.candidates {
        (one.name, one.why_not) = (nasty.clone(), nasty.clone());
    }
    for one in &mut findings.disagreement {
        (one.place, one.axis) = (nasty.clone(), nasty.clone());
    }
    for one in &mut findings.proposals {
        (one.name, one.what, one.file) = (nasty.clone(), nasty.clone(), nasty.clone());
    }
    for row in &mut made.places {
        row.place.insert_str(0, &nasty);
        row.by.insert_str(0, &nasty);
    }
    let text = || nasty.clone();
    made.effects.push(EffectText {
        name: text(),
        missing: text(),
        equation: text(),
        source: text(),
    });
    made.model_after.push_str(&nasty);
    let page = page(&made);
    assert_well_formed(&page);
    assert!(
        !page.contains("<b") || page.matches("<b").count() == page.matches("<body").count(),
        "no tag of ours"
    );
    assert!(!page.contains('\u{0}') && !page.contains('\u{7}'));
    for name in ["map.svg", "gap.svg", "residuals.svg"] {
        overlap::assert_apart(name, &file(&made, name));
    }
}

#[test]
fn texts_of_the_figures_stay_apart() {
    for made in [named(), consistent(), ambiguous(), unexplained()] {
        for name in ["map.svg", "gap.svg", "residuals.svg"] {
            overlap::assert_apart(name, &file(&made, name));
        }
        // The same figures at a telephone's width, as the page holds them.
        for (index, svg) in page(&made).split("<svg ").skip(1).enumerate() {
            let svg = format!("<svg {}", svg.split("</svg>").next().unwrap());
            overlap::assert_apart(&format!("figure {index} of the page"), svg.as_bytes());
        }
    }
}

#[test]
fn pictures_are_not_blank() {
    for name in ["map.png", "gap.png", "residuals.png"] {
        let bytes = file(&named(), name);
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size()];
        let size = reader.next_frame(&mut pixels).unwrap();
        assert_eq!(size.width, 1440, "{name}");
        let inked = pixels[..size.buffer_size()]
            .chunks(3)
            .filter(|pixel| **pixel != [255, 255, 255])
            .count();
        let share = inked as f64 / f64::from(size.width * size.height);
        assert!((0.02..0.7).contains(&share), "{name}: {share}");
    }
}

#[test]
fn empty_lists_leave_their_parts_out() {
    let mut made = named();
    made.residuals.clear();
    made.places.clear();
    made.effects.clear();
    let findings = &mut made.findings;
    findings.disagreement.clear();
    findings.candidates.clear();
    findings.limitations.clear();
    findings.proposals.clear();
    findings.next_measurement.clear();
    findings.gap.held_out_trials.clear();
    findings.summary.clear();
    let names: Vec<String> = files(&made).into_iter().map(|file| file.name).collect();
    assert_eq!(names, ["report.html", "gap.png", "gap.svg"]);
    let left = page(&made);
    assert_well_formed(&left);
    assert!(
        left.contains("<h1>The model lacks: tip load</h1>"),
        "the name, where the catalogue says nothing"
    );
    assert!(left.contains("No trial was held out"));
    for part in
        ["Other candidates", "What to record next", "Limitations", "<figcaption>Each number"]
    {
        assert!(!left.contains(part), "{part}");
    }
    made.findings.effects.clear();
    for verdict in [Verdict::Named, Verdict::Consistent, Verdict::Ambiguous, Verdict::Unexplained] {
        made.findings.verdict = verdict;
        assert_well_formed(&page(&made));
    }
}

#[test]
fn numbers_that_are_not_there_are_dashes() {
    let mut made = named();
    let nan = f64::NAN;
    let findings = &mut made.findings;
    (findings.noise_floor_m, findings.noise.correlation) = (nan, nan);
    (findings.gap.before_m, findings.gap.after_m) = (nan, f64::INFINITY);
    (findings.missing_before.p_value, findings.missing_after.rms_m) = (nan, nan);
    findings.effects[0].confidence = nan;
    findings.effects[0].parameters.insert("mass_kg".to_owned(), Value::Null);
    for one in &mut findings.candidates {
        (one.after_m, one.score) = (nan, nan);
    }
    for one in &mut findings.disagreement {
        (one.rms_m, one.p_value) = (nan, nan);
    }
    for row in &mut made.residuals {
        (row.before_x_m, row.after_y_m) = (nan, f64::NEG_INFINITY);
    }
    for row in &mut made.places {
        (row.rms_before_m, row.floor_m, row.p_after) = (nan, 0.0, nan);
    }
    let page = page(&made);
    assert_well_formed(&page);
    for word in ["NaN", "inf", "null"] {
        let found = page.split(|letter: char| !letter.is_alphanumeric()).any(|other| other == word);
        assert!(!found, "{word}");
    }
    // Half a trial without tracking, and one sample alone, are drawn as they are.
    let mut made = named();
    made.residuals.iter_mut().skip(310).step_by(2).for_each(|row| row.before_x_m = nan);
    files(&made);
    made.residuals = made.residuals.split_off(399);
    files(&made);
}

#[test]
fn twenty_one_effects_find_their_room() {
    let mut made = named();
    let effect = made.findings.effects[0].clone();
    let many = |index: usize| FoundEffect {
        name: format!("effect_number_{index}"),
        parameters: serde_json::from_value(
            json!({"force_n": [0.1, -0.2, index], "tendon": 2, "scale": 1.2}),
        )
        .unwrap(),
        interval_95: serde_json::from_value(
            json!({"force_n": [[0.0, 0.2], [-0.3, -0.1], [0, 30]]}),
        )
        .unwrap(),
        ..effect.clone()
    };
    made.findings.effects = (0..21).map(many).collect();
    let one = made.findings.candidates[1].clone();
    made.findings.candidates = (0..300)
        .map(|index| Candidate { name: format!("candidate {index}"), ..one.clone() })
        .collect();
    let left = page(&made);
    assert_well_formed(&left);
    assert_eq!(left.matches("<article>").count(), 21);
    assert!(left.contains("force_n[2]") && left.contains("candidates.csv has all 300"));
    overlap::assert_apart("gap.svg", &file(&made, "gap.svg"));
}

#[test]
fn the_map_marks_places_at_the_level_of_the_tests() {
    let tests = spinebench::discovery::Options::default().false_alarm;
    assert_eq!(spinebench::report::discovery::SIGNIFICANCE_LEVEL, tests);
}
