//! The distance between two surfaces that need not fit into memory.
//!
//! A k-d tree over the vertices of the target surface divides space into cells. Each cell gets the triangles whose
//! boxes intersect it. A point is first measured against the triangles of its own cell. If no other cell is closer than
//! the closest point found there, that is its distance. Otherwise the search continues in the closer cells, in
//! ascending order, so that each cell is in memory at most twice. The search is exact: distances refer to the whole
//! surface.

use core::ops::ControlFlow;

use glam::DVec3;
use mesh_core::{BoundingBox, as_u32};
use mesh_metric::{
    CompareOptions, Comparison, OneSided, SampleStream, Surface, Worst, area_of, points_of_edge,
};

use crate::cells::Cells;
use crate::disk_mesh::DiskMesh;
use crate::error::Error;
use crate::ingest::{Ingested, MOST_FILES};
use crate::scratch_file::{ScratchFile, ScratchReader, ScratchWriter, point_bytes, point_of};
use crate::step::Step;

/// The bytes that a triangle takes while points are measured against it.
const PER_FACE: u64 = 330;
/// The number of points in one query.
const AT_A_TIME: usize = 1 << 15;

/// Measures the distances between two surfaces as [`mesh_metric::compare`] does. The sample points and their distances
/// are the same. Sums are formed in another order, so that means may differ in their last digits.
///
/// # Errors
/// A surface has no faces, or a face with a missing vertex; the files cannot be read or written; the memory limit is
/// too small.
pub fn distance(
    first: &DiskMesh,
    second: &DiskMesh,
    options: &CompareOptions,
    observer: &mut dyn FnMut(Step) -> bool,
) -> Result<Comparison, Error> {
    let mut one_sided = |from: &DiskMesh, to: &DiskMesh, level| {
        let target = Target::new(to)?;
        Probe { from, target, options, level, observer: &mut *observer }.measure()
    };
    Ok(Comparison { forward: one_sided(first, second, 0)?, backward: one_sided(second, first, 1)? })
}

/// The surface that distances are measured to, by cells.
struct Target<'t> {
    disk_mesh: &'t DiskMesh,
    cells: Cells,
    boxes: Vec<BoundingBox>,
    triangles: Vec<Option<ScratchFile>>,
}

impl<'t> Target<'t> {
    fn new(disk_mesh: &'t DiskMesh) -> Result<Self, Error> {
        let DiskMesh { ingested, memory, folder } = disk_mesh;
        let depth = memory.depth(ingested.summary.triangles, PER_FACE)?;
        if 1 << depth > u64::from(MOST_FILES) {
            return Err(
                memory.too_little(ingested.summary.triangles * PER_FACE / u64::from(MOST_FILES))
            );
        }
        let cells = Cells::new(ingested.sample.clone(), depth);
        let mut sinks = Vec::new();
        for cell in 0..cells.count() {
            sinks.push(ScratchWriter::new(folder.join(format!("cell-{cell}-triangles")))?);
        }
        ingested.each_triangle(memory.stream(), |_, corners| {
            let low = corners[0].min(corners[1]).min(corners[2]);
            let high = corners[0].max(corners[1]).max(corners[2]);
            let mut put = Ok(());
            let _ = cells.each_cell_of(low, high, &mut |cell| {
                put = corners
                    .iter()
                    .try_for_each(|&corner| sinks[cell as usize].put(&point_bytes(corner)));
                if put.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            });
            put
        })?;
        let mut triangles = Vec::new();
        for sink in sinks {
            let is_empty = sink.len() == 0;
            let scratch = sink.finish()?;
            triangles.push((!is_empty).then_some(scratch));
        }
        if triangles.iter().all(Option::is_none) {
            return Err(mesh_metric::SurfaceError::Empty.into());
        }
        let boxes = (0..cells.count()).map(|cell| cells.bounds(cell)).collect();
        Ok(Self { disk_mesh, cells, boxes, triangles })
    }

    /// The cell in which a point is measured first: its own cell, or the closest cell with triangles.
    fn home(&self, point: DVec3) -> u32 {
        let own = self.cells.cell_of(point);
        if self.triangles[own as usize].is_some() {
            return own;
        }
        let distance = |&cell: &u32| squared_distance(&self.boxes[cell as usize], point);
        let there = (0..self.cells.count()).filter(|&cell| self.triangles[cell as usize].is_some());
        there.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(own)
    }

    /// The next cell that may have a closer point.
    fn next(&self, from: u32, home: u32, point: DVec3, than: f64) -> Option<u32> {
        (from..self.cells.count()).find(|&cell| {
            cell != home
                && self.triangles[cell as usize].is_some()
                && squared_distance(&self.boxes[cell as usize], point) <= than * than * SLACK
        })
    }

    fn surface(&self, cell: u32) -> Result<Surface, Error> {
        let Some(scratch) = &self.triangles[cell as usize] else {
            return Err(mesh_metric::SurfaceError::Empty.into());
        };
        let mut positions: Vec<DVec3> = Vec::new();
        let mut source = scratch.reader()?;
        while let Some(point) = source.next()? {
            positions.push(point_of(&point));
        }
        let faces = positions.len() / 3;
        // Three corners for each face: this bound makes numbers of corners fit into 32 bits.
        if positions.len() > u32::MAX as usize {
            return Err(Error::RegionTooLarge { faces: faces as u64 });
        }
        let triangles: Vec<[u32; 3]> =
            (0..as_u32(faces)).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
        Ok(Surface::from_triangles(&positions, &triangles)?)
    }
}

/// An upper bound of the relative rounding error of a squared distance.
const SLACK: f64 = 1.0 + 1e-12;

/// The squared distance of a point from a box, which may be infinite.
fn squared_distance(bounds: &BoundingBox, point: DVec3) -> f64 {
    (bounds.min - point).max(point - bounds.max).max(DVec3::ZERO).length_squared()
}

/// A point whose distance is measured.
#[derive(Clone, Copy)]
struct Point {
    at: DVec3,
    /// Whether it counts for the mean. Otherwise it counts only for the maximum.
    is_sample: bool,
    home: u32,
    /// The vector to the closest point so far, and its length.
    offset: DVec3,
    distance: f64,
}

impl Point {
    fn put(&self, to: &mut ScratchWriter) -> Result<(), Error> {
        to.put(&[u8::from(self.is_sample)])?;
        to.put(&self.home.to_le_bytes())?;
        to.put(&point_bytes(self.at))?;
        to.put(&point_bytes(self.offset))?;
        to.put(&self.distance.to_le_bytes())
    }

    fn get(source: &mut ScratchReader<'_>) -> Result<Option<Self>, Error> {
        let Some([is_sample]) = source.next()? else { return Ok(None) };
        Ok(Some(Self {
            is_sample: is_sample != 0,
            home: u32::from_le_bytes(source.expect()?),
            at: point_of(&source.expect()?),
            offset: point_of(&source.expect()?),
            distance: f64::from_le_bytes(source.expect()?),
        }))
    }
}

/// Sums and maxima of distances.
#[derive(Clone, Copy)]
struct Tally {
    samples: usize,
    sum: f64,
    squares: f64,
    others: usize,
    other_sum: f64,
    other_squares: f64,
    largest: f64,
    worst: Worst,
}

impl Tally {
    fn add(&mut self, point: &Point) {
        let distance = point.distance;
        if point.is_sample {
            self.samples += 1;
            self.sum += distance;
            self.squares += distance * distance;
        } else {
            self.others += 1;
            self.other_sum += distance;
            self.other_squares += distance * distance;
        }
        if distance > self.largest {
            self.largest = distance;
            self.worst = Worst { from: point.at, to: point.at + point.offset };
        }
    }

    fn finish(self) -> OneSided {
        // A surface without area has sample points only at vertices and edges.
        let (count, sum, squares) = if self.samples > 0 {
            (self.samples, self.sum, self.squares)
        } else {
            (self.others, self.other_sum, self.other_squares)
        };
        let by = count.max(1) as f64;
        OneSided {
            mean: sum / by,
            rms: (squares / by).sqrt(),
            max: self.largest.max(0.0),
            worst: self.worst,
            samples: self.samples + self.others,
        }
    }
}

/// The measurement from one surface to another one.
struct Probe<'p> {
    from: &'p DiskMesh,
    target: Target<'p>,
    options: &'p CompareOptions,
    level: u32,
    observer: &'p mut dyn FnMut(Step) -> bool,
}

impl Probe<'_> {
    fn measure(self) -> Result<OneSided, Error> {
        let cells = self.target.cells.count();
        let folder = self.target.disk_mesh.folder.clone();
        let files = |kind: &str| -> Result<Vec<Option<ScratchWriter>>, Error> {
            (0..cells)
                .map(|cell| {
                    ScratchWriter::new(folder.join(format!("cell-{cell}-{kind}"))).map(Some)
                })
                .collect()
        };
        let (mut other_cells, mut visits) = (files("points")?, files("visits")?);
        self.each_point(&mut |at, is_sample| {
            let home = self.target.home(at);
            let point = Point { at, is_sample, home, offset: DVec3::ZERO, distance: f64::INFINITY };
            other_cells[home as usize].as_mut().map_or(Ok(()), |sink| point.put(sink))
        })?;
        let mut tally = Tally {
            samples: 0,
            sum: 0.0,
            squares: 0.0,
            others: 0,
            other_sum: 0.0,
            other_squares: 0.0,
            largest: -1.0,
            worst: Worst { from: DVec3::ZERO, to: DVec3::ZERO },
        };
        for round in 0..2 {
            for cell in 0..cells {
                let sinks = if round == 0 { &mut other_cells } else { &mut visits };
                let Some(sink) = sinks[cell as usize].take() else { continue };
                if sink.len() > 0 {
                    self.in_cell(cell, &sink.finish()?, round == 0, &mut visits, &mut tally)?;
                }
                let done = u64::from(round * cells + cell) + 1;
                let of = 2 * u64::from(cells);
                if !(self.observer)(Step { what: "measuring", done, of, level: self.level }) {
                    return Err(Error::Stopped);
                }
            }
        }
        Ok(tally.finish())
    }

    /// Measures points against the triangles of a cell.
    fn in_cell(
        &self,
        cell: u32,
        points: &ScratchFile,
        is_home: bool,
        visits: &mut [Option<ScratchWriter>],
        tally: &mut Tally,
    ) -> Result<(), Error> {
        let surface = self.target.surface(cell)?;
        let mut source = points.reader()?;
        let mut batch = Vec::new();
        loop {
            batch.clear();
            while batch.len() < AT_A_TIME
                && let Some(point) = Point::get(&mut source)?
            {
                batch.push(point);
            }
            if batch.is_empty() {
                return Ok(());
            }
            let places: Vec<DVec3> = batch.iter().map(|point| point.at).collect();
            if is_home {
                for (point, found) in batch.iter_mut().zip(surface.closest_points(&places)) {
                    (point.offset, point.distance) = (found.offset, found.distance);
                }
            } else {
                let than: Vec<f64> = batch.iter().map(|point| point.distance).collect();
                let found = surface.closer_points(&places, &than);
                for (point, found) in batch.iter_mut().zip(found) {
                    if let Some(found) = found {
                        (point.offset, point.distance) = (found.offset, found.distance);
                    }
                }
            }
            let first = if is_home { 0 } else { cell + 1 };
            for point in &batch {
                match self.target.next(first, point.home, point.at, point.distance) {
                    Some(next) => {
                        if let Some(sink) = &mut visits[next as usize] {
                            point.put(sink)?;
                        }
                    }
                    None => tally.add(point),
                }
            }
        }
    }

    /// Calls `take` with each point to measure, and whether it counts for the mean.
    fn each_point(
        &self,
        take: &mut dyn FnMut(DVec3, bool) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let DiskMesh { ingested, memory, .. } = self.from;
        let CompareOptions { samples, vertices, edges, seed } = *self.options;
        let stream = memory.stream();
        let (mut area, mut triangles) = (0.0, 0_u64);
        let mut is_used = vec![0_u64; if vertices { bits_of(ingested) } else { 0 }];
        ingested.each_triangle(stream, |ids, corners| {
            area += area_of(corners);
            triangles += 1;
            if vertices {
                ids.iter().for_each(|&v| is_used[(v / 64) as usize] |= 1 << (v % 64));
            }
            Ok(())
        })?;
        if triangles == 0 {
            return Err(mesh_metric::SurfaceError::Empty.into());
        }
        let spacing = (area / samples.max(1) as f64).sqrt();
        let mut line = SampleStream::new(area, samples, seed);
        let (mut passed, mut result) = (0, Ok(()));
        ingested.each_triangle(stream, |[a, b, c], corners| {
            passed += 1;
            line.pass(corners, passed == triangles, &mut |point| {
                if result.is_ok() {
                    result = take(point, true);
                }
            });
            core::mem::replace(&mut result, Ok(()))?;
            if !edges {
                return Ok(());
            }
            let [p, q, r] = corners;
            for (from, to) in [((a, p), (b, q)), ((b, q), (c, r)), ((c, r), (a, p))] {
                // From the vertex with the lower index, so that both faces of an edge give the same points.
                let (low, high) = if from.0 < to.0 { (from, to) } else { (to, from) };
                points_of_edge([low.1, high.1], spacing, samples)
                    .try_for_each(|point| take(point, false))?;
            }
            Ok(())
        })?;
        if vertices {
            ingested.each_vertex(|v, point| {
                let is_used = is_used[(v / 64) as usize] >> (v % 64) & 1 == 1;
                if is_used { take(point, false) } else { Ok(()) }
            })?;
        }
        Ok(())
    }
}

/// The number of words of 64 bits for one bit for each vertex.
fn bits_of(ingested: &Ingested) -> usize {
    ingested.summary.vertices.div_ceil(64) as usize
}
