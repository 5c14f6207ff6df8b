//! Which vertices are collapsed together: pieces of space with equally many vertices each.
//!
//! Space is halved again and again, across the longest side of what is left, where that halves the
//! vertices. Each pass halves in other directions than the one before, so that its rims lie across the old
//! ones. The pieces depend on the positions alone.

use glam::{DMat3, DVec3};

use crate::regions::sheet::Sheet;

/// The vertices of a sheet in regions of equal size; only the last may be smaller.
#[derive(Debug)]
pub(super) struct Partition {
    /// The vertices, region by region.
    pub(super) order: Vec<u32>,
    /// By vertex: its place in the order.
    pub(super) rank: Vec<u32>,
    /// The number of vertices of each region.
    pub(super) size: usize,
    /// The faces that have a corner in each region, region by region.
    faces: Vec<u32>,
    /// Where the faces of each region begin, and where the last ones end.
    starts: Vec<u32>,
}

/// A vertex and where it is, in the directions of the pass.
#[derive(Clone, Copy, Debug)]
struct Site {
    at: [f32; 3],
    vertex: u32,
}

impl Partition {
    /// The regions of this many vertices in pass number `pass`.
    pub(super) fn new(sheet: &Sheet<'_>, size: usize, pass: usize) -> Self {
        let directions = directions(pass);
        let center = sheet.vertices().next().map_or(DVec3::ZERO, |v| sheet.positions[v as usize]);
        let site = |vertex: u32| {
            let at = directions * (sheet.positions[vertex as usize] - center);
            Site { at: at.as_vec3().to_array(), vertex }
        };
        let mut sites: Vec<Site> = sheet.vertices().map(site).collect();
        halve(&mut sites, size);
        let order: Vec<u32> = sites.into_iter().map(|site| site.vertex).collect();
        let mut rank = vec![u32::MAX; sheet.vertex_capacity()];
        for (place, &v) in order.iter().enumerate() {
            rank[v as usize] = place as u32;
        }
        let mut partition = Self { order, rank, size, faces: Vec::new(), starts: Vec::new() };
        partition.list_faces(sheet);
        partition
    }

    pub(super) fn regions(&self) -> usize {
        self.order.len().div_ceil(self.size)
    }

    /// The vertices of a region.
    pub(super) fn vertices(&self, region: usize) -> &[u32] {
        let end = self.order.len().min((region + 1) * self.size);
        &self.order[region * self.size..end]
    }

    /// The faces that have a corner in a region.
    pub(super) fn faces(&self, region: usize) -> &[u32] {
        &self.faces[self.starts[region] as usize..self.starts[region + 1] as usize]
    }

    pub(super) fn region_of(&self, v: u32) -> usize {
        self.rank[v as usize] as usize / self.size
    }

    fn list_faces(&mut self, sheet: &Sheet<'_>) {
        let mut starts = vec![0; self.regions() + 1];
        let regions_of = |face: usize| {
            let [a, b, c] = sheet.triangle(face)?.map(|v| self.region_of(v));
            Some([Some(a), (b != a).then_some(b), (c != a && c != b).then_some(c)])
        };
        for face in 0..sheet.face_capacity() {
            for region in regions_of(face).into_iter().flatten().flatten() {
                starts[region] += 1;
            }
        }
        let mut total = 0;
        for start in &mut starts {
            total += core::mem::replace(start, total);
        }
        let mut faces = vec![0; total as usize];
        let mut place = starts.clone();
        for face in 0..sheet.face_capacity() {
            for region in regions_of(face).into_iter().flatten().flatten() {
                faces[place[region] as usize] = face as u32;
                place[region] += 1;
            }
        }
        (self.faces, self.starts) = (faces, starts);
    }
}

/// Orthogonal directions, others in every pass.
fn directions(pass: usize) -> DMat3 {
    // No two of the first thousand are alike.
    let angle = 0.785 * pass as f64;
    DMat3::from_rotation_z(angle) * DMat3::from_rotation_x(0.6 * angle)
}

/// Brings the sites into an order in which those of each region follow each other.
fn halve(sites: &mut [Site], size: usize) {
    let regions = sites.len().div_ceil(size);
    if regions < 2 {
        return;
    }
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for site in &*sites {
        for i in 0..3 {
            low[i] = low[i].min(site.at[i]);
            high[i] = high[i].max(site.at[i]);
        }
    }
    let axis =
        (1..3).fold(
            0,
            |longest, i| {
                if high[i] - low[i] > high[longest] - low[longest] { i } else { longest }
            },
        );
    let middle = regions / 2 * size;
    sites.select_nth_unstable_by(middle, |a, b| {
        a.at[axis].total_cmp(&b.at[axis]).then(a.vertex.cmp(&b.vertex))
    });
    let (left, right) = sites.split_at_mut(middle);
    halve(left, size);
    halve(right, size);
}
