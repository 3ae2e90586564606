//! The grammar of unit labels: `m/s^2`, `m.s-2`, `(mm/s²)/N`, `m/(N s^2)`, `g rms`.

use super::UnitFault;
use super::symbols::{Meaning, Unit, meaning};

/// The longest label that is read, bytes.
const LONGEST: usize = 64;
/// The largest power that is read.
const LARGEST_POWER: i32 = 4;

/// Words after a unit that say which amplitude a value is: the factor cancels in a ratio, and a record over time has
/// none.
const AMPLITUDES: [&str; 6] = ["0-peak", "0-pk", "0-p", "peak", "pk", "rms"];
/// Words after a unit that say that a value is twice the amplitude.
const PEAK_TO_PEAK: [&str; 7] =
    ["peak-to-peak", "peak-peak", "peak to peak", "pk-pk", "pkpk", "p-p", "pp"];

/// What a label may mean: nothing where it is not understood, more than one unit where products and powers can be read
/// in more than one way.
///
/// # Errors
/// For the unit of an unscaled signal, and for a peak-to-peak value.
pub(super) fn readings(label: &str) -> Result<Vec<Unit>, UnitFault> {
    if label.len() > LONGEST {
        return Ok(Vec::new());
    }
    let text = without_amplitude(&plain(label))?;
    let mut units = Vec::new();
    for [divides_all, splits] in [[false, false], [true, false], [false, true], [true, true]] {
        let mut scanner = Scanner { rest: &text, divides_all, splits, unscaled: false };
        let unit = scanner.product(0).filter(|_| scanner.rest.is_empty());
        if unit.is_some() && scanner.unscaled {
            return Err(UnitFault::NeedsSensitivity);
        }
        units.extend(unit);
    }
    Ok(units)
}

/// A label in the characters that the grammar uses.
fn plain(label: &str) -> String {
    let text: String = label
        .chars()
        .map(narrow)
        .map(|c| match c {
            '⁰' => '0',
            '¹' => '1',
            '²' => '2',
            '³' => '3',
            '⁴' => '4',
            '⁻' | '−' | '–' => '-',
            '·' | '⋅' | '×' | '•' | '∙' | '.' => '*',
            '∕' | '⁄' | '÷' => '/',
            'μ' => 'µ',
            '’' => '\'',
            '[' | '{' => '(',
            ']' | '}' => ')',
            c => c,
        })
        .collect();
    text.trim().replace("**", "^")
}

/// The character of ASCII whose wide form, as in Japanese text, this one is.
fn narrow(wide: char) -> char {
    const DISTANCE: u32 = '！' as u32 - '!' as u32;
    match wide {
        '！'..='～' => char::from_u32(wide as u32 - DISTANCE).unwrap_or(wide),
        other => other,
    }
}

/// The word after a unit that says which amplitude its values are.
pub(super) fn amplitude(label: &str) -> Option<&'static str> {
    let text = plain(label);
    AMPLITUDES.iter().find(|word| before(&text, word).is_some()).copied()
}

/// The label without the word that says which amplitude its values are.
fn without_amplitude(text: &str) -> Result<String, UnitFault> {
    if PEAK_TO_PEAK.iter().any(|word| before(text, word).is_some()) {
        return Err(UnitFault::PeakToPeak);
    }
    let Some(cut) = AMPLITUDES.iter().find_map(|word| before(text, word)) else {
        return Ok(text.to_owned());
    };
    let count = |bracket| cut.matches(bracket).count();
    Ok(cut.to_owned() + &")".repeat(count('(').saturating_sub(count(')'))))
}

/// The text before this word at its end, which is not empty.
fn before<'a>(text: &'a str, word: &str) -> Option<&'a str> {
    // Lower case of ASCII changes no length.
    let lower = text.trim_end_matches([')', ' ']).to_ascii_lowercase();
    let front = lower.strip_suffix(word)?.trim_end_matches([' ', '_', ',', '(', '-']);
    text.get(..front.len()).filter(|front| !front.is_empty())
}

/// A cursor over a label.
struct Scanner<'a> {
    rest: &'a str,
    /// Whether a slash divides by all that follows, as in `m/N s^2`, or by the next unit alone.
    divides_all: bool,
    /// Whether words are split where that gives another meaning: `ms-2` is `m s-2`.
    splits: bool,
    unscaled: bool,
}

impl Scanner<'_> {
    /// A product of units up to the end or to a closing bracket; `depth` is the number of open brackets.
    fn product(&mut self, depth: usize) -> Option<Unit> {
        let mut product = self.factor(depth)?;
        let mut sign = 1;
        loop {
            self.skip_blanks();
            match self.rest.chars().next() {
                None | Some(')') => return Some(product),
                Some('/') => {
                    sign = -1;
                    self.skip(1);
                }
                Some(c) => {
                    if c == '*' {
                        self.skip(1);
                    }
                    if !self.divides_all {
                        sign = 1;
                    }
                    // Only a slash continues after "per".
                    if self.skip_word("per ") {
                        sign = -1;
                    }
                }
            }
            product = product.times(self.factor(depth)?, sign);
        }
    }

    /// A unit or a product in brackets, with its power; or 1.
    fn factor(&mut self, depth: usize) -> Option<Unit> {
        self.skip_blanks();
        if self.rest.starts_with('(') {
            self.skip(1);
            let inner = self.product(depth + 1)?;
            self.rest = self.rest.strip_prefix(')')?;
            return Some(Unit::ONE.times(inner, self.power()?));
        }
        let word = self.word();
        if word.is_empty() {
            self.rest = self.rest.strip_prefix('1')?;
            let whole = !self.rest.starts_with(|c: char| c.is_ascii_digit() || c == '^');
            return whole.then_some(Unit::ONE);
        }
        let power = self.power()?;
        self.unit(&word, power)
    }

    /// The unit of a word to a power, which is that of its last part.
    fn unit(&mut self, word: &str, power: i32) -> Option<Unit> {
        let meaning = meaning(word);
        if (meaning.is_none() || self.splits && power < 0)
            && let Some((front, last)) = split(word)
        {
            let front = self.unit(front, 1)?;
            return Some(front.times(self.unit(last, 1)?, power));
        }
        match meaning? {
            Meaning::Unit(unit) => Some(Unit::ONE.times(unit, power)),
            Meaning::Unscaled => {
                self.unscaled = true;
                Some(Unit::ONE)
            }
        }
    }

    /// The power that stands here, 1 for none.
    fn power(&mut self) -> Option<i32> {
        let rest = self.rest;
        let marked = rest.trim_start().strip_prefix('^').map(str::trim_start);
        let text = marked.unwrap_or(rest);
        let (text, bracket) = match text.strip_prefix('(').filter(|_| marked.is_some()) {
            Some(inner) => (inner, true),
            None => (text, false),
        };
        let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
        let count = digits.chars().take_while(char::is_ascii_digit).count();
        if count == 0 {
            return marked.is_none().then_some(1);
        }
        let (number, after) = text.split_at_checked(text.len() - digits.len() + count)?;
        self.rest = if bracket { after.strip_prefix(')')? } else { after };
        let power: i32 = number.parse().ok()?;
        (power != 0 && power.abs() <= LARGEST_POWER).then_some(power)
    }

    /// The letters that stand here, with signs that belong to a name: `g's`, `lb-f`, `%FS`, `g0`.
    fn word(&mut self) -> String {
        let rest = self.rest;
        let mut end = 0;
        for (at, c) in rest.char_indices() {
            let next = rest.get(at + c.len_utf8()..).and_then(|after| after.chars().next());
            let belongs = c.is_alphabetic()
                || "%'_°".contains(c)
                || (c == '-' && at > 0 && next.is_some_and(char::is_alphabetic))
                || (c == '0' && rest.starts_with("g0"));
            if !belongs {
                break;
            }
            end = at + c.len_utf8();
        }
        let (word, after) = rest.split_at_checked(end).unwrap_or(("", rest));
        self.rest = after;
        word.to_owned()
    }

    fn skip(&mut self, bytes: usize) {
        self.rest = self.rest.get(bytes..).unwrap_or_default();
    }

    fn skip_word(&mut self, word: &str) -> bool {
        let begins = self.rest.get(..word.len()).is_some_and(|s| s.eq_ignore_ascii_case(word));
        if begins {
            self.skip(word.len());
        }
        begins
    }

    fn skip_blanks(&mut self) {
        self.rest = self.rest.trim_start();
    }
}

/// The parts of a word of two units: at a hyphen, or before a second.
fn split(word: &str) -> Option<(&str, &str)> {
    let parts = word.rsplit_once('-').or_else(|| {
        let (front, last) = word.split_at_checked(word.len().checked_sub(1)?)?;
        last.eq_ignore_ascii_case("s").then_some((front, last))
    });
    parts.filter(|(front, last)| !front.is_empty() && !last.is_empty())
}
