//! References between siblings, and the cycles among them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use crate::resolve::modules_of;
use crate::tree::Tree;

/// Result of the check of one tree.
#[derive(Debug)]
pub struct TreeCheck {
    /// Number of modules.
    pub modules: usize,
    /// Number of references from a module to another one that neither contains it nor is contained in it.
    pub references: usize,
    /// Siblings that refer to each other.
    pub cycles: Vec<Cycle>,
}

/// Siblings each of which refers, directly or by way of others, to every other.
#[derive(Debug)]
pub struct Cycle {
    /// The file of their parent.
    pub parent: PathBuf,
    /// Their names.
    pub children: Vec<String>,
    /// The references that form the cycle.
    pub references: Vec<Reference>,
}

/// A place in a module or its descendants that refers to a sibling or its descendants.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Reference {
    /// The name of the sibling that refers.
    pub from: String,
    /// The name of the sibling that is referred to.
    pub to: String,
    /// The file of the reference.
    pub file: PathBuf,
    /// Its line, counted from 1.
    pub line: usize,
}

impl TreeCheck {
    /// Checks a tree.
    pub fn of(tree: &Tree) -> Self {
        let references = references(tree);
        Self {
            modules: tree.modules.len(),
            references: references.values().map(BTreeSet::len).sum(),
            cycles: references
                .into_iter()
                .flat_map(|(parent, references)| cycles(tree, parent, &references))
                .collect(),
        }
    }
}

/// The references among the children of each parent. Where a module has a `use` for something, the paths
/// that rely on this `use` are not counted again.
fn references(tree: &Tree) -> BTreeMap<usize, BTreeSet<Reference>> {
    let mut references: BTreeMap<usize, BTreeSet<Reference>> = BTreeMap::new();
    for (id, module) in tree.modules.iter().enumerate() {
        let (imports, paths): (Vec<_>, Vec<_>) =
            module.code.mentions.iter().partition(|mention| mention.imported);
        let led_to = |mention| modules_of(tree, id, mention);
        let among = |to| siblings(tree, id, to);
        let imported: BTreeSet<_> =
            imports.iter().copied().flat_map(led_to).filter_map(among).collect();
        for mention in imports.iter().chain(&paths).copied() {
            for pair in led_to(mention).into_iter().filter_map(among) {
                if !mention.imported && imported.contains(&pair) {
                    continue;
                }
                let name = |id: usize| tree.modules[id].name.clone();
                let (parent, from, to) = (pair.0, name(pair.1), name(pair.2));
                let (file, line) = (module.file.clone(), mention.line);
                references.entry(parent).or_default().insert(Reference { from, to, file, line });
            }
        }
    }
    references
}

/// The common parent of two modules, and the siblings below it that are or contain them. `None` when one
/// of the modules contains the other.
fn siblings(tree: &Tree, from: usize, to: usize) -> Option<(usize, usize, usize)> {
    let (from, to) = (tree.lineage(from), tree.lineage(to));
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    Some((*from.get(common.checked_sub(1)?)?, *from.get(common)?, *to.get(common)?))
}

fn cycles(tree: &Tree, parent: usize, references: &BTreeSet<Reference>) -> Vec<Cycle> {
    let mut direct: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for reference in references {
        direct.entry(&reference.from).or_default().insert(&reference.to);
    }
    let reached: BTreeMap<_, _> =
        direct.keys().map(|&name| (name, reached_from(name, &direct))).collect();
    let reaches = |a: &str, b: &str| reached.get(a).is_some_and(|targets| targets.contains(b));
    let mut cycles: BTreeSet<Vec<&str>> = BTreeSet::new();
    for &name in direct.keys().filter(|&&name| reaches(name, name)) {
        let others = direct.keys().copied();
        cycles.insert(others.filter(|&b| reaches(name, b) && reaches(b, name)).collect());
    }
    let in_full = |children: Vec<&str>| Cycle {
        parent: tree.modules[parent].file.clone(),
        references: references
            .iter()
            .filter(|r| children.contains(&r.from.as_str()) && children.contains(&r.to.as_str()))
            .cloned()
            .collect(),
        children: children.into_iter().map(str::to_owned).collect(),
    };
    cycles.into_iter().map(in_full).collect()
}

fn reached_from<'a>(
    name: &'a str,
    direct: &BTreeMap<&'a str, BTreeSet<&'a str>>,
) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::new();
    let mut open = vec![name];
    while let Some(name) = open.pop() {
        for &next in direct.get(name).into_iter().flatten() {
            if reached.insert(next) {
                open.push(next);
            }
        }
    }
    reached
}
