//! Extracts the contents of one module: the names that it defines and imports, and the paths that it
//! mentions.

use std::collections::BTreeSet;

use proc_macro2::{TokenStream, TokenTree};
use syn::ext::IdentExt;
use syn::punctuated::Punctuated;
use syn::visit::{self, Visit};
use syn::{
    Attribute, Ident, ImplItemFn, Item, ItemMod, ItemUse, Macro, Meta, Path, Token, UseTree,
};

/// The code of one module, without its child modules and without test code.
#[derive(Debug, Default)]
pub struct Code {
    /// Names of its items, other than modules and imports.
    pub definitions: BTreeSet<String>,
    /// Names that a `use` imports one by one.
    pub imports: Vec<Import>,
    /// Paths of glob imports.
    pub globs: Vec<Vec<String>>,
    /// Every path, including those of `use`.
    pub mentions: Vec<Mention>,
}

/// A name that a `use` imports.
#[derive(Debug)]
pub struct Import {
    /// The name in this module.
    pub name: String,
    /// The path that it stands for, seen from this module.
    pub path: Vec<String>,
}

/// A path in the code.
#[derive(Debug)]
pub struct Mention {
    /// Its segments, without generic arguments.
    pub path: Vec<String>,
    /// True in a `use`, where a path may end at a module.
    pub imported: bool,
    /// Line, counted from 1.
    pub line: usize,
}

impl Code {
    /// Reads the items of a module.
    pub fn of(items: &[Item]) -> Self {
        let mut code = Self::default();
        items.iter().for_each(|item| code.visit_item(item));
        code
    }

    fn mention(&mut self, path: &[Ident], imported: bool) {
        if let Some(first) = path.first() {
            let line = first.span().start().line;
            self.mentions.push(Mention { path: texts(path), imported, line });
        }
    }

    /// The leaves of a `use` whose tree begins after `prefix`.
    fn import(&mut self, prefix: &mut Vec<Ident>, tree: &UseTree) {
        match tree {
            UseTree::Path(path) => {
                prefix.push(path.ident.clone());
                self.import(prefix, &path.tree);
                prefix.pop();
            }
            UseTree::Group(group) => {
                group.items.iter().for_each(|tree| self.import(prefix, tree));
            }
            UseTree::Glob(_) => {
                self.mention(prefix, true);
                self.globs.push(texts(prefix));
            }
            UseTree::Name(leaf) => self.import_as(prefix, &leaf.ident, None),
            UseTree::Rename(leaf) => self.import_as(prefix, &leaf.ident, Some(&leaf.rename)),
        }
    }

    fn import_as(&mut self, prefix: &[Ident], leaf: &Ident, rename: Option<&Ident>) {
        let mut path = prefix.to_vec();
        // `use parent::{self}` imports the parent.
        if leaf != "self" || path.is_empty() {
            path.push(leaf.clone());
        }
        self.mention(&path, true);
        let name = rename.or(path.last()).map_or_else(String::new, text);
        self.imports.push(Import { name, path: texts(&path) });
    }

    /// Collects the paths among unparsed tokens: the arguments of a macro or an attribute.
    fn scan(&mut self, tokens: TokenStream) {
        let mut path: Vec<Ident> = Vec::new();
        let (mut colons, mut behind_dot) = (0, false);
        for token in tokens {
            match token {
                TokenTree::Ident(ident) => {
                    if colons != 2 {
                        self.end_path(&mut path);
                    }
                    // A field, a method, or what follows generic arguments does not begin a path.
                    if !behind_dot && (colons != 2 || !path.is_empty()) {
                        path.push(ident);
                    }
                    (colons, behind_dot) = (0, false);
                }
                TokenTree::Punct(punct) if punct.as_char() == ':' => colons += 1,
                other => {
                    self.end_path(&mut path);
                    behind_dot = matches!(&other, TokenTree::Punct(p) if p.as_char() == '.');
                    colons = 0;
                    if let TokenTree::Group(group) = other {
                        self.scan(group.stream());
                    }
                }
            }
        }
        self.end_path(&mut path);
    }

    fn end_path(&mut self, path: &mut Vec<Ident>) {
        self.mention(path, false);
        path.clear();
    }
}

impl<'ast> Visit<'ast> for Code {
    fn visit_item(&mut self, item: &'ast Item) {
        if is_for_tests(attributes(item)) {
            return;
        }
        if let Some(name) = defined_name(item) {
            self.definitions.insert(text(name));
        }
        visit::visit_item(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast ImplItemFn) {
        if !is_for_tests(&item.attrs) {
            visit::visit_impl_item_fn(self, item);
        }
    }

    /// A child module has its own [`Code`].
    fn visit_item_mod(&mut self, _: &'ast ItemMod) {}

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        // A leading `::` makes it a path of another package.
        if item.leading_colon.is_none() {
            self.import(&mut Vec::new(), &item.tree);
        }
    }

    fn visit_path(&mut self, path: &'ast Path) {
        if path.leading_colon.is_none() {
            let segments: Vec<_> = path.segments.iter().map(|part| part.ident.clone()).collect();
            self.mention(&segments, false);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, item: &'ast Macro) {
        self.scan(item.tokens.clone());
        visit::visit_macro(self, item);
    }

    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        if let Meta::List(list) = &attribute.meta {
            self.scan(list.tokens.clone());
        }
        visit::visit_attribute(self, attribute);
    }
}

/// True for items that are compiled for tests only.
pub fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("test")
            || attribute.path().is_ident("cfg")
                && attribute.parse_args().is_ok_and(|condition| requires_test(&condition))
    })
}

fn requires_test(condition: &Meta) -> bool {
    match condition {
        Meta::Path(path) => path.is_ident("test"),
        Meta::List(list) if list.path.is_ident("all") => list
            .parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated)
            .is_ok_and(|conditions| conditions.iter().any(requires_test)),
        _ => false,
    }
}

fn text(ident: &Ident) -> String {
    ident.unraw().to_string()
}

fn texts(path: &[Ident]) -> Vec<String> {
    path.iter().map(text).collect()
}

fn defined_name(item: &Item) -> Option<&Ident> {
    match item {
        Item::Const(item) => Some(&item.ident),
        Item::Enum(item) => Some(&item.ident),
        Item::Fn(item) => Some(&item.sig.ident),
        Item::Macro(item) => item.ident.as_ref(),
        Item::Static(item) => Some(&item.ident),
        Item::Struct(item) => Some(&item.ident),
        Item::Trait(item) => Some(&item.ident),
        Item::TraitAlias(item) => Some(&item.ident),
        Item::Type(item) => Some(&item.ident),
        Item::Union(item) => Some(&item.ident),
        _ => None,
    }
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}
