//! How a view looks: which parts there are on a terminal of this size, and each part in a file.

mod bar;
mod curves;
mod estimate;
mod hit;
mod keys;
mod large;
mod levels;
mod modes;
mod place;
mod positions;
mod sketch;
mod small;
mod spectra;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::Span;
use ratatui::widgets::{Block, Paragraph, Wrap};

use bar::bar;
use small::SmallView;

use super::guide::Guide;
use super::pages::Page;
use super::positions::Positions;
use super::{Theme, View, pace};

/// Below this, only the words of what to do are shown.
const SMALLEST: [u16; 2] = [60, 18];
/// From this height on, all pages are shown one above the other, and from this width on beside each other.
const TALL: u16 = 40;
const WIDE: u16 = 150;
/// Rows of a page of words.
const WORDS: u16 = 20;

impl View for Guide {
    fn draw(&self, frame: &mut Frame<'_>, theme: Theme) {
        guide(self, frame, theme);
    }

    fn note(&mut self, text: &str) {
        self.keep_note(text);
    }
}

impl View for Positions {
    fn draw(&self, frame: &mut Frame<'_>, theme: Theme) {
        positions::all(self, frame, theme);
    }

    fn note(&mut self, text: &str) {
        self.note = text.into();
    }
}

/// The guide of a campaign.
fn guide(guide: &Guide, frame: &mut Frame<'_>, theme: Theme) {
    let area = frame.area();
    let is_small = area.width < SMALLEST[0] || area.height < SMALLEST[1];
    if is_small && !guide.pages.help {
        return small(guide, frame, theme);
    }
    let message = message(guide, theme);
    // The keys need the rows of a message that there is not.
    let messages = if message.is_none() && guide.pages.help { 0 } else { 2 };
    let rows = [
        Constraint::Length((!is_small).into()),
        Constraint::Min(0),
        Constraint::Length(messages),
        Constraint::Length(1),
    ];
    let [title, middle, messages, keys] = Layout::vertical(rows).areas(area);
    bar([&guide.title, &progress(guide)], frame, title, theme);
    if let Some((text, style)) = message {
        let text = Paragraph::new(text).style(style).wrap(Wrap { trim: true });
        frame.render_widget(text, messages);
    }
    keys::line(keys::of(guide), frame, keys, theme);
    if guide.pages.help {
        return keys::help(frame, middle, theme);
    }
    // The sketch is as large as its height allows; a cell is twice as high as wide.
    let left = (area.width * 2 / 5).min(2 * area.height).max(28);
    let [left, right] =
        Layout::horizontal([Constraint::Length(left), Constraint::Min(0)]).areas(middle);
    left_side(guide, frame, left, theme);
    right_side(guide, frame, right, theme);
}

/// A question, or the last note.
fn message(guide: &Guide, theme: Theme) -> Option<(&str, Style)> {
    let question = guide.question.as_deref().map(|question| (question, theme.accent()));
    question.or_else(|| guide.note.as_deref().map(|note| (note, theme.bad())))
}

/// Where to hit.
fn left_side(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let bars = levels::height(guide, frame.area().height >= TALL);
    let has_room = area.height >= place::LARGE + sketch::LOWEST + bars;
    let name = if has_room { place::LARGE } else { place::WORDS };
    let rows =
        [Constraint::Length(name), Constraint::Min(sketch::LOWEST), Constraint::Length(bars)];
    let [name, body, bars] = Layout::vertical(rows).areas(area);
    place::name(guide, frame, name, theme);
    sketch::body(guide, frame, body, theme);
    levels::bars(guide, frame, bars, theme);
}

/// What was measured: pages, as many as there is room for.
fn right_side(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let pages: Vec<Page> = guide.pages.all().collect();
    let [verdict, area] =
        Layout::vertical([Constraint::Length(hit::HEIGHT), Constraint::Min(0)]).areas(area);
    hit::verdict(guide, frame, verdict, theme);
    let places = match () {
        () if frame.area().width >= WIDE && frame.area().height < TALL => {
            Layout::horizontal(pages.iter().map(|_| Constraint::Fill(1))).split(area)
        }
        () if frame.area().height >= TALL => {
            Layout::vertical(pages.iter().map(|page| page_rows(*page, area.height))).split(area)
        }
        () => return page(guide.pages.current, guide, frame, area, theme),
    };
    for (drawn_page, place) in pages.iter().zip(places.iter()) {
        page(*drawn_page, guide, frame, *place, theme);
    }
}

/// The rows of a page among three below each other: words need no more than they have, charts share the rest.
fn page_rows(page: Page, height: u16) -> Constraint {
    match page {
        Page::Hit | Page::Spectra => Constraint::Fill(1),
        Page::Estimate | Page::Modes => Constraint::Length(WORDS.min(height / 3)),
    }
}

fn page(page: Page, guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    match page {
        Page::Hit => hit::readings(guide, frame, area, theme),
        Page::Spectra => spectra::spectra(guide, frame, area, theme),
        Page::Estimate => estimate::estimate(guide, frame, area, theme),
        Page::Modes => modes::modes(guide, frame, area, theme),
    }
}

/// A terminal without room for more than words.
fn small(guide: &Guide, frame: &mut Frame<'_>, theme: Theme) {
    let mut small = SmallView::new(frame.area());
    match message(guide, theme) {
        // What is asked comes last.
        Some((text, style)) if guide.question.is_some() => small.text_to_its_end(text, style),
        Some((text, style)) => small.text(text, style),
        None => {}
    }
    small.text(&place::words(guide), theme.accent());
    if let Some(verdict) = guide.verdict() {
        small.text(&format!("last hit: {verdict}"), Style::new());
    }
    small.text(&progress(guide), Style::new());
    small.draw(SMALLEST, keys::of(guide), frame, theme);
}

/// `block test 12 of 60 hits, about 3 min left`.
fn progress(guide: &Guide) -> String {
    let [done, wanted] = guide.hits();
    let left = guide.pace.left(wanted.saturating_sub(done)).filter(|_| done < wanted);
    let left =
        left.map_or_else(String::new, |left| format!(", about {} left", pace::in_words(left)));
    format!("{}: {done} of {wanted} hits{left}", guide.kind)
}

/// A frame with a heading.
fn framed(title: &str, theme: Theme) -> Block<'_> {
    Block::bordered().border_style(theme.faint()).title(Span::styled(title, theme.strong()))
}

#[cfg(test)]
mod tests;
