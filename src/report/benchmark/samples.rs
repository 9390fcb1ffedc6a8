//! What is left with fewer samples: the gap that is closed, by what was found and by what a lab
//! would try instead, and the share of single effects that are named right, against the samples of
//! the recording.

use super::cases::in_catalogue;
use super::measures::noise_name;
use super::share::{IntervalEstimate, median, wilson};
use crate::data::findings::CaseRow;
use crate::report::discovery::answer::closed;
use crate::report::drawing::{Axis, Canvas, LegendEntry, Panel, Text, TextAlign, legend};
use crate::report::order::ascending;
use crate::report::style::{GREY, LINE, LOOKS, Look, MARKER, PAGE_WIDTH, SMALL};

const LEFT_MARGIN: f64 = 58.0;
const TOP_MARGIN: f64 = 54.0;
const PANEL_HEIGHT: f64 = 190.0;
const PANEL_WIDTH: f64 = (PAGE_WIDTH - 2.0 * LEFT_MARGIN - 24.0) / 2.0;

/// A line: its name and what of the cases with so many samples stands on it.
type Series<'a> = (String, Box<dyn Fn(&[&CaseRow]) -> Option<IntervalEstimate> + 'a>);

/// The gap that a remedy, which leaves `after_m` of a case, closes; all levels of noise together.
fn closing(name: &str, after_m: fn(&CaseRow) -> f64) -> Series<'static> {
    let share = move |cases: &[&CaseRow]| {
        let cases_in_catalogue = cases.iter().filter(|case| in_catalogue(case));
        let closed = cases_in_catalogue
            .filter_map(|case| closed(case.before_m, after_m(case), case.floor_m));
        median(&closed.collect::<Vec<f64>>())
    };
    (name.to_owned(), Box::new(share))
}

/// Single effects named right at one level of noise.
fn named(noise_m: f64) -> Series<'static> {
    let share = move |cases: &[&CaseRow]| {
        let single = cases.iter().filter(|case| case.group == "single" && case.noise_m == noise_m);
        wilson(single.clone().filter(|case| case.right).count() as u64, single.count() as u64)
    };
    (noise_name(noise_m), Box::new(share))
}

/// Draws both panels.
pub(crate) fn draw(cases: &[CaseRow]) -> Canvas {
    let mut canvas = Canvas::new(PAGE_WIDTH, PANEL_HEIGHT + 112.0);
    let remedies = [
        closing("what was found", |case| case.after_m),
        closing("GP", |case| case.gp_m),
        closing("stiffness refitted", |case| case.stiffness_only_m),
    ];
    let (title, axis) = ("(a) gap closed on held-out trials", "squared error beyond noise (%)");
    SamplesPanel { title, axis, lines: &remedies }.draw(&mut canvas, 0, cases);
    let noises = ascending(cases.iter().map(|case| case.noise_m));
    let noises: Vec<Series> = noises.into_iter().take(LOOKS.len()).map(named).collect();
    let (title, axis) = ("(b) single effects named right", "share (%)");
    SamplesPanel { title, axis, lines: &noises }.draw(&mut canvas, 1, cases);
    let note = "(a): medians of singles and pairs, what is beyond the axis at its end; bars: 95 % \
                intervals";
    canvas.text(
        Text::new(
            note,
            [PAGE_WIDTH - 14.0, TOP_MARGIN + PANEL_HEIGHT + 50.0],
            SMALL,
            TextAlign::Right,
        )
        .colour(GREY),
    );
    canvas
}

/// A panel: its title, the label of its axis and its lines.
struct SamplesPanel<'a> {
    title: &'static str,
    axis: &'static str,
    lines: &'a [Series<'a>],
}

impl SamplesPanel<'_> {
    /// Draws panel number `index` under its legend.
    fn draw(&self, canvas: &mut Canvas, index: usize, cases: &[CaseRow]) {
        let SamplesPanel { title, axis, lines } = *self;
        let counts = ascending(cases.iter().map(|case| case.samples as f64));
        let names: Vec<String> = counts.iter().map(f64::to_string).collect();
        let left = LEFT_MARGIN + (PANEL_WIDTH + LEFT_MARGIN + 12.0) * index as f64;
        let keys: Vec<(LegendEntry, &str)> = LOOKS
            .into_iter()
            .zip(lines)
            .map(|(look, (name, _))| (LegendEntry::Plain(look), name.as_str()))
            .collect();
        legend(canvas, [left, 18.0], left + PANEL_WIDTH, &keys);
        let panel = canvas.panel(Panel {
            corner: [left, TOP_MARGIN],
            size: [PANEL_WIDTH, PANEL_HEIGHT],
            x: Axis::categories("samples in the recording", &names),
            y: Axis::exact(axis, 0.0, 100.0, 5),
            title: title.to_owned(),
        });
        for (turn, ((_, estimate), look)) in lines.iter().zip(LOOKS).enumerate() {
            let aside = 0.06 * (turn as f64 - 0.5 * (lines.len() - 1) as f64);
            let at = |count: f64| {
                let with_samples: Vec<&CaseRow> =
                    cases.iter().filter(|case| case.samples as f64 == count).collect();
                estimate(&with_samples)
            };
            let places = counts.iter().enumerate();
            let points = places.filter_map(|(place, count)| {
                at(*count).map(|interval| (place as f64 + aside, interval))
            });
            series(canvas, &panel, &points.collect::<Vec<(f64, IntervalEstimate)>>(), look);
        }
    }
}

/// A line with intervals; what leaves the panel stands at its edge.
fn series(canvas: &mut Canvas, panel: &Panel, points: &[(f64, IntervalEstimate)], look: Look) {
    let percent = |share: f64| (100.0 * share).clamp(panel.y.low, panel.y.high);
    let line: Vec<[f64; 2]> =
        points.iter().map(|(x, interval)| [*x, percent(interval.value)]).collect();
    panel.line(canvas, &line, look.colour, look.dash, LINE);
    for (x, interval) in points {
        if interval.low_95.is_finite() && interval.high_95.is_finite() {
            panel.interval(
                canvas,
                *x,
                [percent(interval.low_95), percent(interval.high_95)],
                look.colour,
            );
        }
    }
    for [x, y] in line {
        canvas.marker(panel.at(x, y), look.marker, MARKER, look.colour, false);
    }
}
