//! UF2: firmware as a file of blocks in any order, for boot loaders that appear as a drive
//! (<https://github.com/microsoft/uf2>).

use super::image::Image;

/// Length of a block, bytes.
pub const BLOCK: usize = 512;
/// Firmware in a block, bytes: a page of the RP2350's flash.
pub const PAYLOAD: usize = 256;

const MAGIC: [u32; 2] = [0x0A32_4655, 0x9E5D_5157];
const MAGIC_END: u32 = 0x0AB1_6F30;
/// Flag: the last field of the header is a family ID.
const HAS_FAMILY: u32 = 0x2000;

/// The image as blocks of whole pages; the parts of a page outside of the image are `0xFF`, as if erased.
pub fn blocks(image: &Image, family: u32) -> Vec<u8> {
    let pages = pages(image);
    let mut file = Vec::with_capacity(pages.len() * BLOCK);
    for (number, (address, page)) in pages.iter().enumerate() {
        let head = [
            MAGIC[0],
            MAGIC[1],
            HAS_FAMILY,
            *address,
            PAYLOAD as u32,
            number as u32,
            pages.len() as u32,
            family,
        ];
        file.extend(head.iter().flat_map(|word| word.to_le_bytes()));
        file.extend(page);
        file.resize((number + 1) * BLOCK - 4, 0);
        file.extend(MAGIC_END.to_le_bytes());
    }
    file
}

/// The pages that the image occupies, by rising address.
fn pages(image: &Image) -> Vec<(u32, [u8; PAYLOAD])> {
    let mut pages: Vec<(u32, [u8; PAYLOAD])> = Vec::new();
    for segment in &image.segments {
        for (address, byte) in (segment.address..).zip(&segment.bytes) {
            let start = address - address % PAYLOAD as u32;
            if pages.last().is_none_or(|last| last.0 != start) {
                pages.push((start, [0xFF; PAYLOAD]));
            }
            if let Some((_, page)) = pages.last_mut() {
                page[(address - start) as usize] = *byte;
            }
        }
    }
    pages
}

#[cfg(test)]
mod tests {
    use super::super::image::Segment;
    use super::*;

    /// An arbitrary family ID.
    const FAMILY: u32 = 0x1234_5678;

    #[test]
    fn blocks_are_read_by_another_reader_of_the_format() {
        let first = Segment { address: 0x1000_0000, bytes: (0..300u32).map(|i| i as u8).collect() };
        let second = Segment { address: 0x1000_01FE, bytes: vec![7; 3] };
        let image = Image { segments: vec![first.clone(), second] };
        let file = blocks(&image, FAMILY);
        // 0x000, 0x100, 0x200: the second segment shares its first page with the first.
        assert_eq!(file.len(), 3 * BLOCK);
        let (bytes, families) = uf2_decode::convert_from_uf2(&file).unwrap();
        assert_eq!(families.into_iter().collect::<Vec<_>>(), [(FAMILY, 0x1000_0000)]);
        assert_eq!(bytes.len(), 3 * PAYLOAD);
        assert_eq!(bytes[..300], first.bytes[..]);
        assert_eq!(bytes[300..0x1FE], [0xFF; 0x1FE - 300]);
        assert_eq!(bytes[0x1FE..0x201], [7; 3]);
    }

    /// The boot loader starts the program when it has received as many blocks as the header of each block
    /// states.
    #[test]
    fn each_block_says_its_number_and_how_many_there_are() {
        let image =
            Image { segments: vec![Segment { address: 0x1000_0000, bytes: vec![1; 5 * 256] }] };
        for (number, block) in blocks(&image, FAMILY).chunks(BLOCK).enumerate() {
            let word = |at: usize| u32::from_le_bytes(block[at..at + 4].try_into().unwrap());
            assert_eq!([word(20), word(24)], [number as u32, 5]);
            assert_eq!(word(508), 0x0AB1_6F30);
        }
    }
}
