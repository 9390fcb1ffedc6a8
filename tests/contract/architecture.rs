//! The rooms of `docs/architecture.md`: what each folder of `src/` may import, and the cuts that carry the science.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Rooms and the rooms that they may import, from the table.
fn table() -> BTreeMap<String, BTreeSet<String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("docs/architecture.md")).unwrap();
    let mut rooms: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for line in text.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let above: BTreeSet<String> = match cells[3] {
            "–" => BTreeSet::new(),
            "all above" => rooms.keys().cloned().collect(),
            names => names.split(' ').map(str::to_owned).collect(),
        };
        rooms.insert(cells[1].trim_matches('`').to_owned(), above);
    }
    rooms
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        if entry.path().is_dir() {
            sources(&entry.path(), found);
        } else if entry.path().extension().is_some_and(|end| end == "rs") {
            found.push(entry.path());
        }
    }
}

/// What each room imports, with the file that does: by the import graph, tests included only where they are files of their own.
fn imports() -> Vec<(String, String, PathBuf)> {
    let files = crate::store_keys::sources();
    let graph = crate::store_keys::graph(&files);
    let room = |file: &str| file.split_once('/').map(|(room, _)| room.to_owned());
    let mut imports = Vec::new();
    for file in files.keys() {
        for import in graph.imports(file) {
            if let (Some(from), Some(to)) = (room(file), room(import)) {
                imports.push((from, to, PathBuf::from(file)));
            }
        }
    }
    imports
}

#[test]
fn every_room_imports_only_rooms_above_it() {
    let table = table();
    assert!(table.len() >= 12, "the table was not read: {table:?}");
    let mut wrong = Vec::new();
    for (room, named, file) in imports() {
        // `cli` is the binary's: it reaches the library from outside.
        let Some(allowed) = table.get(&room).or_else(|| (room != "cli").then(|| panic!("{room} is not in the table")))
        else {
            continue;
        };
        if table.contains_key(&named) && named != room && !allowed.contains(&named) {
            wrong.push(format!("{}: {room} imports {named}", file.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The table itself must keep the cuts, through any number of rooms between.
#[test]
fn the_cuts_hold() {
    let table = table();
    let reach = |from: &str| {
        let mut reached = BTreeSet::new();
        let mut next: Vec<String> = table.get(from).into_iter().flatten().cloned().collect();
        while let Some(room) = next.pop() {
            if reached.insert(room.clone()) {
                next.extend(table.get(&room).into_iter().flatten().cloned());
            }
        }
        reached
    };
    let cuts = [
        ("policies", &["plants", "effects", "tasks"] as &[&str]),
        ("discovery", &["specs", "plants"]),
        ("report", &["runner", "specs", "plants"]),
    ];
    for (from, barred) in cuts {
        let reached = reach(from);
        for room in barred {
            assert!(!reached.contains(*room), "{from} reaches {room}");
        }
    }
}

/// Packages that one room alone opens, from the table's last column; rayon has two.
#[test]
fn a_package_is_opened_by_one_room() {
    let packages = [
        ("rand_chacha", "base"),
        ("statrs", "math"),
        ("pulp", "math"),
        ("polars", "data"),
        ("faer", "learn"),
        ("serde_yaml", "specs"),
        ("plotters", "report"),
        ("serialport", "hardware"),
        ("natnet", "hardware"),
        ("socket2", "hardware"),
        ("signal_hook", "hardware"),
        ("rayon", "runner"),
        ("indicatif", "runner"),
        ("blake3", "runner"),
    ];
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        let path = file.strip_prefix(&src).unwrap();
        for line in text.lines().filter(|line| !line.trim_start().starts_with("//")) {
            for (package, room) in packages {
                let opened = line.contains(&format!("{package}::"));
                let second = package == "rayon" && path.starts_with("discovery");
                assert!(
                    !opened || second || path.starts_with(room),
                    "{}: {line}\n  {package} belongs to {room}",
                    path.display()
                );
            }
        }
    }
}
