use std::collections::HashMap;

use super::graph::{Content, Graph, Node, NodeId};
use super::kind::Kind;
use super::lexer::{Lexer, Token};
use super::node::{OpenNode, Value};
use crate::mesh::{FormatError, Problem};

/// Reads the whole text into its graph. The nodes that are open at a time are kept on a stack of
/// our own.
pub fn parse(text: &[u8]) -> Result<Graph, FormatError> {
    let mut parser = Parser {
        lexer: Lexer::new(text),
        open: Vec::new(),
        graph: Graph { nodes: Vec::new(), roots: Vec::new() },
        names: HashMap::new(),
        prototypes: HashMap::new(),
    };
    while let Some(token) = parser.lexer.next()? {
        parser.token(token)?;
    }
    match parser.open.last() {
        None => Ok(parser.graph),
        Some(node) => Err(Problem::EndsWithin(node.title()).at_line(node.line)),
    }
}

struct Parser<'a> {
    lexer: Lexer<'a>,
    open: Vec<OpenNode<'a>>,
    graph: Graph,
    /// What USE refers to: the latest node of each name.
    names: HashMap<&'a [u8], NodeId>,
    /// Declared prototypes and the lines of their declarations.
    prototypes: HashMap<&'a [u8], usize>,
}

impl<'a> Parser<'a> {
    fn token(&mut self, token: Token<'a>) -> Result<(), FormatError> {
        match token {
            Token::Word(word) => self.word(word),
            Token::NodeEnd => self.end_node(),
            Token::Text | Token::ListBegin | Token::ListEnd | Token::NodeBegin => {
                let line = self.lexer.line;
                let Some(node) = self.open.last_mut() else {
                    return Err(unexpected(token, "a node").at_line(line));
                };
                node.punctuation(token).map_err(|p| p.at_line(line))
            }
        }
    }

    fn word(&mut self, word: &'a [u8]) -> Result<(), FormatError> {
        match word {
            b"DEF" => {
                let name = self.expect_word("a name after DEF")?;
                let kind = self.expect_word("a node type after DEF and its name")?;
                return self.begin_node(kind, Some(name));
            }
            b"USE" => return self.use_node(),
            b"PROTO" => return self.skip_prototype(true),
            b"EXTERNPROTO" => return self.skip_prototype(false),
            b"ROUTE" => return (0..3).try_for_each(|_| self.expect_word("a route").map(drop)),
            _ => {}
        }
        let line = self.lexer.line;
        let begins_node = word[0].is_ascii_alphabetic() || word[0] == b'_' || word[0] >= 0x80;
        if begins_node && self.lexer.node_begins() {
            return self.begin_node(word, None);
        }
        match self.open.last_mut() {
            Some(node) => node.word(word).map_err(|p| p.at_line(line)),
            None => Err(Problem::unexpected(word, "a node, PROTO or ROUTE").at_line(line)),
        }
    }

    fn expect_word(&mut self, expected: &'static str) -> Result<&'a [u8], FormatError> {
        match self.lexer.next()? {
            Some(Token::Word(word)) => Ok(word),
            Some(token) => Err(unexpected(token, expected).at_line(self.lexer.line)),
            None => Err(Problem::EndsWithin("a statement".into()).at_line(self.lexer.line)),
        }
    }

    fn begin_node(&mut self, name: &'a [u8], def: Option<&'a [u8]>) -> Result<(), FormatError> {
        let line = self.lexer.line;
        let kind = match self.prototypes.get(name) {
            Some(declared) => {
                let name = name.escape_ascii();
                let what =
                    format!("an instance of the prototype {name} (declared in line {declared})");
                let remedy = "export the file without prototypes";
                Err(Problem::Unsupported { what, remedy })
            }
            None => Kind::parse(name),
        };
        let kind = kind.map_err(|p| p.at_line(line))?;
        match self.lexer.next()? {
            Some(Token::NodeBegin) => {}
            Some(token) => return Err(unexpected(token, "{ after a node type").at_line(line)),
            None => return Err(Problem::EndsWithin("a node".into()).at_line(line)),
        }
        if let Some(parent) = self.open.last_mut() {
            parent.expect_value(Value::Whole).map_err(|p| p.at_line(line))?;
        }
        self.open.push(OpenNode::new(kind, name, def, line));
        Ok(())
    }

    fn end_node(&mut self) -> Result<(), FormatError> {
        let line = self.lexer.line;
        let Some(node) = self.open.pop() else {
            return Err(unexpected(Token::NodeEnd, "a node").at_line(line));
        };
        let (def, begin) = (node.def, node.line);
        let content = node.finish(&self.graph).map_err(|p| p.at_line(begin))?;
        let id = self.graph.nodes.len() as NodeId;
        let size = size(&content, &self.graph);
        self.graph.nodes.push(Node { line: begin, content, size });
        if let Some(name) = def {
            self.names.insert(name, id);
        }
        self.attach(id);
        Ok(())
    }

    fn use_node(&mut self) -> Result<(), FormatError> {
        let name = self.expect_word("a name after USE")?;
        let line = self.lexer.line;
        let Some(&id) = self.names.get(name) else {
            return Err(Problem::unexpected(name, "the name of an earlier node").at_line(line));
        };
        if let Some(parent) = self.open.last_mut() {
            parent.expect_value(Value::Whole).map_err(|p| p.at_line(line))?;
        }
        self.attach(id);
        Ok(())
    }

    fn attach(&mut self, id: NodeId) {
        match self.open.last_mut() {
            Some(parent) => parent.attach(id),
            None => self.graph.roots.push(id),
        }
    }

    /// Steps over a declaration: its interface, then its body or its URLs.
    fn skip_prototype(&mut self, has_body: bool) -> Result<(), FormatError> {
        let name = self.expect_word("a name after PROTO")?;
        self.prototypes.insert(name, self.lexer.line);
        self.skip_balanced()?;
        if has_body { self.skip_balanced() } else { self.skip_balanced_or_text() }
    }

    fn skip_balanced_or_text(&mut self) -> Result<(), FormatError> {
        let mut ahead = self.lexer.clone();
        match ahead.next()? {
            Some(Token::Text) => {
                self.lexer = ahead;
                Ok(())
            }
            _ => self.skip_balanced(),
        }
    }

    fn skip_balanced(&mut self) -> Result<(), FormatError> {
        let begin = self.lexer.line;
        let mut depth = 0_usize;
        while let Some(token) = self.lexer.next()? {
            match token {
                Token::NodeBegin | Token::ListBegin => depth += 1,
                Token::NodeEnd | Token::ListEnd if depth > 0 => depth -= 1,
                _ if depth > 0 => {}
                _ => return Err(unexpected(token, "[ or {").at_line(self.lexer.line)),
            }
            if depth == 0 {
                return Ok(());
            }
        }
        Err(Problem::EndsWithin("a prototype".into()).at_line(begin))
    }
}

fn size(content: &Content, graph: &Graph) -> u64 {
    let of_node = |id: &NodeId| graph.node(*id).size;
    let inside = match content {
        Content::Group(children) | Content::Transform(_, children) => {
            children.iter().map(of_node).fold(0, u64::saturating_add)
        }
        Content::Faces { coordinate, faces } => of_node(coordinate) + faces.len() as u64,
        Content::Coordinate(points) => points.len() as u64,
        Content::NoSurface | Content::Nothing => 0,
    };
    inside.saturating_add(1)
}

pub(super) fn unexpected(token: Token, expected: &'static str) -> Problem {
    let found: &[u8] = match token {
        Token::Word(word) => word,
        Token::Text => b"a string",
        Token::NodeBegin => b"{",
        Token::NodeEnd => b"}",
        Token::ListBegin => b"[",
        Token::ListEnd => b"]",
    };
    Problem::unexpected(found, expected)
}
