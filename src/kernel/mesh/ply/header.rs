use crate::mesh::error::excerpt;
use crate::mesh::text::words;
use crate::mesh::{FormatError, Problem};

pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Bytes and lines up to the end of `end_header`.
    pub length: usize,
    pub lines: usize,
}

#[derive(Clone, Copy)]
pub enum Encoding {
    Text,
    Little,
    Big,
}

pub struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

pub struct Property {
    pub name: String,
    pub kind: Type,
}

#[derive(Clone, Copy)]
pub enum Type {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Clone, Copy, PartialEq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Element {
    pub fn plural(&self) -> String {
        match self.name.as_str() {
            "vertex" => "vertices".into(),
            "face" => "faces".into(),
            name => format!("elements {name}"),
        }
    }

    /// The fewest bytes that one of these takes in a binary file.
    pub fn least_bytes(&self) -> usize {
        let least = |property: &Property| match property.kind {
            Type::Scalar(scalar) | Type::List { count: scalar, .. } => scalar.bytes(),
        };
        self.properties.iter().map(least).sum()
    }
}

impl Scalar {
    pub fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn parse(word: &[u8]) -> Result<Self, Problem> {
        Ok(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return Err(Problem::unexpected(word, "a PLY type such as float or uint")),
        })
    }

    fn parse_integer(word: &[u8]) -> Result<Self, Problem> {
        match Self::parse(word)? {
            Self::F32 | Self::F64 => Err(Problem::unexpected(word, "an integer type")),
            scalar => Ok(scalar),
        }
    }
}

impl Header {
    pub fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let line_end = line_end(bytes)?;
        let (mut at, mut lines) = (0, 0);
        let (mut encoding, mut elements) = (None, Vec::new());
        loop {
            let rest = &bytes[at..];
            let Some(end) = rest.windows(line_end.len()).position(|window| window == line_end)
            else {
                return Err(Problem::EndsWithin("the header".into()).in_file());
            };
            at += end + line_end.len();
            lines += 1;
            let line = rest[..end].trim_ascii();
            if line == b"end_header" {
                break;
            }
            declare(line, lines, &mut encoding, &mut elements).map_err(|p| p.at_line(lines))?;
        }
        let Some(encoding) = encoding else {
            return Err(Problem::Malformed("the header has no format line".into()).in_file());
        };
        Ok(Self { encoding, elements, length: at, lines })
    }
}

/// Fixed by the first line, because the byte after the header may look like half a line end.
fn line_end(bytes: &[u8]) -> Result<&'static [u8], FormatError> {
    match bytes {
        [b'p', b'l', b'y', b'\r', b'\n', ..] => Ok(b"\r\n"),
        [b'p', b'l', b'y', b'\r', ..] => Ok(b"\r"),
        [b'p', b'l', b'y', b'\n', ..] => Ok(b"\n"),
        _ => Err(Problem::unexpected(&bytes[..bytes.len().min(4)], "the line ply").at_line(1)),
    }
}

fn declare(
    line: &[u8],
    number: usize,
    encoding: &mut Option<Encoding>,
    elements: &mut Vec<Element>,
) -> Result<(), Problem> {
    let words: Vec<&[u8]> = words(line).collect();
    match words.as_slice() {
        [] | [b"comment" | b"obj_info", ..] => {}
        [b"ply"] if number == 1 => {}
        [b"format", name, b"1.0"] => *encoding = Some(parse_encoding(name)?),
        [b"element", name, count] => {
            let parsed = std::str::from_utf8(count).ok().and_then(|c| c.parse().ok());
            let count = parsed.ok_or_else(|| Problem::unexpected(count, "a number of elements"))?;
            let name = excerpt(name);
            if elements.iter().any(|element| element.name == name) {
                return Err(Problem::unexpected(line, "each element once"));
            }
            elements.push(Element { name, count, properties: Vec::new() });
        }
        [b"property", kind @ .., name] if !kind.is_empty() => {
            let kind = parse_type(kind)?;
            let Some(element) = elements.last_mut() else {
                return Err(Problem::unexpected(line, "an element before its properties"));
            };
            element.properties.push(Property { name: excerpt(name), kind });
        }
        _ => return Err(Problem::unexpected(line, "a line of a PLY 1.0 header")),
    }
    Ok(())
}

fn parse_encoding(name: &[u8]) -> Result<Encoding, Problem> {
    match name {
        b"ascii" => Ok(Encoding::Text),
        b"binary_little_endian" => Ok(Encoding::Little),
        b"binary_big_endian" => Ok(Encoding::Big),
        _ => Err(Problem::unexpected(name, "ascii or binary_little_endian or binary_big_endian")),
    }
}

fn parse_type(words: &[&[u8]]) -> Result<Type, Problem> {
    match words {
        [b"list", count, item] => {
            Ok(Type::List { count: Scalar::parse_integer(count)?, item: Scalar::parse(item)? })
        }
        [scalar] => Ok(Type::Scalar(Scalar::parse(scalar)?)),
        _ => Err(Problem::unexpected(&words.join(&b' '), "a type, or list and two types")),
    }
}
