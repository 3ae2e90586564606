//! Flash and static RAM of a linked image.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use massline_boards::Board;
use object::Endianness;
use object::elf::{FileHeader32, PT_LOAD, SHF_ALLOC, SHF_WRITE};
use object::read::elf::{FileHeader, ProgramHeader, SectionHeader};

/// Sizes of an image, bytes.
#[derive(Clone, Copy, Debug)]
pub struct Image {
    /// Everything that is loaded: vectors, code, constants, initial values of statics.
    pub flash: u64,
    /// Statics: `.data`, `.bss` and uninitialised memory.
    pub static_ram: u64,
}

/// Builds the firmware of a board and returns its ELF file. It lies in its target's folder at the same
/// place as `emulated`, that of the emulated board.
pub fn build(checkout: &Path, board: &Board, emulated: &Path) -> anyhow::Result<PathBuf> {
    let (package, target) = (board.package(), &board.target);
    let status = massline_boards::image::cargo(checkout, "build")?
        .args(["-p", &package, "--target", target])
        .status()
        .context("cargo")?;
    ensure!(status.success(), "{package} does not build ({status})");
    let [profile, targets] = [1, 3].map(|up| emulated.ancestors().nth(up));
    let profile = profile.and_then(Path::file_name).context("an image without a folder")?;
    let targets = targets.context("an image without a folder of targets")?;
    Ok(targets.join(target).join(profile).join(package))
}

/// Reads the sizes out of an ELF file.
pub fn measure(elf: &Path) -> anyhow::Result<Image> {
    let bytes = fs::read(elf).with_context(|| elf.display().to_string())?;
    let header = FileHeader32::<Endianness>::parse(&*bytes)?;
    let endian = header.endian()?;
    let flash = header
        .program_headers(endian, &*bytes)?
        .iter()
        .filter(|segment| segment.p_type(endian) == PT_LOAD)
        .map(|segment| u64::from(segment.p_filesz(endian)))
        .sum();
    let in_ram = SHF_ALLOC | SHF_WRITE;
    let static_ram = header
        .section_headers(endian, &*bytes)?
        .iter()
        .filter(|section| section.sh_flags(endian) & in_ram == in_ram)
        .map(|section| u64::from(section.sh_size(endian)))
        .sum();
    Ok(Image { flash, static_ram })
}
