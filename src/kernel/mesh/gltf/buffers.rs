use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

use super::document::Buffer;
use crate::mesh::base64::decoded;
use crate::mesh::source::read_regular;
use crate::mesh::{FormatError, Problem};

/// A buffer's bytes, cut to the length that the document promises.
pub struct Bytes<'a> {
    content: Content<'a>,
    length: usize,
}

enum Content<'a> {
    Chunk(&'a [u8]),
    Inline(Vec<u8>),
    /// Shared, since many buffers may name one file.
    Sibling(Rc<Vec<u8>>),
}

impl Bytes<'_> {
    pub fn get(&self) -> &[u8] {
        &self.all()[..self.length]
    }

    fn all(&self) -> &[u8] {
        match &self.content {
            Content::Chunk(bytes) => bytes,
            Content::Inline(bytes) => bytes,
            Content::Sibling(bytes) => bytes,
        }
    }
}

pub fn load<'a>(
    buffers: &[Buffer],
    chunk: Option<&'a [u8]>,
    directory: &Path,
) -> Result<Vec<Bytes<'a>>, FormatError> {
    let mut siblings = HashMap::new();
    let load_one = |(index, buffer): (usize, &Buffer)| {
        let content = match (&buffer.uri, chunk) {
            (Some(uri), _) => open(uri, directory, &mut siblings),
            (None, Some(chunk)) if index == 0 => Ok(Content::Chunk(chunk)),
            (None, _) => Err(Problem::Malformed("has neither a uri nor a BIN chunk".into())),
        };
        let content = content.map_err(|problem| problem.at_element("buffers", index))?;
        let bytes = Bytes { content, length: buffer.byte_length };
        let found = bytes.all().len();
        if found < bytes.length {
            let problem = super::count("bytes", bytes.length as u64, found as u64);
            return Err(problem.at_element("buffers", index));
        }
        Ok(bytes)
    };
    buffers.iter().enumerate().map(load_one).collect()
}

fn open<'a>(
    uri: &str,
    directory: &Path,
    siblings: &mut HashMap<PathBuf, Rc<Vec<u8>>>,
) -> Result<Content<'a>, Problem> {
    if let Some(data) = uri.strip_prefix("data:") {
        return inline(data).map(Content::Inline);
    }
    let path = sibling_path(uri, directory)?;
    if let Some(bytes) = siblings.get(&path) {
        return Ok(Content::Sibling(bytes.clone()));
    }
    let bytes = read_regular(&path)
        .map_err(|error| Problem::Malformed(format!("{}: {error}", path.display())))?;
    let bytes = Rc::new(bytes);
    siblings.insert(path, bytes.clone());
    Ok(Content::Sibling(bytes))
}

fn inline(data: &str) -> Result<Vec<u8>, Problem> {
    let Some((kind, text)) = data.split_once(',') else {
        return Err(Problem::EndsWithin("a data: URI".into()));
    };
    if !kind.ends_with(";base64") {
        let what = "a data: URI that is not base64".into();
        return Err(Problem::Unsupported { what, remedy: "write its buffer as base64" });
    }
    decoded(text).map_err(|error| Problem::Malformed(format!("data: URI: {error}")))
}

/// A file may only name files beside or below it: no absolute path, no `..`, no scheme, no link
/// that leads out.
fn sibling_path(uri: &str, directory: &Path) -> Result<PathBuf, Problem> {
    let name = percent_decoded(uri);
    let path = Path::new(name.as_ref());
    let below = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    let resolve = |path: &Path| {
        path.canonicalize()
            .map_err(|error| Problem::Malformed(format!("{}: {error}", path.display())))
    };
    if name.is_empty() || name.contains([':', '\\', '\0']) || !path.components().all(below) {
        return Err(outside(uri));
    }
    let resolved = resolve(&directory.join(path))?;
    if !resolved.starts_with(resolve(directory)?) {
        return Err(outside(uri));
    }
    Ok(resolved)
}

fn outside(uri: &str) -> Problem {
    let what = format!("the buffer URI '{uri}'");
    let remedy = "buffers must be files in or below the directory of the glTF file";
    Problem::Unsupported { what, remedy }
}

fn percent_decoded(uri: &str) -> Cow<'_, str> {
    if !uri.contains('%') {
        return uri.into();
    }
    let hex = |digit: u8| char::from(digit).to_digit(16).map(|d| d as u8);
    let (mut decoded, mut rest) = (Vec::new(), uri.as_bytes());
    while let [first, tail @ ..] = rest {
        let escaped = match rest {
            [b'%', high, low, ..] => hex(*high).zip(hex(*low)).map(|(high, low)| high << 4 | low),
            _ => None,
        };
        decoded.push(escaped.unwrap_or(*first));
        rest = if escaped.is_some() { &tail[2..] } else { tail };
    }
    String::from_utf8_lossy(&decoded).into_owned().into()
}
