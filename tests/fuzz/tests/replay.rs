//! The corpus and seeded mutations of it, without a fuzzer.

use std::path::{Path, PathBuf};
use std::{fs, panic};

use massline_fuzz::TARGETS;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Mutations of each target: a few seconds' worth, or minutes' worth with `MASSLINE_LONG`.
fn mutations() -> u32 {
    if std::env::var_os("MASSLINE_LONG").is_some() { 1_000_000 } else { 20_000 }
}
/// Mutated inputs are truncated to this length, so that the run stays short.
const LONGEST: usize = 16 << 10;
/// Byte sequences with a meaning in the formats.
const TOKENS: [&[u8]; 14] = [
    b"    -1\n",
    b"    58\n",
    b"    58b     1     2          11",
    b"\n",
    b"nan",
    b"-1e999",
    b"9999999999999999999",
    b"0",
    b"[[node]]\nid = 1\n",
    b"[[[[[[[[",
    b"\0",
    b"\xff\xff\xff\xff",
    b"{'shape': (",
    b"\x93NUMPY\x01\x00",
];

fn corpus(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    let mut files: Vec<_> =
        fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{}", folder.display());
    files.into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).collect()
}

#[test]
fn no_input_of_the_corpus_breaks_its_target() {
    for (name, target) in TARGETS {
        for (path, bytes) in corpus(name) {
            let outcome = panic::catch_unwind(|| target(&bytes));
            assert!(outcome.is_ok(), "{}", path.display());
        }
    }
}

#[test]
fn no_seeded_mutation_breaks_its_target() {
    for (seed, (name, target)) in TARGETS.into_iter().enumerate() {
        let mut rng = ChaCha8Rng::seed_from_u64(seed as u64);
        let corpus: Vec<Vec<u8>> = corpus(name).into_iter().map(|(_, bytes)| bytes).collect();
        for round in 0..mutations() {
            let bytes = mutated(&corpus, &mut rng);
            if panic::catch_unwind(|| target(&bytes)).is_err() {
                let path = std::env::temp_dir().join(format!("massline-fuzz-{name}-{round}"));
                fs::write(&path, &bytes).unwrap();
                panic!("{name}, mutation {round}: kept as {}", path.display());
            }
        }
    }
}

fn mutated(corpus: &[Vec<u8>], rng: &mut ChaCha8Rng) -> Vec<u8> {
    let pick = |rng: &mut ChaCha8Rng| corpus[rng.random_range(0..corpus.len())].clone();
    let mut bytes = pick(rng);
    bytes.truncate(LONGEST);
    for _ in 0..rng.random_range(1..6) {
        let at = rng.random_range(0..=bytes.len());
        let end = (at + rng.random_range(0..40)).min(bytes.len());
        match rng.random_range(0..7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << rng.random_range(0..8),
            1 if at < bytes.len() => bytes[at] = rng.next_u32() as u8,
            2 => drop(bytes.drain(at..end)),
            3 => {
                let piece = bytes[at..end].to_vec();
                let to = rng.random_range(0..=bytes.len());
                bytes.splice(to..to, piece);
            }
            4 => {
                let token = TOKENS[rng.random_range(0..TOKENS.len())];
                let over = (at + token.len()).min(bytes.len());
                let end = if rng.random() { at } else { over };
                bytes.splice(at..end, token.iter().copied());
            }
            5 => bytes.truncate(at),
            _ => {
                let other = pick(rng);
                let from = rng.random_range(0..=other.len());
                bytes.truncate(at);
                bytes.extend(&other[from..]);
            }
        }
    }
    bytes.truncate(LONGEST);
    bytes
}
