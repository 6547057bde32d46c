//! CRASH3's energies and changes of velocity against integrals, crash tests and momentum.

use bumper::effects::crush::{
    Crush, CrushError, Profile, Stiffness, StiffnessError, Struck, crush, crush_by, delta_v, ees,
};
use bumper::effects::response::{Body, Contact, Inertia, Regime, impact};
use proptest::prelude::*;

fn near(found: f64, expected: f64, relative: f64) -> bool {
    (found - expected).abs() <= relative * expected.abs()
}

fn stiffness() -> impl Strategy<Value = Stiffness> {
    (0.0..8e4_f64, 1e5..3e6_f64).prop_map(|(a, b)| Stiffness::new(a, b).unwrap())
}

/// Struck through the centre of gravity.
fn central(mass: f64, stiffness: Stiffness) -> Struck {
    Struck::new(mass, 1.3, 0.0, stiffness).unwrap()
}

proptest! {
    #[test]
    fn the_energy_of_a_profile_is_the_integral_over_its_width(
        side in stiffness(), stations in prop::collection::vec(0.0..1.2_f64, 2..8),
        width in 0.3..2.0_f64, angle in -0.7..0.7_f64,
    ) {
        const SAMPLES: usize = 20_000;
        let depth_at = |part: f64| {
            let at = part * (stations.len() - 1) as f64;
            let (before, rest) = ((at as usize).min(stations.len() - 2), at);
            let rest = rest - before as f64;
            stations[before] * (1.0 - rest) + stations[before + 1] * rest
        };
        // The work of the force on the way to the crush, after G.
        let energy_at = |c: f64| side.g_j_m() + 0.5 * (side.force_at(0.0) + side.force_at(c)) * c;
        let middle = |i: usize| (i as f64 + 0.5) / SAMPLES as f64;
        let sum: f64 = (0..SAMPLES).map(|i| energy_at(depth_at(middle(i)))).sum();
        let integral = sum / SAMPLES as f64 * width / angle.cos().powi(2);
        let profile = Profile::new(stations, width, angle).unwrap();
        let energy = profile.energy_j(&side);
        prop_assert!(near(energy, integral, 1e-5), "{energy} for {integral}");
    }

    #[test]
    fn six_stations_are_weighted_as_crash3_prints_it(
        side in stiffness(), c in prop::array::uniform6(0.0..1.2_f64), width in 0.3..2.0_f64,
    ) {
        let (a, b, g) = (side.a_n_m(), side.b_n_m2(), side.g_j_m());
        let [c1, c2, c3, c4, c5, c6] = c;
        let linear = c1 + 2.0 * (c2 + c3 + c4 + c5) + c6;
        let squares = c1 * c1 + 2.0 * (c2 * c2 + c3 * c3 + c4 * c4 + c5 * c5) + c6 * c6;
        let products = c1 * c2 + c2 * c3 + c3 * c4 + c4 * c5 + c5 * c6;
        let printed = width / 5.0 * (a / 2.0 * linear + b / 6.0 * (squares + products) + 5.0 * g);
        let energy = Profile::new(c.to_vec(), width, 0.0).unwrap().energy_j(&side);
        prop_assert!(near(energy, printed, 1e-13), "{energy} for {printed}");
    }

    #[test]
    fn a_crash_test_into_a_wall_gives_its_speed_back(
        mass in 600.0..3000.0_f64, b0 in 0.0..4.0_f64, b1 in 5.0..50.0_f64,
        width in 1.0..2.0_f64, depth in 0.0..1.0_f64,
    ) {
        let side = Stiffness::from_test(mass, b0, b1, width).unwrap();
        let energy = Profile::uniform(depth, width).unwrap().energy_j(&side);
        prop_assert!(near(ees(energy, mass), b0 + b1 * depth, 1e-12));
    }

    #[test]
    fn the_energy_is_recovered_from_the_depths_it_makes(
        sides in (stiffness(), stiffness()), energy in 0.0..1e6_f64, width in 0.3..2.0_f64,
    ) {
        let struck = [central(1500.0, sides.0), central(900.0, sides.1)];
        let found = crush(energy, width, [&struck[0], &struck[1]]).unwrap();
        let Crush { depth_m, energy_j, .. } = found;
        prop_assert!(near(energy_j[0] + energy_j[1], energy, 1e-15));
        for (side, (depth, energy)) in [sides.0, sides.1].iter().zip(depth_m.iter().zip(energy_j)) {
            if *depth > 0.0 {
                let recovered = Profile::uniform(*depth, width).unwrap().energy_j(side);
                prop_assert!(near(recovered, energy, 1e-9), "{recovered} for {energy}");
            } else {
                prop_assert!(energy <= side.g_j_m() * width * (1.0 + 1e-12));
            }
        }
        let forces = [sides.0.force_at(depth_m[0]), sides.1.force_at(depth_m[1])];
        match depth_m.map(|depth| depth > 0.0) {
            [true, true] => prop_assert!(near(forces[0], forces[1], 1e-12)),
            // What does not yield would have to be pushed harder.
            [true, false] => prop_assert!(forces[0] <= forces[1] * (1.0 + 1e-12)),
            [false, true] => prop_assert!(forces[1] <= forces[0] * (1.0 + 1e-12)),
            [false, false] => {}
        }
    }

    #[test]
    fn more_energy_never_crushes_less(
        sides in (stiffness(), stiffness()), energy in 0.0..1e6_f64, more in 0.0..1e5_f64,
    ) {
        let struck = [central(1500.0, sides.0), central(900.0, sides.1)];
        let of = |energy: f64| crush(energy, 1.4, [&struck[0], &struck[1]]).unwrap();
        let (less, more) = (of(energy), of(energy + more));
        for side in 0..2 {
            prop_assert!(less.depth_m[side] <= more.depth_m[side]);
            prop_assert!(less.energy_j[side] <= more.energy_j[side]);
            prop_assert!(less.ees_m_s[side] <= more.ees_m_s[side]);
            prop_assert!(less.delta_v_m_s[side] <= more.delta_v_m_s[side]);
        }
    }

    #[test]
    fn a_central_plastic_impact_has_the_delta_v_of_momentum(
        masses in prop::array::uniform2(500.0..4e4_f64), closing in 0.1..50.0_f64,
        sides in (stiffness(), stiffness()),
    ) {
        let [m1, m2] = masses;
        let struck = [central(m1, sides.0), central(m2, sides.1)];
        let energy = 0.5 * m1 * m2 / (m1 + m2) * closing * closing;
        let [dv1, dv2] = delta_v(energy, [&struck[0], &struck[1]]);
        prop_assert!(near(dv1, m2 / (m1 + m2) * closing, 1e-13));
        prop_assert!(near(dv2, m1 / (m1 + m2) * closing, 1e-13));
    }

    /// CRASH3 takes the points that touch to reach a common velocity: an impact by Kudlich and Slibar
    /// without restitution in which nothing slides, wherever it is and however the bodies are turned.
    #[test]
    fn an_impact_that_stops_what_touches_has_the_delta_v_of_crash3(
        masses in prop::array::uniform2(500.0..4e4_f64),
        moments in prop::array::uniform2(prop::array::uniform3(1.0..1.9_f64)),
        turn in prop::array::uniform4(-1.0..1.0_f64),
        cgs in prop::array::uniform2(prop::array::uniform3(-1.5..1.5_f64)),
        velocities in prop::array::uniform2(prop::array::uniform3(-15.0..15.0_f64)),
        sides in (stiffness(), stiffness()),
    ) {
        let norm = turn.iter().map(|c| c * c).sum::<f64>().sqrt();
        prop_assume!(norm > 0.1);
        let body = |i: usize| {
            let [x, y, z] = moments[i].map(|k| k * k * masses[i] / 3.0);
            let tensor = [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
            let inertia = Inertia::new(masses[i], tensor).ok()?;
            Body::new(inertia, cgs[i], turn.map(|c| c / norm), velocities[i], [0.3, -0.2, 0.9]).ok()
        };
        let (Some(one), Some(two)) = (body(0), body(1)) else { return Ok(()) };
        let point = [0.1, -0.2, 0.3];
        let contact = Contact::new(point, [1.0, 0.0, 0.0], 0.0, 1e6).unwrap();
        let Ok(found) = impact([&one, &two], &contact) else { return Ok(()) };
        prop_assume!(found.regime == Regime::Full);
        let crush = crush_by(&found, [&one, &two], sides.into(), point, 1.2).unwrap();
        for (change, by_crush) in found.changes.iter().zip(crush.delta_v_m_s) {
            prop_assert!(near(by_crush, change.delta_v.norm(), 1e-9));
        }
        prop_assert!(near(crush.energy_j.iter().sum(), found.energy_loss, 1e-12));
    }
}

#[test]
fn a_side_too_stiff_to_yield_stays_uncrushed() {
    let (soft, wall) = (Stiffness::new(3e4, 5e5).unwrap(), Stiffness::new(1e9, 1e9).unwrap());
    let struck = [central(1200.0, soft), central(1e5, wall)];
    let found = crush(150e3, 1.5, [&struck[0], &struck[1]]).unwrap();
    let alone = crush(found.energy_j[0], 1.5, [&struck[0], &struck[0]]).unwrap();
    assert!(found.depth_m[0] > 0.5 && found.depth_m[1] == 0.0, "{found:?}");
    assert!(alone.depth_m[0] < found.depth_m[0]);
}

#[test]
fn equal_vehicles_share_the_energy_and_the_crush() {
    let struck = central(1200.0, Stiffness::new(4e4, 7e5).unwrap());
    let found = crush(200e3, 1.5, [&struck, &struck]).unwrap();
    assert_eq!(found.energy_j, [100e3; 2]);
    assert_eq!(found.depth_m[0], found.depth_m[1]);
    assert!(near(found.ees_m_s[0], (2.0 * 100e3 / 1200.0_f64).sqrt(), 1e-15));
}

#[test]
fn energy_below_g_leaves_no_crush() {
    let side = Stiffness::new(4e4, 7e5).unwrap();
    let struck = central(1200.0, side);
    let g = 2.0 * 1.5 * side.g_j_m();
    let depth = |energy: f64| crush(energy, 1.5, [&struck, &struck]).unwrap().depth_m;
    assert_eq!(depth(0.0), [0.0; 2]);
    assert_eq!(depth(0.999 * g), [0.0; 2]);
    assert!(depth(1.001 * g)[0] > 0.0);
}

#[test]
fn the_effective_mass_is_that_of_the_plane_for_a_body_struck_in_the_plane() {
    let side = Stiffness::new(4e4, 7e5).unwrap();
    let (mass, gyration, arm) = (1500.0, 1.4, 0.6);
    let yaw = mass * gyration * gyration;
    let tensor = [[0.4 * yaw, 0.0, 0.0], [0.0, 0.9 * yaw, 0.0], [0.0, 0.0, yaw]];
    let inertia = Inertia::new(mass, tensor).unwrap();
    let body = Body::new(inertia, [0.0; 3], [1.0, 0.0, 0.0, 0.0], [0.0; 3], [0.0; 3]).unwrap();
    let impulse = [-7e3, 0.0, 0.0].into();
    let in_space = Struck::body(&body, [2.0, arm, 0.0], &impulse, side);
    let in_plane = Struck::new(mass, gyration, arm, side).unwrap();
    let [found, wanted] = [in_space, in_plane].map(|struck| struck.effective_mass_factor());
    assert!(near(found, wanted, 1e-15) && near(wanted, 1.96 / (1.96 + 0.36), 1e-15));
}

#[test]
fn the_angle_counts_up_to_45_degrees() {
    let factor = |degrees: f64| {
        Profile::new(vec![0.1; 2], 1.0, degrees.to_radians()).unwrap().angle_factor()
    };
    assert_eq!(factor(0.0), 1.0);
    assert!(near(factor(30.0), 4.0 / 3.0, 1e-14) && near(factor(-30.0), 4.0 / 3.0, 1e-14));
    assert!(near(factor(45.0), 2.0, 1e-14) && factor(80.0) == factor(45.0));
}

#[test]
fn what_no_side_can_be_is_refused() {
    let refusal = |a, b| Stiffness::new(a, b).unwrap_err();
    assert_eq!(refusal(-1.0, 1.0), StiffnessError::A(-1.0));
    assert_eq!(refusal(1.0, 0.0), StiffnessError::B(0.0));
    assert_eq!(refusal(f64::INFINITY, 1.0), StiffnessError::A(f64::INFINITY));
    assert!(refusal(0.0, f64::NAN).to_string().contains("b_n_m2 is NaN"));
    assert!(Stiffness::from_test(0.0, 1.0, 10.0, 1.5).is_err());
    assert!(Stiffness::from_test(1000.0, -1.0, 10.0, 1.5).is_err());
    for stations in [vec![], vec![0.1], vec![0.1, -0.1], vec![0.1, f64::NAN]] {
        assert!(Profile::new(stations, 1.0, 0.0).is_err());
    }
    assert!(Profile::new(vec![0.1; 4], 0.0, 0.0).is_err());
    assert!(Profile::new(vec![0.1; 4], 1.0, f64::NAN).is_err());
    let side = Stiffness::new(4e4, 7e5).unwrap();
    for (mass, gyration, arm) in [(0.0, 1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, f64::NAN)] {
        assert!(Struck::new(mass, gyration, arm, side).is_err());
    }
    let struck = central(1200.0, side);
    assert_eq!(crush(-1.0, 1.0, [&struck, &struck]), Err(CrushError::Energy(-1.0)));
    assert_eq!(crush(1.0, 0.0, [&struck, &struck]), Err(CrushError::Width(0.0)));
}

#[test]
fn what_is_read_is_validated_again() {
    let side = Stiffness::new(4e4, 7e5).unwrap();
    let text = serde_json::to_string(&side).unwrap();
    assert_eq!(serde_json::from_str::<Stiffness>(&text).unwrap(), side);
    let error = serde_json::from_str::<Stiffness>(r#"{"a_n_m": 1.0, "b_n_m2": -1.0}"#).unwrap_err();
    assert!(error.to_string().contains("b_n_m2 is -1 N/m²"), "{error}");
    let text = r#"{"stations_m": [0.1], "width_m": 1.0, "angle_rad": 0.0}"#;
    assert!(serde_json::from_str::<Profile>(text).is_err());
}
