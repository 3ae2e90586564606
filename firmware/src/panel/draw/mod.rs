//! The screens as pixels. One file for each group of screens; [`draw`] finds the right one.

mod calibration;
mod campaign;
pub mod canvas;
mod lists;
mod result;
mod sketch;

use massline_protocol::message::{ResultEntry, Stats};
use massline_shared::diagnosis::Diagnostic;
use massline_shared::layout::RigLayout;

use self::canvas::{Canvas, Screen as Pixels};
use super::PanelModel;
use super::menu::{Menu, Screen};
use super::summary::Summary;
use crate::info::BoardInfo;

/// Everything that may be seen.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Which screen.
    pub menu: &'a Menu,
    /// What the rig is doing.
    pub model: &'a PanelModel,
    /// The layout in use.
    pub layout: Option<&'a RigLayout>,
    /// The layouts that are kept.
    pub layouts: &'a [LayoutLine],
    /// The results that are kept, the newest first.
    pub results: &'a [ResultEntry],
    /// The open result.
    pub summary: Option<&'a Summary>,
    /// What is to be said about the campaign or a layout that was refused.
    pub findings: &'a [Diagnostic],
    /// What the board says of itself.
    pub info: &'a BoardInfo,
    /// What has been counted.
    pub stats: &'a Stats,
}

/// One line of the list of layouts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayoutLine {
    /// Names it in the store.
    pub hash: u32,
    /// Free text, as much as fits a line.
    pub title: heapless::String<24>,
    /// True for the one that is measured with.
    pub in_use: bool,
}

/// Draws the whole screen.
pub fn draw<D: Pixels>(view: &View<'_>, target: &mut D) {
    let canvas = &mut Canvas(target);
    canvas.clear();
    match view.menu.screen() {
        Screen::Home => lists::home(canvas, view),
        Screen::Measure => campaign::draw(canvas, view),
        Screen::Findings => lists::findings(canvas, view),
        Screen::Layouts => lists::layouts(canvas, view),
        Screen::Results => result::list(canvas, view),
        Screen::Result => result::page(canvas, view),
        Screen::Calibration => lists::entries(canvas, view, "Calibrate"),
        Screen::BlockMass => calibration::block_mass(canvas, view),
        Screen::CalibrationWizard => calibration::calibration_wizard(canvas, view),
        Screen::Storage => lists::storage(canvas, view),
        Screen::About => lists::about(canvas, view),
        Screen::Sure(question) => lists::sure(canvas, view, question),
        Screen::Refused(reason) => lists::refused(canvas, reason),
    }
}
