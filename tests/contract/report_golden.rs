//! Three figures and a page as they are kept in `tests/reference/golden`. A change of what people
//! see is a change of these files, which `GOLDEN=accept` writes.

use std::path::Path;

use crate::support::discovery_rows;
use crate::support::report_rows::{published, sweep};
use spinebench::report::discovery::artifacts;
use spinebench::report::{Artifact, Published, figure};

/// Compares a text with the kept one, or replaces that.
fn compare(kept: &str, now: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/golden").join(kept);
    if std::env::var_os("GOLDEN").is_some_and(|wish| wish == "accept") {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        return std::fs::write(path, now).unwrap();
    }
    let before = std::fs::read_to_string(path).unwrap_or_default();
    if before == now {
        return;
    }
    let same_lines =
        before.lines().zip(now.lines()).take_while(|(before, now)| before == now).count();
    let [before, now] =
        [before.as_str(), now].map(|text| text.lines().nth(same_lines).unwrap_or("(the end)"));
    let same_letters =
        before.chars().zip(now.chars()).take_while(|(before, now)| before == now).count();
    let shown = |line: &str| {
        line.chars().skip(same_letters.saturating_sub(60)).take(200).collect::<String>()
    };
    panic!(
        "{kept}, line {}:\n- {}\n+ {}\nIf it is right: GOLDEN=accept cargo test --release --test \
         contract golden",
        same_lines + 1,
        shown(before),
        shown(now)
    );
}

fn file(files: Vec<Artifact>, name: &str) -> String {
    let file = files.into_iter().find(|file| file.name == name).unwrap();
    String::from_utf8(file.bytes).unwrap()
}

fn compare_figure(name: &str, rows: &Published) {
    let drawing = format!("{name}.svg");
    compare(&drawing, &file((figure(name).unwrap().render)(rows).unwrap(), &drawing));
}

#[test]
fn golden_table1() {
    compare_figure("table1", &published("table1", 3));
}

#[test]
fn golden_lines() {
    compare_figure("gp_coverage", &published("gp_coverage", 3));
}

#[test]
fn golden_heat_map() {
    let fields: [(&str, &[&str]); 2] = [
        ("gp.kernel", &["se_ard", "matern32", "matern52"]),
        ("policies.c.switch_threshold_m", &["0.005", "0.01", "0.02"]),
    ];
    compare_figure("sweep", &Published { sweep: sweep(&fields, 3), ..Published::default() });
}

/// The page without what its drawings show and without the revision of the build.
#[test]
fn golden_page() {
    let page = file(artifacts(&discovery_rows::named().story()).unwrap(), "report.html");
    let page = page.replace(spinebench::VERSION, "VERSION");
    let (start, drawings) = page.split_once("<svg").unwrap();
    let rest = drawings.split("<svg").map(|piece| piece.split_once("</svg>").unwrap().1);
    compare("report.html", &std::iter::once(start).chain(rest).collect::<Vec<_>>().join("<svg/>"));
}
