use super::graph::{Content, Graph, NodeId};
use super::kind::Kind;
use super::lexer::Token;
use super::parser::unexpected;
use super::transform;
use crate::geometry::Point;
use crate::mesh::error::excerpt;
use crate::mesh::polygon::Polygons;
use crate::mesh::text::number;
use crate::mesh::{Problem, affine::Affine};

/// What has been read of a field's value.
#[derive(Clone, Copy, PartialEq)]
pub enum Value {
    Missing,
    /// Vectors, colours and rotations are several numbers without brackets.
    Numbers,
    Whole,
}

/// A node whose end has not been reached.
pub struct OpenNode<'a> {
    kind: Kind,
    name: &'a [u8],
    pub def: Option<&'a [u8]>,
    pub line: usize,
    field: Option<&'a [u8]>,
    value: Value,
    in_list: bool,
    /// The numbers of the fields that count.
    numbers: Vec<(&'a [u8], Vec<f64>)>,
    keeps_numbers: bool,
    nodes: Vec<NodeId>,
}

impl<'a> OpenNode<'a> {
    pub fn new(kind: Kind, name: &'a [u8], def: Option<&'a [u8]>, line: usize) -> Self {
        Self {
            kind,
            name,
            def,
            line,
            field: None,
            value: Value::Whole,
            in_list: false,
            numbers: Vec::new(),
            keeps_numbers: false,
            nodes: Vec::new(),
        }
    }

    pub fn title(&self) -> String {
        format!("the {} that begins in this line", excerpt(self.name))
    }

    /// A number, TRUE, FALSE or NULL as a value; everything else is the next field's name.
    pub fn word(&mut self, word: &'a [u8]) -> Result<(), Problem> {
        match word[0] {
            b'0'..=b'9' | b'+' | b'-' | b'.' => {
                self.expect_value(Value::Numbers)?;
                if self.keeps_numbers
                    && let Some((_, numbers)) = self.numbers.last_mut()
                {
                    numbers.push(number(word)?);
                }
                Ok(())
            }
            _ if matches!(word, b"TRUE" | b"FALSE" | b"NULL") => self.expect_value(Value::Whole),
            _ if self.in_list => Err(Problem::unexpected(word, "a number, a node or ]")),
            _ => self.begin_field(word),
        }
    }

    fn begin_field(&mut self, name: &'a [u8]) -> Result<(), Problem> {
        if self.value == Value::Missing && self.kind != Kind::Script {
            return Err(Problem::unexpected(name, "a value of the field before"));
        }
        self.field = Some(name);
        self.value = Value::Missing;
        self.keeps_numbers = self.kind.keeps_numbers(name);
        if self.keeps_numbers {
            if self.numbers.iter().any(|(earlier, _)| *earlier == name) {
                return Err(Problem::unexpected(name, "each field once"));
            }
            self.numbers.push((name, Vec::new()));
        }
        Ok(())
    }

    pub fn punctuation(&mut self, token: Token) -> Result<(), Problem> {
        match token {
            Token::Text => self.expect_value(Value::Whole),
            Token::ListBegin if !self.in_list => {
                self.expect_value(Value::Whole)?;
                self.in_list = true;
                Ok(())
            }
            Token::ListEnd if self.in_list => {
                self.in_list = false;
                Ok(())
            }
            _ => Err(unexpected(token, "a field or its value")),
        }
    }

    /// A value must belong to a field, and be its only one outside a list.
    pub fn expect_value(&mut self, value: Value) -> Result<(), Problem> {
        if self.field.is_none() {
            let found = format!("a value in {}", excerpt(self.name));
            return Err(Problem::Unexpected { found, expected: "a field name first" });
        }
        match (self.value, value) {
            _ if self.in_list => {}
            (Value::Missing, _) | (Value::Numbers, Value::Numbers) => self.value = value,
            _ => {
                let found = "a second value".into();
                return Err(Problem::Unexpected { found, expected: "the next field or }" });
            }
        }
        Ok(())
    }

    pub fn attach(&mut self, id: NodeId) {
        if self.field.is_some() && self.field == self.kind.nodes_field().map(str::as_bytes) {
            self.nodes.push(id);
        }
    }

    pub fn finish(mut self, graph: &Graph) -> Result<Content, Problem> {
        if self.in_list || (self.value == Value::Missing && self.kind != Kind::Script) {
            return Err(Problem::unexpected(b"}", "the rest of a field's value"));
        }
        Ok(match self.kind {
            Kind::Group(_) => Content::Group(self.nodes),
            Kind::Transform => {
                let nodes = std::mem::take(&mut self.nodes);
                Content::Transform(Box::new(self.transform()?), nodes)
            }
            Kind::Switch => {
                // Nothing is chosen by default.
                let choice = self.numbers(b"whichChoice").first().map_or(-1, |c| *c as i64);
                let chosen = usize::try_from(choice).ok().and_then(|c| self.nodes.get(c));
                Content::Group(chosen.copied().into_iter().collect())
            }
            // The first level is the most detailed.
            Kind::LevelOfDetail => {
                Content::Group(self.nodes.first().copied().into_iter().collect())
            }
            Kind::Faces => self.faces(graph)?,
            Kind::Coordinate => Content::Coordinate(self.points()?),
            Kind::NoSurface => Content::NoSurface,
            Kind::Script | Kind::Nothing => Content::Nothing,
        })
    }

    fn numbers(&self, field: &[u8]) -> &[f64] {
        let named = self.numbers.iter().find(|(name, _)| *name == field);
        named.map_or(&[], |(_, numbers)| numbers)
    }

    fn transform(&self) -> Result<Affine, Problem> {
        transform::from_fields(|field| self.numbers(field.as_bytes()))
    }

    fn points(&self) -> Result<Vec<Point>, Problem> {
        let numbers = self.numbers(b"point");
        match numbers.as_chunks() {
            (points, []) => Ok(points.to_vec()),
            _ => {
                let found = format!("{} numbers in point", numbers.len());
                Err(Problem::Unexpected { found, expected: "three for each point" })
            }
        }
    }

    fn faces(&self, graph: &Graph) -> Result<Content, Problem> {
        let indices = self.numbers(b"coordIndex");
        let coordinate = match self.nodes.as_slice() {
            [] if indices.is_empty() => return Ok(Content::Nothing),
            [id] => *id,
            nodes => {
                let found = format!("{} nodes as coord", nodes.len());
                return Err(Problem::Unexpected { found, expected: "one Coordinate" });
            }
        };
        let Content::Coordinate(points) = &graph.node(coordinate).content else {
            let found = "another node as coord".into();
            return Err(Problem::Unexpected { found, expected: "a Coordinate" });
        };
        let faces = polygons(indices, points)?;
        Ok(Content::Faces { coordinate, faces })
    }
}

/// Each polygon ends with -1, which may be missing after the last one.
fn polygons(indices: &[f64], points: &[Point]) -> Result<Vec<[u32; 3]>, Problem> {
    if indices.is_empty() {
        return Ok(Vec::new());
    }
    let vertices = points.len();
    let mut polygons = Polygons::default();
    let mut polygon = Vec::new();
    let indices = indices.strip_suffix(&[-1.0]).unwrap_or(indices);
    for (place, corners) in indices.split(|&index| index == -1.0).enumerate() {
        polygon.clear();
        for &corner in corners {
            if corner.fract() != 0.0 {
                return Err(Problem::NotAnIndex(corner.to_string()));
            }
            if corner < 0.0 || corner >= vertices as f64 {
                return Err(Problem::IndexOutOfRange { index: corner as i64, vertices });
            }
            polygon.push(corner as u32);
        }
        polygons
            .push(&polygon)
            .map_err(|problem| Problem::Malformed(format!("face {place}: {problem}")))?;
    }
    Ok(polygons.into_triangles(points))
}
