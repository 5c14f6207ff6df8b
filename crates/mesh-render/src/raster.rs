//! Triangles to pixels: a depth buffer of several samples per pixel, averaged down.
//!
//! The picture is made in bands of rows, each with the triangles that touch it in their order. So memory does not grow
//! with the picture, and the result does not depend on the number of threads.

use core::ops::Range;

use mesh_core::as_u32;

use crate::texture::Texture;

pub(crate) const EDGE: [f32; 3] = [0.12, 0.12, 0.14];
/// Rows of pixels in a band.
const BAND: u32 = 16;
/// Boxes with at most this number of columns are drawn without a search for the columns of each row.
const FEW: usize = 8;

/// A triangle in samples.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    /// Column, row and depth of its corners.
    pub(crate) at: [[f32; 3]; 3],
    /// The lit colour at its corners, or the factor of the texture.
    pub(crate) color: [[f32; 3]; 3],
    pub(crate) cover: Cover,
    /// The height over the edge opposite to each corner, in samples; infinite for edges that are
    /// not drawn.
    pub(crate) heights: [f32; 3],
}

/// How the colours of the corners cover a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Cover {
    /// Blended between the corners.
    Blended,
    /// Each place has the colour of its nearest corner, which is not lit yet; this is the light at the corners.
    Nearest([f32; 3]),
    /// Blended, times a picture of the texture at these places.
    Picture(u32, [[f32; 2]; 3]),
}

/// Input of the rasteriser besides triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Canvas<'a> {
    /// In pixels.
    pub(crate) size: [u32; 2],
    /// Samples per pixel and direction.
    pub(crate) supersampling: u32,
    /// Half the width of an edge, in samples.
    pub(crate) line: f32,
    pub(crate) texture: Option<&'a Texture>,
    pub(crate) background: Option<[u8; 3]>,
}

/// The pixels of a picture of the triangles.
pub(crate) fn rasterize(canvas: &Canvas<'_>, triangles: &[Triangle]) -> Vec<[u8; 4]> {
    let bands = canvas.size[1].div_ceil(BAND);
    let bins = Bins::new(canvas, triangles, bands as usize);
    let draw = |band: usize| canvas.draw_band(as_u32(band), bins.of(band), triangles);
    mesh_core::parallel::collect_each(bands as usize, draw).concat()
}

/// Whether each triangle is seen in any sample.
pub(crate) fn visible(canvas: &Canvas<'_>, triangles: &[Triangle]) -> Vec<bool> {
    let bands = canvas.size[1].div_ceil(BAND);
    let bins = Bins::new(canvas, triangles, bands as usize);
    let seen = |band: usize| canvas.seen_in_band(as_u32(band), bins.of(band), triangles);
    let mut visible = vec![false; triangles.len()];
    for index in mesh_core::parallel::collect_each(bands as usize, seen).concat() {
        visible[index as usize] = true;
    }
    visible
}

/// The depth of each pixel, of the nearest of its samples; infinite where nothing is drawn.
pub(crate) fn depths(canvas: &Canvas<'_>, triangles: &[Triangle]) -> Vec<f32> {
    let bands = canvas.size[1].div_ceil(BAND);
    let bins = Bins::new(canvas, triangles, bands as usize);
    let depths = |band: usize| canvas.depths_in_band(as_u32(band), bins.of(band), triangles);
    mesh_core::parallel::collect_each(bands as usize, depths).concat()
}

/// The triangles that touch each band.
struct Bins {
    starts: Vec<usize>,
    members: Vec<u32>,
}

impl Bins {
    fn new(canvas: &Canvas<'_>, triangles: &[Triangle], bands: usize) -> Self {
        let rows = (BAND * canvas.supersampling) as f32;
        let touched = |t: &Triangle| {
            let [low, high] = extent(t.at.map(|p| p[1]));
            let band = |row: f32| ((row / rows).max(0.0) as usize).min(bands);
            if high < 0.0 { 0..0 } else { band(low)..(band(high) + 1).min(bands) }
        };
        let mut starts = vec![0; bands + 1];
        for band in triangles.iter().flat_map(touched) {
            starts[band + 1] += 1;
        }
        for band in 0..bands {
            starts[band + 1] += starts[band];
        }
        let mut next = starts.clone();
        let mut members = vec![0; starts[bands]];
        for (index, triangle) in triangles.iter().enumerate() {
            for band in touched(triangle) {
                members[next[band]] = as_u32(index);
                next[band] += 1;
            }
        }
        Self { starts, members }
    }

    fn of(&self, band: usize) -> &[u32] {
        &self.members[self.starts[band]..self.starts[band + 1]]
    }
}

fn extent(values: [f32; 3]) -> [f32; 2] {
    let [a, b, c] = values;
    [a.min(b).min(c), a.max(b).max(c)]
}

/// The samples of a band.
struct Samples<T> {
    /// The first row, and one past the last.
    rows: [u32; 2],
    width: u32,
    /// Depth, infinite where nothing was drawn.
    depth: Vec<f32>,
    /// What is seen: a colour, or the index of a triangle.
    seen: Vec<T>,
}

impl Canvas<'_> {
    fn samples<T: Clone>(&self, band: u32, nothing: T) -> Samples<T> {
        let rows = [band * BAND, ((band + 1) * BAND).min(self.size[1])];
        let width = self.size[0] * self.supersampling;
        let rows = rows.map(|row| row * self.supersampling);
        let count = width as usize * (rows[1] - rows[0]) as usize;
        Samples { rows, width, depth: vec![f32::INFINITY; count], seen: vec![nothing; count] }
    }

    fn draw_band(&self, band: u32, members: &[u32], triangles: &[Triangle]) -> Vec<[u8; 4]> {
        let mut samples = self.samples(band, [0.0; 3]);
        for &member in members {
            let triangle = &triangles[member as usize];
            draw_triangle(triangle, &mut samples, |weights| self.shade(triangle, weights));
        }
        self.average_down(&samples)
    }

    /// The triangles that are seen in a band, each once.
    fn seen_in_band(&self, band: u32, members: &[u32], triangles: &[Triangle]) -> Vec<u32> {
        let mut samples = self.samples(band, u32::MAX);
        for &member in members {
            let triangle = &triangles[member as usize];
            let index = |weights| self.shade(triangle, weights).map(|_| member);
            draw_triangle(triangle, &mut samples, index);
        }
        let mut seen = samples.seen;
        seen.retain(|&index| index != u32::MAX);
        seen.sort_unstable();
        seen.dedup();
        seen
    }

    fn depths_in_band(&self, band: u32, members: &[u32], triangles: &[Triangle]) -> Vec<f32> {
        let mut samples = self.samples(band, ());
        for &member in members {
            let triangle = &triangles[member as usize];
            draw_triangle(triangle, &mut samples, |weights| {
                self.shade(triangle, weights).map(|_| ())
            });
        }
        let n = self.supersampling as usize;
        let (stride, columns) = (samples.width as usize, self.size[0] as usize);
        let rows = samples.depth.chunks_exact(n * stride);
        let nearest = |rows: &[f32], column: usize| {
            let samples = rows.chunks_exact(stride).flat_map(|row| &row[column * n..][..n]);
            samples.copied().fold(f32::INFINITY, f32::min)
        };
        rows.flat_map(|rows| (0..columns).map(move |column| nearest(rows, column))).collect()
    }

    /// The colour at a place of a triangle; `None` if the texture is cut out there.
    pub(crate) fn shade(&self, triangle: &Triangle, weights: [f32; 3]) -> Option<[f32; 3]> {
        let to_edges = [0, 1, 2].map(|i| weights[i] * triangle.heights[i]);
        let nearest = to_edges.into_iter().fold(f32::INFINITY, f32::min);
        if nearest < self.line {
            return Some(EDGE);
        }
        let color = mix(triangle.color, weights);
        match (triangle.cover, self.texture) {
            (Cover::Picture(image, uvs), Some(texture)) => {
                let texel = texture.sample(image, mix(uvs, weights))?;
                Some([0, 1, 2].map(|i| color[i] * texel[i]))
            }
            (Cover::Nearest(light), _) => {
                let [light] = mix(light.map(|l| [l]), weights);
                Some(triangle.color[nearest_corner(weights)].map(|c| c * light))
            }
            _ => Some(color),
        }
    }

    fn average_down(&self, samples: &Samples<[f32; 3]>) -> Vec<[u8; 4]> {
        let n = self.supersampling as usize;
        let stride = samples.width as usize;
        let rows = (samples.rows[1] - samples.rows[0]) as usize / n;
        let mut pixels = Vec::with_capacity(rows * self.size[0] as usize);
        for row in 0..rows {
            for column in 0..self.size[0] as usize {
                let mut total = [0.0; 3];
                let mut covered = 0.0;
                for sample_row in row * n..(row + 1) * n {
                    let start = sample_row * stride + column * n;
                    for sample in start..start + n {
                        if samples.depth[sample] < f32::INFINITY {
                            covered += 1.0;
                            let color = samples.seen[sample];
                            for (sum, value) in total.iter_mut().zip(color) {
                                *sum += value.clamp(0.0, 1.0);
                            }
                        }
                    }
                }
                pixels.push(self.over_background(total, covered, (n * n) as f32));
            }
        }
        pixels
    }

    fn over_background(&self, total: [f32; 3], covered: f32, count: f32) -> [u8; 4] {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 255")]
        let byte = |c: f32| (255.0 * c).round().clamp(0.0, 255.0) as u8;
        let (alpha, [r, g, b]) = match self.background {
            Some(color) => {
                let behind = color.map(|c| f32::from(c) / 255.0 * (count - covered));
                (1.0, [0, 1, 2].map(|i| (total[i] + behind[i]) / count))
            }
            None => (covered / count, total.map(|sum| sum / covered.max(1.0))),
        };
        [byte(r), byte(g), byte(b), byte(alpha)]
    }
}

/// Draws every sample whose middle is in the triangle, including its edges, so that neighbours leave no gap. `seen`
/// gives what is seen at a place, from the weights of the corners; `None` where the triangle has a hole.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a cast of a float beyond the range gives its end"
)]
fn draw_triangle<T>(
    triangle: &Triangle,
    samples: &mut Samples<T>,
    seen: impl Fn([f32; 3]) -> Option<T>,
) {
    let at = triangle.at.map(|p| p.map(f64::from));
    let double_area = cross(at[0], at[1], at[2]);
    // Seen edge-on, or NaN.
    if double_area.is_nan() || double_area.abs() <= 1e-9 {
        return;
    }
    let [left, right] = extent(triangle.at.map(|p| p[0]));
    let [top, bottom] = extent(triangle.at.map(|p| p[1]));
    let columns = (left - 0.5).ceil().max(0.0) as u32
        ..((right - 0.5).floor() + 1.0).clamp(0.0, samples.width as f32) as u32;
    let first = ((top - 0.5).ceil().max(0.0) as u32).max(samples.rows[0]);
    let last = ((bottom - 0.5).floor() + 1.0).max(0.0) as u32;
    for row in first..last.min(samples.rows[1]) {
        let start = (row - samples.rows[0]) as usize * samples.width as usize;
        for column in columns_of_row(&at, f64::from(row) + 0.5, &columns) {
            let p = [f64::from(column) + 0.5, f64::from(row) + 0.5, 0.0];
            let weight = |i: usize| cross(p, at[(i + 1) % 3], at[(i + 2) % 3]) / double_area;
            let weights = [weight(0), weight(1), weight(2)];
            if weights.iter().any(|&w| w < 0.0) {
                continue;
            }
            let weights = weights.map(|w| w as f32);
            let depth = mix(triangle.at.map(|p| [p[2]]), weights)[0];
            let index = start + column as usize;
            if depth < samples.depth[index]
                && let Some(value) = seen(weights)
            {
                samples.depth[index] = depth;
                samples.seen[index] = value;
            }
        }
    }
}

/// The columns of a box between the sides of its triangle at a height, and at least two more on either side for rounding.
/// In each row, a long thin triangle covers few of the columns of its box.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a cast of a float beyond the range gives its end"
)]
fn columns_of_row(at: &[[f64; 3]; 3], height: f64, columns: &Range<u32>) -> Range<u32> {
    if columns.len() <= FEW {
        return columns.clone();
    }
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    let largest = at.iter().fold(0.0, |largest: f64, p| largest.max(p[0].abs()));
    let slack = 2.0 + 1e-12 * largest;
    for i in 0..3 {
        let ([px, py, _], [qx, qy, _]) = (at[i], at[(i + 1) % 3]);
        if (py <= height) != (qy <= height) {
            let x = px + (height - py) / (qy - py) * (qx - px);
            (left, right) = (left.min(x), right.max(x));
        }
    }
    // The row touches a corner at most.
    if left > right {
        return columns.clone();
    }
    let [from, to] = [left - slack, right + slack + 1.0].map(|x| x.max(0.0) as u32);
    columns.start.max(from)..columns.end.min(to)
}

/// Twice the signed area of a triangle on the screen.
fn cross([ax, ay, _]: [f64; 3], [bx, by, _]: [f64; 3], [cx, cy, _]: [f64; 3]) -> f64 {
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

/// The corner with the largest weight, the first of equal ones.
fn nearest_corner([a, b, c]: [f32; 3]) -> usize {
    if a >= b && a >= c {
        0
    } else if b >= c {
        1
    } else {
        2
    }
}

fn mix<const N: usize>(values: [[f32; N]; 3], [a, b, c]: [f32; 3]) -> [f32; N] {
    core::array::from_fn(|i| {
        // If a weight is zero, the value may be infinite.
        values[0][i] * a + values[1][i] * b + values[2][i] * c
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(at: [[f32; 2]; 3], depth: f32, color: [f32; 3]) -> Triangle {
        Triangle {
            at: at.map(|[x, y]| [x, y, depth]),
            color: [color; 3],
            cover: Cover::Blended,
            heights: [f32::INFINITY; 3],
        }
    }

    /// No sample inside a triangle is outside of the columns of its row, and needles have few of them.
    #[test]
    fn the_columns_of_a_row_contain_all_samples_of_the_triangle() {
        let mut random = mesh_core::SplitMix64::new(7);
        let mut coordinate = |size: f64| 50.0 + size * random.symmetric();
        for round in 0..400 {
            let size = [3.0, 60.0, 1e5, 1e12][round % 4];
            let mut at = [(); 3]
                .map(|()| [f64::from(coordinate(size) as f32), coordinate(size).round(), 0.0]);
            if round % 3 == 0 {
                at[2] = [at[1][0] + 0.5, at[1][1] + 0.25, 0.0];
            }
            let double_area = cross(at[0], at[1], at[2]);
            for row in 0..100 {
                let height = f64::from(row) + 0.5 * f64::from(round as u32 % 2);
                let found = columns_of_row(&at, height, &(0..100));
                for column in 0..100 {
                    let p = [f64::from(column) + 0.5, height, 0.0];
                    let weight =
                        |i: usize| cross(p, at[(i + 1) % 3], at[(i + 2) % 3]) / double_area;
                    let is_inside = (0..3).all(|i| weight(i) >= 0.0);
                    assert!(!is_inside || found.contains(&column), "{at:?} {height} {column}");
                }
            }
        }
        let needle = [[0.0, 0.0, 0.0], [100.0, 50.0, 0.0], [100.0, 50.2, 0.0]];
        assert!(columns_of_row(&needle, 20.5, &(0..100)).len() < 10);
    }

    fn canvas(supersampling: u32, background: Option<[u8; 3]>) -> Canvas<'static> {
        Canvas { size: [40, 50], supersampling, line: 0.0, texture: None, background }
    }

    #[test]
    fn a_square_of_two_triangles_has_no_gap_and_its_exact_area() {
        let [a, b, c, d] = [[5.0, 7.0], [35.0, 7.0], [35.0, 43.0], [5.0, 43.0]];
        let red = [1.0, 0.0, 0.0];
        let pixels =
            rasterize(&canvas(1, None), &[flat([a, b, c], 0.0, red), flat([a, c, d], 0.0, red)]);
        assert_eq!(pixels.iter().filter(|p| p[3] == 255).count(), 30 * 36);
        assert_eq!(pixels.iter().filter(|p| p[3] == 0).count(), 40 * 50 - 30 * 36);
    }

    #[test]
    fn the_nearer_triangle_wins_in_any_order() {
        let all = [[-100.0, -100.0], [400.0, -100.0], [-100.0, 400.0]];
        let near = flat(all, -0.5, [0.0, 1.0, 0.0]);
        let far = flat(all, 0.5, [1.0, 0.0, 0.0]);
        for triangles in [[near, far], [far, near]] {
            let pixels = rasterize(&canvas(2, Some([255; 3])), &triangles);
            assert!(pixels.iter().all(|&p| p == [0, 255, 0, 255]));
        }
    }

    #[test]
    fn half_covered_pixels_are_half_transparent() {
        let triangles = [
            flat([[0.0, 0.0], [1.0, 0.0], [1.0, 200.0]], 0.0, [1.0; 3]),
            flat([[0.0, 0.0], [1.0, 200.0], [0.0, 200.0]], 0.0, [1.0; 3]),
        ];
        let pixels = rasterize(&canvas(2, None), &triangles);
        assert_eq!(pixels[0], [255, 255, 255, 128]);
        assert_eq!(pixels[1], [0, 0, 0, 0]);
    }

    #[test]
    fn triangles_out_of_bounds_or_without_area_draw_nothing() {
        let far = f32::MAX;
        let odd = [
            flat([[far, far], [far, -far], [-far, far]], f32::NAN, [1.0; 3]),
            flat([[f32::NAN; 2]; 3], 0.0, [1.0; 3]),
            flat([[3.0, 3.0]; 3], 0.0, [1.0; 3]),
            flat([[-9.0, -9.0], [-5.0, -9.0], [-9.0, -3.0]], 0.0, [1.0; 3]),
        ];
        assert!(rasterize(&canvas(2, None), &odd).iter().all(|p| p[3] == 0));
    }
}
