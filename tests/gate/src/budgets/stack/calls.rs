//! The deepest path of calls in a linked image, read from its machine code.
//!
//! The stack is measured on the emulated board only, and the compiler lays out the frames of each image
//! anew. So the frames of every image are added up along its calls. A method of a `dyn` object is not followed where it
//! is called; it is searched as the beginning of a path of its own. What is measured contains those of a campaign.
//! No function calls itself, directly or through others, because then nothing would bound the stack.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::fs;
use std::path::Path;

use anyhow::{Context, ensure};
use object::read::elf::ElfFile32;

use super::code::{self, Function, Functions};

/// The function through which every panic goes. A panic while another is reported is the last: the handlers see to
/// that.
const PANIC: &str = "core::panicking::panic_fmt";

/// Functions that call themselves, but not more than once: for a number below the normal range, and for the
/// rest of a text behind its last separator.
const CALL_THEMSELVES_ONCE: [&str; 2] =
    ["libm::math::frexp::frexp", "core::str::iter::SplitInternal<P>::next_back"];

/// Functions one of which calls the next, from the one that nobody calls.
#[derive(Debug)]
pub struct CallPath {
    /// The sum of the frames.
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
    let read = || {
        let bytes = fs::read(elf)?;
        let functions = code::functions(&ElfFile32::parse(&*bytes)?)?;
        let panics = functions.values().any(|function| function.name == PANIC);
        ensure!(
            panics,
            "the image has no function {PANIC}: has it another name in this compiler's library?"
        );
        deepest_of(&functions)
    };
    read().with_context(|| elf.display().to_string())
}

fn deepest_of(functions: &Functions) -> anyhow::Result<CallPath> {
    let panic = functions.iter().find(|(_, function)| function.name == PANIC).map(|(at, _)| *at);
    let mut report = Search::new(functions, panic, 0);
    let report_bytes = panic.map_or(0, |panic| report.follow(panic));
    let mut search = Search::new(functions, panic, report_bytes);
    let deepest = functions.keys().map(|&at| (search.depth(at), at)).max();
    let recursions: BTreeSet<_> = report.recursions().chain(search.recursions()).collect();
    let recursions = recursions.into_iter().collect::<Vec<_>>().join("; ");
    ensure!(
        recursions.is_empty(),
        "functions that call themselves, so that nothing bounds the stack: {recursions}"
    );
    let (bytes, first) = deepest.context("the image has no code")?;
    Ok(CallPath { bytes, frames: search.path(first) })
}

/// Searches the deepest path of calls.
#[derive(Debug)]
struct Search<'a> {
    functions: &'a Functions,
    /// The function that reports a panic, and what that takes. It is not followed: its callees may panic.
    panic: Option<u32>,
    report_bytes: u64,
    /// Of each function that has been searched: the bytes of its deepest path, and the call with which it goes on.
    deepest_paths: BTreeMap<u32, (u64, Option<u32>)>,
    /// The functions on the path that is being searched.
    open: Vec<u32>,
    /// Functions each of which calls the next, and the last one the first.
    cycles: Vec<Vec<u32>>,
}

impl<'a> Search<'a> {
    fn new(functions: &'a Functions, panic: Option<u32>, report_bytes: u64) -> Self {
        let (deepest_paths, open, cycles) = (BTreeMap::new(), Vec::new(), Vec::new());
        Self { functions, panic, report_bytes, deepest_paths, open, cycles }
    }

    /// The bytes of the deepest path that begins at a function.
    fn depth(&mut self, at: u32) -> u64 {
        if self.panic == Some(at) { self.report_bytes } else { self.follow(at) }
    }

    fn follow(&mut self, at: u32) -> u64 {
        if let Some((bytes, _)) = self.deepest_paths.get(&at) {
            return *bytes;
        }
        if let Some(before) = self.open.iter().position(|open| *open == at) {
            self.cycles.push(self.open[before..].to_vec());
            return 0;
        }
        let Some(function) = self.functions.get(&at) else { return 0 };
        self.open.push(at);
        if function.calls_itself && !calls_itself_once(function) {
            self.cycles.push(vec![at]);
        }
        let deepest = function.calls.iter().map(|&call| (self.depth(call), call)).max();
        self.open.pop();
        let bytes = frames(function) + deepest.map_or(0, |(bytes, _)| bytes);
        self.deepest_paths.insert(at, (bytes, deepest.map(|(_, call)| call)));
        bytes
    }

    /// Frames and names along the deepest path that begins at a function that has been searched.
    fn path(&self, first: u32) -> Vec<(u64, String)> {
        let (mut path, mut next) = (Vec::new(), Some(first));
        while let Some((at, function)) = next.and_then(|at| self.functions.get_key_value(&at)) {
            let bytes = if self.panic == next { self.report_bytes } else { frames(function) };
            path.push((bytes, function.name.clone()));
            next = self.deepest_paths.get(at).and_then(|(_, call)| *call);
        }
        path
    }

    /// The cycles that were found, as names.
    fn recursions(&self) -> impl Iterator<Item = String> {
        let name = |at| self.functions.get(at).map_or("", |function| function.name.as_str());
        self.cycles
            .iter()
            .map(move |cycle| cycle.iter().map(name).collect::<Vec<_>>().join(" calls "))
    }
}

fn calls_itself_once(function: &Function) -> bool {
    function.calls_itself && CALL_THEMSELVES_ONCE.contains(&function.name.as_str())
}

/// Bytes of the frames of a function when it is called.
fn frames(function: &Function) -> u64 {
    function.frame * if calls_itself_once(function) { 2 } else { 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Functions at 0, 1, … with these names, frames and calls.
    fn functions<const N: usize>(entries: [(&str, u64, &[u32]); N]) -> Functions {
        let function = |(at, (name, frame, calls)): (u32, (&str, u64, &[u32]))| {
            let (calls_itself, calls) =
                (calls.contains(&at), calls.iter().copied().filter(|call| *call != at));
            (at, Function { name: name.to_owned(), frame, calls: calls.collect(), calls_itself })
        };
        (0..).zip(entries).map(function).collect()
    }

    fn refused(functions: &Functions) -> String {
        deepest_of(functions).unwrap_err().to_string()
    }

    #[test]
    fn frames_add_up_along_the_deepest_path() {
        let functions = functions([
            ("leaf", 4, &[]),
            ("large", 16_384, &[0]),
            ("small", 8, &[0]),
            ("top", 16, &[2, 1]),
            ("alone", 508, &[]),
        ]);
        let path = deepest_of(&functions).unwrap();
        assert_eq!(path.bytes, 16 + 16_384 + 4);
        assert_eq!(path.to_string(), "      16  top\n   16384  large\n       4  leaf\n");
    }

    #[test]
    fn functions_that_call_themselves_are_named() {
        let text = refused(&functions([("a", 4, &[1]), ("b", 8, &[2]), ("c", 8, &[1])]));
        assert!(text.ends_with(": b calls c"), "{text}");
        let text = refused(&functions([("a", 4, &[0])]));
        assert!(text.ends_with(": a"), "{text}");
        let path = deepest_of(&functions([(CALL_THEMSELVES_ONCE[0], 24, &[0])])).unwrap();
        assert_eq!(path.bytes, 48);
    }

    #[test]
    fn a_panic_while_a_panic_is_reported_is_no_recursion_and_hides_none() {
        let of_report = |calls| {
            let top: (_, _, &[u32]) = ("top", 500, calls);
            functions([(PANIC, 32, &[1]), ("report", 100, &[2]), ("cut", 10, &[0]), top])
        };
        assert_eq!(deepest_of(&of_report(&[0])).unwrap().bytes, 500 + 32 + 100 + 10);
        // What the report calls has its true depth elsewhere, too: with a report of its own.
        assert_eq!(deepest_of(&of_report(&[2])).unwrap().bytes, 500 + 10 + 32 + 100 + 10);
        let hidden =
            functions([("v", 1, &[1, 3]), (PANIC, 1, &[2]), ("w", 1, &[3]), ("u", 1, &[0])]);
        let text = refused(&hidden);
        assert!(text.ends_with("v calls u"), "{text}");
    }
}
