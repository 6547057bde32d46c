//! Work that waits: nodes to be opened against a box of the other tree, and pairs of leaves.

use crate::geometry::simd::Lanes;

/// Two numbers an entry, first in first out, in room that is made once.
#[derive(Debug, Default)]
pub struct Queue {
    first: Vec<u32>,
    second: Vec<u32>,
    from: usize,
    to: usize,
}

/// More than a query of two vehicles has waiting at any time.
pub const ROOM: usize = 1 << 14;

/// A vector is stored whole, whatever of it counts.
const OVERHANG: usize = 16;

impl Queue {
    /// Makes the room if there is none yet.
    #[inline(always)]
    pub fn clear(&mut self) {
        if self.first.is_empty() {
            self.first.resize(ROOM + OVERHANG, 0);
            self.second.resize(ROOM + OVERHANG, 0);
        }
        (self.from, self.to) = (0, 0);
    }

    #[inline(always)]
    pub fn waiting(&self) -> usize {
        self.to - self.from
    }

    /// Whether `more` entries can be added. If so, and only then, they may be.
    #[inline(always)]
    pub fn has_room(&self, more: usize) -> bool {
        self.to + more <= ROOM
    }

    /// As [`Queue::has_room`], after moving what waits to the front if need be.
    #[inline(always)]
    pub fn make_room(&mut self, more: usize) -> bool {
        self.has_room(more) || {
            self.compact();
            self.has_room(more)
        }
    }

    /// Takes the front, or what came last; only while something waits.
    #[inline(always)]
    pub fn take(&mut self, last: bool) -> [u32; 2] {
        debug_assert!(self.waiting() > 0);
        let at = if last { self.to - 1 } else { self.from };
        if last {
            self.to -= 1;
        } else {
            self.from += 1;
        }
        // SAFETY: `from` was below `to`, which is never beyond the room.
        unsafe { [*self.first.get_unchecked(at), *self.second.get_unchecked(at)] }
    }

    /// The first number of the entry that many places behind the front; any number if there is
    /// none.
    #[inline(always)]
    pub fn glance(&self, ahead: usize) -> u32 {
        debug_assert!(ahead < OVERHANG && self.first.len() == ROOM + OVERHANG);
        // SAFETY: `from` is at most `ROOM`, and what is made is longer than that by `OVERHANG`.
        unsafe { *self.first.get_unchecked(self.from + ahead) }
    }

    /// Drops the front.
    #[inline(always)]
    pub fn skip(&mut self, count: usize) {
        debug_assert!(count <= self.waiting());
        self.from += count;
    }

    #[inline(always)]
    pub fn firsts(&self) -> &[u32] {
        // SAFETY: neither end is beyond the room, and they are in this order.
        unsafe { self.first.get_unchecked(self.from..self.to) }
    }

    #[inline(always)]
    pub fn seconds(&self) -> &[u32] {
        // SAFETY: as above.
        unsafe { self.second.get_unchecked(self.from..self.to) }
    }

    #[inline(always)]
    pub fn entries(&self) -> impl Iterator<Item = [u32; 2]> {
        self.firsts().iter().zip(self.seconds()).map(|(&first, &second)| [first, second])
    }

    /// Goes back to the beginning of the room where that costs nothing, or where less than `more`
    /// of it is left.
    #[inline(always)]
    pub fn rewind(&mut self, more: usize) {
        if self.from == self.to {
            (self.from, self.to) = (0, 0);
        } else if !self.has_room(more) {
            self.compact();
        }
    }

    /// Moves what waits to the beginning of the room.
    #[cold]
    #[inline(never)]
    fn compact(&mut self) {
        self.first.copy_within(self.from..self.to, 0);
        self.second.copy_within(self.from..self.to, 0);
        (self.from, self.to) = (0, self.to - self.from);
    }

    pub fn push(&mut self, entry: [u32; 2]) {
        self.first[self.to] = entry[0];
        self.second[self.to] = entry[1];
        self.to += 1;
    }

    /// Adds the lanes whose bit is set. There must be room for as many as there are lanes.
    #[inline(always)]
    pub fn extend<L: Lanes>(&mut self, lanes: L, bits: u32, first: L::U, second: L::U) {
        debug_assert!(self.has_room(L::COUNT) && bits >> L::COUNT == 0);
        let whole = self.to..self.to + L::COUNT;
        // SAFETY: `to` is at most `ROOM`, and what is made is longer than that by the longest
        // vector.
        unsafe {
            lanes.store_u(self.first.get_unchecked_mut(whole.clone()), first);
            lanes.store_u(self.second.get_unchecked_mut(whole), second);
        }
        self.to += bits.count_ones() as usize;
    }
}
