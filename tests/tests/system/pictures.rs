//! Pictures of the panel's screen, as committed in `boards/virtual/screens`.
//!
//! They change only on purpose: `MASSLINE_BLESS=1` before `cargo test` rewrites them; look at the new
//! pictures before committing them.

use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};

use massline_virtual::framebuffer::{Framebuffer, HEIGHT, WIDTH};

/// Size of a framebuffer pixel in the picture, pixels.
const SCALE: usize = 4;
/// Dark pixels around the framebuffer.
const FRAME: usize = 8;
/// Dark and bright as on an OLED.
const PALETTE: [u8; 6] = [9, 14, 24, 170, 225, 255];

/// Columns and rows of the framebuffer that differ from run to run: a clock, noise levels.
pub type Mask = (std::ops::Range<usize>, std::ops::Range<usize>);

/// Compares the framebuffer, except for the masked areas, with the committed picture of this name.
pub fn check(name: &str, framebuffer: &Framebuffer, masks: &[Mask]) {
    let path = path_of(name);
    if std::env::var_os("MASSLINE_BLESS").is_some() {
        write(&path, framebuffer);
        return;
    }
    let picture = read(&path);
    let masked = |x: &usize, y: &usize| {
        masks.iter().any(|(columns, rows)| columns.contains(x) && rows.contains(y))
    };
    let places = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
    let differing = places
        .filter(|(x, y)| !masked(x, y))
        .filter(|&(x, y)| picture(x, y) != framebuffer.is_bright(x, y))
        .count();
    assert_eq!(
        differing,
        0,
        "{name}: so many pixels are not as in {}; the framebuffer is\n{}",
        path.display(),
        as_text(framebuffer)
    );
}

fn path_of(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../boards/virtual/screens");
    folder.join(format!("{name}.png"))
}

fn write(path: &Path, framebuffer: &Framebuffer) {
    let (width, height) = (WIDTH * SCALE + 2 * FRAME, HEIGHT * SCALE + 2 * FRAME);
    let file = BufWriter::new(File::create(path).unwrap());
    let mut encoder = png::Encoder::new(file, width as u32, height as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(PALETTE.to_vec());
    let on_screen = |at: usize| at.checked_sub(FRAME).map(|at| at / SCALE);
    let pixel = |x: usize, y: usize| {
        let place = on_screen(x).zip(on_screen(y));
        u8::from(place.is_some_and(|(x, y)| framebuffer.is_bright(x, y)))
    };
    let pixels: Vec<u8> = (0..height).flat_map(|y| (0..width).map(move |x| pixel(x, y))).collect();
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
}

/// Reads a picture and returns whether a pixel of the framebuffer is bright in it.
fn read(path: &Path) -> impl Fn(usize, usize) -> bool {
    let file = File::open(path).unwrap_or_else(|e| {
        panic!("{}: {e}; write it with MASSLINE_BLESS=1 and look at it", path.display())
    });
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(info.width as usize, WIDTH * SCALE + 2 * FRAME, "{}", path.display());
    // Decoded to red, green and blue; the bright color has more red.
    let (line, bytes) = (info.line_size, info.line_size / info.width as usize);
    move |x, y| {
        let middle = |at: usize| FRAME + at * SCALE + SCALE / 2;
        pixels[middle(y) * line + middle(x) * bytes] > u8::from(bytes > 1) * 100
    }
}

/// The framebuffer as text, with two rows of pixels per line.
fn as_text(framebuffer: &Framebuffer) -> String {
    let mut text = String::new();
    for y in (0..HEIGHT).step_by(2) {
        for x in 0..WIDTH {
            text.push(match (framebuffer.is_bright(x, y), framebuffer.is_bright(x, y + 1)) {
                (true, true) => '█',
                (true, false) => '▀',
                (false, true) => '▄',
                (false, false) => ' ',
            });
        }
        text.push('\n');
    }
    text
}
