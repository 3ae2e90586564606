//! Boards that appear as a USB drive: a file that is copied there is written to the flash.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use massline_boards::BootLoader;
use massline_boards::boot_loader::{StLink, Uf2};

use super::board::Board;
use super::plan::Plan;
use super::{ProgressObserver, Step, uf2};
use massline_files::file;
use massline_result::{Error, Result};

/// The file format of a drive, and how the drive is recognised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind<'b> {
    /// A boot loader that accepts UF2.
    Uf2(&'b Uf2),
    /// An ST-LINK that accepts a plain binary.
    StLink(&'b StLink),
}

/// What is known after the drive has taken the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveOutcome {
    /// The board has started the program, which it does only after receiving all of it.
    Started,
    /// The file was copied, and the board reported no failure.
    Unconfirmed,
}

/// Timeout for the board to process the file: 400 KiB take some 10 s over an ST-LINK.
const LATE: Duration = Duration::from_secs(60);
/// How long to wait for the ST-LINK's drive to come back, if the system mounts drives automatically.
const BACK: Duration = Duration::from_secs(8);
/// Polling interval: the system does not notify this process when a drive disappears.
const POLL: Duration = Duration::from_millis(50);

impl<'b> Kind<'b> {
    /// The kind of drive of this board; `None` when it has none.
    pub fn of(board: &'b Board) -> Option<Self> {
        match board.boot_loader.as_ref()? {
            BootLoader::Uf2(drive) => Some(Self::Uf2(drive)),
            BootLoader::StLink(drive) => Some(Self::StLink(drive)),
            BootLoader::Dfu(_) => None,
        }
    }

    fn file_name(self) -> &'static str {
        match self {
            Self::Uf2(_) => "massline.uf2",
            Self::StLink(_) => "massline.bin",
        }
    }

    fn content(self, plan: &Plan) -> Vec<u8> {
        match self {
            Self::Uf2(drive) => uf2::blocks(&plan.image, drive.family),
            Self::StLink(_) => plan.image.flat().bytes,
        }
    }

    /// True when this mounted drive is of this kind.
    fn is(self, drive: &Path) -> bool {
        match self {
            Self::Uf2(uf2) => {
                read_text(&drive.join("INFO_UF2.TXT")).is_some_and(|text| text.contains(&uf2.model))
            }
            Self::StLink(_) => ["DETAILS.TXT", "MBED.HTM"].iter().any(|f| drive.join(f).is_file()),
        }
    }

    /// True for a drive of this kind that belongs to this board: an ST-LINK is named after its board. On Windows the
    /// path has no name, so that the user must say which ST-LINK is meant.
    fn is_of_board(self, drive: &Path) -> bool {
        let label = drive.file_name().map(|name| name.to_string_lossy());
        let named = match self {
            Self::Uf2(_) => true,
            Self::StLink(link) => label.is_some_and(|label| label.contains(&link.label)),
        };
        self.is(drive) && named
    }

    fn missing(self) -> Error {
        let (description, steps, label) = match self {
            Self::Uf2(Uf2 { steps, label, model, .. }) => {
                (format!("of the boot loader of an {model}"), steps, label.clone())
            }
            Self::StLink(StLink { steps, label }) => {
                (format!("of an ST-LINK named {label}"), steps, format!("*{label}"))
            }
        };
        Error::device(
            "no_drive",
            format!(
                "no drive {description}: {steps}. The cable must carry data. {}",
                if cfg!(windows) {
                    "If Explorer shows the drive, give its letter: --drive E:\\".to_owned()
                } else {
                    format!(
                        "If your system does not mount drives by itself: udisksctl mount -b \
                         /dev/disk/by-label/{label}, and give its path by --drive"
                    )
                }
            ),
        )
    }
}

/// The only mounted drive of this kind, or the one that the user named.
///
/// # Errors
/// `no_drive`, `several_drives`, `wrong_drive`.
pub fn find(kind: Kind<'_>, named: Option<&Path>) -> Result<PathBuf> {
    if let Some(drive) = named {
        if kind.is(drive) {
            return Ok(drive.to_owned());
        }
        let wanted = match kind {
            Kind::Uf2(Uf2 { model, .. }) => format!(
                "the boot loader of an {model}: it has no INFO_UF2.TXT that names the {model}"
            ),
            Kind::StLink(_) => "an ST-LINK: it has neither DETAILS.TXT nor MBED.HTM".into(),
        };
        let message = format!("{} is not the drive of {wanted}", drive.display());
        return Err(Error::input("wrong_drive", message));
    }
    let mut drives: Vec<_> = mounted().into_iter().filter(|d| kind.is_of_board(d)).collect();
    match (drives.pop(), drives.pop()) {
        (Some(drive), None) => Ok(drive),
        (Some(one), Some(other)) => Err(Error::device(
            "several_drives",
            format!(
                "both {} and {} match; choose one with --drive",
                one.display(),
                other.display()
            ),
        )),
        (None, _) => Err(kind.missing()),
    }
}

/// The text of a small file on a drive.
fn read_text(path: &Path) -> Option<String> {
    file::read(path, 1 << 16).ok().map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
}

/// The mount points of FAT file systems, of all volumes on macOS, or all drives of Windows.
fn mounted() -> Vec<PathBuf> {
    if cfg!(windows) {
        let drives = ('A'..='Z').map(|letter| PathBuf::from(format!("{letter}:\\")));
        return drives.filter(|drive| drive.is_dir()).collect();
    }
    match fs::read_to_string("/proc/self/mounts") {
        Ok(mounts) => mounts.lines().filter_map(fat_drive).collect(),
        // macOS.
        Err(_) => fs::read_dir("/Volumes")
            .map(|volumes| volumes.filter_map(|v| Some(v.ok()?.path())).collect())
            .unwrap_or_default(),
    }
}

/// The mount point of a FAT file system in a line of `/proc/self/mounts`.
fn fat_drive(line: &str) -> Option<PathBuf> {
    let mut fields = line.split(' ');
    let (_, place, system) = (fields.next()?, fields.next()?, fields.next()?);
    let fat = ["vfat", "msdos", "exfat", "fuseblk"].contains(&system);
    // Blanks are escaped in octal.
    fat.then(|| PathBuf::from(place.replace("\\040", " ")))
}

/// Copies the image to the drive and waits until the board has taken it.
///
/// # Errors
/// `drive_not_written`, `drive_not_taken`, `flash_refused` with the board's message.
pub fn flash(
    kind: Kind<'_>,
    drive: &Path,
    plan: &Plan,
    watch: &mut dyn ProgressObserver,
) -> Result<DriveOutcome> {
    let bytes = kind.content(plan);
    let file = drive.join(kind.file_name());
    // A failure file that exists already is about an earlier attempt.
    let before = complaint(drive);
    copy(&file, &bytes, watch)?;
    let start = Instant::now();
    while file.exists() {
        if start.elapsed() > LATE {
            return Err(Error::device(
                "drive_not_taken",
                format!(
                    "{} has not taken {} within {} s",
                    drive.display(),
                    kind.file_name(),
                    LATE.as_secs()
                ),
            ));
        }
        if before.is_none() {
            refused(drive)?;
        }
        thread::sleep(POLL);
    }
    match kind {
        Kind::Uf2(_) => Ok(DriveOutcome::Started),
        Kind::StLink(_) => {
            let start = Instant::now();
            while !kind.is(drive) && start.elapsed() < BACK {
                thread::sleep(POLL);
            }
            refused(drive)?;
            Ok(DriveOutcome::Unconfirmed)
        }
    }
}

fn copy(path: &Path, bytes: &[u8], watch: &mut dyn ProgressObserver) -> Result<()> {
    let failed = |error: io::Error| {
        Error::device("drive_not_written", format!("{}: {error}", path.display()))
    };
    let mut file = File::create(path).map_err(failed)?;
    let mut done = 0;
    for part in bytes.chunks(16 << 10) {
        file.write_all(part).map_err(failed)?;
        done += part.len() as u64;
        watch.at(Step::Write, done, bytes.len() as u64)?;
    }
    // This may fail: the board can disconnect after the last block, before the directory is written.
    let _ = file.sync_all();
    Ok(())
}

/// The text of the file that the ST-LINK writes on its drive after a failure; an empty file is still being
/// written.
fn complaint(drive: &Path) -> Option<String> {
    let text = read_text(&drive.join("FAIL.TXT"))?;
    let text: String = text.trim().chars().filter(|c| !c.is_control()).take(200).collect();
    (!text.is_empty()).then_some(text)
}

fn refused(drive: &Path) -> Result<()> {
    complaint(drive).map_or(Ok(()), |text| {
        Err(Error::device("flash_refused", format!("the ST-LINK says: {text}")))
    })
}

#[cfg(test)]
mod tests {
    use super::super::image::{Image, Segment};
    use super::*;

    struct QuietObserver;

    impl ProgressObserver for QuietObserver {
        fn at(&mut self, _: Step, _: u64, _: u64) -> Result<()> {
            Ok(())
        }
    }

    fn plan(board: &str) -> Plan {
        let board = Board::named(board).unwrap();
        let bytes = (0..20_000u32).map(|i| (i / 3) as u8).collect();
        let image = Image { segments: vec![Segment { address: board.flash.origin, bytes }] };
        Plan::new(board, image).unwrap()
    }

    /// Imitates a board: takes the file from the drive as soon as it has `size` bytes.
    fn board(drive: PathBuf, kind: Kind<'static>, size: usize) -> thread::JoinHandle<Vec<u8>> {
        let file = drive.join(kind.file_name());
        thread::spawn(move || {
            let start = Instant::now();
            loop {
                match fs::read(&file) {
                    Ok(bytes) if bytes.len() == size => break,
                    _ => thread::yield_now(),
                }
                // Reached only when nothing is copied.
                assert!(start.elapsed() < LATE, "no file of {size} bytes has come");
            }
            let taken = fs::read(&file).unwrap();
            match kind {
                Kind::Uf2(_) => fs::remove_dir_all(&drive).unwrap(),
                Kind::StLink(_) => {
                    fs::write(drive.join("FAIL.TXT"), "SWD ERROR\r\n").unwrap();
                    fs::remove_file(&file).unwrap();
                }
            }
            taken
        })
    }

    fn drive(file: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let drive = folder.path().join("drive");
        fs::create_dir(&drive).unwrap();
        fs::write(drive.join(file), text).unwrap();
        (folder, drive)
    }

    #[test]
    fn the_boot_loader_of_an_rp2350_is_given_a_uf2_and_goes_away() {
        let (_folder, drive) = drive("INFO_UF2.TXT", "UF2 Bootloader v1.0\nBoard-ID: RP2350\n");
        let plan = plan("pico2");
        let kind = Kind::of(plan.board).unwrap();
        let rom = board(drive.clone(), kind, 20_000usize.div_ceil(256) * 512);
        assert_eq!(find(kind, Some(&drive)), Ok(drive.clone()));
        assert_eq!(flash(kind, &drive, &plan, &mut QuietObserver), Ok(DriveOutcome::Started));
        let (bytes, _) = uf2_decode::convert_from_uf2(&rom.join().unwrap()).unwrap();
        assert_eq!(bytes[..20_000], plan.image.segments[0].bytes[..]);
    }

    #[test]
    fn what_an_st_link_complains_of_is_passed_on() {
        let (_folder, drive) = drive("DETAILS.TXT", "Version: 0221");
        let plan = plan("nucleo-g474re");
        let kind = Kind::of(plan.board).unwrap();
        let link = board(drive.clone(), kind, 20_000);
        let error = flash(kind, &drive, &plan, &mut QuietObserver).unwrap_err();
        assert_eq!(error.to_string(), "the ST-LINK says: SWD ERROR");
        assert_eq!(link.join().unwrap(), plan.image.segments[0].bytes);
    }

    #[test]
    fn a_drive_of_something_else_is_not_written() {
        let (_folder, drive) =
            drive("INFO_UF2.TXT", "Model: Raspberry Pi RP2\nBoard-ID: RPI-RP2\n");
        for name in ["pico2", "nucleo-g474re"] {
            let kind = Kind::of(Board::named(name).unwrap()).unwrap();
            assert_eq!(find(kind, Some(&drive)).unwrap_err().code(), "wrong_drive", "{name}");
        }
    }

    #[test]
    fn fat_drives_are_found_among_the_mounts() {
        let line = "/dev/sdb1 /media/me/NOD\\040G474RE vfat rw,nosuid 0 0";
        assert_eq!(fat_drive(line), Some(PathBuf::from("/media/me/NOD G474RE")));
        assert_eq!(fat_drive("proc /proc proc rw 0 0"), None);
        assert_eq!(fat_drive(""), None);
    }
}
