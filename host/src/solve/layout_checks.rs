//! Whether a layout admits the methods, judged with an assumed body; what is expected of the object decides nothing.

use massline_shared::body::RigidBody;
use massline_shared::diagnosis::{Diagnostic, Diagnostics};
use massline_shared::identify::{Applicability, Method};
use massline_shared::layout::HostLayout;

use super::errors::first_error;
use crate::{Error, ErrorKind, Result};
use massline_files::layout_file::LayoutFile;
use massline_report::words::message_in;

/// The methods that the layout admits, and the others with the reasons.
pub(super) fn admitted(
    layout: &HostLayout,
    body: &RigidBody<f64>,
    methods: Vec<Method>,
) -> (Vec<Method>, Vec<(Method, Diagnostics)>) {
    let (mut admitted, mut blocked) = (Vec::new(), Vec::new());
    for method in methods {
        let checked = Applicability::new(layout, body, &[method]);
        if checked.admits(method) {
            admitted.push(method);
        } else {
            let reasons = checked.diagnostics.into_iter().filter(Diagnostic::is_error);
            blocked.push((method, reasons.collect()));
        }
    }
    (admitted, blocked)
}

/// Returns the error of a layout that rules out all of these methods.
pub(super) fn layout_problem(
    file: &LayoutFile,
    body: &RigidBody<f64>,
    about_body: &str,
    methods: &[Method],
) -> Result<()> {
    let layout = &file.layout;
    let checked = Applicability::new(layout, body, methods);
    match first_error(&checked.diagnostics, |d| message_in(d, layout)) {
        None => Ok(()),
        Some(Error { kind: kind @ ErrorKind::Undetermined, code, message }) => {
            Err(Error::new(kind, code, format!("{message} ({about_body})")))
        }
        Some(other) => Err(other),
    }
}
