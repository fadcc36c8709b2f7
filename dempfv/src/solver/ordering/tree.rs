//! The tree of a dissection: each part's sides, then its separator.

/// A leaf of the tree, or a separator.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    /// Vertices that are ordered here.
    pub vertices: u32,
    /// Nodes of the tree below it; none below a leaf.
    pub below: u32,
}

impl Size {
    pub(super) fn of_leaf(vertices: usize) -> Size {
        Size { vertices: vertices as u32, below: 0 }
    }

    pub(super) fn of_cut(vertices: usize, below: usize) -> Size {
        Size { vertices: vertices as u32, below: below as u32 }
    }
}

/// What separators cost, about: entries of the factor among their own vertices.
pub(super) fn weight(sizes: &[Size]) -> f64 {
    let own = |size: &Size| if size.below > 0 { f64::from(size.vertices).powi(2) } else { 0.0 };
    sizes.iter().map(own).sum()
}

/// The nodes by their numbers: sides come before their separator, so that this is
/// also the order of elimination.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    /// The lowest number below each node, or its own.
    first: Vec<u32>,
    /// The separator of the part that a node is a side of; the root's is its own.
    parent: Vec<u32>,
}

impl Tree {
    pub(super) fn new(sizes: &[Size]) -> Tree {
        let first: Vec<u32> =
            sizes.iter().enumerate().map(|(k, size)| k as u32 - size.below).collect();
        let mut parent: Vec<u32> = (0..sizes.len() as u32).collect();
        for (k, size) in sizes.iter().enumerate() {
            // The right side ends just before its separator, the left before the right.
            if size.below > 0 {
                let right = k - 1;
                let left = first[right] as usize - 1;
                parent[left] = k as u32;
                parent[right] = k as u32;
            }
        }
        Tree { first, parent }
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.first.len()
    }

    /// Whether a node is a leaf.
    pub(super) fn is_leaf(&self, node: u32) -> bool {
        self.first[node as usize] == node
    }

    /// Nodes below a node.
    pub(super) fn below(&self, node: u32) -> u32 {
        node - self.first[node as usize]
    }

    /// Whether one of two nodes is above the other, or both are one: their vertices
    /// may be neighbours.
    pub(super) fn in_line(&self, a: u32, b: u32) -> bool {
        self.first[a.max(b) as usize] <= a.min(b)
    }

    /// The lowest node that is in line with both and not below either.
    pub(super) fn join(&self, a: u32, b: u32) -> u32 {
        let mut above = a.max(b);
        while self.first[above as usize] > a.min(b) {
            above = self.parent[above as usize];
        }
        above
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two leaves and their separator, a leaf, and the root: ((0 1) 2, 3) 4.
    #[test]
    fn lines_and_joins() {
        let leaf = Size::of_leaf(9);
        let sizes = [leaf, leaf, Size::of_cut(3, 2), leaf, Size::of_cut(5, 4)];
        let tree = Tree::new(&sizes);
        assert_eq!(weight(&sizes), 34.0);
        assert_eq!(tree.parent, [2, 2, 4, 4, 4]);
        assert_eq!([0, 1, 2, 3, 4].map(|k| tree.below(k)), [0, 0, 2, 0, 4]);
        assert_eq!([0, 1, 2, 3, 4].map(|k| tree.is_leaf(k)), [true, true, false, true, false]);
        let related = [(0, 0), (0, 2), (2, 1), (0, 4), (3, 4), (4, 2)];
        for a in 0..5 {
            for b in 0..5 {
                let expected = a == b || related.contains(&(a, b)) || related.contains(&(b, a));
                let expected = expected || (a.min(b), a.max(b)) == (1, 4);
                assert_eq!(tree.in_line(a, b), expected, "{a} {b}");
            }
        }
        assert_eq!([tree.join(0, 1), tree.join(1, 3), tree.join(3, 2)], [2, 4, 4]);
        assert_eq!([tree.join(0, 0), tree.join(0, 2), tree.join(4, 0)], [0, 2, 4]);
    }
}
