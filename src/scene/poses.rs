//! Poses from a CSV file: `qw,qx,qy,qz,tx,ty,tz`, a unit quaternion and metres a row.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::num::NonZeroU32;
use std::path::Path;

use super::PosesError;
use crate::geometry::Pose;

const HEADER: [&str; 7] = ["qw", "qx", "qy", "qz", "tx", "ty", "tz"];

/// Bytes. Seven numbers need a tenth; a file that is not text at all need not be read to its end.
const LONGEST_LINE: u64 = 4096;

/// All poses of the file, or the first `first` of them. Blank lines and spaces around the numbers
/// are fine; anything else that is not a pose is an error that names its line.
pub fn read_poses(path: &Path, first: Option<NonZeroU32>) -> Result<Vec<Pose>, PosesError> {
    let unreadable = |source| PosesError::Read { path: path.to_owned(), source };
    let bad_row = |line, reason| PosesError::Row { path: path.to_owned(), line, reason };
    let mut lines = Lines::new(BufReader::new(File::open(path).map_err(unreadable)?));
    check_header(&mut lines, path)?;

    let limit = first.map_or(u32::MAX, NonZeroU32::get) as usize;
    let mut poses = Vec::new();
    while lines.advance().map_err(unreadable)? {
        if poses.len() == limit {
            if first.is_some() {
                break;
            }
            return Err(PosesError::TooMany { path: path.to_owned() });
        }
        let pose = lines.text().and_then(pose).map_err(|reason| bad_row(lines.number, reason))?;
        poses.push(pose);
    }
    check_count(poses, first, path)
}

fn check_header(lines: &mut Lines<impl BufRead>, path: &Path) -> Result<(), PosesError> {
    let found = match lines.advance() {
        Err(source) => return Err(PosesError::Read { path: path.to_owned(), source }),
        Ok(false) => "nothing".to_owned(),
        Ok(true) => match lines.text() {
            Ok(text) if fields(text.trim_start_matches('\u{feff}')).eq(HEADER) => return Ok(()),
            Ok(text) => format!("`{}`", text.chars().take(60).collect::<String>().escape_debug()),
            Err(reason) => reason,
        },
    };
    Err(PosesError::Header { path: path.to_owned(), line: lines.number.max(1), found })
}

fn check_count(
    poses: Vec<Pose>,
    first: Option<NonZeroU32>,
    path: &Path,
) -> Result<Vec<Pose>, PosesError> {
    let (path, found) = (path.to_owned(), poses.len());
    match first.map(NonZeroU32::get) {
        _ if found == 0 => Err(PosesError::Empty { path }),
        Some(wanted) if found < wanted as usize => Err(PosesError::TooFew { path, wanted, found }),
        _ => Ok(poses),
    }
}

fn fields(line: &str) -> impl Iterator<Item = &str> {
    line.split(',').map(str::trim)
}

fn pose(line: &str) -> Result<Pose, String> {
    let count = fields(line).count();
    if count != HEADER.len() {
        return Err(format!("{count} fields where {} are wanted", HEADER.len()));
    }
    let mut numbers = [0.0; HEADER.len()];
    for ((number, field), name) in numbers.iter_mut().zip(fields(line)).zip(HEADER) {
        *number =
            field.parse::<f64>().map_err(|_| format!("field {name}: `{field}` is not a number"))?;
    }
    let [w, x, y, z, translation @ ..] = numbers;
    Pose::checked([w, x, y, z], translation).map_err(|e| e.to_string())
}

/// Lines that are not blank, with their numbers.
struct Lines<R> {
    reader: R,
    line: Vec<u8>,
    /// From 1.
    number: u64,
}

impl<R: BufRead> Lines<R> {
    fn new(reader: R) -> Self {
        Self { reader, line: Vec::new(), number: 0 }
    }

    /// To the next line; false at the end of the file.
    fn advance(&mut self) -> io::Result<bool> {
        loop {
            self.line.clear();
            let mut limited = self.reader.by_ref().take(LONGEST_LINE);
            if limited.read_until(b'\n', &mut self.line)? == 0 {
                return Ok(false);
            }
            self.number += 1;
            if !self.line.trim_ascii().is_empty() {
                return Ok(true);
            }
        }
    }

    fn text(&self) -> Result<&str, String> {
        let whole = (self.line.len() as u64) < LONGEST_LINE;
        let text = str::from_utf8(&self.line).ok().filter(|_| whole);
        text.map(str::trim).ok_or_else(|| "something that is not a line of a CSV file".to_owned())
    }
}
