use std::fmt::Write;

use proptest::prelude::*;

use crate::writers::{Body, every_variant};
use crate::{load, parse, triangles};

#[test]
fn every_format_reads_as_the_same_mesh() {
    for body in [Body::house(), Body::crooked()] {
        let expected = body.mesh();
        for variant in every_variant(&body) {
            let mesh = load(variant.name, &variant.bytes).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(triangles(&mesh), triangles(&expected), "{}", variant.name);
            if variant.indexed {
                assert_eq!(mesh, expected, "{}", variant.name);
            } else {
                assert!(mesh.vertices().len() <= expected.vertices().len(), "{}", variant.name);
            }
        }
    }
}

#[test]
fn content_decides_where_the_extension_says_nothing() {
    for variant in every_variant(&Body::house()) {
        for name in ["mesh", "mesh.dat"] {
            let mesh = load(name, &variant.bytes).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(triangles(&mesh), triangles(&Body::house().mesh()), "{}", variant.name);
        }
    }
}

/// Three corners as each text format writes them.
fn texts(corners: &[[f64; 3]; 3]) -> Vec<(&'static str, String)> {
    let line = |c: &[f64; 3]| format!("{:?} {:e} {}\n", c[0], c[1], c[2]);
    let mut obj = String::new();
    let mut stl = String::from("solid\nfacet\nouter loop\n");
    let mut ply = String::from(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty float y\n\
         property double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n",
    );
    let mut vrml = String::from(
        "#VRML V2.0 utf8\nShape { geometry IndexedFaceSet { coord Coordinate { point [ ",
    );
    for corner in corners {
        write!(obj, "v {}", line(corner)).unwrap();
        write!(stl, "vertex {}", line(corner)).unwrap();
        ply.push_str(&line(corner));
        vrml.push_str(&line(corner));
    }
    obj.push_str("f 1 2 3\n");
    stl.push_str("endloop\nendfacet\nendsolid\n");
    ply.push_str("3 0 1 2\n");
    vrml.push_str("] } coordIndex [ 0 1 2 ] } }");
    vec![("m.obj", obj), ("m.stl", stl), ("m.ply", ply), ("m.wrl", vrml)]
}

fn bits(corners: &[[f64; 3]; 3]) -> [[u64; 3]; 3] {
    corners.map(|corner| corner.map(|c| (c + 0.0).to_bits()))
}

proptest! {
    #[test]
    fn decimal_text_is_kept_to_the_last_bit(
        corners in prop::array::uniform3(prop::array::uniform3(
            prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO))
    ) {
        for (name, text) in texts(&corners) {
            let mesh = parse(name, text.as_bytes()).expect(name);
            prop_assert_eq!(bits(&mesh.triangle(0)), bits(&corners), "{}", name);
        }
    }
}
