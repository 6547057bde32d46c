use crate::writers::{Body, ply_binary, ply_text};
use crate::{assert_refused, load};

fn replaced(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).expect(from);
    [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
}

#[test]
fn a_lying_count_is_refused_at_once() {
    let (binary, text) = (ply_binary(&Body::crooked(), false), ply_text(&Body::crooked(), "\n"));
    let binary = replaced(&binary, "element vertex 7", "element vertex 4294967295");
    assert_refused(
        "m.ply",
        binary,
        "the header promises 4294967295 vertices, the file has bytes for 7",
    );
    let text = replaced(&text, "element face 6", "element face 18446744073709551615");
    let message = "the header promises 18446744073709551615 faces, the file has lines for 6";
    assert_refused("m.ply", text, message);
}

#[test]
fn elements_without_properties_take_no_time() {
    let text = ply_text(&Body::crooked(), "\n");
    let with_empty =
        replaced(&text, "element vertex", "element empty 18446744073709551615\nelement vertex");
    assert_eq!(load("m.ply", with_empty).expect("legal"), Body::crooked().mesh());
}

#[test]
fn a_count_that_is_too_small_is_refused() {
    let text = replaced(&ply_text(&Body::crooked(), "\n"), "face 6", "face 5");
    assert_refused("m.ply", text, "line 29: found '-3 3 0 6 6', expected the end of the file");
    let mut binary = ply_binary(&Body::crooked(), true);
    binary.extend([1, 2, 3]);
    assert_refused("m.ply", binary, "3 bytes follow the last element");
}

#[test]
fn bad_values_are_named_with_their_place() {
    let text = ply_text(&Body::crooked(), "\n");
    let edit = |from, to| replaced(&text, from, to);
    assert_refused(
        "m.ply",
        edit("-3 3 0 6 6", "-3 3 0 6 7"),
        "triangle 5: vertex index 7 is out of range",
    );
    assert_refused(
        "m.ply",
        edit("-3 3 0 6 6", "-3 3 0 6 -1"),
        "line 29: vertex index -1 is out of range",
    );
    assert_refused(
        "m.ply",
        edit("-3 3 0 6 6", "-3 2 0 6"),
        "line 29: a face needs at least 3 vertices",
    );
    assert_refused(
        "m.ply",
        edit("-3 3 0 6 6", "-3 3 0 6 6 6"),
        "line 29: found '6', expected the end of the line",
    );
    assert_refused("m.ply", edit("-3 3 0 6 6", "-3 4 0 6 6"), "line 29: found the end of the line");
    assert_refused("m.ply", edit("-3 3 0 6 6", "-3 3 0 6 x"), "line 29: 'x' is not an index");
    assert_refused(
        "m.ply",
        edit("255", "255 nan"),
        "line 17: coordinate NaN is not a finite number",
    );
    let nan = ply_binary(&Body::crooked(), false);
    let last = nan.len() - 4;
    let nan = [&nan[..last], &f32::NAN.to_le_bytes()].concat();
    assert_refused("m.ply", nan, "vertex 6: coordinate NaN is not a finite number");
}

#[test]
fn broken_headers_are_refused() {
    let text = ply_text(&Body::crooked(), "\n");
    let edit = |from, to| replaced(&text, from, to);
    assert_refused(
        "m.ply",
        edit("double x", "double w"),
        "the vertex element needs one property x",
    );
    assert_refused("m.ply", edit("double x", "quad x"), "line 9: found 'quad'");
    assert_refused("m.ply", edit("vertex_index", "corners"), "needs one list vertex_indices");
    assert_refused(
        "m.ply",
        edit("list uchar int vertex_index", "int vertex_index"),
        "expected a list",
    );
    assert_refused(
        "m.ply",
        edit("format ascii 1.0", "format ascii 2.0"),
        "line 2: found 'format ascii 2.0'",
    );
    assert_refused("m.ply", edit("format ascii 1.0", "comment"), "the header has no format line");
    assert_refused("m.ply", edit("element vertex 7", "element vertex -7"), "found '-7'");
    assert_refused("m.ply", edit("element camera", "element face"), "expected each element once");
    assert_refused(
        "m.ply",
        edit("element face 6", "element tristrips 6"),
        "tristrips is not supported",
    );
}

#[test]
fn lines_may_end_by_carriage_returns_alone() {
    let mesh = load("m.ply", ply_text(&Body::crooked(), "\r")).expect("legal");
    assert_eq!(mesh, Body::crooked().mesh());
}

#[test]
fn a_cloud_of_points_has_no_faces() {
    let cloud = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
                 property float z\nend_header\n1 2 3\n";
    assert_refused("m.ply", cloud, "m.ply: the mesh has no faces");
}
