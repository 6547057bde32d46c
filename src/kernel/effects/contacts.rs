//! All intersecting triangle pairs of a scenario: the paper's main job.

use crate::geometry::Pose;
use crate::tree::TreeView;
use crate::tree::descent::{Descent, DescentError, Pair};

/// Replaces `pairs` by all intersecting pairs, sorted.
pub fn contacts(
    descent: &mut Descent,
    fixed: &TreeView<'_>,
    moving: &TreeView<'_>,
    pose: &Pose,
    pairs: &mut Vec<Pair>,
) -> Result<(), DescentError> {
    pairs.clear();
    descent.all_pairs(fixed, moving, pose, pairs)?;
    sort(pairs);
    Ok(())
}

/// By triangle of the fixed mesh, then of the moving one.
pub fn sort(pairs: &mut [Pair]) {
    pairs.sort_unstable_by_key(|&[a, b]| u64::from(a) << 32 | u64::from(b));
}

/// 64-bit FNV-1a over sorted pairs, each two little-endian u32.
pub fn pairs_fnv1a64(pairs: &[Pair]) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in pairs.as_flattened().iter().flat_map(|n| n.to_le_bytes()) {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    }
    hash
}
