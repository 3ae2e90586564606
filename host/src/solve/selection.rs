//! Selects the functions of a universal file for the sensors and hits of a layout.

use std::collections::{BTreeSet, HashMap};

use massline_shared::layout::HostLayout;

use super::missing;
use super::pair::{Key, Pair, key_of};
use crate::{Error, Result};
use massline_files::uff::{Function, UffFault, UffFile};

/// The names of the components of response and reference.
type Components<'a> = [&'a str; 2];

/// The functions of a file by what they are the response of.
pub(super) struct Selection<'a> {
    uff: &'a UffFile,
    functions: HashMap<Key, Vec<&'a Function>>,
    /// The components to use, where the file has the same pair of more than one.
    components: Option<Components<'a>>,
}

impl<'a> Selection<'a> {
    /// The functions of a file for a layout.
    pub(super) fn new(layout: &HostLayout, uff: &'a UffFile) -> Self {
        let mut functions: HashMap<Key, Vec<&Function>> = HashMap::new();
        for function in &uff.functions {
            functions.entry(key_of(function)).or_default().push(function);
        }
        let mut selection = Self { uff, functions, components: None };
        selection.components = selection.only_complete_components(layout);
        selection
    }

    /// The frequency responses of a pair, of all components.
    fn frequency_responses(&self, pair: &Pair) -> impl Iterator<Item = &'a Function> + '_ {
        let functions = self.functions.get(&pair.key()).into_iter().flatten().copied();
        functions.filter(|function| function.is_frequency_response())
    }

    /// The components that have each pair of the layout once, where some pair is there of several components and only
    /// these are complete.
    fn only_complete_components(&self, layout: &HostLayout) -> Option<Components<'a>> {
        let mut names = BTreeSet::new();
        let mut is_doubled = false;
        for pair in Pair::all(layout) {
            names.extend(self.frequency_responses(&pair).map(components));
            is_doubled |= self.frequency_responses(&pair).nth(1).is_some();
        }
        let is_complete = |wanted: &Components<'_>| {
            Pair::all(layout).all(|pair| {
                self.frequency_responses(&pair).filter(|f| components(f) == *wanted).count() == 1
            })
        };
        let mut complete = names.into_iter().filter(|_| is_doubled).filter(is_complete);
        complete.next().filter(|_| complete.next().is_none())
    }

    /// Says which components are used and which are not.
    pub(super) fn note(&self) -> Option<String> {
        let used = self.components?;
        let mut others: Vec<&str> = self.uff.functions.iter().flat_map(components).collect();
        others.sort_unstable();
        others.dedup();
        others.retain(|name| !used.contains(name));
        let list =
            |names: &[&str]| names.iter().map(|name| called(name)).collect::<Vec<_>>().join(", ");
        Some(format!(
            "the file has responses of several components at the same nodes: those of {} are used, those of {} are not",
            list(&used[..if used[0] == used[1] { 1 } else { 2 }]),
            list(&others)
        ))
    }

    /// The only frequency response of a pair.
    ///
    /// # Errors
    /// When there is none, or more than one.
    pub(super) fn find(&self, pair: &Pair) -> Result<&'a Function> {
        let is_used = |f: &&Function| self.components.is_none_or(|used| components(f) == used);
        let mut frfs = self.frequency_responses(pair).filter(is_used);
        let name = pair.name();
        match (frfs.next(), frfs.next()) {
            (Some(function), None) => Ok(function),
            (Some(first), Some(second)) => Err(doubled(&name, first, second)),
            (None, _) => {
                match self.functions.get(&pair.key()).and_then(|functions| functions.first()) {
                    Some(other) => {
                        let function_type = other.function_type;
                        let error = other.error(UffFault::FunctionType { found: function_type });
                        Err(Error::from(error).within(name))
                    }
                    None => Err(missing::error(self.uff, pair)),
                }
            }
        }
    }

    /// The coherence of a pair above 0 Hz, in ascending order of the frequency; `None` when the file has none.
    pub(super) fn coherence(&self, pair: &Pair) -> Option<Vec<f64>> {
        let function = self.functions.get(&pair.key())?.iter().find(|f| f.is_coherence())?;
        let pairs = function.abscissa.iter().zip(&function.ordinate);
        let mut points: Vec<(f64, f64)> =
            pairs.filter(|(f, _)| **f != 0.0).map(|(f, value)| (*f, value.re)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Some(points.into_iter().map(|(_, value)| value).collect())
    }
}

/// The names of the components of a function.
fn components(function: &Function) -> Components<'_> {
    function.components.each_ref().map(String::as_str)
}

/// A component in messages.
fn called(name: &str) -> String {
    if name.is_empty() { "no name".to_owned() } else { format!("{name:?}") }
}

fn doubled(name: &str, first: &Function, second: &Function) -> Error {
    let [one, other] = [first, second].map(components);
    let message = if one == other {
        format!(
            "the frequency response of {name} is there twice, in datasets {} and {}; remove one",
            first.dataset, second.dataset
        )
    } else {
        let describe = |[response, reference]: Components<'_>| {
            format!("{} due to {}", called(response), called(reference))
        };
        format!(
            "the frequency response of {name} is there of several components: of {} in dataset {} and of {} in dataset \
             {}, and the file does not tell which of them is the object; export the functions of the object alone",
            describe(one),
            first.dataset,
            describe(other),
            second.dataset
        )
    };
    Error::input("frf_doubled", message)
}
