//! The pose contract: how a moving vertex is placed, bit for bit.

use bytemuck::{Pod, Zeroable};

use super::Point;

/// Places the moving mesh: `p' = R p + t`, metres, moving frame to fixed frame.
///
/// `rotation` is row major and used as it is; it need not be a perfect rotation.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Pose {
    pub rotation: [f64; 9],
    pub translation: [f64; 3],
}

const _: () = assert!(size_of::<Pose>() == 96);

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PoseError {
    #[error("{0} is not a finite number")]
    NotFinite(&'static str),
    #[error("the quaternion has length {0}, not 1: divide its four numbers by that")]
    NotUnit(f64),
}

impl Pose {
    pub const IDENTITY: Self =
        Self { rotation: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], translation: [0.0; 3] };

    /// From a quaternion (w, x, y, z), used as given and not re-normalised.
    pub fn from_quaternion([w, x, y, z]: [f64; 4], translation: Point) -> Self {
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let (xx, xy, xz) = (x * x2, x * y2, x * z2);
        let (yy, yz, zz) = (y * y2, y * z2, z * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        let rotation = [
            1.0 - (yy + zz),
            xy - wz,
            xz + wy,
            xy + wz,
            1.0 - (xx + zz),
            yz - wx,
            xz - wy,
            yz + wx,
            1.0 - (xx + yy),
        ];
        Self { rotation, translation }
    }

    /// As [`Pose::from_quaternion`], for numbers from outside: finite, and of unit length to
    /// within what six printed decimals lose.
    pub fn checked(quaternion: [f64; 4], translation: Point) -> Result<Self, PoseError> {
        const NAMES: [&str; 7] = ["qw", "qx", "qy", "qz", "tx", "ty", "tz"];
        let numbers = quaternion.iter().chain(&translation);
        if let Some((_, name)) = numbers.zip(NAMES).find(|(n, _)| !n.is_finite()) {
            return Err(PoseError::NotFinite(name));
        }
        let squared: f64 = quaternion.iter().map(|c| c * c).sum();
        if (squared - 1.0).abs() > 1e-5 {
            return Err(PoseError::NotUnit(squared.sqrt()));
        }
        Ok(Self::from_quaternion(quaternion, translation))
    }

    /// Each product and sum is one binary64 operation in this order: no FMA, no reassociation.
    #[inline]
    pub fn apply(&self, [x, y, z]: Point) -> Point {
        let (r, t) = (&self.rotation, &self.translation);
        [
            ((r[0] * x + r[1] * y) + r[2] * z) + t[0],
            ((r[3] * x + r[4] * y) + r[5] * z) + t[1],
            ((r[6] * x + r[7] * y) + r[8] * z) + t[2],
        ]
    }

    /// Per axis, a bound on |p'| for all points with |p| at most `reach`.
    ///
    /// Computed as [`Pose::apply`] computes, of which each rounding is monotone: if the bound is
    /// finite, then no coordinate of those points overflows on its way, nor are they beyond it.
    pub fn reach(&self, reach: Point) -> Point {
        let absolute = Self {
            rotation: self.rotation.map(f64::abs),
            translation: self.translation.map(f64::abs),
        };
        absolute.apply(reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURN: [f64; 4] = [0.5, -0.5, 0.5, 0.5];

    #[test]
    fn unit_quaternion_is_used_as_given() {
        let pose = Pose::checked(TURN, [1.0, 2.0, 3.0]).unwrap();
        assert_eq!(pose, Pose::from_quaternion(TURN, [1.0, 2.0, 3.0]));
        assert_eq!(pose.apply([0.0; 3]), [1.0, 2.0, 3.0]);
        assert_eq!(Pose::checked([1.0, 0.0, 0.0, 0.0], [0.0; 3]).unwrap(), Pose::IDENTITY);
    }

    #[test]
    fn quaternion_printed_with_six_decimals_is_accepted() {
        let printed = [-0.407399, 0.282190, 0.273168, -0.824484];
        let pose = Pose::checked(printed, [0.0; 3]).unwrap();
        assert_eq!(pose, Pose::from_quaternion(printed, [0.0; 3]));
    }

    #[test]
    fn quaternion_of_another_length_is_refused_with_its_length() {
        let refused = |q| Pose::checked(q, [0.0; 3]).unwrap_err();
        assert_eq!(refused([0.0; 4]), PoseError::NotUnit(0.0));
        assert_eq!(refused([0.0, 3.0, 4.0, 0.0]), PoseError::NotUnit(5.0));
        assert_eq!(refused([1e200, 0.0, 0.0, 0.0]), PoseError::NotUnit(f64::INFINITY));
        assert!(matches!(refused([0.9999, 0.0, 0.0, 0.0]), PoseError::NotUnit(_)));
    }

    #[test]
    fn number_that_is_not_finite_is_refused_by_name() {
        let names = ["qw", "qx", "qy", "qz", "tx", "ty", "tz"];
        for (position, name) in names.into_iter().enumerate() {
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let mut numbers = [0.5; 7];
                numbers[position] = bad;
                let [w, x, y, z, translation @ ..] = numbers;
                let refused = Pose::checked([w, x, y, z], translation).unwrap_err();
                assert_eq!(refused, PoseError::NotFinite(name));
            }
        }
    }

    #[test]
    fn reach_bounds_every_corner_of_the_box() {
        let pose = Pose::from_quaternion([0.36, -0.48, 0.64, 0.48], [-7.0, 0.1, 1e-3]);
        let bound = pose.reach([1.1, 2.3, 0.7]);
        for corner in 0..8 {
            let sign = |k: u32| if corner >> k & 1 == 1 { -1.0 } else { 1.0 };
            let placed = pose.apply([1.1 * sign(0), 2.3 * sign(1), 0.7 * sign(2)]);
            assert!((0..3).all(|k| placed[k].abs() <= bound[k]), "{placed:?} beyond {bound:?}");
        }
        let far = pose.reach([f64::MAX, f64::MAX, 0.0]);
        assert!(far.iter().any(|c| c.is_infinite()));
    }
}
