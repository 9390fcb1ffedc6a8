//! One source of a spec: a file, or an option of the command line.

use super::alias::{RenamedKey, canonical as unaliased, rename_keys, resolve_outside};
use super::error::{SourceLocation, SpecError};
use super::invisible;
use super::locate::{PathEnd, locate};
use super::merge_keys::{self, MergedKey};
use super::mismatch::describe;
use super::path::{KeyPath, Step};
use super::suggest::nearest;
use super::sweep_option;
use super::tree::{get, invisible_key, merge, not_plain, put, remove};
use crate::data::read_text;
use serde_yaml::{Mapping, Value};
use std::path::{Path, PathBuf};

/// One source of values.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    /// The file, or the option, as the user wrote it.
    pub(super) name: String,
    pub(super) text: String,
    pub(super) value: Value,
    /// Folder that file names in it are relative to.
    pub(super) folder: PathBuf,
    /// The path whose value is the text: the root, or the key of an option or an included file.
    pub(super) root: KeyPath,
    /// Whether this layer replaces the value at `root` instead of merging with it.
    pub(super) replaces: bool,
    /// Keys that merge keys brought.
    pub(super) merged: Vec<MergedKey>,
    /// Keys that stand in its text under former names.
    pub(super) renamed: Vec<RenamedKey>,
}

/// Prefixes of the names of command-line sources.
pub(super) const SET: &str = "--set ";
const SWEEP: &str = "--sweep ";

impl Layer {
    /// A file, as the layer below `include` (a path, and the location of the file's name), or as
    /// the root.
    pub(super) fn file(
        path: &Path,
        include: Option<(&KeyPath, SourceLocation)>,
    ) -> Result<Layer, SpecError> {
        let name = path.display().to_string();
        let text = read_text(path).map_err(|error| {
            let missing = error.kind() == std::io::ErrorKind::NotFound;
            let found = if missing {
                format!("no file `{name}`{}", searched(path))
            } else {
                format!("`{name}`: {error}")
            };
            let expected = "the name of a YAML file";
            match &include {
                Some((key, place)) => {
                    let (place, key) = (place.clone(), (*key).clone());
                    SpecError::Key { place, key, found, expected: expected.into() }
                }
                None => SpecError::File { file: name.clone(), found, expected },
            }
        })?;
        let value = yaml(&text, &name)?;
        let value = if value.is_null() { Value::Mapping(Mapping::new()) } else { value };
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let root = include.as_ref().map_or_else(KeyPath::default, |(key, _)| (*key).clone());
        let layer = Layer {
            name,
            text,
            value,
            folder,
            root,
            replaces: include.is_some(),
            merged: Vec::new(),
            renamed: Vec::new(),
        };
        if !layer.value.is_mapping() {
            let table = layer.text.lines().next().is_some_and(|line| line.starts_with("trial,"));
            let found = if table { "a recording (CSV)".to_owned() } else { describe(&layer.value) };
            return Err(layer.refuse(&layer.root, found, "a mapping of keys to values"));
        }
        let mut layer = layer.plain()?.with_present_names()?;
        resolve_outside(&mut layer.value, &layer.folder);
        Ok(layer)
    }

    pub(super) fn option(set: &str) -> Result<Layer, SpecError> {
        let name = format!("{SET}{set}");
        let refuse = |found: String| malformed(&name, found, "path.to.key=value".to_owned());
        let (path, text) = set.split_once('=').ok_or_else(|| refuse(format!("`{set}`")))?;
        let (root, renamed) = unaliased(KeyPath::parse(path.trim()).map_err(refuse)?);
        let value = yaml(text, &name)?;
        let (text, folder, renamed) =
            (text.to_owned(), PathBuf::new(), renamed.into_iter().collect());
        let merged = Vec::new();
        Layer { name, text, value, folder, root, replaces: false, merged, renamed }
            .plain()?
            .with_present_names()
    }

    /// Gives keys that were written under former names their present names.
    fn with_present_names(mut self) -> Result<Layer, SpecError> {
        match rename_keys(&mut self.value, &self.root) {
            Ok(renamed) => self.renamed.extend(renamed),
            Err(former) => {
                return Err(self.refuse(
                    &former,
                    "the former and the current name of a key".to_owned(),
                    "one of the two",
                ));
            }
        }
        Ok(self)
    }

    /// For each key under a former name a note that tells the present one.
    pub(super) fn notes(&self) -> impl Iterator<Item = String> {
        self.renamed.iter().filter(|renamed| renamed.is_former()).map(|renamed| {
            let place = self.place(&renamed.present, PathEnd::Key);
            format!("{place}: `{}` is now called `{}`", renamed.former, renamed.present)
        })
    }

    /// Replaces merge keys by the keys that they stand for; refuses keys that are not text or hold
    /// invisible characters, and tags.
    pub(super) fn plain(mut self) -> Result<Layer, SpecError> {
        self.merged = merge_keys::apply(&mut self.value, &self.root)
            .map_err(|(path, found)| self.refuse(&path, found, merge_keys::EXPECTED))?;
        if let Some(path) = invisible_key(&self.value, &self.root)
            && let Some(Step::Key(key)) = path.0.last()
        {
            return Err(SpecError::Key {
                place: self.place(&path, PathEnd::Key),
                found: invisible::describe(key).unwrap_or_default(),
                key: path.parent(),
                expected: "keys and values of visible characters and plain spaces".to_owned(),
            });
        }
        match not_plain(&self.value, &self.root) {
            Some((path, found)) => Err(self.refuse(&path, found, "plain keys and values")),
            None => Ok(self),
        }
    }

    /// A `--sweep` option, as the equivalent entry of `sweep:`.
    pub(super) fn sweep(option: &str) -> Result<Layer, SpecError> {
        let name = format!("{SWEEP}{option}");
        let (path, values) = sweep_option::parse(option).map_err(|found| {
            malformed(&name, found, format!("path.to.key= and {}", sweep_option::EXPECTED))
        })?;
        let value = Value::Mapping(Mapping::from_iter([(Value::from(path.to_string()), values)]));
        let (root, text) = (KeyPath::default().key("sweep"), option.to_owned());
        Ok(Layer {
            name,
            text,
            value,
            folder: PathBuf::new(),
            root,
            replaces: false,
            merged: Vec::new(),
            renamed: Vec::new(),
        })
    }

    pub(super) fn is_option(&self) -> bool {
        self.name.starts_with(SET) || self.name.starts_with(SWEEP)
    }

    /// Appends this layer and, below it, the files that it names at the paths `includes`.
    pub(super) fn push_with_included(
        mut self,
        includes: &[KeyPath],
        layers: &mut Vec<Layer>,
    ) -> Result<(), SpecError> {
        let mut included = Vec::new();
        for path in includes {
            let Some(Value::String(name)) = get(&self.rooted(), path).cloned() else { continue };
            let file = self.folder.join(&name);
            included.push(Layer::file(&file, Some((path, self.place(path, PathEnd::Value))))?);
            match path.0.strip_prefix(self.root.0.as_slice()) {
                Some([]) | None => self.value = Value::Mapping(Mapping::new()),
                Some(below) => remove(&mut self.value, &KeyPath(below.to_vec())),
            }
        }
        layers.push(self);
        layers.append(&mut included);
        Ok(())
    }

    /// Takes `extends` out of this layer and reads the file that it names.
    pub(super) fn parent(
        &mut self,
        extended_files: &[PathBuf],
    ) -> Result<Option<Layer>, SpecError> {
        let path = KeyPath::default().key("extends");
        let Some(value) = self.value.get("extends").cloned() else { return Ok(None) };
        let expected = "the name of a spec beside this one";
        let Value::String(name) = &value else {
            return Err(self.refuse(&path, describe(&value), expected));
        };
        let file = self.folder.join(name);
        if !file.is_file() {
            let found = format!("no file `{}`{}", file.display(), searched(&file));
            return Err(self.refuse(&path, found, expected));
        }
        if extended_files.contains(&canonical(&file)) {
            return Err(self.refuse(&path, format!("`{name}`, which extends this file"), expected));
        }
        if let Value::Mapping(mapping) = &mut self.value {
            mapping.remove("extends");
        }
        Layer::file(&file, None).map(Some)
    }

    pub(super) fn refuse(&self, path: &KeyPath, found: String, expected: &str) -> SpecError {
        let (place, expected) = (self.place(path, PathEnd::Value), expected.to_owned());
        SpecError::Key { place, key: path.clone(), found: invisible::named(found), expected }
    }

    pub(super) fn place(&self, path: &KeyPath, end: PathEnd) -> SourceLocation {
        if self.is_option() {
            return SourceLocation::Option(self.name.clone());
        }
        // The text has the key under its former name.
        let written = self.renamed.iter().find_map(|renamed| {
            let below = path.0.strip_prefix(renamed.present.0.as_slice())?;
            Some(KeyPath([renamed.former.0.as_slice(), below].concat()))
        });
        let path = &merge_keys::written(&self.merged, written.as_ref().unwrap_or(path));
        let below = path.0.strip_prefix(self.root.0.as_slice()).unwrap_or_default();
        let (line, column) = locate(&self.text, &KeyPath(below.to_vec()), end).unwrap_or((1, 1));
        SourceLocation::File { file: self.name.clone(), line, column }
    }

    /// The value of this layer at a path of the document; above its root, the mapping that leads
    /// there.
    pub(super) fn get(&self, path: &KeyPath) -> Option<Value> {
        match path.0.strip_prefix(self.root.0.as_slice()) {
            Some(below) => get(&self.value, &KeyPath(below.to_vec())).cloned(),
            None if self.root.0.starts_with(&path.0) => Some(Value::Mapping(Mapping::new())),
            None => None,
        }
    }

    /// Merges this layer into the tree of the weaker ones.
    ///
    /// # Errors
    /// [`SpecError::Key`] for an item that a list does not have.
    pub(super) fn merge_into(&self, tree: &mut Value) -> Result<(), SpecError> {
        if !self.root.0.iter().any(|step| matches!(step, Step::Item(_))) {
            merge(tree, self.rooted());
            return Ok(());
        }
        let mut value = get(tree, &self.root).cloned().unwrap_or(Value::Null);
        merge(&mut value, self.value.clone());
        put(tree, &self.root.0, value).map_err(|found| {
            self.refuse(&self.root, found, "a path of keys and of existing list items")
        })
    }

    /// The value under its path from the root of the document.
    pub(super) fn rooted(&self) -> Value {
        self.root.0.iter().rev().fold(self.value.clone(), |value, step| match step {
            Step::Key(key) => {
                Value::Mapping(Mapping::from_iter([(Value::from(key.as_str()), value)]))
            }
            Step::Item(_) => value,
        })
    }
}

/// The error for a malformed option.
fn malformed(option: &str, found: String, expected: String) -> SpecError {
    SpecError::Key {
        place: SourceLocation::Option(option.to_owned()),
        key: KeyPath::default(),
        found,
        expected,
    }
}

fn yaml(text: &str, name: &str) -> Result<Value, SpecError> {
    serde_yaml::from_str(text).map_err(|error| {
        let (line, column) = error.location().map_or((1, 1), |at| (at.line(), at.column()));
        let place = |line, column| match name.starts_with(SET) {
            true => SourceLocation::Option(name.to_owned()),
            false => SourceLocation::File { file: name.to_owned(), line, column },
        };
        if let Some((key, (line, column))) = repeated_key(&error.to_string(), text) {
            let (found, expected) = ("this key twice".to_owned(), "it once".to_owned());
            return SpecError::Key { place: place(line, column), key, found, expected };
        }
        if let Some((line, column, found)) = invisible::near(text, line) {
            let expected = "YAML of visible characters and plain spaces".to_owned();
            return SpecError::Syntax { place: place(line, column), found, expected };
        }
        let at_tab =
            text.lines().nth(line - 1).and_then(|text| text.chars().nth(column - 1)) == Some('\t');
        let (found, expected) = match at_tab {
            true => ("a tab character".to_owned(), "YAML, which is indented by spaces".to_owned()),
            false => syntax(&error.to_string()),
        };
        SpecError::Syntax { place: place(line, column), found, expected }
    })
}

/// A key that stands twice in one mapping, from the message of the parser, and where it stands first.
fn repeated_key(message: &str, text: &str) -> Option<(KeyPath, (usize, usize))> {
    let (mapping, key) =
        message.split(" at line ").next()?.split_once("duplicate entry with key ")?;
    let key = key.trim_matches('"');
    let path = KeyPath::parse(&format!("{}{key}", mapping.replace(": ", "."))).ok()?;
    let place = locate(text, &path, PathEnd::Key)?;
    Some((path, place))
}

/// What the parser of YAML found and what it expected, from its message.
fn syntax(message: &str) -> (String, String) {
    let words = message.split(" at line ").next().unwrap_or_default();
    if let Some(expected) = words.strip_prefix("did not find expected ") {
        return ("something else".to_owned(), format!("YAML with {expected} here"));
    }
    (words.strip_prefix("found ").unwrap_or(words).to_owned(), "YAML".to_owned())
}

/// Where a relative file was searched for, and the file there that is named most alike.
pub(super) fn searched(path: &Path) -> String {
    let folder =
        path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Ok(place) = folder.canonicalize() else {
        return format!(" (there is no folder `{}`)", folder.display());
    };
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    let suggestion = nearest(&name, names.iter().map(String::as_str));
    let hint =
        suggestion.map_or(String::new(), |suggestion| format!("; did you mean `{suggestion}`?"));
    format!(" in {}{hint}", place.display())
}

pub(super) fn canonical(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}
