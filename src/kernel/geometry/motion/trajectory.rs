//! Where a mesh is at any time.

use nalgebra::{Matrix3, Vector3};

use super::span::{PartState, Span};
use super::{Horizon, Motion, MotionError, PartMotion};
use crate::geometry::{Point, Pose};

/// A mesh, or a part of one, from a start pose on: `start`, and the part's motion in the mesh, then
/// the body's motion in the world.
#[derive(Clone, Debug)]
pub struct Trajectory {
    start: Matrix3<f64>,
    translation: Vector3<f64>,
    /// From the centre of gravity to the mesh's origin, at the start, world axes.
    from_cg: Vector3<f64>,
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
    spin: Vector3<f64>,
    spin_acceleration: Vector3<f64>,
    part: Option<Part>,
    stretch: f64,
}

/// A body at a time: its turn since the start, mesh axes to world axes, and the centre of gravity.
struct Placed {
    turn: Vector3<f64>,
    body: Matrix3<f64>,
    translation: Vector3<f64>,
    cg: Vector3<f64>,
}

/// A [`PartMotion`], its axis of unit length to rounding.
#[derive(Clone, Debug)]
struct Part {
    pivot: Vector3<f64>,
    axis: Vector3<f64>,
    rate: f64,
    turn_acceleration: f64,
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
}

/// How far what is computed of a trajectory can be from what is meant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounding {
    /// Of any placed point, in metres; what it moves in one rounding of the time is in it.
    pub position_m: f64,
    /// Of the velocity of any point.
    pub speed_m_s: f64,
}

/// No quantity of a motion is larger, in SI units; then no product of those that a bound is made of
/// overflows.
const RANGE: f64 = 1e70;

/// An angle beyond this has few digits left after the point.
const MOST_TURN_RAD: f64 = (1_u64 << 30) as f64;

/// 64 roundings. Rotations of body and part, their product with the start's and the point's have less
/// than 40 between them, relative to a lever that is counted twice; paths and their sums less than ten.
const RELATIVE_ROUNDING: f64 = 1.0 / (1_u64 << 47) as f64;

impl Trajectory {
    pub fn new(start: Pose, motion: &Motion, part: Option<&PartMotion>) -> Self {
        let rotation = Matrix3::from_row_slice(&start.rotation);
        let values = motion.values();
        let deviation = (rotation.tr_mul(&rotation) - Matrix3::identity()).norm();
        Self {
            start: rotation,
            translation: start.translation.into(),
            from_cg: -(rotation * Vector3::from(values.cg_m)),
            velocity: values.velocity_m_s.into(),
            acceleration: values.acceleration_m_s2.into(),
            spin: values.spin_rad_s.into(),
            spin_acceleration: values.spin_acceleration_rad_s2.into(),
            part: part.map(Part::new),
            stretch: (1.0 + deviation).sqrt() * (1.0 + RELATIVE_ROUNDING),
        }
    }

    /// At rest in a pose.
    pub fn at_rest(pose: Pose) -> Self {
        Self::new(pose, &Motion::default(), None)
    }

    /// Where the mesh, or the part, is at a time: mesh axes to world axes. What does not turn has
    /// exactly the start's rotation, and at time 0 its translation.
    pub fn pose(&self, time_s: f64) -> Pose {
        let Placed { body, translation, .. } = self.placed(time_s);
        let Some(part) = &self.part else { return pose_of(&body, &translation) };
        let (rotation, offset) = part.placed(time_s);
        pose_of(&(body * rotation), &(translation + body * offset))
    }

    /// Of the body's centre of gravity, and its angular velocity; world axes.
    pub fn velocities(&self, time_s: f64) -> (Point, Point) {
        let turn = self.placed(time_s).turn;
        let rate = self.spin + self.spin_acceleration * time_s;
        let velocity = self.velocity + self.acceleration * time_s;
        (velocity.into(), angular_velocity(&turn, &rate).into())
    }

    fn placed(&self, t: f64) -> Placed {
        let path = self.velocity * t + self.acceleration * (0.5 * t * t);
        let turn = self.spin * t + self.spin_acceleration * (0.5 * t * t);
        let rotation = rotation(&turn);
        let swing = (rotation - Matrix3::identity()) * self.from_cg;
        let translation = self.translation + path + swing;
        let cg = translation - rotation * self.from_cg;
        Placed { turn, body: rotation * self.start, translation, cg }
    }

    /// What bounds are made of, for times from one to another.
    pub fn span(&self, from_s: f64, to_s: f64) -> Span {
        let Placed { turn, body, translation, cg } = self.placed(from_s);
        let rate = |t: f64| self.spin + self.spin_acceleration * t;
        // The norm of a linear function is largest at an end.
        let fastest_spin = rate(from_s).norm().max(rate(to_s).norm());
        let part = self.part.as_ref().map(|part| part.state(from_s, to_s));
        let pose = match &part {
            Some(part) => pose_of(&(body * part.rotation), &(translation + body * part.offset)),
            None => pose_of(&body, &translation),
        };
        Span {
            pose,
            duration: to_s - from_s,
            cg,
            velocity: self.velocity + self.acceleration * from_s,
            acceleration: self.acceleration,
            spin: angular_velocity(&turn, &rate(from_s)),
            fastest_spin,
            spin_change: self.spin_change(fastest_spin),
            body,
            stretch: self.stretch,
            part,
        }
    }

    /// Bound on the angular acceleration. With the rotation vector `u`, the angular velocity is `J
    /// u'`, where `J`, the integral of exp(s [u]) over s in [0, 1], has norm 1 at most, and its
    /// derivative |u'| / 2.
    fn spin_change(&self, fastest_spin: f64) -> f64 {
        let acceleration = self.spin_acceleration.norm();
        let is_parallel = self.spin.cross(&self.spin_acceleration) == Vector3::zeros();
        if is_parallel { acceleration } else { acceleration + 0.5 * fastest_spin * fastest_spin }
    }

    /// For points of the mesh with |p| of at most `reach_m`, until the horizon; an error if the motion
    /// cannot be followed so far.
    pub fn rounding(&self, reach_m: f64, horizon: Horizon) -> Result<Rounding, MotionError> {
        let t = horizon.seconds();
        let over = |rate: f64, acceleration: f64| [rate + acceleration * t, acceleration];
        let still = [0.0; 2];
        let (turn, slide, pivot) = self.part.as_ref().map_or((still, still, 0.0), |part| {
            let turn = over(part.rate.abs(), part.turn_acceleration.abs());
            (turn, over(part.velocity.norm(), part.acceleration.norm()), part.pivot.norm())
        });
        let spin = over(self.spin.norm(), self.spin_acceleration.norm());
        let path = over(self.velocity.norm(), self.acceleration.norm());
        let angle = (spin[0] + turn[0]) * t;
        let lever = self.stretch * (reach_m + 2.0 * pivot + slide[0] * t) + self.from_cg.norm();
        let speed = path[0] + self.stretch * slide[0] + (spin[0] + turn[0]) * lever;
        let extent = self.translation.norm() + 2.0 * lever + speed * t;
        let parts = [turn, slide, spin, path].concat();
        let in_range = parts.iter().chain(&[lever, speed, extent]).all(|x| *x < RANGE);
        if !(in_range && angle < MOST_TURN_RAD) {
            return Err(MotionError::OutOfRange { duration_s: t });
        }
        let relative = RELATIVE_ROUNDING * (1.0 + angle);
        Ok(Rounding { position_m: relative * extent, speed_m_s: relative * speed })
    }
}

impl Part {
    fn new(motion: &PartMotion) -> Self {
        let values = motion.values();
        let turn = values.turn.as_ref();
        Self {
            pivot: turn.map_or_else(Vector3::zeros, |turn| turn.point_m.into()),
            axis: turn.map_or_else(Vector3::z, |turn| Vector3::from(turn.axis).normalize()),
            rate: turn.map_or(0.0, |turn| turn.rate_rad_s),
            turn_acceleration: turn.map_or(0.0, |turn| turn.acceleration_rad_s2),
            velocity: values.velocity_m_s.into(),
            acceleration: values.acceleration_m_s2.into(),
        }
    }

    /// In the mesh: rotation and offset.
    fn placed(&self, t: f64) -> (Matrix3<f64>, Vector3<f64>) {
        let angle = self.rate * t + self.turn_acceleration * (0.5 * t * t);
        let rotation = rotation(&(self.axis * angle));
        let slide = self.velocity * t + self.acceleration * (0.5 * t * t);
        (rotation, slide - (rotation - Matrix3::identity()) * self.pivot)
    }

    fn state(&self, from: f64, to: f64) -> PartState {
        let (rotation, offset) = self.placed(from);
        let rate = |t: f64| self.rate + self.turn_acceleration * t;
        let velocity = |t: f64| self.velocity + self.acceleration * t;
        PartState {
            rotation,
            offset,
            pivot: self.pivot,
            pivot_now: rotation * self.pivot + offset,
            axis: self.axis,
            rate: rate(from),
            fastest_turn: rate(from).abs().max(rate(to).abs()),
            turn_change: self.turn_acceleration.abs(),
            velocity: velocity(from),
            fastest_slide: velocity(from).norm().max(velocity(to).norm()),
            slide_change: self.acceleration.norm(),
        }
    }
}

fn pose_of(rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> Pose {
    let row = |i: usize| -> Point { [rotation[(i, 0)], rotation[(i, 1)], rotation[(i, 2)]] };
    let rows: [Point; 3] = [row(0), row(1), row(2)];
    let mut flat = [0.0; 9];
    flat.copy_from_slice(rows.as_flattened());
    Pose { rotation: flat, translation: (*translation).into() }
}

/// Rodrigues' formula; exactly the identity for no turn.
fn rotation(turn: &Vector3<f64>) -> Matrix3<f64> {
    let angle = turn.norm();
    if angle == 0.0 {
        return Matrix3::identity();
    }
    let half = (0.5 * angle).sin() / angle;
    let across = turn.cross_matrix();
    Matrix3::identity() + across * (angle.sin() / angle) + across * across * (2.0 * half * half)
}

/// Of what is turned by a rotation vector that changes at a rate: by the left Jacobian of SO(3)
/// (Solà, Deray & Atchuthan, "A micro Lie theory for state estimation in robotics", 2018, appendix B).
fn angular_velocity(turn: &Vector3<f64>, rate: &Vector3<f64>) -> Vector3<f64> {
    let angle = turn.norm();
    if angle == 0.0 {
        return *rate;
    }
    let half = (0.5 * angle).sin() / angle;
    // Below, the series is as good as 64 bits, and the quotient is not.
    let third = if angle < 0.01 {
        1.0 / 6.0 - angle * angle / 120.0
    } else {
        (angle - angle.sin()) / (angle * angle * angle)
    };
    let across = turn.cross(rate);
    rate + across * (2.0 * half * half) + turn.cross(&across) * third
}
