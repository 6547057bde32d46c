//! Which published mesh a tree is, and how it is cut.

use bytemuck::{Pod, Zeroable};

use super::{WireError, flag, records, split_header, zero};
use crate::tree::roots::Cut;

/// Body of the message that adds a tree which workers see where it was published.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InPlaceTree {
    pub mesh: u32,
    pub cut: Cut,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct InPlaceRecord {
    mesh: u32,
    /// 0: by depth; 1: by triangles.
    cut_by: u32,
    limit: u32,
    reserved: u32,
}

impl InPlaceTree {
    pub fn to_bytes(self) -> [u8; size_of::<InPlaceRecord>()] {
        let (cut_by, limit) = match self.cut {
            Cut::Depth(depth) => (0, depth),
            Cut::Triangles(most) => (1, most),
        };
        bytemuck::cast(InPlaceRecord { mesh: self.mesh, cut_by, limit, reserved: 0 })
    }

    pub fn parse(bytes: &[u8]) -> Result<Self, WireError> {
        let (record, rest) = split_header::<InPlaceRecord>(bytes)?;
        records::<u8>(rest, 0)?;
        zero("reserved word", record.reserved)?;
        let cut = match flag("cut_by", record.cut_by)? {
            false => Cut::Depth(record.limit),
            true => Cut::Triangles(record.limit),
        };
        Ok(Self { mesh: record.mesh, cut })
    }
}

/// Body of the message that says where a plan was published, or a job.
pub fn published_at(number: u32) -> [u8; 4] {
    number.to_ne_bytes()
}

pub fn place_of(body: &[u8]) -> Result<u32, WireError> {
    let described = WireError::Length { found: body.len(), described: size_of::<u32>() };
    Ok(u32::from_ne_bytes(body.try_into().map_err(|_| described)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_in_place_is_read_as_it_was_written_and_else_refused() {
        for cut in [Cut::Depth(12), Cut::Triangles(2000)] {
            let place = InPlaceTree { mesh: 3, cut };
            let mut bytes = place.to_bytes();
            assert_eq!(InPlaceTree::parse(&bytes), Ok(place));
            assert!(InPlaceTree::parse(&bytes[..12]).is_err());
            bytes[4] = 2;
            assert!(matches!(InPlaceTree::parse(&bytes), Err(WireError::Field { .. })));
        }
    }
}
