//! Draws with plotters.

use std::io;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::look::{INK, Look, Mark, printable};
use super::span::{Span, shortened};
use super::{Axis, Figure, Point, Scale};

pub(in crate::report) type DrawError = DrawingAreaErrorKind<io::Error>;
pub(in crate::report) type Place = (i32, i32);
type Chart<'a, 'b> = ChartContext<'b, SVGBackend<'a>, Cartesian2d<Span, Span>>;

pub(in crate::report) const WIDTH: u32 = 960;
/// Least: a long legend makes the figure taller.
const HEIGHT: u32 = 540;
const FONT: (&str, u32) = ("sans-serif", 16);
const TITLE_FONT: (&str, u32) = ("sans-serif", 20);
const LONGEST_TITLE: usize = 100;
/// Half of a mark's width.
pub(in crate::report) const RADIUS: i32 = 5;
/// Of a series: those with more points have marks at some of them.
const MOST_MARKS: usize = 40;

pub(super) fn draw(figure: &Figure) -> Result<String, DrawError> {
    let points = || figure.series.iter().flat_map(|one| &one.points);
    let x = span(&figure.x, points().map(|point| point.x));
    let y = span(&figure.y, points().flat_map(Point::heights));
    let is_bars = matches!(figure.x.scale, Scale::Names(_));
    let mut svg = String::new();
    {
        let canvas = Canvas::new(&mut svg, Legend::of(figure));
        let foot = y.foot();
        let labels = [figure.x.label.as_str(), &figure.y.label];
        let chart = canvas.frame(&figure.title, labels, x, y)?;
        for (number, one) in figure.series.iter().enumerate() {
            let look = Look::of(number);
            if is_bars {
                let slot = Slot { number, of: figure.series.len(), foot };
                canvas.bars(&chart, look, &slot, &one.points)?;
            } else {
                canvas.line(&chart, look, &one.points)?;
            }
        }
        canvas.legend(figure)?;
        canvas.present()?;
    }
    Ok(svg)
}

fn span(axis: &Axis, values: impl Iterator<Item = f64>) -> Span {
    match &axis.scale {
        Scale::Linear => Span::linear(values),
        Scale::Log => Span::log(values),
        Scale::Names(names) => Span::names(names),
    }
}

/// Without characters that have no place in a file.
fn clean(text: &str, longest: usize) -> String {
    shortened(&text.chars().map(printable).collect::<String>(), longest)
}

/// Where a series' bars are among those of the others at the same name.
struct Slot {
    number: usize,
    of: usize,
    foot: f64,
}

impl Slot {
    /// Left and right end of the bar at a name, on the axis of names.
    fn ends(&self, name: f64) -> [f64; 2] {
        let width = 0.8 / self.of as f64;
        let left = name - 0.4 + self.number as f64 * width;
        [left + 0.04 * width, left + 0.96 * width]
    }
}

/// What a figure is drawn on.
pub(in crate::report) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
    legend: Legend,
}

impl<'a> Canvas<'a> {
    pub fn new(svg: &'a mut String, legend: Legend) -> Self {
        let size = (WIDTH, HEIGHT.max(legend.height));
        Self { area: SVGBackend::with_string(svg, size).into_drawing_area(), legend }
    }

    /// Title, axes and grid.
    pub fn frame(
        &self,
        title: &str,
        labels: [&str; 2],
        x: Span,
        y: Span,
    ) -> Result<Chart<'a, '_>, DrawError> {
        let mut builder = ChartBuilder::on(&self.area);
        builder
            .caption(clean(title, LONGEST_TITLE), TITLE_FONT.into_font().color(&INK))
            .margin(12)
            .margin_right(20 + self.legend.width)
            .x_label_area_size(46)
            .y_label_area_size(88);
        let has_names = x.is_names();
        let mut chart = builder.build_cartesian_2d(x, y)?;
        let [x_label, y_label] = labels.map(|label| clean(label, LONGEST_TITLE));
        let mut mesh = chart.configure_mesh();
        if has_names {
            mesh.disable_x_mesh();
        }
        mesh.axis_style(INK)
            .bold_line_style(INK.mix(0.18))
            .light_line_style(INK.mix(0.07))
            .label_style(FONT.into_font().color(&INK))
            .x_desc(x_label)
            .y_desc(y_label)
            .draw()?;
        Ok(chart)
    }

    fn line(&self, chart: &Chart<'a, '_>, look: Look, points: &[Point]) -> Result<(), DrawError> {
        let places: Vec<Place> =
            points.iter().map(|point| chart.backend_coord(&(point.x, point.y))).collect();
        if places.len() > 1 {
            self.area.draw(&PathElement::new(places.clone(), look.line()))?;
        }
        for (point, &(x, _)) in points.iter().zip(&places) {
            self.error_bar(chart, look.colour, point, x)?;
        }
        let every = places.len() / MOST_MARKS + 1;
        places.iter().step_by(every).try_for_each(|&place| self.mark(look, place))
    }

    fn bars(
        &self,
        chart: &Chart<'a, '_>,
        look: Look,
        slot: &Slot,
        points: &[Point],
    ) -> Result<(), DrawError> {
        for point in points {
            let [left, right] = slot.ends(point.x);
            let corner = chart.backend_coord(&(left, point.y));
            let opposite = chart.backend_coord(&(right, slot.foot));
            self.bar([corner, opposite], look)?;
            let middle = (corner.0 + opposite.0) / 2;
            self.error_bar(chart, INK, point, middle)?;
            if slot.of > 1 {
                self.mark(look, (middle, corner.1))?;
            }
        }
        Ok(())
    }

    fn bar(&self, [one, other]: [Place; 2], look: Look) -> Result<(), DrawError> {
        let [left, right] = [one.0.min(other.0), one.0.max(other.0)];
        let [top, foot] = [one.1.min(other.1), one.1.max(other.1)];
        let corners = [(left, top), (right, foot)];
        self.draw_rectangle(corners, look.colour.mix(0.5))?;
        self.area.draw(&Rectangle::new(corners, look.colour.stroke_width(1)))
    }

    fn error_bar(
        &self,
        chart: &Chart<'a, '_>,
        colour: RGBColor,
        point: &Point,
        x: i32,
    ) -> Result<(), DrawError> {
        let Some(spread) = point.spread else { return Ok(()) };
        let [low, high] = spread.map(|y| chart.backend_coord(&(point.x, y)).1);
        let strokes =
            [[(x, low), (x, high)], [(x - 4, low), (x + 4, low)], [(x - 4, high), (x + 4, high)]];
        strokes.into_iter().try_for_each(|ends| {
            self.area.draw(&PathElement::new(ends.to_vec(), colour.stroke_width(1)))
        })
    }

    pub fn mark(&self, look: Look, place: Place) -> Result<(), DrawError> {
        const R: i32 = RADIUS;
        let colour = look.colour;
        let corners = |offsets: &[Place]| -> Vec<Place> {
            offsets.iter().map(|(x, y)| (place.0 + x, place.1 + y)).collect()
        };
        let filled =
            |offsets: &[Place]| self.area.draw(&Polygon::new(corners(offsets), colour.filled()));
        let stroked = |offsets: &[Place]| {
            self.area.draw(&PathElement::new(corners(offsets), colour.stroke_width(2)))
        };
        let square = [(-R + 1, -R + 1), (R - 1, -R + 1), (R - 1, R - 1), (-R + 1, R - 1)];
        match look.mark {
            Mark::Disc => self.area.draw(&Circle::new(place, RADIUS, colour.filled())),
            Mark::Ring => self.area.draw(&Circle::new(place, RADIUS, colour.stroke_width(2))),
            Mark::Square => filled(&square),
            Mark::Frame => stroked(&[&square[..], &square[..1]].concat()),
            Mark::Triangle => filled(&[(0, -R - 1), (R + 1, R - 1), (-R - 1, R - 1)]),
            Mark::Wedge => filled(&[(0, R + 1), (R + 1, -R + 1), (-R - 1, -R + 1)]),
            Mark::Diamond => filled(&[(0, -R - 1), (R + 1, 0), (0, R + 1), (-R - 1, 0)]),
            Mark::Cross => {
                stroked(&[(-R, -R), (R, R)])?;
                stroked(&[(-R, R), (R, -R)])
            }
        }
    }

    fn legend(&self, figure: &Figure) -> Result<(), DrawError> {
        let is_bars = matches!(figure.x.scale, Scale::Names(_));
        let left = (WIDTH - self.legend.width) as i32;
        let named = figure.series.iter().enumerate().filter(|(_, one)| !one.name.is_empty());
        for (row, (number, one)) in named.enumerate() {
            let look = Look::of(number);
            let middle = Legend::TOP + row as i32 * Legend::LINE;
            if is_bars {
                self.bar([(left, middle - 6), (left + 34, middle + 6)], look)?;
            } else {
                let ends = vec![(left, middle), (left + 34, middle)];
                self.area.draw(&PathElement::new(ends, look.line()))?;
            }
            self.mark(look, (left + 17, middle))?;
            self.text(&clean(&one.name, Legend::LONGEST), (left + 42, middle))?;
        }
        Ok(())
    }

    /// Left end of its middle line at a place.
    pub fn text(&self, text: &str, place: Place) -> Result<(), DrawError> {
        let style = FONT.into_font().color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
        self.area.draw(&Text::new(clean(text, LONGEST_TITLE), place, style))
    }

    pub fn draw_rectangle(&self, corners: [Place; 2], style: RGBAColor) -> Result<(), DrawError> {
        self.area.draw(&Rectangle::new(corners, style.filled()))
    }

    pub fn draw_path(&self, places: Vec<Place>, style: ShapeStyle) -> Result<(), DrawError> {
        self.area.draw(&PathElement::new(places, style))
    }

    pub fn present(&self) -> Result<(), DrawError> {
        self.area.present()
    }
}

/// Pixels for the names of the series, right of the chart.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::report) struct Legend {
    width: u32,
    height: u32,
}

impl Legend {
    const TOP: i32 = 58;
    const LINE: i32 = 22;
    const LONGEST: usize = 34;

    fn of(figure: &Figure) -> Self {
        let named = || figure.series.iter().filter(|one| !one.name.is_empty());
        let length = |name: &str| name.chars().count().min(Self::LONGEST) as u32;
        let longest = named().map(|one| length(&one.name)).max();
        let width = longest.map_or(0, |longest| 60 + 7 * longest);
        Self { width, height: (Self::TOP + Self::LINE * named().count() as i32) as u32 }
    }
}
