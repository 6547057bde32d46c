//! Text that may be compressed.

use std::borrow::Cow;
use std::io::{Read, Write};

use flate2::Compression;
use flate2::write::GzEncoder;

use super::{FormatError, Problem};

/// The text itself, decompressed if it is not plain.
///
/// Scenes compress about five-fold; what grows far beyond that is made to exhaust memory.
pub fn decompressed(bytes: &[u8]) -> Result<Cow<'_, [u8]>, FormatError> {
    const ALWAYS_ALLOWED: u64 = 64 << 20;
    const MOST_GROWTH: u64 = 32;
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(bytes.into());
    }
    let limit = ALWAYS_ALLOWED + MOST_GROWTH * bytes.len() as u64;
    let mut text = Vec::new();
    flate2::read::MultiGzDecoder::new(bytes)
        .take(limit + 1)
        .read_to_end(&mut text)
        .map_err(|error| Problem::Malformed(format!("gzip: {error}")).in_file())?;
    if text.len() as u64 > limit {
        let problem = format!("the gzip data grows beyond {limit} bytes: decompress it first");
        return Err(Problem::TooLarge(problem).in_file());
    }
    Ok(text.into())
}

/// As small as it gets.
pub fn compressed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.expect("writing to memory does not fail")
}
