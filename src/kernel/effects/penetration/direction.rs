use nalgebra::Vector3;

use crate::geometry::Point;

/// A unit vector, in the fixed mesh's axes.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Point", into = "Point")]
pub struct Direction(Vector3<f64>);

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DirectionError {
    #[error("the direction has a component that is no finite number")]
    NotFinite,
    #[error("the direction has length {0}, not 1: divide its components by that")]
    NotUnit(f64),
}

impl Direction {
    /// Of unit length to 1e-6, which is then made as exact as it can be: a direction of another one's
    /// components is that one, bit for bit.
    pub fn new(direction: Point) -> Result<Self, DirectionError> {
        if !direction.iter().all(|c| c.is_finite()) {
            return Err(DirectionError::NotFinite);
        }
        let direction = Vector3::from(direction);
        let length = direction.norm();
        if !(1.0 - 1e-6..=1.0 + 1e-6).contains(&length) {
            return Err(DirectionError::NotUnit(length));
        }
        let is_exact = (length - 1.0).abs() <= 4.0 * f64::EPSILON;
        Ok(Self(if is_exact { direction } else { direction / length }))
    }

    /// `None`: too short to point anywhere.
    pub(super) fn of(vector: Vector3<f64>) -> Option<Self> {
        vector.try_normalize(1e-9).map(Self)
    }

    pub(super) fn vector(&self) -> &Vector3<f64> {
        &self.0
    }

    /// Two unit vectors across it and each other.
    pub(super) fn across(&self) -> [Vector3<f64>; 2] {
        let axis = Vector3::ith(self.0.iamin(), 1.0);
        let first = self.0.cross(&axis).normalize();
        [first, self.0.cross(&first)]
    }
}

impl TryFrom<Point> for Direction {
    type Error = DirectionError;

    fn try_from(direction: Point) -> Result<Self, DirectionError> {
        Self::new(direction)
    }
}

impl From<Direction> for Point {
    fn from(direction: Direction) -> Point {
        direction.0.into()
    }
}
