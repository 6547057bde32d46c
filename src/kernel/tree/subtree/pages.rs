//! Memory that costs nothing where nothing was written.

use std::io;
use std::ops::Deref;

use super::partial::Put;
use memmap2::{Advice, MmapMut, MmapOptions, UncheckedAdvice};

/// Zeroes, until something is written. Pages are given back when nobody uses them any more.
#[derive(Debug)]
pub struct Pages {
    memory: MmapMut,
    page: usize,
    /// How many use each page.
    users: Vec<u32>,
}

impl Pages {
    pub fn reserve(bytes: usize) -> io::Result<Self> {
        let memory = MmapOptions::new().len(bytes).no_reserve_swap().map_anon()?;
        // A huge page would cost what lies beside the little that is written. Kernels without huge
        // pages refuse, and rightly so.
        let _ = memory.advise_range(Advice::NoHugePage, 0, bytes);
        let page = page_size();
        Ok(Self { memory, page, users: vec![0; bytes.div_ceil(page)] })
    }

    fn write(&mut self, at: usize, bytes: &[u8]) {
        self.memory[at..at + bytes.len()].copy_from_slice(bytes);
    }

    /// Numbers of the pages of these ranges, each once.
    fn of(&self, ranges: impl Iterator<Item = (usize, usize)>) -> Vec<u32> {
        let mut pages = Vec::new();
        for (at, length) in ranges.filter(|&(_, length)| length > 0) {
            let (first, last) = (at / self.page, (at + length - 1) / self.page);
            pages.extend(first as u32..=last as u32);
        }
        pages.sort_unstable();
        pages.dedup();
        pages
    }

    fn hold(&mut self, pages: &[u32]) {
        for &page in pages {
            self.users[page as usize] += 1;
        }
    }

    /// Those that nobody else holds become zeroes again.
    pub fn release(&mut self, pages: &[u32]) {
        for &page in pages {
            let users = &mut self.users[page as usize];
            *users -= 1;
            if *users == 0 {
                self.discard(page as usize);
            }
        }
    }

    pub fn in_use(&self) -> usize {
        self.users.iter().filter(|&&users| users > 0).count() * self.page
    }

    fn discard(&mut self, page: usize) {
        let at = page * self.page;
        let length = self.page.min(self.memory.len() - at);
        // SAFETY: the page lies within the mapping, which is private and not of a file: it reads as
        // zeroes afterwards, which is a value of every type that is read from here, and nobody has a
        // reference to it while `self` is borrowed.
        let given =
            unsafe { self.memory.unchecked_advise_range(UncheckedAdvice::DontNeed, at, length) };
        if given.is_err() {
            // Then it keeps its memory, but not what was in it.
            self.memory[at..at + length].fill(0);
        }
    }
}

impl Deref for Pages {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.memory
    }
}

impl Put for Pages {
    fn put(&mut self, writes: &[(usize, &[u8])]) -> io::Result<Vec<u32>> {
        let pages = self.of(writes.iter().map(|(at, bytes)| (*at, bytes.len())));
        self.hold(&pages);
        writes.iter().for_each(|(at, bytes)| self.write(*at, bytes));
        Ok(pages)
    }
}

fn page_size() -> usize {
    // SAFETY: asks for a number.
    let size = unsafe { libc::sysconf(libc::_SC_PAGESIZE) };
    usize::try_from(size).expect("every Linux has a page size")
}
