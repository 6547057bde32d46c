/// A smooth curve y(x) through given points, without overshoot: cubic Hermite with the slopes of
/// Fritsch & Carlson, "Monotone piecewise cubic interpolation" (1980), in the harmonic-mean form.
/// Beyond its ends it stays level.
pub(super) struct Curve(
    /// (x, y), x ascending, at least two.
    pub &'static [[f64; 2]],
);

impl Curve {
    pub fn at(&self, x: f64) -> f64 {
        let points = self.0;
        let last = points.len() - 1;
        let x = x.clamp(points[0][0], points[last][0]);
        let i = points.partition_point(|p| p[0] <= x).clamp(1, last) - 1;
        let ([x0, y0], [x1, y1]) = (points[i], points[i + 1]);
        let (width, t) = (x1 - x0, (x - x0) / (x1 - x0));
        let (m0, m1) = (self.slope(i) * width, self.slope(i + 1) * width);
        let rise = y1 - y0;
        y0 + t * (m0 + t * (3.0 * rise - 2.0 * m0 - m1 + t * (m0 + m1 - 2.0 * rise)))
    }

    fn slope(&self, i: usize) -> f64 {
        let secant = |i: usize| {
            let ([x0, y0], [x1, y1]) = (self.0[i], self.0[i + 1]);
            (y1 - y0) / (x1 - x0)
        };
        if i == 0 {
            return secant(0);
        }
        if i + 1 == self.0.len() {
            return secant(i - 1);
        }
        let (before, after) = (secant(i - 1), secant(i));
        let product = before * after;
        if product > 0.0 { 2.0 * product / (before + after) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_meets_its_points_and_stays_between_them() {
        let points: &[[f64; 2]] = &[[0.0, 1.0], [1.0, 2.0], [1.5, 2.0], [4.0, -3.0]];
        let curve = Curve(points);
        for p in points {
            assert!((curve.at(p[0]) - p[1]).abs() < 1e-12);
        }
        for step in 0..=400 {
            let y = curve.at(f64::from(step) / 100.0);
            assert!((-3.0 - 1e-12..=2.0 + 1e-12).contains(&y), "{y}");
        }
    }
}
