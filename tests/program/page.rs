//! `spinebench page` through the binary.

use std::path::Path;
use std::process::Command;

fn page(file: &Path) -> (i32, String) {
    let run =
        Command::new(env!("CARGO_BIN_EXE_spinebench")).arg("page").arg(file).output().unwrap();
    (run.status.code().unwrap(), String::from_utf8_lossy(&run.stderr).into_owned())
}

#[test]
fn tables_are_copied_in_and_figures_shown() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("t.md"), "| a |\n| --- |\n").unwrap();
    std::fs::write(folder.path().join("f.png"), [0_u8]).unwrap();
    let file = folder.path().join("README.md");
    let text = "# X\n<!-- begin:t.md -->\nold\n<!-- end:t.md -->\n<!-- begin:f.png -->\n<!-- \
                end:f.png -->\n";
    std::fs::write(&file, text).unwrap();
    assert_eq!(page(&file).0, 0);
    let once = std::fs::read_to_string(&file).unwrap();
    assert!(
        once.contains("| --- |") && once.contains("![f](f.png)") && !once.contains("old"),
        "{once}"
    );
    assert_eq!(page(&file).0, 0);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), once);
}

#[test]
fn a_missing_file_is_named_and_nothing_changes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("README.md");
    let text = "<!-- begin:gone.png -->\n<!-- end:gone.png -->\n";
    std::fs::write(&file, text).unwrap();
    let (status, words) = page(&file);
    assert_eq!(status, 2);
    assert!(words.contains("gone.png"), "{words}");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
}
