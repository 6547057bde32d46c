//! What is shown as a picture.

use std::collections::BTreeSet;

use super::accuracy_plot::AccuracyPlot;
use super::figure::{Figure, FigureError, Table};

#[derive(Clone, Debug, PartialEq)]
pub enum Drawing {
    Figure(Figure),
    Accuracy(AccuracyPlot),
}

impl Drawing {
    /// Stem of its file.
    pub fn name(&self) -> &str {
        match self {
            Self::Figure(figure) => &figure.name,
            Self::Accuracy(_) => AccuracyPlot::NAME,
        }
    }

    pub fn to_svg(&self) -> Result<String, FigureError> {
        match self {
            Self::Figure(figure) => figure.to_svg(),
            Self::Accuracy(plot) => plot.to_svg(),
        }
    }

    pub fn to_inline_svg(&self) -> Result<String, FigureError> {
        match self {
            Self::Figure(figure) => figure.to_inline_svg(),
            Self::Accuracy(plot) => plot.to_inline_svg(),
        }
    }

    pub fn numbers(&self) -> Table {
        match self {
            Self::Figure(figure) => figure.numbers(),
            Self::Accuracy(plot) => plot.numbers(),
        }
    }

    pub(super) fn check(&self) -> Result<(), FigureError> {
        match self {
            Self::Figure(figure) => figure.check(),
            Self::Accuracy(plot) => plot.check(),
        }
    }
}

impl From<Figure> for Drawing {
    fn from(figure: Figure) -> Self {
        Self::Figure(figure)
    }
}

/// Each drawing as an SVG file of its name; of equal names the second has `-2` behind it, and so on.
pub fn svg_files<'a>(
    drawings: impl IntoIterator<Item = &'a Drawing>,
) -> Result<Vec<(String, String)>, FigureError> {
    let mut taken = BTreeSet::new();
    let mut file_name = |name: &str| {
        let others = (2..).map(|number| format!("{name}-{number}.svg"));
        let mut names = [format!("{name}.svg")].into_iter().chain(others);
        names.find(|name| taken.insert(name.clone())).expect("there are ever more")
    };
    drawings.into_iter().map(|drawing| Ok((file_name(drawing.name()), drawing.to_svg()?))).collect()
}
