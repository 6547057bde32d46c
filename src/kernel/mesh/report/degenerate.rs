use crate::geometry::Triangle;
use crate::geometry::predicates::orient2d;

/// True iff the vertices are collinear: their projections along all three axes are.
pub fn is_degenerate([a, b, c]: &Triangle) -> bool {
    let collinear_on = |i: usize, j: usize| {
        let [a, b, c] = [a, b, c].map(|p| [p[i], p[j]]);
        orient2d(&a, &b, &c).is_eq()
    };
    collinear_on(0, 1) && collinear_on(1, 2) && collinear_on(2, 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn collinear_and_repeated_vertices_have_no_area() {
        assert!(is_degenerate(&[[0.5; 3], [1.5; 3], [4.0; 3]]));
        assert!(is_degenerate(&[[0.1, 0.2, 0.3], [0.1, 0.2, 0.3], [7.0, 8.0, 9.0]]));
    }

    #[test]
    fn a_sliver_of_one_ulp_has_area() {
        let above = f64::from_bits(1.5_f64.to_bits() + 1);
        assert!(!is_degenerate(&[[0.5; 3], [1.5, 1.5, above], [4.0; 3]]));
        assert!(!is_degenerate(&[[0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1e-100]]));
        assert!(!is_degenerate(&[[0.0; 3], [0.0, 1e-300, 0.0], [0.0, 0.0, 5e-324]]));
    }
}
