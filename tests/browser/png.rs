//! As much of PNG as Chromium writes (8 bits a channel, not interlaced), to look at pictures of
//! pages. PNG specification, third edition, sections 5 and 9.

use std::io::Read;

use flate2::read::ZlibDecoder;

pub struct Picture {
    pub width: usize,
    pub height: usize,
    /// Row by row from the top, red, green, blue.
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    pub fn pixel(&self, x: usize, y: usize) -> [u8; 3] {
        self.pixels[y * self.width + x]
    }

    /// The part of the pixels that differ.
    pub fn changed(&self, other: &Self) -> f64 {
        assert_eq!([self.width, self.height], [other.width, other.height]);
        if self.pixels.as_flattened() == other.pixels.as_flattened() {
            return 0.0;
        }
        let pairs = self.pixels.iter().zip(&other.pixels);
        pairs.filter(|(a, b)| a != b).count() as f64 / self.pixels.len() as f64
    }

    /// The part with these columns and rows.
    pub fn part(&self, columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> Self {
        let row = |y: usize| &self.pixels[y * self.width..][columns.clone()];
        let pixels = rows.clone().flat_map(|y| row(y).iter().copied()).collect();
        Self { width: columns.len(), height: rows.len(), pixels }
    }

    /// How many there are of different colours.
    pub fn colours(&self) -> usize {
        let mut colours = self.pixels.clone();
        colours.sort_unstable();
        colours.dedup();
        colours.len()
    }

    /// How many pixels have nearly this colour.
    pub fn count_near(&self, colour: [u8; 3], tolerance: u8) -> usize {
        let near = |pixel: &&[u8; 3]| (0..3).all(|k| pixel[k].abs_diff(colour[k]) <= tolerance);
        self.pixels.iter().filter(near).count()
    }
}

pub fn decode(bytes: &[u8]) -> Picture {
    let rest = bytes.strip_prefix(b"\x89PNG\r\n\x1a\n").expect("a PNG");
    let (mut rest, mut packed, mut head) = (rest, Vec::new(), [0; 13]);
    while let Some((length, after)) = rest.split_first_chunk::<4>() {
        let (kind, after) = after.split_at(4);
        let (data, after) = after.split_at(u32::from_be_bytes(*length) as usize);
        match kind {
            b"IHDR" => head.copy_from_slice(data),
            b"IDAT" => packed.extend_from_slice(data),
            _ => {}
        }
        rest = &after[4..];
    }
    let number = |at: usize| u32::from_be_bytes(head[at..at + 4].try_into().unwrap()) as usize;
    let (width, height) = (number(0), number(4));
    let channels = match (head[8], head[9], head[12]) {
        (8, 2, 0) => 3,
        (8, 6, 0) => 4,
        other => panic!("not a PNG that Chromium writes: {other:?}"),
    };
    let mut rows = Vec::new();
    ZlibDecoder::new(&packed[..]).read_to_end(&mut rows).unwrap();
    let mut above = vec![0; width * channels];
    let mut pixels = Vec::with_capacity(width * height);
    for row in rows.chunks_exact_mut(1 + width * channels) {
        let (filter, row) = row.split_first_mut().unwrap();
        unfilter(*filter, row, &above, channels);
        pixels.extend(row.chunks_exact(channels).map(|pixel| [pixel[0], pixel[1], pixel[2]]));
        above.copy_from_slice(row);
    }
    Picture { width, height, pixels }
}

/// Written as it is because it takes most of the time of the tests, which are not optimised.
fn unfilter(filter: u8, row: &mut [u8], above: &[u8], channels: usize) {
    let mut at = 0;
    while at < row.len() {
        let (a, c) =
            if at < channels { (0, 0) } else { (row[at - channels], above[at - channels]) };
        let b = above[at];
        let predicted = match filter {
            0 => return,
            1 => a,
            2 => b,
            3 => ((a as u16 + b as u16) / 2) as u8,
            4 => paeth(a, b, c),
            other => panic!("no filter {other}"),
        };
        row[at] = row[at].wrapping_add(predicted);
        at += 1;
    }
}

/// The nearest of the three to a + b - c, and the first of several.
fn paeth(a: u8, b: u8, c: u8) -> u8 {
    let [from_c_to_a, from_c_to_b] = [a as i16 - c as i16, b as i16 - c as i16];
    let distances = [from_c_to_b.abs(), from_c_to_a.abs(), (from_c_to_a + from_c_to_b).abs()];
    if distances[0] <= distances[1] && distances[0] <= distances[2] {
        a
    } else if distances[1] <= distances[2] {
        b
    } else {
        c
    }
}
