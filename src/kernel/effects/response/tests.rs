use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;

use super::*;

const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

fn diagonal([x, y, z]: [f64; 3]) -> [[f64; 3]; 3] {
    [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]
}

/// A solid sphere of radius 1 m.
fn sphere(mass: f64, cg: [f64; 3], velocity: [f64; 3]) -> Body {
    let inertia = Inertia::new(mass, diagonal([0.4 * mass; 3])).unwrap();
    Body::new(inertia, cg, UPRIGHT, velocity, [0.0; 3]).unwrap()
}

#[track_caller]
fn near(found: Vector3<f64>, expected: [f64; 3]) {
    let off = (found - Vector3::from(expected)).norm();
    assert!(off < 1e-12, "{found:?} for {expected:?}");
}

/// dV1 = (V2 - V1) (1 + e) / (1 + m1 / m2).
#[test]
fn a_central_impact_along_a_line_is_that_of_the_textbooks() {
    for (restitution, expected) in [(0.0, 15.0), (0.2, 18.0), (1.0, 30.0)] {
        let [one, two] = [
            sphere(1.0, [1.0, 0.0, 0.0], [-10.0, 0.0, 0.0]),
            sphere(3.0, [-1.0, 0.0, 0.0], [10.0, 0.0, 0.0]),
        ];
        let contact = Contact::new([0.0; 3], [1.0, 0.0, 0.0], restitution, 0.5).unwrap();
        let impact = impact([&one, &two], &contact).unwrap();
        near(impact.changes[0].delta_v, [expected, 0.0, 0.0]);
        near(impact.changes[1].delta_v, [-expected / 3.0, 0.0, 0.0]);
        near(impact.changes[0].delta_spin, [0.0; 3]);
        // (1 - e²) m1 m2 / (m1 + m2) u² / 2
        let loss = (1.0 - restitution * restitution) * 0.75 * 400.0 / 2.0;
        assert!((impact.energy_loss - loss).abs() < 1e-9 && !impact.energy_rises);
        assert_eq!((impact.changes[0].pdof_deg, impact.changes[1].pdof_deg), (180.0, 0.0));
    }
}

#[test]
fn without_friction_spheres_exchange_only_what_is_along_the_normal() {
    let (s, c) = 30_f64.to_radians().sin_cos();
    let one = sphere(2.0, [c, s, 0.0], [-3.0, 0.0, 1.0]);
    let two = sphere(2.0, [-c, -s, 0.0], [0.0; 3]);
    let contact = Contact::new([0.0; 3], [c, s, 0.0], 1.0, 0.0).unwrap();
    let impact = impact([&one, &two], &contact).unwrap();
    // Equal masses and no loss: they swap their velocities along the normal.
    near(impact.changes[0].delta_v, [3.0 * c * c, 3.0 * c * s, 0.0]);
    near(impact.changes[1].delta_v, [-3.0 * c * c, -3.0 * c * s, 0.0]);
    near(impact.changes[1].delta_spin, [0.0; 3]);
    assert!(impact.energy_loss.abs() < 1e-12 && impact.regime == Regime::Sliding);
}

/// A ball of 1 kg against one so heavy that it is the floor: while it slides, friction changes its
/// velocity by mu (1 + e) v and its spin by 5/2 of that over its radius; where friction is enough,
/// what slides has lost (1 + e) 2/7 of its velocity.
#[test]
fn a_ball_with_friction_slides_or_grips() {
    let ball = sphere(1.0, [0.0, 0.0, 1.0], [4.0, 0.0, -2.0]);
    let floor = sphere(1e15, [0.0, 0.0, -1.0], [0.0; 3]);
    let bounce = |friction| {
        let contact = Contact::new([0.0; 3], [0.0, 0.0, 1.0], 0.5, friction).unwrap();
        impact([&ball, &floor], &contact).unwrap()
    };
    let sliding = bounce(0.1);
    near(sliding.changes[0].delta_v, [-0.3, 0.0, 3.0]);
    near(sliding.changes[0].delta_spin, [0.0, 0.75, 0.0]);
    assert_eq!(sliding.regime, Regime::Sliding);
    let full = bounce(1.0);
    let lost = 1.5 * 4.0 * 2.0 / 7.0;
    near(full.changes[0].delta_v, [-lost, 0.0, 3.0]);
    near(full.changes[0].delta_spin, [0.0, 2.5 * lost, 0.0]);
    assert_eq!(full.regime, Regime::Full);
}

#[test]
fn bodies_that_part_have_no_impact() {
    let one = sphere(1.0, [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    let two = sphere(1.0, [-1.0, 0.0, 0.0], [0.0; 3]);
    let contact = Contact::new([0.0; 3], [1.0, 0.0, 0.0], 0.1, 0.5).unwrap();
    assert_eq!(impact([&one, &two], &contact), Err(NoImpact::Apart));
}

#[test]
fn what_no_body_has_is_refused() {
    let ok = diagonal([1.0, 2.0, 2.5]);
    for mass in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Inertia::new(mass, ok), Err(InertiaError::Mass(_))));
    }
    let refused = |tensor| Inertia::new(1.0, tensor).unwrap_err();
    assert_eq!(refused(diagonal([1.0, f64::NAN, 1.0])), InertiaError::NotFinite);
    assert!(matches!(refused(diagonal([1.0, 1.0, 2.1])), InertiaError::Triangle(_)));
    assert!(matches!(refused(diagonal([1.0, 1.0, 0.0])), InertiaError::NotPositive(_)));
    assert!(matches!(refused(diagonal([1.0, 1.0, -1.0])), InertiaError::NotPositive(_)));
    let skew = [[1.0, 0.1, 0.0], [0.2, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(refused(skew), InertiaError::NotSymmetric(0.1, 0.2));
    let inertia = Inertia::new(1.0, ok).unwrap();
    let body = |q, v| Body::new(inertia, [0.0; 3], q, v, [0.0; 3]);
    assert!(matches!(body([1.0, 1.0, 0.0, 0.0], [0.0; 3]), Err(BodyError::Orientation(_))));
    assert!(matches!(body([f64::NAN; 4], [0.0; 3]), Err(BodyError::Orientation(_))));
    assert_eq!(body(UPRIGHT, [f64::NAN; 3]), Err(BodyError::NotFinite("the velocity")));
    let contact = |normal, e, mu| Contact::new([0.0; 3], normal, e, mu);
    let up = [0.0, 0.0, 1.0];
    assert!(matches!(contact([0.0; 3], 0.1, 0.5), Err(ContactError::Normal(_))));
    assert!(matches!(contact(up, 1.1, 0.5), Err(ContactError::Restitution(_))));
    assert!(matches!(contact(up, f64::NAN, 0.5), Err(ContactError::Restitution(_))));
    assert!(matches!(contact(up, 0.1, -0.5), Err(ContactError::Friction(_))));
}

/// What a body is made of, so that it can be made again mirrored or turned.
#[derive(Clone, Copy, Debug)]
struct Parts {
    mass: f64,
    /// Half the extents of a solid box.
    half: [f64; 3],
    cg: Vector3<f64>,
    axis: Vector3<f64>,
    velocity: Vector3<f64>,
    spin: Vector3<f64>,
}

impl Parts {
    fn body(&self, turned: &Rotation3<f64>) -> Body {
        let [x, y, z] = self.half.map(|h| h * h * self.mass / 3.0);
        let inertia = Inertia::new(self.mass, diagonal([y + z, z + x, x + y])).unwrap();
        let q = nalgebra::UnitQuaternion::from_rotation_matrix(
            &(turned * Rotation3::from_scaled_axis(self.axis)),
        );
        let orientation = [q.w, q.i, q.j, q.k];
        let [cg, velocity, spin] =
            [self.cg, self.velocity, self.spin].map(|vector| (turned * vector).into());
        Body::new(inertia, cg, orientation, velocity, spin).unwrap()
    }

    /// By the plane y = 0; a box is its own mirror image, and spins are axial.
    fn mirrored(&self) -> Self {
        let polar = |v: Vector3<f64>| Vector3::new(v.x, -v.y, v.z);
        let axial = |v: Vector3<f64>| Vector3::new(-v.x, v.y, -v.z);
        Self {
            cg: polar(self.cg),
            axis: axial(self.axis),
            velocity: polar(self.velocity),
            spin: axial(self.spin),
            ..*self
        }
    }
}

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

fn parts() -> impl Strategy<Value = Parts> {
    let half = prop::array::uniform3(0.2..3.0);
    (500.0..40_000.0, half, vector(3.0), vector(3.0), vector(30.0), vector(5.0)).prop_map(
        |(mass, half, cg, axis, velocity, spin)| Parts { mass, half, cg, axis, velocity, spin },
    )
}

fn directions() -> impl Strategy<Value = Vector3<f64>> {
    vector(1.0).prop_filter_map("too short", |v| v.try_normalize(0.1))
}

fn struck(
    parts: [Parts; 2],
    normal: Vector3<f64>,
    e: f64,
    mu: f64,
    turn: &Rotation3<f64>,
) -> Result<Impact, NoImpact> {
    let [one, two] = parts.each_ref().map(|parts| parts.body(turn));
    let contact = Contact::new([0.0; 3], (turn * normal).into(), e, mu).unwrap();
    impact([&one, &two], &contact)
}

fn close(a: Vector3<f64>, b: Vector3<f64>) -> bool {
    (a - b).norm() <= 1e-6 * (1.0 + a.norm())
}

proptest! {
    #[test]
    fn momentum_and_energy_are_accounted_for(
        parts in [parts(), parts()], normal in directions(), e in 0.0..=1.0, mu in 0.0..1.0,
    ) {
        let bodies = parts.each_ref().map(|parts| parts.body(&Rotation3::identity()));
        if let Ok(impact) = struck(parts, normal, e, mu, &Rotation3::identity()) {
            let (mut linear, mut angular, mut energy) = (Vector3::zeros(), Vector3::zeros(), 0.0);
            let mut size = 0.0;
            for (body, change) in bodies.iter().zip(&impact.changes) {
                linear += body.mass() * change.delta_v;
                angular += body.cg().cross(&(body.mass() * change.delta_v)) + body.moments() * change.delta_spin;
                let kinetic = |v: Vector3<f64>, w: Vector3<f64>| {
                    0.5 * (body.mass() * v.norm_squared() + w.dot(&(body.moments() * w)))
                };
                let before = kinetic(body.velocity(), body.spin());
                energy += before - kinetic(body.velocity() + change.delta_v, body.spin() + change.delta_spin);
                size += before;
            }
            let impulse = impact.impulse.norm();
            prop_assert!(linear.norm() <= 1e-12 * impulse);
            prop_assert!(angular.norm() <= 1e-10 * impulse);
            prop_assert!((energy - impact.energy_loss).abs() <= 1e-9 * size, "{energy} {impact:?}");
            prop_assert!(impact.impulse.dot(&normal) > 0.0, "nothing pulls");
            prop_assert!(impact.energy_rises == (impact.energy_loss < 0.0) || impact.energy_loss.abs() < 1e-9 * size);
        }
    }

    #[test]
    fn turned_and_mirrored_worlds_have_the_same_impact(
        parts in [parts(), parts()], normal in directions(), axis in vector(3.0), e in 0.0..=1.0, mu in 0.0..1.0,
    ) {
        let turn = Rotation3::from_scaled_axis(axis);
        let there = struck(parts, normal, e, mu, &Rotation3::identity());
        let turned = struck(parts, normal, e, mu, &turn);
        let mirror = |v: Vector3<f64>| Vector3::new(v.x, -v.y, v.z);
        let mirrored = struck(parts.map(|p| p.mirrored()), mirror(normal), e, mu, &Rotation3::identity());
        match (there, turned, mirrored) {
            (Ok(there), Ok(turned), Ok(mirrored)) => {
                prop_assert!(close(turn * there.impulse, turned.impulse));
                prop_assert!(close(mirror(there.impulse), mirrored.impulse));
                for i in 0..2 {
                    prop_assert!(close(turn * there.changes[i].delta_spin, turned.changes[i].delta_spin));
                    let pdof = |angle: f64| angle.to_radians().sin_cos();
                    let (a, b) = (pdof(there.changes[i].pdof_deg), pdof(mirrored.changes[i].pdof_deg));
                    let flat = there.changes[i].delta_v.norm() * 1e-6;
                    prop_assert!((a.0 + b.0).abs() < 1e-5 + flat && (a.1 - b.1).abs() < 1e-5 + flat);
                }
            }
            (there, turned, mirrored) => {
                prop_assert_eq!(there.err(), turned.err());
                prop_assert_eq!(there.err(), mirrored.err());
            }
        }
    }
}

/// Friction and the arm turn the slip of this body back; restitution along the normal alone then gives
/// more than there was.
#[test]
fn an_energy_rise_is_flagged() {
    let (s, c) = 14_f64.to_radians().sin_cos();
    let inertia = Inertia::new(3.0, diagonal([1.0; 3])).unwrap();
    let cg = [2.0 * c, 0.0, 2.0 * s];
    let strikes = Body::new(inertia, cg, UPRIGHT, [0.2, 0.0, -1.0], [0.0; 3]).unwrap();
    let floor = sphere(1e15, [0.0, 0.0, -1.0], [0.0; 3]);
    let struck = |restitution| {
        let contact = Contact::new([0.0; 3], [0.0, 0.0, 1.0], restitution, 0.3).unwrap();
        impact([&strikes, &floor], &contact).unwrap()
    };
    assert!(struck(1.0).energy_rises && struck(1.0).energy_loss < 0.0);
    assert!(!struck(0.0).energy_rises && struck(0.0).energy_loss > 0.0);
}
