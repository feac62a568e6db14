//! The modules of a crate, and which of them each one uses.

use proc_macro2::{TokenStream, TokenTree};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};

/// A module's path from the crate's root; empty for the root itself.
pub type Name = Vec<String>;

/// A path in the source: its segments, and where it stands.
#[derive(Clone, Debug)]
struct Reference {
    segments: Vec<String>,
    line: usize,
}

/// What a module says.
#[derive(Debug, Default)]
struct Module {
    file: PathBuf,
    /// Modules within, in the order of their declarations.
    children: Vec<String>,
    /// Names that it imports, and what each stands for.
    imports: BTreeMap<String, Vec<String>>,
    references: Vec<Reference>,
}

/// One module uses another.
#[derive(Clone, Debug)]
pub struct Use {
    /// Who uses.
    pub from: Name,
    /// What is used.
    pub to: Name,
    /// Where, as `file:line`.
    pub place: String,
}

/// A crate's modules.
#[derive(Debug, Default)]
pub struct Crate {
    modules: BTreeMap<Name, Module>,
}

impl Crate {
    /// Reads the crate whose first source file is `file`, relative to `root`. What only its unit tests contain is left out.
    ///
    /// # Panics
    /// Where a module's file is missing or does not parse.
    pub fn read(root: &Path, file: &Path) -> Self {
        let mut own = Crate::default();
        let folder = file.parent().unwrap_or(Path::new(""));
        own.read_file(root, file, folder, Vec::new());
        own
    }

    fn read_file(&mut self, root: &Path, file: &Path, folder: &Path, name: Name) {
        let text = fs::read_to_string(root.join(file)).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let parsed = syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        if !is_test(&parsed.attrs) {
            self.read_items(root, (file, folder), &parsed.items, name);
        }
    }

    fn read_items(&mut self, root: &Path, (file, folder): (&Path, &Path), items: &[syn::Item], name: Name) {
        let mut module = Module { file: file.to_owned(), ..Module::default() };
        for item in items {
            let syn::Item::Mod(child) = item else {
                module.visit_item(item);
                continue;
            };
            if is_test(&child.attrs) {
                continue;
            }
            let ident = child.ident.to_string();
            let child_name: Name = name.iter().cloned().chain([ident.clone()]).collect();
            if let Some((_, items)) = &child.content {
                self.read_items(root, (file, &folder.join(&ident)), items, child_name);
            } else {
                let (file, folder) = file_of(root, (file, folder), &ident, &child.attrs);
                self.read_file(root, &file, &folder, child_name);
            }
            module.children.push(ident);
        }
        self.modules.insert(name, module);
    }

    /// Every use of one module by another.
    pub fn uses(&self) -> Vec<Use> {
        let mut uses = Vec::new();
        for (from, module) in &self.modules {
            for reference in &module.references {
                let Some(to) = self.resolve(from, &reference.segments, 0).filter(|to| to != from) else { continue };
                let place = format!("{}:{}", module.file.display(), reference.line);
                uses.push(Use { from: from.clone(), to, place });
            }
        }
        uses
    }

    /// The modules directly within `name`, in the order of their declarations.
    pub fn children(&self, name: &Name) -> &[String] {
        self.modules.get(name).map_or(&[], |module| &module.children)
    }

    /// Every module.
    pub fn names(&self) -> impl Iterator<Item = &Name> {
        self.modules.keys()
    }

    /// The module in which that stands which a path names when written in the module `from`; `None` in another crate.
    fn resolve(&self, from: &Name, segments: &[String], depth: usize) -> Option<Name> {
        let (first, rest) = segments.split_first()?;
        let module = self.modules.get(from)?;
        match first.as_str() {
            "crate" => self.descend(Vec::new(), rest, depth),
            "self" => self.descend(from.clone(), rest, depth),
            "super" => {
                let (_, parent) = from.split_last()?;
                let parent = parent.to_vec();
                if rest.first().is_some_and(|next| next == "super") {
                    self.resolve(&parent, rest, depth)
                } else {
                    self.descend(parent, rest, depth)
                }
            }
            first if module.children.iter().any(|child| child == first) => self.descend(from.clone(), segments, depth),
            first => self.imported(from, module.imports.get(first)?, rest, depth),
        }
    }

    /// Follows a path from the module `at` on: into its children, through its imports, up to an item.
    fn descend(&self, at: Name, segments: &[String], depth: usize) -> Option<Name> {
        let Some((first, rest)) = segments.split_first() else { return Some(at) };
        let module = self.modules.get(&at)?;
        if module.children.contains(first) {
            return self.descend(at.into_iter().chain([first.clone()]).collect(), rest, depth);
        }
        match module.imports.get(first) {
            Some(path) => self.imported(&at, path, rest, depth),
            None => Some(at),
        }
    }

    fn imported(&self, at: &Name, path: &[String], rest: &[String], depth: usize) -> Option<Name> {
        // Imports of each other's imports never go so deep, but for `use search::search`, which names itself.
        let is_itself = path.len() == 1 && rest.is_empty();
        if depth > 8 || is_itself {
            return None;
        }
        let whole: Vec<String> = path.iter().chain(rest).cloned().collect();
        self.resolve(at, &whole, depth + 1)
    }
}

/// Whether an item exists for unit tests alone.
fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg") && attribute.parse_args::<syn::Path>().is_ok_and(|path| path.is_ident("test"))
    })
}

/// The file of the module `name` declared in `file`, and the folder of that module's own modules.
fn file_of(
    root: &Path,
    (file, folder): (&Path, &Path),
    name: &str,
    attributes: &[syn::Attribute],
) -> (PathBuf, PathBuf) {
    let stated = attributes.iter().find(|attribute| attribute.path().is_ident("path")).and_then(|attribute| {
        let syn::Meta::NameValue(pair) = &attribute.meta else { return None };
        let syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }) = &pair.value else { return None };
        Some(text.value())
    });
    if let Some(stated) = stated {
        let file = file.parent().unwrap_or(Path::new("")).join(stated);
        let folder = file.parent().unwrap_or(Path::new("")).to_owned();
        return (file, folder);
    }
    let (flat, nested) = (folder.join(format!("{name}.rs")), folder.join(name).join("mod.rs"));
    (if root.join(&flat).exists() { flat } else { nested }, folder.join(name))
}

impl Module {
    fn add(&mut self, segments: Vec<String>, line: usize) {
        self.references.push(Reference { segments, line });
    }

    fn import(&mut self, tree: &syn::UseTree, before: &[String], line: usize) {
        let with = |ident: &syn::Ident| before.iter().cloned().chain([ident.to_string()]).collect::<Vec<_>>();
        match tree {
            syn::UseTree::Path(path) => self.import(&path.tree, &with(&path.ident), line),
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.import(tree, before, line)),
            syn::UseTree::Glob(_) => self.add(before.to_vec(), line),
            syn::UseTree::Name(name) if name.ident == "self" => {
                self.imports.extend(before.last().map(|last| (last.clone(), before.to_vec())));
                self.add(before.to_vec(), line);
            }
            syn::UseTree::Name(name) => {
                self.imports.insert(name.ident.to_string(), with(&name.ident));
                self.add(with(&name.ident), line);
            }
            syn::UseTree::Rename(rename) => {
                self.imports.insert(rename.rename.to_string(), with(&rename.ident));
                self.add(with(&rename.ident), line);
            }
        }
    }

    /// Paths among a macro's tokens that begin with `crate`, `super` or `self`.
    fn add_tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut line = 0;
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Ident(ident) if path.is_empty() || colons == 2 => {
                    line = ident.span().start().line;
                    path.push(ident.to_string());
                    colons = 0;
                }
                TokenTree::Punct(mark) if mark.as_char() == ':' && !path.is_empty() => colons += 1,
                other => {
                    self.add_tokens_path(&mut path, line);
                    colons = 0;
                    match other {
                        TokenTree::Group(group) => self.add_tokens(group.stream()),
                        TokenTree::Ident(ident) => {
                            line = ident.span().start().line;
                            path.push(ident.to_string());
                        }
                        TokenTree::Punct(_) | TokenTree::Literal(_) => {}
                    }
                }
            }
        }
        self.add_tokens_path(&mut path, line);
    }

    fn add_tokens_path(&mut self, path: &mut Vec<String>, line: usize) {
        let path = std::mem::take(path);
        if path.len() > 1 {
            self.add(path, line);
        }
    }
}

impl<'ast> Visit<'ast> for Module {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        let attributes: &[syn::Attribute] = match item {
            syn::Item::Fn(item) => &item.attrs,
            syn::Item::Impl(item) => &item.attrs,
            syn::Item::Use(item) => &item.attrs,
            syn::Item::Const(item) => &item.attrs,
            syn::Item::Struct(item) => &item.attrs,
            _ => &[],
        };
        if !is_test(attributes) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.import(&item.tree, &[], item.use_token.span.start().line);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        let line = path.segments.first().map_or(0, |segment| segment.ident.span().start().line);
        self.add(segments, line);
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, item: &'ast syn::Macro) {
        self.add_tokens(item.tokens.clone());
        visit::visit_macro(self, item);
    }

    // `pub(in crate::x)` uses nothing.
    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}
}
