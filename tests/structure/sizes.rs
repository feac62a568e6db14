//! How long files and functions are.

use proc_macro2::Span;
use std::path::Path;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

/// Lines of a file at most.
pub const FILE_LINES: usize = 400;
/// Lines of a function at most, from its signature to its closing brace.
pub const FUNCTION_LINES: usize = 60;

/// Whether the limits do not hold for a file: assembly is as long as the instructions it needs.
pub fn is_assembly(file: &Path) -> bool {
    file.file_name().is_some_and(|name| name == "armv7em.rs")
}

/// A function: its name, with that of the type it belongs to, and its lines.
#[derive(Debug)]
pub struct Function {
    /// `name` or `Type::name`.
    pub name: String,
    /// Lines from its signature to its closing brace.
    pub lines: usize,
}

/// The functions of a file.
///
/// # Panics
/// Where the text is not Rust.
pub fn functions(text: &str) -> Vec<Function> {
    let file = syn::parse_file(text).expect("a source file parses");
    let mut found = Functions::default();
    found.visit_file(&file);
    found.found
}

#[derive(Default)]
struct Functions {
    /// The type whose `impl` or the trait that is being visited.
    of: Option<String>,
    found: Vec<Function>,
}

impl Functions {
    fn add(&mut self, signature: &syn::Signature, block: &syn::Block) {
        let name = signature.ident.to_string();
        let name = self.of.as_ref().map_or(name.clone(), |of| format!("{of}::{name}"));
        self.found.push(Function { name, lines: lines(signature.span(), block.span()) });
    }

    fn within(&mut self, of: String, visit: impl FnOnce(&mut Self)) {
        let before = self.of.replace(of);
        visit(self);
        self.of = before;
    }
}

fn lines(first: Span, last: Span) -> usize {
    last.end().line - first.start().line + 1
}

impl<'ast> Visit<'ast> for Functions {
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.add(&item.sig, &item.block);
        visit::visit_item_fn(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.add(&item.sig, &item.block);
        visit::visit_impl_item_fn(self, item);
    }

    fn visit_trait_item_fn(&mut self, item: &'ast syn::TraitItemFn) {
        if let Some(block) = &item.default {
            self.add(&item.sig, block);
        }
        visit::visit_trait_item_fn(self, item);
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        let name = match &*item.self_ty {
            syn::Type::Path(path) => path.path.segments.last().map(|segment| segment.ident.to_string()),
            _ => None,
        };
        self.within(name.unwrap_or_else(|| "impl".to_owned()), |own| visit::visit_item_impl(own, item));
    }

    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        self.within(item.ident.to_string(), |own| visit::visit_item_trait(own, item));
    }
}
