use std::collections::HashMap;
use std::io;
use std::path::Path;

use super::*;

/// Checks sources given as paths and texts; the first is the root.
fn check(files: &[(&str, &str)]) -> TreeCheck {
    let texts: HashMap<&Path, &str> =
        files.iter().map(|(path, text)| (Path::new(*path), *text)).collect();
    let read = |path: &Path| {
        let text = texts.get(path).ok_or(io::ErrorKind::NotFound)?;
        Ok((*text).to_owned())
    };
    TreeCheck::of(&Tree::load(Path::new(files[0].0), &read).unwrap())
}

/// The children of every cycle.
fn cycles(files: &[(&str, &str)]) -> Vec<Vec<String>> {
    check(files).cycles.into_iter().map(|cycle| cycle.children).collect()
}

/// The children of every cycle between modules `a` and `b` with these texts below this root.
fn cycles_of(root: &str, a: &str, b: &str) -> Vec<Vec<String>> {
    cycles(&[("lib.rs", root), ("a.rs", a), ("b.rs", b)])
}

const ROOT: &str = "mod a; mod b;";

#[test]
fn references_in_one_direction_are_no_cycle() {
    let files = [
        ("lib.rs", "mod a; mod b; use a::A; fn f(_: A) { b::g() }"),
        ("a.rs", "use crate::b::B; pub struct A(B);"),
        ("b.rs", "pub struct B; pub fn g() {}"),
    ];
    let checked = check(&files);
    assert!(checked.cycles.is_empty());
    assert_eq!((checked.modules, checked.references), (3, 1));
}

#[test]
fn siblings_that_import_from_each_other_are_a_cycle_with_its_places() {
    let files = [
        ("lib.rs", ROOT),
        ("a.rs", "\nuse super::b::B;\npub struct A(B);"),
        ("b.rs", "pub struct B;\n\nuse crate::{a::A};"),
    ];
    let checked = check(&files);
    let [cycle] = &checked.cycles[..] else { panic!("{checked:?}") };
    assert_eq!(cycle.parent, Path::new("lib.rs"));
    assert_eq!(cycle.children, ["a", "b"]);
    let reference = |from: &str, to: &str, file: &str, line| cycles::Reference {
        from: from.into(),
        to: to.into(),
        file: file.into(),
        line,
    };
    assert_eq!(cycle.references, [reference("a", "b", "a.rs", 2), reference("b", "a", "b.rs", 3)]);
}

#[test]
fn a_re_export_of_the_parent_hides_no_cycle() {
    let root = "mod a; mod b; pub use a::A; pub use b::B as C;";
    assert_eq!(cycles_of(root, "use super::C; pub struct A;", "pub struct B(crate::A);").len(), 1);
    assert_eq!(cycles_of(root, "pub struct A;", "pub struct B(crate::A);").len(), 0);
}

#[test]
fn a_re_export_of_a_whole_module_hides_no_cycle() {
    let root = "mod a; mod b; pub use a::*; pub use b::*;";
    let (a, b) = ("use super::*; pub struct A(B);", "pub struct B; fn f() { super::A::new(); }");
    assert_eq!(cycles_of(root, a, b).len(), 1);
}

#[test]
fn bare_paths_count_in_expressions_types_and_patterns() {
    let b = "pub enum B { X } fn f() { crate::a::g() }";
    for a in [
        "pub fn g() { super::b::f(); }",
        "pub fn g(_: &[Option<super::b::B>]) {}",
        "pub fn g(x: X) { match x { crate::b::B::X => {} } }",
        "pub fn g() -> impl super::b::Trait {}",
        "use super::b; pub fn g() { b::f() }",
    ] {
        assert_eq!(cycles_of(ROOT, a, b).len(), 1, "{a}");
    }
}

#[test]
fn paths_in_macros_and_attributes_count() {
    let b = "pub struct B; use super::a::g;";
    for a in [
        "pub fn g() { assert!(x.y == (1, crate::b::B::new())); }",
        "macro_rules! m { () => { $crate::b::B } } pub fn g() {}",
        "#[derive(crate::b::B)] pub struct S; pub fn g() {}",
    ] {
        assert_eq!(cycles_of(ROOT, a, b).len(), 1, "{a}");
    }
}

#[test]
fn what_a_macro_makes_belongs_to_the_module_of_the_macro_call() {
    let root = "mod a; mod b; pub use a::Meters;";
    assert_eq!(cycles_of(root, "unit!(Meters); use super::b::B;", "use super::Meters;").len(), 1);
}

#[test]
fn code_for_tests_does_not_count() {
    let b = "pub struct B; use super::a::A;";
    for a in [
        "pub struct A; #[cfg(test)] mod tests { use crate::b::B; }",
        "pub struct A; #[cfg(test)] use crate::b::B;",
        "pub struct A; #[cfg(all(test, unix))] fn f(_: crate::b::B) {}",
        "pub struct A; #[test] fn f() { crate::b::f() }",
        "pub struct A; impl A { #[cfg(test)] fn f() { crate::b::f() } }",
    ] {
        assert_eq!(cycles_of(ROOT, a, b).len(), 0, "{a}");
    }
    let sometimes = "pub struct A; #[cfg(any(test, unix))] use crate::b::B;";
    assert_eq!(cycles_of(ROOT, sometimes, b).len(), 1);
}

#[test]
fn a_test_module_in_a_file_is_not_read() {
    let a = "pub struct A; #[cfg(test)] mod tests;";
    assert_eq!(cycles_of(ROOT, a, "use super::a::A;").len(), 0);
}

#[test]
fn a_module_and_its_children_may_refer_to_each_other() {
    let files = [
        ("lib.rs", "mod a; fn f() { a::c::g() }"),
        ("a/mod.rs", "pub mod c; use c::C; pub struct A(C);"),
        ("a/c.rs", "use super::A; use crate::f; pub struct C; pub fn g() {}"),
    ];
    assert!(cycles(&files).is_empty());
}

#[test]
fn a_reference_from_deep_inside_counts_for_the_siblings_around_it() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "mod c { use super::super::b::d::D; } pub struct A;"),
        ("b.rs", "pub mod d;"),
        ("b/d.rs", "use crate::a::A; pub struct D;"),
    ];
    assert_eq!(cycles(&files), [["a", "b"]]);
}

#[test]
fn a_cycle_may_go_over_three_modules() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c; mod d;"),
        ("a.rs", "use super::b;"),
        ("b.rs", "use super::{c as other, d};"),
        ("c.rs", "use crate::a;"),
        ("d.rs", ""),
    ];
    assert_eq!(cycles(&files), [["a", "b", "c"]]);
}

#[test]
fn paths_of_other_packages_and_variables_named_as_modules_do_not_count() {
    let a = "use super::*; use b_package::b::B; fn f() { let b = 1; g(b, ::b::X); x.b(b) }";
    assert_eq!(cycles_of(ROOT, a, "use super::a;").len(), 0);
}

#[test]
fn imports_that_lead_in_a_circle_end() {
    assert_eq!(cycles_of(ROOT, "pub use super::b::X;", "pub use super::a::X;").len(), 1);
}

#[test]
fn a_function_named_as_its_module_is_found_in_it() {
    let root = "mod a; mod b; pub use crate::a::a;";
    assert_eq!(cycles_of(root, "use super::b; pub fn a() {}", "use crate::a;").len(), 1);
}

#[test]
fn a_path_attribute_names_the_file_of_a_module() {
    let files = [
        ("src/lib.rs", "#[path = \"../other/x.rs\"] mod a; mod b;"),
        ("src/../other/x.rs", "use super::b;"),
        ("src/b.rs", "use super::a;"),
    ];
    assert_eq!(cycles(&files), [["a", "b"]]);
}

#[test]
fn a_module_with_a_file_for_each_system_has_the_first() {
    let each = "#[cfg_attr(unix, path = \"a/unix.rs\")] #[cfg_attr(not(unix), path = \"a/elsewhere.rs\")] mod a; mod \
         b;";
    let files =
        [("src/lib.rs", each), ("src/a/unix.rs", "use super::b;"), ("src/b.rs", "use super::a;")];
    assert_eq!(cycles(&files), [["a", "b"]]);
}

#[test]
fn a_missing_file_is_an_error_that_names_it() {
    let read = |path: &Path| match path.to_str() {
        Some("lib.rs") => Ok("mod a;".to_owned()),
        _ => Err(io::ErrorKind::NotFound.into()),
    };
    let error = Tree::load(Path::new("lib.rs"), &read).unwrap_err();
    assert_eq!(error.to_string(), "module a of lib.rs: a/mod.rs");
}
