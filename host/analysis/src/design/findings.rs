//! What a layout admits before its test: the methods of its profile, and the findings that concern it.

use massline_shared::Real;
use massline_shared::body::RigidBody;
use massline_shared::capacity::Capacity;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use massline_shared::identify::{Applicability, Method};
use massline_shared::layout::{HostLayout, Layout, TestProfile};

use super::methods_of;

/// A warning of a layout in the suspension profile that does not state gravity, which its sensors sense: the tilt of
/// the object is as large in their readings as its motion.
pub fn gravity_to_be_stated<R: Real, C: Capacity>(layout: &Layout<R, C>) -> Option<Diagnostic> {
    let lacks = layout.test.profile == TestProfile::Suspension && layout.lacks_gravity();
    lacks.then(|| Diagnostic::whole(Code::GravityNotGiven, Severity::Warning, 0.0))
}

/// What a layout admits.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutFindings {
    /// Findings about the layout; an error where none of the methods can work.
    pub diagnostics: Diagnostics,
    /// Rank and condition of the equations of mass lines; `None` in the suspension profile, whose methods do not solve
    /// them.
    pub equations: Option<(usize, f64)>,
    /// The methods of the test's profile, each with the codes that rule it out.
    pub methods: Vec<(Method, Vec<Code>)>,
}

impl LayoutFindings {
    /// What this layout admits for an object like this body.
    pub fn new(layout: &HostLayout, body: &RigidBody<f64>) -> Self {
        let profile = layout.test.profile;
        let methods = methods_of(profile);
        let applicability = Applicability::new(layout, body, &methods);
        let obstacles = |method| (method, applicability.obstacles(method).collect());
        let mut diagnostics = applicability.findings(profile);
        if let Some(finding) = gravity_to_be_stated(layout) {
            // There is room for sixteen diagnostics; a layout with as many does not lack a warning.
            let _ = diagnostics.push(finding);
        }
        Self {
            diagnostics,
            equations: match profile {
                TestProfile::MassLine => Some((applicability.rank, applicability.condition)),
                TestProfile::Suspension => None,
            },
            methods: methods.into_iter().map(obstacles).collect(),
        }
    }

    /// True when nothing rules out one of the methods.
    pub fn admits_any(&self) -> bool {
        self.methods.iter().any(|(_, obstacles)| obstacles.is_empty())
    }

    /// The same of a layout that admits methods but does not determine the ten properties with them: none of them
    /// applies.
    pub(super) fn without_answer(mut self) -> Self {
        for (_, obstacles) in &mut self.methods {
            if obstacles.is_empty() {
                obstacles.push(Code::TenParametersNotIdentifiable);
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::body_for_checks;
    use massline_files::layout_file::LayoutFile;

    #[test]
    fn the_suspension_profile_asks_for_gravity() {
        let text = include_str!("../../../examples/wheel.toml");
        let findings = |text: &str| {
            let file = LayoutFile::parse(text, "wheel.toml").unwrap();
            LayoutFindings::new(&file.layout, &body_for_checks(&file).0)
        };
        assert!(findings(text).diagnostics.is_empty());
        let gravity = "gravity = [0.0, 0.0, -9.80665]\n";
        assert!(text.contains(gravity));
        let without = findings(&text.replacen(gravity, "", 1));
        let warning = Diagnostic::whole(Code::GravityNotGiven, Severity::Warning, 0.0);
        assert_eq!(without.diagnostics.as_slice(), [warning]);
        // It is no obstacle: the rig measures all the same.
        assert!(without.admits_any());
        // A mass line has a term for it.
        let of_lines = text.replacen(gravity, "", 1).replacen("profile = \"suspension\"", "", 1);
        assert!(findings(&of_lines).diagnostics.is_empty());
    }
}
