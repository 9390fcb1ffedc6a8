//! `import vicon`, `qualisys`, `ndi` and `c3d`: one motion in the layouts of four systems.

use spinebench::data::Recording;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

const FRAMES: usize = 50;

/// The tip from the base in a frame at 50 Hz, mm.
fn tip_mm(frame: usize) -> [f64; 3] {
    let x = (1e4 * (0.05 * frame as f64).sin()).round() / 1e3;
    [x, 0.0, 220.0 - x.abs() / 5.0]
}

fn recorded(folder: &Path, arguments: &str) -> (String, Option<Recording>) {
    let out = folder.join("out.csv");
    let _ = std::fs::remove_file(&out);
    let output = Command::new(env!("CARGO_BIN_EXE_spinebench"))
        .args(arguments.split(' ').map(|word| word.replace('_', " ")))
        .args(["--commands", "log.csv", "--offset-s", "0", "--out", "out.csv"])
        .current_dir(folder)
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    let expected = if out.exists() { 0 } else { 2 };
    assert_eq!(output.status.code(), Some(expected), "{arguments}: {said}");
    (said, out.exists().then(|| Recording::read(&out).unwrap()))
}

fn vicon() -> String {
    let mut text = "Objects\n50\n,,base:base,,,,,,,tip:tip,,,,,,\n\
                    Frame,Sub Frame,RX,RY,RZ,RW,TX,TY,TZ,RX,RY,RZ,RW,TX,TY,TZ\n\
                    ,,,,,,mm,mm,mm,,,,,mm,mm,mm\n"
        .to_owned();
    for frame in 0..FRAMES {
        let [x, y, z] = tip_mm(frame);
        let tip = format!("0,0,0,1,{},{},{}", x + 10.0, y + 20.0, z + 5.0);
        writeln!(text, "{},0,0,0,0,1,10,20,5,{tip}", frame + 1).unwrap();
    }
    text + "\n"
}

fn qualisys() -> String {
    let mut text = format!(
        "NO_OF_FRAMES\t{FRAMES}\nNO_OF_BODIES\t2\nFREQUENCY\t50\nDATA_INCLUDED\t6D\n\
         BODY_NAMES\tbase\ttip\nFrame\tTime\tbase X\tY\tZ\n"
    );
    for frame in 0..FRAMES {
        let [x, y, z] = tip_mm(frame);
        let turn = "0\t0\t0\t0.3\t1\t0\t0\t0\t1\t0\t0\t0\t1";
        let tip = format!("{}\t{}\t{}", x + 10.0, y + 20.0, z + 5.0);
        writeln!(
            text,
            "{}\t{:.5}\t10\t20\t5\t{turn}\t{tip}\t{turn}",
            frame + 1,
            0.02 * frame as f64
        )
        .unwrap();
    }
    text
}

fn ndi() -> String {
    let tool =
        "ToolInfo,Frame#,PortHandle,Face#,TransformStatus,Q0,Qx,Qy,Qz,Tx,Ty,Tz,Error,#Markers";
    let mut text = format!("#Tools,{tool},{tool}\n");
    for frame in 0..FRAMES {
        let [x, y, z] = tip_mm(frame);
        let row = |name: &str, place: String| {
            format!("{name} s/n:1,{},Port:{name},0,OK,1,0,0,0,{place},0.1,0", 700 + frame)
        };
        let tip = format!("{},{},{}", x + 10.0, y + 20.0, z + 5.0);
        writeln!(text, "2,{},{}", row("0A", "10,20,5".into()), row("0B", tip)).unwrap();
    }
    text
}

/// A C3D file with floating-point numbers (c3d.org): header, parameters and frames in blocks of 512
/// bytes.
fn c3d(unit: &str, lost: usize) -> Vec<u8> {
    let mut header = vec![0_u8; 512];
    header[..2].copy_from_slice(&[2, 0x50]);
    for (byte, word) in [(2, 2_u16), (6, 1), (8, FRAMES as u16), (16, 3)] {
        header[byte..byte + 2].copy_from_slice(&word.to_le_bytes());
    }
    header[12..16].copy_from_slice(&(-1.0_f32).to_le_bytes());
    header[20..24].copy_from_slice(&50.0_f32.to_le_bytes());
    // 84 is the code of little-endian processors.
    let mut parameters = vec![1, 0x50, 1, 84];
    let mut put = |name: &str, id: i8, content: &[u8], is_last: bool| {
        parameters.extend([name.len() as u8, id as u8]);
        parameters.extend(name.bytes());
        let next = if is_last { 0 } else { content.len() as u16 + 3 };
        parameters.extend(next.to_le_bytes());
        parameters.extend(content);
        parameters.push(0);
    };
    put("POINT", -1, &[], false);
    put("USED", 1, &[2, 0, 2, 0], false);
    put("FRAMES", 1, &[2, 0, FRAMES as u8, 0], false);
    let float = |number: f32| [&[4, 0][..], &number.to_le_bytes()].concat();
    put("RATE", 1, &float(50.0), false);
    put("SCALE", 1, &float(-1.0), false);
    let text = |dimensions: &[u8], text: &str| [&[255][..], dimensions, text.as_bytes()].concat();
    put("UNITS", 1, &text(&[1, 4], &format!("{unit:4}")), false);
    put("LABELS", 1, &text(&[2, 4, 2], "basetip "), false);
    put("ANALOG", -2, &[], false);
    put("USED", 2, &[2, 0, 0, 0], true);
    parameters.resize(512, 0);
    let mut frames = Vec::new();
    for frame in 0..FRAMES {
        let [x, y, z] = tip_mm(frame);
        let residual = if frame == lost { -1.0 } else { 3.0 };
        for number in [10.0, 20.0, 5.0, 3.0, x + 10.0, y + 20.0, z + 5.0, residual] {
            frames.extend((number as f32).to_le_bytes());
        }
    }
    [header, parameters, frames].concat()
}

#[test]
fn every_system_gives_the_same_rows() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let put = |name: &str, text: String| std::fs::write(folder.join(name), text).unwrap();
    let rows = (0..4).map(|row| format!("0,{:.1},0.00{row},0\n", 0.2 * f64::from(row)));
    put("log.csv", format!("trial,time_s,tendon_1_m,tendon_2_m\n{}", rows.collect::<String>()));
    put("v.csv", vicon());
    put("q.tsv", qualisys());
    put("n.csv", ndi());
    let bytes = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
    bytes("a.c3d", &c3d("mm", FRAMES));
    for arguments in [
        "import vicon v.csv",
        "import qualisys q.tsv",
        "import ndi n.csv --rate-hz 50 --base Port:0A --tip Port:0B",
        "import c3d a.c3d",
    ] {
        let (said, found) = recorded(folder, arguments);
        let found = found.unwrap_or_else(|| panic!("{arguments}: {said}"));
        for (row, tip) in found.tip_m.unwrap().into_iter().enumerate() {
            let expected = tip_mm(10 * row).map(|x| 1e-3 * x);
            let apart = tip.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // C3D has single precision.
            assert!(apart < 1e-7, "{arguments}, row {row}: {tip:?} for {expected:?}");
        }
        assert_eq!(found.tip_quaternion.is_some(), !arguments.contains("c3d"));
    }
    let refused = |arguments: &str| recorded(folder, arguments).0;
    assert!(refused("import vicon q.tsv").contains("expected a block `Objects`"));
    assert!(refused("import qualisys v.csv").contains("expected `MARKER_NAMES` or `BODY_NAMES`"));
    let said = refused("import ndi n.csv --base Port:0A --tip Port:0B");
    assert!(said.contains("found frames without a rate, expected --rate-hz"), "{said}");
    assert!(refused("import vicon v.csv --rate-hz 50").contains("the file contains it"));
    assert!(refused("import c3d v.csv").contains("another kind of file, expected a C3D file"));
    bytes("a.c3d", &c3d("ft", FRAMES));
    assert!(refused("import c3d a.c3d").contains("POINT:UNITS: found `ft`"));
    // A lost marker, and files that were cut off or lie about their sizes.
    bytes("a.c3d", &c3d("mm", 20));
    let said = refused("import c3d a.c3d --max-gap-s 0.02");
    assert!(said.contains("1 of 4 rows were not tracked"), "{said}");
    let whole = c3d("mm", FRAMES);
    bytes("a.c3d", &whole[..1024 + 32 * 35]);
    assert!(refused("import c3d a.c3d").contains("a.c3d has 35 of the 50 frames"));
    for damage in [vec![(2, 0xff), (3, 0xff)], vec![(2, 5)], vec![(516, 0xff)]] {
        let mut damaged = whole.clone();
        damage.into_iter().for_each(|(byte, value)| damaged[byte] = value);
        bytes("a.c3d", &damaged);
        let said = refused("import c3d a.c3d");
        assert!(said.starts_with("error: a.c3d") && said.trim_end().lines().count() == 1, "{said}");
    }
}
