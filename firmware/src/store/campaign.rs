//! The progress of the current campaign, and finished DOFs with or without lines.

use embedded_storage_async::nor_flash::NorFlash;

use super::contents::{Change, DofHandle};
use super::{Source, Store, StoreError};

impl<F: NorFlash> Store<F> {
    /// Stores a finished DOF of the current campaign, by its index in the layout; an older one with this index is
    /// removed. The caller calls [`Store::put_progress`] next: without the progress a campaign cannot be restored.
    ///
    /// A DOF without lines has at most [`MAX_DOF`](super::MAX_DOF) bytes and is deleted with the end of its
    /// campaign. One with lines ([`DofWithLines`](super::DofWithLines)) is longer, and stays with the result of its
    /// campaign. When there is too little room, layouts that are not in use give way.
    ///
    /// # Errors
    /// [`StoreError::Full`], or [`StoreError::Failed`] when the write fails.
    pub async fn put_dof(
        &mut self,
        index: u8,
        dof: &(impl Source + ?Sized),
    ) -> Result<(), StoreError> {
        if !self.contents.has_place_for_dof(self.contents.campaign.serial, index) {
            return Err(StoreError::Full);
        }
        self.evict_layouts_for(dof.length()).await?;
        let campaign = self.campaign();
        self.keep(&dof, &|object| Change::Dof { object, campaign, index }).await
    }

    /// Removes a DOF with lines of the current campaign because it is open again, so that there is room for the
    /// new one. A DOF without lines stays until it is replaced. The caller calls [`Store::put_progress`] before:
    /// after a power cut in between, the progress says that this DOF is open.
    ///
    /// # Errors
    /// [`StoreError::Failed`] when the write fails.
    pub async fn reopen_dof(&mut self, index: u8) -> Result<(), StoreError> {
        match self.dof_of_campaign(index).filter(DofHandle::has_lines) {
            Some(DofHandle { campaign, .. }) => {
                self.note(Change::Reopened { campaign, index }).await
            }
            None => Ok(()),
        }
    }

    /// Stores the progress of the current campaign.
    ///
    /// # Errors
    /// [`StoreError::Full`], or [`StoreError::Failed`] when the write fails.
    pub async fn put_progress(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        self.evict_layouts_for(bytes.len()).await?;
        let campaign = self.campaign();
        self.keep(&bytes, &|object| Change::Progress { object, campaign }).await
    }

    /// True when the progress of a campaign that has not ended is stored.
    pub fn has_progress(&self) -> bool {
        self.contents.campaign.serial != 0
    }

    /// The stored progress of the campaign, read into `room`.
    pub async fn progress<'r>(&mut self, room: &'r mut [u8]) -> Option<&'r [u8]> {
        let object = self.contents.campaign.progress?;
        self.read_whole(object, room).await
    }

    /// The `i`th finished DOF of the campaign in the order of storing, read into `room`: as much of it as fits, so
    /// the lines may be cut off. `None` after the last.
    pub async fn dof<'r>(&mut self, i: usize, room: &'r mut [u8]) -> Option<&'r [u8]> {
        let dofs = || self.contents.dofs_of(self.contents.campaign.serial);
        let place = |serial: u32| dofs().filter(|other| other.object.serial < serial).count();
        let object = dofs().find(|stored| place(stored.object.serial) == i)?.object;
        let length = self.read(object, 0, room).await?;
        room.get(..length)
    }

    /// The finished DOF of the current campaign with this index in the layout.
    pub fn dof_of_campaign(&self, index: u8) -> Option<DofHandle> {
        let mut dofs = self.contents.dofs_of(self.contents.campaign.serial);
        dofs.find(|stored| stored.index == index).copied()
    }

    /// The DOF with lines that is stored with a result, by its index in the layout.
    pub fn dof_of_result(&self, number: u32, index: u8) -> Option<DofHandle> {
        self.contents.dofs_of_result(number).find(|stored| stored.index == index).copied()
    }

    /// Reads part of a finished DOF into `out`, starting at `offset`; returns the number of bytes read.
    ///
    /// # Errors
    /// [`StoreError::Failed`] when a part of it cannot be read, as when it has been deleted meanwhile.
    pub async fn read_dof(
        &mut self,
        stored: &DofHandle,
        offset: usize,
        out: &mut [u8],
    ) -> Result<usize, StoreError> {
        self.read(stored.object, offset, out).await.ok_or(StoreError::Failed)
    }

    /// Deletes the progress of the campaign: whatever is stored from now on belongs to another one.
    ///
    /// # Errors
    /// [`StoreError::Failed`] when the write fails. In that case the next start finds the campaign again,
    /// unless another one has been stored meanwhile.
    pub async fn clear_progress(&mut self) -> Result<(), StoreError> {
        let campaign = self.contents.campaign.serial;
        if campaign == 0 {
            return Ok(());
        }
        let noted = self.note(Change::Ended { campaign }).await;
        self.contents.end(campaign);
        noted
    }

    /// The serial of the current campaign; a new one when nothing of it is stored yet.
    fn campaign(&mut self) -> u32 {
        match self.contents.campaign.serial {
            0 => self.next_serial(),
            serial => serial,
        }
    }
}
