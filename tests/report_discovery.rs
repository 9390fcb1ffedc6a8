//! What people see of a discovery: the page, its figures and its tables.

mod report_discovery_rows;

use std::path::Path;

use report_discovery_rows::{Made, ambiguous, consistent, named};
use serde_json::{Value, json};
use spinebench::data::findings::Verdict;
use spinebench::report::discovery::artifacts;
use spinebench::report::{Artifact, write};

fn files(made: &Made) -> Vec<Artifact> {
    artifacts(&made.story()).unwrap()
}

fn page(made: &Made) -> String {
    let files = files(made);
    let page = files.iter().find(|file| file.name == "report.html").unwrap();
    String::from_utf8(page.bytes.clone()).unwrap()
}

#[test]
fn the_same_findings_give_the_same_bytes() {
    for (name, made) in [("named", named()), ("consistent", consistent()), ("ambiguous", ambiguous())] {
        let first = files(&made);
        assert!(first == files(&made), "{name}");
        // Left there to be looked at.
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("discovery").join(name);
        write(&first, &folder, &folder).unwrap();
    }
}
