//! What a store holds: the result of all changes in its log.
//!
//! The log moves live records between its pages, so changes are not read in the order in which they were
//! made. Their serials restore the order: of two changes of the same item the later one holds. A change
//! that removes something (a deletion, the end of a campaign) always comes after everything that it
//! removes, because records of removed items are never moved.

use heapless::{String, Vec};
use massline_protocol::message::{EstimatedMass, ResultEntry};
use massline_shared::layout::RIG_HITS;
use serde::{Deserialize, Serialize};

use super::{LAYOUTS, RESULTS};

/// Most bytes of an encoded change. The longest is that of a layout: six integers of at most five bytes,
/// three more bytes, a title.
pub(super) const MAX_CHANGE: usize = 6 * 5 + 3 + 49;

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
    /// True for the layout in use.
    pub in_use: bool,
    /// Serial of the change that last put it into use.
    used: u32,
    object: Object,
}

/// A stored result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResultHandle {
    /// Its entry in the list of results.
    pub entry: ResultEntry,
    /// CRC-32 of the result's bytes.
    pub crc: u32,
    pub(super) object: Object,
}

/// A change of the contents. Its postcard encoding is a part of the store's format.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Change {
    /// A layout was put into use, whether new or already stored; `evicted` was removed for it.
    Layout {
        hash: u32,
        title: String<48>,
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
    Deleted {
        number: u32,
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
}

/// The campaign that has not ended.
#[derive(Clone, Debug, Default)]
pub(super) struct StoredCampaign {
    /// Serial that identifies it, 0 without a campaign.
    pub serial: u32,
    pub progress: Option<Object>,
    /// Its finished DOFs by their index in the layout.
    pub dofs: Vec<(u8, Object), RIG_HITS>,
}

/// Everything that is stored.
#[derive(Debug, Default)]
pub(super) struct Contents {
    pub layouts: Vec<LayoutHandle, LAYOUTS>,
    pub calibration: Option<Object>,
    /// In the order of their numbers.
    pub results: Vec<ResultHandle, RESULTS>,
    pub last_number: u32,
    pub campaign: StoredCampaign,
    /// The last campaign that has ended.
    ended: u32,
}

impl Contents {
    /// Applies a change.
    pub fn apply(&mut self, serial: u32, change: Change) {
        match change {
            Change::Layout { hash, title, object, evicted } => {
                let gone =
                    |stored: &LayoutHandle| Some(stored.hash) == evicted || stored.hash == hash;
                if self.layouts.iter().any(|stored| stored.hash == hash && stored.used > serial) {
                    return;
                }
                self.layouts.retain(|stored| !gone(stored) || stored.used > serial);
                let stored = LayoutHandle { hash, title, in_use: false, used: serial, object };
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
                let _ = self.results.insert(at, ResultHandle { entry, crc, object });
                self.last_number = self.last_number.max(number);
                self.end(campaign);
            }
            Change::Deleted { number } => {
                self.results.retain(|stored| stored.entry.number != number);
                self.last_number = self.last_number.max(number);
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
                let Some(campaign) = self.enter(campaign) else { return };
                let known = campaign.dofs.iter_mut().find(|(of, _)| *of == index);
                match known {
                    Some((_, stored)) if stored.serial > object.serial => {}
                    Some((_, stored)) => *stored = object,
                    // There is room for every DOF of a layout.
                    None => drop(campaign.dofs.push((index, object))),
                }
            }
            Change::Ended { campaign } => self.end(campaign),
        }
    }

    /// Counts a piece that was found intact in the log.
    pub fn found(&mut self, serial: u32, length: u16) {
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
        self.campaign.dofs.retain(|(_, object)| whole(object));
        self.mark_layout_in_use();
        (before - count(self)) as u32
    }

    /// True for the serial of a stored object and of its change.
    pub fn is_live(&self, serial: u32) -> bool {
        let layouts = self.layouts.iter().flat_map(|stored| [stored.used, stored.object.serial]);
        let results = self.results.iter().map(|stored| stored.object.serial);
        let campaign = &self.campaign;
        let dofs = campaign.dofs.iter().map(|(_, object)| object.serial);
        let others = self.calibration.iter().chain(&campaign.progress).map(|stored| stored.serial);
        layouts.chain(results).chain(dofs).chain(others).any(|live| live == serial)
    }

    /// The object and the title of the layout with this hash.
    pub fn layout(&self, hash: u32) -> Option<(Object, &String<48>)> {
        let stored = self.layouts.iter().find(|stored| stored.hash == hash)?;
        Some((stored.object, &stored.title))
    }

    /// The object of the layout in use.
    pub fn layout_in_use(&self) -> Option<Object> {
        self.layouts.iter().find(|stored| stored.in_use).map(|stored| stored.object)
    }

    /// Hash of the layout to be removed for a new one; `None` while there is room.
    pub fn layout_to_evict(&self) -> Option<u32> {
        let oldest = self.layouts.iter().min_by_key(|stored| stored.used);
        oldest.filter(|_| self.layouts.is_full()).map(|stored| stored.hash)
    }

    fn objects(&mut self) -> impl Iterator<Item = &mut Object> {
        let Self { layouts, calibration, results, campaign, .. } = self;
        let layouts = layouts.iter_mut().map(|stored| &mut stored.object);
        let results = results.iter_mut().map(|stored| &mut stored.object);
        let dofs = campaign.dofs.iter_mut().map(|(_, object)| object);
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
        }
        Some(&mut self.campaign)
    }

    pub(super) fn end(&mut self, campaign: u32) {
        self.ended = self.ended.max(campaign);
        if self.campaign.serial <= self.ended {
            self.campaign = StoredCampaign::default();
        }
    }
}

#[cfg(test)]
mod tests;
