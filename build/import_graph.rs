//! The import graph of the crate, read from its sources: which files a file depends on, and which
//! external crates it names. The build script derives from it what a stored result depends on; the
//! architecture tests hold the rooms by it.
//!
//! Rules, chosen so that the closure of a file is sound (a file outside of it cannot change what
//! the file computes):
//!
//! * A path in code, in a private `use`, in a macro's tokens or in an attribute's text is an edge
//!   to the file that *defines* the item. Re-exports are followed: a file that only passes a name
//!   on is not part of the closure.
//! * A name that a module does not visibly define (a macro makes it) counts as defined in the
//!   module's file.
//! * A re-exported trait is an edge of the file that re-exports it, since methods need no path.
//! * An `impl` block in a file that nobody names belongs to the closure as soon as all types and
//!   traits in its header do.
//! * A macro that is called by its bare name is an edge to every file that defines a macro of this
//!   name.
//! * Comments, layout, doc attributes and `#[cfg(test)]` items do not count.
//! * `include_str!`, `include_bytes!` and `include!` with a literal path are edges to that file.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use syn::buffer::{Cursor, TokenBuffer};
use syn::visit::{self, Visit};

/// A module of the crate, by the names on the way to it; the program's own modules begin with
/// [`PROGRAM`].
type Module = Vec<String>;

/// First name of the modules below `main.rs`.
const PROGRAM: &str = "(program)";

/// What a name stands for in a module.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Binding {
    /// A module of the crate.
    Module(Module),
    /// An item of this module; true for a trait.
    Item(bool),
    /// Another path, as it stands in a `use` of this module.
    Use(Vec<String>),
}

/// What a path leads to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Target {
    Module(Module),
    /// An item of this file; true for a trait.
    Item(String, bool),
    External(String),
}

/// The names that a module knows.
#[derive(Default)]
struct Scope {
    file: String,
    names: BTreeMap<String, BTreeSet<Binding>>,
}

/// An `impl` block: the files that define what its header names.
struct ImplBlock {
    file: String,
    header: BTreeSet<String>,
}

/// Files of the crate with what each depends on. Files are named by their path below `src/`, with
/// `/`.
#[derive(Default)]
pub(crate) struct ImportGraph {
    scopes: BTreeMap<Module, Scope>,
    externals: BTreeSet<String>,
    macros: BTreeMap<String, BTreeSet<String>>,
    edges: BTreeMap<String, BTreeSet<String>>,
    crates: BTreeMap<String, BTreeSet<String>>,
    impls: Vec<ImplBlock>,
}

impl ImportGraph {
    /// Reads the graph of a crate with this library name from its files and the library names of
    /// its dependencies.
    ///
    /// # Errors
    /// The first file that cannot be parsed.
    pub(crate) fn new<'a>(
        library: &str,
        files: &BTreeMap<String, String>,
        externals: impl IntoIterator<Item = &'a str>,
    ) -> Result<ImportGraph, String> {
        let externals = externals.into_iter().map(|name| name.replace('-', "_")).collect();
        let mut graph = ImportGraph { externals, ..ImportGraph::default() };
        let mut parsed = Vec::new();
        for (file, text) in files.iter().filter(|(file, _)| file.ends_with(".rs")) {
            let tree = syn::parse_file(text).map_err(|error| format!("{file}: {error}"))?;
            parsed.push((file.clone(), module_of(file), tree));
        }
        let root = parsed
            .iter()
            .find(|(file, ..)| file == "lib.rs")
            .map(|(.., tree)| declared(&tree.items));
        let root = root.ok_or("lib.rs: not found")?;
        for (_, module, _) in parsed.iter_mut().filter(|(file, ..)| file != "main.rs") {
            if module.first().is_some_and(|room| !root.contains(room)) {
                module.insert(0, PROGRAM.to_owned());
            }
        }
        let tests: BTreeSet<Module> =
            parsed.iter().flat_map(|(_, module, tree)| test_modules(module, tree)).collect();
        parsed.retain(|(_, module, _)| {
            !(1..=module.len()).any(|length| tests.contains(&module[..length]))
        });
        for (file, module, tree) in &parsed {
            graph.collect(file, module, &tree.items);
            // Whoever declares it and the modules around it, also inside a macro.
            for depth in 1..=module.len() {
                let names =
                    &mut graph.scopes.entry(module[..depth - 1].to_vec()).or_default().names;
                let binding = Binding::Module(module[..depth].to_vec());
                names.entry(module[depth - 1].clone()).or_default().insert(binding);
            }
        }
        for (file, module, tree) in &parsed {
            let mut visitor = Visitor {
                graph: &graph,
                library,
                file,
                module: module.clone(),
                targets: BTreeSet::new(),
                files: BTreeSet::new(),
                impls: Vec::new(),
            };
            visitor.visit_file(tree);
            let Visitor { targets, files: mut edges, impls, .. } = visitor;
            let mut crates = BTreeSet::new();
            for target in targets {
                match target {
                    Target::Item(defined, _) => edges.insert(defined),
                    Target::External(name) => crates.insert(name),
                    Target::Module(_) => false,
                };
            }
            edges.remove(file);
            edges.retain(|edge| files.contains_key(edge));
            graph.edges.insert(file.clone(), edges);
            graph.crates.insert(file.clone(), crates);
            graph
                .impls
                .extend(impls.into_iter().map(|header| ImplBlock { file: file.clone(), header }));
        }
        Ok(graph)
    }

    /// The files that `file` names items of.
    pub(crate) fn imports(&self, file: &str) -> &BTreeSet<String> {
        static NONE: BTreeSet<String> = BTreeSet::new();
        self.edges.get(file).unwrap_or(&NONE)
    }

    /// The external crates that `file` names.
    pub(crate) fn crates(&self, file: &str) -> &BTreeSet<String> {
        static NONE: BTreeSet<String> = BTreeSet::new();
        self.crates.get(file).unwrap_or(&NONE)
    }

    /// All files that `roots` depend on, the roots included. Files for which `outside` holds are
    /// not entered unless they are roots.
    pub(crate) fn closure<'a>(
        &self,
        roots: impl IntoIterator<Item = &'a str>,
        outside: impl Fn(&str) -> bool,
    ) -> BTreeSet<String> {
        let mut closure: BTreeSet<String> = roots.into_iter().map(str::to_owned).collect();
        let mut next: Vec<String> = closure.iter().cloned().collect();
        loop {
            while let Some(file) = next.pop() {
                for edge in self.imports(&file).iter().filter(|edge| !outside(edge)) {
                    if closure.insert(edge.clone()) {
                        next.push(edge.clone());
                    }
                }
            }
            let reached =
                |block: &&ImplBlock| !block.header.is_empty() && block.header.is_subset(&closure);
            let found: Vec<String> =
                self.impls.iter().filter(reached).map(|block| block.file.clone()).collect();
            next.extend(
                found.into_iter().filter(|file| !outside(file) && closure.insert(file.clone())),
            );
            if next.is_empty() {
                return closure;
            }
        }
    }

    /// Adds the names of a module and of the modules inside it.
    fn collect(&mut self, file: &str, module: &Module, items: &[syn::Item]) {
        self.scopes.entry(module.clone()).or_default().file = file.to_owned();
        for item in items.iter().filter(|item| !is_test(attributes(item))) {
            let mut bind = |name: String, binding: Binding| {
                self.scopes
                    .entry(module.clone())
                    .or_default()
                    .names
                    .entry(name)
                    .or_default()
                    .insert(binding);
            };
            match item {
                syn::Item::Mod(inner) => {
                    let name = inner.ident.to_string();
                    let path = [module.as_slice(), std::slice::from_ref(&name)].concat();
                    bind(name, Binding::Module(path.clone()));
                    if let Some((_, items)) = &inner.content {
                        self.collect(file, &path, items);
                    }
                }
                syn::Item::Use(inner) => {
                    for (path, name) in leaves(&inner.tree) {
                        bind(name, Binding::Use(path));
                    }
                }
                syn::Item::Macro(inner) => {
                    if let Some(name) = &inner.ident {
                        self.macros.entry(name.to_string()).or_default().insert(file.to_owned());
                    }
                }
                other => {
                    // Names that a function's body imports count for the module: more names, never
                    // fewer.
                    let mut local = LocalUses::default();
                    local.visit_item(other);
                    local.0.into_iter().for_each(|(path, name)| bind(name, Binding::Use(path)));
                    if let Some(name) = defined(other) {
                        bind(
                            name,
                            Binding::Item(matches!(
                                other,
                                syn::Item::Trait(_) | syn::Item::TraitAlias(_)
                            )),
                        );
                    }
                }
            }
        }
    }

    /// What `path` leads to when it stands in `module`.
    fn resolve(&self, library: &str, module: &Module, path: &[String]) -> BTreeSet<Target> {
        let seen = RefCell::new(BTreeSet::new());
        self.resolve_new(library, module, path, &seen)
    }

    fn resolve_new(
        &self,
        library: &str,
        module: &Module,
        path: &[String],
        seen: &RefCell<BTreeSet<(Module, Vec<String>)>>,
    ) -> BTreeSet<Target> {
        let mut found = BTreeSet::new();
        let Some((first, rest)) = path.split_first() else { return found };
        if !seen.borrow_mut().insert((module.clone(), path.to_vec())) {
            return found;
        }
        let root = if module.first().is_some_and(|name| name == PROGRAM) {
            vec![PROGRAM.to_owned()]
        } else {
            vec![]
        };
        match first.as_str() {
            "crate" => self.descend(library, root, rest, seen, &mut found),
            "self" => self.descend(library, module.clone(), rest, seen, &mut found),
            "super" => {
                let mut above = module.clone();
                above.pop();
                let rest = if rest.first().is_some_and(|next| next == "super") {
                    return self.resolve_new(library, &above, rest, seen);
                } else {
                    rest
                };
                self.descend(library, above, rest, seen, &mut found);
            }
            name => {
                if self.scopes.get(module).is_some_and(|scope| scope.names.contains_key(name)) {
                    self.descend(library, module.clone(), path, seen, &mut found);
                } else if name == library {
                    self.descend(library, Vec::new(), rest, seen, &mut found);
                } else if self.externals.contains(name) {
                    found.insert(Target::External(name.to_owned()));
                }
            }
        }
        found
    }

    /// What the names `rest` lead to from within `module`.
    fn descend(
        &self,
        library: &str,
        module: Module,
        rest: &[String],
        seen: &RefCell<BTreeSet<(Module, Vec<String>)>>,
        found: &mut BTreeSet<Target>,
    ) {
        let Some((name, after)) = rest.split_first() else {
            found.insert(Target::Module(module));
            return;
        };
        let Some(scope) = self.scopes.get(&module) else { return };
        let Some(bindings) = scope.names.get(name) else {
            // A macro makes it, or it is a variant of an enum of the same path.
            found.insert(Target::Item(scope.file.clone(), false));
            return;
        };
        for binding in bindings {
            match binding {
                Binding::Module(inner) => self.descend(library, inner.clone(), after, seen, found),
                Binding::Item(is_trait) => {
                    found.insert(Target::Item(scope.file.clone(), *is_trait));
                }
                Binding::Use(path) if path.first() == Some(name) && path.len() == 1 => {
                    if self.externals.contains(name) {
                        found.insert(Target::External(name.clone()));
                    }
                }
                Binding::Use(path) => {
                    // `use` paths begin at a crate or at a name of this module, never at the name
                    // that they bind here.
                    for target in self.resolve_new(library, &module, path, seen) {
                        match target {
                            Target::Module(inner) => {
                                self.descend(library, inner, after, seen, found)
                            }
                            other => {
                                found.insert(other);
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Collects what one file names.
struct Visitor<'a> {
    graph: &'a ImportGraph,
    library: &'a str,
    file: &'a str,
    module: Module,
    targets: BTreeSet<Target>,
    files: BTreeSet<String>,
    impls: Vec<BTreeSet<String>>,
}

impl Visitor<'_> {
    fn name(&mut self, path: &[String]) {
        self.targets.extend(self.graph.resolve(self.library, &self.module, path));
    }

    /// Names in tokens that have not been parsed: sequences of `a::b::c`, and paths in literal text
    /// where `texts`.
    fn tokens(&mut self, mut cursor: Cursor, texts: bool) {
        let mut path: Vec<String> = Vec::new();
        let mut joined = false;
        while !cursor.eof() {
            if let Some((name, next)) = cursor.ident() {
                if !joined {
                    self.name(&std::mem::take(&mut path));
                }
                path.push(name.to_string());
                (joined, cursor) = (false, next);
            } else if let Some((_, next)) = cursor.lifetime() {
                cursor = next;
            } else if let Some((mark, next)) = cursor.punct() {
                let colons = next
                    .punct()
                    .filter(|(second, _)| mark.as_char() == ':' && second.as_char() == ':');
                if let Some((_, after)) = colons.filter(|_| !path.is_empty()) {
                    (joined, cursor) = (true, after);
                } else {
                    self.called(&path, mark.as_char());
                    self.name(&std::mem::take(&mut path));
                    (joined, cursor) = (false, next);
                }
            } else if let Some((inside, _, _, next)) = cursor.any_group() {
                self.name(&std::mem::take(&mut path));
                self.tokens(inside, texts);
                (joined, cursor) = (false, next);
            } else if let Some((literal, next)) = cursor.literal() {
                if texts {
                    self.text(&literal.to_string());
                }
                cursor = next;
            } else {
                match cursor.token_tree() {
                    Some((_, next)) => cursor = next,
                    None => break,
                }
            }
        }
        self.name(&path);
    }

    /// A macro's name before its `!`.
    fn called(&mut self, path: &[String], mark: char) {
        if let ([name], '!') = (path, mark) {
            self.files.extend(self.graph.macros.get(name).into_iter().flatten().cloned());
        }
    }

    /// A path in the text of an attribute, as serde takes them.
    fn text(&mut self, literal: &str) {
        let text = literal.trim_matches('"');
        let names: Vec<String> =
            text.split("::").map(|name| name.split('<').next().unwrap_or("").to_owned()).collect();
        let is_name = |name: &String| {
            !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || c == '_')
        };
        if names.iter().all(is_name) {
            // serde's `with` names a module: its functions are meant.
            for target in self.graph.resolve(self.library, &self.module, &names) {
                match target {
                    Target::Module(module) => {
                        self.files
                            .extend(self.graph.scopes.get(&module).map(|scope| scope.file.clone()));
                    }
                    other => {
                        self.targets.insert(other);
                    }
                }
            }
        }
    }

    fn path(&self, path: &syn::Path) -> Vec<String> {
        path.segments.iter().map(|segment| segment.ident.to_string()).collect()
    }
}

impl<'ast> Visit<'ast> for Visitor<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        self.module.push(item.ident.to_string());
        visit::visit_item_mod(self, item);
        self.module.pop();
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let private = matches!(item.vis, syn::Visibility::Inherited);
        for (path, _) in leaves(&item.tree) {
            let targets = self.graph.resolve(self.library, &self.module, &path);
            let counts = |target: &Target| {
                private || matches!(target, Target::Item(_, true) | Target::External(_))
            };
            self.targets.extend(targets.into_iter().filter(counts));
        }
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        let kept = std::mem::take(&mut self.targets);
        if let Some((_, path, _)) = &item.trait_ {
            self.visit_path(path);
        }
        self.visit_type(&item.self_ty);
        let header = self.targets.iter().filter_map(|target| match target {
            Target::Item(file, _) => Some(file.clone()),
            _ => None,
        });
        self.impls.push(header.collect());
        self.targets.extend(kept);
        visit::visit_item_impl(self, item);
    }

    fn visit_impl_item(&mut self, item: &'ast syn::ImplItem) {
        let attributes = match item {
            syn::ImplItem::Const(item) => &item.attrs,
            syn::ImplItem::Fn(item) => &item.attrs,
            _ => return visit::visit_impl_item(self, item),
        };
        if !is_test(attributes) {
            visit::visit_impl_item(self, item);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names = self.path(path);
        self.name(&names);
        visit::visit_path(self, path);
    }

    fn visit_attribute(&mut self, attribute: &'ast syn::Attribute) {
        if attribute.path().is_ident("doc") {
            return;
        }
        if let syn::Meta::List(list) = &attribute.meta {
            self.tokens(TokenBuffer::new2(list.tokens.clone()).begin(), true);
        }
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        let names = self.path(&call.path);
        self.called(&names, '!');
        self.name(&names);
        if names.last().is_some_and(|name| name.starts_with("include"))
            && let Ok(text) = call.parse_body::<syn::LitStr>()
        {
            self.files.insert(beside(self.file, &text.value()));
        }
        self.tokens(TokenBuffer::new2(call.tokens.clone()).begin(), false);
    }
}

/// The `use` declarations in the bodies of an item.
#[derive(Default)]
struct LocalUses(Vec<(Vec<String>, String)>);

impl<'ast> Visit<'ast> for LocalUses {
    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.0.extend(leaves(&item.tree));
    }
}

/// The module of a file below `src/`.
fn module_of(file: &str) -> Module {
    if file == "main.rs" {
        return vec![PROGRAM.to_owned()];
    }
    let path = file.trim_end_matches(".rs").trim_end_matches("/mod");
    if path == "lib" { Vec::new() } else { path.split('/').map(str::to_owned).collect() }
}

/// The modules that these items declare.
fn declared(items: &[syn::Item]) -> BTreeSet<String> {
    let module = |item: &syn::Item| {
        if let syn::Item::Mod(item) = item { Some(item.ident.to_string()) } else { None }
    };
    items.iter().filter_map(module).collect()
}

/// The files' modules that are declared for tests only.
fn test_modules(module: &Module, tree: &syn::File) -> Vec<Module> {
    let tests = tree.items.iter().filter(|item| is_test(attributes(item)));
    let path = |item: &syn::Item| match item {
        syn::Item::Mod(item) if item.content.is_none() => {
            Some([module.as_slice(), &[item.ident.to_string()]].concat())
        }
        _ => None,
    };
    tests.filter_map(path).collect()
}

/// The paths of a `use` declaration with the name that each binds; a glob binds `*`.
fn leaves(tree: &syn::UseTree) -> Vec<(Vec<String>, String)> {
    fn descend(tree: &syn::UseTree, path: &[String], found: &mut Vec<(Vec<String>, String)>) {
        let joined = |name: &syn::Ident| [path, &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(inner) => descend(&inner.tree, &joined(&inner.ident), found),
            syn::UseTree::Name(inner) if inner.ident == "self" => {
                found.push((path.to_vec(), path.last().cloned().unwrap_or_default()));
            }
            syn::UseTree::Name(inner) => {
                found.push((joined(&inner.ident), inner.ident.to_string()))
            }
            syn::UseTree::Rename(inner) if inner.ident == "self" => {
                found.push((path.to_vec(), inner.rename.to_string()))
            }
            syn::UseTree::Rename(inner) => {
                found.push((joined(&inner.ident), inner.rename.to_string()))
            }
            syn::UseTree::Glob(_) => found.push((path.to_vec(), "*".to_owned())),
            syn::UseTree::Group(inner) => {
                inner.items.iter().for_each(|tree| descend(tree, path, found))
            }
        }
    }
    let mut found = Vec::new();
    descend(tree, &[], &mut found);
    found
}

/// The name that an item defines.
fn defined(item: &syn::Item) -> Option<String> {
    let name = match item {
        syn::Item::Const(item) => &item.ident,
        syn::Item::Enum(item) => &item.ident,
        syn::Item::Fn(item) => &item.sig.ident,
        syn::Item::Static(item) => &item.ident,
        syn::Item::Struct(item) => &item.ident,
        syn::Item::Trait(item) => &item.ident,
        syn::Item::TraitAlias(item) => &item.ident,
        syn::Item::Type(item) => &item.ident,
        syn::Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(name.to_string())
}

fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    match item {
        syn::Item::Const(item) => &item.attrs,
        syn::Item::Enum(item) => &item.attrs,
        syn::Item::Fn(item) => &item.attrs,
        syn::Item::Impl(item) => &item.attrs,
        syn::Item::Macro(item) => &item.attrs,
        syn::Item::Mod(item) => &item.attrs,
        syn::Item::Static(item) => &item.attrs,
        syn::Item::Struct(item) => &item.attrs,
        syn::Item::Trait(item) => &item.attrs,
        syn::Item::Type(item) => &item.attrs,
        syn::Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// True with `#[cfg(test)]`.
fn is_test(attributes: &[syn::Attribute]) -> bool {
    let test = |attribute: &syn::Attribute| {
        attribute.path().is_ident("cfg")
            && attribute.parse_args::<syn::Ident>().is_ok_and(|name| name == "test")
    };
    attributes.iter().any(test)
}

/// The file that `text` names beside `file`, below `src/`.
fn beside(file: &str, text: &str) -> String {
    let mut path: Vec<&str> = file.split('/').collect();
    path.pop();
    for step in text.split('/') {
        match step {
            "." => {}
            ".." => {
                path.pop();
            }
            name => path.push(name),
        }
    }
    path.join("/")
}

/// What counts of a source: its tokens, without comments, layout, doc attributes and test items.
///
/// # Errors
/// Text that is no Rust.
pub(crate) fn code(text: &str) -> Result<String, String> {
    let tokens = text.parse().map_err(|error| format!("{error}"))?;
    let mut code = String::with_capacity(text.len());
    write_tokens(TokenBuffer::new2(tokens).begin(), &mut code);
    Ok(code)
}

fn write_tokens(mut cursor: Cursor, code: &mut String) {
    while !cursor.eof() {
        if let Some((inside, after)) = attribute(cursor) {
            let name = inside.ident().map(|(name, _)| name.to_string()).unwrap_or_default();
            if name == "doc" {
                cursor = after;
                continue;
            }
            if let Some(end) = cfg_test(inside).then(|| item_end(after)).flatten() {
                cursor = end;
                continue;
            }
        }
        if let Some((inside, delimiter, _, next)) = cursor.any_group() {
            code.push_str(&format!("{delimiter:?}("));
            write_tokens(inside, code);
            code.push(')');
            cursor = next;
        } else if let Some((token, next)) = cursor.token_tree() {
            code.push_str(&token.to_string());
            code.push(' ');
            cursor = next;
        } else {
            break;
        }
    }
}

/// The inside of the attribute that begins here and what follows it.
fn attribute(cursor: Cursor) -> Option<(Cursor, Cursor)> {
    let (_, mut next) = cursor.punct().filter(|(mark, _)| mark.as_char() == '#')?;
    if let Some((_, after)) = next.punct().filter(|(mark, _)| mark.as_char() == '!') {
        next = after;
    }
    let (inside, delimiter, _, after) = next.any_group()?;
    (format!("{delimiter:?}") == "Bracket").then_some((inside, after))
}

/// True inside `#[cfg(test)]`.
fn cfg_test(inside: Cursor) -> bool {
    let Some((name, next)) = inside.ident() else { return false };
    let Some((condition, _, _, end)) = next.any_group() else { return false };
    let only_test = condition.ident().is_some_and(|(word, rest)| word == "test" && rest.eof());
    name == "cfg" && only_test && end.eof()
}

/// What follows the item that begins here; `None` where no item begins.
fn item_end(mut cursor: Cursor) -> Option<Cursor> {
    const KEYWORDS: [&str; 12] = [
        "async", "const", "enum", "fn", "impl", "mod", "static", "struct", "trait", "type",
        "unsafe", "use",
    ];
    while let Some((_, after)) = attribute(cursor) {
        cursor = after;
    }
    if let Some((word, next)) = cursor.ident().filter(|(word, _)| word == "pub") {
        let _ = word;
        cursor = next.any_group().map_or(next, |(_, _, _, after)| after);
    }
    let (keyword, _) =
        cursor.ident().filter(|(word, _)| KEYWORDS.iter().any(|keyword| word == keyword))?;
    let to_semicolon = ["const", "static", "type", "use"].iter().any(|word| keyword == word);
    while !cursor.eof() {
        if let Some((_, delimiter, _, next)) = cursor.any_group() {
            if format!("{delimiter:?}") == "Brace" && !to_semicolon {
                return Some(next);
            }
            cursor = next;
        } else {
            let ends = cursor.punct().is_some_and(|(mark, _)| mark.as_char() == ';');
            cursor = cursor.token_tree()?.1;
            if ends {
                return Some(cursor);
            }
        }
    }
    None
}
