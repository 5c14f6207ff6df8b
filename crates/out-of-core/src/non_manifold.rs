//! Vertices at which a surface is not an oriented manifold.

use mesh_core::as_u32;

use crate::renumber::NONE;

/// The vertices among the first `own`, ascending, whose faces do not form one fan: an edge there has more than two
/// faces, or two faces of opposite orientation, or faces share only the vertex.
///
/// There must be fewer than 2^32 corners.
pub(crate) fn non_manifold_vertices(own: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    // The corners at each own vertex.
    let mut starts = vec![0_u32; own + 1];
    let corners =
        || triangles.as_flattened().iter().enumerate().filter(|(_, v)| (**v as usize) < own);
    corners().for_each(|(_, &v)| starts[v as usize] += 1);
    let mut total = 0;
    for start in &mut starts {
        total += core::mem::replace(start, total);
    }
    let mut listed = vec![0_u32; total as usize];
    let mut place = starts.clone();
    for (corner, &v) in corners() {
        listed[place[v as usize] as usize] = as_u32(corner);
        place[v as usize] += 1;
    }
    let mut fan = Fan::default();
    let is_stuck = |&v: &u32| {
        let range = starts[v as usize] as usize..starts[v as usize + 1] as usize;
        !fan.is_one(&listed[range], triangles)
    };
    (0..as_u32(own)).filter(is_stuck).collect()
}

/// The faces at a vertex, each as the edge opposite to the vertex.
#[derive(Default)]
struct Fan {
    links: Vec<(u32, u32)>,
}

impl Fan {
    fn is_one(&mut self, corners: &[u32], triangles: &[[u32; 3]]) -> bool {
        self.links.clear();
        for &corner in corners {
            let triangle = triangles[corner as usize / 3];
            let i = corner as usize % 3;
            self.links.push((triangle[(i + 1) % 3], triangle[(i + 2) % 3]));
        }
        self.links.sort_unstable();
        if self.links.windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return false;
        }
        let next = |v: u32| {
            let found = self.links.binary_search_by_key(&v, |link| link.0);
            found.map_or(NONE, |place| self.links[place].1)
        };
        // Start at the edge without a predecessor, or anywhere if the fan is closed.
        let mut targets: Vec<u32> = self.links.iter().map(|link| link.1).collect();
        targets.sort_unstable();
        if targets.windows(2).any(|pair| pair[0] == pair[1]) {
            return false;
        }
        let first = self.links.iter().find(|link| targets.binary_search(&link.0).is_err());
        let Some(&(start, _)) = first.or(self.links.first()) else { return true };
        let (mut at, mut met) = (start, 0);
        while met <= self.links.len() {
            at = next(at);
            if at == NONE {
                break;
            }
            met += 1;
            if at == start {
                break;
            }
        }
        met == self.links.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fans_are_told_from_everything_else() {
        // Around vertex 0: closed, open, two fans, three faces at an edge, one face turned over.
        let closed = [[0, 1, 2], [0, 2, 3], [0, 3, 1]];
        assert_eq!(non_manifold_vertices(1, &closed), [0; 0]);
        assert_eq!(non_manifold_vertices(1, &closed[..2]), [0; 0]);
        assert_eq!(non_manifold_vertices(4, &closed[..2]), [0; 0]);
        assert_eq!(non_manifold_vertices(1, &[[0, 1, 2], [0, 3, 4]]), [0]);
        assert_eq!(non_manifold_vertices(2, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]), [0, 1]);
        assert_eq!(non_manifold_vertices(5, &[[0, 1, 2], [0, 1, 3]]), [0, 1]);
        let pinched = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [0, 4, 5], [0, 5, 6], [0, 6, 4]];
        assert_eq!(non_manifold_vertices(7, &pinched), [0]);
    }
}
