//! Continuous queries of known truth, and how [`crate::geometry::continuous`] answers them.
//!
//! A file has a query a line, `source kind truth h0 … h23`: the kind is `vf` (vertex p against triangle
//! v0 v1 v2) or `ee` (edge a0 a1 against edge b0 b1), the truth 1 if they are in contact at any time
//! in the closed [0, 1], and the numbers are the vertices p v0 v1 v2 or a0 a1 b0 b1 at the start, x y z
//! each, and then at the end. As in the other suites, numbers are bit patterns in hexadecimal digits,
//! `#` begins a comment, and the file may be compressed.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

use super::{SuiteError, content, parsed, text};
use crate::geometry::Point;
use crate::geometry::continuous::{
    TimeOfImpact, edge_edge, edge_edge_in_integers, vertex_face, vertex_face_in_integers,
};

/// What is asked of each query; answers are exact whatever it is.
const TOLERANCE: f64 = 1e-9;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QueryKind {
    VertexFace,
    EdgeEdge,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Query {
    /// From 1, in the suite's file.
    pub line: usize,
    pub source: String,
    pub kind: QueryKind,
    /// Whether they ever are.
    pub contact: bool,
    pub start: [Point; 4],
    pub end: [Point; 4],
}

impl Query {
    pub fn answer(&self, tolerance: f64) -> Option<TimeOfImpact> {
        match self.kind {
            QueryKind::VertexFace => vertex_face(&self.start, &self.end, tolerance),
            QueryKind::EdgeEdge => edge_edge(&self.start, &self.end, tolerance),
        }
    }

    /// The first time of contact to 2^-53, without any rounding before that.
    pub fn reference(&self) -> Option<TimeOfImpact> {
        match self.kind {
            QueryKind::VertexFace => vertex_face_in_integers(&self.start, &self.end, 0.0),
            QueryKind::EdgeEdge => edge_edge_in_integers(&self.start, &self.end, 0.0),
        }
    }
}

/// The queries of one file, at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct QuerySuite {
    /// Its file.
    pub name: String,
    pub queries: Vec<Query>,
}

impl QuerySuite {
    pub fn read(path: &Path) -> Result<Self, SuiteError> {
        Self::parse(&content(path)?, &path.display().to_string())
    }

    /// As [`QuerySuite::read`], of the content of a file that errors call `name`.
    pub fn parse(bytes: &[u8], name: &str) -> Result<Self, SuiteError> {
        Ok(Self { name: name.to_owned(), queries: parsed(bytes, name, text::parse_queries)? })
    }
}

/// The queries of a source.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct QueryRow {
    pub source: String,
    pub queries: u32,
    /// Contacts without an answer.
    pub missed: u32,
    /// Answers without a contact.
    pub extra: u32,
    /// How far an end of an answer's interval is from the [`Query::reference`] at most, as a part of
    /// the motion; of queries that both found in contact.
    pub worst_time_error: Option<f64>,
    /// Of one thread, with all else idle.
    pub mean_ns: f64,
}

/// A query that was answered wrongly.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WrongQuery {
    pub suite: String,
    pub line: usize,
    pub source: String,
    /// Or extra.
    pub missed: bool,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct QueryReport {
    /// In the order of the files.
    pub rows: Vec<QueryRow>,
    pub total: QueryRow,
    pub wrong: Vec<WrongQuery>,
}

/// Answers every query. `on_done` is told of some more that are done, from any thread.
pub fn check(suites: &[QuerySuite], on_done: &(dyn Fn(u64) + Sync)) -> QueryReport {
    let mut report = QueryReport::default();
    report.total.source = "all".to_owned();
    for suite in suites {
        for (source, queries) in by_source(&suite.queries) {
            let answered = |query: &&Query| {
                let answers = [query.answer(TOLERANCE), query.reference()];
                on_done(1);
                answers
            };
            let answers: Vec<_> = queries.par_iter().map(answered).collect();
            let mean_ns = mean_ns(&queries);
            report.rows.push(QueryRow {
                source: source.to_owned(),
                mean_ns,
                ..QueryRow::default()
            });
            report.total.mean_ns += mean_ns * queries.len() as f64;
            for (query, answer) in queries.iter().zip(answers) {
                report.add(&suite.name, query, answer);
            }
        }
    }
    report.total.mean_ns /= f64::from(report.total.queries).max(1.0);
    report
}

/// Each source with its queries, in the order of their first.
fn by_source(queries: &[Query]) -> Vec<(&str, Vec<&Query>)> {
    let mut sources: Vec<(&str, Vec<&Query>)> = Vec::new();
    for query in queries {
        match sources.iter_mut().rev().find(|(source, _)| *source == query.source) {
            Some((_, of_source)) => of_source.push(query),
            None => sources.push((&query.source, vec![query])),
        }
    }
    sources
}

fn mean_ns(queries: &[&Query]) -> f64 {
    let start = Instant::now();
    for query in queries {
        black_box(black_box(query).answer(TOLERANCE));
    }
    start.elapsed().as_nanos() as f64 / queries.len() as f64
}

impl QueryReport {
    /// To the last row, and the total.
    fn add(&mut self, suite: &str, query: &Query, answers: [Option<TimeOfImpact>; 2]) {
        let found = answers[0].is_some();
        for row in self.rows.last_mut().into_iter().chain([&mut self.total]) {
            row.queries += 1;
            row.missed += u32::from(query.contact && !found);
            row.extra += u32::from(!query.contact && found);
            if let [Some(answer), Some(reference)] = answers {
                let error = f64::abs(answer.earliest - reference.earliest)
                    .max(f64::abs(answer.latest - reference.latest));
                row.worst_time_error =
                    Some(row.worst_time_error.map_or(error, |worst| worst.max(error)));
            }
        }
        if found != query.contact {
            let (suite, source) = (suite.to_owned(), query.source.clone());
            self.wrong.push(WrongQuery { suite, line: query.line, source, missed: !found });
        }
    }
}
