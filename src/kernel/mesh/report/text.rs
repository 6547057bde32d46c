use std::fmt;

use super::MeshReport;
use crate::geometry::Point;

impl fmt::Display for MeshReport {
    /// One fact a line, without a line end after the last.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = [0, 1, 2].map(|a| self.bounding_box.max[a] - self.bounding_box.min[a]);
        let format = self.format.as_deref().unwrap_or("built in");
        writeln!(f, "{} ({format})", self.source)?;
        writeln!(f, "  triangles            {}", self.triangles)?;
        writeln!(f, "    degenerate         {}", self.degenerate_triangles)?;
        writeln!(f, "    duplicate          {}", self.duplicate_triangles)?;
        writeln!(f, "  vertices             {}", self.vertices)?;
        writeln!(f, "    duplicate          {}", self.duplicate_vertices)?;
        writeln!(f, "    unused             {}", self.unused_vertices)?;
        writeln!(f, "  connected parts      {}", self.parts)?;
        writeln!(f, "  boundary edges       {}", self.boundary_edges)?;
        writeln!(f, "  non-manifold edges   {}", self.non_manifold_edges)?;
        writeln!(f, "  closed               {}", yes_or_no(self.closed))?;
        writeln!(f, "  consistent normals   {}", yes_or_no(self.consistently_oriented))?;
        writeln!(f, "  lowest corner        {} m", triple(self.bounding_box.min))?;
        writeln!(f, "  highest corner       {} m", triple(self.bounding_box.max))?;
        writeln!(f, "  size                 {} m", triple(size))?;
        writeln!(f, "  surface area         {} m²", number(self.surface_area_m2))?;
        let Some(solid) = self.solid else {
            let missing = if self.closed { "its normals differ" } else { "it is not closed" };
            return write!(f, "  volume               none: {missing}");
        };
        let facing = if solid.inside_out { " (triangles face inward)" } else { "" };
        writeln!(f, "  volume               {} m³{facing}", number(solid.volume_m3))?;
        write!(f, "  centre of mass       {} m", triple(solid.centre_of_mass))
    }
}

fn yes_or_no(value: bool) -> &'static str {
    if value { "yes" } else { "no" }
}

/// In columns, as long as the numbers are of a vehicle's size.
fn triple(point: Point) -> String {
    point.map(|c| format!("{:>10}", number(c))).join(" ")
}

/// Micrometres are shown; a number too small or too large for that has an exponent.
fn number(value: f64) -> String {
    if value == 0.0 {
        String::from("0.000000")
    } else if (1e-6..1e9).contains(&value.abs()) {
        format!("{value:.6}")
    } else {
        format!("{value:.6e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_any_size_are_short() {
        let shown = [-0.0, 4.5, -1234.5, 2e-7, 1e300, f64::INFINITY].map(number);
        let expected =
            ["0.000000", "4.500000", "-1234.500000", "2.000000e-7", "1.000000e300", "inf"];
        assert_eq!(shown, expected);
    }
}
