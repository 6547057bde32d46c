//! What a mesh is like: counts, defects, size. A report refuses nothing.

mod degenerate;
mod text;
mod topology;

use parry3d_f64::mass_properties::details::trimesh_signed_volume_and_center_of_mass;
use parry3d_f64::math::Vector;
use serde::Serialize;

use super::weld::weld;
use super::{Format, MeshError, MeshSource, TriangleMesh};
use crate::geometry::{Point, Triangle};
use topology::Topology;

/// Lengths in metres; an area or volume beyond the f64 range is infinite or NaN, in JSON null.
/// Everything about shared vertices holds after exactly equal ones were made one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshReport {
    pub source: String,
    /// None for a built-in mesh.
    pub format: Option<String>,
    pub vertices: usize,
    pub triangles: usize,
    pub bounding_box: BoundingBox,
    /// Their vertices are collinear or repeated: exactly no area (see `degenerate`).
    pub degenerate_triangles: usize,
    /// Triangles with the same three vertices as an earlier one, in any order.
    pub duplicate_triangles: usize,
    /// Vertices of no triangle.
    pub unused_vertices: usize,
    /// Vertices equal to an earlier one.
    pub duplicate_vertices: usize,
    /// Edges of one triangle only.
    pub boundary_edges: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Watertight: each edge belongs to exactly two triangles.
    pub closed: bool,
    /// No edge is passed in the same direction by two triangles.
    pub consistently_oriented: bool,
    /// Sets of triangles connected by shared vertices.
    pub parts: usize,
    pub surface_area_m2: f64,
    /// Of a closed and consistently oriented mesh.
    pub solid: Option<Solid>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BoundingBox {
    pub min: Point,
    pub max: Point,
}

/// The enclosed space, filled with one density.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Solid {
    pub volume_m3: f64,
    pub centre_of_mass: Point,
    /// The triangles face inward.
    pub inside_out: bool,
}

impl MeshReport {
    pub fn load(source: &MeshSource) -> Result<Self, MeshError> {
        let (mesh, format) = source.load_with_format()?;
        Ok(Self::of(source, format, &mesh))
    }

    /// `mesh` and `format` are what `source` loads; no file is read.
    pub fn of(source: &MeshSource, format: Option<Format>, mesh: &TriangleMesh) -> Self {
        let welded = weld(mesh.vertices());
        let faces: Vec<[u32; 3]> =
            mesh.faces().iter().map(|face| face.map(|i| welded.index[i as usize])).collect();
        let topology = Topology::of(&faces, welded.points.len());
        let triangles = || mesh.triangles();
        let solid = topology.closed() && topology.consistently_oriented;
        Self {
            source: source.to_string(),
            format: format.map(|format| format.to_string()),
            vertices: mesh.vertices().len(),
            triangles: mesh.faces().len(),
            bounding_box: bounding_box(mesh),
            degenerate_triangles: triangles().filter(degenerate::is_degenerate).count(),
            duplicate_triangles: topology::duplicates(&faces),
            unused_vertices: topology::unused(mesh.faces(), mesh.vertices().len()),
            duplicate_vertices: mesh.vertices().len() - welded.points.len(),
            boundary_edges: topology.boundary_edges,
            non_manifold_edges: topology.non_manifold_edges,
            closed: topology.closed(),
            consistently_oriented: topology.consistently_oriented,
            parts: topology.parts,
            surface_area_m2: triangles().map(area).sum(),
            solid: solid.then(|| Solid::of(mesh)),
        }
    }
}

impl Solid {
    fn of(mesh: &TriangleMesh) -> Self {
        let vertices: Vec<Vector> =
            mesh.vertices().iter().map(|v| Vector::from_array(*v)).collect();
        let (volume, centre) = trimesh_signed_volume_and_center_of_mass(&vertices, mesh.faces());
        Self {
            volume_m3: volume.abs(),
            centre_of_mass: centre.to_array(),
            inside_out: volume < 0.0,
        }
    }
}

/// Of the triangles: unused vertices do not count.
fn bounding_box(mesh: &TriangleMesh) -> BoundingBox {
    let mut bounds = BoundingBox { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };
    for corner in mesh.faces().as_flattened() {
        let vertex = mesh.vertices()[*corner as usize];
        for (axis, coordinate) in vertex.into_iter().enumerate() {
            bounds.min[axis] = bounds.min[axis].min(coordinate);
            bounds.max[axis] = bounds.max[axis].max(coordinate);
        }
    }
    bounds
}

fn area([a, b, c]: Triangle) -> f64 {
    let [a, b, c] = [a, b, c].map(Vector::from_array);
    0.5 * (b - a).cross(c - a).length()
}
