//! One word for one thing: a type name stands for one type in the whole crate.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(path);
        }
    }
}

/// Structs, enums, traits and type aliases of one file, outside tests.
#[derive(Default)]
struct Declared(Vec<String>);

impl<'ast> Visit<'ast> for Declared {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        let is_test = |attribute: &syn::Attribute| {
            attribute.path().is_ident("cfg") && attribute.parse_args::<syn::Ident>().is_ok_and(|what| what == "test")
        };
        if !module.attrs.iter().any(is_test) {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        self.0.push(item.ident.to_string());
    }

    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        self.0.push(item.ident.to_string());
    }

    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        self.0.push(item.ident.to_string());
    }

    fn visit_item_type(&mut self, item: &'ast syn::ItemType) {
        self.0.push(item.ident.to_string());
    }
}

fn declared(text: &str) -> Vec<String> {
    let mut declared = Declared::default();
    declared.visit_file(&syn::parse_file(text).unwrap());
    declared.0
}

#[test]
fn a_type_name_stands_for_one_type() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    let mut homes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in files.iter().filter(|file| !file.ends_with("tests.rs")) {
        let home = file.strip_prefix(&src).unwrap().display().to_string();
        for name in declared(&std::fs::read_to_string(file).unwrap()) {
            homes.entry(name).or_default().push(home.clone());
        }
    }
    assert!(homes.len() > 500, "{} types were found", homes.len());
    homes.retain(|_, homes| homes.len() > 1);
    let twice: Vec<String> = homes.iter().map(|(name, homes)| format!("{name}: {}", homes.join(", "))).collect();
    assert!(twice.is_empty(), "{} names stand for several types:\n{}", twice.len(), twice.join("\n"));
}

#[test]
fn types_are_found_and_those_of_tests_are_not() {
    let text = "pub(crate) struct A { b: u8 }\nenum C {}\ntype D = A;\npub trait E { type F; }\n#[cfg(test)]\nmod tests { struct A; }";
    assert_eq!(declared(text), ["A", "C", "D", "E"]);
}
