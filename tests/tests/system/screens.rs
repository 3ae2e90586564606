//! Every screen of the panel as a picture.

use crate::pictures;
use massline_files::layout_file::LayoutFile;
use massline_firmware::board::{
    BoardInfo, BootReason, BrownOut, Circuit, Clock, NO_CONVERTER_FAULT, ScreenSetting, StackUse,
    Supply,
};
use massline_firmware::panel::calibration_wizard::{CalibrationWizard, Proposal, WizardProblem};
use massline_firmware::panel::draw::{LayoutLine, View, draw};
use massline_firmware::panel::menu::{ABOUT_PAGES, Menu, Question, Screen};
use massline_firmware::panel::refused::RefusalReason;
use massline_firmware::panel::self_test::SelfTestState;
use massline_firmware::panel::summary::Summary;
use massline_firmware::panel::{Button, FurtherPlace, HitVerdict, PanelModel, PrecisionModel};
use massline_firmware::store::RESULTS;
use massline_protocol::message::{Battery, EstimatedMass, ResultEntry, Stats};
use massline_protocol::object::StoredEstimate;
use massline_shared::body::RigidBody;
use massline_shared::calibration::CalibrationSigma;
use massline_shared::calibration::tumble::{Position, TumbleProblem};
use massline_shared::design::Widths;
use massline_shared::diagnosis::Setting;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use massline_shared::identify::maximum_likelihood::{BudgetScales, LearnedBudget, LearnedFrom};
use massline_shared::identify::{Consistency, Method, Verdict};
use massline_shared::layout::{RigLayout, TestProfile};
use massline_shared::measurement::campaign::Phase;
use massline_shared::signal::Swing;
use massline_shared::signal::self_test::ChannelAtRest;
use massline_virtual::framebuffer::Framebuffer;

/// The state of a rig that is drawn on a screen.
struct Rig {
    model: PanelModel,
    layout: Option<RigLayout>,
    layouts: Vec<LayoutLine>,
    results: Vec<ResultEntry>,
    summary: Option<Summary>,
    findings: Vec<Diagnostic>,
    at_rest: Vec<ChannelAtRest<f32>>,
    info: BoardInfo,
    stats: Stats,
}

impl Rig {
    fn new() -> Self {
        let file = include_str!("../../../host/examples/three-bar-test-1.toml");
        let layout = LayoutFile::parse(file, "test").unwrap().rig_layout().unwrap();
        let line = |title: &str, profile, in_use| LayoutLine {
            hash: 1,
            title: title.try_into().unwrap(),
            in_use,
            profile,
        };
        let model = PanelModel {
            dof: Some((1, layout.hits[1].dof)),
            accepted: 2,
            wanted: 5,
            dofs: 3,
            hits_done: 7,
            hits: 15,
            seconds_left: Some(130),
            levels: [1, 2, 1, 3, 5, 7, 10, 12, 2, 0],
            mass: Some(EstimatedMass { value: 1.2294, sigma: Some(0.0293) }),
            result: 3,
            ..PanelModel::START
        };
        Self {
            model,
            layout: Some(layout),
            layouts: vec![
                line("three-bar frame, test 1", TestProfile::MassLine, true),
                line("wheel", TestProfile::Suspension, false),
            ],
            results: (1..=3).rev().map(entry).collect(),
            summary: None,
            findings: Vec::new(),
            at_rest: Vec::new(),
            info: BoardInfo {
                name: "blackpill-f411",
                firmware: "0.1.0",
                git_hash: "0123456789abcdef",
                git_dirty: true,
                boot_reason: BootReason::PowerOn,
                last_panic: "",
                clock: Clock::Crystal,
                supply: Supply::STEADY,
                circuit: Circuit::default(),
                converter_fault: NO_CONVERTER_FAULT,
                stack: StackUse::default,
            },
            stats: Stats {
                uptime_ms: 4_321_000,
                stack_high_water: 21_964,
                stack_size: 24_576,
                triggers: 17,
                ..Stats::default()
            },
        }
    }

    fn at(phase: Phase) -> Self {
        let mut rig = Self::new();
        rig.model.phase = phase;
        rig.model.idle = matches!(phase, Phase::Idle | Phase::Done);
        rig
    }

    /// Draws a screen after pressing `Next` this many times and compares it with its picture.
    fn show(mut self, name: &str, screen: Screen, next: usize) {
        self.model.findings = self.findings.len() as u8;
        self.model.layouts = self.layouts.len() as u8;
        self.model.results = self.results.len() as u8;
        self.model.pages = self.summary.as_ref().map_or(0, Summary::pages);
        let mut menu = Menu::new();
        menu.follow(&self.model);
        menu.open(screen);
        for _ in 0..next {
            menu.press(Button::Next, &self.model);
        }
        let mut framebuffer = Framebuffer::default();
        let view = View {
            menu: &menu,
            model: &self.model,
            layout: self.layout.as_ref(),
            layout_hash: 7,
            layouts: &self.layouts,
            results: &self.results,
            summary: self.summary.as_ref(),
            findings: &self.findings,
            at_rest: &self.at_rest,
            info: &self.info,
            stats: &self.stats,
            screen: ScreenSetting::Sh1106,
        };
        draw(&view, &mut framebuffer);
        pictures::check(name, &framebuffer, &[]);
    }
}

fn entry(number: u32) -> ResultEntry {
    let mass = EstimatedMass { value: 1.2294 * number as f32, sigma: Some(0.0293) };
    ResultEntry { number, layout_hash: 7, mass: (number != 2).then_some(mass), length: 1000 }
}

fn diagnostic(code: Code, severity: Severity, subject: Subject, value: f32) -> Diagnostic {
    Diagnostic::about(code, severity, subject, value)
}

/// The result of the first test of the three-bar frame, as shown in the README.
fn summary() -> Summary {
    let sigmas =
        [0.0293, 0.000_91, 0.001_27, 0.001_08, 3.1e-4, 1.9e-4, 3.6e-4, 1.4e-4, 0.7e-4, 1.1e-4];
    let mut covariance = heapless::Vec::new();
    for row in 0..10 {
        for column in 0..=row {
            let variance = if row == column { sigmas[row] * sigmas[row] } else { 0.0 };
            covariance.push(variance).unwrap();
        }
    }
    let estimate = StoredEstimate {
        method: Method::MaximumLikelihood.number(),
        properties: [
            1.2294, 0.168_73, -0.089_45, 0.018_89, 0.011_011, 0.006_839, 0.013_882, 0.004_235,
            -0.000_962, 0.002_692,
        ],
        covariance,
        condition: 8.604,
        consistency: Some(Consistency { chi_squared: 12.4, degrees_of_freedom: 17 }),
        learned: Some(LearnedBudget {
            scales: BudgetScales { hit_position: 0.6, hit_direction: 0.56, constant: 0.62 },
            scatter_degrees_of_freedom: 40,
            learned_from: LearnedFrom::RepeatHits,
            constant_log_variance: 0.04,
            widening: [1.0; 10],
        }),
        diagnostics: Diagnostics::new(),
    };
    let findings = [
        diagnostic(Code::LargeSensorPull, Severity::Note, Subject::Sensor(1), 1.7),
        diagnostic(Code::NoPlateau, Severity::Warning, Subject::response(1, 5), 0.031),
    ];
    Summary {
        number: 3,
        layout_hash: 7,
        answer: estimate.estimate(),
        verdict: Some(Verdict::UseWithCare),
        places_with_lines: 0,
        findings: findings.into_iter().collect(),
    }
}

#[test]
fn a_result_that_the_program_solves_looks_as_its_picture() {
    let lines = Summary { answer: None, places_with_lines: 6, ..summary() };
    Rig { summary: Some(lines), ..Rig::new() }.show("result-lines", Screen::Result, 0);
}

#[test]
fn what_is_measured_looks_as_its_pictures() {
    Rig::at(Phase::Idle).show("profile", Screen::Profile, 1);
    let mut rig = Rig::at(Phase::Idle);
    rig.layout.as_mut().unwrap().test.profile = TestProfile::Suspension;
    rig.show("measure-idle-modes", Screen::Measure, 0);
    let mut rig = Rig::at(Phase::Solving);
    rig.model.profile = TestProfile::Suspension;
    rig.show("storing", Screen::Measure, 0);
    for (name, reason) in [
        ("refused-room", RefusalReason::TooLittleRoom(12)),
        ("refused-room-one", RefusalReason::TooLittleRoom(1)),
        ("refused-room-none", RefusalReason::TooLittleRoom(0)),
        ("refused-block", RefusalReason::BlockNeedsMassLines),
    ] {
        Rig::new().show(name, Screen::Refused(reason), 0);
    }
}

fn verdict(reason: Option<Diagnostic>) -> Option<HitVerdict> {
    Some(HitVerdict { peak_force: 152.3, swing: None, reason })
}

#[test]
fn the_home_screen_looks_as_its_pictures() {
    for (name, millivolts, percent) in [("home-charge", 3840, 64), ("home-charge-low", 3470, 4)] {
        let mut rig = Rig::at(Phase::Idle);
        rig.model.battery = Some(Battery { millivolts, percent });
        rig.show(name, Screen::Home, 0);
    }
    Rig::at(Phase::Idle).show("home", Screen::Home, 0);
    Rig::at(Phase::Paused).show("home-end-of-list", Screen::Home, 5);
}

#[test]
fn the_screens_before_a_campaign_look_as_their_pictures() {
    Rig::at(Phase::Idle).show("measure-idle", Screen::Measure, 0);
    let without = Rig { layout: None, layouts: Vec::new(), ..Rig::at(Phase::Idle) };
    without.show("measure-no-layout", Screen::Measure, 0);
}

#[test]
fn the_screens_that_ask_for_a_hit_look_as_their_pictures() {
    Rig::at(Phase::Armed).show("armed", Screen::Measure, 0);
    let mut rig = Rig::at(Phase::Armed);
    rig.model.verdict = verdict(None);
    rig.show("armed-after-good", Screen::Measure, 0);
    let mut rig = Rig::at(Phase::Busy);
    rig.model.verdict = verdict(None);
    rig.show("busy", Screen::Measure, 0);
    let mut rig = Rig::at(Phase::Armed);
    rig.model.dof = Some((11, "65535:-Z".parse().unwrap()));
    (rig.model.dofs, rig.model.accepted, rig.model.wanted) = (12, 49, 50);
    rig.model.seconds_left = Some(u16::MAX);
    rig.show("armed-longest", Screen::Measure, 0);
}

#[test]
fn a_rejected_hit_says_why() {
    let mut rig = Rig::at(Phase::Armed);
    rig.model.verdict =
        verdict(Some(diagnostic(Code::DoubleHit, Severity::Error, Subject::Whole, 0.42)));
    rig.show("rejected", Screen::Measure, 0);
    let mut rig = Rig::at(Phase::Armed);
    rig.model.verdict =
        verdict(Some(diagnostic(Code::Overload, Severity::Error, Subject::Channel(5), 171.2)));
    rig.show("rejected-channel", Screen::Measure, 0);
    let mut rig = Rig::at(Phase::Busy);
    rig.model.dof = Some((11, "65535:-Z".parse().unwrap()));
    (rig.model.accepted, rig.model.wanted) = (49, 50);
    rig.model.verdict =
        verdict(Some(diagnostic(Code::HitInconsistent, Severity::Error, Subject::Hit(1), 0.3)));
    rig.show("rejected-busy", Screen::Measure, 0);
    let mut rig = Rig::at(Phase::Armed);
    rig.model.verdict =
        verdict(Some(diagnostic(Code::HitElsewhere, Severity::Error, Subject::Hit(1), 1.85)));
    rig.show("rejected-elsewhere", Screen::Measure, 0);
    // In the suspension profile the lowest line says how the object swung.
    let mut rig = Rig::at(Phase::Armed);
    rig.model.profile = TestProfile::Suspension;
    let swung = diagnostic(Code::PreTriggerNotQuiet, Severity::Error, Subject::Channel(5), 0.124);
    rig.model.verdict = verdict(Some(swung)).map(|verdict| HitVerdict {
        swing: Some(Swing { impulse: 1.02, rest: 0.124, remainder: 0.0101 }),
        ..verdict
    });
    rig.show("rejected-swinging", Screen::Measure, 0);
}

#[test]
fn a_doubtful_hit_that_is_kept_says_why() {
    let doubt = diagnostic(Code::HitInconsistent, Severity::Warning, Subject::Hit(1), 0.3);
    let mut rig = Rig::at(Phase::Armed);
    rig.model.verdict = verdict(Some(doubt));
    rig.show("kept", Screen::Measure, 0);
    let mut rig = Rig::at(Phase::Armed);
    rig.model.verdict = verdict(Some(doubt));
    rig.model.dof = Some((11, "65535:-Z".parse().unwrap()));
    (rig.model.accepted, rig.model.wanted) = (49, 50);
    rig.show("kept-longest", Screen::Measure, 0);
}

#[test]
fn an_undo_looks_as_its_pictures() {
    // The longest list: all eight lines, as far as they fit the screen.
    let mut rig = Rig::at(Phase::Paused);
    rig.findings = vec![diagnostic(Code::GravityNotGiven, Severity::Warning, Subject::Whole, 0.0)];
    rig.model.averaged = 7;
    rig.model.precision = Some(precision(false));
    rig.show("paused-undo", Screen::Measure, 1);
    let mut rig = Rig::at(Phase::Armed);
    rig.model.verdict =
        verdict(Some(diagnostic(Code::HitUndone, Severity::Error, Subject::Hit(1), 0.0)));
    rig.show("undone", Screen::Measure, 0);
    Rig::at(Phase::Paused).show("refused-undo", Screen::Refused(RefusalReason::NothingToUndo), 0);
    Rig::at(Phase::Paused).show(
        "refused-undo-late",
        Screen::Refused(RefusalReason::HitOverwritten),
        0,
    );
}

#[test]
fn the_screens_of_a_campaign_that_waits_or_ends_look_as_their_pictures() {
    let mut rig = Rig::at(Phase::Confirming);
    rig.model.verdict = verdict(None);
    rig.show("confirming", Screen::Measure, 0);
    let findings = vec![diagnostic(Code::GravityNotGiven, Severity::Warning, Subject::Whole, 0.0)];
    Rig { findings, ..Rig::at(Phase::Paused) }.show("paused", Screen::Measure, 1);
    Rig::at(Phase::Solving).show("solving", Screen::Measure, 0);
    Rig::at(Phase::Done).show("done", Screen::Measure, 0);
    let mut rig = Rig::at(Phase::Done);
    rig.model.mass = None;
    rig.show("done-no-answer", Screen::Measure, 0);
    let mut rig = Rig::at(Phase::Done);
    rig.model.block = true;
    rig.show("done-block", Screen::Measure, 0);
}

#[test]
fn a_title_in_any_script_is_drawn() {
    let titles = [
        ("cyrillic", "Стальная рама из трёх"),
        ("chinese", "三根钢条的框架三根钢条"),
        ("german", "Prüfstand Süd, Aufhängung über Kreuz"),
    ];
    for (name, title) in titles {
        for (screen, picture) in [(Screen::Measure, "measure"), (Screen::Layouts, "layouts")] {
            let mut rig = Rig::at(Phase::Idle);
            rig.layout.as_mut().unwrap().title = title.try_into().unwrap();
            // As long as a line has room for.
            rig.layouts[0].title = title.chars().take(8).collect();
            rig.show(&format!("{picture}-title-{name}"), screen, 0);
        }
    }
}

/// Intervals after five of twelve places; the longest texts with `longest`.
fn precision(longest: bool) -> PrecisionModel {
    let dof = if longest { "65535:-Z" } else { "4:+X" }.parse().unwrap();
    let widths = if longest {
        Widths { mass: 9.994, center: 0.0994, inertia: 9.994 }
    } else {
        Widths { mass: 0.0083, center: 0.000_92, inertia: 0.018 }
    };
    let (property, half_widths) =
        if longest { (8, [9.994, 9.9]) } else { (2, [0.000_92, 0.000_71]) };
    let further = Some(FurtherPlace { dof, property, half_widths });
    PrecisionModel { dofs: if longest { 12 } else { 5 }, widths: Some(widths), further }
}

#[test]
fn the_screens_about_the_precision_look_as_their_pictures() {
    let after_a_dof = |known: PrecisionModel| {
        let mut rig = Rig::at(Phase::Armed);
        (rig.model.accepted, rig.model.averaged, rig.model.dofs) = (0, 25, 12);
        rig.model.verdict = verdict(None);
        rig.model.precision = Some(known);
        rig
    };
    after_a_dof(precision(false)).show("after-a-place", Screen::Measure, 0);
    let too_few = PrecisionModel { dofs: 2, widths: None, further: None };
    after_a_dof(too_few).show("after-too-few-places", Screen::Measure, 0);
    let mut rig = after_a_dof(precision(true));
    rig.model.seconds_left = Some(u16::MAX);
    rig.show("after-a-place-longest", Screen::Measure, 0);
    for (name, longest) in [("precision", false), ("precision-longest", true)] {
        let mut rig = after_a_dof(precision(longest));
        rig.model.phase = Phase::Paused;
        rig.show(name, Screen::Precision, 0);
    }
    let mut rig = after_a_dof(precision(false));
    rig.model.phase = Phase::TargetReached;
    rig.show("target-reached", Screen::Measure, 0);
}

#[test]
fn the_pages_of_findings_look_as_their_pictures() {
    let findings = vec![
        diagnostic(
            Code::SettingOutOfRange,
            Severity::Error,
            Subject::Setting(Setting::ExponentialDecay),
            9000.0,
        ),
        diagnostic(Code::ResultNotStored, Severity::Error, Subject::Whole, 0.0),
        diagnostic(Code::LargeHitPull, Severity::Note, Subject::Hit(2), 2.4),
    ];
    let names = ["finding-setting", "finding-store", "finding-hit"];
    for (page, name) in names.into_iter().enumerate() {
        let rig = Rig { findings: findings.clone(), ..Rig::at(Phase::Paused) };
        rig.show(name, Screen::Findings, page);
    }
}

#[test]
fn the_pages_of_a_self_test_look_as_their_pictures() {
    let at = |self_test| {
        let mut rig = Rig::at(Phase::Idle);
        rig.model.self_test = self_test;
        rig
    };
    at(SelfTestState::Running { percent: 40 }).show("self-test-runs", Screen::SelfTest, 0);
    at(SelfTestState::Disturbed).show("self-test-disturbed", Screen::SelfTest, 0);
    let channel = |level, noise, hum_50_hz, hum_60_hz| ChannelAtRest {
        level,
        noise,
        hum_50_hz,
        hum_60_hz,
        screen: 0.0,
        slow_range: 0.0,
        is_stuck: false,
        is_alike: false,
    };
    let mut at_rest = vec![channel(1.512, 456e-6, 12e-6, 8e-6); 10];
    at_rest[0] = channel(0.107, 140e-6, 30e-6, 0.0);
    // The widest that there is.
    at_rest[2] = channel(3.3, 1.2345, 1.65, 99.9e-3);
    let sound = SelfTestState::Done { findings: 0, channels: 10 };
    for (page, name) in ["self-test-sound", "self-test-channels"].into_iter().enumerate() {
        Rig { at_rest: at_rest.clone(), ..at(sound) }.show(name, Screen::SelfTest, page);
    }
    let findings = vec![
        diagnostic(Code::SensorSilent, Severity::Error, Subject::Sensor(1), 0.002),
        diagnostic(Code::PickUp50Hz, Severity::Error, Subject::Channel(9), 0.00123),
    ];
    let faulty = SelfTestState::Done { findings: 2, channels: 10 };
    for (page, name) in [(1, "self-test-fault"), (4, "self-test-last-channels")] {
        let rig = Rig { at_rest: at_rest.clone(), findings: findings.clone(), ..at(faulty) };
        rig.show(name, Screen::SelfTest, page);
    }
}

/// Checks the drawn text of every code, not only its number of characters.
#[test]
fn every_code_leaves_the_edges_of_the_screen_dark() {
    for &code in Code::ALL {
        let mut rig = Rig::at(Phase::Paused);
        rig.findings = vec![diagnostic(code, Severity::Error, code.subject_kind().at(1), 0.5)];
        rig.model.findings = 1;
        let mut menu = Menu::new();
        menu.follow(&rig.model);
        menu.open(Screen::Findings);
        let mut framebuffer = Framebuffer::default();
        let view = View {
            menu: &menu,
            model: &rig.model,
            layout: rig.layout.as_ref(),
            layout_hash: 7,
            layouts: &[],
            results: &[],
            summary: None,
            findings: &rig.findings,
            at_rest: &[],
            info: &rig.info,
            stats: &rig.stats,
            screen: ScreenSetting::Automatic,
        };
        draw(&view, &mut framebuffer);
        // 21 characters of six pixels: two columns stay dark unless text overflows.
        let edge = (13..64).any(|y| framebuffer.is_bright(126, y) || framebuffer.is_bright(127, y));
        assert!(!edge, "{code:?}");
        assert!((23..64).any(|y| (0..128).any(|x| framebuffer.is_bright(x, y))), "{code:?}");
    }
}

#[test]
fn the_list_of_layouts_looks_as_its_pictures() {
    Rig::new().show("layouts", Screen::Layouts, 1);
    Rig { layouts: Vec::new(), ..Rig::new() }.show("layouts-none", Screen::Layouts, 0);
}

#[test]
fn the_list_of_results_looks_as_its_pictures() {
    Rig::new().show("results", Screen::Results, 0);
    let full = (1..=RESULTS as u32).rev().map(entry).collect();
    Rig { results: full, ..Rig::new() }.show("results-full", Screen::Results, 6);
    Rig { results: Vec::new(), ..Rig::new() }.show("results-none", Screen::Results, 0);
}

#[test]
fn the_pages_of_a_result_look_as_their_pictures() {
    let names = [
        "result-mass",
        "result-inertia",
        "result-products",
        "result-principal",
        "result-limits",
        "result-budget",
        "result-finding",
        "result-finding-response",
    ];
    for (page, name) in names.into_iter().enumerate() {
        let rig = Rig { summary: Some(summary()), ..Rig::new() };
        rig.show(name, Screen::Result, page);
    }
    let mut uneven = Rig { summary: Some(summary()), ..Rig::new() };
    uneven.layout.as_mut().expect("has a layout").hits[0].uncertainty.position *= 2.0;
    uneven.show("result-budget-uneven", Screen::Result, 5);
    let good = Summary { verdict: Some(Verdict::Good), findings: Diagnostics::new(), ..summary() };
    Rig { summary: Some(good), ..Rig::new() }.show("result-mass-good", Screen::Result, 0);
    let contradicted = Summary { verdict: Some(Verdict::DoNotUse), ..summary() };
    Rig { summary: Some(contradicted), ..Rig::new() }.show("result-mass-no", Screen::Result, 0);
    let nothing = Summary { answer: None, ..summary() };
    Rig { summary: Some(nothing), ..Rig::new() }.show("result-no-answer", Screen::Result, 0);
}

#[test]
fn a_heavy_body_without_sigmas_fits_the_page() {
    let mut heavy = summary();
    if let Some(answer) = &mut heavy.answer {
        answer.body = RigidBody::from_theta(&(answer.theta() * -987.654));
        answer.covariance = None;
        answer.consistency = None;
    }
    heavy.verdict = Some(Verdict::DoNotUse);
    Rig { summary: Some(heavy.clone()), ..Rig::new() }.show("result-heavy", Screen::Result, 0);
    Rig { summary: Some(heavy), ..Rig::new() }.show("result-heavy-limits", Screen::Result, 4);
}

#[test]
fn the_screens_of_a_calibration_look_as_their_pictures() {
    Rig::new().show("calibration", Screen::Calibration, 0);
    Rig::new().show("block-mass", Screen::BlockMass, 2);
    let sigma = CalibrationSigma { gain: 0.000_21, cross_axis: 0.0034, hammer_gain: 0.0041 };
    let tumble = Proposal { sound: true, hammer_ratio: None, sigma };
    let block = Proposal { sound: false, hammer_ratio: Some(1.0213), sigma };
    let problem = TumbleProblem::NotAtRest { position: Position::ALL[0], deviation: 1.0 };
    for (name, calibration_wizard) in [
        ("tumble-wanted", CalibrationWizard::Wanted(1)),
        ("tumble-reading", CalibrationWizard::Reading(1)),
        ("tumble-moved", CalibrationWizard::Wrong(WizardProblem::Tumble { sensor: 2, problem })),
        ("block-sensors-unknown", CalibrationWizard::Wrong(WizardProblem::SensorsUnknown)),
        ("tumble-proposal", CalibrationWizard::Proposed(tumble)),
        ("block-proposal", CalibrationWizard::Proposed(block)),
        ("calibrated", CalibrationWizard::Stored),
    ] {
        let mut rig = Rig::new();
        rig.model.calibration_wizard = calibration_wizard;
        rig.show(name, Screen::CalibrationWizard, 0);
    }
}

#[test]
fn the_pages_about_the_rig_and_its_store_look_as_their_pictures() {
    Rig::new().show("storage", Screen::Storage, 0);
    let full = (1..=RESULTS as u32).rev().map(entry).collect();
    Rig { results: full, ..Rig::new() }.show("storage-full", Screen::Storage, 0);
    let last_panic =
        "index out of bounds: the len is 3 but the index is 7, firmware/src/store.rs:123";
    for page in 0..usize::from(ABOUT_PAGES) {
        let mut rig = Rig::new();
        rig.info.last_panic = last_panic;
        rig.info.boot_reason = BootReason::Panic;
        rig.model.battery = Some(Battery { millivolts: 3840, percent: 64 });
        rig.show(&format!("about-{}", page + 1), Screen::About, page);
    }
}

#[test]
fn a_dead_crystal_and_a_low_supply_are_said() {
    let brown_out = Some(BrownOut { read: || 2700, raise: || {} });
    let show = |name, is_low: fn() -> bool| {
        let mut rig = Rig::new();
        rig.info.clock = Clock::Internal;
        rig.info.supply = Supply { is_low, brown_out, battery: None };
        rig.show(name, Screen::About, 2);
    };
    show("about-3-no-crystal", || false);
    show("about-3-supply-low", || true);
    Rig::new().show("refused-supply-low", Screen::Refused(RefusalReason::SupplyLow), 0);
}

#[test]
fn questions_and_refusals_look_as_their_pictures() {
    Rig::at(Phase::Paused).show("sure-end", Screen::Sure(Question::End), 0);
    Rig::at(Phase::Paused).show("sure-redo", Screen::Sure(Question::Redo), 0);
    let rig = Rig { summary: Some(summary()), ..Rig::new() };
    rig.show("sure-delete", Screen::Sure(Question::Delete), 0);
    Rig::new().show("refused", Screen::Refused(RefusalReason::StoreFull), 0);
}
