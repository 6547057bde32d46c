//! The built-in vehicles: the same bits everywhere, any budget, sound geometry.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use bumper::mesh::{
    MeshError, TriangleMesh,
    builtin::{Builtin, Model},
};
use proptest::prelude::*;

fn mesh(text: &str) -> TriangleMesh {
    text.parse::<Builtin>().unwrap().mesh()
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn extent(mesh: &TriangleMesh) -> [[f64; 2]; 3] {
    [0, 1, 2].map(|axis| {
        let along = || mesh.vertices().iter().map(|p| p[axis]);
        [along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max)]
    })
}

/// The faces of each connected component.
fn components(mesh: &TriangleMesh) -> Vec<Vec<[u32; 3]>> {
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    let mut parent: Vec<u32> = (0..mesh.vertices().len() as u32).collect();
    for &[a, b, c] in mesh.faces() {
        for other in [b, c] {
            let (from, to) = (root(&mut parent, other), root(&mut parent, a));
            parent[from as usize] = to;
        }
    }
    let mut parts: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
    for &face in mesh.faces() {
        parts.entry(root(&mut parent, face[0])).or_default().push(face);
    }
    parts.into_values().collect()
}

#[test]
fn the_meshes_are_the_same_bits_on_every_machine() {
    let hashes = ["car", "tracked", "car?triangles=20000"].map(|text| mesh(text).content_hash());
    assert_eq!(hashes, [0x19b8_9228_4c72_b6bd, 0x4301_76cf_7da3_74e4, 0xf774_be2e_dac8_072f]);
}

#[test]
fn defaults_have_the_size_and_the_parts_of_real_models() {
    let cases =
        [("car", 90_000, 300, [4.5, 1.97, 1.45]), ("tracked", 300_000, 1_500, [5.19, 2.86, 2.52])];
    for (text, budget, parts, size) in cases {
        let mesh = mesh(text);
        assert!((budget * 99 / 100..=budget).contains(&mesh.faces().len()), "{text}");
        assert!(components(&mesh).len() >= parts, "{text}");
        for ([low, high], wanted) in extent(&mesh).into_iter().zip(size) {
            assert!((high - low - wanted).abs() < 0.05, "{text}: {low} to {high}");
        }
        let [x, y, z] = extent(&mesh);
        assert!(x[0] < -2.2 && x[1] > 2.2 && (y[0] + y[1]).abs() < 1e-12, "{text}");
        assert!(z[0].abs() < 0.02, "{text} stands on the ground, not at {}", z[0]);
    }
}

#[test]
fn no_triangle_of_a_default_is_degenerate() {
    for text in ["car", "tracked"] {
        let mesh = mesh(text);
        for face in 0..mesh.faces().len() as u32 {
            let [a, b, c] = mesh.triangle(face);
            let normal = cross(minus(b, a), minus(c, a));
            assert!(dot(normal, normal).sqrt() > 1e-10, "{text}: triangle {face}");
        }
    }
}

#[test]
fn closed_parts_look_outward_and_no_edge_is_shared_twice_the_same_way() {
    for text in ["car", "tracked", "car?triangles=1000", "tracked?triangles=1000"] {
        let mesh = mesh(text);
        let mut closed = 0;
        for part in components(&mesh) {
            let mut edges = BTreeSet::new();
            for [a, b, c] in &part {
                for edge in [(a, b), (b, c), (c, a)] {
                    assert!(edges.insert(edge), "{text}: edge {edge:?} twice");
                }
            }
            if edges.iter().all(|&(a, b)| edges.contains(&(b, a))) {
                closed += 1;
                let volume = |&[a, b, c]: &[u32; 3]| {
                    let [a, b, c] = [a, b, c].map(|i| mesh.vertices()[i as usize]);
                    dot(a, cross(b, c)) / 6.0
                };
                let volume = part.iter().map(volume).sum::<f64>();
                let at = mesh.vertices()[part[0][0] as usize];
                assert!(volume > 0.0, "{text}: the part at {at:?} is inside out");
            }
        }
        assert!(closed >= 6, "{text}");
    }
}

#[test]
fn left_and_right_carry_alike() {
    for text in ["car", "tracked"] {
        let mesh = mesh(text);
        let mut sides = HashMap::new();
        for face in 0..mesh.faces().len() as u32 {
            let y: f64 = mesh.triangle(face).iter().map(|p| p[1]).sum();
            *sides.entry(y > 0.0).or_insert(0_usize) += 1;
        }
        let (left, right) = (sides[&true] as f64, sides[&false] as f64);
        assert!((left / right - 1.0).abs() < 0.1, "{text}: {left} and {right}");
    }
}

#[test]
fn any_budget_is_met_from_above_and_keeps_the_vehicle_s_size() {
    for model in [Model::Car, Model::Tracked] {
        let whole = extent(&Builtin::from(model).mesh());
        for budget in [1_000, 2_500, 7_000, 20_000, 50_000, 150_000, 400_000, 1_000_000] {
            let mesh = Builtin::new(model, budget).unwrap().mesh();
            let count = mesh.faces().len() as f64 / f64::from(budget);
            assert!((0.95..=1.0).contains(&count), "{model:?} {budget}: {count}");
            for (ours, whole) in extent(&mesh).into_iter().zip(whole) {
                for end in 0..2 {
                    assert!((ours[end] - whole[end]).abs() < 0.45, "{model:?} {budget}");
                }
            }
        }
    }
}

#[test]
fn names_and_budgets_survive_display_and_parse() {
    for text in ["car", "tracked", "car?triangles=20000", "tracked?triangles=1000"] {
        assert_eq!(text.parse::<Builtin>().unwrap().to_string(), text);
    }
    assert_eq!("car?triangles=90000".parse::<Builtin>().unwrap().to_string(), "car");
}

#[test]
fn a_bad_name_option_or_budget_says_what_there_is() {
    let error = |text: &str| text.parse::<Builtin>().unwrap_err();
    assert!(matches!(error("lorry"), MeshError::UnknownBuiltin(name) if name == "lorry"));
    assert!(matches!(error(""), MeshError::UnknownBuiltin(_)));
    assert!(matches!(error("car?"), MeshError::UnknownBuiltinOption(_)));
    assert!(matches!(error("car?colour=red"), MeshError::UnknownBuiltinOption(_)));
    for count in ["", "many", "-5", "1.5", "99999999999", "1000&x=1"] {
        let error = error(&format!("car?triangles={count}"));
        assert!(matches!(&error, MeshError::BuiltinNotACount(text) if text == count), "{error}");
    }
    assert_eq!(
        error("car?triangles=999").to_string(),
        "triangles=999 is out of range: this built-in mesh has 1000 to 20000000 triangles"
    );
    assert!(matches!(error("tracked?triangles=20000001"), MeshError::BuiltinBudget { .. }));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_budget_is_never_exceeded_and_nearly_used(car: bool, budget in 1_000_u32..60_000) {
        let model = if car { Model::Car } else { Model::Tracked };
        let count = Builtin::new(model, budget).unwrap().mesh().faces().len() as f64;
        prop_assert!(count <= f64::from(budget) && count > 0.9 * f64::from(budget), "{count}");
    }
}
