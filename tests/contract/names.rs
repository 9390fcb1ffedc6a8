//! One word for one thing: a type name stands for one type in the whole crate.

use std::collections::BTreeMap;

use syn::visit::{self, Visit};

/// Structs, enums, traits and type aliases of one file, outside tests.
#[derive(Default)]
struct Declared(Vec<String>);

impl<'ast> Visit<'ast> for Declared {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        let is_test = |attribute: &syn::Attribute| {
            attribute.path().is_ident("cfg")
                && attribute.parse_args::<syn::Ident>().is_ok_and(|what| what == "test")
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
    let mut homes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (file, text) in crate::store_keys::sources() {
        if file.ends_with(".rs") && !file.ends_with("tests.rs") {
            for name in declared(&text) {
                homes.entry(name).or_default().push(file.clone());
            }
        }
    }
    assert!(homes.len() > 500, "{} types were found", homes.len());
    homes.retain(|_, homes| homes.len() > 1);
    let twice: Vec<String> =
        homes.iter().map(|(name, homes)| format!("{name}: {}", homes.join(", "))).collect();
    assert!(
        twice.is_empty(),
        "{} names stand for several types:\n{}",
        twice.len(),
        twice.join("\n")
    );
}

#[test]
fn types_are_found_and_those_of_tests_are_not() {
    let text = "pub(crate) struct A { b: u8 }\nenum C {}\ntype D = A;\npub trait E { type F; \
                }\n#[cfg(test)]\nmod tests { struct A; }";
    assert_eq!(declared(text), ["A", "C", "D", "E"]);
}
