//! The tree of the modules of one library or program, read from its files.

use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;
use syn::ext::IdentExt;
use syn::punctuated::Punctuated;
use syn::{Attribute, Expr, ExprLit, Item, ItemMod, Lit, Meta, Token};

use crate::code::{Code, is_for_tests};

/// Reads the text of a file.
pub type FileReader<'a> = &'a dyn Fn(&Path) -> io::Result<String>;

/// All modules; the first is the root.
#[derive(Debug, Default)]
pub struct Tree {
    /// All modules, each parent before its children.
    pub modules: Vec<Module>,
}

/// A module.
#[derive(Debug)]
pub struct Module {
    /// The last segment of its path; empty for the root.
    pub name: String,
    /// Index of the module that declares it; `None` for the root.
    pub parent: Option<usize>,
    /// The file that contains its code.
    pub file: PathBuf,
    /// The contents of its code.
    pub code: Code,
}

/// The location of a module and of its children's files.
struct Place {
    file: PathBuf,
    /// Folder of the child modules' files.
    folder: PathBuf,
    /// Folder that the path attribute of a child module is relative to.
    base: PathBuf,
}

impl Tree {
    /// Loads the modules reachable from the file `root`.
    ///
    /// # Errors
    /// When a file is missing or is not Rust.
    pub fn load(root: &Path, read: FileReader<'_>) -> anyhow::Result<Self> {
        let mut tree = Self::default();
        let text = read(root).with_context(|| root.display().to_string())?;
        tree.add_file("", None, Place::with_own_folder(root.to_owned()), &text, read)?;
        Ok(tree)
    }

    /// The child modules of this name.
    pub fn children_named(&self, module: usize, name: &str) -> impl Iterator<Item = usize> {
        let is_child = move |&id: &usize| {
            self.modules[id].parent == Some(module) && self.modules[id].name == name
        };
        (0..self.modules.len()).filter(is_child)
    }

    /// The module and all modules that contain it, beginning with the root.
    pub fn lineage(&self, module: usize) -> Vec<usize> {
        let mut lineage: Vec<_> =
            std::iter::successors(Some(module), |&id| self.modules[id].parent).collect();
        lineage.reverse();
        lineage
    }

    fn add_file(
        &mut self,
        name: &str,
        parent: Option<usize>,
        place: Place,
        text: &str,
        read: FileReader<'_>,
    ) -> anyhow::Result<()> {
        let file = syn::parse_file(text).with_context(|| place.file.display().to_string())?;
        if is_for_tests(&file.attrs) {
            return Ok(());
        }
        self.add(name, parent, place, &file.items, read)
    }

    fn add(
        &mut self,
        name: &str,
        parent: Option<usize>,
        place: Place,
        items: &[Item],
        read: FileReader<'_>,
    ) -> anyhow::Result<()> {
        let id = self.modules.len();
        let (name, file, code) = (name.to_owned(), place.file.clone(), Code::of(items));
        self.modules.push(Module { name, parent, file, code });
        for item in items {
            let Item::Mod(module) = item else { continue };
            if is_for_tests(&module.attrs) {
                continue;
            }
            let name = module.ident.unraw().to_string();
            match &module.content {
                Some((_, items)) => self.add(&name, Some(id), place.inline(&name), items, read)?,
                None => {
                    let (place, text) = place.find(module, &name, read)?;
                    self.add_file(&name, Some(id), place, &text, read)?;
                }
            }
        }
        Ok(())
    }
}

impl Place {
    /// A file in whose folder its child modules lie: a root, a `mod.rs`, or one named by a path
    /// attribute.
    fn with_own_folder(file: PathBuf) -> Self {
        let folder = file.parent().map(Path::to_owned).unwrap_or_default();
        Self { file, base: folder.clone(), folder }
    }

    /// A child module inside the same file.
    fn inline(&self, name: &str) -> Self {
        let folder = self.folder.join(name);
        Self { file: self.file.clone(), base: folder.clone(), folder }
    }

    /// A child module in a file of its own, and the text of that file.
    fn find(
        &self,
        module: &ItemMod,
        name: &str,
        read: FileReader<'_>,
    ) -> anyhow::Result<(Self, String)> {
        if let Some(path) = module.attrs.iter().find_map(path_attribute) {
            let file = self.base.join(path);
            let text = read(&file).with_context(|| file.display().to_string())?;
            return Ok((Self::with_own_folder(file), text));
        }
        let file = self.folder.join(format!("{name}.rs"));
        if let Ok(text) = read(&file) {
            let folder = self.folder.join(name);
            return Ok((Self { file, base: self.folder.clone(), folder }, text));
        }
        let file = self.folder.join(name).join("mod.rs");
        let text = read(&file).with_context(|| {
            format!("module {name} of {}: {}", self.file.display(), file.display())
        })?;
        Ok((Self::with_own_folder(file), text))
    }
}

/// The path of `#[path = "…"]`, or of `#[cfg_attr(…, path = "…")]` whatever its condition: of a module with one file
/// for each system the first is read.
fn path_attribute(attribute: &Attribute) -> Option<String> {
    if !attribute.path().is_ident("cfg_attr") {
        return path_of(&attribute.meta);
    }
    let parts = Punctuated::<Meta, Token![,]>::parse_terminated;
    attribute.parse_args_with(parts).ok()?.iter().skip(1).find_map(path_of)
}

fn path_of(meta: &Meta) -> Option<String> {
    let Meta::NameValue(pair) = meta else { return None };
    match &pair.value {
        Expr::Lit(ExprLit { lit: Lit::Str(path), .. }) if pair.path.is_ident("path") => {
            Some(path.value())
        }
        _ => None,
    }
}
