//! Writing a mesh on disk to a file of another format, as a stream.

use std::io::Write;
use std::path::Path;

use mesh_io::{
    Format, NO_COLOR, Passer, Passing, Staged, WriteOptions, WriteReport, stage_passing,
    write_passing,
};

use crate::disk_mesh::DiskMesh;
use crate::error::Error;
use crate::scratch_file::point_of;
use crate::vertex_scalars::VertexScalars;

/// Scalars and colours that vertices are written with.
#[derive(Clone, Copy)]
pub struct Columns<'c> {
    /// The scalars.
    pub numbers: &'c VertexScalars,
    /// The names of the columns.
    pub names: &'c [&'c str],
    /// The colour of a vertex, from its scalars.
    pub color: &'c dyn Fn(&[f64]) -> [u8; 4],
}

impl DiskMesh {
    /// Writes the mesh as PLY, STL or OBJ. The file appears at its path when it is committed. With scalars, polygons
    /// are cut into triangles.
    ///
    /// # Errors
    /// The file cannot be written, the format is not supported or cannot hold so many elements, or a face uses a
    /// missing vertex.
    pub fn stage(
        &self,
        path: &Path,
        options: &WriteOptions,
        columns: Option<Columns<'_>>,
    ) -> Result<Staged, Error> {
        let mut failed = None;
        let content = |out: &mut Passer<'_>| self.pass(out, columns, &mut failed);
        let staged = stage_passing(path, &self.passing(columns), options, content);
        failed.map_or_else(|| Ok(staged?), Err)
    }

    /// As [`DiskMesh::stage`], to a stream, which should be buffered.
    ///
    /// # Errors
    /// As [`DiskMesh::stage`]; part of the file may have been written.
    pub fn write_to(
        &self,
        writer: &mut dyn Write,
        format: Format,
        options: &WriteOptions,
        columns: Option<Columns<'_>>,
    ) -> Result<WriteReport, Error> {
        let mut failed = None;
        let content = |out: &mut Passer<'_>| self.pass(out, columns, &mut failed);
        let written = write_passing(writer, &self.passing(columns), format, options, content);
        failed.map_or_else(|| Ok(written?), Err)
    }

    fn passing(&self, columns: Option<Columns<'_>>) -> Passing {
        let summary = self.summary();
        let mut passing = Passing {
            vertices: summary.vertices,
            faces: summary.faces,
            triangles: summary.triangles,
            longest: summary.longest,
            single: summary.single,
            ..Passing::default()
        };
        if let Some(Columns { numbers, names, .. }) = columns {
            (passing.faces, passing.longest, passing.colors) = (summary.triangles, 3, true);
            let names = names.iter().map(|&name| name.to_owned());
            passing.scalars = names.zip(numbers.single().iter().copied()).collect();
        }
        passing
    }

    /// Passes vertices and faces to a writer. Errors that do not come from the writer go to `failed`.
    fn pass(
        &self,
        out: &mut Passer<'_>,
        columns: Option<Columns<'_>>,
        failed: &mut Option<Error>,
    ) -> std::io::Result<()> {
        let mut written = Ok(());
        // Errors of the writer end the streams below with `Stopped`.
        let mut put = |result: std::io::Result<()>| {
            result.map_err(|error| {
                written = Err(error);
                Error::Stopped
            })
        };
        let passed = match columns {
            None => self.ingested.each_vertex(|_, at| put(out.vertex(at, NO_COLOR, &[]))).and_then(
                |()| {
                    self.ingested.each_face(self.memory.stream(), |vertices, corners| {
                        put(out.face(vertices, corners))
                    })
                },
            ),
            Some(Columns { numbers, color, .. }) => self
                .ingested
                .points
                .reader()
                .and_then(|mut points| {
                    numbers.each_row(self.summary().vertices, |row| {
                        let at = point_of(&points.expect()?);
                        put(out.vertex(at, color(row), row))
                    })
                })
                .and_then(|()| {
                    self.ingested.each_triangle(self.memory.stream(), |vertices, corners| {
                        put(out.face(&vertices, &corners))
                    })
                }),
        };
        written?;
        passed.map_err(|error| {
            *failed = Some(error);
            std::io::ErrorKind::Other.into()
        })
    }
}
