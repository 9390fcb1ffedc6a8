//! `export mcap` and `import mcap` through the program. Bags that other programs write and read are
//! tested in Python (`python/tests/test_bags.py`).

use std::path::Path;
use std::process::{Command, Output};

const NOMINAL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/models/nominal.yaml");

fn run(folder: &Path, arguments: &str) -> Output {
    let words = arguments.split(' ').map(|word| if word == "NOMINAL" { NOMINAL } else { word });
    Command::new(env!("CARGO_BIN_EXE_spinebench")).args(words).current_dir(folder).output().unwrap()
}

fn refused(folder: &Path, arguments: &str) -> String {
    let output = run(folder, arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
    assert!(said.starts_with("error: ") && said.trim_end().lines().count() == 1, "{said}");
    assert!(!folder.join("out.mcap").exists() && !folder.join("out.csv").exists(), "{arguments}");
    said
}

#[test]
fn a_recording_is_exported_with_the_robot() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let commands = "trial,time_s,tendon_1_m,tendon_2_m,tendon_3_m,tendon_4_m\n0,0,0,0,0,0\n0,0.2,0.01,0,-0.01,0\n1,0,0,0,0,0\n";
    std::fs::write(folder.join("in.csv"), commands).unwrap();
    let ok = |arguments: &str| {
        let output = run(folder, arguments);
        assert_eq!(
            output.status.code(),
            Some(0),
            "{arguments}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    };
    ok("simulate --model NOMINAL --commands in.csv --out rec.csv");
    ok("export mcap rec.csv --model NOMINAL --out rec.mcap");
    let bytes = std::fs::read(folder.join("rec.mcap")).unwrap();
    let has = |text: &str| bytes.windows(text.len()).any(|part| part == text.as_bytes());
    for text in [
        "foxglove.PoseInFrame",
        "foxglove.SceneUpdate",
        "/tip",
        "/robot",
        "/tf",
        "foxglove.FrameTransforms",
        "\"child_frame_id\":\"station_0\"",
        "\"cylinders\":[{",
        "\"tendon_1_m\":0.01",
        "\"sec\":1",
    ] {
        assert!(has(text), "{text}");
    }
    assert!(bytes.ends_with(b"\x89MCAP0\r\n"));
    assert!(refused(folder, "export mcap rec.csv --out out.bag").contains("expected `.mcap`"));
    assert!(refused(folder, "export mcap none.csv --out out.mcap").contains("none.csv"));
    assert!(
        refused(folder, "export mcap rec.csv --residuals rec.csv --out out.mcap")
            .contains("rec.csv")
    );
    // What is exported holds no messages of ROS.
    let map = "{commands: {topic: /commands, tendons: {columns: [a]}}}";
    std::fs::write(folder.join("map.yaml"), map).unwrap();
    let said = refused(folder, "import mcap rec.mcap --map map.yaml --out out.csv");
    assert!(
        said.contains("topic `/commands`: found messages of type `spinebench.Commands` in `json`"),
        "{said}"
    );
    let said = refused(folder, "import mcap rec.csv --map map.yaml --out out.csv");
    assert!(
        said.contains("rec.csv, byte 0: found another kind of file, expected an MCAP file"),
        "{said}"
    );
    std::fs::write(folder.join("map.yaml"), "{commands: {tendons: {columns: [a]}}}").unwrap();
    assert!(
        refused(folder, "import mcap rec.mcap --map map.yaml --out out.csv")
            .contains("commands.topic")
    );
}
