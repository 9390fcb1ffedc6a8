//! What the repository holds: nothing that a local interpreter or build left behind.

use std::path::Path;
use std::process::Command;

/// Parts of paths of a person's machine: home folders, mount points, installed packages, this
/// checkout.
const MACHINE_PATHS: [&str; 9] = [
    "/home/",
    "/Users/",
    "/root/",
    "/mnt/",
    "/media/",
    "/Volumes/",
    ":\\Users\\",
    "/site-packages/",
    env!("CARGO_MANIFEST_DIR"),
];

/// Bytes at the start of a file in which a binary one has a zero.
const HEAD_BYTES: usize = 8192;

/// The tracked files that `git ls-files` lists with these options; none outside a repository.
fn tracked(options: &[&str]) -> Vec<String> {
    let mut command = Command::new("git");
    command.args(["ls-files", "-z"]).args(options).current_dir(env!("CARGO_MANIFEST_DIR"));
    let listed = command.output().ok().filter(|output| output.status.success());
    let text = listed
        .map_or_else(String::new, |output| String::from_utf8_lossy(&output.stdout).into_owned());
    text.split('\0').filter(|name| !name.is_empty()).map(str::to_owned).collect()
}

/// The path of a machine that a binary file holds.
fn machine_path(bytes: &[u8]) -> Option<&'static str> {
    let is_binary = bytes.iter().take(HEAD_BYTES).any(|byte| *byte == 0);
    let holds = |path: &&str| bytes.windows(path.len()).any(|window| window == path.as_bytes());
    if is_binary { MACHINE_PATHS.iter().copied().find(|path| holds(&path)) } else { None }
}

#[test]
fn no_file_is_tracked_that_is_to_be_ignored() {
    let ignored = tracked(&["--cached", "--ignored", "--exclude-standard"]);
    assert!(ignored.is_empty(), "`.gitignore` matches tracked files: {ignored:?}");
}

#[test]
fn no_binary_file_tells_a_path_of_a_machine() {
    assert_eq!(machine_path(b"\0\x01/home/somebody/project/module.py\0"), Some("/home/"));
    assert_eq!(machine_path(b"\0C:\\Users\\somebody"), Some(":\\Users\\"));
    assert_eq!(machine_path(b"see /home/somebody"), None, "a text");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let telling: Vec<String> = tracked(&[])
        .into_iter()
        .filter_map(|name| {
            let path = machine_path(&std::fs::read(root.join(&name)).ok()?)?;
            Some(format!("{name}: {path}"))
        })
        .collect();
    assert!(telling.is_empty(), "{telling:?}");
}
