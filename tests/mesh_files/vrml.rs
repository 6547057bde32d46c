use std::fmt::Write;
use std::io::Write as _;

use crate::writers::{Body, gzip, vrml, vrml_shape};
use crate::{area, assert_refused, load};

const TRIANGLE: &str = "Shape { geometry IndexedFaceSet {
 coord Coordinate { point [ 0 0 0, 1 0 0, 0 1 0 ] } coordIndex [ 0 1 2 ] } }";

fn scene(nodes: &str) -> String {
    format!("#VRML V2.0 utf8\n{nodes}\n")
}

#[track_caller]
fn assert_corners(nodes: &str, expected: [[f64; 3]; 3]) {
    let mesh = load("m.wrl", scene(nodes)).unwrap_or_else(|error| panic!("{error}"));
    for (corner, expected) in mesh.triangle(0).as_flattened().iter().zip(expected.as_flattened()) {
        assert!((corner - expected).abs() < 1e-15, "{:?}", mesh.triangle(0));
    }
}

#[test]
fn transforms_are_applied_from_the_inside_out() {
    // (1,0,0) and (0,1,0) scaled by (2,3,1), turned by 90 degrees about z, moved by (1,2,3),
    // then by the parent doubled.
    let nodes = format!(
        "Transform {{ scale 2 2 2 children Transform {{ translation 1 2 3
         rotation 0 0 5 1.5707963267948966 scale 2 3 1 children [ {TRIANGLE} ] }} }}"
    );
    assert_corners(&nodes, [[2.0, 4.0, 6.0], [2.0, 8.0, 6.0], [-4.0, 4.0, 6.0]]);
}

#[test]
fn a_concave_face_is_covered_and_nothing_else() {
    let nodes = "Transform { scale 2 -2 2 children Shape { geometry IndexedFaceSet { convex FALSE
      coord Coordinate { point [ 0 0 0, 4 0 0, 4 1 0, 1 1 0, 1 3 0, 0 3 0 ] }
      coordIndex [ 1 2 3 4 5 0 -1 ] } } }";
    let mesh = load("m.wrl", scene(nodes)).expect("legal");
    assert_eq!((mesh.faces().len(), area(&mesh)), (4, 24.0));
}

#[test]
fn scale_and_rotation_are_about_the_center() {
    let nodes = format!("Transform {{ center 1 1 0 scale 3 3 3 children {TRIANGLE} }}");
    assert_corners(&nodes, [[-2.0, -2.0, 0.0], [1.0, -2.0, 0.0], [-2.0, 1.0, 0.0]]);
    let nodes = format!(
        "Transform {{ center 1 0 0 rotation 0 0 1 3.141592653589793 children {TRIANGLE} }}"
    );
    assert_corners(&nodes, [[2.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, -1.0, 0.0]]);
}

#[test]
fn scale_is_along_the_turned_axes() {
    // The axes are turned by 90 degrees about z: the factor of x acts along y.
    let nodes = format!(
        "Transform {{ scaleOrientation 0 0 1 1.5707963267948966 scale 5 1 1 children {TRIANGLE} }}"
    );
    assert_corners(&nodes, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 5.0, 0.0]]);
}

#[test]
fn used_nodes_are_placed_again() {
    let nodes = format!(
        "DEF A Transform {{ translation 0 0 1 children DEF B {TRIANGLE} }}
         USE A Transform {{ translation 0 0 5 children [ USE B, USE A ] }}"
    );
    let mesh = load("m.wrl", scene(&nodes)).expect("legal");
    let heights: Vec<f64> = (0..4).map(|face| mesh.triangle(face)[0][2]).collect();
    assert_eq!(heights, [1.0, 1.0, 5.0, 6.0]);
}

#[test]
fn one_choice_and_one_level_are_shown() {
    let high = TRIANGLE.replace("0 0 0,", "0 0 9,");
    let chosen = format!("Switch {{ whichChoice 1 choice [ {TRIANGLE} {high} ] }}");
    assert_eq!(load("m.wrl", scene(&chosen)).expect("legal").triangle(0)[0], [0.0, 0.0, 9.0]);
    let levels = format!("LOD {{ range [ 10 ] level [ {high} {TRIANGLE} ] }}");
    assert_eq!(load("m.wrl", scene(&levels)).expect("legal").faces().len(), 1);
    let nothing = format!("Switch {{ choice [ {TRIANGLE} ] }}");
    assert_refused("m.wrl", scene(&nothing), "the mesh has no faces");
}

#[test]
fn what_has_no_surface_is_stepped_over() {
    let nodes = format!(
        "PROTO Unused [ field SFNode n NULL eventIn SFBool b ] {{ Group {{ children [ ] }} }}
         EXTERNPROTO Far [ field SFBool b ] \"far.wrl\"
         EXTERNPROTO Farther [ ] [ \"a.wrl\" \"b.wrl\" ]
         Viewpoint {{ position 0 0 10 description \"# front }}\" }}
         DEF Clock TimeSensor {{ loop TRUE }}
         DEF Logic Script {{ url \"javascript:\" field SFFloat f 1 eventIn SFTime set eventOut SFBool b
           field SFNode node USE Clock directOutput TRUE }}
         ROUTE Clock.time TO Logic.set
         Collision {{ collide FALSE proxy {TRIANGLE} children [ Anchor {{ url \"x\" children {TRIANGLE} }} ] }}
         Shape {{ geometry IndexedLineSet {{ coord Coordinate {{ point [ 0 0 0 1 1 1 ] }} coordIndex [ 0 1 ] }} }}"
    );
    assert_eq!(load("m.wrl", scene(&nodes)).unwrap_or_else(|e| panic!("{e}")).faces().len(), 1);
}

#[test]
fn what_would_silently_be_missing_is_refused() {
    let refused = |nodes: &str, message: &str| assert_refused("m.wrl", scene(nodes), message);
    refused(
        &format!("PROTO Wheel [ ] {{ {TRIANGLE} }}\n\nWheel {{ }}"),
        "line 5: an instance of the prototype Wheel (declared in line 2) is not supported",
    );
    refused(
        "EXTERNPROTO Wheel [ ] \"w.wrl\" Group { children [ DEF W Wheel { } ] }",
        "line 2: an instance of the prototype Wheel",
    );
    refused("\nInline { url \"part.wrl\" }", "line 3: the node Inline is not supported");
    refused(
        "Shape { geometry Sphere { } }",
        "line 2: the node Sphere is not supported: convert it",
    );
    refused("Grupo { }", "line 2: found 'Grupo', expected a node type of VRML97");
    refused("USE nobody", "line 2: found 'nobody', expected the name of an earlier node");
    refused(
        "DEF A Group { children USE A }",
        "line 2: found 'A', expected the name of an earlier node",
    );
}

#[test]
fn bad_face_sets_are_named_with_their_line() {
    let refused = |from: &str, to: &str, message: &str| {
        assert!(TRIANGLE.contains(from), "{from}");
        assert_refused("m.wrl", scene(&TRIANGLE.replacen(from, to, 1)), message);
    };
    refused("0 1 2 ]", "0 1 3 ]", "line 2: vertex index 3 is out of range (there are 3 vertices)");
    refused("0 1 2 ]", "0 1 -2 ]", "line 2: vertex index -2 is out of range");
    refused("0 1 2 ]", "0 1 1.5 ]", "'1.5' is not an index");
    refused("0 1 2 ]", "0 1 2 -1 0 1 ]", "line 2: face 1: a face needs at least 3 vertices");
    refused("0 1 2 ]", "-1 ]", "face 0: a face needs at least 3 vertices");
    refused("0 1 2 ]", "]", "the mesh has no faces");
    refused("0 1 0 ]", "0 1 0 7 ]", "line 3: found 10 numbers in point");
    refused("0 1 0 ]", "0 1 nan ]", "line 3: found 'nan'");
    refused("0 1 0 ]", "0 1 1e999 ]", "line 3: coordinate inf is not a finite number");
    refused("coord Coordinate", "coord Normal", "expected a Coordinate");
    refused("coord Coordinate", "other Coordinate", "line 2: found 0 nodes as coord");
    refused("coordIndex [ 0 1 2 ]", "coordIndex", "expected the rest of a field's value");
    refused("coordIndex [", "[", "line 3: found a second value");
    refused("coord Coordinate", "coord NULL Coordinate", "line 3: found a second value");
}

#[test]
fn transforms_that_overflow_are_refused() {
    let nodes = format!(
        "Transform {{ scale 1e200 1 1 children Transform {{ scale 1e200 1 1 children {TRIANGLE} }} }}"
    );
    assert_refused(
        "m.wrl",
        scene(&nodes),
        "line 2: its transforms take a vertex beyond all finite numbers",
    );
    assert_refused(
        "m.wrl",
        scene("Transform { translation 1 2 }"),
        "translation has 2 numbers, must have 3",
    );
}

#[test]
fn any_depth_of_nesting_is_read() {
    const DEPTH: usize = 300_000;
    for begin in ["Group { children [ ", "Transform { translation 0 0 1 children [ "] {
        let nested = scene(&[begin.repeat(DEPTH), TRIANGLE.into(), "] }".repeat(DEPTH)].concat());
        let height = if begin.starts_with('G') { 0.0 } else { DEPTH as f64 };
        assert_eq!(load("m.wrl", &nested).expect("legal").triangle(0)[0], [0.0, 0.0, height]);
        assert_refused("m.wrl", scene(&begin.repeat(DEPTH)), "the file ends within the ");
    }
    assert_refused("m.wrl", scene(&"[".repeat(DEPTH)), "found '['");
    assert_refused(
        "m.wrl",
        scene(&format!("PROTO P {}", "[".repeat(DEPTH))),
        "ends within a prototype",
    );
}

#[test]
fn few_bytes_cannot_expand_without_limit() {
    for leaf in [TRIANGLE, "WorldInfo { }"] {
        let mut nodes = format!("DEF N0 Group {{ children {leaf} }}\n");
        for level in 1..=70 {
            let below = level - 1;
            writeln!(nodes, "DEF N{level} Group {{ children [ USE N{below} USE N{below} ] }}")
                .unwrap();
        }
        assert_refused("m.wrl", scene(&nodes), "the scene expands to");
    }
}

#[test]
fn broken_and_exploding_gzip_is_refused() {
    let packed = gzip(&vrml(&Body::house(), "\n"));
    assert_refused("m.wrl", &packed[..packed.len() - 1], "gzip: ");
    let mut damaged = packed.clone();
    let crc = damaged.len() - 8;
    damaged[crc] ^= 1;
    assert_refused("m.wrz", damaged, "gzip: ");
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(b"#VRML V2.0 utf8\n").unwrap();
    let blank = vec![b' '; 1 << 20];
    (0..100).for_each(|_| encoder.write_all(&blank).unwrap());
    assert_refused("m.wrl", encoder.finish().unwrap(), "the gzip data grows beyond");
}

#[test]
fn other_versions_are_refused() {
    let old = scene(TRIANGLE).replace("V2.0 utf8", "V1.0 ascii");
    assert_refused(
        "m.wrl",
        old,
        "line 1: found '#VRML V1.0 ascii', expected the line #VRML V2.0 utf8",
    );
}

#[test]
fn names_and_strings_may_be_in_any_encoding() {
    let mut bytes =
        b"#VRML V2.0 utf8\nDEF K\xe4fer WorldInfo { title \"\xff\" }\nUSE K\xe4fer\n".to_vec();
    bytes.extend(vrml_shape(&Body::house()).bytes());
    assert_eq!(load("m.wrl", bytes).expect("legal"), Body::house().mesh());
}
