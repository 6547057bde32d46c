use crate::mesh::closed::Shells;
use crate::mesh::weld;
use crate::tree::{ByNumber, Ranks, TreeView};

/// What effects look up in a mesh, made when it is first asked for and kept as long as the tree is
/// the same.
#[derive(Debug, Default)]
pub struct Kept {
    ranks: Ranks,
    places: Option<(u64, Vec<u32>)>,
    shells: Option<(u64, Shells)>,
}

impl Kept {
    pub fn by_number<'a>(&'a mut self, tree: &TreeView<'a>) -> ByNumber<'a> {
        self.ranks.of(tree)
    }

    /// For each vertex of the tree the number of its place, which equal vertices share.
    pub fn places<'a>(&'a mut self, tree: &TreeView<'a>) -> (&'a [u32], ByNumber<'a>) {
        let places = of_tree(&mut self.places, tree, |tree| weld(tree.vertices()).index);
        (places, self.ranks.of(tree))
    }

    pub fn shells<'a>(&'a mut self, tree: &TreeView<'a>) -> (&'a Shells, ByNumber<'a>) {
        let by_number = self.ranks.of(tree);
        // In the order of the file: the same for every kind of tree.
        let shells = of_tree(&mut self.shells, tree, |tree| {
            Shells::of(
                tree.vertices(),
                (0..tree.triangle_count()).map(|number| by_number.vertices(number)),
            )
        });
        (shells, by_number)
    }
}

fn of_tree<'a, T>(
    kept: &'a mut Option<(u64, T)>,
    tree: &TreeView<'_>,
    make: impl FnOnce(&TreeView<'_>) -> T,
) -> &'a T {
    if kept.as_ref().is_none_or(|(of, _)| *of != tree.hash()) {
        *kept = Some((tree.hash(), make(tree)));
    }
    &kept.as_ref().expect("it is there now").1
}
