use super::assembly::{Assembly, Part};
use crate::{geometry::Point, mesh::TriangleMesh};

/// How much of a vehicle is modelled; each level has all parts of the one before, some of them
/// in a finer form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Detail {
    /// What a child would draw.
    Outline,
    /// The main parts, in simple forms.
    Parts,
    /// Every part.
    Full,
}

/// The vehicle with at most `budget` triangles, and as close to it as whole rows of cells allow:
/// the most detail whose coarsest form leaves room to spare, at the highest density that fits.
pub(super) fn within_budget(budget: u64, build: impl Fn(Detail) -> Assembly) -> TriangleMesh {
    let assembly = [Detail::Full, Detail::Parts]
        .into_iter()
        .map(&build)
        .find(|assembly| 4 * total(assembly.parts(), 0.0) <= 3 * budget)
        .unwrap_or_else(|| build(Detail::Outline));
    let parts = assembly.parts();
    let densities = fill(parts, budget);
    let (mut vertices, mut faces) = (Vec::<Point>::new(), Vec::new());
    for (part, density) in parts.iter().zip(densities) {
        part.sheet.tessellate(density, &part.placement, &mut vertices, &mut faces);
    }
    TriangleMesh::new(vertices, faces).expect("a built-in vehicle is a valid mesh")
}

fn total(parts: &[Part], density: f64) -> u64 {
    parts.iter().map(|part| part.sheet.triangles(density)).sum()
}

/// A density for each part. One for all parts would jump by thousands of triangles where many
/// equal parts gain a row at once, so the parts that still fit take that step and the others wait.
fn fill(parts: &[Part], budget: u64) -> Vec<f64> {
    /// Halvings: enough to tell any two densities apart at which some part gains a row.
    const STEPS: u32 = 48;
    let mut dense = 1.0;
    while total(parts, dense) <= budget {
        dense *= 2.0;
    }
    let mut sparse = 0.0;
    for _ in 0..STEPS {
        let middle = (sparse + dense) / 2.0;
        let bound = if total(parts, middle) <= budget { &mut sparse } else { &mut dense };
        *bound = middle;
    }
    let mut spare = budget.saturating_sub(total(parts, sparse));
    let step = |part: &Part| {
        let gain = part.sheet.triangles(dense) - part.sheet.triangles(sparse);
        if gain > spare {
            return sparse;
        }
        spare -= gain;
        dense
    };
    parts.iter().map(step).collect()
}
