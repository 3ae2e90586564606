//! Which page a terminal shows that has no room for all of them, and whether the keys are explained instead.

use crossterm::event::KeyCode;

/// What is shown beside the DOF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Page {
    /// The last hit over time.
    Hit,
    /// Frequency responses and coherence.
    Spectra,
    /// The ten properties so far.
    Estimate,
}

impl Page {
    const ALL: [Self; 3] = [Self::Hit, Self::Spectra, Self::Estimate];
}

/// The pages of a campaign.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pages {
    /// Whether the campaign has estimates.
    estimates: bool,
    /// The page that is turned up.
    pub(super) current: Page,
    /// Whether the keys are explained.
    pub(super) help: bool,
}

impl Pages {
    /// The pages of a campaign with or without estimates, at the first.
    pub(super) fn new(estimates: bool) -> Self {
        Self { estimates, current: Page::Hit, help: false }
    }

    /// All pages, in their order.
    pub(super) fn all(self) -> impl Iterator<Item = Page> {
        Page::ALL.into_iter().filter(move |page| self.estimates || *page != Page::Estimate)
    }

    /// Takes a key that turns a page or explains the keys; false for any other key.
    pub(super) fn key(&mut self, key: KeyCode) -> bool {
        if self.help {
            return self.key_of_help(key);
        }
        let pages: Vec<Page> = self.all().collect();
        let here = pages.iter().position(|page| *page == self.current).unwrap_or(0);
        let turned = match key {
            KeyCode::Tab | KeyCode::Right => here + 1,
            KeyCode::BackTab | KeyCode::Left => here + pages.len() - 1,
            KeyCode::Char('?' | 'h') | KeyCode::F(1) => {
                self.help = true;
                return true;
            }
            _ => return false,
        };
        self.current = pages[turned % pages.len()];
        true
    }

    /// While the keys are explained, none of them does anything but leave.
    fn key_of_help(&mut self, key: KeyCode) -> bool {
        if matches!(key, KeyCode::Char('?' | 'h') | KeyCode::F(1) | KeyCode::Esc) {
            self.help = false;
        }
        key != KeyCode::Char('p')
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn while_the_keys_are_explained_no_other_key_reaches_the_campaign() {
        let mut pages = Pages::new(true);
        assert!(pages.key(KeyCode::Char('?')));
        for key in ['d', 's', 'u', 'q', 'f', 'a'] {
            assert!(pages.key(KeyCode::Char(key)) && pages.help, "{key}");
        }
        assert!(pages.key(KeyCode::Tab));
        assert_eq!(pages.current, Page::Hit);
        assert!(!pages.key(KeyCode::Char('p')), "a pause is always possible");
        assert!(pages.key(KeyCode::Esc) && !pages.help);
        assert!(!pages.key(KeyCode::Char('d')));
    }

    #[test]
    fn a_block_test_has_no_page_of_its_estimate() {
        let mut pages = Pages::new(false);
        for page in [Page::Spectra, Page::Hit, Page::Spectra] {
            assert!(pages.key(KeyCode::Tab));
            assert_eq!(pages.current, page);
        }
        assert!(!pages.key(KeyCode::Char('d')), "a key of the campaign");
    }
}
