//! Room in the store: what an object takes, and what a campaign needs.
//!
//! In the smallest flash a campaign with lines needs almost all of it, so layouts that are not in use give way to it.

use embedded_storage_async::nor_flash::NorFlash;
use massline_shared::layout::RIG_HITS;

use super::contents::{Change, Contents, DOFS, MAX_CHANGE, MAX_SHORT_CHANGE};
use super::log::Log;
use super::record::Kind;
use super::writing::{MAX_PIECE, MIN_PIECE};
use super::{
    MAX_DOF, MAX_LINES, MAX_LINES_HEAD, MAX_PROGRESS, MAX_RESULT, MAX_RESULT_HEAD, RESULTS, Store,
    StoreError,
};

/// Changes without an object for which a full store still has room: deletions and their like, beside a layout that is
/// put into use.
const SMALL_CHANGES: u32 = 3;

/// What a campaign will store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CampaignSize {
    /// DOFs of the layout, at most [`RIG_HITS`].
    pub dofs: usize,
    /// Bytes of the lines of each DOF, at most [`MAX_LINES`]; 0 for a campaign that stores none.
    pub lines: usize,
}

/// What a store lacks for a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shortage {
    /// Bytes of flash; 0 when there are bytes enough but too many results or DOFs.
    pub bytes: u32,
    /// How many results must be deleted, the oldest first; `None` when even without results there is too little
    /// room.
    pub results: Option<usize>,
}

impl Shortage {
    /// How many results must be deleted, as a message says it: zero when even without results there is too little room.
    pub fn results_to_delete(&self) -> u8 {
        self.results.map_or(0, |results| results as u8)
    }
}

impl<F: NorFlash> Store<F> {
    /// True when there is no room for a campaign with all its progress and its result. The current campaign does
    /// not count: it ends when another one starts.
    pub async fn is_full(&mut self, campaign: CampaignSize) -> bool {
        self.lacks(campaign, 0).await.is_some()
    }

    /// What is missing for a campaign with all its progress and its result; `None` when there is room. The current
    /// campaign does not count, nor, for a campaign with lines, do layouts that are not in use: they give way.
    pub async fn shortage(&mut self, campaign: CampaignSize) -> Option<Shortage> {
        let bytes = self.lacks(campaign, 0).await?;
        for deleted in 1..=self.contents.results.len() {
            if self.lacks(campaign, deleted).await.is_none() {
                return Some(Shortage { bytes, results: Some(deleted) });
            }
        }
        Some(Shortage { bytes, results: None })
    }

    /// The bytes that are missing for a campaign when the `deleted` oldest results are deleted, 0 when there are only
    /// too many results or DOFs; `None` when there is room.
    async fn lacks(&mut self, campaign: CampaignSize, deleted: usize) -> Option<u32> {
        let dofs = campaign.dofs.min(RIG_HITS);
        let live = |contents: &Contents, serial| {
            contents.is_live_without(deleted, serial)
                && (campaign.lines == 0 || !contents.is_of_unused_layout(serial))
        };
        let needed = self.taken(live).await + self.needed(dofs, campaign.lines.min(MAX_LINES));
        let bytes = needed.saturating_sub(self.bytes());
        let places = self.contents.results.len() - deleted < RESULTS
            && self.contents.dofs_without(deleted) + dofs <= DOFS;
        (bytes > 0 || !places).then_some(bytes)
    }

    /// Bytes that a campaign takes with its result.
    fn needed(&self, dofs: usize, lines: usize) -> u32 {
        let (longest_dof, longest_result) = match lines {
            0 => (MAX_DOF, MAX_RESULT - (RIG_HITS - dofs) * MAX_DOF),
            _ => (MAX_LINES_HEAD + lines, MAX_RESULT_HEAD + dofs * MAX_LINES_HEAD),
        };
        let progress = self.cost(MAX_PROGRESS, MAX_SHORT_CHANGE);
        // Beside the progress there is its successor or, at the end, the result.
        progress
            + dofs as u32 * self.cost(longest_dof, MAX_SHORT_CHANGE)
            + progress.max(self.cost(longest_result, MAX_SHORT_CHANGE))
    }

    /// Most bytes of flash that an object of `length` bytes takes with its change of `change` bytes, however it is
    /// divided into pieces.
    fn cost(&self, length: usize, change: usize) -> u32 {
        let pieces = most_pieces(length, self.log.pages() as usize) as u32;
        Log::<F>::size(length) + pieces * Log::<F>::size(1) + Log::<F>::size(change)
    }

    /// Removes layouts that are not in use, those without a result first, until an object of this length fits or only
    /// the layout in use is left.
    pub(super) async fn evict_layouts_for(&mut self, length: usize) -> Result<(), StoreError> {
        while self.usable
            && !self.has_room(length).await
            && let Some(hash) = self.contents.unused_layout()
        {
            self.note(Change::Evicted { hash }).await?;
        }
        Ok(())
    }

    /// True when an object of this length fits beside everything that is stored.
    pub(super) async fn has_room(&mut self, length: usize) -> bool {
        let taken = self.taken(Contents::is_live).await;
        taken + self.cost(length, MAX_CHANGE) <= self.bytes()
    }

    /// Bytes for the records of objects in any order of writing.
    fn bytes(&self) -> u32 {
        let reserve = Log::<F>::size(MAX_CHANGE) + SMALL_CHANGES * Log::<F>::size(MAX_SHORT_CHANGE);
        self.log.capacity(MIN_PIECE.max(MAX_CHANGE)).saturating_sub(reserve)
    }

    /// Bytes that the records of the `live` objects take.
    async fn taken(&mut self, live: impl Fn(&Contents, u32) -> bool) -> u32 {
        let (mut taken, mut cursor) = (0, self.log.records());
        while let Some(record) = self.log.next(&mut cursor).await {
            let header = record.header;
            let of_object = matches!(header.kind, Kind::Data | Kind::Change);
            if of_object && live(&self.contents, header.serial) {
                taken += Log::<F>::size(header.length.into());
            }
        }
        taken
    }
}

/// Most pieces into which an object of `length` bytes is divided. No piece but the last is shorter than
/// [`MIN_PIECE`]. Only the last and those at the end of a page are shorter than [`MAX_PIECE`]; an object that fits
/// the store is complete before it has ended every page.
fn most_pieces(length: usize, pages: usize) -> usize {
    (length / MIN_PIECE + 1).min(length / MAX_PIECE + pages)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_object_is_divided_at_most_at_every_page() {
        // Of 7 in the three sectors of an F411: 4 whole pieces, one at the end of two pages each, and the last.
        assert_eq!(most_pieces(MAX_DOF + MAX_LINES, 3), 7);
        // In the 25 pages of a G474: 4 whole pieces, and one at the end of each page.
        assert_eq!(most_pieces(MAX_DOF + MAX_LINES, 25), 29);
        assert_eq!((most_pieces(0, 3), most_pieces(127, 3), most_pieces(128, 3)), (1, 1, 2));
    }
}
