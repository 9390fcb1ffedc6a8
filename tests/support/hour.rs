//! A folder in which a user works, and the program run there.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder of its own.
pub(crate) struct Desk(tempfile::TempDir);

impl Desk {
    pub(crate) fn new() -> Desk {
        Desk(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn put(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// Runs the program with these arguments, between which there are single spaces.
    pub(crate) fn run(&self, arguments: &str) -> Output {
        let mut command = Command::new(Path::new(env!("CARGO_BIN_EXE_spinebench")));
        command
            .args(arguments.split(' '))
            .current_dir(self.0.path())
            .env("SPINEBENCH_CACHE", ".spinebench/cache")
            .output()
            .unwrap()
    }

    /// Runs what must succeed and returns what it says, errors and notes first.
    pub(crate) fn ok(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments}: {said}");
        said + &String::from_utf8(output.stdout).unwrap()
    }

    /// Runs what must be refused with exit status 2 and leave nothing called `out…`.
    pub(crate) fn refused(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
        for entry in std::fs::read_dir(self.0.path()).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            assert!(!name.starts_with("out") && !name.starts_with('.'), "{arguments} left {name}");
        }
        said
    }
}
