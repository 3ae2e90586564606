//! Which page a terminal shows that has no room for all of them, and whether the keys are explained instead.

use crossterm::event::KeyCode;

/// What is told of the answer after each DOF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnswerSoFar {
    /// The intervals of the ten properties, from mass lines.
    Intervals,
    /// The suspension modes.
    Modes,
}

/// What is shown beside the DOF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Page {
    /// The last hit over time.
    Hit,
    /// Frequency responses and coherence.
    Spectra,
    /// The ten properties so far.
    Estimate,
    /// The suspension modes so far.
    Modes,
}

impl Page {
    const ALL: [Self; 4] = [Self::Hit, Self::Spectra, Self::Estimate, Self::Modes];

    /// Whether it is there in a campaign of which this is followed.
    fn is_of(self, answer: Option<AnswerSoFar>) -> bool {
        match self {
            Self::Hit | Self::Spectra => true,
            Self::Estimate => answer == Some(AnswerSoFar::Intervals),
            Self::Modes => answer == Some(AnswerSoFar::Modes),
        }
    }
}

/// The pages of a campaign.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pages {
    /// What is followed of the answer.
    answer: Option<AnswerSoFar>,
    /// The page that is turned up.
    pub(super) current: Page,
    /// Whether the keys are explained.
    pub(super) help: bool,
}

impl Pages {
    /// The pages of a campaign of which this is followed, at the first.
    pub(super) fn new(answer: Option<AnswerSoFar>) -> Self {
        Self { answer, current: Page::Hit, help: false }
    }

    /// All pages, in their order.
    pub(super) fn all(self) -> impl Iterator<Item = Page> {
        Page::ALL.into_iter().filter(move |page| page.is_of(self.answer))
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
        let mut pages = Pages::new(Some(AnswerSoFar::Intervals));
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
        let mut pages = Pages::new(None);
        for page in [Page::Spectra, Page::Hit, Page::Spectra] {
            assert!(pages.key(KeyCode::Tab));
            assert_eq!(pages.current, page);
        }
        assert!(!pages.key(KeyCode::Char('d')), "a key of the campaign");
    }
}
