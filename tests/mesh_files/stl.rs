use crate::writers::{Body, stl_binary, stl_text};
use crate::{assert_refused, load};

#[test]
fn equal_corners_become_one_vertex() {
    let text = "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
                facet\nouter loop\nvertex -0.0 0 0\nvertex 0 1 0\nvertex 1e-300 0 0\nendloop\nendfacet\nendsolid\n";
    let mesh = load("m.stl", text).expect("legal");
    assert_eq!(mesh.faces(), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn several_solids_are_one_mesh() {
    let twice = [stl_text(&Body::house(), "\n"), stl_text(&Body::crooked(), "\n")].concat();
    let faces = Body::house().faces().len() + Body::crooked().faces().len();
    assert_eq!(load("m.stl", twice).expect("legal").faces().len(), faces);
}

#[test]
fn a_lying_count_is_refused_at_once() {
    let mut bytes = stl_binary(&Body::crooked(), b"");
    bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_refused(
        "m.stl",
        &bytes,
        "the header promises 4294967295 triangles, the file has bytes for 6",
    );
    bytes[80..84].copy_from_slice(&0_u32.to_le_bytes());
    assert_refused("m.stl", &bytes, "the header promises 0 triangles, the file has bytes for 6");
    let longer = [stl_binary(&Body::crooked(), b""), vec![7]].concat();
    assert_refused("m.stl", longer, "1 bytes follow the last element");
}

#[test]
fn bad_content_is_named_with_its_place() {
    let mut bytes = stl_binary(&Body::crooked(), b"");
    bytes[84 + 50 + 12..84 + 50 + 16].copy_from_slice(&f32::INFINITY.to_le_bytes());
    assert_refused("m.stl", bytes, "byte 134: coordinate inf is not a finite number");
    let text = String::from_utf8(stl_text(&Body::crooked(), "\n")).unwrap();
    let edited = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    };
    assert_refused("m.stl", edited("vertex -1 0 -0", "vertex -1 0 nan"), "line 4: coordinate NaN");
    assert_refused("m.stl", edited("vertex -1 0 -0", "vertex -1 0"), "line 4: found 2 numbers");
    assert_refused("m.stl", edited("vertex -1 0 -0", "vertex -1 0 0 0"), "line 4: found '0'");
    assert_refused(
        "m.stl",
        edited("  endloop", "  vertex 0 0 0"),
        "line 7: found 'vertex', expected endloop",
    );
    assert_refused("m.stl", edited("endsolid two words", ""), "the file ends within a solid");
    assert_refused("m.stl", "solid empty\nendsolid empty\n", "the mesh has no faces");
    assert_refused("m.stl", "short", "the file ends within the 84 bytes of a binary STL header");
}
