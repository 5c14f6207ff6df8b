//! Which components of a mesh are inside out.
//!
//! A component is decided by the first of these rules that applies:
//!
//! 1. **Closed components** by their signed volume and by containment. The volume is positive for a component inside no
//!    other closed component and for a component at an even depth of nesting. It is negative at an odd depth, where the
//!    component is the surface of a cavity. A component is inside another one when all its vertices are inside it or on
//!    it and at least one is inside. Containment is exact (`containment`).
//! 2. **Nearly closed components** are components with holes whose volume has the same sign for every apex in the
//!    bounding box from which the holes are closed. They are treated like closed ones, but contain nothing.
//! 3. **Open components** by visibility from far outside: the side whose visible area is larger by a tenth is
//!    the front (`visibility`). A component is not turned because other components stand before its front, as houses
//!    stand on terrain, unless they hide half of it, as what is in a hull hides the inside of the hull.
//! 4. **Undecided** are components without volume, flat sheets, components hidden inside others, and open components
//!    among so many overlapping faces that visibility would take too long.
//!
//! Time: O(n log n) with one ray per component and one location per vertex of a nested component. Components whose
//! boxes lie in no other box cost one ray only.

use std::collections::HashMap;

use glam::DVec3;

use crate::index::as_u32;
use crate::measure::bounding_box::BoundingBox;
use crate::measure::containment::{Containment, Location};
use crate::measure::face_tree::FaceTree;
use crate::measure::unit_scale::UnitScale;
use crate::measure::visibility::{DIRECTIONS, Visibility, VisibleArea};
use crate::mesh::TriMesh;
use crate::parallel;
use crate::topology::handle::FaceId;

/// The direction in which the faces of a component look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Facing {
    /// Towards the outside; into the cavity for the surface of a cavity.
    Outward,
    /// The wrong way.
    InsideOut,
    /// Neither volume nor visibility decides.
    Undecided,
}

/// The facing of each component of a mesh; made by [`TriMesh::facings`].
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Facings {
    /// Per component, in the order of [`Topology::components`](crate::Topology::components).
    pub of_component: Vec<Facing>,
    /// Per component its faces, ascending.
    pub faces: Vec<Vec<FaceId>>,
}

impl Facings {
    /// The number of components that face one way.
    #[must_use]
    pub fn count(&self, facing: Facing) -> usize {
        self.of_component.iter().filter(|&&other| other == facing).count()
    }

    /// The faces of each component that is inside out.
    pub fn inside_out(&self) -> impl Iterator<Item = &[FaceId]> {
        let wrong = |(&facing, faces)| (facing == Facing::InsideOut).then_some(faces);
        self.of_component.iter().zip(&self.faces).filter_map(wrong).map(Vec::as_slice)
    }
}

/// A visible area decides if it is larger by this factor.
const CLEARLY: f64 = 1.1;

/// A side is the inside if other components hide it so far that the other side is larger by this factor.
const HIDDEN: f64 = 2.0;

/// Most sample points on one open component.
const MOST_SAMPLES: usize = 512;

/// Sample points on all open components together. The largest components are sampled first; the others stay undecided.
const ALL_SAMPLES: usize = 1 << 16;

/// Tests of half-lines against faces for all open components together, and more for each face of the mesh. Usual meshes
/// need fewer; where thousands of components overlap, the smallest ones stay undecided.
const ALL_TESTS: usize = 10 * 2 * DIRECTIONS * ALL_SAMPLES;
const TESTS_PER_FACE: usize = 200;

/// Components whose visible areas are computed before the tests are counted: a constant, so that the number of threads
/// changes nothing.
const AT_A_TIME: usize = 64;

impl TriMesh {
    /// Which components are inside out, and which are undecided, by the [rules](crate::measure::facing) of
    /// [`Repair::reorient`](crate::Repair::reorient).
    ///
    /// ```
    /// use mesh_core::{TriMesh, measure::Facing};
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    /// let inward = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
    /// let facings = TriMesh::from_triangles(&corners, &inward)?.facings();
    /// assert_eq!(facings.of_component, [Facing::InsideOut]);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn facings(&self) -> Facings {
        if let Ok(Some(scale)) = UnitScale::of(self)
            && let Ok(scaled) = scale.mesh(self)
        {
            return scaled.facings();
        }
        let parts = Parts::new(self);
        let of_component = parts.decide(self);
        Facings { of_component, faces: parts.faces }
    }
}

impl VisibleArea {
    /// Whether more is visible of the back.
    fn is_back(self) -> bool {
        self.back > CLEARLY * self.front
    }
}

/// The components and their measures.
struct Parts {
    component_of_face: Vec<u32>,
    faces: Vec<Vec<FaceId>>,
    sizes: Vec<Size>,
}

/// Sizes of a component; area and volume relative to the longest extent of the mesh.
#[derive(Clone, Copy)]
struct Size {
    bounds: BoundingBox,
    is_closed: bool,
    area: f64,
    /// Signed volume of the cone over the centre of the bounding box; 0 where rounding or holes hide its sign.
    volume: f64,
}

impl Parts {
    fn new(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        let components = topology.components();
        let mut faces = vec![Vec::new(); components.count];
        let mut component_of_face = vec![u32::MAX; topology.face_capacity()];
        for face in topology.faces() {
            let [vertex, ..] = topology.face_vertices(face);
            if let Some(component) = components.of_vertex[vertex] {
                faces[component as usize].push(face);
                component_of_face[face.index()] = component;
            }
        }
        let unit = mesh.bounding_box().map_or(1.0, |b| b.extent().max_element());
        let sizes = faces.iter().map(|faces| Size::new(mesh, faces, unit)).collect();
        Self { component_of_face, faces, sizes }
    }

    fn component(&self, face: FaceId) -> u32 {
        self.component_of_face[face.index()]
    }

    fn decide(&self, mesh: &TriMesh) -> Vec<Facing> {
        let by_volume = |is_inverted: bool| match is_inverted {
            true => Facing::InsideOut,
            false => Facing::Outward,
        };
        let sizes = &self.sizes;
        if sizes.len() == 1 && sizes[0].volume != 0.0 {
            return vec![by_volume(sizes[0].volume < 0.0)];
        }
        let Some(bounds) = mesh.bounding_box() else { return Vec::new() };
        let tree = FaceTree::new(mesh);
        let depths = self.depths(mesh, &Containment::new(mesh, &tree, bounds));
        let visibility = Visibility::new(mesh, &tree, bounds);
        let most = ALL_TESTS + TESTS_PER_FACE * self.component_of_face.len();
        let (visible, mut used) = self.visible_areas(&visibility, most);
        let facing = |i: usize| {
            if sizes[i].volume != 0.0 {
                let is_cavity = depths[i] % 2 == 1;
                return by_volume((sizes[i].volume < 0.0) != is_cavity);
            }
            let VisibleArea { front, back } = visible[i];
            if visible[i].is_back() {
                let is_clear = back > HIDDEN * front
                    || used < most && {
                        let (alone, tests) = self.visible_alone(&visibility, i);
                        used += tests;
                        alone.is_back()
                    };
                if is_clear { Facing::InsideOut } else { Facing::Undecided }
            } else if front > CLEARLY * back {
                Facing::Outward
            } else {
                Facing::Undecided
            }
        };
        (0..sizes.len()).map(facing).collect()
    }

    /// The number of closed components that contain each component with a volume.
    fn depths(&self, mesh: &TriMesh, containment: &Containment<'_>) -> Vec<u32> {
        let points = self.lonely_corners(mesh);
        let candidates = parallel::collect_each(self.sizes.len(), |i| {
            self.candidates(points[i], containment, as_u32(i))
        });
        let mut depths = vec![0; self.sizes.len()];
        // A container has a larger volume, so its depth is known first.
        for i in self.by_volume() {
            let is_in = |&container: &u32| self.is_in(mesh, containment, i, container);
            if let Some(container) = candidates[i].iter().copied().find(is_in) {
                depths[i] = depths[container as usize] + 1;
            }
        }
        depths
    }

    /// Components in order of decreasing volume.
    fn by_volume(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.sizes.len()).collect();
        order.sort_by(|&i, &j| self.size(j).total_cmp(&self.size(i)).then(i.cmp(&j)));
        order
    }

    fn size(&self, i: usize) -> f64 {
        self.sizes[i].volume.abs()
    }

    /// Whether a component may contain another one, judged by their sizes.
    fn may_contain(&self, container: u32, i: u32) -> bool {
        let [outer, inner] = [container, i].map(|c| self.sizes[c as usize]);
        container != i
            && outer.is_closed
            && outer.volume.abs() > inner.volume.abs()
            && outer.bounds.min.cmple(inner.bounds.min).all()
            && inner.bounds.max.cmple(outer.bounds.max).all()
    }

    /// For each component, the vertex with the fewest faces at its position. Components can meet in one point by the
    /// thousands; each look-up of that point finds the faces of all of them.
    fn lonely_corners(&self, mesh: &TriMesh) -> Vec<DVec3> {
        let key = |point: DVec3| point.to_array().map(f64::to_bits);
        let mut count: HashMap<[u64; 3], u32> = HashMap::new();
        for &face in self.faces.iter().flatten() {
            mesh.triangle(face).into_iter().for_each(|p| *count.entry(key(p)).or_default() += 1);
        }
        let lonely = |faces: &Vec<FaceId>| {
            let corners = faces.iter().flat_map(|&face| mesh.triangle(face));
            corners.min_by_key(|&point| count.get(&key(point))).unwrap_or(DVec3::NAN)
        };
        self.faces.iter().map(lonely).collect()
    }

    /// The closed components that contain a vertex of a component, or touch it; the smallest first.
    fn candidates(&self, point: DVec3, containment: &Containment<'_>, i: u32) -> Vec<u32> {
        if self.sizes[i as usize].volume == 0.0 {
            return Vec::new();
        }
        let other = |face| Some(self.component(face)).filter(|&c| self.may_contain(c, i));
        let mut found = containment.containers(point, other);
        let order = |&a: &u32, &b: &u32| {
            self.size(a as usize).total_cmp(&self.size(b as usize)).then(a.cmp(&b))
        };
        found.sort_by(order);
        found
    }

    /// Whether all vertices of a component are inside another one or on it, and one is inside.
    fn is_in(
        &self,
        mesh: &TriMesh,
        containment: &Containment<'_>,
        i: usize,
        container: u32,
    ) -> bool {
        let faces = &self.faces[i];
        let is_part = |face| self.component(face) == container;
        let place = |index: usize| {
            let corner = mesh.triangle(faces[index / 3])[index % 3];
            containment.locate(corner, is_part)
        };
        let count = 3 * faces.len();
        let some_inside = || (0..count).any(|index| place(index) == Location::Inside);
        let none_outside = |mut range: core::ops::Range<usize>| {
            range.all(|index| place(index) != Location::Outside)
        };
        // In this order, because components that are not nested have a vertex outside.
        parallel::holds_in_blocks(count, none_outside) && some_inside()
    }

    /// The visible area of a component without the others, and the number of tests.
    fn visible_alone(&self, visibility: &Visibility<'_>, i: usize) -> (VisibleArea, usize) {
        let faces = &self.faces[i];
        let is_own = |face| self.component(face) as usize == i;
        visibility.of_faces(faces, MOST_SAMPLES.min(16 * faces.len()), is_own)
    }

    /// Visible areas of the components without a volume, the largest first, until the samples or `most` tests are used up,
    /// and the number of tests.
    fn visible_areas(&self, visibility: &Visibility<'_>, most: usize) -> (Vec<VisibleArea>, usize) {
        let mut order: Vec<usize> =
            (0..self.sizes.len()).filter(|&i| self.sizes[i].volume == 0.0).collect();
        order.sort_by(|&i, &j| self.sizes[j].area.total_cmp(&self.sizes[i].area).then(i.cmp(&j)));
        let samples = MOST_SAMPLES.min(ALL_SAMPLES / order.len().max(1)).max(16);
        order.truncate(ALL_SAMPLES / samples);
        let (mut used, mut all) = (0, vec![VisibleArea::default(); self.sizes.len()]);
        for some in order.chunks(AT_A_TIME) {
            let areas = parallel::collect_each(some.len(), |place| {
                let faces = &self.faces[some[place]];
                visibility.of_faces(faces, samples.min(16 * faces.len()), |_| true)
            });
            for (&i, (area, tests)) in some.iter().zip(areas) {
                all[i] = area;
                used += tests;
            }
            if used >= most {
                break;
            }
        }
        (all, used)
    }
}

impl Size {
    /// Sizes in units of `unit`, so that no product overflows.
    fn new(mesh: &TriMesh, faces: &[FaceId], unit: f64) -> Self {
        let topology = mesh.topology();
        let corners = faces.iter().flat_map(|&f| mesh.triangle(f));
        let nowhere = BoundingBox { min: DVec3::ZERO, max: DVec3::ZERO };
        let bounds = BoundingBox::of_points(corners).unwrap_or(nowhere);
        let is_closed =
            faces.iter().all(|&f| topology.face_neighbours(f).iter().all(Option::is_some));
        let center = bounds.center();
        let (mut volume, mut terms, mut area, mut vector_area) = (0.0, 0.0, 0.0, DVec3::ZERO);
        for &face in faces {
            let [a, b, c] = mesh.triangle(face).map(|p| (p - center) / unit);
            let term = a.dot(b.cross(c)) / 6.0;
            let cross = 0.5 * (b - a).cross(c - a);
            (volume, terms) = (volume + term, terms + term.abs());
            (area, vector_area) = (area + cross.length(), vector_area + cross);
        }
        let largest = bounds.min.abs().max(bounds.max.abs()).max_element() / unit;
        let rounding = f64::EPSILON * ((faces.len() as f64 + 16.0) * terms + largest * area);
        // Another apex in the box changes the volume of an open component by no more than this.
        let diagonal = bounds.diagonal() / unit;
        let by_apex = if is_closed { 0.0 } else { vector_area.length() * diagonal / 6.0 };
        let is_certain = volume.abs() > rounding + by_apex;
        Self { bounds, is_closed, area, volume: if is_certain { volume } else { 0.0 } }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;

    fn random_point(random: &mut SplitMix64) -> DVec3 {
        DVec3::new(random.symmetric(), random.symmetric(), random.symmetric())
    }

    /// Thousands of triangles that touch in one point, and lie in all directions around it.
    fn triangles_around_a_point(count: u32) -> TriMesh {
        let mut random = SplitMix64::new(3);
        let mut points = Vec::new();
        for _ in 0..count {
            let far = random_point(&mut random);
            points.extend([DVec3::ZERO, far, far + 0.05 * random_point(&mut random)]);
        }
        let faces: Vec<_> = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        TriMesh::from_triangles(&points, &faces).unwrap()
    }

    /// The number of components that were looked at, and of tests.
    fn looked_at(mesh: &TriMesh, most: usize) -> (usize, usize) {
        let tree = FaceTree::new(mesh);
        let visibility = Visibility::new(mesh, &tree, mesh.bounding_box().unwrap());
        let (visible, tests) = Parts::new(mesh).visible_areas(&visibility, most);
        (visible.iter().filter(|area| area.front + area.back > 0.0).count(), tests)
    }

    #[test]
    fn overlapping_components_share_their_tests() {
        let (count, most) = (1000, 1_000_000);
        let crowded = triangles_around_a_point(count as u32);
        let (_, without) = looked_at(&crowded, usize::MAX);
        let (_, tests) = looked_at(&crowded, most);
        let last = AT_A_TIME * 16 * 2 * DIRECTIONS * 64;
        assert!(tests < most + last && 2 * tests < without, "{tests} {without}");
        // The same triangles side by side.
        let place = |v: u32| 2.0 * DVec3::new(f64::from(v / 3 % 16), f64::from(v / 48), 0.0);
        let moved = crowded.positions().iter().zip(0..).map(|(&p, v)| p + place(v)).collect();
        let apart = TriMesh::new(crowded.topology().clone(), moved).unwrap();
        let (seen, _) = looked_at(&apart, ALL_TESTS + TESTS_PER_FACE * count);
        assert_eq!(seen, count);
    }

    #[test]
    fn components_that_meet_in_a_point_are_looked_up_elsewhere() {
        let (count, mut random) = (1000, SplitMix64::new(5));
        let (mut points, mut faces) = (Vec::new(), Vec::new());
        for i in 0..count {
            let far = random_point(&mut random);
            let mut near = || far + 0.05 * random_point(&mut random);
            points.extend([DVec3::ZERO, near(), near(), near()]);
            let sides = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
            faces.extend(sides.map(|side| side.map(|v| 4 * i + v)));
        }
        let mesh = TriMesh::from_triangles(&points, &faces).unwrap();
        let (parts, tree) = (Parts::new(&mesh), FaceTree::new(&mesh));
        let containment = Containment::new(&mesh, &tree, mesh.bounding_box().unwrap());
        let lonely = parts.lonely_corners(&mesh);
        assert!(lonely.iter().all(|&point| point != DVec3::ZERO));
        let candidates = |i: u32| parts.candidates(lonely[i as usize], &containment, i).len();
        let all: usize = (0..count).map(candidates).sum();
        assert!(all < count as usize / 10, "{all}");
    }
}
