use super::graph::{Content, Graph};
use crate::mesh::FormatError;
use crate::mesh::affine::Affine;
use crate::mesh::instances::Instances;
use crate::mesh::raw::RawMesh;

/// Walks the graph depth first and writes out every use of every face set.
pub fn place(graph: &Graph, file_bytes: usize) -> Result<RawMesh, FormatError> {
    let mut instances = Instances::new(file_bytes);
    let sizes = graph.roots.iter().map(|root| graph.node(*root).size);
    instances.allow(sizes.fold(0, u64::saturating_add))?;
    let mut skipped = 0;
    let mut pending: Vec<_> =
        graph.roots.iter().rev().map(|root| (*root, Affine::IDENTITY)).collect();
    while let Some((id, outer)) = pending.pop() {
        let node = graph.node(id);
        match &node.content {
            Content::Group(children) => {
                pending.extend(children.iter().rev().map(|child| (*child, outer)));
            }
            Content::Transform(inner, children) => {
                let affine = outer.after(inner);
                pending.extend(children.iter().rev().map(|child| (*child, affine)));
            }
            Content::Faces { coordinate, faces } => {
                let Content::Coordinate(points) = &graph.node(*coordinate).content else {
                    unreachable!("the parser links face sets to coordinates only")
                };
                let first = instances
                    .place(&outer, points.iter().copied())
                    .map_err(|problem| problem.at_line(node.line))?;
                instances.connect(&outer, first, faces);
            }
            Content::NoSurface => skipped += 1,
            Content::Coordinate(_) | Content::Nothing => {}
        }
    }
    if skipped > 0 {
        tracing::warn!("skipped {skipped} shapes of lines, points and text");
    }
    Ok(instances.finish())
}
