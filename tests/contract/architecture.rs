//! The rooms of `docs/reference/architecture.md`: what each folder of `src/` may import, and the cuts that
//! carry the science.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// One row of the table.
struct Room {
    imports: BTreeSet<String>,
    /// Folders and files of the room; each imports only what stands left of it.
    order: Vec<String>,
    packages: BTreeSet<String>,
}

/// The names in a cell of the table.
fn words(cell: &str) -> impl Iterator<Item = String> {
    cell.split([' ', ',']).filter(|word| !word.is_empty() && *word != "–").map(str::to_owned)
}

/// The rows of the table by room.
fn rows() -> BTreeMap<String, Room> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("docs/reference/architecture.md")).unwrap();
    let mut rooms: BTreeMap<String, Room> = BTreeMap::new();
    for line in text.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let imports = match cells[3] {
            "all above" => rooms.keys().cloned().collect(),
            names => words(names).collect(),
        };
        let packages = words(cells[5]).map(|name| name.replace('-', "_")).collect();
        let room = Room { imports, order: words(cells[4]).collect(), packages };
        rooms.insert(cells[1].trim_matches('`').to_owned(), room);
    }
    assert!(rooms.len() >= 12, "the table was not read");
    rooms
}

/// Rooms and the rooms that they may import, from the table.
fn table() -> BTreeMap<String, BTreeSet<String>> {
    rows().into_iter().map(|(name, room)| (name, room.imports)).collect()
}

/// What each room imports, with the file that does: by the import graph, tests included only where
/// they are files of their own.
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
    let mut wrong = Vec::new();
    for (room, named, file) in imports() {
        // `cli` is the binary's: it reaches the library from outside.
        let Some(allowed) = table
            .get(&room)
            .or_else(|| (room != "cli").then(|| panic!("{room} is not in the table")))
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

/// A package is opened by the rooms alone whose rows name it.
#[test]
fn a_package_is_opened_by_its_room() {
    let rows = rows();
    let files = crate::store_keys::sources();
    let graph = crate::store_keys::graph(&files);
    let listed: BTreeSet<&String> = rows.values().flat_map(|room| &room.packages).collect();
    assert!(listed.len() > 10, "{listed:?}");
    let mut opened = BTreeSet::new();
    let mut wrong = Vec::new();
    for file in files.keys() {
        let Some(room) = file.split_once('/').and_then(|(room, _)| rows.get(room)) else {
            continue;
        };
        for package in graph.crates(file).iter().filter(|package| listed.contains(package)) {
            opened.insert(package.clone());
            if !room.packages.contains(package) {
                wrong.push(format!("{file} opens {package}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(
        listed.iter().all(|package| opened.contains(*package)),
        "nobody opens one of {listed:?}: {opened:?}"
    );
}

/// Inside a room whatever the table puts in order imports only what stands left of it, and every
/// folder has its place there.
#[test]
fn folders_of_a_room_import_one_way() {
    let files = crate::store_keys::sources();
    let graph = crate::store_keys::graph(&files);
    let unit = |file: &str| -> Option<(String, String)> {
        let (room, rest) = file.split_once('/')?;
        let first = rest.split('/').next()?;
        (first != "mod.rs").then(|| (room.to_owned(), first.trim_end_matches(".rs").to_owned()))
    };
    let mut wrong = Vec::new();
    for (name, room) in rows() {
        let place = |unit: &str| room.order.iter().position(|listed| listed == unit);
        for file in files.keys().filter(|file| file.starts_with(&format!("{name}/"))) {
            let Some((_, from)) = unit(file) else { continue };
            let is_folder = file.matches('/').count() > 1;
            if is_folder && place(&from).is_none() {
                wrong.push(format!("{name}/{from} has no place in the order"));
            }
            for (other, to) in graph.imports(file).iter().filter_map(|import| unit(import)) {
                if other == name
                    && let (Some(from), Some(to)) = (place(&from), place(&to))
                    && to > from
                {
                    wrong.push(format!("{file} imports {}", room.order[to]));
                }
            }
        }
        assert!(
            room.order.iter().all(|unit| {
                let below = format!("{name}/{unit}");
                files.keys().any(|file| {
                    *file == format!("{below}.rs") || file.starts_with(&format!("{below}/"))
                })
            }),
            "{name}: the order names what is not there"
        );
    }
    wrong.sort();
    wrong.dedup();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
