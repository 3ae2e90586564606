//! The deepest path of calls in a linked image, read from its machine code.
//!
//! The stack is measured on the emulated board only, and the compiler lays out the frames of each image
//! anew. So the frames of every image are added up along its calls. What is called through a pointer is not
//! followed. No function calls itself, directly or not, because then nothing would bound the stack; only a panic
//! may, while it is reported.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::fs;
use std::path::Path;

use anyhow::{Context, ensure};
use object::read::elf::ElfFile32;
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};
use rustc_demangle::demangle;

use super::thumb::{self, Effect};

/// The function through which every panic goes.
const PANIC: &str = "core::panicking::panic_fmt";

/// Functions one of which calls the next, from the one that nobody calls.
#[derive(Debug)]
pub struct CallPath {
    /// The sum of the frames, bytes.
    pub bytes: u64,
    /// Frames, bytes, and names.
    frames: Vec<(u64, String)>,
}

impl fmt::Display for CallPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.frames.iter().try_for_each(|(bytes, name)| writeln!(f, "{bytes:>8}  {name}"))
    }
}

/// The path of an image that takes most of the stack.
pub fn deepest(elf: &Path) -> anyhow::Result<CallPath> {
    let file = elf.display();
    let bytes = fs::read(elf).with_context(|| file.to_string())?;
    let image = ElfFile32::parse(&*bytes).with_context(|| file.to_string())?;
    let symbols = Symbols::of(&image)?;
    ensure!(
        !symbols.names.is_empty(),
        "{file}: the image has no names of functions; build it with strip = false"
    );
    let mut functions = BTreeMap::new();
    for section in image.sections().filter(|section| section.kind() == SectionKind::Text) {
        read_code(section.address(), section.data()?, &symbols, &mut functions)?;
    }
    let mut search = Search::new(&functions);
    let path = search.deepest(&symbols.names).context("the image has no code")?;
    let recursions = search.recursions(&symbols.names);
    ensure!(
        recursions.is_empty(),
        "{file}: functions that call themselves: {}",
        recursions.join("; ")
    );
    Ok(path)
}

/// The symbols of an image that say where functions and constants begin.
#[derive(Debug, Default)]
struct Symbols {
    names: BTreeMap<u32, String>,
    /// Where instructions begin, or constants (`$t` and `$d` of Arm's ELF).
    instructions: BTreeMap<u32, bool>,
}

impl Symbols {
    fn of(image: &ElfFile32) -> anyhow::Result<Self> {
        let mut symbols = Self::default();
        for symbol in image.symbols() {
            let (name, address) = (symbol.name()?, u32::try_from(symbol.address())?);
            match name.split('.').next() {
                Some("$t") => drop(symbols.instructions.insert(address, true)),
                Some("$d") => drop(symbols.instructions.insert(address, false)),
                _ if symbol.kind() == SymbolKind::Text => {
                    // The lowest bit only says that it is Thumb code.
                    symbols
                        .names
                        .entry(address & !1)
                        .or_insert_with(|| format!("{:#}", demangle(name)));
                }
                _ => {}
            }
        }
        Ok(symbols)
    }
}

#[derive(Debug, Default)]
struct Function {
    frame: u64,
    /// Addresses.
    calls: BTreeSet<u32>,
}

/// Reads the functions of a section that begins at `origin`.
fn read_code(
    origin: u64,
    code: &[u8],
    symbols: &Symbols,
    functions: &mut BTreeMap<u32, Function>,
) -> anyhow::Result<()> {
    let halfwords: Vec<_> =
        code.chunks_exact(2).map(|two| u16::from_le_bytes([two[0], two[1]])).collect();
    let origin = u32::try_from(origin)?;
    let (mut instructions, mut current) = (false, origin);
    let mut next = 0;
    while let Some(&first) = halfwords.get(next) {
        let address = origin + 2 * u32::try_from(next)?;
        // Constants may have an odd length; an odd place is that of the next one.
        for at in [address, address.wrapping_sub(1)] {
            instructions = *symbols.instructions.get(&at).unwrap_or(&instructions);
        }
        if symbols.names.contains_key(&address) {
            current = address;
        }
        next += 1;
        if !instructions {
            continue;
        }
        let effect = if thumb::is_long(first) {
            let second = *halfwords.get(next).context("an instruction ends behind its section")?;
            next += 1;
            thumb::long(first, second)
        } else {
            thumb::short(first)
        };
        let function = functions.entry(current).or_default();
        match effect {
            Effect::Nothing => {}
            Effect::Grows(bytes) => function.frame += u64::from(bytes),
            Effect::GrowsUnknown => {
                let name = symbols.names.get(&current).map_or("?", String::as_str);
                anyhow::bail!("{name}: the size of its frame is not a constant");
            }
            Effect::Jump(distance) => {
                let target = address.wrapping_add_signed(distance);
                if target != current && symbols.names.contains_key(&target) {
                    function.calls.insert(target);
                }
            }
        }
    }
    Ok(())
}

/// Searches the deepest path of calls.
#[derive(Debug)]
struct Search<'a> {
    functions: &'a BTreeMap<u32, Function>,
    /// Of each function that has been searched: the bytes of its deepest path, and the call with which it goes on.
    found: BTreeMap<u32, (u64, Option<u32>)>,
    /// The functions on the path that is being searched.
    open: Vec<u32>,
    /// Functions each of which calls the next, and the last one the first.
    cycles: Vec<Vec<u32>>,
}

impl<'a> Search<'a> {
    fn new(functions: &'a BTreeMap<u32, Function>) -> Self {
        Self { functions, found: BTreeMap::new(), open: Vec::new(), cycles: Vec::new() }
    }

    /// The bytes of the deepest path that begins at a function.
    fn depth(&mut self, at: u32) -> u64 {
        if let Some((bytes, _)) = self.found.get(&at) {
            return *bytes;
        }
        let Some(function) = self.functions.get(&at) else { return 0 };
        if let Some(before) = self.open.iter().position(|open| *open == at) {
            self.cycles.push(self.open[before..].to_vec());
            return 0;
        }
        self.open.push(at);
        let deepest = function.calls.iter().map(|&call| (self.depth(call), call)).max();
        self.open.pop();
        let bytes = function.frame + deepest.map_or(0, |(bytes, _)| bytes);
        self.found.insert(at, (bytes, deepest.map(|(_, call)| call)));
        bytes
    }

    fn deepest(&mut self, names: &BTreeMap<u32, String>) -> Option<CallPath> {
        let (bytes, first) = self.functions.keys().map(|&at| (self.depth(at), at)).max()?;
        let mut frames = Vec::new();
        let (mut next, mut passed) = (Some(first), BTreeSet::new());
        while let Some(at) = next.filter(|at| passed.insert(*at)) {
            let frame = self.functions.get(&at).map_or(0, |function| function.frame);
            frames.push((frame, names.get(&at).cloned().unwrap_or_default()));
            next = self.found.get(&at).and_then(|(_, call)| *call);
        }
        Some(CallPath { bytes, frames })
    }

    /// The cycles among the calls that were searched, as names, without those of a panic.
    fn recursions(&self, names: &BTreeMap<u32, String>) -> Vec<String> {
        let name = |at: &u32| names.get(at).map_or("?", String::as_str);
        let named = self.cycles.iter().map(|cycle| cycle.iter().map(name).collect::<Vec<_>>());
        named.filter(|cycle| !cycle.contains(&PANIC)).map(|cycle| cycle.join(" calls ")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function called `name` at each `(address, name)`; everything is code.
    fn symbols(names: &[(u32, &str)], constants: &[u32]) -> Symbols {
        let mut instructions = BTreeMap::from([(names[0].0, true)]);
        instructions.extend(constants.iter().map(|at| (*at, false)));
        Symbols {
            names: names.iter().map(|(at, name)| (*at, (*name).to_owned())).collect(),
            instructions,
        }
    }

    fn functions(code: &[u16], symbols: &Symbols) -> BTreeMap<u32, Function> {
        let code: Vec<_> = code.iter().flat_map(|halfword| halfword.to_le_bytes()).collect();
        let mut functions = BTreeMap::new();
        read_code(0x100, &code, symbols, &mut functions).unwrap();
        functions
    }

    fn path(code: &[u16], symbols: &Symbols) -> CallPath {
        Search::new(&functions(code, symbols)).deepest(&symbols.names).unwrap()
    }

    #[test]
    fn frames_add_up_along_the_deepest_path() {
        let code = [
            0xB5B0, 0xF000, 0xF802, 0xF000, 0xF804, // push four, bl small, bl large
            0xB401, 0x4770, // small: push one, return
            0xB0FF, 0x4770, // (never called) 508 bytes
            0xF5AD, 0x4D80, 0xB401, 0x4770, // large: 16 384 bytes, push one
        ];
        let names = [(0x100, "top"), (0x10A, "small"), (0x10E, "alone"), (0x112, "large")];
        let path = path(&code, &symbols(&names, &[]));
        assert_eq!(path.bytes, 16 + 16_384 + 4, "{path}");
        assert_eq!(path.to_string(), "      16  top\n   16388  large\n");
    }

    #[test]
    fn functions_that_call_themselves_are_named_but_for_a_panic() {
        let code = [
            0xB401, 0xF000, 0xF801, 0x4770, // push one, bl second, return
            0xB403, 0xE7F9, // second: push two, b first
        ];
        for (first, expected) in [("first", vec!["first calls second"]), (PANIC, vec![])] {
            let symbols = symbols(&[(0x100, first), (0x108, "second")], &[]);
            let functions = functions(&code, &symbols);
            let mut search = Search::new(&functions);
            assert_eq!(search.deepest(&symbols.names).unwrap().bytes, 4 + 8);
            assert_eq!(search.recursions(&symbols.names), expected);
        }
    }

    #[test]
    fn constants_are_not_read_as_instructions() {
        let code = [0xB401, 0x4770, 0xB0FF];
        assert_eq!(path(&code, &symbols(&[(0x100, "one")], &[0x104])).bytes, 4);
        assert_eq!(path(&code, &symbols(&[(0x100, "one")], &[])).bytes, 4 + 508);
    }

    #[test]
    fn a_frame_whose_size_is_in_a_register_is_refused_by_name() {
        let code: Vec<_> =
            [0xEBAD_u16, 0x0D04].iter().flat_map(|halfword| halfword.to_le_bytes()).collect();
        let error = read_code(0x100, &code, &symbols(&[(0x100, "one")], &[]), &mut BTreeMap::new())
            .unwrap_err();
        assert_eq!(error.to_string(), "one: the size of its frame is not a constant");
    }
}
