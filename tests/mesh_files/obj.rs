use crate::{area, assert_refused, load};

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn faces_may_come_before_their_vertices() {
    let mesh = load("m.obj", format!("f 1 2 3\n{CORNERS}")).expect("legal");
    assert_eq!(mesh.faces(), [[0, 1, 2]]);
}

#[test]
fn a_concave_face_is_covered_and_nothing_else() {
    let l = "v 0 0 0\nv 4 0 0\nv 4 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\n";
    for face in ["f 1 2 3 4 5 6", "f 2 3 4 5 6 1", "f 6 5 4 3 2 1"] {
        for text in [format!("{l}{face}\n"), format!("{face}\n{l}")] {
            let mesh = load("m.obj", text).expect("legal");
            assert_eq!((mesh.faces().len(), area(&mesh)), (4, 6.0), "{face}");
        }
    }
    let quad = load("m.obj", format!("{CORNERS}v 1 1 0\nf 1 2 4 3\n")).expect("legal");
    assert_eq!(quad.faces(), [[0, 1, 3], [0, 3, 2]]);
}

#[test]
fn relative_indices_count_from_the_vertices_so_far() {
    let mesh = load("m.obj", format!("{CORNERS}f -3 -2 -1\nv 0 0 1\nf -2 -1 -4\n")).expect("legal");
    assert_eq!(mesh.faces(), [[0, 1, 2], [2, 3, 0]]);
}

#[test]
fn vertices_may_carry_a_weight_or_a_colour() {
    let mesh =
        load("m.obj", "v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 1 1 1 1\nf 1 2 3").expect("legal");
    assert_eq!(mesh.vertices(), [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
}

#[test]
fn names_and_comments_may_be_in_any_encoding() {
    let text =
        [b"# \xff\xfe\no K\xe4fer\n".as_slice(), CORNERS.as_bytes(), b"f 1 2 3 # \x80\n"].concat();
    assert_eq!(load("m.obj", text).expect("legal").faces().len(), 1);
}

#[test]
fn bad_statements_are_named_with_their_line() {
    let refused = |line: &str, message: &str| {
        assert_refused("m.obj", format!("{CORNERS}{line}\nf 1 2 3\n"), message);
    };
    refused("f 1 2 4", "m.obj: line 4: vertex index 4 is out of range (there are 3 vertices)");
    refused("f 0 1 2", "line 4: vertex index 0 is out of range");
    refused("f -4 1 2", "line 4: vertex index -4 is out of range");
    refused(
        "f -9223372036854775808 1 2",
        "line 4: vertex index -9223372036854775808 is out of range",
    );
    refused("f 99999999999999999999 1 2", "line 4: '99999999999999999999' is not an index");
    refused("f 1 2", "line 4: a face needs at least 3 vertices, this one has 2");
    refused("f 1/x 2 3", "line 4: 'x' is not an index");
    refused("v 1 2", "line 4: found 2 numbers, expected the coordinates x y z");
    refused("v 1 2 inf", "line 4: coordinate inf is not a finite number");
    refused("v 1 2 1e999", "line 4: coordinate inf is not a finite number");
    refused("v 1 2 three", "line 4: 'three' is not a number");
    refused("v 1 2 \u{663}", "is not a number");
    refused("surf 0 1 0 1 1 2", "line 4: a free-form surface is not supported");
    refused("vertex 1 2 3", "line 4: found 'vertex', expected an OBJ statement");
    assert_refused("m.obj", format!("{CORNERS}f 1 2 3 \\"), "ends within a continued line");
    assert_refused("m.obj", CORNERS, "the mesh has no faces");
}
