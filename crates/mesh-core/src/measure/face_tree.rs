//! A bounding volume hierarchy over the faces of a mesh that is updated after edits.

use glam::DVec3;

use crate::index::as_u32;
use crate::measure::BoundingBox;
use crate::measure::fan::{Fan, tip};
use crate::measure::slab::Slab;
use crate::measure::triangle_bounds::TriangleBounds;
use crate::mesh::TriMesh;
use crate::topology::handle::FaceId;

/// A complete binary tree of bounding boxes, to find the faces near a point or a box.
///
/// [`FaceTree::update`] takes the faces that an edit changed, made or removed: it recomputes their boxes and
/// inserts new faces where boxes grow least. Local edits hardly change the quality of the tree. Removed faces
/// are skipped; if most faces were removed or are new, a new tree is faster. Compaction renumbers the faces and
/// needs a new tree.
#[derive(Clone, Debug)]
pub struct FaceTree {
    /// The root first; the children of node i are 2i + 1 and 2i + 2.
    nodes: Vec<Node>,
    /// For each node, a slab around its faces that is thinner than its box, or all of space. Empty if no face is long
    /// and thin.
    slabs: Vec<Slab>,
    /// The faces, leaf after leaf.
    faces: Vec<FaceId>,
    /// The leaf of each face, by face index; [`NONE`] for faces that are not in the tree.
    leaf_of_face: Vec<u32>,
    /// The face that was added to each leaf last; empty as long as none was.
    added_to_leaf: Vec<Option<FaceId>>,
    /// By face index, the face that was added to the same leaf before it.
    added_before: Vec<Option<FaceId>>,
    leaves: usize,
}

/// Bounds of the faces of a leaf, or of all leaves below a node.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    bounds: BoundingBox,
    fan: Option<Fan>,
}

const FACES_PER_LEAF: usize = 4;

/// No leaf.
const NONE: u32 = u32::MAX;

impl Node {
    const EMPTY: Self =
        Self { bounds: BoundingBox { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY }, fan: None };

    fn is_empty(&self) -> bool {
        self.bounds.min.x > self.bounds.max.x
    }

    fn new(mesh: &TriMesh, faces: &(impl Iterator<Item = FaceId> + Clone)) -> Self {
        let boxes = faces.clone().map(|f| BoundingBox::of_triangle(mesh.triangle(f)));
        Self { bounds: boxes.fold(Self::EMPTY.bounds, union), fan: Fan::new(mesh, faces) }
    }

    fn join(self, other: Self) -> Self {
        let fan = match (self.fan, other.fan) {
            (fan, _) if other.is_empty() => fan,
            (_, fan) if self.is_empty() => fan,
            (Some(fan), Some(other)) => fan.join(other),
            _ => None,
        };
        Self { bounds: union(self.bounds, other.bounds), fan }
    }

    fn may_cross(&self, mesh: &TriMesh, triangle: &TriangleBounds) -> bool {
        match self.fan {
            Some(fan) => fan.may_cross(mesh, self.bounds, triangle),
            None => triangle.bounds.meets(self.bounds),
        }
    }
}

impl FaceTree {
    /// The tree over all faces of a mesh. Takes O(n log n) time.
    #[must_use]
    pub fn new(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        let mut faces: Vec<FaceId> = topology.faces().collect();
        let leaves = faces.len().div_ceil(FACES_PER_LEAF).next_power_of_two();
        let mut arrangement = Arrangement::new(mesh, &faces, 2 * leaves - 1);
        arrangement.arrange(&mut faces, leaves, 0);
        let mut tree = Self {
            nodes: vec![Node::EMPTY; 2 * leaves - 1],
            slabs: arrangement.slabs,
            leaf_of_face: vec![NONE; topology.face_capacity()],
            added_to_leaf: Vec::new(),
            added_before: Vec::new(),
            faces,
            leaves,
        };
        for leaf in 0..leaves {
            for i in tree.range(leaf) {
                tree.leaf_of_face[tree.faces[i].index()] = as_u32(leaf);
            }
            tree.nodes[leaves - 1 + leaf] = tree.leaf_node(mesh, leaf);
        }
        for node in (0..leaves - 1).rev() {
            tree.nodes[node] = tree.nodes[2 * node + 1].join(tree.nodes[2 * node + 2]);
        }
        tree
    }

    /// The range of the faces of a leaf: the same halving as in `arrange`.
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

    /// The faces of a leaf, removed ones included.
    fn faces_of_leaf(&self, leaf: usize) -> impl Iterator<Item = FaceId> + Clone + '_ {
        let last = self.added_to_leaf.get(leaf).copied().flatten();
        let before = |face: &FaceId| self.added_before.get(face.index()).copied().flatten();
        let added = core::iter::successors(last, before);
        self.faces[self.range(leaf)].iter().copied().chain(added)
    }

    fn leaf_node(&self, mesh: &TriMesh, leaf: usize) -> Node {
        Node::new(mesh, &self.faces_of_leaf(leaf).filter(|&f| mesh.topology().contains_face(f)))
    }

    /// Updates the tree after an edit that changed, made or removed these faces. Faces that were never in the
    /// mesh are ignored.
    pub fn update(&mut self, mesh: &TriMesh, faces: impl IntoIterator<Item = FaceId>) {
        for face in faces {
            let known = self.leaf_of_face.get(face.index()).copied().filter(|&leaf| leaf != NONE);
            let leaf = match known {
                Some(leaf) => leaf as usize,
                None if mesh.topology().contains_face(face) => self.add(mesh, face),
                None => continue,
            };
            let mut node = self.leaves - 1 + leaf;
            self.nodes[node] = self.leaf_node(mesh, leaf);
            if mesh.topology().contains_face(face) {
                self.widen_slabs(node, mesh.triangle(face));
            }
            while node > 0 {
                node = (node - 1) / 2;
                let both = self.nodes[2 * node + 1].join(self.nodes[2 * node + 2]);
                if self.nodes[node] == both {
                    break;
                }
                self.nodes[node] = both;
            }
        }
    }

    /// Extends the slabs of a leaf and of the nodes above to a triangle. Slabs never become thinner.
    fn widen_slabs(&mut self, leaf: usize, triangle: [DVec3; 3]) {
        if self.slabs.is_empty() {
            return;
        }
        let parent = |&node: &usize| node.checked_sub(1).map(|below| below / 2);
        for node in core::iter::successors(Some(leaf), parent) {
            self.slabs[node].extend(triangle);
        }
    }

    /// Adds a face to a leaf, reached from the root by the child whose box grows less, and returns the leaf.
    fn add(&mut self, mesh: &TriMesh, face: FaceId) -> usize {
        let bounds = BoundingBox::of_triangle(mesh.triangle(face));
        let growth = |b: BoundingBox| size(union(b, bounds)) - size(b);
        let mut node = 0;
        while node < self.leaves - 1 {
            let [low, high] = [2 * node + 1, 2 * node + 2];
            let is_higher = growth(self.nodes[high].bounds) < growth(self.nodes[low].bounds);
            node = if is_higher { high } else { low };
        }
        let leaf = node + 1 - self.leaves;
        let count = face.index() + 1;
        if self.leaf_of_face.len() < count {
            self.leaf_of_face.resize(count, NONE);
        }
        if self.added_before.len() < count {
            self.added_before.resize(count, None);
        }
        self.added_to_leaf.resize(self.leaves, None);
        self.leaf_of_face[face.index()] = as_u32(leaf);
        self.added_before[face.index()] = self.added_to_leaf[leaf].replace(face);
        leaf
    }

    /// The first face that satisfies `has`, among the faces of all leaves whose box meets `bounds`. These are
    /// all faces that meet `bounds`, and some more.
    pub fn find(
        &self,
        mesh: &TriMesh,
        bounds: BoundingBox,
        has: impl FnMut(FaceId) -> bool,
    ) -> Option<FaceId> {
        self.search(mesh, |node| self.nodes[node].bounds.meets(bounds), has)
    }

    /// The first face that satisfies `has`, among a superset of the faces that cross a triangle in the sense of
    /// [`triangles_cross`](crate::triangles_cross). Vertices that the triangle shares with a face must have
    /// their position in the mesh.
    pub fn find_crossing(
        &self,
        mesh: &TriMesh,
        triangle: &TriangleBounds,
        has: impl FnMut(FaceId) -> bool,
    ) -> Option<FaceId> {
        let is_beside = |slab: &Slab| slab.is_beside(triangle.triangle.1);
        let may_have = |node: usize| {
            self.nodes[node].may_cross(mesh, triangle)
                && !self.slabs.get(node).is_some_and(is_beside)
        };
        self.search(mesh, may_have, has)
    }

    /// The first face that satisfies `has`, among the faces of all leaves whose box and all boxes above satisfy
    /// `may_have`.
    pub fn find_where(
        &self,
        mesh: &TriMesh,
        may_have: impl Fn(&BoundingBox) -> bool,
        has: impl FnMut(FaceId) -> bool,
    ) -> Option<FaceId> {
        self.search(mesh, |node| may_have(&self.nodes[node].bounds), has)
    }

    fn search(
        &self,
        mesh: &TriMesh,
        may_have: impl Fn(usize) -> bool,
        mut has: impl FnMut(FaceId) -> bool,
    ) -> Option<FaceId> {
        // One open node per level at most, besides the current one.
        let mut open = [0_usize; 64];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let node = open[count];
            if !may_have(node) {
                continue;
            }
            if node >= self.leaves - 1 {
                let mut faces = self.faces_of_leaf(node + 1 - self.leaves);
                let found = faces.find(|&f| mesh.topology().contains_face(f) && has(f));
                if found.is_some() {
                    return found;
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

/// The order of the faces in a new tree, and the slabs of its nodes.
struct Arrangement<'m> {
    mesh: &'m TriMesh,
    /// For each face, by index, the direction across it if it is long and thin and in no fan, or zero. Empty if all are
    /// zero.
    across: Vec<DVec3>,
    slabs: Vec<Slab>,
}

impl<'m> Arrangement<'m> {
    fn new(mesh: &'m TriMesh, faces: &[FaceId], nodes: usize) -> Self {
        let mut across = Vec::new();
        for &face in faces {
            let triangle = mesh.triangle(face);
            if is_slender(triangle) && !is_in_fan(mesh, face) {
                across.resize(mesh.topology().face_capacity(), DVec3::ZERO);
                across[face.index()] = Slab::across(triangle);
            }
        }
        let slabs = if across.is_empty() { Vec::new() } else { vec![Slab::default(); nodes] };
        Self { mesh, across, slabs }
    }

    /// Orders the faces below a node by recursive median splits: along the longest extent, or across a bundle of long
    /// thin faces if that separates them better.
    fn arrange(&mut self, faces: &mut [FaceId], leaves: usize, node: usize) {
        let mesh = self.mesh;
        let across = self.across_most(faces);
        if let Some(normal) = across {
            let corners = || faces.iter().flat_map(|&f| mesh.triangle(f));
            let slab = Slab::around(normal, corners());
            // The extent of the box along the normal.
            let extent = BoundingBox::of_points(corners()).map_or(DVec3::ZERO, |b| b.extent());
            if 2.0 * (slab.high - slab.low) < extent.dot(normal.abs()) {
                self.slabs[node] = slab;
            }
        }
        if leaves < 2 || faces.len() < 2 {
            return;
        }
        let center = |face: FaceId| mesh.triangle(face).into_iter().sum::<DVec3>();
        let bounds = BoundingBox::of_points(faces.iter().map(|&f| center(f)));
        let extent = bounds.map_or(DVec3::ZERO, |b| b.extent());
        let axis = DVec3::AXES[extent.max_position()];
        let is_better =
            |normal: &DVec3| separation(mesh, faces, *normal) > separation(mesh, faces, axis);
        let direction = across.filter(is_better).unwrap_or(axis);
        let middle = faces.len() / 2;
        faces.select_nth_unstable_by(middle, |&f, &g| {
            let [at_f, at_g] = [f, g].map(|face| center(face).dot(direction));
            at_f.total_cmp(&at_g).then(f.cmp(&g))
        });
        let (low, high) = faces.split_at_mut(middle);
        self.arrange(low, leaves / 2, 2 * node + 1);
        self.arrange(high, leaves / 2, 2 * node + 2);
    }

    /// The mean direction across the faces, if most are long, thin and nearly parallel.
    fn across_most(&self, faces: &[FaceId]) -> Option<DVec3> {
        /// The mean of unit vectors of one direction has the length 1, of all directions in a plane 0.64.
        const PARALLEL: f64 = 0.8;
        let across = |face: &FaceId| self.across.get(face.index()).copied();
        let slender = faces.iter().filter_map(across).filter(|&across| across != DVec3::ZERO);
        let (mut sum, mut count) = (DVec3::ZERO, 0);
        for across in slender {
            sum += if sum.dot(across) < 0.0 { -across } else { across };
            count += 1;
        }
        let are_parallel = sum.length() > PARALLEL * f64::from(as_u32(count));
        (2 * count > faces.len() && are_parallel).then(|| sum.normalize())
    }
}

/// Whether a triangle is at least four times as long as wide.
fn is_slender([a, b, c]: [DVec3; 3]) -> bool {
    const SLENDER: f64 = 4.0;
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    SLENDER * (b - a).cross(c - a).length() < longest
}

/// Whether a long thin face has its apex at a vertex of many faces. The slabs of such faces all meet at that vertex, so
/// a [`Fan`] bounds these faces instead.
fn is_in_fan(mesh: &TriMesh, face: FaceId) -> bool {
    const MANY: usize = 16;
    let topology = mesh.topology();
    tip(mesh.triangle(face)).is_some_and(|corner| {
        topology.one_ring(topology.face_vertices(face)[corner]).nth(MANY).is_some()
    })
}

/// How many times the mean extent of the faces along a unit vector fits into the extent of their centers.
fn separation(mesh: &TriMesh, faces: &[FaceId], along: DVec3) -> f64 {
    let (mut low, mut high, mut widths) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    for &face in faces {
        let [a, b, c] = mesh.triangle(face).map(|corner| corner.dot(along));
        let center = (a + b + c) / 3.0;
        (low, high) = (low.min(center), high.max(center));
        widths += a.max(b).max(c) - a.min(b).min(c);
    }
    (high - low) * f64::from(as_u32(faces.len())) / widths
}

fn union(a: BoundingBox, b: BoundingBox) -> BoundingBox {
    BoundingBox { min: a.min.min(b.min), max: a.max.max(b.max) }
}

/// The sum of the edge lengths; 0 for the empty box.
fn size(b: BoundingBox) -> f64 {
    b.extent().max(DVec3::ZERO).element_sum()
}
