//! Figures and tables as values: what is measured says what is to be seen, and this draws it, alone
//! as an SVG file or within a page.

mod chart;
mod look;
mod number;
mod numbers;
mod span;

use serde::{Deserialize, Serialize};

pub(super) use chart::{Canvas, DrawError, Legend, Place, RADIUS, WIDTH};
pub(super) use look::{INK, Look, as_file, escaped, within_page};
pub use number::{grouped, number};
pub(super) use span::Span;

/// Lines, or bars over names. Black on white or white on black as the reader has it; its series can
/// be told apart without colour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// Stem of its file: letters, digits, `-` and `_`.
    pub name: String,
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    /// A figure without series or points is empty axes.
    pub series: Vec<Series>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// With its unit.
    pub label: String,
    pub scale: Scale,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// From zero, or from the least value below it.
    Linear,
    /// All values are above zero.
    Log,
    /// Of the x axis only: its points are bars at the numbers of these names, from 0.
    Names(Vec<String>),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Series {
    /// For the legend, which lists the series that have one.
    pub name: String,
    /// Joined in this order.
    pub points: Vec<Point>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    pub x: f64,
    pub y: f64,
    /// The least and the most of the samples that `y` stands for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread: Option<[f64; 2]>,
}

/// Cells as they are to be read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    pub title: String,
    /// With their units.
    pub columns: Vec<String>,
    /// As many cells as columns.
    pub rows: Vec<Vec<String>>,
}

#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    #[error(
        "figure `{0}`: its name is the stem of a file: letters, digits, `-` and `_`, 100 at most"
    )]
    Name(String),
    #[error(
        "figure `{figure}`: {series}: point {point} is neither zero nor between 1e-200 and 1e200 in size"
    )]
    OutOfRange { figure: String, series: String, point: usize },
    #[error("figure `{figure}`: {series}: point {point} is not above zero on a logarithmic axis")]
    NotPositive { figure: String, series: String, point: usize },
    #[error("figure `{figure}`: {series}: point {point} has a least sample above the most")]
    Spread { figure: String, series: String, point: usize },
    #[error("figure `{figure}`: {series}: point {point} is at none of the names of the x axis")]
    NoSuchName { figure: String, series: String, point: usize },
    #[error("figure `{0}`: names belong on the x axis")]
    NamesOnY(String),
    #[error("table `{table}`: row {row} has more or fewer cells than there are columns")]
    Cells { table: String, row: usize },
    #[error("figure `{figure}`: cannot be drawn: {source}")]
    Draw { figure: String, source: chart::DrawError },
}

/// Sizes that an axis can be computed with.
const SIZES: std::ops::RangeInclusive<f64> = 1e-200..=1e200;
const LONGEST_NAME: usize = 100;

pub(super) fn is_usable(value: f64) -> bool {
    value == 0.0 || SIZES.contains(&value.abs())
}

impl Axis {
    pub fn linear(label: &str) -> Self {
        Self { label: label.to_owned(), scale: Scale::Linear }
    }

    pub fn log(label: &str) -> Self {
        Self { label: label.to_owned(), scale: Scale::Log }
    }
}

impl Point {
    pub fn at(x: f64, y: f64) -> Self {
        Self { x, y, spread: None }
    }

    /// All values on the y axis.
    fn heights(&self) -> impl Iterator<Item = f64> {
        [self.y].into_iter().chain(self.spread.into_iter().flatten())
    }
}

impl Series {
    /// One for each name, in the order of their first points.
    pub fn grouped(points: impl IntoIterator<Item = (String, Point)>) -> Vec<Self> {
        let mut series: Vec<Self> = Vec::new();
        for (name, point) in points {
            match series.iter_mut().find(|one| one.name == name) {
                Some(one) => one.points.push(point),
                None => series.push(Self { name, points: vec![point] }),
            }
        }
        series
    }
}

impl Figure {
    /// A file of its own.
    pub fn to_svg(&self) -> Result<String, FigureError> {
        Ok(look::as_file(&self.draw()?, &self.title))
    }

    /// For a page, whose text colour it takes.
    pub fn to_inline_svg(&self) -> Result<String, FigureError> {
        Ok(look::within_page(&self.draw()?, &self.title))
    }

    fn draw(&self) -> Result<String, FigureError> {
        self.check()?;
        chart::draw(self).map_err(|source| FigureError::Draw { figure: self.name.clone(), source })
    }

    /// Whether it can be drawn.
    pub(super) fn check(&self) -> Result<(), FigureError> {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        let is_stem = (1..=LONGEST_NAME).contains(&self.name.len());
        if !is_stem || !self.name.chars().all(is_plain) {
            return Err(FigureError::Name(self.name.clone()));
        }
        if let Scale::Names(_) = self.y.scale {
            return Err(FigureError::NamesOnY(self.name.clone()));
        }
        for series in &self.series {
            for (point, at) in series.points.iter().enumerate() {
                self.check_point(&series.name, point, at)?;
            }
        }
        Ok(())
    }

    fn check_point(&self, series: &str, point: usize, at: &Point) -> Result<(), FigureError> {
        let (figure, series) = (self.name.clone(), series.to_owned());
        if !is_usable(at.x) || !at.heights().all(is_usable) {
            return Err(FigureError::OutOfRange { figure, series, point });
        }
        let x_is_low = self.x.scale == Scale::Log && at.x <= 0.0;
        let y_is_low = self.y.scale == Scale::Log && at.heights().any(|y| y <= 0.0);
        if x_is_low || y_is_low {
            return Err(FigureError::NotPositive { figure, series, point });
        }
        if at.spread.is_some_and(|[least, most]| least > most) {
            return Err(FigureError::Spread { figure, series, point });
        }
        match &self.x.scale {
            Scale::Names(names) if !(0..names.len()).any(|number| number as f64 == at.x) => {
                Err(FigureError::NoSuchName { figure, series, point })
            }
            _ => Ok(()),
        }
    }
}

impl Table {
    /// For a terminal: a title, and columns as wide as their widest cell.
    pub fn to_text(&self) -> String {
        let lines = || [&self.columns].into_iter().chain(&self.rows);
        let width = |column: usize| lines().map(|row| row[column].chars().count()).max();
        let widths: Vec<_> = (0..self.columns.len()).filter_map(width).collect();
        let mut text = format!("{}\n", self.title);
        for line in lines() {
            for (cell, &width) in line.iter().zip(&widths) {
                text += &format!("  {cell:>width$}");
            }
            text += "\n";
        }
        text
    }

    pub(super) fn check(&self) -> Result<(), FigureError> {
        let ragged = self.rows.iter().position(|row| row.len() != self.columns.len());
        let table = || self.title.clone();
        ragged.map_or(Ok(()), |row| Err(FigureError::Cells { table: table(), row }))
    }
}

#[cfg(test)]
pub(in crate::report) mod tests;
