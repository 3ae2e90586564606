//! What a store holds: the result of all changes in its log.
//!
//! The log moves live records between its pages, so changes are not read in the order in which they were
//! made. Their serials restore the order: of two changes of the same item the later one holds. A change
//! that removes something (a deletion, the end of a campaign) always comes after everything that it
//! removes, because records of removed items are never moved.
//!
//! A finished DOF belongs to its campaign until this ends. One with lines then belongs to the campaign's result,
//! which names the campaign, and is deleted with it: its bytes are not copied. A DOF may lie before or behind the
//! change that ends its campaign, so the changes of DOFs are applied after all others.

use heapless::{String, Vec};
use massline_protocol::message::{EstimatedMass, ResultEntry};
use massline_shared::layout::{RIG_HITS, TestProfile};
use massline_shared::signal::COMPACT_RESPONSE;
use serde::{Deserialize, Serialize};

use super::{LAYOUTS, MAX_DOF, RESULTS};
use crate::screen_setting::ScreenSetting;

/// Most bytes of an encoded change. The longest is that of a layout: six integers of at most five bytes,
/// four more bytes, a title.
pub(super) const MAX_CHANGE: usize = 6 * 5 + 4 + 49;
/// Most bytes of an encoded change that names no layout. The longest is that of a result: five integers of at most
/// five bytes, a length of three, a mass of ten, its kind.
pub(super) const MAX_SHORT_CHANGE: usize = 5 * 5 + 3 + 10 + 1;

/// Most finished DOFs in the store: those of the current campaign, and those with lines of stored results.
pub const DOFS: usize = 2 * RIG_HITS;

/// The bytes of a stored item: the pieces in the log with this serial.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Object {
    pub serial: u32,
    pub length: u16,
    /// Intact bytes found in the log when the store was opened.
    #[serde(skip)]
    pub found: u16,
}

/// A stored layout.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutHandle {
    /// CRC-32 of its bytes, which identifies it.
    pub hash: u32,
    /// Its title.
    pub title: String<48>,
    /// What it measures.
    pub profile: TestProfile,
    /// True for the layout in use.
    pub in_use: bool,
    /// Serial of the change that last put it into use.
    used: u32,
    pub(super) object: Object,
}

/// A stored result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResultHandle {
    /// Its entry in the list of results.
    pub entry: ResultEntry,
    /// CRC-32 of the result's bytes.
    pub crc: u32,
    pub(super) object: Object,
    /// Serial of its campaign, 0 when nothing of it was stored.
    pub(super) campaign: u32,
}

/// A finished DOF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DofHandle {
    /// Serial of its campaign.
    pub(super) campaign: u32,
    pub(super) object: Object,
    /// Its index in the layout.
    pub index: u8,
}

impl DofHandle {
    /// Number of bytes, with those of its lines.
    pub fn length(&self) -> usize {
        self.object.length.into()
    }

    /// True when its lines are stored: then it is longer than what a DOF says besides them.
    pub fn has_lines(&self) -> bool {
        self.length() > MAX_DOF
    }
}

// A DOF with the lines of a single response is longer than any DOF without lines.
const _: () = assert!(COMPACT_RESPONSE > MAX_DOF);

/// A change of the contents. Its postcard encoding is a part of the store's format.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Change {
    /// A layout was put into use, whether new or already stored; `evicted` was removed for it.
    Layout {
        hash: u32,
        title: String<48>,
        profile: TestProfile,
        object: Object,
        evicted: Option<u32>,
    },
    Calibration {
        object: Object,
    },
    /// A result was stored, which ends its campaign.
    Result {
        object: Object,
        number: u32,
        layout: u32,
        mass: Option<EstimatedMass>,
        crc: u32,
        campaign: u32,
    },
    /// A result and the DOFs of its campaign were deleted.
    Deleted {
        number: u32,
        campaign: u32,
    },
    /// The progress of a campaign. A campaign is identified by a serial.
    Progress {
        object: Object,
        campaign: u32,
    },
    /// A finished DOF of a campaign.
    Dof {
        object: Object,
        campaign: u32,
        index: u8,
    },
    Ended {
        campaign: u32,
    },
    /// A DOF of a campaign was removed, because it is open again.
    Reopened {
        campaign: u32,
        index: u8,
    },
    /// A layout that is not in use was removed to make room.
    Evicted {
        hash: u32,
    },
    /// The operator has said which controller the screen has.
    Screen {
        setting: ScreenSetting,
    },
}

impl Change {
    /// True for a finished DOF, which is applied after all other changes.
    pub fn is_dof(&self) -> bool {
        matches!(self, Self::Dof { .. } | Self::Reopened { .. })
    }
}

/// The campaign that has not ended.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StoredCampaign {
    /// Serial that identifies it, 0 without a campaign.
    pub serial: u32,
    pub progress: Option<Object>,
}

/// Everything that is stored.
#[derive(Debug, Default)]
pub(super) struct Contents {
    pub layouts: Vec<LayoutHandle, LAYOUTS>,
    pub calibration: Option<Object>,
    /// Which controller the screen has, and the serial of the change that says so.
    pub screen: Option<(u32, ScreenSetting)>,
    /// In the order of their numbers.
    pub results: Vec<ResultHandle, RESULTS>,
    pub last_number: u32,
    pub campaign: StoredCampaign,
    /// The finished DOFs of the campaign, and those with lines of the results.
    pub dofs: Vec<DofHandle, DOFS>,
    /// The last campaign that has ended.
    ended: u32,
}

impl Contents {
    /// Applies a change.
    pub fn apply(&mut self, serial: u32, change: Change) {
        match change {
            Change::Layout { hash, title, profile, object, evicted } => {
                let gone =
                    |stored: &LayoutHandle| Some(stored.hash) == evicted || stored.hash == hash;
                if self.layouts.iter().any(|stored| stored.hash == hash && stored.used > serial) {
                    return;
                }
                self.layouts.retain(|stored| !gone(stored) || stored.used > serial);
                let in_use = false;
                let stored = LayoutHandle { hash, title, profile, in_use, used: serial, object };
                // There is room: either one was removed or the list was not full.
                let _ = self.layouts.push(stored);
                self.mark_layout_in_use();
            }
            Change::Calibration { object } => {
                if self.calibration.is_none_or(|stored| stored.serial < object.serial) {
                    self.calibration = Some(object);
                }
            }
            Change::Result { object, number, layout, mass, crc, campaign } => {
                let length = object.length.into();
                let entry = ResultEntry { number, layout_hash: layout, mass, length };
                // The log may hold a result twice: if the flash reported a failure although the write was
                // complete.
                self.results.retain(|stored| stored.entry.number != number);
                let at =
                    self.results.iter().take_while(|stored| stored.entry.number < number).count();
                // There is room, else the result would not have been stored.
                let _ = self.results.insert(at, ResultHandle { entry, crc, object, campaign });
                self.last_number = self.last_number.max(number);
                self.end(campaign);
            }
            Change::Deleted { number, campaign } => {
                self.results.retain(|stored| stored.entry.number != number);
                self.last_number = self.last_number.max(number);
                self.end(campaign);
            }
            Change::Progress { object, campaign } => {
                let progress = self.enter(campaign).map(|current| &mut current.progress);
                if let Some(stored) = progress
                    && stored.is_none_or(|stored| stored.serial < object.serial)
                {
                    *stored = Some(object);
                }
            }
            Change::Dof { object, campaign, index } => {
                self.enter(campaign);
                let dof = DofHandle { campaign, object, index };
                let owned = self.has_owner(&dof);
                match self.place_of_dof(campaign, index) {
                    Some(place) => {
                        let older = |stored: &&mut DofHandle| stored.object.serial < object.serial;
                        if let Some(stored) = self.dofs.get_mut(place).filter(older) {
                            *stored = dof;
                        }
                    }
                    // There is room, else the DOF would not have been stored.
                    None if owned => drop(self.dofs.push(dof)),
                    None => {}
                }
            }
            Change::Reopened { campaign, index } => {
                let known = self.place_of_dof(campaign, index);
                if let Some(place) = known
                    && self.dofs.get(place).is_some_and(|stored| stored.object.serial < serial)
                {
                    self.dofs.remove(place);
                }
            }
            Change::Ended { campaign } => self.end(campaign),
            Change::Screen { setting } => self.set_screen(serial, setting),
            Change::Evicted { hash } => {
                self.layouts.retain(|stored| stored.hash != hash || stored.used > serial);
                self.mark_layout_in_use();
            }
        }
    }

    /// Of two statements about the screen the later one holds.
    fn set_screen(&mut self, serial: u32, setting: ScreenSetting) {
        if self.screen.is_none_or(|(before, _)| before < serial) {
            self.screen = Some((serial, setting));
        }
    }

    /// Counts a piece that was found intact in the log.
    pub fn count_intact(&mut self, serial: u32, length: u16) {
        let objects = self.objects().filter(|object| object.serial == serial);
        objects.for_each(|object| object.found = object.found.saturating_add(length));
    }

    /// Drops every object that was not found complete; returns how many.
    pub fn drop_torn(&mut self) -> u32 {
        let count = |contents: &mut Self| contents.objects().count();
        let before = count(self);
        let whole = |object: &Object| object.found == object.length;
        self.layouts.retain(|stored| whole(&stored.object));
        self.calibration = self.calibration.filter(whole);
        self.results.retain(|stored| whole(&stored.object));
        self.campaign.progress = self.campaign.progress.filter(whole);
        self.dofs.retain(|stored| whole(&stored.object));
        let dropped = before - count(self);
        self.drop_ownerless_dofs();
        self.mark_layout_in_use();
        dropped as u32
    }

    /// True for the serial of a stored object and of its change.
    pub fn is_live(&self, serial: u32) -> bool {
        let layouts = self.layouts.iter().flat_map(|stored| [stored.used, stored.object.serial]);
        let results = self.results.iter().map(|stored| stored.object.serial);
        let dofs = self.dofs.iter().map(|stored| stored.object.serial);
        let others =
            self.calibration.iter().chain(&self.campaign.progress).map(|stored| stored.serial);
        let others = others.chain(self.screen.map(|(serial, _)| serial));
        layouts.chain(results).chain(dofs).chain(others).any(|live| live == serial)
    }

    /// As [`Self::is_live`] when the campaign has ended without a result and the `deleted` oldest results are
    /// deleted.
    pub fn is_live_without(&self, deleted: usize, serial: u32) -> bool {
        let is_dof_of =
            |campaign| self.dofs_of(campaign).any(|stored| stored.object.serial == serial);
        let StoredCampaign { serial: current, progress } = self.campaign;
        let of_campaign =
            progress.is_some_and(|object| object.serial == serial) || is_dof_of(current);
        let mut gone = self.results.iter().take(deleted);
        let of_result =
            |stored: &ResultHandle| stored.object.serial == serial || is_dof_of(stored.campaign);
        self.is_live(serial) && !of_campaign && !gone.any(of_result)
    }

    /// Number of DOFs that stay then.
    pub fn dofs_without(&self, deleted: usize) -> usize {
        let kept = self.results.iter().skip(deleted);
        kept.map(|stored| self.dofs_of(stored.campaign).count()).sum()
    }

    /// The finished DOFs of a campaign.
    pub fn dofs_of(&self, campaign: u32) -> impl Iterator<Item = &DofHandle> {
        self.dofs.iter().filter(move |stored| stored.campaign == campaign)
    }

    /// The finished DOFs with lines of a result.
    pub fn dofs_of_result(&self, number: u32) -> impl Iterator<Item = &DofHandle> {
        let result = self.results.iter().find(move |stored| stored.entry.number == number);
        result.into_iter().flat_map(|stored| self.dofs_of(stored.campaign))
    }

    /// True when a finished DOF of the campaign has a place in the list.
    pub fn has_place_for_dof(&self, campaign: u32, index: u8) -> bool {
        !self.dofs.is_full() || self.place_of_dof(campaign, index).is_some()
    }

    /// The layout with this hash.
    pub fn layout(&self, hash: u32) -> Option<&LayoutHandle> {
        self.layouts.iter().find(|stored| stored.hash == hash)
    }

    /// The object of the layout in use.
    pub fn layout_in_use(&self) -> Option<Object> {
        self.layouts.iter().find(|stored| stored.in_use).map(|stored| stored.object)
    }

    /// Hash of the layout that is not in use and is missed least.
    pub fn unused_layout(&self) -> Option<u32> {
        self.least_missed(self.layouts.iter().filter(|stored| !stored.in_use))
    }

    /// The least recently used layout of those without a result, or of all where each has one, which is solved with it.
    fn least_missed<'l>(&self, layouts: impl Iterator<Item = &'l LayoutHandle>) -> Option<u32> {
        let has_result =
            |hash: u32| self.results.iter().any(|stored| stored.entry.layout_hash == hash);
        layouts
            .min_by_key(|stored| (has_result(stored.hash), stored.used))
            .map(|stored| stored.hash)
    }

    /// True for the serial of a layout that is not in use.
    pub fn is_of_unused_layout(&self, serial: u32) -> bool {
        let mut unused = self.layouts.iter().filter(|stored| !stored.in_use);
        unused.any(|stored| [stored.used, stored.object.serial].contains(&serial))
    }

    /// Hash of the layout to be removed for a new one; `None` while there is room.
    pub fn layout_to_evict(&self) -> Option<u32> {
        if !self.layouts.is_full() {
            return None;
        }
        self.least_missed(self.layouts.iter())
    }

    fn objects(&mut self) -> impl Iterator<Item = &mut Object> {
        let Self { layouts, calibration, results, campaign, dofs, .. } = self;
        let layouts = layouts.iter_mut().map(|stored| &mut stored.object);
        let results = results.iter_mut().map(|stored| &mut stored.object);
        let dofs = dofs.iter_mut().map(|stored| &mut stored.object);
        layouts.chain(results).chain(dofs).chain(calibration).chain(&mut campaign.progress)
    }

    fn mark_layout_in_use(&mut self) {
        let last = self.layouts.iter().map(|stored| stored.used).max();
        self.layouts.iter_mut().for_each(|stored| stored.in_use = Some(stored.used) == last);
    }

    /// The campaign with this serial, started if it is newer than the current one; `None` if it has ended
    /// or is older.
    fn enter(&mut self, campaign: u32) -> Option<&mut StoredCampaign> {
        if campaign <= self.ended || campaign < self.campaign.serial {
            return None;
        }
        if campaign > self.campaign.serial {
            self.campaign = StoredCampaign { serial: campaign, ..StoredCampaign::default() };
            self.drop_ownerless_dofs();
        }
        Some(&mut self.campaign)
    }

    pub(super) fn end(&mut self, campaign: u32) {
        self.ended = self.ended.max(campaign);
        if self.campaign.serial <= self.ended {
            self.campaign = StoredCampaign::default();
        }
        self.drop_ownerless_dofs();
    }

    fn place_of_dof(&self, campaign: u32, index: u8) -> Option<usize> {
        self.dofs.iter().position(|stored| (stored.campaign, stored.index) == (campaign, index))
    }

    /// True for a DOF of the campaign, or with lines of a result.
    fn has_owner(&self, dof: &DofHandle) -> bool {
        is_owned(&self.campaign, &self.results, dof)
    }

    fn drop_ownerless_dofs(&mut self) {
        let Self { campaign, results, dofs, .. } = self;
        dofs.retain(|dof| is_owned(campaign, results, dof));
    }
}

fn is_owned(campaign: &StoredCampaign, results: &[ResultHandle], dof: &DofHandle) -> bool {
    let of_result = |stored: &ResultHandle| stored.campaign == dof.campaign;
    dof.campaign == campaign.serial || dof.has_lines() && results.iter().any(of_result)
}

#[cfg(test)]
mod tests;
