//! Collapse logs as bytes, for levels of detail made later or elsewhere; see [`CollapseLog::write`].

use std::io::{ErrorKind, Read, Write};

use glam::DVec3;
use mesh_core::{Checksum, HalfEdgeId, Handle, TriMesh, VertexId, as_u32};

use crate::record::log::{CollapseLog, LogEntry};

const MAGIC: &[u8; 8] = b"CURVLOD1";

/// The reasons why bytes are not a record of a mesh.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The bytes cannot be read or written.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The bytes do not begin with the identifier of a record.
    #[error("this is no record of collapses: it does not begin with CURVLOD1")]
    NoRecord,
    /// The bytes end too early.
    #[error("the record ends within collapse {collapse} of {collapses}")]
    Truncated {
        /// The collapse at which they end.
        collapse: u32,
        /// The expected number of collapses.
        collapses: u32,
    },
    /// The record belongs to a mesh of another size.
    #[error(
        "the record is of a mesh of {vertices} vertices and {faces} faces; read the one that it was made with, with the same repairs"
    )]
    OtherSize {
        /// The vertices of that mesh.
        vertices: u32,
        /// Its faces.
        faces: u32,
    },
    /// The record belongs to another mesh of the same size.
    #[error("the record is of another mesh of the same size")]
    OtherMesh,
    /// The bytes are not those that were written, or they end after the last collapse.
    #[error("the record was cut off or changed after it was written; make it again")]
    Damaged,
    /// A collapse names an element that the mesh does not have, or its position is not finite.
    #[error("collapse {collapse} does not fit the mesh")]
    Misfit {
        /// The collapse.
        collapse: u32,
    },
}

impl CollapseLog {
    /// Writes the log of a run on this mesh. All numbers are little-endian:
    ///
    /// | bytes | what |
    /// |---|---|
    /// | 8 | `CURVLOD1` |
    /// | 4, 4 | vertices and faces of the mesh that the log belongs to |
    /// | 8 | its fingerprint: FNV-1a over the bits of its positions and the indices of its triangles |
    /// | 4 | the number of collapses |
    ///
    /// and for each collapse 48 bytes: the half-edge, the removed vertex, the remaining vertex, the number of faces
    /// before (4 bytes each), the three coordinates of the new position, and the cost (8 bytes each).
    ///
    /// # Errors
    /// The writer fails.
    pub fn write(&self, mesh: &TriMesh, writer: &mut dyn Write) -> std::io::Result<()> {
        let topology = mesh.topology();
        let collapses = u32::try_from(self.len()).map_err(|_| ErrorKind::FileTooLarge)?;
        writer.write_all(MAGIC)?;
        writer.write_all(&as_u32(topology.vertex_count()).to_le_bytes())?;
        writer.write_all(&as_u32(topology.face_count()).to_le_bytes())?;
        writer.write_all(&fingerprint(mesh).to_le_bytes())?;
        writer.write_all(&collapses.to_le_bytes())?;
        for entry in self.entries() {
            let LogEntry { half_edge, removed, kept, position, cost, faces_before } = *entry;
            for number in [half_edge.get(), removed.get(), kept.get(), faces_before] {
                writer.write_all(&number.to_le_bytes())?;
            }
            for number in [position.x, position.y, position.z, cost] {
                writer.write_all(&number.to_le_bytes())?;
            }
        }
        Ok(())
    }

    /// Reads the log of a run on this mesh.
    ///
    /// # Errors
    /// The bytes are not a record, or belong to another mesh. [`CollapseLog::replay`] checks whether each collapse is
    /// legal.
    pub fn read(mesh: &TriMesh, reader: &mut dyn Read) -> Result<Self, RecordError> {
        let topology = mesh.topology();
        if take::<8>(reader, || RecordError::NoRecord)? != *MAGIC {
            return Err(RecordError::NoRecord);
        }
        let [vertices, faces] =
            [take(reader, || RecordError::NoRecord)?, take(reader, || RecordError::NoRecord)?]
                .map(u32::from_le_bytes);
        if [vertices as usize, faces as usize] != [topology.vertex_count(), topology.face_count()] {
            return Err(RecordError::OtherSize { vertices, faces });
        }
        if u64::from_le_bytes(take(reader, || RecordError::NoRecord)?) != fingerprint(mesh) {
            return Err(RecordError::OtherMesh);
        }
        let collapses = u32::from_le_bytes(take(reader, || RecordError::NoRecord)?);
        let mut log = Self::default();
        for collapse in 0..collapses {
            let bytes = take(reader, || RecordError::Truncated { collapse, collapses })?;
            let entry = entry(mesh, &bytes).ok_or(RecordError::Misfit { collapse })?;
            log.push(entry);
        }
        Ok(log)
    }
}

/// The next bytes, or an error if the input ends before.
fn take<const N: usize>(
    reader: &mut dyn Read,
    missing: impl Fn() -> RecordError,
) -> Result<[u8; N], RecordError> {
    let mut bytes = [0; N];
    match reader.read_exact(&mut bytes) {
        Ok(()) => Ok(bytes),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Err(missing()),
        Err(error) => Err(error.into()),
    }
}

fn entry(mesh: &TriMesh, bytes: &[u8; 48]) -> Option<LogEntry> {
    let topology = mesh.topology();
    let (whole, real) = bytes.split_first_chunk::<16>()?;
    let whole: Vec<u32> =
        whole.as_chunks::<4>().0.iter().map(|&chunk| u32::from_le_bytes(chunk)).collect();
    let real: Vec<f64> =
        real.as_chunks::<8>().0.iter().map(|&chunk| f64::from_le_bytes(chunk)).collect();
    let (&[half_edge, removed, kept, faces_before], &[x, y, z, cost]) = (&whole[..], &real[..])
    else {
        return None;
    };
    let position = DVec3::new(x, y, z);
    let in_range = (half_edge as usize) < topology.half_edge_capacity()
        && removed.max(kept) < as_u32(topology.vertex_capacity());
    (in_range && position.is_finite()).then(|| LogEntry {
        half_edge: HalfEdgeId::from_index(half_edge as usize),
        removed: VertexId::new(removed),
        kept: VertexId::new(kept),
        position,
        cost,
        faces_before,
    })
}

/// The checksum of the bits of the positions and the indices of the triangles.
fn fingerprint(mesh: &TriMesh) -> u64 {
    let mut sum = Checksum::default();
    for v in mesh.topology().vertices() {
        mesh.position(v).to_array().iter().for_each(|x| sum.add(&x.to_bits().to_le_bytes()));
    }
    for triangle in mesh.topology().triangles() {
        triangle.iter().for_each(|v| sum.add(&v.to_le_bytes()));
    }
    sum.value()
}
