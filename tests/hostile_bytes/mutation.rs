//! Damages bytes, the same way for the same seed everywhere.

/// SplitMix64 (Steele, Lea & Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `end`; 0 if there is nothing below.
    pub fn below(&mut self, end: usize) -> usize {
        if end == 0 { 0 } else { (self.next() % end as u64) as usize }
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    /// A range within `length`, rather a short one.
    fn range(&mut self, length: usize) -> std::ops::Range<usize> {
        let from = self.below(length);
        let longest = self.pick(&[1, 4, 8, 64, 512]);
        from..(from + 1 + self.below(longest)).min(length)
    }
}

const WORDS: [u32; 12] =
    [0, 1, 2, 7, 8, 255, 256, 0x7fff_ffff, 0x8000_0000, 0x8000_0001, u32::MAX - 1, u32::MAX];

const REALS: [f64; 12] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN_POSITIVE,
    5e-324,
    1e-160,
    3e38,
];

/// Pieces of the text formats.
const TOKENS: [&str; 32] = [
    "\n",
    " ",
    "#",
    "-1",
    "0",
    "4294967296",
    "1e309",
    "nan",
    "\\\n",
    "{",
    "}",
    "[",
    "]",
    "\"",
    ",",
    "property list uchar int vertex_indices\n",
    "element face 99999999\n",
    "end_header\n",
    "f 1 2 3\n",
    "f -1/1/1 2//3 3\n",
    "vertex",
    "endsolid",
    "facet normal 0 0 0",
    "DEF A Group{}",
    "USE A",
    "PROTO P[]{}",
    "Transform{",
    "\"byteOffset\":",
    "\"count\":",
    "\"children\":[0]",
    "scale 0 0 0",
    "\"buffers\":[{\"byteLength\":9}]",
];

/// One to eight changes: of single bits, of whole numbers where numbers lie, of the order and
/// length of parts, and parts of another seed.
pub fn mutate(bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    for _ in 0..1 + random.below(8) {
        change(bytes, other, random);
    }
}

fn change(bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    let length = bytes.len();
    match random.below(13) {
        0 if length > 0 => bytes[random.below(length)] ^= 1 << random.below(8),
        1 if length > 0 => bytes[random.below(length)] = random.next() as u8,
        // Half of all changes are of numbers, in place.
        2 | 3 => put(bytes, 4, &random.pick(&WORDS).to_le_bytes(), random),
        4 => put(bytes, 4, &(random.below(80) as u32).to_le_bytes(), random),
        5 => put(bytes, 8, &random.pick(&REALS).to_le_bytes(), random),
        6 => put(bytes, 4, &(random.pick(&REALS) as f32).to_le_bytes(), random),
        7 => step(bytes, random),
        8 => {
            let from = random.range(length);
            let to = random.below(length - from.len() + 1);
            bytes.copy_within(from, to);
        }
        9 => drop(bytes.drain(random.range(length))),
        10 => {
            let again = bytes[random.range(length)].to_vec();
            let at = random.below(length + 1);
            bytes.splice(at..at, again);
        }
        11 => {
            let token = random.pick(&TOKENS);
            let at = random.below(length + 1);
            bytes.splice(at..at, token.bytes());
        }
        _ => {
            let part = &other[random.range(other.len())];
            let at = random.below(length + 1);
            let replaced = at..(at + part.len()).min(length);
            bytes.splice(replaced, part.iter().copied());
        }
    }
}

/// Where a number of that alignment may lie.
fn put(bytes: &mut [u8], alignment: usize, number: &[u8], random: &mut Random) {
    let at = random.below(bytes.len() / alignment) * alignment;
    if let Some(target) = bytes.get_mut(at..at + number.len()) {
        target.copy_from_slice(number);
    }
}

/// A neighbour of the number that is there: off by one is what is forgotten.
fn step(bytes: &mut [u8], random: &mut Random) {
    let at = random.below(bytes.len() / 4) * 4;
    if let Some(target) = bytes.get_mut(at..at + 4) {
        let there = u32::from_le_bytes([target[0], target[1], target[2], target[3]]);
        let by = random.pick(&[1, 2, 8, u32::MAX, u32::MAX - 1]);
        target.copy_from_slice(&there.wrapping_add(by).to_le_bytes());
    }
}
