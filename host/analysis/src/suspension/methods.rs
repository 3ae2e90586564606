//! The methods that use the suspension modes, asked one by one.

use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use massline_shared::identify::Method;
use massline_shared::identify::dppim::worse_form;
use massline_shared::identify::suspension::Answer;
use massline_shared::layout::HostLayout;
use massline_shared::modes::{Modes, Reduction};

use super::HostFit;

/// A method with a choice of modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// The method.
    pub method: Method,
    /// The modes.
    pub choice: ModeChoice,
}

/// The modes that a method gets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ModeChoice {
    /// All suspension modes, with shapes from all forces.
    #[default]
    All,
    /// The five of lowest frequency.
    Five,
    /// All of them, each with its shape from the force that shows it best.
    BestForce,
}

impl ModeChoice {
    fn of(self, modes: &Modes<f64>, memory: &Reduction<f64>) -> Option<Modes<f64>> {
        match self {
            Self::All => Some(modes.clone()),
            Self::Five => Some(modes.clone().first(5)),
            Self::BestForce => modes.of_best_forces(&memory.responses()),
        }
    }
}

/// Answers, and reasons where there is none.
pub struct ModalAnswers {
    /// The answers.
    pub answers: Vec<(Variant, Answer<f64>)>,
    /// The methods without an answer.
    pub not_applicable: Vec<(Method, Diagnostics)>,
    /// A form of the direct method that fits worse than the other, where it was asked for by name.
    pub warned: Option<(Method, Diagnostic)>,
}

impl ModalAnswers {
    /// Drops what these methods do not say.
    pub(super) fn keep(&mut self, wanted: &[Method]) {
        self.answers.retain(|(variant, _)| wanted.contains(&variant.method));
        self.not_applicable.retain(|(method, _)| wanted.contains(method));
    }
}

/// Asks every variant. Of the two forms of the direct method, the one that fits clearly worse is refused unless it is
/// asked for by name.
pub fn answered(
    fit: &HostFit<'_>,
    variants: &[Variant],
    named: bool,
    memory: &mut Reduction<f64>,
) -> ModalAnswers {
    let mut modal = ModalAnswers { answers: Vec::new(), not_applicable: Vec::new(), warned: None };
    for variant in variants {
        match answer(fit, fit.layout(), variant, memory, fit.modes()) {
            Ok(answer) => modal.answers.push((*variant, answer)),
            Err(reasons) => modal.not_applicable.push((variant.method, reasons)),
        }
    }
    refuse_other_damping(&mut modal, named);
    modal
}

fn refuse_other_damping(modal: &mut ModalAnswers, named: bool) {
    let misfit = |method: Method| {
        let answer = modal.answers.iter().find(|(variant, _)| variant.method == method);
        answer.and_then(|(_, answer)| answer.misfit)
    };
    let pair = misfit(Method::Dppim).zip(misfit(Method::DppimStructural));
    let Some((viscous, structural)) = pair else { return };
    let Some((worse, code, times)) = worse_form(viscous, structural) else { return };
    if named {
        modal.warned = Some((worse, Diagnostic::whole(code, Severity::Warning, times as f32)));
        return;
    }
    modal.answers.retain(|(variant, _)| variant.method != worse);
    let reason = Diagnostic::whole(code, Severity::Error, times as f32);
    modal.not_applicable.push((worse, Diagnostics::from_array([reason])));
}

/// The answer of a variant to these motions and modes.
pub(super) fn answer(
    fit: &HostFit<'_>,
    layout: &HostLayout,
    variant: &Variant,
    memory: &Reduction<f64>,
    modes: &Modes<f64>,
) -> Result<Answer<f64>, Diagnostics> {
    let chosen = variant.choice.of(modes, memory);
    let none = Diagnostic::whole(Code::SuspensionModesMissing, Severity::Error, 0.0);
    let modes = chosen.ok_or_else(|| Diagnostics::from_array([none]))?;
    fit.answer(variant.method, layout, memory, &modes)
}
