//! The examples in README and docs run as printed: blocks that are marked run and print what the
//! page says, and every command that any page shows names options that exist and files that are
//! shipped.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A fenced block of a page, with the mark in the line before it.
struct Block {
    mark: Option<String>,
    text: String,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut found = Vec::new();
    let mut lines = page.lines().peekable();
    let mut mark = None;
    while let Some(line) = lines.next() {
        if let Some(named) =
            line.trim().strip_prefix("<!-- ").and_then(|rest| rest.strip_suffix(" -->"))
        {
            mark = Some(named.to_owned());
        } else if line.trim_start().starts_with("```") {
            let inside: Vec<&str> =
                lines.by_ref().take_while(|line| !line.trim_start().starts_with("```")).collect();
            found.push(Block { mark: mark.take(), text: inside.join("\n") + "\n" });
        } else if !line.trim().is_empty() {
            mark = None;
        }
    }
    found
}

/// README and every page of the manual.
fn pages() -> Vec<PathBuf> {
    std::iter::once(Path::new(ROOT).join("README.md")).chain(manual()).collect()
}

/// Every page of the manual.
fn manual() -> Vec<PathBuf> {
    let entries = |folder: PathBuf| {
        std::fs::read_dir(folder).unwrap().flatten().map(|entry| entry.path()).collect::<Vec<_>>()
    };
    let (shelves, pages): (Vec<_>, Vec<_>) =
        entries(Path::new(ROOT).join("docs")).into_iter().partition(|path| path.is_dir());
    let pages = pages.into_iter().chain(shelves.into_iter().flat_map(entries));
    pages.filter(|path| path.extension().is_some_and(|end| end == "md")).collect()
}

/// A folder that looks like a checkout and takes what examples write.
fn checkout() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for shared in ["models", "experiments", "tests"] {
        std::os::unix::fs::symlink(Path::new(ROOT).join(shared), folder.path().join(shared))
            .unwrap();
    }
    std::fs::create_dir_all(folder.path().join("results")).unwrap();
    std::fs::copy(
        Path::new(ROOT).join("results/PUBLISHED"),
        folder.path().join("results/PUBLISHED"),
    )
    .unwrap();
    // Files of an example that name ../experiments stand in out/.
    std::fs::create_dir_all(folder.path().join("out")).unwrap();
    folder
}

fn run(folder: &Path, line: &str) -> Output {
    let words: Vec<&str> = line.split('#').next().unwrap().split_whitespace().skip(1).collect();
    let mut command = Command::new(env!("CARGO_BIN_EXE_spinebench"));
    command
        .args(words)
        .current_dir(folder)
        .env("SPINEBENCH_CACHE", ".spinebench/cache")
        .output()
        .unwrap()
}

/// The commands of a block with what they print: lines after a prompt `$ `, or all lines where
/// there is no prompt.
fn typed(block: &str) -> Vec<(String, String)> {
    if !block.starts_with("$ ") {
        return block.lines().map(|line| (line.to_owned(), String::new())).collect();
    }
    let mut all: Vec<(String, String)> = Vec::new();
    for line in block.lines() {
        match (line.strip_prefix("$ "), all.last_mut()) {
            (Some(command), _) => all.push((command.to_owned(), String::new())),
            (None, Some((_, expected))) => expected.push_str(&format!("{line}\n")),
            (None, None) => {}
        }
    }
    all
}

/// Runs a line as a shell would, with the program in its path.
fn shell(folder: &Path, line: &str) -> Output {
    let program = Path::new(env!("CARGO_BIN_EXE_spinebench"));
    let path =
        format!("{}:{}", program.parent().unwrap().display(), std::env::var("PATH").unwrap());
    let mut command = Command::new("bash");
    command
        .args(["-c", line])
        .env("PATH", path)
        .current_dir(folder)
        .env("SPINEBENCH_CACHE", ".spinebench/cache")
        .output()
        .unwrap()
}

/// Whether `said` is `expected`, in which `…` stands for any text.
fn prints(said: &str, expected: &str) -> bool {
    let mut pieces = expected.split('…');
    let Some(mut rest) = said.strip_prefix(pieces.next().unwrap_or_default()) else { return false };
    let mut last = None;
    for piece in pieces {
        let Some(at) = rest.find(piece) else { return false };
        rest = &rest[at + piece.len()..];
        last = Some(piece);
    }
    rest.is_empty() || last == Some("")
}

#[test]
fn marked_examples_run_as_printed() {
    let mut ran = 0;
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        let folder = checkout();
        let mut said = String::new();
        for block in blocks(&text) {
            let mark = block.mark.unwrap_or_default();
            if let Some(file) = mark.strip_prefix("file:") {
                let file = folder.path().join(file);
                std::fs::create_dir_all(file.parent().unwrap()).unwrap();
                std::fs::write(file, block.text).unwrap();
            } else if mark == "runs" {
                for (line, expected) in typed(&block.text) {
                    let output = shell(folder.path(), &line);
                    said = String::from_utf8_lossy(&output.stdout).into_owned()
                        + &String::from_utf8_lossy(&output.stderr);
                    assert!(output.status.success(), "{}: {line}\n{said}", page.display());
                    assert!(
                        expected.is_empty() || prints(&said, &expected),
                        "{}: {line}\n{said}",
                        page.display()
                    );
                    ran += 1;
                }
            } else if mark == "prints" {
                assert!(prints(&said, &block.text), "{}: it prints\n{said}", page.display());
            }
        }
        let claims = std::fs::read_to_string(folder.path().join("out/results/claims.csv"));
        assert!(
            !claims.unwrap_or_default().contains("arm,"),
            "{}: the paper's claims are judged on another robot",
            page.display()
        );
        assert!(
            !folder.path().join("plots").exists(),
            "{}: an example replaced published results",
            page.display()
        );
    }
    assert!(ran >= 4, "{ran} examples");
}

/// The lines of a page that show a command, with continued lines joined.
fn commands(page: &str) -> Vec<String> {
    let whole = |block: Block| block.text.replace("\\\n", " ");
    let lines = blocks(page).into_iter().map(whole).collect::<String>();
    let shown = |line: &str| line.trim().trim_start_matches("$ ").to_owned();
    lines.lines().map(shown).filter(|line| line.starts_with("spinebench ")).collect()
}

/// What a command of the manual may need that a test has not got.
const NEEDS: [&str; 5] = ["a robot", "a cluster", "a checkout", "a browser", "hours"];

/// A page shows no command that was never run: a block with one is marked `<!-- runs -->`, or says
/// what it needs, as `<!-- needs: a robot -->`. A usage line, which names its arguments in capitals,
/// is none.
#[test]
fn every_command_of_the_manual_runs_or_says_what_it_needs() {
    let mut wrong = Vec::new();
    for page in pages() {
        for block in blocks(&std::fs::read_to_string(&page).unwrap()) {
            let mark = block.mark.unwrap_or_default();
            let excused = mark.strip_prefix("needs: ").is_some_and(|need| NEEDS.contains(&need));
            if mark != "runs" && !excused {
                let shown = commands(&format!("```\n{}```", block.text));
                let is_usage = |line: &String| {
                    line.split(|letter: char| !(letter.is_ascii_uppercase() || letter == '_'))
                        .any(|word| word.len() > 2)
                };
                let shown = shown.into_iter().filter(|line| !is_usage(line));
                wrong.extend(shown.map(|line| format!("{}: `{line}`", page.display())));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_shown_command_has_the_options_and_files_that_it_names() {
    let mut wrong = Vec::new();
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        for line in commands(&text) {
            let shown = line.split(" #").next().unwrap().to_owned();
            let words: Vec<&str> = shown.split_whitespace().skip(1).collect();
            let Some(name) = words.iter().find(|word| !word.starts_with('-')) else { continue };
            let mut command = vec![*name];
            if ["cache", "import", "league", "schema"].contains(name) {
                let is_word = |letter: char| letter.is_lowercase() || letter == '-';
                command.extend(words.get(1).filter(|word| word.chars().all(is_word)));
            }
            let help = run(Path::new(ROOT), &format!("spinebench {} --help", command.join(" ")));
            let help = String::from_utf8_lossy(&help.stdout).into_owned();
            let told = |what: String| format!("{}: `{line}`: {what}", page.display());
            if help.is_empty() {
                wrong.push(told(format!("no command `{}`", command.join(" "))));
            }
            for word in &words {
                let option = word
                    .trim_matches(|letter| "[]".contains(letter))
                    .split(['=', ' '])
                    .next()
                    .unwrap();
                if option.starts_with("--") && !help.contains(option) {
                    wrong.push(told(format!("no option `{option}`")));
                }
                let shipped = ["models/", "experiments/", "tests/data/"]
                    .iter()
                    .any(|start| word.starts_with(start));
                if shipped && !word.contains(['*', '…']) && !Path::new(ROOT).join(word).exists() {
                    wrong.push(told(format!("no file `{word}`")));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_readme_is_short_and_its_links_lead_somewhere() {
    let readme = std::fs::read_to_string(Path::new(ROOT).join("README.md")).unwrap();
    let words = without_comments(&readme).split_whitespace().count();
    assert!(words <= 900, "{words} words");
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = link.split('#').next().unwrap();
            if file.is_empty() || file.contains("://") || file.contains(' ') {
                continue;
            }
            assert!(page.parent().unwrap().join(file).exists(), "{}: {link}", page.display());
        }
    }
}

#[test]
fn numbers_in_prose_are_those_of_the_tables() {
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        let again = spinebench::report::page::recounted(&text, page.parent().unwrap()).unwrap();
        assert!(again == text, "{}: run `spinebench page` on it", page.display());
    }
    let readme = std::fs::read_to_string(Path::new(ROOT).join("README.md")).unwrap();
    assert!(readme.matches("<!-- cell:").count() > 8);
}

#[test]
fn every_document_is_in_the_index() {
    let docs = Path::new(ROOT).join("docs");
    let index = std::fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    for page in manual() {
        let name = page.strip_prefix(&docs).unwrap().to_string_lossy().into_owned();
        let is_listed = name == "SUMMARY.md" || index.contains(&format!("({name})"));
        assert!(is_listed, "{name} is not in docs/SUMMARY.md");
    }
}

/// `text` without its HTML comments.
fn without_comments(text: &str) -> String {
    let mut pieces = text.split("<!--");
    let first = pieces.next().unwrap().to_owned();
    first
        + &pieces
            .filter_map(|piece| piece.split_once("-->"))
            .map(|(_, rest)| rest)
            .collect::<String>()
}

/// `text` without what `spinebench page` inserts.
fn by_hand(text: &str) -> String {
    let mut pieces = text.split("<!-- begin:");
    let mut kept = pieces.next().unwrap().to_owned();
    for piece in pieces {
        let name = piece.split(" -->").next().unwrap();
        let (_, after) = piece.split_once(&format!("<!-- end:{name} -->")).unwrap();
        kept.push_str(after);
    }
    kept
}

#[test]
fn the_manual_is_short() {
    let words = |page: PathBuf| {
        let words = by_hand(&std::fs::read_to_string(&page).unwrap()).split_whitespace().count();
        (words, page)
    };
    let mut pages: Vec<_> = manual().into_iter().map(words).collect();
    pages.sort();
    let total: usize = pages.iter().map(|(words, _)| words).sum();
    assert!(total <= 28_000, "{total} words by hand: {pages:?}");
}
