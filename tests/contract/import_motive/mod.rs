//! `import motive`: exports in the dialects of Motive's versions give the motion that they were
//! written from.

mod refused;

use crate::support::motive::{
    AT_S, Bench, Column, FRAMES, LENGTHS, PLAIN, RATE_HZ, apart, column, dialects, difference,
    export, log, plain_log, tip, to_motive, written,
};
use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use spinebench::data::Recording;
use spinebench::data::import::ExportFormat;
use spinebench::math::rotation::parts;
use std::path::Path;

#[test]
fn every_dialect_gives_the_motion_that_was_written() {
    let lost: Vec<usize> = (80..90).chain(120..123).collect();
    let mut first: Option<Recording> = None;
    for dialect in dialects() {
        let bench = Bench::new(&export(&dialect, &lost));
        let (recording, said) = bench.imported(&[]);
        assert!(
            said.contains("1 of 6 rows were not tracked")
                && said.contains("34.5° relative to the tracking frame"),
            "{said}"
        );
        let valid: Vec<bool> = (0..6).map(|row| recording.is_valid(row)).collect();
        assert_eq!(
            valid,
            [true, true, false, true, true, true],
            "three frames are bridged, ten are not"
        );
        for row in (0..6).filter(|&row| valid[row]) {
            let (place_m, turn) = tip(AT_S[row]);
            assert!(
                apart(&recording.tip_m.as_ref().unwrap()[row], place_m.as_slice()) < 1e-4,
                "row {row}"
            );
            assert!(
                apart(&recording.tip_quaternion.as_ref().unwrap()[row], &parts(&turn)) < 1e-4,
                "row {row}"
            );
            let pose = recording.base.as_ref().unwrap()[row];
            assert!(apart(&pose.position_m, &[1.1, -0.4, -0.3]) < 1e-6, "{pose:?}");
            let turn = UnitQuaternion::new(Vector3::new(0.6, -0.05, -0.02));
            assert!(apart(&pose.quaternion, &parts(&turn)) < 1e-6, "{pose:?}");
        }
        let first = first.get_or_insert_with(|| recording.clone());
        let apart = difference(first, &recording);
        assert!(
            apart < if dialect.euler || dialect.unit.0 == "Inches" { 1e-6 } else { 1e-12 },
            "{}: {apart}",
            dialect.version
        );
        assert_eq!(recording.extra, first.extra, "the log's own columns are carried");
    }
}

#[test]
fn the_tip_may_be_given_along_the_tracking_axes_or_other_ones() {
    let bench = Bench::new(&export(&PLAIN, &[]));
    let (recording, said) = bench.imported(&["--frame", "tracking"]);
    assert!(said.contains("the tracking frame's axes"), "{said}");
    for row in 0..6 {
        let (place_m, turn) = tip(AT_S[row]);
        let base = UnitQuaternion::new(Vector3::new(0.6, -0.05, -0.02));
        assert!(apart(&recording.tip_m.as_ref().unwrap()[row], (base * place_m).as_slice()) < 1e-4);
        assert!(
            apart(&recording.tip_quaternion.as_ref().unwrap()[row], &parts(&(base * turn))) < 1e-4
        );
    }
    // The robot along Motive's −x.
    let (turned, _) = bench.imported(&["--axes", "x=+y,y=-z,z=-x"]);
    let [place_m, other_m] =
        [&recording, &turned].map(|recording| recording.base.as_ref().unwrap()[0].position_m);
    assert_eq!(other_m, [place_m[0], -place_m[2], place_m[1]]);
    for axes in ["x=+y,y=+x,z=+z", "x=+y,y=-x", "up"] {
        let said = Bench::new("").refused(&["--axes", axes]);
        assert!(said.contains("--axes") && said.contains("x=+y,y=-x,z=+z"), "{said}");
    }
}

#[test]
fn lost_frames_are_bridged_up_to_the_gap_asked_for() {
    let bench = Bench::new(&export(&PLAIN, &(80..90).collect::<Vec<_>>()));
    assert_eq!(bench.imported(&[]).0.valid.unwrap().iter().filter(|valid| !**valid).count(), 1);
    let (recording, said) = bench.imported(&["--max-gap-s", "0.1"]);
    assert!(
        recording.valid.unwrap().iter().all(|valid| *valid) && !said.contains("not tracked"),
        "{said}"
    );
    let bench = Bench::new(&export(&PLAIN, &(0..FRAMES).collect::<Vec<_>>()));
    assert!(bench.refused(&[]).contains("no command with both bodies tracked around it"));
    let bench = Bench::new(&export(&PLAIN, &[]));
    bench.put("log.csv", "trial,time_s,tendon_1_m,export_time_s\n0,0,0,0.4531\n0,0.2,0,0.6531\n");
    assert!(bench.refused(&["--max-gap-s", "1e-4"]).contains("up to 0.008334 s apart"));
    bench.refused(&["--max-gap-s", "-1"]);
    bench.refused(&["--max-gap-s", "nan"]);
}

#[test]
fn a_log_is_placed_by_its_times_by_one_clock_or_trial_by_trial() {
    let bench = Bench::new(&export(&PLAIN, &[]));
    let (known, _) = bench.imported(&[]);
    let wall = log().replace("export_time_s", "wall_time_s").lines().skip(1).fold(
        format!("{LENGTHS},wall_time_s\n"),
        |text, line| {
            let cells: Vec<&str> = line.split(',').collect();
            let at_s: f64 = cells[4].parse().unwrap();
            text + &format!("{},{}\n", cells[..4].join(","), 1_538_733_903.0 + at_s)
        },
    );
    bench.put("log.csv", &wall);
    assert!(
        difference(&bench.imported(&["--offset-s", "0.25"]).0, &known) < 1e-5,
        "digits of a clock since 1970"
    );
    bench.put("log.csv", &plain_log());
    assert!(difference(&bench.imported(&["--offset-s", "0.25,1"]).0, &known) < 1e-12);
    let (early, said) = bench.imported(&["--offset-s=-0.3,0.7"]);
    assert!(said.contains("2 of 6 rows") && early.valid.unwrap()[..2] == [false; 2], "{said}");
}

/// Spreadsheets drop empty cells at the ends of lines, and some versions write zeros for a body
/// that is not seen.
#[test]
fn short_lines_and_zeros_are_lost_frames() {
    let lost: Vec<usize> = (80..90).collect();
    let text = export(&PLAIN, &lost);
    let (known, _) = Bench::new(&text).imported(&[]);
    let short: String =
        text.lines().map(|line| line.trim_end_matches(',').to_owned() + "\r\n").collect();
    assert_ne!(short, text);
    assert_eq!(difference(&Bench::new(&short).imported(&[]).0, &known), 0.0);
    let zeros = text.replace(",,,,,,,,\r\n", ",0,0,0,0,0,0,0,0\r\n");
    assert_ne!(zeros, text);
    assert_eq!(difference(&Bench::new(&zeros).imported(&[]).0, &known), 0.0);
    let cut = text.lines().take(300).map(|line| line.to_owned() + "\r\n").collect::<String>();
    let (_, said) = Bench::new(&cut).imported(&[]);
    assert!(said.contains("293 of the 361 frames that its header states"), "{said}");
}

#[test]
fn help_tells_how_to_place_a_log() {
    let output = Bench::new("").run(&["motive", "--help"]);
    let text = String::from_utf8(output.stdout).unwrap();
    for words in ["export_time_s", "wall_time_s", "--offset-s", "--axes", "--max-gap-s", "--frame"]
    {
        assert!(text.contains(words), "{text}");
    }
}

proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = ExportFormat::Motive.parse(Path::new("x.csv"), &bytes, None);
    }

    /// Good exports with a few bytes changed, and cut off.
    #[test]
    fn no_change_makes_the_reader_panic(
        which in 0_usize..9,
        changes in proptest::collection::vec((0_usize..6000, prop::sample::select(b",\"\n\r;.-0eNXW\xff ".to_vec())), 0..12),
        end in 0_usize..6000,
    ) {
        let mut bytes = export(&dialects()[which], &[3]).into_bytes();
        bytes.truncate(6000);
        for (place, byte) in changes {
            if let Some(old) = bytes.get_mut(place) {
                *old = byte;
            }
        }
        bytes.truncate(end.max(200));
        if let Ok(export) = ExportFormat::Motive.parse(Path::new("x.csv"), &bytes, None) {
            prop_assert!(export.bodies.iter().all(|body| body.poses.len() == export.time_s.len()));
        }
    }
}

/// Single markers on base and tip and along the body: no orientations, and the tracking frame's
/// axes.
#[test]
fn single_markers_are_points_along_the_body() {
    let place_m = |share: f64, time_s: f64| {
        let (place_m, _) = tip(time_s);
        to_motive(Vector3::new(1.1, -0.4, -0.3) + share * place_m)
    };
    let marker = |name: &'static str, id: &'static str, share: f64| {
        ["X", "Y", "Z"].into_iter().enumerate().map(move |(axis, part)| {
            let cells = (0..FRAMES)
                .map(|frame| format!("{:.9}", place_m(share, frame as f64 / RATE_HZ)[axis]));
            column(["Marker", name, id, "", "Position", part], cells)
        })
    };
    let markers = [("base", "1", 0.0), ("tip", "2", 1.0), ("Marker 7", "3", 0.5)];
    let columns: Vec<Column> =
        markers.into_iter().flat_map(|(name, id, share)| marker(name, id, share)).collect();
    let bench = Bench::new(&written(&PLAIN, &columns));
    let (recording, said) = bench.imported(&["--points", "middle=Marker 7"]);
    assert!(said.contains("`base` is a single marker"), "{said}");
    assert!(recording.tip_quaternion.is_none() && recording.base.is_none());
    let [middle] = &recording.points[..] else { panic!("{:?}", recording.points) };
    assert_eq!((middle.name.as_str(), &middle.quaternion), ("middle", &None));
    for row in 0..6 {
        let (place_m, _) = tip(AT_S[row]);
        assert!(
            apart(&recording.tip_m.as_ref().unwrap()[row], place_m.as_slice()) < 1e-4,
            "row {row}"
        );
        assert!(apart(&middle.position_m[row], (0.5 * place_m).as_slice()) < 1e-4, "row {row}");
    }
    assert!(
        bench
            .refused(&["--points", "p1"])
            .contains("the markers `base`, `tip`, `Marker 7`, expected one called `p1`")
    );
    assert!(bench.refused(&["--points", "a b=tip"]).contains("a name of letters, digits and _"));
    assert!(bench.refused(&["--points", "p=tip,p=base"]).contains("found `p` twice"));
}
