//! A crate's modules and the paths that each of them names.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};

/// From the crate's root downward.
pub type Name = Vec<String>;

/// One module: a file, or a block in one.
#[derive(Debug, Default)]
pub struct Module {
    /// Paths as they are written, each in full.
    pub paths: Vec<Name>,
    /// Names that the module hands on, and what they stand for.
    pub reexports: BTreeMap<String, Name>,
    /// What would hide paths from this reader: all names of the crate's root at once, or the root by another name.
    pub hidden: Vec<String>,
}

/// All modules but those for tests alone.
#[derive(Debug, Default)]
pub struct Sources {
    pub modules: BTreeMap<Name, Module>,
}

impl Sources {
    /// The crate whose `lib.rs` stands in this folder.
    pub fn read(folder: &Path) -> Sources {
        let mut sources = Sources::default();
        sources.file(Vec::new(), &folder.join("lib.rs"), folder);
        sources
    }

    /// `folder` is where the files of modules below stand.
    fn file(&mut self, name: Name, file: &Path, folder: &Path) {
        let text = std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        let parsed = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        self.items(name, &parsed.items, folder);
    }

    fn items(&mut self, name: Name, items: &[syn::Item], folder: &Path) {
        let mut reader = Reader { module: Module::default(), depth: name.len() };
        for item in items {
            match item {
                syn::Item::Mod(module) if !is_test(&module.attrs) => {
                    let (mut below, folder) = (name.clone(), folder.join(module.ident.to_string()));
                    below.push(module.ident.to_string());
                    match &module.content {
                        Some((_, items)) => self.items(below, items, &folder),
                        None if folder.join("mod.rs").exists() => self.file(below, &folder.join("mod.rs"), &folder),
                        None => self.file(below, &folder.with_extension("rs"), &folder),
                    }
                }
                syn::Item::Mod(_) => {}
                other => reader.visit_item(other),
            }
        }
        self.modules.insert(name, reader.module);
    }
}

/// `#[cfg(test)]` or `#[test]`.
fn is_test(attributes: &[syn::Attribute]) -> bool {
    let cfg =
        |a: &syn::Attribute| a.path().is_ident("cfg") && a.parse_args::<syn::Path>().is_ok_and(|p| p.is_ident("test"));
    attributes.iter().any(|a| a.path().is_ident("test") || cfg(a))
}

struct Reader {
    module: Module,
    /// How far below the root the module lies.
    depth: usize,
}

/// Whether a path leads to the crate's root from a module so far below it.
fn is_root(path: &[String], depth: usize) -> bool {
    let here = path.iter().take_while(|part| *part == "self").count();
    let up = &path[here..];
    path == ["crate"] || (here > 0 || depth > 0) && up.len() == depth && up.iter().all(|part| part == "super")
}

impl Reader {
    /// Every path of a `use`, and what it is called here.
    fn tree(&mut self, tree: &syn::UseTree, before: &mut Name, handed_on: bool) {
        let mut leaf = |path: Name, called: String| {
            if handed_on {
                self.module.reexports.insert(called, path.clone());
            }
            self.module.paths.push(path);
        };
        match tree {
            syn::UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.tree(&path.tree, before, handed_on);
                before.pop();
            }
            syn::UseTree::Rename(rename)
                if is_root(before, self.depth) && rename.ident == "self"
                    || before.is_empty() && is_root(&[rename.ident.to_string()], self.depth) =>
            {
                self.module.hidden.push(format!("the crate's root by the name {}", rename.rename));
            }
            syn::UseTree::Glob(_) if is_root(before, self.depth) => {
                self.module.hidden.push("all names of the crate's root".into());
            }
            syn::UseTree::Name(name) if name.ident == "self" => {
                leaf(before.clone(), before.last().cloned().unwrap_or_default());
            }
            syn::UseTree::Name(name) => {
                let name = name.ident.to_string();
                leaf([before.as_slice(), std::slice::from_ref(&name)].concat(), name);
            }
            syn::UseTree::Rename(rename) => {
                leaf([before.as_slice(), &[rename.ident.to_string()]].concat(), rename.rename.to_string());
            }
            syn::UseTree::Glob(_) => self.module.paths.push(before.clone()),
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.tree(tree, before, handed_on)),
        }
    }

    /// Paths among the tokens of a macro, which are not parsed: names with two colons between them.
    fn tokens(&mut self, tokens: &str) {
        let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        let text = tokens.replace(|c| !is_part(c), " ").replace("::", " :: ");
        let words: Vec<&str> = text.split_whitespace().collect();
        for (at, first) in words.iter().enumerate().filter(|(_, word)| ["crate", "super", "self"].contains(*word)) {
            let (mut path, mut rest) = (vec![first.to_string()], &words[at + 1..]);
            while let ["::", name, more @ ..] = rest {
                path.push(name.to_string());
                rest = more;
            }
            if path.len() > 1 && (at == 0 || words[at - 1] != "::") {
                self.module.paths.push(path);
            }
        }
    }
}

impl<'a> Visit<'a> for Reader {
    fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
        let handed_on = !matches!(item.vis, syn::Visibility::Inherited);
        self.tree(&item.tree, &mut Vec::new(), handed_on);
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        if path.segments.len() > 1 {
            self.module.paths.push(path.segments.iter().map(|s| s.ident.to_string()).collect());
        }
        visit::visit_path(self, path);
    }

    fn visit_item_extern_crate(&mut self, item: &'a syn::ItemExternCrate) {
        if item.ident == "self" {
            self.module.hidden.push("the crate's root as a crate".into());
        }
    }

    /// What a derive is told to call, as tokens or in a text; the links of documentation are left out.
    fn visit_attribute(&mut self, attribute: &'a syn::Attribute) {
        match &attribute.meta {
            meta if meta.path().is_ident("doc") => {}
            syn::Meta::List(list) => self.tokens(&list.tokens.to_string()),
            syn::Meta::NameValue(syn::MetaNameValue { value: syn::Expr::Lit(text), .. }) => {
                if let syn::Lit::Str(text) = &text.lit {
                    self.tokens(&text.value());
                }
            }
            _ => visit::visit_attribute(self, attribute),
        }
    }

    fn visit_macro(&mut self, call: &'a syn::Macro) {
        self.tokens(&call.tokens.to_string());
        visit::visit_macro(self, call);
    }

    fn visit_item(&mut self, item: &'a syn::Item) {
        let attributes = match item {
            syn::Item::Const(item) => &item.attrs,
            syn::Item::Fn(item) => &item.attrs,
            syn::Item::Impl(item) => &item.attrs,
            syn::Item::Mod(item) => &item.attrs,
            syn::Item::Struct(item) => &item.attrs,
            syn::Item::Use(item) => &item.attrs,
            _ => &Vec::new(),
        };
        if !is_test(attributes) {
            visit::visit_item(self, item);
        }
    }
}

/// All Rust files in a folder and below.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    for path in entries.map(|entry| entry.expect("an entry").path()) {
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}
