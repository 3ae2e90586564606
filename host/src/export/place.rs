//! Values of a document with the way to them, which errors name.

use serde_json::Value;

use crate::error::{Error, Result};

/// Difference of two elements that are the same by symmetry, relative to their size: the rounding of a rig's numbers.
const SYMMETRY: f64 = 1e-6;

/// What to do with a document that is not as expected.
pub(super) const ADVICE: &str = "give an archive, or the whole output of massline solve, measure, results get, \
                                 simulate or replay with --json";

/// A value of a document, and how it is reached.
#[derive(Clone, Debug)]
pub(super) struct Place<'a> {
    pub(super) value: &'a Value,
    path: String,
    pub(super) source: &'a str,
}

impl<'a> Place<'a> {
    /// The whole of a document that is called `source` in errors.
    pub(super) fn whole(value: &'a Value, source: &'a str) -> Self {
        Self { value, path: String::new(), source }
    }

    pub(super) fn key(&self, key: &str) -> Result<Self> {
        let path = if self.path.is_empty() { key.into() } else { format!("{}.{key}", self.path) };
        match self.value.get(key) {
            Some(value) => Ok(Self { value, path, source: self.source }),
            None => Err(Error::input(
                "result_key_missing",
                format!("{}: {path}: the key is missing; {ADVICE}", self.source),
            )),
        }
    }

    /// The entry of a list; null behind its end.
    pub(super) fn at(&self, index: usize) -> Self {
        const NULL: &Value = &Value::Null;
        let value = self.value.get(index).unwrap_or(NULL);
        Self { value, path: format!("{}[{index}]", self.path), source: self.source }
    }

    pub(super) fn entries(&self) -> Result<Vec<Self>> {
        let list = self.value.as_array().ok_or_else(|| self.wrong("a list"))?;
        Ok((0..list.len()).map(|k| self.at(k)).collect())
    }

    pub(super) fn number(&self) -> Result<f64> {
        self.value.as_f64().filter(|value| value.is_finite()).ok_or_else(|| self.wrong("a number"))
    }

    pub(super) fn numbers<const N: usize>(&self) -> Result<[f64; N]> {
        self.has_entries(N)?;
        let mut numbers = [0.0; N];
        for (k, number) in numbers.iter_mut().enumerate() {
            *number = self.at(k).number()?;
        }
        Ok(numbers)
    }

    pub(super) fn rows<const N: usize>(&self) -> Result<[[f64; N]; N]> {
        self.has_entries(N)?;
        let mut rows = [[0.0; N]; N];
        for (k, row) in rows.iter_mut().enumerate() {
            *row = self.at(k).numbers()?;
        }
        Ok(rows)
    }

    fn has_entries(&self, count: usize) -> Result<()> {
        let there = self.value.as_array().is_some_and(|list| list.len() == count);
        if there { Ok(()) } else { Err(self.wrong(&format!("a list of {count}"))) }
    }

    /// Checks a matrix; `size` is the square of the size of what an index stands for.
    pub(super) fn is_symmetric<const N: usize>(
        &self,
        rows: &[[f64; N]; N],
        size: impl Fn(usize) -> f64,
    ) -> Result<()> {
        for i in 0..N {
            for j in 0..i {
                let scale = (size(i).abs() * size(j).abs()).sqrt().max(rows[i][j].abs());
                if (rows[i][j] - rows[j][i]).abs() > SYMMETRY * scale {
                    let wanted = format!("equal to [{j}][{i}], because the matrix is symmetric");
                    return Err(self.at(i).at(j).wrong(&wanted));
                }
            }
        }
        Ok(())
    }

    pub(super) fn wrong(&self, wanted: &str) -> Error {
        /// Longest excerpt, characters.
        const EXCERPT: usize = 40;
        let text = self.value.to_string();
        let mut found: String = text.chars().take(EXCERPT).collect();
        if found.len() < text.len() {
            found.push('…');
        }
        let message = format!("{}: {}: {found} is not {wanted}; {ADVICE}", self.source, self.path);
        Error::input("result_value_wrong", message)
    }
}
