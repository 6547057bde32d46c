//! The numbers of a figure, to be read beside it.

use super::{Figure, Point, Scale, Series, Table, number};

impl Figure {
    /// A column for each series where they share their places on the x axis, otherwise a row for
    /// each point.
    pub fn numbers(&self) -> Table {
        let places = self.places();
        let points: usize = self.series.iter().map(|one| one.points.len()).sum();
        let is_dense = 2 * points >= places.len() * self.series.len();
        let is_grid = is_dense && !self.series.iter().any(has_two_at_a_place);
        let (columns, rows) = if is_grid { self.by_place(&places) } else { self.by_point() };
        let has_label = columns.contains(&self.y.label);
        let title = if has_label { String::new() } else { self.y.label.clone() };
        Table { title, columns, rows }
    }

    /// Each once, in order.
    fn places(&self) -> Vec<f64> {
        let points = self.series.iter().flat_map(|one| &one.points);
        let mut places: Vec<f64> = points.map(|point| point.x).collect();
        places.sort_by(f64::total_cmp);
        places.dedup_by(|next, place| is_same(*next, *place));
        places
    }

    fn by_place(&self, places: &[f64]) -> (Vec<String>, Vec<Vec<String>>) {
        let name = |one: &Series| match one.name.as_str() {
            "" => self.y.label.clone(),
            name => name.to_owned(),
        };
        let columns = [self.x.label.clone()].into_iter().chain(self.series.iter().map(name));
        let cell = |one: &Series, x: f64| {
            one.points.iter().find(|point| is_same(point.x, x)).map_or_else(String::new, value)
        };
        let row = |&x: &f64| {
            let cells = self.series.iter().map(|one| cell(one, x));
            [self.place(x)].into_iter().chain(cells).collect()
        };
        (columns.collect(), places.iter().map(row).collect())
    }

    fn by_point(&self) -> (Vec<String>, Vec<Vec<String>>) {
        let columns = vec!["series".to_owned(), self.x.label.clone(), self.y.label.clone()];
        let rows = self.series.iter().flat_map(|one| {
            let row = |point: &Point| vec![one.name.clone(), self.place(point.x), value(point)];
            one.points.iter().map(row)
        });
        (columns, rows.collect())
    }

    fn place(&self, x: f64) -> String {
        match &self.x.scale {
            Scale::Names(names) => names.get(x as usize).cloned().unwrap_or_default(),
            Scale::Linear | Scale::Log => number(x),
        }
    }
}

/// But for rounding.
fn is_same(place: f64, other: f64) -> bool {
    (place - other).abs() <= 1e-9 * place.abs()
}

fn has_two_at_a_place(one: &Series) -> bool {
    let mut places: Vec<f64> = one.points.iter().map(|point| point.x).collect();
    places.sort_by(f64::total_cmp);
    places.windows(2).any(|pair| is_same(pair[0], pair[1]))
}

fn value(point: &Point) -> String {
    let value = number(point.y);
    match point.spread {
        Some([least, most]) if least < 0.0 => {
            format!("{value} ({} to {})", number(least), number(most))
        }
        Some([least, most]) => format!("{value} ({}–{})", number(least), number(most)),
        None => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::figure::Axis;

    fn figure(series: &[(&str, &[[f64; 2]])]) -> Figure {
        let one = |(name, points): &(&str, &[[f64; 2]])| Series {
            name: (*name).to_owned(),
            points: points.iter().map(|&[x, y]| Point::at(x, y)).collect(),
        };
        Figure {
            name: "name".to_owned(),
            title: "Title".to_owned(),
            x: Axis::linear("x"),
            y: Axis::linear("y (us)"),
            series: series.iter().map(one).collect(),
        }
    }

    #[test]
    fn series_of_the_same_places_are_columns() {
        let table =
            figure(&[("a", &[[2.0, 5.0], [0.1, 0.5]]), ("", &[[0.3 - 0.2, 7.0]])]).numbers();
        assert_eq!(table.title, "", "it is over a column");
        assert_eq!(table.columns, ["x", "a", "y (us)"]);
        assert_eq!(table.rows, [["0.1", "0.5", "7"], ["2", "5", ""]]);
    }

    #[test]
    fn other_series_are_rows() {
        let named = figure(&[("a", &[[1.0, 1.0]])]).numbers();
        assert_eq!((named.title.as_str(), named.columns[1].as_str()), ("y (us)", "a"));
        let twice = figure(&[("a", &[[1.0, 5.0], [1.0, 6.0]])]).numbers();
        assert_eq!(twice.rows, [["a", "1", "5"], ["a", "1", "6"]]);
        let apart: Vec<_> = [[[1.0, 1.0]], [[2.0, 1.0]], [[3.0, 1.0]]].to_vec();
        let apart = figure(&[("a", &apart[0]), ("b", &apart[1]), ("c", &apart[2])]).numbers();
        assert_eq!(apart.columns, ["series", "x", "y (us)"]);
        assert_eq!(apart.rows.len(), 3);
        assert_eq!(figure(&[]).numbers().rows.len(), 0);
    }

    #[test]
    fn names_and_spreads_are_words() {
        let mut bars = figure(&[("", &[[1.0, 5.0]])]);
        bars.x.scale = Scale::Names(vec!["load".to_owned(), "build".to_owned()]);
        bars.series[0].points[0].spread = Some([4.0, 6000.0]);
        assert_eq!(bars.numbers().rows, [["build", "5 (4–6,000)"]]);
        bars.series[0].points[0].spread = Some([-4.0, 6.0]);
        assert_eq!(bars.numbers().rows, [["build", "5 (-4 to 6)"]]);
    }
}
