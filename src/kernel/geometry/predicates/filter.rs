use crate::geometry::Point;

/// Error bound of the [`orient3d`](super::orient3d) determinant in plain f64, made once for many
/// points: Meyer & Pion, "FPG: A code generator for fast and certified geometric predicates"
/// (2008).
///
/// # Why it holds
/// Let u = 2^-53 and let M bound the nine *rounded* differences of an axis. Each difference has
/// an error of at most u M (gradual underflow makes small ones exact). A product of two: its
/// rounding and its factors' errors, 3 u MM. Their difference, at most 2 MM: 6 u MM from the
/// products, 2 u MM from its own rounding, together 8 u MM. Times the third difference: 8 + 2
/// from the factors' errors and 2 of rounding, 12 u MMM. Three such, at most 2 MMM each, added
/// one after the other: 36, and 4 and 6 of rounding. That makes 46 u MMM to first order. The
/// constant is 46.03 u. The rest covers terms in u^2, the roundings in the bound itself, and,
/// with M at least 1e-97, products that underflow: at most 2^-1072 (1 + M), where the rest is
/// more than 1e-18 MMM. With M at most 1e102 nothing overflows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticFilter {
    epsilon: f64,
}

impl StaticFilter {
    /// Decides nothing: every sign is left to the exact stages.
    pub const OFF: Self = Self { epsilon: f64::INFINITY };

    /// `extent`: per axis, at least |x_i - x_j| as f64 rounds it, over all vertices i, j that meet
    /// in one test (of both triangles, the moving one placed).
    ///
    /// Rounding is monotone, so `max - min` over a set of vertices, computed in f64, will do for
    /// any of them. A wider extent only leaves more to the exact stages; one that is beyond 1e102,
    /// infinite or NaN turns the filter off.
    pub fn for_extent(extent: Point) -> Self {
        const SMALLEST: f64 = 1e-97;
        const LARGEST: f64 = 1e102;
        if !extent.iter().all(|&m| m <= LARGEST) {
            return Self::OFF;
        }
        let [x, y, z] = extent.map(|m| m.max(SMALLEST));
        Self { epsilon: 5.11071278299733e-15 * x * y * z }
    }

    /// Whatever rounding did, the exact determinant is greater than zero.
    #[inline]
    pub(super) fn is_positive(&self, determinant: f64) -> bool {
        determinant > self.epsilon
    }

    #[inline]
    pub(super) fn is_negative(&self, determinant: f64) -> bool {
        determinant < -self.epsilon
    }
}
