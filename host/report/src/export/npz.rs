//! NumPy archive: the arrays of the other numeric formats, and texts with units, frame and convention.

use std::io::{self, Cursor, Write};

use massline_files::npy::Header;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::heading;
use super::subject::ExportedResult;
use massline_result::{Error, Result};

/// An archive. What the result does not have is NaN.
pub(super) fn write(exported: &ExportedResult) -> Result<Vec<u8>> {
    archive(exported)
        .map_err(|e| Error::internal("npz", format!("the archive is not written: {e}")))
}

fn archive(exported: &ExportedResult) -> io::Result<Vec<u8>> {
    let body = &exported.body;
    let placement = &exported.placement;
    let mut archive = Archive(ZipWriter::new(Cursor::new(Vec::new())));
    let ten = |values: Option<super::Vector10>| match values {
        Some(values) => values.iter().copied().collect(),
        None => vec![f64::NAN; 10],
    };
    archive.numbers("value", &[10], &ten(Some(exported.theta())))?;
    archive.numbers("sigma", &[10], &ten(exported.sigma()))?;
    let [low, high] = exported.interval().map_or([None; 2], |ends| ends.map(Some));
    archive.numbers("low95", &[10], &ten(low))?;
    archive.numbers("high95", &[10], &ten(high))?;
    // Symmetric matrices are the same by rows and by columns.
    let covariance = exported.covariance().map(|c| c.as_slice().to_vec());
    archive.numbers("covariance", &[10, 10], &covariance.unwrap_or(vec![f64::NAN; 100]))?;
    archive.numbers("mass", &[], &[body.mass])?;
    archive.numbers("center_of_mass", &[3], body.center_of_mass.as_slice())?;
    archive.numbers("inertia", &[3, 3], body.inertia.as_slice())?;
    archive.numbers("frame_origin", &[3], placement.origin.as_slice())?;
    archive.numbers("frame_axes", &[3, 3], placement.axes.transpose().as_slice())?;
    archive.texts("order", &[10], &heading::order())?;
    for (name, text) in texts(exported) {
        archive.texts(name, &[], &[&text])?;
    }
    Ok(archive.0.finish()?.into_inner())
}

/// What is said in words.
pub(super) fn texts(exported: &ExportedResult) -> [(&'static str, String); 9] {
    let units = exported.units;
    [
        ("title", exported.test.title.clone()),
        ("method", exported.method().to_owned()),
        ("source", exported.test.source.clone()),
        ("program", heading::PROGRAM.into()),
        ("convention", heading::convention().into()),
        ("units", units.words()),
        ("frame", heading::frame(exported)),
        ("verdict", heading::verdict(exported)),
        ("physical", exported.violated_condition().unwrap_or("yes".into())),
    ]
}

struct Archive(ZipWriter<Cursor<Vec<u8>>>);

impl Archive {
    /// Begins an array.
    fn begin(&mut self, name: &str, descr: String, shape: &[u64]) -> io::Result<()> {
        // The same result makes the same bytes, whatever the time.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::default());
        self.0.start_file(format!("{name}.npy"), options)?;
        let header = Header { descr, fortran_order: false, shape: shape.to_vec() };
        self.0.write_all(&header.to_bytes())
    }

    fn numbers(&mut self, name: &str, shape: &[u64], values: &[f64]) -> io::Result<()> {
        self.begin(name, "<f8".into(), shape)?;
        values.iter().try_for_each(|value| self.0.write_all(&value.to_le_bytes()))
    }

    /// Texts in the fixed width of the longest, as four bytes for each character.
    fn texts(&mut self, name: &str, shape: &[u64], texts: &[&str]) -> io::Result<()> {
        let width = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
        self.begin(name, format!("<U{width}"), shape)?;
        for text in texts {
            let padded = text.chars().map(u32::from).chain(std::iter::repeat(0)).take(width);
            for character in padded {
                self.0.write_all(&character.to_le_bytes())?;
            }
        }
        Ok(())
    }
}
