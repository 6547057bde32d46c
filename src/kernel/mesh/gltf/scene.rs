use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::accessor;
use super::buffers::Bytes;
use super::document::{Document, Node};
use super::primitive::Parts;
use crate::geometry::Pose;
use crate::mesh::affine::Affine;
use crate::mesh::instances::Instances;
use crate::mesh::raw::RawMesh;
use crate::mesh::{FormatError, Problem};

pub fn read(
    document: &Document,
    buffers: &[Bytes],
    file_bytes: usize,
) -> Result<RawMesh, FormatError> {
    let placed = placed_nodes(document)?;
    let mut instances = Instances::new(file_bytes);
    let mut meshes = HashMap::new();
    let mut size = 0;
    for index in placed.iter().filter_map(|(node, _)| document.nodes[*node].mesh) {
        if let Entry::Vacant(entry) = meshes.entry(index) {
            entry.insert(Parts::read(document, buffers, index, |more| {
                size += more;
                instances.allow(size)
            })?);
        }
    }
    let parts = |node: usize| document.nodes[node].mesh.map(|mesh| &meshes[&mesh]);
    instances.allow(placed.iter().filter_map(|(node, _)| parts(*node)).map(Parts::size).sum())?;
    let mut skipped = 0;
    for (node, affine) in &placed {
        let Some(parts) = parts(*node) else { continue };
        skipped += parts.skipped;
        place(document, buffers, parts, affine, &mut instances)
            .map_err(|problem| problem.at_element("nodes", *node))?;
    }
    if skipped > 0 {
        tracing::warn!("skipped {skipped} primitives of points and lines");
    }
    Ok(instances.finish())
}

/// Primitives that share their positions share the vertices made from them.
fn place(
    document: &Document,
    buffers: &[Bytes],
    parts: &Parts,
    affine: &Affine,
    instances: &mut Instances,
) -> Result<(), Problem> {
    let mut first_vertex = HashMap::new();
    for part in &parts.parts {
        let first = match first_vertex.get(&part.positions) {
            Some(&first) => first,
            None => {
                let view = accessor::positions(document, buffers, part.positions)
                    .map_err(|error| error.problem)?;
                let first = instances.place(affine, view.points())?;
                first_vertex.insert(part.positions, first);
                first
            }
        };
        instances.connect(affine, first, &part.faces);
    }
    Ok(())
}

/// Every node of the default scene (or the first, or without scenes all) in depth-first order,
/// with its transform into the scene.
fn placed_nodes(document: &Document) -> Result<Vec<(usize, Affine)>, FormatError> {
    let mut pending: Vec<(usize, Affine)> =
        roots(document)?.into_iter().rev().map(|root| (root, Affine::IDENTITY)).collect();
    let mut reached = vec![false; document.nodes.len()];
    let mut placed = Vec::new();
    while let Some((index, outer)) = pending.pop() {
        let node = document.nodes.get(index).ok_or_else(|| accessor::missing("node", index))?;
        let at_node = |problem: Problem| problem.at_element("nodes", index);
        if std::mem::replace(&mut reached[index], true) {
            let problem = "is reached twice: nodes must form a tree";
            return Err(at_node(Problem::Malformed(problem.into())));
        }
        let affine = outer.after(&local(node).map_err(at_node)?);
        pending.extend(node.children.iter().rev().map(|child| (*child, affine)));
        placed.push((index, affine));
    }
    let left_out = (0..document.nodes.len())
        .filter(|&node| !reached[node] && document.nodes[node].mesh.is_some());
    match left_out.count() {
        0 => {}
        count => tracing::warn!("left out {count} nodes with meshes that the scene does not show"),
    }
    Ok(placed)
}

fn roots(document: &Document) -> Result<Vec<usize>, FormatError> {
    if document.scenes.is_empty() && document.scene.is_none() {
        let mut is_child = vec![false; document.nodes.len()];
        for &child in document.nodes.iter().flat_map(|node| &node.children) {
            *is_child.get_mut(child).ok_or_else(|| accessor::missing("node", child))? = true;
        }
        return Ok((0..document.nodes.len()).filter(|&node| !is_child[node]).collect());
    }
    let index = document.scene.unwrap_or(0);
    let scene = document.scenes.get(index).ok_or_else(|| accessor::missing("scene", index))?;
    Ok(scene.nodes.clone())
}

fn local(node: &Node) -> Result<Affine, Problem> {
    if node.mesh.is_some() && (node.skin.is_some() || node.extensions.instancing.is_some()) {
        let what = "a mesh placed by a skin or by EXT_mesh_gpu_instancing".into();
        return Err(Problem::Unsupported { what, remedy: "export the file without them" });
    }
    if let Some(m) = node.matrix {
        if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
            let what = "a matrix whose last row is not 0 0 0 1".into();
            return Err(Problem::Unsupported { what, remedy: "use an affine matrix" });
        }
        return Ok(Affine([0, 1, 2].map(|row| [m[row], m[row + 4], m[row + 8], m[row + 12]])));
    }
    let translation = Affine::translation(node.translation.unwrap_or_default());
    let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let rotation = Affine::linear(Pose::from_quaternion([w, x, y, z], [0.0; 3]).rotation);
    let scale = Affine::scale(node.scale.unwrap_or([1.0; 3]));
    Ok(translation.after(&rotation).after(&scale))
}
