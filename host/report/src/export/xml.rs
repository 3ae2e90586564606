//! XML documents with a heading.

use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};

use super::heading;
use super::number::shortest;
use super::subject::ExportedResult;
use massline_result::{Error, Result};

/// A writer of elements.
pub(super) type Elements = Writer<Vec<u8>>;

/// A document with the heading as a comment and one element that `content` writes.
pub(super) fn document(
    exported: &ExportedResult,
    own: &str,
    content: impl FnOnce(&mut Elements) -> io::Result<()>,
) -> Result<Vec<u8>> {
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
    let lines = heading::lines(exported, own).join("\n  ");
    let write = |writer: &mut Elements| {
        writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        let comment = format!("\n  {}\n", commentable(&lines));
        writer.write_event(Event::Comment(BytesText::from_escaped(comment)))?;
        content(writer)
    };
    write(&mut writer).map_err(|e| Error::internal("xml", format!("XML is not written: {e}")))?;
    let mut bytes = writer.into_inner();
    bytes.push(b'\n');
    Ok(bytes)
}

/// The text with no two hyphens in a row, which would end a comment.
fn commentable(text: &str) -> String {
    let mut safe = String::new();
    for c in text.chars() {
        if c == '-' && safe.ends_with('-') {
            safe.push(' ');
        }
        safe.push(c);
    }
    safe
}

/// Numbers with blanks between them.
pub(super) fn numbers(values: impl IntoIterator<Item = f64>) -> String {
    values.into_iter().map(shortest).collect::<Vec<_>>().join(" ")
}

/// The title as the name of a link, body or model: letters, digits, `_`, `-` and `.` of any script, which ROS and
/// Gazebo accept in topics and frames. The simulators keep `world` and names that begin with `__` for themselves.
pub(super) fn name(title: &str) -> String {
    let fits = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.');
    let name: String = title.chars().map(|c| if fits(c) { c } else { ' ' }).collect();
    let name = name.split_whitespace().collect::<Vec<_>>().join("_");
    match name.trim_start_matches('_') {
        "" | "world" => "body".into(),
        _ if name.starts_with("__") => name.trim_start_matches('_').into(),
        _ => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_simulators_keep_for_themselves_are_not_used() {
        let names = ["world", "__model__", "_x", "  ", "a b", "world 2"].map(name);
        assert_eq!(names, ["body", "model__", "_x", "body", "a_b", "world_2"]);
    }
}
