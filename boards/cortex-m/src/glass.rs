//! What is to stand on the glass, whether or not the screen answers at the moment.

use crate::frame::{PAGES, Page, WIDTH};

/// The pages as they came last, and which of them the screen does not show yet.
#[derive(Clone, Debug)]
pub struct Glass {
    pages: [Page; PAGES],
    /// Bit by bit the pages that the screen does not show.
    stale: u8,
}

impl Default for Glass {
    fn default() -> Self {
        Self::new()
    }
}

impl Glass {
    /// Nothing has come yet, and nothing is to be shown.
    pub const fn new() -> Self {
        Self { pages: [[0; WIDTH]; PAGES], stale: 0 }
    }

    /// Takes a page that has come; without effect for one that does not exist.
    pub fn take(&mut self, number: u8, page: &Page) {
        if let Some(kept) = self.pages.get_mut(usize::from(number)) {
            *kept = *page;
            self.stale |= 1 << number;
        }
    }

    /// A page that the screen does not show.
    pub fn next(&self) -> Option<(u8, &Page)> {
        let number = self.stale.trailing_zeros();
        self.pages.get(number as usize).map(|page| (number as u8, page))
    }

    /// The screen shows the page.
    pub fn shown(&mut self, number: u8) {
        self.stale &= !1_u8.checked_shl(number.into()).unwrap_or(0);
    }

    /// The screen does not answer, or was switched on anew: it shows nothing of all this.
    pub fn lost(&mut self) {
        self.stale = u8::MAX;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn show_all(glass: &mut Glass) -> Vec<(u8, u8)> {
        let mut shown = Vec::new();
        while let Some((number, page)) = glass.next() {
            shown.push((number, page[0]));
            glass.shown(number);
        }
        shown
    }

    #[test]
    fn each_page_is_shown_once_as_it_came_last() {
        let mut glass = Glass::new();
        assert_eq!(show_all(&mut glass), []);
        glass.take(7, &[1; WIDTH]);
        glass.take(2, &[2; WIDTH]);
        glass.take(7, &[3; WIDTH]);
        glass.take(8, &[9; WIDTH]);
        assert_eq!(show_all(&mut glass), [(2, 2), (7, 3)]);
        assert_eq!(show_all(&mut glass), []);
    }

    #[test]
    fn a_screen_that_comes_back_gets_what_it_missed_and_all_the_rest() {
        let mut glass = Glass::new();
        glass.take(0, &[5; WIDTH]);
        assert_eq!(show_all(&mut glass), [(0, 5)]);
        glass.lost();
        glass.take(1, &[6; WIDTH]);
        let rest = (2..8).map(|number| (number, 0));
        assert_eq!(
            show_all(&mut glass),
            [(0, 5), (1, 6)].into_iter().chain(rest).collect::<Vec<_>>()
        );
    }
}
