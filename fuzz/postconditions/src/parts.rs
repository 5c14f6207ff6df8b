//! Triangles as they are put together from grids, walls and caps.

use glam::DVec3;
use mesh_core::PolygonSoup;
use mesh_core::SplitMix64;

/// Random choices of a generated mesh.
pub(crate) struct Choices(SplitMix64);

impl Choices {
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        random.bits();
        Self(random)
    }

    /// A whole number from `low` to `high`.
    pub(crate) fn count(&mut self, low: usize, high: usize) -> usize {
        low + (self.0.uniform() * (high - low + 1) as f64) as usize
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }

    /// A number between two positive ones; its logarithm is uniform.
    pub(crate) fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// True once in `times`.
    pub(crate) fn one_in(&mut self, times: usize) -> bool {
        self.count(1, times) == 1
    }

    pub(crate) fn direction(&mut self) -> DVec3 {
        DVec3::new(self.0.normal(), self.0.normal(), self.0.normal()).normalize_or(DVec3::Z)
    }
}

/// Triangles in the making. Equal positions stay separate vertices until [`Parts::soup`].
#[derive(Default)]
pub(crate) struct Parts {
    pub(crate) points: Vec<DVec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Whether equal positions stay separate vertices in [`Parts::soup`].
    pub(crate) is_apart: bool,
}

impl Parts {
    pub(crate) fn push(&mut self, corners: [DVec3; 3]) {
        let first = self.points.len() as u32;
        self.points.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
    }

    /// A grid of `cells` quadrilaterals over the unit square; the normal is u × v.
    pub(crate) fn grid(&mut self, cells: [usize; 2], point: impl Fn(f64, f64) -> DVec3) {
        self.grid_with(cells, point, |_, _| false);
    }

    /// A grid whose diagonals join the other two corners where `turns`.
    pub(crate) fn grid_with(
        &mut self,
        [columns, rows]: [usize; 2],
        point: impl Fn(f64, f64) -> DVec3,
        mut turns: impl FnMut(usize, usize) -> bool,
    ) {
        let first = self.points.len();
        for row in 0..=rows {
            for column in 0..=columns {
                self.points.push(point(column as f64 / columns as f64, row as f64 / rows as f64));
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let a = (first + row * (columns + 1) + column) as u32;
                let [b, c, d] = [a + 1, a + columns as u32 + 2, a + columns as u32 + 1];
                let two = if turns(column, row) {
                    [[a, b, d], [b, c, d]]
                } else {
                    [[a, b, c], [a, c, d]]
                };
                self.triangles.extend(two);
            }
        }
    }

    /// The six sides of a box.
    pub(crate) fn cuboid(&mut self, low: DVec3, high: DVec3, [x, y, z]: [usize; 3]) {
        let at = |u: f64, v: f64, w: f64| low + (high - low) * DVec3::new(u, v, w);
        self.grid([x, y], |u, v| at(u, v, 1.0));
        self.grid([y, x], |u, v| at(v, u, 0.0));
        self.grid([y, z], |u, v| at(1.0, u, v));
        self.grid([z, y], |u, v| at(0.0, v, u));
        self.grid([z, x], |u, v| at(v, 1.0, u));
        self.grid([x, z], |u, v| at(u, 0.0, v));
    }

    /// A fan from a centre round a closed outline.
    pub(crate) fn fan(&mut self, centre: DVec3, outline: &[DVec3]) {
        for (index, &point) in outline.iter().enumerate() {
            self.push([centre, point, outline[(index + 1) % outline.len()]]);
        }
    }

    /// The walls between two closed outlines with as many points; the second is above, seen counter-clockwise.
    pub(crate) fn ring(&mut self, below: &[DVec3], above: &[DVec3]) {
        for index in 0..below.len() {
            let next = (index + 1) % below.len();
            self.push([below[index], below[next], above[next]]);
            self.push([below[index], above[next], above[index]]);
        }
    }

    /// Faces in the opposite direction, from the face with index `first`.
    pub(crate) fn reverse_from(&mut self, first: usize) {
        self.triangles[first..].iter_mut().for_each(|[_, b, c]| core::mem::swap(b, c));
    }

    /// Three vertices of its own for each triangle.
    pub(crate) fn scattered(&self) -> Self {
        let mut all = Self { is_apart: self.is_apart, ..Self::default() };
        self.triangles.iter().for_each(|t| all.push(t.map(|v| self.points[v as usize])));
        all
    }

    /// One vertex for each position, to a billionth of the size, unless the parts stay apart; faces that lose a corner
    /// are left out.
    pub(crate) fn soup(&self) -> PolygonSoup {
        if self.is_apart {
            return soup(&self.points, &self.triangles);
        }
        let size = self.points.iter().fold(0.0_f64, |size, p| size.max(p.abs().max_element()));
        let key = |point: DVec3| (point / (1e-9 * size)).round().to_array().map(|x| x as i64);
        let mut numbers = std::collections::HashMap::new();
        let (mut points, mut new) = (Vec::new(), Vec::new());
        for &point in &self.points {
            let number = *numbers.entry(key(point)).or_insert_with(|| {
                points.push(point);
                points.len() as u32 - 1
            });
            new.push(number);
        }
        let triangles = self.triangles.iter().map(|corners| corners.map(|v| new[v as usize]));
        let is_whole = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        soup(&points, &triangles.filter(is_whole).collect::<Vec<_>>())
    }
}

/// A soup of few triangles.
pub(crate) fn soup(points: &[DVec3], triangles: &[[u32; 3]]) -> PolygonSoup {
    PolygonSoup::from_triangles(points, triangles).unwrap_or_default()
}
