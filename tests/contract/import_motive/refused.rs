//! What is no export, no log or no body is refused in words that help.

use crate::support::motive::{Bench, PLAIN, difference, export, log, plain_log};

#[test]
fn a_log_that_cannot_be_placed_is_refused() {
    let bench = Bench::new(&export(&PLAIN, &[]));
    let place = "log.csv, line 1, column `export_time_s`";
    let timed = log();
    assert!(
        bench.refused(&["--offset-s", "0"]).contains("the time of each row, and also --offset-s")
    );
    let milliseconds = "trial,time_s,tendon_1_m,export_time_s\n0,0,0,250\n0,0.2,0,450\n";
    let cases: [(&str, &[&str], &str); 9] = [
        (&plain_log(), &[], place),
        (&plain_log(), &["--offset-s", "0.25"], "2 trials and 1 offsets"),
        (&plain_log(), &["--offset-s", "0.25,x"], "expected seconds"),
        (&plain_log(), &["--offset-s", "0.25,inf"], "expected seconds"),
        (&plain_log(), &["--offset-s", "0.25,0.3"], "log.csv, line 5, column `time_s`"),
        (&plain_log(), &["--offset-s", "50,60"], "which goes from 0 s to 3 s"),
        (&timed.replace("0.4531,n1", ",n1"), &[], "line 3, column `export_time_s`: found nothing"),
        (
            &timed.replace("0.4531,n1", "0.1,n1"),
            &[],
            "line 3, column `export_time_s`: found 0.100000 s",
        ),
        (
            milliseconds,
            &[],
            "line 3, column `export_time_s`: found 200.000000 s after the trial's first row, \
             expected about 0.2",
        ),
    ];
    for (log, more, words) in cases {
        bench.put("log.csv", log);
        let said = bench.refused(more);
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn bodies_are_found_by_name_and_listed_when_they_are_not() {
    let text = export(&PLAIN, &[]);
    let exact = Bench::new(&text);
    let (known, _) = exact.imported(&["--base", "base", "--tip", "tip, upper"]);
    let capitals = Bench::new(&text.replace(",base", ",Base plate").replace("tip, upper", "TIP"));
    assert_eq!(difference(&capitals.imported(&[]).0, &known), 0.0);
    let listed = "export.csv, line 4: found the rigid bodies `Base plate`, `TIP`, expected one \
                  called `base plate`";
    assert!(capitals.refused(&["--base", "base plate"]).contains(listed));
    assert!(capitals.refused(&["--tip", "Base plate"]).contains("as base and as tip"));
    let both = Bench::new(&text.replace(",base", ",base 1").replace("tip, upper", "base 2"));
    assert!(
        both.refused(&["--tip", "base 1"]).contains("expected one called `base`, or a single one")
    );
    assert!(both.refused(&["--base", "base 1"]).contains("(--tip NAME)"));
    let twins = Bench::new(&text.replace("\"tip, upper\"", "base"));
    assert!(twins.refused(&["--tip", "base"]).contains("`base`, `base`"), "one name, two IDs");
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn a_broken_export_is_refused_by_line_and_column() {
    let good = export(&PLAIN, &[]);
    let line = |number: usize| good.lines().nth(number - 1).unwrap().to_owned();
    let cells = |number: usize| line(number).split(',').map(str::to_owned).collect::<Vec<String>>();
    let with = |number: usize, cell: usize, text: &str| {
        let mut cells = cells(number);
        cells[cell] = text.to_owned();
        good.replacen(&line(number), &cells.join(","), 1)
    };
    // Line 7 is `Frame,…`; cell 6 of the lines after it is the base's Position X.
    let cases: Vec<(String, &str)> = vec![
        (String::new(), "export.csv: empty"),
        ("trial,time_s\n0,0\n".to_owned(), "line 1: found `trial`, expected `Format Version,1.2…`"),
        (good.replace(',', ";"), "line 1: found cells between semicolons"),
        (
            good.replace("Version,1.23", "Version,2.0"),
            "line 1, column `Format Version`: found `2.0`",
        ),
        (
            good.replace("Units,Meters", "Units,Furlongs"),
            "line 1, column `Length Units`: found `Furlongs`",
        ),
        (good.replace("Length Units", "Units"), "line 1, column `Length Units`: found nothing"),
        (
            good.replace("Type,Quaternion", "Type,ZYX"),
            "line 1, column `Rotation Type`: found `ZYX`",
        ),
        (
            good.replace("Space,Global", "Space,Local"),
            "line 1, column `Coordinate Space`: found `Local`",
        ),
        (
            good.replace("Rigid Body", "Bone"),
            "line 3: found only `Bone`, no column of a `Rigid Body` or a `Marker`",
        ),
        (
            good.replacen("Frame,Time (Seconds)", "Frame,Time (ms)", 1),
            "line 7: found no column `Time (Seconds)`",
        ),
        (good.replacen("Frame,Time (Seconds)", "x,y", 1), "line 8: found a row of numbers"),
        (good.lines().take(6).collect::<Vec<_>>().join("\n"), "line 6: found the end of the file"),
        (
            good.lines().take(7).collect::<Vec<_>>().join("\n"),
            "export.csv: empty: found a header and no frames",
        ),
        (with(7, 6, "Z"), "line 7, column `base Position X`: found no such column"),
        (with(7, 7, "X"), "line 7, column `base Position X`: found 2 such columns"),
        (
            with(9, 6, "left"),
            "line 9, column `base Position X`: found `left`, expected a number with a decimal \
             point",
        ),
        (with(9, 6, "\"0,25\""), "line 9, column `base Position X`: found `0,25`"),
        (
            with(9, 6, "0,25"),
            "line 9: found 19 cells, expected 18 as in the header (decimal commas",
        ),
        (with(9, 6, "inf"), "line 9, column `base Position X`: found `inf`"),
        (with(9, 5, "0.2"), "line 9, column `base Rotation W`: found `0.2` of length"),
        (with(9, 1, ""), "line 9, column `Time (Seconds)`: found nothing"),
        (
            with(9, 1, "0.000000"),
            "line 9, column `Time (Seconds)`: found `0.000000`, expected more than 0",
        ),
        (with(9, 4, "\"0.1"), "line 9: found a quotation mark that is not closed"),
        (
            good.trim_end().rsplit_once(',').unwrap().0.to_owned(),
            "line 368: found 17 cells, expected 18 as in the header",
        ),
    ];
    for (text, words) in cases {
        let said = Bench::new(&text).refused(&[]);
        assert!(said.contains("export.csv") && said.contains(words), "{words}: {said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    }
    let bench = Bench::new("");
    std::fs::write(bench.path("export.csv"), b"Format Version,1.23\n\xff\xfe\n").unwrap();
    assert!(bench.refused(&[]).contains("line 2: found bytes that are not text, expected UTF-8"));
    assert!(bench.refused(&["--out", "log.csv/no/out.csv"]).starts_with("error: "));
}
