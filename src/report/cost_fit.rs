//! The paper's cost equation, T_total = N_b C_b + N_p C_p (section 3), fitted to what scenarios
//! took.

use crate::wire::CostRecord;

/// The costs that explain the times best.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct CostFit {
    /// C_b: nanoseconds a test of two boxes.
    pub c_b_ns: f64,
    /// C_p: nanoseconds a test of two triangles.
    pub c_p_ns: f64,
    /// Mean over scenarios of |N_b C_b + N_p C_p - T| / T.
    pub mean_relative_error: f64,
}

impl CostFit {
    /// Least squares over non-negative costs, of each scenario's error relative to its time: times
    /// scatter in proportion to themselves, and a scenario that was held up counts for less the
    /// longer it was, at most 1.
    ///
    /// `None` if the scenarios do not tell the two costs apart: there is but one, or N_p is
    /// everywhere the same multiple of N_b.
    pub fn of(costs: &[CostRecord]) -> Option<Self> {
        let rows: Vec<[f64; 2]> = costs.iter().filter_map(per_nanosecond).collect();
        let [c_b_ns, c_p_ns] = non_negative_least_squares(&rows)?;
        let error = |[b, p]: &[f64; 2]| (b * c_b_ns + p * c_p_ns - 1.0).abs();
        let mean_relative_error = rows.iter().map(error).sum::<f64>() / rows.len() as f64;
        Some(Self { c_b_ns, c_p_ns, mean_relative_error })
    }
}

/// N_b / T and N_p / T, which the costs are to take to 1.
fn per_nanosecond(cost: &CostRecord) -> Option<[f64; 2]> {
    let time = cost.descent_ns as f64;
    let counts = [cost.counts.boxes, cost.counts.triangles];
    (time > 0.0).then(|| counts.map(|count| count as f64 / time))
}

/// The non-negative x, y that minimise the sum of (x a + y b - 1)^2 over all rows [a, b], none of
/// which is negative.
fn non_negative_least_squares(rows: &[[f64; 2]]) -> Option<[f64; 2]> {
    let sum = |term: fn(&[f64; 2]) -> f64| rows.iter().map(term).sum::<f64>();
    let (a, b) = (sum(|r| r[0]), sum(|r| r[1]));
    let (aa, ab, bb) = (sum(|r| r[0] * r[0]), sum(|r| r[0] * r[1]), sum(|r| r[1] * r[1]));
    let determinant = aa * bb - ab * ab;
    // The squared sine of the angle between the columns: below this it is rounding.
    if determinant <= 1e-9 * aa * bb {
        return None;
    }
    let (x, y) = ((a * bb - b * ab) / determinant, (b * aa - a * ab) / determinant);
    // Two unknowns: where the free optimum has one of them negative, the best has it 0.
    Some(match (x < 0.0, y < 0.0) {
        (true, _) => [0.0, b / bb],
        (_, true) => [a / aa, 0.0],
        _ => [x, y],
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    use super::*;
    use crate::tree::Counts;

    fn cost(boxes: u64, triangles: u64, descent_ns: f64) -> CostRecord {
        let counts = Counts { boxes, triangles, exact: 0 };
        CostRecord { counts, descent_ns: descent_ns.round() as u64 }
    }

    /// Scenarios of all sizes, whose N_p / N_b varies.
    fn scenarios(c_b: f64, c_p: f64) -> Vec<CostRecord> {
        (1..200_u64)
            .map(|n| {
                let (boxes, triangles) = (500 * n, 37 * (n * n % 101));
                cost(boxes, triangles, boxes as f64 * c_b + triangles as f64 * c_p)
            })
            .collect()
    }

    fn is_near(found: f64, expected: f64, relative: f64) -> bool {
        (found - expected).abs() <= relative * expected.abs()
    }

    #[test]
    fn costs_that_made_the_times_are_found() {
        let fit = CostFit::of(&scenarios(12.5, 80.0)).unwrap();
        assert!(is_near(fit.c_b_ns, 12.5, 1e-3) && is_near(fit.c_p_ns, 80.0, 1e-3), "{fit:?}");
        assert!(fit.mean_relative_error < 1e-3, "{fit:?}");
    }

    #[test]
    fn scenarios_that_were_held_up_hardly_matter() {
        let mut costs = scenarios(12.5, 80.0);
        costs.iter_mut().step_by(20).for_each(|cost| cost.descent_ns *= 50);
        let fit = CostFit::of(&costs).unwrap();
        assert!(is_near(fit.c_b_ns, 12.5, 0.02) && is_near(fit.c_p_ns, 80.0, 0.02), "{fit:?}");
    }

    #[test]
    fn a_cost_below_nothing_is_nothing() {
        let costs: Vec<_> = (1..50_u64)
            .map(|n| {
                let (boxes, triangles) = (1000 + 10 * n, 10 * n);
                cost(boxes, triangles, boxes as f64 * 20.0 - triangles as f64 * 9.0)
            })
            .collect();
        let fit = CostFit::of(&costs).unwrap();
        assert_eq!(fit.c_p_ns, 0.0);
        assert!(fit.c_b_ns > 10.0 && fit.c_b_ns < 20.0, "{fit:?}");
    }

    #[test]
    fn scenarios_that_are_all_alike_tell_nothing() {
        assert_eq!(CostFit::of(&[]), None);
        assert_eq!(CostFit::of(&[cost(100, 10, 5000.0)]), None);
        let alike: Vec<_> = (1..50).map(|n| cost(100 * n, 10 * n, 5000.0)).collect();
        assert_eq!(CostFit::of(&alike), None);
        let apart: Vec<_> = (1..50).map(|n| cost(100 * n, 0, 5000.0)).collect();
        assert_eq!(CostFit::of(&apart), None);
        assert_eq!(CostFit::of(&[cost(100, 10, 0.0), cost(100, 20, 0.0)]), None);
    }

    fn squares(rows: &[[f64; 2]], [x, y]: [f64; 2]) -> f64 {
        rows.iter().map(|[a, b]| (x * a + y * b - 1.0).powi(2)).sum()
    }

    proptest! {
        /// Against a singular value decomposition, which knows nothing of normal equations; and,
        /// where that has a negative cost, against the two axes one by one.
        #[test]
        fn the_fit_is_the_least_of_squares(
            samples in prop::collection::vec((1_u64..10_000, 0_u64..10_000, 1_u64..1_000_000), 3..40),
        ) {
            let costs: Vec<_> = samples.iter().map(|&(b, p, t)| cost(b, p, t as f64)).collect();
            let rows: Vec<[f64; 2]> = costs.iter().filter_map(per_nanosecond).collect();
            let matrix = DMatrix::from_row_iterator(rows.len(), 2, rows.iter().flatten().copied());
            let svd = matrix.svd(true, true);
            let ratio = svd.singular_values.min() / svd.singular_values.max();
            prop_assume!(ratio > 1e-3);
            let free = svd.solve(&DVector::from_element(rows.len(), 1.0), 0.0).unwrap();

            let fit = CostFit::of(&costs).unwrap();
            let found = squares(&rows, [fit.c_b_ns, fit.c_p_ns]);
            prop_assert!(fit.c_b_ns >= 0.0 && fit.c_p_ns >= 0.0);
            if free[0] >= 0.0 && free[1] >= 0.0 {
                prop_assert!(found <= squares(&rows, [free[0], free[1]]) * (1.0 + 1e-9));
                prop_assert!((fit.c_b_ns - free[0]).abs() <= 1e-6 * (free[0] + free[1]));
            } else {
                prop_assert!(fit.c_b_ns == 0.0 || fit.c_p_ns == 0.0);
            }
            let largest = fit.c_b_ns.max(fit.c_p_ns);
            for step in 0..=200 {
                let other = largest * f64::from(step) / 100.0;
                prop_assert!(found <= squares(&rows, [other, 0.0]) * (1.0 + 1e-9));
                prop_assert!(found <= squares(&rows, [0.0, other]) * (1.0 + 1e-9));
            }
        }
    }
}
