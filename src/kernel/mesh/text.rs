//! Lines, words and numbers of the text formats. Everything is bytes: names and comments may be
//! in any encoding.

use super::Problem;
use super::error::excerpt;

/// Lines numbered from 1, ended by LF, CRLF or CR; a missing last end is fine.
#[derive(Clone)]
pub struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, number: 0 }
    }

    /// For text that begins after `lines` lines of a header.
    pub fn after(bytes: &'a [u8], lines: usize) -> Self {
        Self { rest: bytes, number: lines }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
        let (line, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        let end_length = match rest {
            [b'\r', b'\n', ..] => 2,
            [] => 0,
            _ => 1,
        };
        self.rest = &rest[end_length..];
        Some((self.number, line))
    }
}

pub fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// A finite number, kept to the last bit of an f64.
pub fn number(word: &[u8]) -> Result<f64, Problem> {
    let value: f64 = parse(word).ok_or_else(|| Problem::NotANumber(excerpt(word)))?;
    if value.is_finite() { Ok(value) } else { Err(Problem::NotFinite(value)) }
}

pub fn integer(word: &[u8]) -> Result<i64, Problem> {
    parse(word).ok_or_else(|| Problem::NotAnIndex(excerpt(word)))
}

fn parse<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Exactly three numbers.
pub fn point<'a>(words: impl Iterator<Item = &'a [u8]>) -> Result<[f64; 3], Problem> {
    let mut coordinates = [0.0; 3];
    let mut count = 0;
    for word in words {
        let slot = coordinates
            .get_mut(count)
            .ok_or_else(|| Problem::unexpected(word, "three coordinates and no more"))?;
        *slot = number(word)?;
        count += 1;
    }
    if count < 3 {
        let found = format!("{count} numbers");
        return Err(Problem::Unexpected { found, expected: "three coordinates" });
    }
    Ok(coordinates)
}

/// Editors put this invisible mark before text.
pub fn without_byte_order_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}
