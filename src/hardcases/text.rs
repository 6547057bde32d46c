//! The three forms of a suite's file: a word or line that is not as it should be is refused, and
//! named by its line.

use super::continuous::{Query, QueryKind};
use super::{Cases, MeshCase, PairCase, TransformCase};
use crate::geometry::contact::Kind;
use crate::geometry::{Point, Pose, Triangle};
use crate::mesh::{MeshError, TriangleMesh, text};
use crate::tree::descent::Pair;

/// What is wrong with a line.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    #[error("{found} fields where {wanted} are wanted")]
    Fields { wanted: usize, found: usize },
    #[error("'{found}' where {wanted} is wanted")]
    Unexpected { wanted: &'static str, found: String },
    #[error("{0} is not a finite number")]
    NotFinite(f64),
    #[error("truth {truth} does not go with the kind {kind}")]
    Contradiction { truth: String, kind: String },
    #[error("the file ends here, {wanted} is still to come")]
    Ends { wanted: &'static str },
    #[error("the {role} mesh: {error}")]
    Mesh { role: &'static str, error: Box<MeshError> },
    #[error("the pair {} {} is not of the meshes' triangles", .0[0], .0[1])]
    NoSuchPair(Pair),
    #[error("the pair {} {} does not come after the one before it", .0[0], .0[1])]
    Order(Pair),
}

/// With the line's number.
pub type Parsed<T> = Result<T, (usize, Problem)>;

/// `None` if there is nothing but comments.
pub fn parse(bytes: &[u8]) -> Parsed<Option<Cases>> {
    let mut lines = Lines { rest: text::Lines::new(text::without_byte_order_mark(bytes)), last: 0 };
    let Some(first) = lines.next()? else { return Ok(None) };
    let cases = match (first.words[0], first.words.len()) {
        ("case", _) => Cases::Meshes(all(first, lines, mesh_case)?),
        (_, TRANSFORM_WORDS) => Cases::Transforms(all(first, lines, |l, _| transform_case(&l))?),
        _ => Cases::Pairs(all(first, lines, |l, _| pair_case(&l))?),
    };
    Ok(Some(cases))
}

/// Continuous queries; `None` if there is nothing but comments.
pub fn parse_queries(bytes: &[u8]) -> Parsed<Option<Vec<Query>>> {
    let mut lines = Lines { rest: text::Lines::new(text::without_byte_order_mark(bytes)), last: 0 };
    let Some(first) = lines.next()? else { return Ok(None) };
    all(first, lines, |line, _| query(&line)).map(Some)
}

/// A case for each line that begins one.
fn all<'a, T>(
    first: Line<'a>,
    mut lines: Lines<'a>,
    case: impl Fn(Line<'a>, &mut Lines<'a>) -> Parsed<T>,
) -> Parsed<Vec<T>> {
    let mut cases = Vec::new();
    let mut next = Some(first);
    while let Some(line) = next {
        cases.push(case(line, &mut lines)?);
        next = lines.next()?;
    }
    Ok(cases)
}

struct Line<'a> {
    number: usize,
    /// At least one.
    words: Vec<&'a str>,
}

impl<'a> Line<'a> {
    fn refuse<T>(&self, problem: Problem) -> Parsed<T> {
        Err((self.number, problem))
    }

    /// The words after the first, which has to be `name`.
    fn after<const N: usize>(&self, name: &'static str) -> Parsed<[&'a str; N]> {
        if self.words[0] != name {
            return self.refuse(unexpected(name, self.words[0]));
        }
        self.fields(&self.words[1..])
    }

    fn fields<const N: usize>(&self, words: &[&'a str]) -> Parsed<[&'a str; N]> {
        let fields = words.try_into();
        fields.or_else(|_| self.refuse(Problem::Fields { wanted: N, found: words.len() }))
    }

    /// Finite numbers by their bits, 16 hexadecimal digits each.
    fn numbers<const N: usize>(&self, words: &[&'a str]) -> Parsed<[f64; N]> {
        const WANTED: &str = "an f64 as 16 hexadecimal digits";
        let mut numbers = [0.0; N];
        for (number, word) in numbers.iter_mut().zip(self.fields::<N>(words)?) {
            let digits = word.len() == 16 && word.bytes().all(|b| b.is_ascii_hexdigit());
            let bits = u64::from_str_radix(word, 16).ok().filter(|_| digits);
            match bits.map(f64::from_bits) {
                Some(value) if value.is_finite() => *number = value,
                Some(value) => return self.refuse(Problem::NotFinite(value)),
                None => return self.refuse(unexpected(WANTED, word)),
            }
        }
        Ok(numbers)
    }

    fn truth(&self, word: &str) -> Parsed<bool> {
        match word {
            "0" => Ok(false),
            "1" => Ok(true),
            other => self.refuse(unexpected("the truth, 0 or 1,", other)),
        }
    }

    fn indices<const N: usize>(&self, words: [&'a str; N]) -> Parsed<[u32; N]> {
        let mut indices = [0; N];
        for (index, word) in indices.iter_mut().zip(words) {
            let digits = word.bytes().all(|b| b.is_ascii_digit());
            match word.parse() {
                Ok(value) if digits => *index = value,
                _ => return self.refuse(unexpected("a number below 2^32", word)),
            }
        }
        Ok(indices)
    }
}

/// Foreign text in short.
fn unexpected(wanted: &'static str, found: &str) -> Problem {
    const LONGEST: usize = 32;
    let mut found: String = found.escape_debug().collect();
    if found.len() > LONGEST {
        found = found.chars().take(LONGEST).chain("...".chars()).collect();
    }
    Problem::Unexpected { wanted, found }
}

/// Lines that are neither empty nor comments.
struct Lines<'a> {
    rest: text::Lines<'a>,
    last: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Parsed<Option<Line<'a>>> {
        for (number, line) in self.rest.by_ref() {
            self.last = number;
            if line.first() == Some(&b'#') {
                continue;
            }
            let text = str::from_utf8(line).map_err(|_| {
                (number, unexpected("text in UTF-8", &String::from_utf8_lossy(line)))
            })?;
            let words: Vec<&str> = text.split_ascii_whitespace().collect();
            if !words.is_empty() {
                return Ok(Some(Line { number, words }));
            }
        }
        Ok(None)
    }

    /// The next line, which has to be there.
    fn need(&mut self, wanted: &'static str) -> Parsed<Line<'a>> {
        self.next()?.ok_or((self.last, Problem::Ends { wanted }))
    }
}

/// `family truth kind h0 … h17`
fn pair_case(line: &Line<'_>) -> Parsed<PairCase> {
    let [family, truth, kind, ..] = line.fields::<21>(&line.words)?;
    let numbers: [f64; 18] = line.numbers(&line.words[3..])?;
    let intersect = line.truth(truth)?;
    let common = match kind {
        "none" => None,
        "point" => Some(Kind::Point),
        "segment" => Some(Kind::Segment),
        "area" => Some(Kind::Polygon),
        other => return line.refuse(unexpected("none, point, segment or area", other)),
    };
    if common.is_some() != intersect {
        let (truth, kind) = (truth.to_owned(), kind.to_owned());
        return line.refuse(Problem::Contradiction { truth, kind });
    }
    let (corners, _) = numbers.as_chunks::<3>();
    let triangle = |from: usize| -> Triangle { [0, 1, 2].map(|corner| corners[from + corner]) };
    let family = family.to_owned();
    Ok(PairCase { line: line.number, family, common, a: triangle(0), b: triangle(3) })
}

/// `source kind truth h0 … h23`
fn query(line: &Line<'_>) -> Parsed<Query> {
    let [source, kind, truth, ..] = line.fields::<27>(&line.words)?;
    let kind = match kind {
        "vf" => QueryKind::VertexFace,
        "ee" => QueryKind::EdgeEdge,
        other => return line.refuse(unexpected("the kind, vf or ee,", other)),
    };
    let contact = line.truth(truth)?;
    let numbers: [f64; 24] = line.numbers(&line.words[3..])?;
    let (vertices, _) = numbers.as_chunks::<3>();
    let [start, end] = [0, 4].map(|from| [0, 1, 2, 3].map(|vertex| vertices[from + vertex]));
    Ok(Query { line: line.number, source: source.to_owned(), kind, contact, start, end })
}

const TRANSFORM_WORDS: usize = 22;

/// `q(w x y z) t(x y z) p(x y z)  R(9) p'(3)`
fn transform_case(line: &Line<'_>) -> Parsed<TransformCase> {
    let numbers: [f64; TRANSFORM_WORDS] = line.numbers(&line.words)?;
    Ok(TransformCase {
        line: line.number,
        quaternion: part(&numbers, 0),
        translation: part(&numbers, 4),
        point: part(&numbers, 7),
        rotation: part(&numbers, 10),
        placed: part(&numbers, 19),
    })
}

fn part<const N: usize>(numbers: &[f64; TRANSFORM_WORDS], from: usize) -> [f64; N] {
    std::array::from_fn(|k| numbers[from + k])
}

/// `case NAME vertices_a faces_a vertices_b faces_b pairs`, and the lines that it announces.
fn mesh_case<'a>(line: Line<'a>, lines: &mut Lines<'a>) -> Parsed<MeshCase> {
    let [name, counts @ ..] = line.after::<6>("case")?;
    let [vertices_a, faces_a, vertices_b, faces_b, pair_count] = line.indices(counts)?;
    let quaternion = named_numbers(lines.need("the quaternion q")?, "q")?;
    let rotation = named_numbers(lines.need("the rotation R")?, "R")?;
    let translation = named_numbers(lines.need("the translation t")?, "t")?;
    let fixed = mesh(lines, "fixed", vertices_a, faces_a)?;
    let moving = mesh(lines, "moving", vertices_b, faces_b)?;
    let mut pairs: Vec<Pair> = Vec::new();
    for _ in 0..pair_count {
        let line = lines.need("a pair p")?;
        let pair: Pair = line.indices(line.after("p")?)?;
        if [&fixed, &moving].iter().zip(pair).any(|(mesh, i)| i as usize >= mesh.faces().len()) {
            return line.refuse(Problem::NoSuchPair(pair));
        }
        if pairs.last().is_some_and(|last| *last >= pair) {
            return line.refuse(Problem::Order(pair));
        }
        pairs.push(pair);
    }
    let (pose, name) = (Pose { rotation, translation }, name.to_owned());
    Ok(MeshCase { line: line.number, name, fixed, moving, quaternion, pose, pairs })
}

fn named_numbers<const N: usize>(line: Line<'_>, name: &'static str) -> Parsed<[f64; N]> {
    let words: [&str; N] = line.after(name)?;
    line.numbers(&words)
}

fn mesh<'a>(
    lines: &mut Lines<'a>,
    role: &'static str,
    vertices: u32,
    faces: u32,
) -> Parsed<TriangleMesh> {
    // Nothing is reserved: the counts may lie.
    let mut points: Vec<Point> = Vec::new();
    for _ in 0..vertices {
        points.push(named_numbers(lines.need("a vertex v")?, "v")?);
    }
    let (mut corners, mut last) = (Vec::new(), 0);
    for _ in 0..faces {
        let line = lines.need("a face f")?;
        corners.push(line.indices(line.after("f")?)?);
        last = line.number;
    }
    TriangleMesh::new(points, corners)
        .map_err(|error| (last, Problem::Mesh { role, error: error.into() }))
}
