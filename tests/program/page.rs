//! `spinebench page` through the binary.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

fn page(file: &Path) -> (i32, String) {
    pages(&[file.as_os_str()])
}

fn pages(arguments: &[&OsStr]) -> (i32, String) {
    let run = Command::new(env!("CARGO_BIN_EXE_spinebench"))
        .arg("page")
        .args(arguments)
        .output()
        .unwrap();
    (run.status.code().unwrap(), String::from_utf8_lossy(&run.stderr).into_owned())
}

#[test]
fn tables_are_copied_in_and_figures_shown() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("t.md"), "| a |\n| --- |\n").unwrap();
    std::fs::write(folder.path().join("f.png"), [0_u8]).unwrap();
    std::fs::write(folder.path().join("f.md"), "One thing. And another.\n").unwrap();
    let file = folder.path().join("README.md");
    let text = "# X\n<!-- begin:t.md -->\nold\n<!-- end:t.md -->\n<!-- begin:f.png -->\n<!-- \
                end:f.png -->\n";
    std::fs::write(&file, text).unwrap();
    assert_eq!(page(&file).0, 0);
    let once = std::fs::read_to_string(&file).unwrap();
    assert!(
        once.contains("| --- |")
            && once.contains("![One thing](f.png)\n\n*One thing. And another.*")
            && !once.contains("old"),
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

/// The pages below a folder that have generated parts.
fn generated(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            generated(&path, found);
        } else if path.extension().is_some_and(|end| end == "md")
            && std::fs::read_to_string(&path).unwrap().contains("<!-- begin:")
        {
            found.push(path);
        }
    }
}

#[test]
fn generated_parts_of_the_manual_are_current() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = vec![root.join("README.md")];
    generated(&root.join("docs"), &mut found);
    assert!(found.len() > 5, "{found:?}");
    let mut arguments = vec![OsStr::new("--check")];
    arguments.extend(found.iter().map(|path| path.as_os_str()));
    assert_eq!(pages(&arguments), (0, String::new()), "`make pages` updates them");
}

#[test]
fn a_page_that_is_not_current_is_named_and_stays() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("page.md");
    let text = "<!-- begin:keys:model -->\nold\n<!-- end:keys:model -->\n";
    std::fs::write(&file, text).unwrap();
    let (status, words) = pages(&[OsStr::new("--check"), file.as_os_str()]);
    assert_eq!(status, 1);
    assert!(words.contains("page.md"), "{words}");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
    assert_eq!(page(&file).0, 0);
    let once = std::fs::read_to_string(&file).unwrap();
    assert!(once.contains("| `robot` | object |"), "{once}");
}
