//! The cells of a flash in memory, and what a power cut does to them.

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use super::{Chip, FlashError, VirtualChip};

const ERASED: u8 = 0xFF;

/// When the power is cut. A *step* writes one word or erases one page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Number of steps that still complete; the next one is torn.
    pub after: u64,
    /// Seed that decides what the torn step leaves.
    pub seed: u64,
}

/// A step that a rig has done: a word that it wrote, or a page that it erased.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlashStep {
    at: usize,
    /// The bytes of the word; `None` for a page.
    word: Option<Vec<u8>>,
}

/// The content of a flash in memory; clones share it.
#[derive(Clone)]
pub struct FlashMemory(Arc<Mutex<Cells>>);

impl Default for FlashMemory {
    /// Erased flash of the virtual board.
    fn default() -> Self {
        Self::of::<VirtualChip>()
    }
}

impl fmt::Debug for FlashMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("FlashMemory")
    }
}

impl FlashMemory {
    /// Erased flash of a chip.
    pub fn of<C: Chip>() -> Self {
        Self::of_cells(Cells::new::<C>(vec![ERASED; C::BYTES]))
    }

    /// Flash of the virtual board with this content.
    pub(super) fn holding(bytes: Vec<u8>) -> Self {
        Self::of_cells(Cells::new::<VirtualChip>(bytes))
    }

    fn of_cells(cells: Cells) -> Self {
        Self(Arc::new(Mutex::new(cells)))
    }

    /// An independent copy with the same content, whose steps are not noted.
    pub fn copied(&self) -> Self {
        let cells = self.with(|cells| Cells { noted: None, ..cells.clone() });
        Self::of_cells(cells)
    }

    /// Notes every step from now on.
    pub fn note_steps(&self) {
        self.with(|cells| cells.noted = Some(Vec::new()));
    }

    /// The steps that were noted, in their order.
    pub fn noted_steps(&self) -> Vec<FlashStep> {
        self.with(|cells| cells.noted.clone().unwrap_or_default())
    }

    /// Does a step that was noted on flash of the same chip with the content that this one has: after some of the steps
    /// of a rig, and a [cut](Self::cut_power) in the next one, the flash is as if the rig's power had been cut there.
    ///
    /// # Errors
    /// Those of the write or of the erase.
    pub fn repeat(&self, step: &FlashStep) -> Result<(), FlashError> {
        self.with(|cells| match &step.word {
            Some(word) => cells.write(step.at, word),
            None => cells.erase(step.at, cells.page),
        })
    }

    /// Schedules a power cut. Power returns when the flash is opened again.
    pub fn cut_power(&self, cut: Cut) {
        self.with(|cells| cells.cut = Some(cut));
    }

    /// Whether writes and erases fail from now on, although there is power.
    pub fn refuse_changes(&self, refuse: bool) {
        self.with(|cells| cells.refuses = refuse);
    }

    /// False from the power cut until the flash is opened again.
    pub fn has_power(&self) -> bool {
        self.with(|cells| !cells.dark)
    }

    /// Steps done so far.
    pub fn steps(&self) -> u64 {
        self.with(|cells| cells.steps)
    }

    /// Number of erases of each page.
    pub fn erases(&self) -> Vec<u32> {
        self.with(|cells| cells.erases.clone())
    }

    pub(super) fn with<T>(&self, operation: impl FnOnce(&mut Cells) -> T) -> T {
        operation(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// State of a word with an error-correcting code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Word {
    Erased,
    Written,
    Torn,
}

#[derive(Clone)]
pub(super) struct Cells {
    bytes: Vec<u8>,
    page: usize,
    word: usize,
    /// Empty for a chip without error-correcting codes.
    words: Vec<Word>,
    steps: u64,
    erases: Vec<u32>,
    cut: Option<Cut>,
    dark: bool,
    refuses: bool,
    /// The steps that were done since noting them was asked for.
    noted: Option<Vec<FlashStep>>,
}

impl Cells {
    fn new<C: Chip>(bytes: Vec<u8>) -> Self {
        let words = if C::ECC { bytes.len() / C::WORD } else { 0 };
        Self {
            page: C::PAGE,
            word: C::WORD,
            words: vec![Word::Erased; words],
            steps: 0,
            erases: vec![0; bytes.len() / C::PAGE],
            cut: None,
            dark: false,
            refuses: false,
            noted: None,
            bytes,
        }
    }

    pub fn power_up(&mut self) {
        self.cut = None;
        self.dark = false;
    }

    pub fn bytes(&self, start: usize, length: usize) -> &[u8] {
        &self.bytes[start..start + length]
    }

    pub fn read(&self, start: usize, bytes: &mut [u8]) -> Result<(), FlashError> {
        if self.dark {
            return Err(FlashError::PowerCut);
        }
        let words = start / self.word..(start + bytes.len()).div_ceil(self.word);
        if self.words.get(words).is_some_and(|words| words.contains(&Word::Torn)) {
            return Err(FlashError::Torn);
        }
        bytes.copy_from_slice(self.bytes(start, bytes.len()));
        Ok(())
    }

    pub fn write(&mut self, start: usize, bytes: &[u8]) -> Result<(), FlashError> {
        for (at, new) in (start..).step_by(self.word).zip(bytes.chunks(self.word)) {
            let torn = self.step()?;
            let index = at / self.word;
            if self.words.get(index).is_some_and(|&word| word != Word::Erased) {
                return Err(FlashError::NotErased);
            }
            let place = &mut self.bytes[at..at + new.len()];
            if place.iter().zip(new).any(|(&old, &new)| new & !old != 0) {
                return Err(FlashError::NotErased);
            }
            let left = match torn {
                None => StepExtent::Whole,
                Some(mut chance) => tear(place, new, &mut chance),
            };
            if left == StepExtent::Whole {
                place.copy_from_slice(new);
            }
            if let Some(word) = self.words.get_mut(index) {
                *word = match left {
                    StepExtent::Nothing => Word::Erased,
                    StepExtent::Part => Word::Torn,
                    StepExtent::Whole => Word::Written,
                };
            }
            self.powered()?;
            self.note(at, Some(new));
        }
        Ok(())
    }

    pub fn erase(&mut self, start: usize, length: usize) -> Result<(), FlashError> {
        for page in (start..start + length).step_by(self.page) {
            match self.step()? {
                None => {
                    self.erases[page / self.page] += 1;
                    self.bytes[page..page + self.page].fill(ERASED);
                    let words = page / self.word..(page + self.page) / self.word;
                    if let Some(words) = self.words.get_mut(words) {
                        words.fill(Word::Erased);
                    }
                }
                Some(mut chance) => self.tear_page(page, &mut chance),
            }
            self.powered()?;
            self.note(page, None);
        }
        Ok(())
    }

    fn note(&mut self, at: usize, word: Option<&[u8]>) {
        if let Some(noted) = &mut self.noted {
            noted.push(FlashStep { at, word: word.map(<[u8]>::to_vec) });
        }
    }

    /// Begins a step; returns the random number generator when the power is cut during it.
    fn step(&mut self) -> Result<Option<Chance>, FlashError> {
        self.powered()?;
        if self.refuses {
            return Err(FlashError::Refused);
        }
        self.steps += 1;
        let Some(cut) = &mut self.cut else { return Ok(None) };
        if let Some(left) = cut.after.checked_sub(1) {
            cut.after = left;
            return Ok(None);
        }
        self.dark = true;
        Ok(Some(Chance(cut.seed)))
    }

    fn powered(&self) -> Result<(), FlashError> {
        if self.dark { Err(FlashError::PowerCut) } else { Ok(()) }
    }

    /// Leaves a page as an interrupted erase does: how far it came is random, and each word may be
    /// unchanged, erased or in between.
    fn tear_page(&mut self, page: usize, chance: &mut Chance) {
        let progress = chance.below(5);
        for at in (page..page + self.page).step_by(self.word) {
            let done = match progress {
                0 => StepExtent::Nothing,
                1 => StepExtent::Whole,
                _ => [StepExtent::Nothing, StepExtent::Part, StepExtent::Whole][chance.below(3)],
            };
            let place = &mut self.bytes[at..at + self.word];
            match done {
                StepExtent::Nothing => continue,
                StepExtent::Whole => place.fill(ERASED),
                // Cells are cleared before they are erased, so any bit may read as either.
                StepExtent::Part => place.iter_mut().for_each(|byte| *byte = chance.next() as u8),
            }
            if let Some(word) = self.words.get_mut(at / self.word) {
                *word = if done == StepExtent::Whole { Word::Erased } else { Word::Torn };
            }
        }
    }
}

/// How much of an interrupted step was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StepExtent {
    Nothing,
    Part,
    Whole,
}

/// Clears none, some or all of the bits that were to be cleared.
fn tear(place: &mut [u8], new: &[u8], chance: &mut Chance) -> StepExtent {
    match chance.below(8) {
        0 => StepExtent::Nothing,
        1 => StepExtent::Whole,
        _ => {
            for (old, new) in place.iter_mut().zip(new) {
                *old &= new | chance.next() as u8;
            }
            StepExtent::Part
        }
    }
}

/// Deterministic random number generator: SplitMix64.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }
}
