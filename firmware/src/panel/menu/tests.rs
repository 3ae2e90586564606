use super::*;
use crate::panel::PrecisionModel;
use crate::panel::calibration_wizard::{Proposal, WizardProblem};
use massline_shared::calibration::CalibrationSigma;
use proptest::prelude::*;
use std::collections::{BTreeSet, VecDeque};
use std::string::{String, ToString};

/// Presses of Back from the deepest screen: a question about a page of a list of home.
const DEEPEST: usize = 4;

fn model(phase: Phase) -> PanelModel {
    let idle = matches!(phase, Phase::Idle | Phase::Done);
    PanelModel { phase, idle, dofs: 3, wanted: 5, hits: 15, layouts: 1, ..PanelModel::START }
}

const PHASES: [Phase; 8] = [
    Phase::Idle,
    Phase::Armed,
    Phase::Busy,
    Phase::Confirming,
    Phase::Paused,
    Phase::Solving,
    Phase::Done,
    Phase::TargetReached,
];

const PROPOSAL: Proposal = Proposal {
    sound: true,
    hammer_ratio: None,
    sigma: CalibrationSigma { gain: 0.0, cross_axis: 0.0, hammer_gain: 0.0 },
};

fn calibration_wizards() -> impl Strategy<Value = CalibrationWizard> {
    prop_oneof![
        Just(CalibrationWizard::Off),
        (0..6_u8).prop_map(CalibrationWizard::Wanted),
        (0..6_u8).prop_map(CalibrationWizard::Reading),
        Just(CalibrationWizard::Wrong(WizardProblem::NotUsable)),
        Just(CalibrationWizard::Wrong(WizardProblem::Refused(RefusalReason::SamplerStopped))),
        Just(CalibrationWizard::Proposed(PROPOSAL)),
        Just(CalibrationWizard::Stored),
    ]
}

fn self_tests() -> impl Strategy<Value = SelfTestState> {
    prop_oneof![
        Just(SelfTestState::Off),
        (0..101_u8).prop_map(|percent| SelfTestState::Running { percent }),
        (0..17_u8, 0..11_u8)
            .prop_map(|(findings, channels)| SelfTestState::Done { findings, channels }),
        Just(SelfTestState::Disturbed),
    ]
}

prop_compose! {
    fn models()(
        phase in prop::sample::select(PHASES.to_vec()),
        (accepted, averaged, hits_done) in (0..6_u8, 0..16_u16, 0..16_u16),
        (findings, layouts, results, pages) in (0..17_u8, 0..5_u8, 0..9_u8, 0..22_u8),
        (interrupted, block, streaming) in any::<(bool, bool, bool)>(),
        (calibration_wizard, self_test) in (calibration_wizards(), self_tests()),
    ) -> PanelModel {
        let of_phase = model(phase);
        PanelModel {
            accepted, averaged, hits_done, findings, layouts, results, pages, interrupted, block, calibration_wizard,
            self_test,
            // The rig is not idle while it streams or takes a reading either.
            idle: of_phase.idle && !streaming,
            ..of_phase
        }
    }
}

fn buttons() -> impl Strategy<Value = Button> {
    prop::sample::select(std::vec![Button::Ok, Button::Back, Button::Next])
}

/// True when the phase permits the action; the rig may still refuse it for other reasons.
fn suits(action: Action, model: &PanelModel) -> bool {
    use Command as C;
    let phase = model.phase;
    match action {
        Action::Start => matches!(phase, Phase::Idle | Phase::Done),
        Action::Command(C::Accept | C::Reject) => phase == Phase::Confirming,
        Action::Command(C::Pause) => matches!(phase, Phase::Armed | Phase::Busy),
        Action::Command(C::Redo | C::Skip | C::Resume | C::Abort) => phase == Phase::Paused,
        Action::Command(C::Undo) => phase == Phase::Paused && model.averaged > 0,
        Action::Command(C::Finish) => phase == Phase::Paused && model.accepted > 0,
        Action::Command(C::Conclude | C::Continue) => phase == Phase::TargetReached,
        Action::StartBlock { decigrams } => model.idle && decigrams > 0,
        Action::UseProfile(_) => model.dofs > 0,
        Action::UseLayout(place) => model.idle && place < model.layouts,
        Action::OpenResult(place) => place < model.results,
        Action::OpenLast => phase == Phase::Done,
        Action::SolveBlock => phase == Phase::Done && model.block,
        Action::DeleteResult => model.pages > 0,
        Action::StartTumble | Action::StartSelfTest => model.idle,
        Action::StopSelfTest => model.self_test != SelfTestState::Off,
        Action::ReadPosition => matches!(
            model.calibration_wizard,
            CalibrationWizard::Wanted(_) | CalibrationWizard::Wrong(_)
        ),
        Action::KeepCalibration => {
            matches!(model.calibration_wizard, CalibrationWizard::Proposed(_))
        }
        Action::CancelCalibration => model.calibration_wizard != CalibrationWizard::Off,
        // Any phase: the rig refuses it while something is measured.
        Action::NextScreen => true,
    }
}

proptest! {
    #[test]
    fn whatever_is_pressed_the_menu_asks_only_for_what_the_phase_allows(
        steps in prop::collection::vec((models(), prop::collection::vec(buttons(), 0..6)), 1..40),
    ) {
        let mut menu = Menu::new();
        for (model, presses) in steps {
            menu.follow(&model);
            for button in presses {
                if let Some(action) = menu.press(button, &model) {
                    prop_assert!(suits(action, &model), "{action:?} in {model:?}");
                }
                let length = menu.length(&model).max(1);
                prop_assert!(menu.cursor() < length, "{menu:?}");
                menu.follow(&model);
            }
        }
    }

    #[test]
    fn back_leads_home_from_everywhere(
        steps in prop::collection::vec((models(), buttons()), 0..60),
        last in models(),
    ) {
        let mut menu = Menu::new();
        for (model, button) in steps {
            menu.follow(&model);
            menu.press(button, &model);
        }
        menu.follow(&last);
        for _ in 0..DEEPEST {
            menu.press(Button::Back, &last);
            // The rig carries out what Back requests: it discards the calibration in progress, and the self-test.
            let (calibration_wizard, self_test) = (CalibrationWizard::Off, SelfTestState::Off);
            menu.follow(&PanelModel { calibration_wizard, self_test, ..last });
        }
        prop_assert_eq!(menu.screen(), Screen::Home);
    }

    #[test]
    fn the_mass_of_the_block_stays_within_its_digits(presses in prop::collection::vec(buttons(), 0..200)) {
        let mut menu = Menu { screen: Screen::BlockMass, ..Menu::new() };
        let model = model(Phase::Idle);
        for button in presses {
            menu.press(button, &model);
            prop_assert!(menu.decigrams() < 1_000_000);
        }
    }
}

/// Name of a screen and, where it matters, of what it shows.
fn name(menu: &Menu, model: &PanelModel) -> String {
    let screen = std::format!("{:?}", menu.screen());
    match menu.screen() {
        Screen::Measure => std::format!("{screen} {:?}", model.phase),
        _ => screen,
    }
}

/// Presses every button on every screen and simulates the rig's reaction, until no new state is found.
#[test]
fn every_screen_is_reached_by_buttons_alone() {
    let mut seen = BTreeSet::new();
    let mut visited = BTreeSet::new();
    let start = PanelModel { results: 2, findings: 1, ..model(Phase::Idle) };
    let mut open = VecDeque::from([(Menu::new(), start)]);
    while let Some((mut menu, model)) = open.pop_front() {
        menu.follow(&model);
        if !visited.insert(std::format!("{menu:?} {model:?}")) {
            continue;
        }
        seen.insert(name(&menu, &model));
        // Digits and pages do not lead to new screens.
        for button in [Button::Ok, Button::Back, Button::Next] {
            let mut next = menu;
            if let Some(action) = next.press(button, &model) {
                open.extend(outcomes(action, next, &model));
            } else if next.decigrams() == menu.decigrams() {
                open.push_back((next, model));
            }
        }
    }
    let phases =
        ["Idle", "Armed", "Busy", "Confirming", "Paused", "Solving", "Done", "TargetReached"];
    let others = [
        "Home",
        "Findings",
        "Precision",
        "Profile",
        "Layouts",
        "Results",
        "Result",
        "Calibration",
        "BlockMass",
        "CalibrationWizard",
        "SelfTest",
        "Storage",
        "About",
        "Sure(End)",
        "Sure(Redo)",
        "Sure(Delete)",
        "Refused(StoreFull)",
        "Refused(NothingToUndo)",
    ];
    let screens = phases.map(|phase| std::format!("Measure {phase}")).into_iter();
    for screen in screens.chain(others.map(|screen| screen.to_string())) {
        assert!(seen.contains(&screen), "{screen} is not reached: {seen:?}");
    }
}

/// Possible outcomes of an action.
fn outcomes(action: Action, menu: Menu, model: &PanelModel) -> std::vec::Vec<(Menu, PanelModel)> {
    use Command as C;
    let with = |phase| PanelModel {
        results: model.results,
        findings: 1,
        accepted: 1,
        averaged: 1,
        precision: Some(PrecisionModel { dofs: 1, widths: None, further: None }),
        ..self::model(phase)
    };
    let at = |screen| {
        let mut menu = menu;
        menu.open(screen);
        menu
    };
    let refused = |reason| {
        let mut menu = menu;
        menu.refuse(reason);
        (menu, *model)
    };
    match action {
        Action::Start | Action::Command(C::Resume) | Action::StartBlock { .. } => std::vec![
            (menu, with(Phase::Armed)),
            (menu, with(Phase::Busy)),
            (menu, with(Phase::Confirming)),
            (menu, with(Phase::Solving)),
            (menu, with(Phase::Done)),
            (menu, with(Phase::TargetReached)),
            (menu, PanelModel { interrupted: true, ..with(Phase::Paused) }),
            refused(RefusalReason::StoreFull),
            refused(RefusalReason::LayoutRefused),
        ],
        Action::Command(C::Pause | C::Redo | C::Skip | C::Finish) => {
            std::vec![(menu, with(Phase::Paused))]
        }
        Action::Command(C::Undo) => {
            std::vec![(menu, with(Phase::Paused)), refused(RefusalReason::NothingToUndo)]
        }
        Action::Command(C::Abort) => std::vec![(menu, with(Phase::Idle))],
        Action::Command(C::Conclude) => std::vec![(menu, with(Phase::Solving))],
        Action::Command(C::Continue) => std::vec![(menu, with(Phase::Armed))],
        Action::Command(C::Accept | C::Reject) => std::vec![(menu, with(Phase::Armed))],
        Action::OpenResult(_) | Action::OpenLast => {
            std::vec![(at(Screen::Result), PanelModel { pages: 2, ..*model })]
        }
        Action::DeleteResult => std::vec![(menu, PanelModel { pages: 0, results: 1, ..*model })],
        Action::StartTumble | Action::ReadPosition => {
            let calibration_wizard = |calibration_wizard| {
                (at(Screen::CalibrationWizard), PanelModel { calibration_wizard, ..*model })
            };
            std::vec![
                calibration_wizard(CalibrationWizard::Wanted(1)),
                calibration_wizard(CalibrationWizard::Proposed(PROPOSAL))
            ]
        }
        Action::StartSelfTest => {
            let state = |self_test| (at(Screen::SelfTest), PanelModel { self_test, ..*model });
            std::vec![
                state(SelfTestState::Running { percent: 50 }),
                state(SelfTestState::Disturbed),
                state(SelfTestState::Done { findings: 2, channels: 10 }),
            ]
        }
        Action::StopSelfTest => {
            std::vec![(menu, PanelModel { self_test: SelfTestState::Off, ..*model })]
        }
        Action::SolveBlock => {
            let calibration_wizard = CalibrationWizard::Proposed(PROPOSAL);
            std::vec![(at(Screen::CalibrationWizard), PanelModel { calibration_wizard, ..*model })]
        }
        Action::KeepCalibration => std::vec![(
            menu,
            PanelModel { calibration_wizard: CalibrationWizard::Stored, ..*model }
        )],
        Action::CancelCalibration => {
            std::vec![(menu, PanelModel { calibration_wizard: CalibrationWizard::Off, ..*model })]
        }
        Action::UseLayout(_) => std::vec![(menu, *model)],
        Action::UseProfile(_) => std::vec![(at(Screen::Measure), *model)],
        Action::NextScreen => std::vec![(menu, *model), refused(RefusalReason::WrongPhase)],
    }
}

#[test]
fn a_campaign_that_the_host_starts_comes_to_the_front() {
    let mut menu = Menu { screen: Screen::About, ..Menu::new() };
    menu.follow(&model(Phase::Armed));
    assert_eq!(menu.screen(), Screen::Measure);
    // The menu does not return by itself to an operator who has left, but the rig does not wait for a hit
    // meanwhile.
    let action = menu.press(Button::Back, &model(Phase::Armed));
    assert_eq!(action, Some(Action::Command(Command::Pause)));
    menu.follow(&model(Phase::Paused));
    assert_eq!(menu.screen(), Screen::Home);
}

#[test]
fn at_its_target_a_paused_campaign_offers_only_what_it_can_do() {
    let paused = PanelModel { accepted: 5, averaged: 5, at_target: true, ..model(Phase::Paused) };
    let menu = Menu { screen: Screen::Measure, phase: Phase::Paused, ..Menu::new() };
    assert_eq!(menu.entries(&paused), [Entry::Resume, Entry::Undo, Entry::End]);
}

#[test]
fn a_paused_campaign_offers_to_undo_a_hit_once_there_is_one() {
    let menu = Menu { screen: Screen::Measure, phase: Phase::Paused, ..Menu::new() };
    for (averaged, hits_done, offered) in
        [(0, 0, false), (1, 1, true), (5, 10, true), (15, 15, false)]
    {
        let paused = PanelModel { averaged, hits_done, ..model(Phase::Paused) };
        let entries = menu.entries(&paused);
        assert_eq!(entries.contains(&Entry::Undo), offered, "{averaged} hits: {entries:?}");
    }
    // The longest list.
    let precision = Some(PrecisionModel { dofs: 1, widths: None, further: None });
    let longest =
        PanelModel { averaged: 7, accepted: 2, findings: 1, precision, ..model(Phase::Paused) };
    assert!(menu.entries(&longest).is_full());
}

#[test]
fn an_interruption_by_the_rig_says_why_at_once() {
    let mut menu = Menu { screen: Screen::Measure, phase: Phase::Armed, ..Menu::new() };
    menu.follow(&PanelModel { interrupted: true, findings: 1, ..model(Phase::Paused) });
    assert_eq!(menu.screen(), Screen::Findings);
}

#[test]
fn nothing_is_lost_without_a_question() {
    let paused = PanelModel { accepted: 2, ..model(Phase::Paused) };
    let mut menu = Menu { screen: Screen::Measure, phase: Phase::Paused, ..Menu::new() };
    let entries = menu.entries(&paused);
    let end = entries.iter().position(|&entry| entry == Entry::End).unwrap();
    for _ in 0..end {
        assert_eq!(menu.press(Button::Next, &paused), None);
    }
    assert_eq!(menu.press(Button::Ok, &paused), None);
    assert_eq!(menu.screen(), Screen::Sure(Question::End));
    assert_eq!(menu.press(Button::Back, &paused), None);
    assert_eq!(menu.screen(), Screen::Measure);
}

#[test]
fn a_mass_is_typed_in_digit_by_digit() {
    let idle = model(Phase::Idle);
    let mut menu = Menu { screen: Screen::BlockMass, decigrams: 0, ..Menu::new() };
    // Sets the thousands of grams to 2, and the tenths of a gram to 1, past 9.
    let presses = "on count count on on on on count count count count count count count count count \
                   count count on";
    let mut action = None;
    for word in presses.split_whitespace() {
        let button = if word == "on" { Button::Ok } else { Button::Next };
        action = menu.press(button, &idle);
    }
    assert_eq!(action, Some(Action::StartBlock { decigrams: 20_001 }));
    assert_eq!(menu.screen(), Screen::Measure);
}
