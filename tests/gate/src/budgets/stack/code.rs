//! The functions of a linked image: the frame of each, and whom it calls.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, bail, ensure};
use object::read::elf::ElfFile32;
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};
use rustc_demangle::demangle;

use super::thumb::{self, Effect};

/// A function of an image.
#[derive(Debug, Default)]
pub struct Function {
    pub name: String,
    /// Bytes of stack.
    pub frame: u64,
    /// Addresses of the functions that it calls, jumps to, or loads the address of: if a function is called
    /// several times, its address may be kept in a register.
    pub calls: BTreeSet<u32>,
    pub calls_itself: bool,
}

/// The functions of an image by address.
pub type Functions = BTreeMap<u32, Function>;

/// Reads the functions of an image.
pub fn functions(image: &ElfFile32) -> anyhow::Result<Functions> {
    let symbols = Symbols::of(image)?;
    ensure!(
        !symbols.names.is_empty(),
        "the image has no names of functions; build it with strip = false"
    );
    let mut functions = Functions::new();
    for section in image.sections().filter(|section| section.kind() == SectionKind::Text) {
        read(u32::try_from(section.address())?, section.data()?, &symbols, &mut functions)?;
    }
    Ok(functions)
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
                    let name = || format!("{:#}", demangle(name));
                    symbols.names.entry(without_mark(address)).or_insert_with(name);
                }
                _ => {}
            }
        }
        Ok(symbols)
    }

    /// The function at which an address points, if it points at one.
    fn function(&self, pointer: u32) -> Option<u32> {
        let address = without_mark(pointer);
        (pointer != address && self.names.contains_key(&address)).then_some(address)
    }
}

/// The address of a function without the lowest bit, which says that it is Thumb code.
const fn without_mark(pointer: u32) -> u32 {
    pointer & !1
}

/// Reads the functions of a section that begins at `origin`.
fn read(
    origin: u32,
    code: &[u8],
    symbols: &Symbols,
    functions: &mut Functions,
) -> anyhow::Result<()> {
    let halfwords: Vec<_> = code.as_chunks().0.iter().map(|two| u16::from_le_bytes(*two)).collect();
    let mut instructions = None;
    let mut current = origin;
    // The lower halves of constants that are loaded by halves, of each register.
    let mut lower = [None; 16];
    let mut next = 0;
    while let Some(&first) = halfwords.get(next) {
        let address = origin + 2 * u32::try_from(next)?;
        // The constants before may have an odd length, and others begin there.
        for at in [address.wrapping_sub(1), address] {
            instructions = symbols.instructions.get(&at).or(instructions);
        }
        let instructions =
            instructions.context("code that is marked neither as instructions nor as constants")?;
        if let Some(name) = symbols.names.get(&address) {
            (current, lower) = (address, [None; 16]);
            functions.entry(address).or_default().name.clone_from(name);
        }
        let second = halfwords.get(next + 1).copied();
        next += 1;
        let function = functions.entry(current).or_default();
        if !instructions {
            let word = u32::from(first) | u32::from(second.unwrap_or(0)) << 16;
            function.calls.extend(symbols.function(word).filter(|_| address.is_multiple_of(4)));
            continue;
        }
        let effect = if thumb::is_long(first) {
            next += 1;
            thumb::long(first, second.context("an instruction ends behind its section")?)
        } else {
            thumb::short(first)
        };
        match effect {
            Effect::Nothing => {}
            Effect::Grows(bytes) => function.frame += u64::from(bytes),
            Effect::GrowsUnknown => {
                bail!("{}: the size of its frame is not a constant", function.name)
            }
            Effect::Call(distance) if address.wrapping_add_signed(distance) == current => {
                function.calls_itself = true
            }
            Effect::Call(distance) | Effect::Jump(distance) => {
                let target = address.wrapping_add_signed(distance);
                function
                    .calls
                    .extend((target != current).then(|| symbols.function(target | 1)).flatten());
            }
            Effect::LoadsLower(register, half) => lower[usize::from(register)] = Some(half),
            Effect::LoadsUpper(register, half) => {
                let word = lower[usize::from(register)]
                    .map(|lower| u32::from(half) << 16 | u32::from(lower));
                function.calls.extend(word.and_then(|word| symbols.function(word)));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORIGIN: u32 = 0x100;

    /// Functions of these names, and constants that begin at these addresses; the rest is instructions.
    fn symbols(names: &[(u32, &str)], constants: &[u32]) -> Symbols {
        let mut instructions = BTreeMap::from([(ORIGIN, true)]);
        instructions.extend(constants.iter().map(|at| (*at, false)));
        Symbols {
            names: names.iter().map(|(at, name)| (*at, (*name).to_owned())).collect(),
            instructions,
        }
    }

    fn read_all(code: &[u16], symbols: &Symbols) -> anyhow::Result<Functions> {
        let code: Vec<_> = code.iter().flat_map(|halfword| halfword.to_le_bytes()).collect();
        let mut functions = Functions::new();
        read(ORIGIN, &code, symbols, &mut functions).map(|()| functions)
    }

    #[test]
    fn frames_and_calls_are_those_of_the_instructions() {
        let code = [
            0xB5B0, 0xF000, 0xF802, 0xF000, 0xF804, // push four, bl small, bl large
            0xB401, 0x4770, // small: push one, return
            0xE7F7, 0x4770, // alone: b top
            0xF5AD, 0x4D80, 0xB401, 0xF7FF, 0xFFFB, // large: 16 384 bytes, push one, bl large
            0xF47F, 0xAFF0, 0xE7FC, // loop: bne.w top, b loop
        ];
        let names =
            [(0x100, "top"), (0x10A, "small"), (0x10E, "alone"), (0x112, "large"), (0x11C, "loop")];
        let functions = read_all(&code, &symbols(&names, &[])).unwrap();
        let frames: Vec<_> = functions.values().map(|function| function.frame).collect();
        assert_eq!(frames, [16, 4, 0, 16_388, 0]);
        assert_eq!(functions[&0x100].calls, BTreeSet::from([0x10A, 0x112]));
        assert_eq!(
            [0x10E, 0x11C].map(|at| functions[&at].calls.clone()),
            [BTreeSet::from([0x100]), BTreeSet::from([0x100])]
        );
        let itself: Vec<_> = functions.values().map(|function| function.calls_itself).collect();
        assert_eq!(itself, [false, false, false, true, false]);
    }

    #[test]
    fn a_function_whose_address_is_loaded_is_called() {
        let code = |pointer| {
            [
                0xF240, 0x1011, 0xF2C0, 0x0000, // one: movw r0, 0x111, movt r0, 0
                0x4770, 0x4770, // two
                pointer, 0x0000, // its constant
                0x4770, // three
            ]
        };
        let mut symbols = symbols(&[(0x100, "one"), (0x108, "two"), (0x110, "three")], &[0x10C]);
        symbols.instructions.insert(0x110, true);
        let calls = |pointer, function| {
            read_all(&code(pointer), &symbols).unwrap()[&function].calls.clone()
        };
        assert_eq!(calls(0, 0x100), BTreeSet::from([0x110]));
        assert_eq!(calls(0x111, 0x108), BTreeSet::from([0x110]));
        // No instruction of Thumb code is there, and no function.
        assert_eq!(
            [0x110, 0x113].map(|pointer| calls(pointer, 0x108)),
            [const { BTreeSet::new() }; 2]
        );
    }

    #[test]
    fn constants_are_not_read_as_instructions() {
        let code = [0xB401, 0x4770, 0xB0FF, 0xB401];
        let frame = |symbols: &Symbols| read_all(&code, symbols).unwrap()[&ORIGIN].frame;
        assert_eq!(frame(&symbols(&[(0x100, "one")], &[])), 4 + 508 + 4);
        let mut with_constant = symbols(&[(0x100, "one")], &[0x104]);
        assert_eq!(frame(&with_constant), 4);
        with_constant.instructions.insert(0x106, true);
        assert_eq!(frame(&with_constant), 4 + 4);
        // Of three bytes, or of one.
        for odd in [0x103, 0x105] {
            with_constant.instructions.insert(odd, false);
            assert_eq!(frame(&with_constant), 4 + 4);
        }
    }

    #[test]
    fn what_cannot_be_read_is_refused_by_name() {
        let refused =
            |code: &[u16], symbols: &Symbols| read_all(code, symbols).unwrap_err().to_string();
        let one = symbols(&[(0x100, "one")], &[]);
        assert_eq!(
            refused(&[0xEBAD, 0x0D04], &one),
            "one: the size of its frame is not a constant"
        );
        assert_eq!(refused(&[0xF000], &one), "an instruction ends behind its section");
        let without_marks = Symbols { instructions: BTreeMap::new(), ..one };
        assert_eq!(
            refused(&[0xB401], &without_marks),
            "code that is marked neither as instructions nor as constants"
        );
    }
}
