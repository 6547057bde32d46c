//! Finds columns whose boxes overlap: a grid on the ground.

use super::column::{Column, Room};
use crate::geometry::predicates::Point2;

/// Columns by the cells that their boxes reach into. Holds its memory.
#[derive(Debug, Default)]
pub struct Grid {
    cells: [usize; 2],
    cell_size: Point2,
    /// Where each cell's columns begin in `columns`.
    starts: Vec<u32>,
    columns: Vec<u32>,
}

impl Grid {
    /// More cells would hold the same columns again and again.
    const MOST: f64 = 256.0;

    pub fn fill(&mut self, columns: &[Column], room: &Room) {
        for axis in 0..2 {
            let width: f64 = columns.iter().map(|c| c.high[axis] - c.low[axis]).sum();
            let mean = width / columns.len().max(1) as f64;
            let cells = (room.size[axis] / (2.0 * mean)).clamp(1.0, Self::MOST).floor();
            self.cells[axis] = cells as usize;
            self.cell_size[axis] = room.size[axis] / cells;
        }
        // Counted, then summed up to where each cell ends, then filled from there backwards.
        self.starts.clear();
        self.starts.resize(self.cells[0] * self.cells[1] + 1, 0);
        for column in columns {
            self.each_cell(column, |grid, cell| grid.starts[cell] += 1);
        }
        let mut total = 0;
        for start in &mut self.starts {
            total += *start;
            *start = total;
        }
        self.columns.clear();
        self.columns.resize(total as usize, 0);
        for (i, column) in columns.iter().enumerate().rev() {
            self.each_cell(column, |grid, cell| {
                grid.starts[cell] -= 1;
                grid.columns[grid.starts[cell] as usize] = i as u32;
            });
        }
    }

    fn cell(&self, [x, y]: &Point2) -> [usize; 2] {
        [(x, 0), (y, 1)].map(|(c, axis): (&f64, usize)| {
            ((c / self.cell_size[axis]) as usize).min(self.cells[axis] - 1)
        })
    }

    fn each_cell(&mut self, column: &Column, mut act: impl FnMut(&mut Self, usize)) {
        let ([x0, y0], [x1, y1]) = (self.cell(&column.low), self.cell(&column.high));
        for y in y0..=y1 {
            for x in x0..=x1 {
                act(self, y * self.cells[0] + x);
            }
        }
    }

    /// Gives each column once whose box overlaps that of `column`.
    pub fn each_overlapping<'a>(
        &self,
        column: &Column,
        columns: &'a [Column],
        mut act: impl FnMut(&'a Column, Point2),
    ) {
        let ([x0, y0], [x1, y1]) = (self.cell(&column.low), self.cell(&column.high));
        for y in y0..=y1 {
            for x in x0..=x1 {
                let cell = y * self.cells[0] + x;
                let (from, to) = (self.starts[cell] as usize, self.starts[cell + 1] as usize);
                for other in self.columns[from..to].iter().map(|&i| &columns[i as usize]) {
                    let low = [0, 1].map(|k| column.low[k].max(other.low[k]));
                    let size = [0, 1].map(|k| column.high[k].min(other.high[k]) - low[k]);
                    // In the cell where the common box begins, and in no other.
                    if size[0] >= 0.0 && size[1] >= 0.0 && self.cell(&low) == [x, y] {
                        act(other, size);
                    }
                }
            }
        }
    }
}
