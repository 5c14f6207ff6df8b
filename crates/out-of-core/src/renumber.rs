//! New numbers for the vertices of triangles.

use mesh_core::as_u32;

/// Marks a vertex without a number.
pub(crate) const NONE: u32 = u32::MAX;

/// The inverse of an order: for each old number its place in the order, which is the new number.
///
/// For example, the inverse of `[2, 0, 1]` is `[1, 2, 0]`.
pub(crate) fn inverse(order: impl ExactSizeIterator<Item = u32>) -> Vec<u32> {
    let mut number = vec![0_u32; order.len()];
    order.zip(0..).for_each(|(old, new)| number[old as usize] = new);
    number
}

/// Triangles with new numbers of their vertices.
pub(crate) fn renumbered<'t>(
    triangles: impl IntoIterator<Item = &'t [u32; 3]>,
    number: &[u32],
) -> Vec<[u32; 3]> {
    triangles.into_iter().map(|triangle| triangle.map(|v| number[v as usize])).collect()
}

/// Numbers the vertices that some triangles use, in the order of their first use.
pub(crate) struct FirstUse {
    number: Vec<u32>,
    /// The old number for each new number.
    pub(crate) used: Vec<u32>,
}

impl FirstUse {
    /// Starts with `vertices` vertices, none of which is in use.
    pub(crate) fn new(vertices: usize) -> Self {
        Self { number: vec![NONE; vertices], used: Vec::new() }
    }

    /// A triangle with new numbers.
    pub(crate) fn triangle(&mut self, triangle: [u32; 3]) -> [u32; 3] {
        triangle.map(|v| {
            let number = &mut self.number[v as usize];
            if *number == NONE {
                // There are no more new numbers than old ones.
                *number = as_u32(self.used.len());
                self.used.push(v);
            }
            *number
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_order_and_of_the_first_use() {
        assert_eq!(inverse([2, 0, 1].into_iter()), [1, 2, 0]);
        assert_eq!(renumbered(&[[0, 1, 2]], &[1, 2, 0]), [[1, 2, 0]]);
        let mut first = FirstUse::new(6);
        assert_eq!([[5, 3, 0], [3, 5, 1]].map(|t| first.triangle(t)), [[0, 1, 2], [1, 0, 3]]);
        assert_eq!(first.used, [5, 3, 0, 1]);
    }
}
