use std::rc::Rc;

use super::{placement::Placement, sheet::Sheet};

/// Parts and where they stand; equal parts share one sheet.
#[derive(Clone, Default)]
pub(super) struct Assembly {
    parts: Vec<Part>,
}

#[derive(Clone)]
pub(super) struct Part {
    pub sheet: Rc<Sheet>,
    pub placement: Placement,
}

impl Assembly {
    pub fn put(&mut self, sheet: impl Into<Rc<Sheet>>, placement: Placement) {
        self.parts.push(Part { sheet: sheet.into(), placement });
    }

    pub fn include(&mut self, other: &Assembly, at: Placement) {
        self.parts.extend(other.parts.iter().map(|part| Part {
            sheet: Rc::clone(&part.sheet),
            placement: part.placement.within(&at),
        }));
    }

    /// As it is on the left, and its reflection on the right.
    pub fn include_on_both_sides(&mut self, left: &Assembly) {
        self.include(left, Placement::HERE);
        self.include(left, Placement::MIRROR);
    }

    pub fn parts(&self) -> &[Part] {
        &self.parts
    }
}
