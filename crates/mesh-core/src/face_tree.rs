//! A tree of boxes round the faces of a mesh that follows edits.

use glam::DVec3;

use crate::handle::FaceId;
use crate::measure::BoundingBox;
use crate::mesh::TriMesh;

/// A complete binary tree of bounding boxes, to find the faces near a place.
///
/// An edit gives faces other corners: [`FaceTree::update`] computes their leaves and the boxes above
/// again. Edits are local, so the tree stays about as good as it was. Faces that were removed are
/// passed over; when most of them were, a new tree is quicker.
#[derive(Clone, Debug)]
pub struct FaceTree {
    /// The boxes, the root first; the children of box i are 2i + 1 and 2i + 2.
    boxes: Vec<BoundingBox>,
    /// The faces, leaf after leaf.
    faces: Vec<FaceId>,
    /// The leaf of each face, by face index.
    leaf_of_face: Vec<u32>,
    leaves: usize,
}

const FACES_PER_LEAF: usize = 4;

const EMPTY: BoundingBox = BoundingBox { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

impl FaceTree {
    /// The tree over all faces of a mesh. Takes O(n log n) time.
    #[must_use]
    pub fn new(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        let mut faces: Vec<FaceId> = topology.faces().collect();
        let leaves = faces.len().div_ceil(FACES_PER_LEAF).next_power_of_two();
        arrange(mesh, &mut faces, leaves);
        let mut tree = Self {
            boxes: vec![EMPTY; 2 * leaves - 1],
            leaf_of_face: vec![0; topology.face_capacity()],
            faces,
            leaves,
        };
        for leaf in 0..leaves {
            for i in tree.range(leaf) {
                tree.leaf_of_face[tree.faces[i].index()] = leaf as u32;
            }
            tree.boxes[leaves - 1 + leaf] = tree.leaf_box(mesh, leaf);
        }
        for node in (0..leaves - 1).rev() {
            tree.boxes[node] = union(tree.boxes[2 * node + 1], tree.boxes[2 * node + 2]);
        }
        tree
    }

    /// Where the faces of a leaf are: the same halves of halves that they were arranged by.
    fn range(&self, leaf: usize) -> core::ops::Range<usize> {
        let (mut start, mut end, mut leaves, mut place) = (0, self.faces.len(), self.leaves, leaf);
        while leaves > 1 {
            let middle = start + (end - start) / 2;
            leaves /= 2;
            if place < leaves {
                end = middle;
            } else {
                start = middle;
                place -= leaves;
            }
        }
        start..end
    }

    fn leaf_box(&self, mesh: &TriMesh, leaf: usize) -> BoundingBox {
        let faces = self.faces[self.range(leaf)].iter();
        let live = faces.filter(|&&f| mesh.topology().contains_face(f));
        live.map(|&f| BoundingBox::of_triangle(mesh.triangle(f))).fold(EMPTY, union)
    }

    /// Follows an edit: these faces have new corners, or are gone.
    pub fn update(&mut self, mesh: &TriMesh, faces: impl IntoIterator<Item = FaceId>) {
        for face in faces {
            let leaf = self.leaf_of_face[face.index()] as usize;
            let mut node = self.leaves - 1 + leaf;
            self.boxes[node] = self.leaf_box(mesh, leaf);
            while node > 0 {
                node = (node - 1) / 2;
                let both = union(self.boxes[2 * node + 1], self.boxes[2 * node + 2]);
                if self.boxes[node] == both {
                    break;
                }
                self.boxes[node] = both;
            }
        }
    }

    /// The first face with a property among those whose leaves meet `bounds`: all faces that meet
    /// it, and some more.
    pub fn find(
        &self,
        mesh: &TriMesh,
        bounds: BoundingBox,
        mut has: impl FnMut(FaceId) -> bool,
    ) -> Option<FaceId> {
        // One open node per level at most, besides the current one.
        let mut open = [0_usize; 64];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let node = open[count];
            if !meet(self.boxes[node], bounds) {
                continue;
            }
            if node >= self.leaves - 1 {
                let mut faces = self.faces[self.range(node + 1 - self.leaves)].iter();
                if let Some(&face) = faces.find(|&&f| mesh.topology().contains_face(f) && has(f)) {
                    return Some(face);
                }
            } else {
                open[count] = 2 * node + 2;
                open[count + 1] = 2 * node + 1;
                count += 2;
            }
        }
        None
    }
}

/// Orders faces so that each half of a half lies on one side of the widest direction.
fn arrange(mesh: &TriMesh, faces: &mut [FaceId], leaves: usize) {
    if leaves < 2 || faces.len() < 2 {
        return;
    }
    let center = |face: FaceId| mesh.triangle(face).into_iter().sum::<DVec3>();
    let bounds = BoundingBox::of_points(faces.iter().map(|&f| center(f)));
    let extent = bounds.map_or(DVec3::ZERO, |b| b.extent());
    let axis = extent.max_position();
    let middle = faces.len() / 2;
    faces.select_nth_unstable_by(middle, |&f, &g| {
        center(f)[axis].total_cmp(&center(g)[axis]).then(f.cmp(&g))
    });
    let (low, high) = faces.split_at_mut(middle);
    arrange(mesh, low, leaves / 2);
    arrange(mesh, high, leaves / 2);
}

fn union(a: BoundingBox, b: BoundingBox) -> BoundingBox {
    BoundingBox { min: a.min.min(b.min), max: a.max.max(b.max) }
}

fn meet(a: BoundingBox, b: BoundingBox) -> bool {
    a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
}
