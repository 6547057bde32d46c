use crate::mesh::{FormatError, Problem};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Token<'a> {
    /// A name, keyword or number.
    Word(&'a [u8]),
    Text,
    NodeBegin,
    NodeEnd,
    ListBegin,
    ListEnd,
}

#[derive(Clone)]
pub struct Lexer<'a> {
    text: &'a [u8],
    at: usize,
    /// Of the token that was read last, counted from 1.
    pub line: usize,
}

impl<'a> Lexer<'a> {
    pub fn new(text: &'a [u8]) -> Self {
        Self { text, at: 0, line: 1 }
    }

    pub fn next(&mut self) -> Result<Option<Token<'a>>, FormatError> {
        self.skip_blank();
        let Some(&first) = self.text.get(self.at) else { return Ok(None) };
        self.at += 1;
        Ok(Some(match first {
            b'{' => Token::NodeBegin,
            b'}' => Token::NodeEnd,
            b'[' => Token::ListBegin,
            b']' => Token::ListEnd,
            b'"' => self.string()?,
            _ => {
                let rest = &self.text[self.at..];
                let length = rest.iter().position(|b| ends_word(*b)).unwrap_or(rest.len());
                let start = self.at - 1;
                self.at += length;
                Token::Word(&self.text[start..self.at])
            }
        }))
    }

    pub fn node_begins(&self) -> bool {
        let mut ahead = self.clone();
        ahead.skip_blank();
        ahead.text.get(ahead.at) == Some(&b'{')
    }

    /// White space, commas and comments.
    fn skip_blank(&mut self) {
        while let Some(&byte) = self.text.get(self.at) {
            match byte {
                b'#' => {
                    let rest = &self.text[self.at..];
                    let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
                    self.at += end.unwrap_or(rest.len());
                }
                b' ' | b'\t' | b',' | b'\n' | b'\r' => self.step_over(byte),
                _ => return,
            }
        }
    }

    /// CR LF is one line end; the LF counts.
    fn step_over(&mut self, byte: u8) {
        self.at += 1;
        let followed = self.text.get(self.at) == Some(&b'\n');
        self.line += usize::from(byte == b'\n' || (byte == b'\r' && !followed));
    }

    fn string(&mut self) -> Result<Token<'a>, FormatError> {
        let begin = self.line;
        while let Some(&byte) = self.text.get(self.at) {
            self.step_over(byte);
            match byte {
                b'"' => return Ok(Token::Text),
                b'\\' if self.at < self.text.len() => self.step_over(self.text[self.at]),
                _ => {}
            }
        }
        Err(Problem::EndsWithin("a string".into()).at_line(begin))
    }
}

fn ends_word(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b',' | b'\n' | b'\r' | b'#' | b'{' | b'}' | b'[' | b']' | b'"')
}
