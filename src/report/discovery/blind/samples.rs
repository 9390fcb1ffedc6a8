//! What is left with fewer samples: the gap that is closed and the share of single effects that are named right, against
//! the samples of the recording, a line for each level of noise.

use super::super::super::axes::{Axis, Panel};
use super::super::super::canvas::{Align, Canvas, Text};
use super::super::super::legend::{Key, legend};
use super::super::super::style::{GREY, LINE, LOOKS, Look, MARKER, PAGE_WIDTH, SMALL};
use super::cases::{distinct, gap_closed, in_catalogue};
use super::measures::noise_name;
use super::share::{Estimate, median, wilson};
use crate::data::findings::CaseRow;

const LEFT: f64 = 58.0;
const HIGH: f64 = 190.0;

/// A panel: its title, its axis, and what of some cases stands in it, in percent.
type Subject = (&'static str, &'static str, fn(&[&CaseRow]) -> Option<Estimate>);

const SUBJECTS: [Subject; 2] = [
    ("(a) gap closed on held-out trials", "squared error beyond noise (%)", closed),
    ("(b) single effects named right", "share (%)", named),
];

fn closed(cases: &[&CaseRow]) -> Option<Estimate> {
    let closed = cases.iter().filter(|case| in_catalogue(case)).filter_map(|case| gap_closed(case));
    median(&closed.collect::<Vec<f64>>())
}

fn named(cases: &[&CaseRow]) -> Option<Estimate> {
    let single = cases.iter().filter(|case| case.group == "single");
    wilson(single.clone().filter(|case| case.right).count() as u64, single.count() as u64)
}

/// Draws both panels.
pub(super) fn draw(cases: &[CaseRow]) -> Canvas {
    let counts = distinct(cases.iter().map(|case| case.samples as f64));
    let noises: Vec<f64> = distinct(cases.iter().map(|case| case.noise_m)).into_iter().take(LOOKS.len()).collect();
    let labels: Vec<String> = noises.iter().map(|noise_m| noise_name(*noise_m)).collect();
    let mut canvas = Canvas::new(PAGE_WIDTH, HIGH + 112.0);
    let keys: Vec<(Key, &str)> =
        LOOKS.into_iter().zip(&labels).map(|(look, label)| (Key::Plain(look), label.as_str())).collect();
    legend(&mut canvas, [LEFT, 18.0], PAGE_WIDTH - 12.0, &keys);
    let wide = (PAGE_WIDTH - 2.0 * LEFT - 24.0) / 2.0;
    let names: Vec<String> = counts.iter().map(f64::to_string).collect();
    for (index, (title, label, estimate)) in SUBJECTS.into_iter().enumerate() {
        let panel = Panel {
            corner: [LEFT + (wide + LEFT + 12.0) * index as f64, 54.0],
            size: [wide, HIGH],
            x: Axis::categories("samples in the recording", &names),
            y: Axis::exact(label, 0.0, 100.0, 5),
            title: title.to_owned(),
        };
        panel.draw(&mut canvas);
        for (turn, (noise_m, look)) in noises.iter().zip(LOOKS).enumerate() {
            let aside = 0.06 * (turn as f64 - 0.5 * (noises.len() - 1) as f64);
            let at = |count: f64| {
                let here = cases.iter().filter(|case| case.samples as f64 == count && case.noise_m == *noise_m);
                estimate(&here.collect::<Vec<&CaseRow>>())
            };
            let points: Vec<(f64, Estimate)> = counts
                .iter()
                .enumerate()
                .filter_map(|(place, count)| at(*count).map(|found| (place as f64 + aside, found)))
                .collect();
            series(&mut canvas, &panel, &points, look);
        }
    }
    let note = "singles and pairs in (a): median; bars: 95 % intervals";
    canvas.text(Text::new(note, [PAGE_WIDTH - 14.0, 54.0 + HIGH + 50.0], SMALL, Align::Right).colour(GREY));
    canvas
}

/// A line with intervals; what leaves the panel stands at its edge.
fn series(canvas: &mut Canvas, panel: &Panel, points: &[(f64, Estimate)], look: Look) {
    let percent = |share: f64| (100.0 * share).clamp(panel.y.low, panel.y.high);
    let line: Vec<[f64; 2]> = points.iter().map(|(x, found)| [*x, percent(found.value)]).collect();
    panel.line(canvas, &line, look.colour, look.dash, LINE);
    for (x, found) in points {
        if found.low_95.is_finite() && found.high_95.is_finite() {
            panel.interval(canvas, *x, [percent(found.low_95), percent(found.high_95)], look.colour);
        }
    }
    for [x, y] in line {
        canvas.marker(panel.at(x, y), look.marker, MARKER, look.colour, false);
    }
}
