//! Counts of elements and defects of a mesh, region by region.
//!
//! A region holds all faces at its own vertices, which is enough to classify these vertices and their edges. An edge is
//! counted in the lowest of its cells. Connected components extend over many regions. A component gets a number in each
//! region; numbers are merged if their components share a vertex or a face.

use std::path::{Path, PathBuf};

use glam::DVec3;
use mesh_core::build::has_zero_area;
use mesh_core::diagnose::is_sliver;
use mesh_core::disjoint_sets::DisjointSets;
use mesh_core::edge_connectivity::EdgeConnectivity;
use mesh_core::measure::SoupMeasures;
use mesh_core::{BoundingBox, Diagnosis, as_u32, unit_sized_points};

use crate::disk_mesh::DiskMesh;
use crate::error::Error;
use crate::ingest::{MOST_FILES, hash};
use crate::region::Region;
use crate::scratch_file::{ID, ScratchFile, ScratchWriter, id_bytes};
use crate::split::Repairs;
use crate::step::Step;

/// The results of [`mesh_core::diagnose()`] and [`mesh_core::PolygonSoup::measure`] for a mesh that is larger than
/// memory. The counts are the same. Area and volume are summed in another order, and may differ in the last digits.
#[derive(Clone, Debug, Default)]
pub struct Statistics {
    /// Counts of elements and defects.
    pub diagnosis: Diagnosis,
    /// Bounding box, area and volume.
    pub measures: SoupMeasures,
}

/// The bytes per face while its region is classified.
const PER_FACE: u64 = 250;

impl DiskMesh {
    /// Counts the elements and defects of the mesh, and measures it.
    ///
    /// # Errors
    /// A face uses a missing vertex, or the files cannot be read or written.
    pub fn statistics(&self, observer: &mut dyn FnMut(Step) -> bool) -> Result<Statistics, Error> {
        let bounds = self.bounds();
        let corners = bounds.map(|bounds| [bounds.min, bounds.max]);
        let factor = corners.map_or(1.0, |corners| unit_sized_points(&corners).1);
        let mut surveyor = Collector {
            found: Statistics::default(),
            center: bounds.map_or(DVec3::ZERO, |bounds| bounds.center() / factor),
            factor,
            proper: 0,
            used: 0,
            components: Components::new(self.folder.join("components"))?,
            edge_components: Components::new(self.folder.join("edge-components"))?,
            boundaries: Components::new(self.folder.join("boundaries"))?,
        };
        let repairs =
            Repairs { drop_degenerate: true, cut_non_manifold: true, ..Repairs::default() };
        self.each_region(PER_FACE, repairs, observer, &mut |region| surveyor.look_at(&region))?;
        let Collector { mut found, proper, used, components, edge_components, boundaries, .. } =
            surveyor;
        found.measures = found.measures.restored(factor);
        let summary = self.summary();
        let memory = self.memory.stream();
        let diagnosis = &mut found.diagnosis;
        diagnosis.vertices = summary.vertices as usize;
        diagnosis.faces = summary.triangles as usize;
        diagnosis.quadrilaterals = summary.quadrilaterals as usize;
        diagnosis.larger_polygons = summary.larger as usize;
        diagnosis.triangles = (summary.faces - summary.quadrilaterals - summary.larger) as usize;
        diagnosis.repeated_vertex_faces = diagnosis.faces - proper;
        diagnosis.unreferenced_vertices = diagnosis.vertices - used;
        diagnosis.components = components.count(&self.folder, memory)?;
        diagnosis.edge_components = edge_components.count(&self.folder, memory)?;
        diagnosis.boundary_loops = boundaries.count(&self.folder, memory)?;
        diagnosis.euler_characteristic = used as i64 - diagnosis.edges as i64 + proper as i64;
        Ok(found)
    }
}

/// Collects statistics over regions.
struct Collector {
    found: Statistics,
    /// The centre of the mesh, at unit size.
    center: DVec3,
    /// The power of two by which coordinates are divided, so that areas and volumes are numbers.
    factor: f64,
    /// The number of triangles with three different vertices.
    proper: usize,
    /// The number of vertices that these triangles use.
    used: usize,
    components: Components,
    edge_components: Components,
    boundaries: Components,
}

/// The next corner of the same triangle.
fn next(corner: u32) -> u32 {
    if corner % 3 == 2 { corner - 2 } else { corner + 1 }
}

impl Collector {
    fn look_at(&mut self, region: &Region) -> Result<(), Error> {
        self.proper += region.own_face_count();
        self.used += region.own;
        self.measure(region);
        self.count_duplicates(region);
        self.connect(region)
    }

    fn measure(&mut self, region: &Region) {
        let measures = &mut self.found.measures;
        let place = |&p: &DVec3| p / self.factor;
        let points = region.positions[..region.own].iter().map(place);
        let bounds = BoundingBox::of_points(points);
        measures.bounds = match (measures.bounds, bounds) {
            (Some(a), Some(b)) => {
                Some(BoundingBox { min: a.min.min(b.min), max: a.max.max(b.max) })
            }
            (a, b) => a.or(b),
        };
        for triangle in region.own_triangles() {
            let corners = triangle.map(|v| region.positions[v as usize]);
            if has_zero_area(corners) {
                self.found.diagnosis.zero_area_faces += 1;
            } else if is_sliver(corners) {
                self.found.diagnosis.slivers += 1;
            }
            let [a, b, c] = corners.map(|corner| place(&corner) - self.center);
            measures.area += 0.5 * (b - a).cross(c - a).length();
            measures.volume += a.dot(b.cross(c)) / 6.0;
        }
    }

    fn count_duplicates(&mut self, region: &Region) {
        let mut sorted: Vec<[u32; 3]> = region.own_triangles().collect();
        sorted.iter_mut().for_each(|triangle| triangle.sort_unstable());
        sorted.sort_unstable();
        let repeated = sorted.chunk_by(|a, b| a == b).map(|same| same.len() - 1);
        self.found.diagnosis.duplicate_faces += repeated.sum::<usize>();
    }

    fn connect(&mut self, region: &Region) -> Result<(), Error> {
        let corners = region.triangles.as_flattened();
        let vertex_at = |corner: u32| corners[corner as usize];
        // The sides at own vertices: all faces of these edges are in the region. A region has fewer corners than 2^32.
        let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(corners.len());
        for side in 0..as_u32(corners.len()) {
            let [a, b] = [vertex_at(side), vertex_at(next(side))];
            if (a.min(b) as usize) < region.own {
                sides.push(([a.min(b), a.max(b)], side));
            }
        }
        sides.sort_unstable();
        let mut connectivity = EdgeConnectivity::new(region.positions.len(), &region.triangles);
        let mut boundary = DisjointSets::new(region.positions.len());
        let mut at_boundary = vec![false; region.positions.len()];
        let found = &mut self.found.diagnosis;
        for edge in sides.chunk_by(|a, b| a.0 == b.0) {
            let ends = edge[0].0;
            let [from, to] = connectivity.connect(edge.iter().map(|&(_, side)| side));
            if ends.map(|v| region.home(v)).into_iter().min() != Some(region.cell) {
                continue;
            }
            found.edges += 1;
            match edge {
                [_] => {
                    found.boundary_edges += 1;
                    boundary.union(from, to);
                    ends.iter().for_each(|&v| at_boundary[v as usize] = true);
                }
                [_, (_, other)] => {
                    found.inconsistent_edges += usize::from(vertex_at(*other) == from);
                }
                _ => found.non_manifold_edges += 1,
            }
        }
        drop(sides);
        let fans = connectivity.fans(region.own);
        found.non_manifold_vertices += fans.iter().filter(|&&fans| fans > 1).count();
        drop(fans);
        let EdgeConnectivity { mut vertices, mut faces, .. } = connectivity;
        let (by_vertex, by_edge) = (&mut vertices, &mut faces);

        let is_shared = |triangle: &[u32; 3]| triangle.iter().any(|&v| v as usize >= region.own);
        let mut at_rim = vec![false; region.positions.len()];
        for triangle in region.triangles.iter().filter(|triangle| is_shared(triangle)) {
            triangle.iter().for_each(|&v| at_rim[v as usize] = true);
        }
        let vertices = 0..as_u32(region.positions.len());
        let key = |v: u32| key_of([region.vertex_ids[v as usize]]);
        let rim = || vertices.clone().filter(|&v| at_rim[v as usize]);
        self.components.add(by_vertex, vertices.clone(), rim().map(|v| (v, key(v))))?;
        let bounding = || vertices.clone().filter(|&v| at_boundary[v as usize]);
        let shared = bounding().filter(|&v| at_rim[v as usize]).map(|v| (v, key(v)));
        self.boundaries.add(&mut boundary, bounding(), shared)?;
        let faces = 0..as_u32(region.triangles.len());
        let shared = faces.clone().filter(|&f| is_shared(&region.triangles[f as usize]));
        let shared = shared.map(|f| {
            let mut ids = region.triangles[f as usize].map(|v| region.vertex_ids[v as usize]);
            ids.sort_unstable();
            (f, key_of(ids))
        });
        self.edge_components.add(by_edge, faces.clone(), shared)
    }
}

/// The key by which a vertex or a face is recognised in all regions.
type Key = [u8; 3 * ID];

fn key_of<const N: usize>(ids: [u64; N]) -> Key {
    let mut key = [0; 3 * ID];
    for (bytes, id) in key.as_chunks_mut::<ID>().0.iter_mut().zip(ids) {
        *bytes = id_bytes(id);
    }
    key
}

/// Counts connected components over many regions.
struct Components {
    path: PathBuf,
    /// The number of components within one region.
    within: usize,
    /// The numbers of the other components, one for each of their regions.
    numbers: DisjointSets,
    count: u32,
    /// Elements that are in several regions, with the number of their component in one of them.
    shared: ScratchWriter,
}

impl Components {
    fn new(path: PathBuf) -> Result<Self, Error> {
        let shared = ScratchWriter::new(path.clone())?;
        Ok(Self { path, within: 0, numbers: DisjointSets::default(), count: 0, shared })
    }

    /// Adds the components of a region, from all of its elements and from the elements that are in other regions too.
    fn add(
        &mut self,
        sets: &mut DisjointSets,
        elements: impl Iterator<Item = u32> + Clone,
        shared: impl Iterator<Item = (u32, Key)>,
    ) -> Result<(), Error> {
        const NONE: u32 = u32::MAX;
        let most = elements.clone().max().map_or(0, |last| last as usize + 1);
        let mut number = vec![NONE; most];
        for (element, key) in shared {
            let root = sets.find(element) as usize;
            if number[root] == NONE {
                number[root] = self.numbers.push();
                self.count += 1;
            }
            self.shared.put(&key)?;
            self.shared.put(&number[root].to_le_bytes())?;
        }
        let roots = elements.filter(|&element| sets.find(element) == element);
        self.within += roots.filter(|&root| number[root as usize] == NONE).count();
        Ok(())
    }

    /// The number of components.
    fn count(self, folder: &Path, memory: u64) -> Result<usize, Error> {
        let Self { path, within, mut numbers, count, shared } = self;
        let bytes = shared.len();
        let shared = shared.finish()?;
        let files = bytes.div_ceil(memory.max(1 << 20)).clamp(1, u64::from(MOST_FILES));
        let stem = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut files_of = Vec::new();
        for i in 0..files {
            files_of.push(ScratchWriter::new(folder.join(format!("{stem}-{i}")))?);
        }
        let mut source = shared.reader()?;
        while let Some(key) = source.next::<{ 3 * ID }>()? {
            let number: [u8; 4] = source.expect()?;
            let sink = &mut files_of[hash(&key, files)];
            sink.put(&key)?;
            sink.put(&number)?;
        }
        let files_of: Result<Vec<ScratchFile>, Error> =
            files_of.into_iter().map(ScratchWriter::finish).collect();
        for scratch in files_of? {
            let mut all: Vec<(Key, u32)> = Vec::new();
            let mut source = scratch.reader()?;
            while let Some(key) = source.next()? {
                all.push((key, u32::from_le_bytes(source.expect()?)));
            }
            all.sort_unstable();
            for pair in all.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
                numbers.union(pair[0].1, pair[1].1);
            }
        }
        Ok(within + numbers.count_sets(0..count))
    }
}
