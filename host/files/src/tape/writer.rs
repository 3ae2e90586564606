//! Writes a tape during a recording.
//!
//! Until a tape is complete it is called `NAME.partial.npy`, its sidecar `NAME.partial.toml`; then both take their
//! names. Whatever happens to a recording, there is never half a tape under the name that was given, and a tape that is
//! replaced stays until then. The two partial files are a tape of their own: scans are on the disk before the segment
//! that they belong to is listed, and a header that states no scans stands for all that are there. A process that is
//! killed therefore leaves a tape that can be replayed.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use massline_shared::signal::Scan;

use super::npy::header_bytes;
use super::scans::SCAN;
use super::{Segment, Sidecar, Tape, has_whole_hit, sidecar_path};
use crate::file::{self, ExistingFile};
use massline_result::{Error, Result};

/// Bytes that are written at a time.
const BLOCK: usize = 1 << 16;

/// Writes a tape during a recording. One of [`TapeWriter::finish`], [`TapeWriter::keep`] and [`TapeWriter::discard`]
/// ends it; a writer that is dropped does what `keep` does.
#[derive(Debug)]
pub struct TapeWriter {
    path: PathBuf,
    existing: ExistingFile,
    partial: PathBuf,
    file: File,
    /// Bytes that are not in the file yet.
    block: Vec<u8>,
    sidecar: Sidecar,
    scans: u64,
    ended: bool,
}

impl TapeWriter {
    /// Checks that a tape and its sidecar may be written here.
    ///
    /// # Errors
    /// Exit 2 when one of them exists and is kept, a recording that was cut short has left its hits under the partial
    /// name, the name does not end with `.npy`, or the folder does not exist.
    pub fn check(path: &Path, existing: ExistingFile) -> Result<()> {
        if path.extension().is_none_or(|extension| extension != "npy") {
            return Err(file::cannot(path, "the name of a tape ends with .npy"));
        }
        file::check(path, existing)?;
        let sidecar = sidecar_path(path);
        // Not even with --force: it may be the layout.
        if sidecar.exists() && Sidecar::read(&sidecar).is_err() {
            return Err(file::cannot(
                path,
                format!(
                    "its sidecar would be {}, which is another file; give another name",
                    sidecar.display()
                ),
            ));
        }
        file::check(&sidecar, existing)?;
        let partial = partial_path(path);
        if existing == ExistingFile::Kept && has_a_whole_hit(&partial) {
            let message = format!(
                "{} holds the hits of a recording that was cut short; replay or rename it, or replace it with --force",
                partial.display()
            );
            return Err(Error::input("file_exists", message));
        }
        Ok(())
    }

    /// Creates a tape; `sidecar` may already hold segments.
    ///
    /// # Errors
    /// As [`TapeWriter::check`], and exit 2 when a file cannot be written; then there is nothing new.
    pub fn create(path: &Path, sidecar: Sidecar, existing: ExistingFile) -> Result<Self> {
        Self::check(path, existing)?;
        let partial = partial_path(path);
        let created = File::create(&partial).map_err(|e| file::cannot(&partial, e))?;
        let mut writer = Self {
            path: path.to_owned(),
            existing,
            partial,
            file: created,
            block: Vec::new(),
            sidecar,
            scans: 0,
            ended: false,
        };
        match writer.write_header(0).map_err(|e| writer.cannot(e)).and_then(|()| writer.list()) {
            Ok(()) => Ok(writer),
            Err(error) => {
                writer.discard();
                Err(error)
            }
        }
    }

    /// Appends scans.
    ///
    /// # Errors
    /// Exit 2 when the file cannot be written; the tape keeps the scans so far.
    pub fn push(&mut self, scans: &[Scan]) -> Result<()> {
        self.block.extend(scans.as_flattened().iter().flat_map(|code| code.to_le_bytes()));
        self.scans += scans.len() as u64;
        if self.block.len() < BLOCK { Ok(()) } else { self.flush() }
    }

    /// Number of scans so far, which is the index of the next.
    pub fn scans(&self) -> u64 {
        self.scans
    }

    /// Records the segment of a hit.
    ///
    /// # Errors
    /// Exit 2 when a file cannot be written.
    pub fn segment(&mut self, segment: Segment) -> Result<()> {
        self.sidecar.segments.push(segment);
        self.flush()?;
        self.list()
    }

    /// Replaces all segments.
    ///
    /// # Errors
    /// Exit 2 when a file cannot be written.
    pub fn set_segments(&mut self, segments: &[Segment]) -> Result<()> {
        self.sidecar.segments = segments.to_vec();
        self.flush()?;
        self.list()
    }

    /// Completes the tape and gives it its name; returns its number of scans.
    ///
    /// # Errors
    /// Exit 2 when a file cannot be written. What is on the disk then stays under the partial name if it has a hit.
    pub fn finish(mut self) -> Result<u64> {
        self.ended = true;
        match self.complete() {
            Ok(()) => Ok(self.scans),
            Err(error) if has_a_whole_hit(&self.partial) => {
                let left = format!("{} holds the hits up to there", self.partial.display());
                Err(Error::input("cannot_write", format!("{error}; {left}")))
            }
            // The scans have their name already, and the sidecar not yet.
            Err(error) if !self.partial.exists() => Err(error),
            Err(error) => {
                self.discard();
                Err(error)
            }
        }
    }

    /// Ends a recording that failed: a tape with a hit is completed, any other removed. Returns the number of scans.
    ///
    /// # Errors
    /// As [`TapeWriter::finish`].
    pub fn keep(mut self) -> Result<Option<u64>> {
        if self.keeps_whole_hits() {
            return self.finish().map(Some);
        }
        self.discard();
        Ok(None)
    }

    /// Removes the partial tape.
    pub fn discard(mut self) {
        self.remove();
    }

    /// Leaves out the segments that the tape does not wholly have; false when none is left.
    fn keeps_whole_hits(&mut self) -> bool {
        let scans = self.scans;
        self.sidecar.segments.retain(|segment| has_whole_hit(*segment, scans));
        !self.sidecar.segments.is_empty()
    }

    fn remove(&mut self) {
        self.ended = true;
        // What cannot be removed is not in the way: the next recording replaces a partial tape without hits.
        let _ = (fs::remove_file(&self.partial), fs::remove_file(sidecar_path(&self.partial)));
    }

    fn complete(&mut self) -> Result<()> {
        self.flush()?;
        self.write_header(self.scans).map_err(|e| self.cannot(e))?;
        self.file.sync_all().map_err(|e| self.cannot(e))?;
        self.list()?;
        // Another program may have written there meanwhile.
        file::check(&self.path, self.existing)?;
        let (sidecar, partial) = (sidecar_path(&self.path), sidecar_path(&self.partial));
        // Between these steps an old tape lacks its sidecar, but never has that of the new one.
        match fs::remove_file(&sidecar) {
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(file::cannot(&sidecar, e)),
            _ => {}
        }
        for (from, to) in [(&self.partial, &self.path), (&partial, &sidecar)] {
            fs::rename(from, to).map_err(|e| file::cannot(to, e))?;
        }
        Ok(())
    }

    /// Brings all scans to the file. When that fails the tape has as many as the file.
    fn flush(&mut self) -> Result<()> {
        let written = self.file.write_all(&self.block);
        self.block.clear();
        written.map_err(|e| {
            if let Ok(about) = self.file.metadata() {
                let header = header_bytes(0);
                self.scans = about.len().saturating_sub(header.len() as u64) / SCAN;
            }
            self.cannot(e)
        })
    }

    /// Writes the sidecar.
    fn list(&self) -> Result<()> {
        let text = self.sidecar.to_toml();
        file::write(&sidecar_path(&self.partial), text.as_bytes(), ExistingFile::Replaced)
    }

    /// Writes the header for this number of scans, and moves behind the last scan.
    fn write_header(&mut self, scans: u64) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(0))?;
        self.file.write_all(&header_bytes(scans))?;
        self.file.seek(SeekFrom::End(0)).map(|_| ())
    }

    fn cannot(&self, error: io::Error) -> Error {
        file::cannot(&self.path, error)
    }
}

impl Drop for TapeWriter {
    fn drop(&mut self) {
        if self.ended {
            return;
        }
        self.ended = true;
        if self.keeps_whole_hits() {
            // A drop cannot report an error; the partial tape is left.
            let _ = self.complete();
        } else {
            self.remove();
        }
    }
}

/// Where a tape is written until it is complete.
fn partial_path(tape: &Path) -> PathBuf {
    tape.with_extension("partial.npy")
}

/// Whether there is a tape here with a hit that a replay could use.
fn has_a_whole_hit(tape: &Path) -> bool {
    Tape::read(tape).is_ok_and(|tape| {
        let count = tape.scans.count();
        tape.sidecar.segments.iter().any(|segment| has_whole_hit(*segment, count))
    })
}
