//! The screens as pixels. Each group of screens has a file; [`draw`] calls the right one.

mod calibration;
mod campaign;
pub mod canvas;
mod figures;
mod lists;
mod precision;
mod result;
mod safe_mode;
mod self_test;
mod sketch;

use massline_protocol::message::{ResultEntry, Stats};
use massline_shared::diagnosis::Diagnostic;
use massline_shared::layout::{RigLayout, TestProfile};
use massline_shared::signal::self_test::ChannelAtRest;

use self::canvas::{Canvas, Screen as Pixels};
pub use self::safe_mode::{StoreState, safe_mode};
use super::PanelModel;
use super::menu::{Menu, Screen};
use super::summary::Summary;
use crate::info::BoardInfo;
use crate::screen_setting::ScreenSetting;

/// Everything that a screen may show.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// State of the menu, which selects the screen.
    pub menu: &'a Menu,
    /// State of the rig.
    pub model: &'a PanelModel,
    /// The layout in use.
    pub layout: Option<&'a RigLayout>,
    /// Its hash.
    pub layout_hash: u32,
    /// The stored layouts.
    pub layouts: &'a [LayoutLine],
    /// The stored results, newest first.
    pub results: &'a [ResultEntry],
    /// The open result.
    pub summary: Option<&'a Summary>,
    /// The diagnostics of the campaign, of a refused layout or of the self-test.
    pub findings: &'a [Diagnostic],
    /// What the channels read in the self-test.
    pub at_rest: &'a [ChannelAtRest<f32>],
    /// What the board reports about itself.
    pub info: &'a BoardInfo,
    /// Counters of the rig.
    pub stats: &'a Stats,
    /// Which controller the screen has.
    pub screen: ScreenSetting,
}

/// One line of the list of layouts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayoutLine {
    /// Hash that identifies it in the store.
    pub hash: u32,
    /// Title, cut to the length of a line.
    pub title: heapless::String<24>,
    /// True for the layout in use.
    pub in_use: bool,
    /// What it measures.
    pub profile: TestProfile,
}

/// Draws the whole screen.
pub fn draw<D: Pixels>(view: &View<'_>, target: &mut D) {
    let canvas = &mut Canvas(target);
    canvas.clear();
    match view.menu.screen() {
        Screen::Home => lists::home(canvas, view),
        Screen::Measure => campaign::draw(canvas, view),
        Screen::Findings => lists::findings(canvas, view),
        Screen::Precision => precision::page(canvas, view.model),
        Screen::Layouts => lists::layouts(canvas, view),
        Screen::Profile => lists::entries(canvas, view, "Measure what?"),
        Screen::Results => result::list(canvas, view),
        Screen::Result => result::page(canvas, view),
        Screen::Calibration => lists::entries(canvas, view, "Calibrate"),
        Screen::BlockMass => calibration::block_mass(canvas, view),
        Screen::CalibrationWizard => calibration::calibration_wizard(canvas, view),
        Screen::Storage => lists::storage(canvas, view),
        Screen::SelfTest => self_test::page(canvas, view),
        Screen::About => lists::about(canvas, view),
        Screen::Sure(question) => lists::sure(canvas, view, question),
        Screen::Refused(reason) => lists::refused(canvas, reason),
    }
}
