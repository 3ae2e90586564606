//! `--method`: one of the methods, by its short name.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use massline_shared::identify::Method;

use massline_analysis::identification::Selection;

/// The methods that can be applied to a rig's measurement.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct MethodArgs {
    #[arg(
        long,
        value_name = "METHOD",
        value_parser = one_of(Method::of_mass_lines()),
        help = help(Method::of_mass_lines())
    )]
    method: Option<Method>,
}

impl MethodArgs {
    /// The selected methods.
    pub fn selection(self) -> Selection {
        selection(self.method)
    }
}

/// One method, or all that answer without being named.
pub(crate) fn selection(method: Option<Method>) -> Selection {
    method.map_or(Selection::All, Selection::Only)
}

/// A parser for the short names of these methods, in the order of their numbers.
pub(crate) fn one_of(
    methods: impl IntoIterator<Item = Method>,
) -> impl TypedValueParser<Value = Method> {
    let mut methods: Vec<Method> = methods.into_iter().collect();
    methods.sort_by_key(|method| method.number());
    let value = |method: &Method| {
        let entry = method.entry();
        PossibleValue::new(entry.short_name).help(entry.summary)
    };
    let names = PossibleValuesParser::new(methods.iter().map(value).collect::<Vec<_>>());
    names.try_map(move |name| {
        let named = methods.iter().find(|method| method.entry().short_name == name).copied();
        named.ok_or("there is no method of this name")
    })
}

/// The value of `--method` for all methods that apply.
pub(crate) const ALL: &str = "all";

/// A parser for `all` and the short names of all methods, in the order of their numbers.
pub(crate) fn one_or_all() -> impl TypedValueParser<Value = Selection> {
    let mut methods: Vec<Method> = Method::ALL.to_vec();
    methods.sort_by_key(|method| method.number());
    let all_methods =
        PossibleValue::new(ALL).help("All that apply to the file, compared with each other");
    let values = methods.iter().map(|method| {
        let entry = method.entry();
        PossibleValue::new(entry.short_name).help(entry.summary)
    });
    let names = PossibleValuesParser::new(std::iter::once(all_methods).chain(values));
    names.map(move |name| {
        let named = methods.iter().find(|method| method.entry().short_name == name);
        named.map_or(Selection::All, |method| Selection::Only(*method))
    })
}

/// The help of `--method`, with the methods that answer by default.
pub(crate) fn help(usual: impl IntoIterator<Item = Method>) -> String {
    let titles = usual.into_iter().map(|method| method.entry().title.to_lowercase());
    format!("One method alone; default: {}", titles.collect::<Vec<_>>().join(", then "))
}
