//! The gap: tip error of the model as given, of the answer and of the leading candidates, beside
//! the noise floor.

use super::super::style::{BLUE, Colour, DASHED, INK, SMALL, VERMILION, WHITE};
use super::DiscoveryReport;
use super::format::{fitted, millimetres, times};
use crate::data::findings::Candidate;
use crate::report::drawing::{Axis, Canvas, Panel, Text, TextAlign, text_width};

const BAR_HEIGHT: f64 = 13.0;
const ROW_HEIGHT: f64 = 19.0;
/// Candidates drawn.
const MAX_CANDIDATES: usize = 8;
/// Of them, those at most that do without the answer.
const MAX_RIVALS: usize = 5;
/// Grey of a bar that is not the answer, dark enough on white.
const OTHER: Colour = [170, 170, 170];

/// A bar: name, size in metres, colour.
struct Bar {
    name: String,
    size_m: f64,
    colour: Colour,
}

/// The picture at a width in hundredths of an inch; none where no gap was measured.
pub(super) fn draw(report: &DiscoveryReport, width: f64) -> Option<Canvas> {
    let floor_m = report.findings.noise_floor_m;
    let proof = proof(report);
    let others = others(report);
    let sizes =
        || proof.iter().chain(&others).map(|bar| bar.size_m).filter(|size| size.is_finite());
    sizes().next()?;
    let label = if width > 500.0 { 210.0 } else { 118.0 };
    let value = 112.0;
    let mut canvas = Canvas::new(width, 1e5);
    let title = 4.0;
    let between = if others.is_empty() { 0.0 } else { 26.0 };
    let high = ROW_HEIGHT * (proof.len() + others.len()) as f64 + between + 6.0;
    canvas
        .text(Text::new("On held-out trials", [12.0, title + 14.0], SMALL, TextAlign::Left).bold());
    let panel = canvas.panel(Panel {
        corner: [label, title + 22.0],
        size: [width - label - value, high],
        x: Axis::covering(
            "rms tip error (mm)",
            sizes().chain([floor_m, 0.0]).map(|size| 1e3 * size),
            4,
        ),
        y: Axis::bare_to(1.0),
        title: String::new(),
    });
    let mut y = panel.corner[1] + 6.0;
    for bar in &proof {
        y = draw_bar(&mut canvas, &panel, bar, y, floor_m);
    }
    let proof_end = y;
    if !others.is_empty() {
        y += between;
        let title = "Candidates, on trials of the fit that they have not seen";
        heading(&mut canvas, title, y - 7.0, width);
    }
    for bar in &others {
        y = draw_bar(&mut canvas, &panel, bar, y, floor_m);
    }
    let bottom = panel.corner[1] + high;
    let pieces = if others.is_empty() {
        vec![[panel.corner[1], bottom]]
    } else {
        vec![[panel.corner[1], proof_end], [proof_end + between - 3.0, bottom]]
    };
    noise(&mut canvas, panel.at(1e3 * floor_m, 0.0)[0], &pieces, floor_m);
    canvas.height = (panel.corner[1] + high + 42.0).ceil();
    Some(canvas)
}

/// A heading across the picture; what of the grid is behind it is covered.
fn heading(canvas: &mut Canvas, words: &str, baseline: f64, width: f64) {
    let words = fitted(words, 0.97 * SMALL, width - 40.0);
    let end = 16.0 + text_width(&words, SMALL, true);
    canvas.rectangle([10.0, baseline - 10.0], [end, baseline + 4.0], WHITE, 1.0);
    canvas.text(Text::new(words, [12.0, baseline], SMALL, TextAlign::Left).bold());
}

/// Before and after.
fn proof(report: &DiscoveryReport) -> Vec<Bar> {
    let gap = &report.findings.gap;
    let before = Bar { name: report.before().to_owned(), size_m: gap.before_m, colour: VERMILION };
    let names: Vec<&str> =
        report.findings.effects.iter().map(|effect| effect.name.as_str()).collect();
    let name = if names.len() == 1 {
        format!("with {}", names[0])
    } else {
        "with the effects found".to_owned()
    };
    let after = report.changed().then_some(Bar { name, size_m: gap.after_m, colour: BLUE });
    std::iter::once(before).chain(after).collect()
}

/// The answer, where there is one, the leading candidates without it, and what others add to it.
/// What other trials do not pin down, and so is worse than the model without any effect, is left
/// out.
fn others(report: &DiscoveryReport) -> Vec<Bar> {
    let answer = report.findings.candidates.iter().find(|candidate| candidate.why_not.is_empty());
    let shown = |name: &str| {
        let added = answer.and_then(|answer| name.strip_prefix(&answer.name)?.strip_prefix(" + "));
        added.map_or_else(|| name.to_owned(), |added| format!("… + {added}"))
    };
    let is_shown = |candidate: &&Candidate| {
        !candidate.why_not.is_empty() && candidate.after_m <= report.findings.gap.before_m
    };
    let (more, rivals): (Vec<&Candidate>, Vec<&Candidate>) = report
        .findings
        .candidates
        .iter()
        .filter(is_shown)
        .partition(|candidate| shown(&candidate.name) != candidate.name);
    let beaten = rivals.into_iter().take(MAX_RIVALS).chain(more).take(MAX_CANDIDATES);
    let others: Vec<Bar> = beaten
        .map(|candidate| Bar {
            name: shown(&candidate.name),
            size_m: candidate.after_m,
            colour: OTHER,
        })
        .collect();
    let answer_bar = answer.filter(|candidate| candidate.after_m.is_finite() && !others.is_empty());
    let answer_bar = answer_bar.map(|candidate| Bar {
        name: "the answer".to_owned(),
        size_m: candidate.after_m,
        colour: BLUE,
    });
    answer_bar.into_iter().chain(others).collect()
}

fn draw_bar(canvas: &mut Canvas, panel: &Panel, bar: &Bar, y: f64, floor_m: f64) -> f64 {
    let base = y + 0.5 * BAR_HEIGHT + 3.6;
    let name = fitted(&bar.name, SMALL, panel.corner[0] - 22.0);
    canvas.text(Text::new(name, [panel.corner[0] - 8.0, base], SMALL, TextAlign::Right));
    let zero = panel.at(0.0, 0.0)[0];
    let end = if bar.size_m.is_finite() { panel.at(1e3 * bar.size_m, 0.0)[0] } else { zero };
    canvas.rectangle([zero, y], [end.max(zero + 0.6), y + BAR_HEIGHT], bar.colour, 1.0);
    let right = canvas.width - 10.0;
    let values = [(right - 42.0, millimetres(bar.size_m)), (right, times(bar.size_m, floor_m))];
    for (x, words) in values {
        canvas.text(Text::new(words, [x, base], SMALL, TextAlign::Right));
    }
    y + ROW_HEIGHT
}

/// The noise floor: no model can come below it. The line runs over `pieces` and leaves the heading
/// between them free.
fn noise(canvas: &mut Canvas, x: f64, pieces: &[[f64; 2]], floor_m: f64) {
    let Some([top, _]) = pieces.first().copied().filter(|_| x.is_finite()) else { return };
    for [from, to] in pieces {
        canvas.line(&[[x, *from], [x, *to]], 1.3, INK, DASHED);
    }
    canvas.line(&[[x, top - 6.0], [x, top]], 1.3, INK, &[]);
    let label = format!("noise floor {}", millimetres(floor_m));
    let wide = text_width(&label, SMALL, false);
    let at = (x - 0.5 * wide).clamp(130.0, (canvas.width - 10.0 - wide).max(130.0));
    canvas.text(Text::new(label, [at, top - 9.0], SMALL, TextAlign::Left));
}
