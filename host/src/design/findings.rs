//! What a layout admits before its test: the methods of its profile, and the findings that concern it.

use massline_shared::body::RigidBody;
use massline_shared::diagnosis::{Code, Diagnostics};
use massline_shared::identify::{Applicability, Method};
use massline_shared::layout::{HostLayout, TestProfile};

use super::methods_of;

/// What a layout admits.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutFindings {
    /// Findings about the layout; an error where none of the methods can work.
    pub diagnostics: Diagnostics,
    /// Rank and condition of the equations of mass lines; `None` in the suspension profile, whose methods do not solve them.
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
        Self {
            diagnostics: applicability.findings(profile),
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

    /// The same of a layout that admits methods but does not determine the ten properties with them: none of them applies.
    pub(super) fn without_answer(mut self) -> Self {
        for (_, obstacles) in &mut self.methods {
            if obstacles.is_empty() {
                obstacles.push(Code::TenParametersNotIdentifiable);
            }
        }
        self
    }
}
