//! `massline plot`: pictures of a result.

use std::path::{Path, PathBuf};

use crate::output::Output;
use crate::support::files::ReplaceArgs;
use crate::support::sources::SourceArgs;
use crate::{Error, Result};
use massline_files::file;
use massline_report::document::DrawnPictures;
use massline_report::picture::{DrawnFile, FONT_LICENCE, ImageFormat, Picture};
use massline_report::result_file::ResultFile;
use massline_result::FilePath;

/// Arguments of `massline plot`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
RESULT is an archive (FRAME.massline), the output of solve, modes, measure, results get, simulate or
replay with --json, or a report (FRAME.html, of several results BOTH.html#result-2). Every picture
that it has the data for is drawn, or those of --picture. Of several results, the best answer of each
is drawn side by side. The hits need an archive of measure --records; the frequency responses need an
archive, or with --responses the file that the result was solved from.

Examples:
  massline plot frame.massline
  massline plot frame.massline --picture estimates -o frame.png
  massline plot frame.massline --picture pulls --picture hits -o pictures
  massline solve wheel.toml wheel.uff --json > wheel.json
  massline plot wheel.json --layout wheel.toml --responses wheel.uff -o pictures
  massline plot test-1.massline test-2.massline -o both.svg")]
pub struct Args {
    #[command(flatten)]
    sources: SourceArgs,
    /// Draw this picture only; may be given several times.
    #[arg(long, value_enum, value_name = "PICTURE")]
    picture: Vec<Picture>,
    /// Print the licence of the font in the program, DejaVu Sans, and draw nothing.
    #[arg(long, exclusive = true)]
    font_licence: bool,
    /// File of one picture (.svg or .png), or folder [default: this folder].
    #[arg(short, long, value_name = "PATH")]
    output: Option<PathBuf>,
    /// Format of the files in a folder.
    #[arg(long, value_enum, value_name = "FORMAT", default_value = "svg")]
    format: ImageFormat,
    #[command(flatten)]
    replace: ReplaceArgs,
}

/// Runs the command.
///
/// # Errors
/// When a result cannot be read or has nothing to draw, or a file cannot be written.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    if args.font_licence {
        return output.verbatim(FONT_LICENCE.trim_end());
    }
    let (wanted, format) = (args.requested_pictures(), args.file_format()?);
    let sources = args.sources.read(output)?;
    let mut drawn = Vec::new();
    for picture in wanted {
        let files = picture.of(&sources, format)?;
        if files.is_empty() && !args.picture.is_empty() {
            return Err(nothing(picture, &sources));
        }
        drawn.extend(files);
    }
    if drawn.is_empty() {
        return Err(nothing(Picture::Estimates, &sources));
    }
    if let (Some((path, _)), [_, _, ..]) = (args.one_file()?, &drawn[..]) {
        let text = format!(
            "{}: there is a picture for each of {} hit DOFs; give a folder",
            path.display(),
            drawn.len()
        );
        return Err(Error::input("usage", text));
    }
    let mut written = Vec::new();
    for drawn in drawn {
        let path = args.path_of(&drawn, format)?;
        file::write(&path, &drawn.bytes, args.replace.existing())?;
        written.push(FilePath::from(path));
    }
    let value = DrawnPictures { written };
    output.answer(&value, |_| {
        let lines = value.written.iter().map(|path| path.display().to_string());
        lines.collect::<Vec<_>>().join("\n")
    })
}

fn nothing(picture: Picture, sources: &[ResultFile]) -> Error {
    let names: Vec<&str> = sources.iter().map(|source| source.name.as_str()).collect();
    let (names, name, needs) = (names.join(", "), picture.name(), picture.needs());
    let text =
        format!("{names}: there is nothing to draw for the picture {name}: it needs {needs}");
    Error::undetermined("nothing_to_draw", text)
}

impl Args {
    fn requested_pictures(&self) -> Vec<Picture> {
        match (&self.picture[..], &self.sources.results[..]) {
            ([], [_]) => Picture::all().to_vec(),
            // The others show one result.
            ([], _) => vec![Picture::Estimates],
            (wanted, _) => wanted.to_vec(),
        }
    }

    /// The file of one picture that `--output` names.
    ///
    /// # Errors
    /// Exit 2 for a name that ends as that of a file in another format.
    fn one_file(&self) -> Result<Option<(&Path, ImageFormat)>> {
        let Some(path) = self.output.as_deref() else { return Ok(None) };
        if path == Path::new("-") {
            return Err(Error::input("usage", "-o -: give the name of a file or of a folder"));
        }
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        let format = match extension.to_ascii_lowercase().as_str() {
            "svg" => ImageFormat::Svg,
            "png" => ImageFormat::Png,
            _ if extension.is_empty() || is_folder(path) => return Ok(None),
            other => {
                let text = format!(
                    "{}: a picture is a .svg or a .png file, not .{other}; a folder of this name must end with a slash",
                    path.display()
                );
                return Err(Error::input("usage", text));
            }
        };
        Ok(Some((path, format)))
    }

    /// # Errors
    /// Exit 2 for one file and several pictures.
    fn file_format(&self) -> Result<ImageFormat> {
        let Some((path, format)) = self.one_file()? else { return Ok(self.format) };
        if self.requested_pictures().len() == 1 {
            return Ok(format);
        }
        let text = format!(
            "{}: one file is for one picture; choose it with --picture, or give a folder",
            path.display()
        );
        Err(Error::input("usage", text))
    }

    /// Where a picture is written.
    ///
    /// # Errors
    /// Exit 2 when the folder cannot be made.
    fn path_of(&self, drawn: &DrawnFile, format: ImageFormat) -> Result<PathBuf> {
        if let Some((path, _)) = self.one_file()? {
            return Ok(path.to_owned());
        }
        let folder = self.output.as_deref().unwrap_or(Path::new(""));
        if !folder.as_os_str().is_empty() {
            std::fs::create_dir_all(folder).map_err(|e| {
                let text = format!("{}: the folder cannot be made: {e}", folder.display());
                Error::input("file_not_writable", text)
            })?;
        }
        let extension = match format {
            ImageFormat::Svg => "svg",
            ImageFormat::Png => "png",
        };
        let (stem, name) = (self.sources.stem("results"), drawn.stem());
        Ok(folder.join(format!("{stem}-{name}.{extension}")))
    }
}

/// True for a folder that exists, or a path that ends as one.
fn is_folder(path: &Path) -> bool {
    path.is_dir() || path.as_os_str().to_string_lossy().ends_with(std::path::is_separator)
}
