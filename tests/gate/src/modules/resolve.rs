//! Resolves a path in the code to the modules that it leads to.

use std::collections::BTreeSet;

use crate::code::Mention;
use crate::tree::Tree;

/// Meaning of a name.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Meaning {
    Module(usize),
    /// An item that this module defines.
    ItemOf(usize),
}

impl Meaning {
    fn module(self) -> usize {
        let (Self::Module(module) | Self::ItemOf(module)) = self;
        module
    }
}

/// The modules along a path, and the one that defines the item it leads to. Empty for a path into another
/// package.
pub fn modules_of(tree: &Tree, from: usize, mention: &Mention) -> BTreeSet<usize> {
    let mut names = Names { tree, in_progress: Vec::new() };
    let mut named = BTreeSet::new();
    let meanings = names.follow(from, &mention.path, &mut named);
    if mention.path.len() == 1 && !mention.imported {
        // A bare name in an expression may be a variable, but not a module.
        let items = meanings.iter().filter(|meaning| matches!(meaning, Meaning::ItemOf(_)));
        return items.map(|meaning| meaning.module()).collect();
    }
    named
}

struct Names<'a> {
    tree: &'a Tree,
    /// Modules and names that are being looked up, because imports may form a cycle.
    in_progress: Vec<(usize, String)>,
}

impl Names<'_> {
    /// Resolves a path seen from a module; `named` collects the modules along it.
    fn follow(
        &mut self,
        from: usize,
        path: &[String],
        named: &mut BTreeSet<usize>,
    ) -> Vec<Meaning> {
        let Some((first, rest)) = path.split_first() else { return Vec::new() };
        let mut meanings = match self.keyword(from, first) {
            Some(module) => vec![Meaning::Module(module)],
            None => self.look_up(from, first),
        };
        named.extend(meanings.iter().map(|meaning| meaning.module()));
        for name in rest {
            let modules: BTreeSet<_> = meanings
                .iter()
                .filter(|meaning| matches!(meaning, Meaning::Module(_)))
                .map(|meaning| meaning.module())
                .collect();
            if modules.is_empty() {
                // A variant or an associated item belongs to the module of its type.
                return meanings;
            }
            meanings = modules.iter().flat_map(|&module| self.member(module, name)).collect();
            named.extend(meanings.iter().map(|meaning| meaning.module()));
        }
        meanings
    }

    fn member(&mut self, module: usize, name: &str) -> Vec<Meaning> {
        if let Some(module) = self.keyword(module, name) {
            return vec![Meaning::Module(module)];
        }
        let circular = self.is_in_progress(module, name);
        let meanings = self.look_up(module, name);
        // A name without a declaration is defined there by a macro.
        if meanings.is_empty() && !circular { vec![Meaning::ItemOf(module)] } else { meanings }
    }

    fn keyword(&self, module: usize, name: &str) -> Option<usize> {
        match name {
            "crate" => Some(0),
            "self" => Some(module),
            "super" => self.tree.modules[module].parent,
            _ => None,
        }
    }

    fn is_in_progress(&self, module: usize, name: &str) -> bool {
        self.in_progress.iter().any(|(from, entry)| *from == module && entry == name)
    }

    /// Resolves a name in a module: its own items, child modules and imports, then glob imports.
    fn look_up(&mut self, module: usize, name: &str) -> Vec<Meaning> {
        if self.is_in_progress(module, name) {
            return Vec::new();
        }
        self.in_progress.push((module, name.to_owned()));
        let tree = self.tree;
        let code = &tree.modules[module].code;
        let mut meanings: Vec<_> = tree.children_named(module, name).map(Meaning::Module).collect();
        if code.definitions.contains(name) {
            meanings.push(Meaning::ItemOf(module));
        }
        let mut declared = !meanings.is_empty();
        for import in code.imports.iter().filter(|import| import.name == name) {
            declared = true;
            meanings.extend(self.follow(module, &import.path, &mut BTreeSet::new()));
        }
        if !declared {
            for glob in &code.globs {
                for meaning in self.follow(module, glob, &mut BTreeSet::new()) {
                    if let Meaning::Module(from) = meaning {
                        meanings.extend(self.look_up(from, name));
                    }
                }
            }
        }
        self.in_progress.pop();
        meanings
    }
}
