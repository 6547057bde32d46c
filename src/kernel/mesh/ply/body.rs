use super::header::{Element, Scalar};
use crate::mesh::text::{Lines, integer, number, words};
use crate::mesh::{FormatError, Place, Problem};

/// Reads the values of one element after the other.
///
/// 1. `begin` and `end` enclose each element; the values are asked for in file order.
/// 2. `EndsWithin` is returned iff the file ends early; nothing else is.
/// 3. `capacity` is never more than the remaining bytes can hold, whatever the header says.
/// 4. `finish` refuses bytes after the last element.
pub trait Cursor {
    /// What the file has too few of when it ends early.
    const UNIT: &'static str;

    fn begin(&mut self) -> Result<(), Problem>;
    fn float(&mut self, scalar: Scalar) -> Result<f64, Problem>;
    fn integer(&mut self, scalar: Scalar) -> Result<i64, Problem>;
    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), Problem>;
    fn end(&mut self) -> Result<(), Problem>;
    fn finish(&mut self) -> Result<(), FormatError>;
    fn capacity(&self, element: &Element) -> usize;
    fn place(&self) -> Place;
}

pub struct BinaryCursor<'a, const BIG: bool> {
    rest: &'a [u8],
    file_length: usize,
}

impl<'a, const BIG: bool> BinaryCursor<'a, BIG> {
    pub fn new(body: &'a [u8], header_length: usize) -> Self {
        Self { rest: body, file_length: header_length + body.len() }
    }

    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Problem> {
        let (bytes, rest) = self.rest.split_first_chunk().ok_or_else(ends)?;
        self.rest = rest;
        let mut bytes: [u8; N] = *bytes;
        if BIG {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

fn ends() -> Problem {
    Problem::EndsWithin(String::new())
}

impl<const BIG: bool> Cursor for BinaryCursor<'_, BIG> {
    const UNIT: &'static str = "bytes";

    fn begin(&mut self) -> Result<(), Problem> {
        Ok(())
    }

    #[inline]
    fn float(&mut self, scalar: Scalar) -> Result<f64, Problem> {
        match scalar {
            Scalar::F32 => Ok(f32::from_le_bytes(self.take()?).into()),
            Scalar::F64 => Ok(f64::from_le_bytes(self.take()?)),
            // At most 32 bits, so exact in an f64.
            integer => Ok(self.integer(integer)? as f64),
        }
    }

    #[inline]
    fn integer(&mut self, scalar: Scalar) -> Result<i64, Problem> {
        Ok(match scalar {
            Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
            Scalar::F32 | Scalar::F64 => {
                let value = self.float(scalar)?;
                return Err(Problem::NotAnIndex(value.to_string()));
            }
        })
    }

    #[inline]
    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), Problem> {
        let bytes = count.checked_mul(scalar.bytes() as u64).and_then(|b| usize::try_from(b).ok());
        self.rest = bytes.and_then(|bytes| self.rest.get(bytes..)).ok_or_else(ends)?;
        Ok(())
    }

    fn end(&mut self) -> Result<(), Problem> {
        Ok(())
    }

    fn finish(&mut self) -> Result<(), FormatError> {
        match self.rest.trim_ascii() {
            [] => Ok(()),
            _ => Err(Problem::Trailing { bytes: self.rest.len() }.at(self.place())),
        }
    }

    fn capacity(&self, element: &Element) -> usize {
        let most = self.rest.len() / element.least_bytes().max(1);
        usize::try_from(element.count).unwrap_or(most).min(most)
    }

    fn place(&self) -> Place {
        Place::Byte(self.file_length - self.rest.len())
    }
}

/// One element a line; blank lines are passed over.
pub struct TextCursor<'a> {
    lines: Lines<'a>,
    line: usize,
    /// What is left of the current line.
    rest: &'a [u8],
    length: usize,
}

impl<'a> TextCursor<'a> {
    pub fn new(body: &'a [u8], header_lines: usize) -> Self {
        let lines = Lines::after(body, header_lines);
        Self { lines, line: header_lines, rest: b"", length: body.len() }
    }

    fn word(&mut self) -> Result<&'a [u8], Problem> {
        let start = self.rest.trim_ascii_start();
        let end = start.iter().position(u8::is_ascii_whitespace).unwrap_or(start.len());
        let (word, rest) = start.split_at(end);
        self.rest = rest;
        if word.is_empty() {
            let found = "the end of the line".into();
            return Err(Problem::Unexpected { found, expected: "another value" });
        }
        Ok(word)
    }
}

impl Cursor for TextCursor<'_> {
    const UNIT: &'static str = "lines";

    fn begin(&mut self) -> Result<(), Problem> {
        let mut filled = self.lines.by_ref().filter(|(_, line)| words(line).next().is_some());
        (self.line, self.rest) = filled.next().ok_or_else(ends)?;
        Ok(())
    }

    /// The text is taken as f64 whatever type the header names: no digit is lost.
    fn float(&mut self, _: Scalar) -> Result<f64, Problem> {
        number(self.word()?)
    }

    fn integer(&mut self, _: Scalar) -> Result<i64, Problem> {
        integer(self.word()?)
    }

    fn skip(&mut self, _: Scalar, count: u64) -> Result<(), Problem> {
        (0..count).try_for_each(|_| self.word().map(drop))
    }

    fn end(&mut self) -> Result<(), Problem> {
        match self.rest.trim_ascii() {
            [] => Ok(()),
            more => Err(Problem::unexpected(more, "the end of the line")),
        }
    }

    fn finish(&mut self) -> Result<(), FormatError> {
        match self.begin() {
            Err(_) => Ok(()),
            Ok(()) => {
                let expected = "the end of the file: the header promises no more elements";
                Err(Problem::unexpected(self.rest, expected).at_line(self.line))
            }
        }
    }

    /// A line holds at least a digit and its end.
    fn capacity(&self, element: &Element) -> usize {
        let most = self.length / 2 + 1;
        usize::try_from(element.count).unwrap_or(most).min(most)
    }

    fn place(&self) -> Place {
        Place::Line(self.line)
    }
}

#[cfg(test)]
mod tests {
    use super::super::header::{Property, Type};
    use super::*;

    #[test]
    fn a_lying_count_reserves_no_more_than_the_file_can_hold() {
        let name = String::from("x");
        let properties = vec![Property { name, kind: Type::Scalar(Scalar::F32) }];
        let element = Element { name: "vertex".into(), count: u64::MAX, properties };
        let body = [b'1'; 100];
        assert_eq!(BinaryCursor::<false>::new(&body, 0).capacity(&element), 25);
        assert!(TextCursor::new(&body, 0).capacity(&element) <= 100);
    }
}
