//! The bytes that a page carries: a header of JSON, and sections of plain numbers that it names.
//!
//! Four bytes with the length of the header, the header, and the sections one after the other, each
//! from a multiple of eight bytes on, little-endian. `viewer/src/payload.js` reads them.

use bytemuck::Pod;
use serde::Serialize;

/// How the numbers of a section are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Numbers {
    U32,
    F32,
    F64,
    /// Whole numbers below 2^32 of seven bits a byte, the lowest first; the last byte of each is
    /// below 128.
    Varint,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Section {
    pub name: String,
    pub numbers: Numbers,
    /// From the end of the header, which is filled up to a multiple of eight bytes.
    pub at: usize,
    pub bytes: usize,
}

#[derive(Debug, Default)]
pub struct Sections {
    list: Vec<Section>,
    bytes: Vec<u8>,
}

impl Sections {
    pub fn u32(&mut self, name: impl Into<String>, values: &[u32]) {
        self.plain(name, Numbers::U32, values);
    }

    pub fn f32(&mut self, name: impl Into<String>, values: &[f32]) {
        self.plain(name, Numbers::F32, values);
    }

    pub fn f64(&mut self, name: impl Into<String>, values: &[f64]) {
        self.plain(name, Numbers::F64, values);
    }

    pub fn varint(&mut self, name: impl Into<String>, values: impl IntoIterator<Item = u32>) {
        let at = self.begin();
        for mut value in values {
            while value >= 128 {
                self.bytes.push(value as u8 | 128);
                value >>= 7;
            }
            self.bytes.push(value as u8);
        }
        self.end(name.into(), Numbers::Varint, at);
    }

    fn plain<T: Pod>(&mut self, name: impl Into<String>, numbers: Numbers, values: &[T]) {
        let at = self.begin();
        self.bytes.extend_from_slice(bytemuck::cast_slice(values));
        self.end(name.into(), numbers, at);
    }

    fn begin(&mut self) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
        self.bytes.len()
    }

    fn end(&mut self, name: String, numbers: Numbers, at: usize) {
        let bytes = self.bytes.len() - at;
        self.list.push(Section { name, numbers, at, bytes });
    }

    /// With a header that is made of the list of sections.
    pub fn finish<H: Serialize>(self, header: impl FnOnce(Vec<Section>) -> H) -> Vec<u8> {
        let header = serde_json::to_vec(&header(self.list)).expect("string keys and plain values");
        let length = u32::try_from(header.len()).expect("a header is short");
        let mut payload = [&length.to_le_bytes()[..], &header].concat();
        payload.resize(payload.len().next_multiple_of(8), b' ');
        payload.extend_from_slice(&self.bytes);
        payload
    }
}

/// Of small absolute value: small.
pub fn zigzag(value: i32) -> u32 {
    ((value << 1) ^ (value >> 31)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_are_where_the_header_says() {
        let mut sections = Sections::default();
        sections.varint("a", [0, 127, 128, u32::MAX]);
        sections.f64("b", &[1.5]);
        sections.u32("c", &[7]);
        let payload = sections.finish(|list| list);
        let length = u32::from_le_bytes(payload[..4].try_into().unwrap()) as usize;
        let list: serde_json::Value = serde_json::from_slice(&payload[4..4 + length]).unwrap();
        let bytes = |of: usize| {
            let number = |key: &str| list[of][key].as_u64().unwrap() as usize;
            let from = (4 + length).next_multiple_of(8) + number("at");
            assert_eq!(from % 8, 0);
            &payload[from..from + number("bytes")]
        };
        assert_eq!(bytes(0), [0, 127, 128, 1, 255, 255, 255, 255, 15]);
        assert_eq!(bytes(1), 1.5_f64.to_le_bytes());
        assert_eq!(bytes(2), [7, 0, 0, 0]);
        assert_eq!(list[1]["numbers"], "f64");
    }

    #[test]
    fn what_is_near_zero_is_short() {
        assert_eq!(
            [0, -1, 1, -2, i32::MAX, i32::MIN].map(zigzag),
            [0, 1, 2, 3, u32::MAX - 1, u32::MAX]
        );
    }
}
