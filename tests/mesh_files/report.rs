use bumper::mesh::report::MeshReport;
use bumper::mesh::{Format, MeshSource, TriangleMesh};

use crate::writers::Body;

fn report(mesh: &TriangleMesh) -> MeshReport {
    MeshReport::of(&MeshSource::File("made/here.ply".into()), Some(Format::Ply), mesh)
}

type Part = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// An axis-aligned box as eight vertices and twelve triangles that face outward.
fn cuboid(min: [f64; 3], max: [f64; 3]) -> Part {
    let corner =
        |i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { min[axis] } else { max[axis] });
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    ((0..8).map(corner).collect(), faces.collect())
}

fn joined(parts: &[Part]) -> TriangleMesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (points, triangles) in parts {
        let first = vertices.len() as u32;
        vertices.extend(points);
        faces.extend(triangles.iter().map(|face| face.map(|i| i + first)));
    }
    TriangleMesh::new(vertices, faces).expect("valid")
}

fn assert_close(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{found} {expected}");
}

#[test]
fn a_box_has_the_closed_form_of_its_volume_centre_and_area() {
    let mesh = joined(&[cuboid([10.0, -2.0, 0.5], [14.5, -1.0, 2.0])]);
    let report = report(&mesh);
    let solid = report.solid.expect("closed");
    assert_close(solid.volume_m3, 4.5 * 1.0 * 1.5);
    for (found, expected) in solid.centre_of_mass.into_iter().zip([12.25, -1.5, 1.25]) {
        assert_close(found, expected);
    }
    assert!(!solid.inside_out);
    assert_close(report.surface_area_m2, 2.0 * (4.5 * 1.0 + 1.0 * 1.5 + 1.5 * 4.5));
    assert_eq!(report.bounding_box.min, [10.0, -2.0, 0.5]);
    assert_eq!(report.bounding_box.max, [14.5, -1.0, 2.0]);
    assert!(report.closed && report.consistently_oriented);
    assert_eq!((report.parts, report.boundary_edges, report.non_manifold_edges), (1, 0, 0));
}

#[test]
fn a_house_has_the_closed_form_of_a_prism() {
    let report = report(&Body::house().mesh());
    let solid = report.solid.expect("closed");
    assert_close(solid.volume_m3, 9.0);
    assert_close(solid.centre_of_mass[2], 7.0 / 9.0);
    assert_close(report.surface_area_m2, 18.0 + 6.0 * 2.0_f64.sqrt());
}

#[test]
fn a_box_turned_inside_out_says_so() {
    let (vertices, faces) = cuboid([0.0; 3], [1.0; 3]);
    let turned = faces.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let solid = report(&joined(&[(vertices, turned)])).solid.expect("closed");
    assert!(solid.inside_out);
    assert_close(solid.volume_m3, 1.0);
}

#[test]
fn a_lid_taken_off_leaves_a_boundary() {
    let (vertices, mut faces) = cuboid([0.0; 3], [1.0; 3]);
    faces.truncate(10);
    let report = report(&joined(&[(vertices, faces)]));
    assert_eq!((report.boundary_edges, report.closed, report.solid), (4, false, None));
    assert!(report.consistently_oriented);
}

#[test]
fn one_turned_triangle_is_inconsistent() {
    let (vertices, mut faces) = cuboid([0.0; 3], [1.0; 3]);
    faces[0].swap(1, 2);
    let report = report(&joined(&[(vertices, faces)]));
    assert!(report.closed && !report.consistently_oriented && report.solid.is_none());
}

#[test]
fn parts_are_counted_after_equal_vertices_are_joined() {
    let apart = [cuboid([0.0; 3], [1.0; 3]), cuboid([2.0; 3], [3.0; 3])];
    assert_eq!(report(&joined(&apart)).parts, 2);
    let corner_to_corner = [cuboid([0.0; 3], [1.0; 3]), cuboid([1.0; 3], [3.0; 3])];
    let report = report(&joined(&corner_to_corner));
    assert_eq!((report.parts, report.duplicate_vertices), (1, 1));
}

#[test]
fn defects_are_counted_and_refuse_nothing() {
    let (mut vertices, mut faces) = cuboid([0.0; 3], [1.0; 3]);
    vertices.extend([[5.0; 3], [0.0, 0.0, -0.0], [2.0, 0.0, 0.0]]);
    // The same corners again, once by another vertex; a segment; a point; a third wall at an edge.
    faces.extend([[2, 3, 0], [9, 2, 3], [0, 1, 10], [4, 4, 4], [0, 1, 7]]);
    let report = report(&joined(&[(vertices, faces)]));
    assert_eq!(report.duplicate_triangles, 2);
    assert_eq!(report.degenerate_triangles, 2);
    assert_eq!(report.unused_vertices, 1);
    assert_eq!(report.duplicate_vertices, 1);
    assert!(report.non_manifold_edges > 0 && !report.closed);
    // The unused vertex at 5 is not part of the body.
    assert_eq!(report.bounding_box.max, [2.0, 1.0, 1.0]);
}

#[test]
fn a_report_is_text_and_json() {
    let report = report(&Body::house().mesh());
    let text = report.to_string();
    assert!(text.starts_with("made/here.ply (PLY)\n"), "{text}");
    assert!(
        text.contains("triangles            16\n")
            && text.contains("volume               9.000000 m³"),
        "{text}"
    );
    let json = serde_json::to_value(&report).expect("plain data");
    assert_eq!(json["triangles"], 16);
    assert_eq!(json["solid"]["inside_out"], false);
}

#[test]
fn coordinates_at_the_ends_of_the_range_are_reported_on() {
    for size in [f64::MAX, f64::MIN_POSITIVE, 5e-324] {
        let report = report(&joined(&[cuboid([-size; 3], [size; 3])]));
        assert!(report.closed && report.consistently_oriented);
        assert_eq!(report.bounding_box.max, [size; 3]);
        serde_json::to_string(&report).expect("plain data");
    }
}
