//! Reads firmware from an ELF file, and checks that it is for a board.

use std::path::Path;

use object::elf::{EM_ARM, ET_EXEC, FileHeader32, PT_LOAD};
use object::read::elf::{FileHeader, ProgramHeader};
use object::{Endianness, LittleEndian, U32};

use super::board::{BOARDS, Board};
use massline_files::file;
use massline_result::{Error, Result};

/// Largest ELF file that is read, bytes: firmware with its debug information has a few million.
const MAX_BYTES: u64 = 1 << 26;

/// Contiguous bytes at an address.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Address of the first byte.
    pub address: u32,
    /// The bytes; never empty.
    pub bytes: Vec<u8>,
}

impl Segment {
    /// Address after the last byte.
    pub fn end(&self) -> u64 {
        u64::from(self.address) + self.bytes.len() as u64
    }
}

/// The contents for a chip's flash: segments by rising address that do not touch each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// The segments; never empty.
    pub segments: Vec<Segment>,
}

impl Image {
    /// Reads an ELF file that is firmware for `board`.
    ///
    /// # Errors
    /// `image_not_read`, `image_malformed`, `image_for_another_board`.
    pub fn read(path: &Path, board: &Board) -> Result<Self> {
        let bytes = file::read(path, MAX_BYTES).map_err(|error| {
            Error::input("image_not_read", format!("{}: {error}", path.display()))
        })?;
        let image = Self::parse(&bytes).and_then(|image| image.checked_for(board).map(|()| image));
        image.map_err(|error| error.within(path.display()))
    }

    /// The segments of an ELF file.
    ///
    /// # Errors
    /// `image_malformed`.
    pub fn parse(elf: &[u8]) -> Result<Self> {
        let header = FileHeader32::<Endianness>::parse(elf).map_err(|_| {
            malformed(
                "is not a 32-bit ELF file; pass the ELF that cargo builds for the board, not a .bin or .uf2",
            )
        })?;
        let endian = header.endian().map_err(|e| malformed(&e.to_string()))?;
        if header.e_machine(endian) != EM_ARM || header.e_type(endian) != ET_EXEC {
            return Err(malformed("is not a program for an ARM chip"));
        }
        let headers = header.program_headers(endian, elf).map_err(|e| malformed(&e.to_string()))?;
        let mut segments = Vec::new();
        for header in headers.iter().filter(|h| h.p_type(endian) == PT_LOAD) {
            let bytes = header.data(endian, elf).map_err(|()| malformed("is cut off"))?;
            if !bytes.is_empty() {
                segments.push(Segment { address: header.p_paddr(endian), bytes: bytes.to_vec() });
            }
        }
        segments.sort_by_key(|segment| segment.address);
        let mut segments = joined(segments)?;
        segments.iter_mut().for_each(fill_last_word);
        Ok(Self { segments: joined(segments)? })
    }

    /// Total number of bytes.
    pub fn len(&self) -> u64 {
        self.segments.iter().map(|segment| segment.bytes.len() as u64).sum()
    }

    /// Always false, because an image has at least one segment.
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty()
    }

    /// One segment from the first byte to the last, with `0xFF`, the value of erased flash, in the gaps.
    pub fn flat(&self) -> Segment {
        let mut flat = Segment { address: self.segments[0].address, bytes: Vec::new() };
        for segment in &self.segments {
            flat.bytes.resize((segment.address - flat.address) as usize, 0xFF);
            flat.bytes.extend(&segment.bytes);
        }
        flat
    }

    /// Checks that the image starts on the board's chip and is the firmware of the board.
    fn checked_for(&self, board: &Board) -> Result<()> {
        let first = &self.segments[0];
        if first.address != board.flash.origin {
            return Err(another(format!(
                "begins at 0x{:08x}, flash of {} at 0x{:08x}",
                first.address, board.name, board.flash.origin
            )));
        }
        let named: Vec<_> = BOARDS.iter().filter(|other| self.contains(&other.name)).collect();
        if !named.iter().any(|named| named.name == board.name) {
            return Err(another(match named.first() {
                Some(other) => format!("is the firmware of {}, not of {}", other.name, board.name),
                None => format!("does not name {}: no firmware of massline", board.name),
            }));
        }
        self.vectors_checked(board)
    }

    fn contains(&self, text: &str) -> bool {
        let holds = |s: &Segment| s.bytes.windows(text.len()).any(|w| w == text.as_bytes());
        self.segments.iter().any(holds)
    }

    /// Checks the first words of the vector table: initial stack pointer and entry point.
    fn vectors_checked(&self, board: &Board) -> Result<()> {
        let first = &self.segments[0];
        let word = |at: usize| {
            let bytes = first.bytes.get(at..at + 4)?;
            let word: [u8; 4] = bytes.try_into().ok()?;
            Some(U32::<LittleEndian>::from_bytes(word).get(LittleEndian))
        };
        let (Some(stack), Some(reset)) = (word(0), word(4)) else {
            return Err(malformed("has no vector table"));
        };
        if stack <= board.ram.start || stack > board.ram.end {
            return Err(another(format!(
                "puts its stack at 0x{stack:08x}, where {} has no RAM",
                board.name
            )));
        }
        let entry = reset & !1;
        let inside = |s: &Segment| entry >= s.address && u64::from(entry) < s.end();
        if reset & 1 == 0 || !self.segments.iter().any(inside) {
            return Err(malformed(&format!("starts at 0x{reset:08x}, where it has no code")));
        }
        Ok(())
    }
}

/// Gaps up to this many bytes are filled instead of starting a new segment.
const GAP: u64 = 64;

/// Joins segments that touch or have a small gap between them, which is filled as if erased.
fn joined(segments: Vec<Segment>) -> Result<Vec<Segment>> {
    let mut joined: Vec<Segment> = Vec::new();
    for segment in segments {
        if segment.end() > u64::from(u32::MAX) {
            return Err(malformed("goes beyond the last address"));
        }
        match joined.last_mut() {
            Some(last) if last.end() > u64::from(segment.address) => {
                return Err(malformed(&format!("has two contents at 0x{:08x}", segment.address)));
            }
            Some(last) if last.end() + GAP >= u64::from(segment.address) => {
                last.bytes.resize((segment.address - last.address) as usize, 0xFF);
                last.bytes.extend(segment.bytes);
            }
            _ => joined.push(segment),
        }
    }
    if joined.is_empty() { Err(malformed("holds nothing to be flashed")) } else { Ok(joined) }
}

/// Pads to a full word, the unit in which flash is written.
fn fill_last_word(segment: &mut Segment) {
    segment.bytes.resize(segment.bytes.len().next_multiple_of(4), 0xFF);
}

fn malformed(reason: &str) -> Error {
    Error::input("image_malformed", reason.to_owned())
}

fn another(reason: String) -> Error {
    Error::input("image_for_another_board", reason)
}
