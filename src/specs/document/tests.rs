use super::merged::Document;
use super::path::KeyPath;
use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Outer {
    points: u64,
    duration_s: f64,
    #[serde(default)]
    inner: Option<Inner>,
    #[serde(default)]
    plant: Option<TestPlant>,
    #[serde(default)]
    named: std::collections::BTreeMap<String, AllDefaults>,
}

#[derive(Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct AllDefaults {
    stop_m: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Inner {
    sizes: Vec<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum TestPlant {
    Grid {
        rows: u64,
    },
    #[allow(dead_code)]
    Walk {
        every: f64,
    },
}

fn parse(files: &[(&str, &str)], sets: &[&str]) -> Result<Outer, String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let document =
        Document::read(&folder.path().join(files[0].0), &sets, &[KeyPath::default().key("inner")]);
    document
        .and_then(|document| document.parse())
        .map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

#[test]
fn an_inherited_mapping_is_dropped_by_null_and_an_own_one_has_defaults() {
    let files = [
        ("a.yaml", "extends: b.yaml\nnamed: {gone: null, own: null}\n"),
        ("b.yaml", "points: 1\nduration_s: 5\nnamed: {gone: {stop_m: 1}, kept: {stop_m: 2}}\n"),
    ];
    let names = |sets: &[&str]| parse(&files, sets).unwrap().named.into_keys().collect::<Vec<_>>();
    assert_eq!(names(&[]), ["kept", "own"]);
    assert_eq!(names(&["named.kept=null"]), ["own"]);
}

fn error(files: &[(&str, &str)], sets: &[&str]) -> String {
    parse(files, sets).unwrap_err()
}

#[test]
fn a_child_overrides_its_parent_and_an_option_both() {
    let files = [
        ("a.yaml", "extends: b.yaml\npoints: 2\ninner: {sizes: [3]}\nplant: {grid: {rows: 4}}\n"),
        (
            "b.yaml",
            "points: 1\nduration_s: 5\ninner: {sizes: [1, 2]}\nplant: {walk: {every: 1.5}}\n",
        ),
    ];
    let read = parse(&files, &["inner.sizes=[7, 8]"]).unwrap();
    assert_eq!((read.points, read.duration_s, read.inner.unwrap().sizes), (2, 5.0, vec![7, 8]));
    assert!(matches!(read.plant, Some(TestPlant::Grid { rows: 4 })));
}

#[test]
fn a_named_file_takes_the_place_of_its_name_and_is_named_in_errors() {
    let spec = ("a.yaml", "extends: b.yaml\ninner: c.yaml\n");
    let base = ("b.yaml", "points: 1\nduration_s: 5\ninner: d.yaml\n");
    let other = ("d.yaml", "sizes: [1]\nmore: 2\n");
    let read = parse(&[spec, base, ("c.yaml", "sizes: [4]\n"), other], &[]).unwrap();
    assert_eq!(read.inner.unwrap().sizes, [4]);
    let read =
        parse(&[spec, base, ("c.yaml", "sizes: [4]\n"), other], &["inner.sizes=[9]"]).unwrap();
    assert_eq!(read.inner.unwrap().sizes, [9]);
    let said = error(&[spec, base, ("c.yaml", "sizes: [4]\nmore: 1\n"), other], &[]);
    assert!(said.starts_with("c.yaml:2:1: inner.more: found the unknown key `more`"), "{said}");
    let said = error(&[spec, base, other], &[]);
    assert!(said.starts_with("a.yaml:2:8: inner: found no file `c.yaml`"), "{said}");
}

#[test]
fn errors_point_to_the_file_that_wrote_the_value() {
    let base = ("b.yaml", "points: 1\nduration_s: 5\n");
    let cases = [
        (
            "extends: b.yaml\nduration_ms: 2\n",
            "a.yaml:2:1: duration_ms: found the unknown key `duration_ms`",
        ),
        (
            "extends: b.yaml\n\npoints: [1]\n",
            "a.yaml:3:9: points: found sequence, expected a whole number",
        ),
        (
            "extends: b.yaml\ninner: {sizes: [1, x]}\n",
            "a.yaml:2:20: inner.sizes[1]: found text \"x\"",
        ),
        (
            "extends: b.yaml\nplant: {grid: {row: 3}}\n",
            "a.yaml:2:16: plant.grid.row: found the unknown",
        ),
        ("extends: b.yaml\nplant: {ring: {}}\n", "a.yaml:2:"),
        ("extends: b.yaml\ninner: {}\n", "a.yaml:2:8: inner.sizes: found no such key"),
        ("extends: c.yaml\n", "a.yaml:1:10: extends: found no file `c.yaml`"),
        ("extends: a.yaml\n", "a.yaml:1:10: extends: found `a.yaml`, which extends this file"),
        ("a: [\n", "a.yaml:2:1: found"),
        ("points: 1\npoints: 2\n", "a.yaml:"),
    ];
    for (text, expected) in cases {
        let said = error(&[("a.yaml", text), base], &[]);
        assert!(said.starts_with(expected), "{text}\n  gave   {said}\n  wanted {expected}");
    }
    assert!(
        error(&[("a.yaml", "extends: b.yaml\nduration_ms: 2\n"), base], &[])
            .contains("did you mean `duration_s`")
    );
    let said =
        error(&[("a.yaml", "extends: b.yaml\n"), ("b.yaml", "points: -1\nduration_s: 5\n")], &[]);
    assert!(
        said.starts_with("b.yaml:1:9: points: found integer `-1`, expected a whole number"),
        "{said}"
    );
    let said = error(&[("a.yaml", "points: 1\nduration_s: 1\n")], &["inner.sizes=3"]);
    assert!(
        said.starts_with("--set inner.sizes=3: inner.sizes: found integer `3`, expected a list"),
        "{said}"
    );
}
