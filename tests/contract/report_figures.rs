//! What every figure of the registry must do, whatever it shows.

use std::path::Path;

use crate::support::report_rows::{published, sweep};
use crate::support::text_overlap::assert_apart;
use spinebench::report::{OutputFolder, Published, ReportError, figure, figures, write};
use spinebench::rows::table_descriptions;

#[test]
fn no_rows_are_an_error() {
    for figure in figures() {
        let error = (figure.render)(&Published::default()).unwrap_err();
        assert!(
            matches!(error, ReportError::NoRows { figure: name, .. } if name == figure.name),
            "{error}"
        );
    }
}

#[test]
fn names_are_unique_and_one_repetition_makes_pictures_and_a_caption() {
    for (index, one) in figures().enumerate() {
        assert!(figures().take(index).all(|other| other.name != one.name));
        assert_eq!(figure(one.name).unwrap().about, one.about);
        let files = (one.render)(&published(one.name, 1)).unwrap();
        for end in ["png", "svg"] {
            let name = format!("{}.{end}", one.name);
            let file = files.iter().find(|file| file.name == name).unwrap();
            assert_eq!(file.folder, OutputFolder::Plots);
            let start: &[u8] = if end == "png" { b"\x89PNG\r\n" } else { b"<svg " };
            assert!(file.bytes.starts_with(start), "{name}");
        }
        let captions = files
            .iter()
            .filter(|file| file.folder == OutputFolder::Plots && file.name.ends_with(".md"));
        for caption in captions {
            let words = String::from_utf8(caption.bytes.clone()).unwrap();
            let sentences = words.matches(". ").count() + usize::from(words.ends_with(".\n"));
            assert!((1..=5).contains(&sentences), "{}: {words}", caption.name);
        }
    }
}

/// Sizes of the texts of an SVG, points, of one that is printed 85 mm wide.
fn sizes_pt(svg: &str) -> Vec<f64> {
    let width: f64 =
        svg.split("viewBox=\"0 0 ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    let sizes = svg.split("font-size=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
    sizes.map(|size| size.parse::<f64>().unwrap() / width * 85.0 / 25.4 * 72.0).collect()
}

#[test]
fn over_one_column_every_text_is_read_and_none_lies_on_another() {
    for figure in figures() {
        let files = (figure.render)(&published(figure.name, 3)).unwrap();
        let svgs: Vec<_> = files.iter().filter(|file| file.name.ends_with(".svg")).collect();
        for svg in &svgs {
            assert_apart(&svg.name, &svg.bytes);
        }
        let columns: Vec<_> =
            svgs.iter().filter(|file| file.name.ends_with("_column.svg")).collect();
        assert!(2 * columns.len() == svgs.len(), "{}: one for each picture", figure.name);
        for column in columns {
            let text = String::from_utf8_lossy(&column.bytes);
            assert!(text.contains("width=\"85.0mm\""), "{}", column.name);
            let least = sizes_pt(&text).into_iter().fold(f64::INFINITY, f64::min);
            assert!(least >= 7.0, "{}: a text of {least:.1} pt", column.name);
        }
    }
}

#[test]
fn figures_are_drawn_again_from_what_is_published() {
    let looked_at = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report");
    for figure in figures() {
        let folder = tempfile::tempdir().unwrap();
        let rows = published(figure.name, 3).write(folder.path()).unwrap();
        let again = Published::read(folder.path()).unwrap();
        let files = (figure.render)(&rows).unwrap();
        assert!(files == (figure.render)(&again).unwrap(), "{}", figure.name);
        write(&files, &looked_at, &looked_at).unwrap();
    }
}

/// The first rows of every table that the figure has, with `hole` in place of numbers with
/// decimals.
fn poor_rows(figure: &str, keep: usize, hole: Option<&str>) -> Published {
    let folder = tempfile::tempdir().unwrap();
    published(figure, 1).write(folder.path()).unwrap();
    for table in table_descriptions() {
        let path = folder.path().join(table.file);
        let Ok(text) = std::fs::read_to_string(&path) else { continue };
        let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
        let poor = |line: &str| {
            if line.contains('"') {
                return line.to_owned();
            }
            let cells = header.iter().zip(line.split(',')).map(|(column, cell)| {
                let decimals = cell.parse::<f64>().is_ok() && cell.parse::<i64>().is_err();
                hole.filter(|_| decimals && !column.contains('.')).unwrap_or(cell)
            });
            cells.collect::<Vec<_>>().join(",")
        };
        let rows = text.lines().skip(1).take(keep).map(poor);
        let lines: Vec<String> = std::iter::once(header.join(",")).chain(rows).collect();
        std::fs::write(&path, lines.join("\n")).unwrap();
    }
    Published::read(folder.path()).unwrap()
}

#[test]
fn poor_rows_are_drawn_or_refused_but_never_crash() {
    for figure in figures() {
        for keep in [1, 3] {
            (figure.render)(&poor_rows(figure.name, keep, None)).unwrap();
        }
        for hole in ["", "inf"] {
            let drawn = (figure.render)(&poor_rows(figure.name, 3, Some(hole)));
            let refused = matches!(drawn, Err(ReportError::NoRows { .. }));
            assert!(drawn.is_ok() || refused, "{}, `{hole}`: {drawn:?}", figure.name);
        }
    }
}

#[test]
fn names_that_nobody_foresaw_are_drawn_too() {
    let mut rows = published("table1", 1);
    for row in rows.trials.iter_mut().filter(|row| row.training == "paper") {
        row.training = "half, \"trained\" & <odd>".to_owned();
    }
    let files = (figure("table1").unwrap().render)(&rows).unwrap();
    let svg = files.iter().find(|file| file.name == "table1.svg").unwrap();
    assert!(!String::from_utf8_lossy(&svg.bytes).contains("<odd>"), "text in SVG is escaped");
}

#[test]
fn sweeps_of_two_and_three_fields_are_heat_maps_and_of_more_are_left_to_the_table() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report");
    std::fs::create_dir_all(&folder).unwrap();
    let render = |fields: &[(&str, &[&str])]| {
        let rows = Published { sweep: sweep(fields, 3), ..Published::default() };
        (figure("sweep").unwrap().render)(&rows)
    };
    let thresholds = ("policies.c.switch_threshold_m", ["0.005", "0.01", "0.02"].as_slice());
    let kernels = ("gp.kernel", ["se_ard", "matern32", "matern52"].as_slice());
    let models =
        ("plant.simulated.model", ["../models/nominal.yaml", "../models/real.yaml"].as_slice());
    let files = render(&[kernels, thresholds]).unwrap();
    let svg = String::from_utf8_lossy(&files[1].bytes).into_owned();
    // Every cell has its number: A, B and pi_real in two modes, C in one.
    let numbers =
        svg.lines().filter(|line| line.trim().parse::<f64>().is_ok_and(|mm| mm > 1.0)).count();
    assert!(numbers >= 9 * 7, "{numbers}");
    assert!(svg.contains("Matérn 5/2") && svg.contains("threshold of policy C (mm)"), "{svg}");
    let triple = [models, kernels, thresholds];
    for (name, fields) in
        [("pair", &[kernels, thresholds][..]), ("files", &[models, kernels]), ("triple", &triple)]
    {
        for file in render(fields).unwrap() {
            std::fs::write(folder.join(format!("{name}_{}", file.name)), file.bytes).unwrap();
        }
    }
    let svg = String::from_utf8_lossy(&render(&triple).unwrap()[1].bytes).into_owned();
    assert_eq!(
        svg.matches("plant.simulated.model = ").count(),
        2,
        "a block for each value of the first field"
    );
    let error = render(&[kernels, thresholds, models, ("gp.folds", &["5", "10"])]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "sweep: found rows of 4 swept fields, expected one to three of them"
    );
}

#[test]
fn sweeps_of_any_size_and_kind_of_value_are_drawn() {
    let numbers = |count: i32, value: &dyn Fn(i32) -> f64| {
        (0..count).map(|k| format!("{:e}", value(k))).collect::<Vec<_>>()
    };
    let cases: [Vec<String>; 5] = [
        numbers(1500, &f64::from),
        numbers(40, &|k| 10f64.powf(f64::from(k) / 8.0 - 4.0)),
        numbers(1, &f64::from),
        vec![
            "true".into(),
            "null".into(),
            "[{\"tip_load\":{\"mass_kg\":0.02}}]".into(),
            "<&>".into(),
        ],
        (0..30).map(|k| format!("a rather long name of a value, number {k}")).collect(),
    ];
    for values in &cases {
        let values: Vec<&str> = values.iter().map(String::as_str).collect();
        for fields in [
            &[("a.b", values.as_slice())] as &[(&str, &[&str])],
            &[("a.b", &values[..values.len().min(45)]), ("c.d", &values[..values.len().min(60)])],
        ] {
            let rows = Published { sweep: sweep(fields, 1), ..Published::default() };
            (figure("sweep").unwrap().render)(&rows).unwrap();
        }
    }
}
