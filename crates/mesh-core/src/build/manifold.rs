//! Makes triangles an oriented 2-manifold, or reports why they are not.

use crate::build::cut::{Fans, cut_apart};
use crate::build::draft::Draft;
use crate::build::duplicates::{find_duplicates, without_walls};
use crate::build::edges::{EdgeTable, edge_ends, same_direction};
use crate::build::error::BuildError;
use crate::build::orient::{Orientation, orient};
use crate::build::sample::{Sample, VertexPair};

impl Draft<'_> {
    /// Drops duplicates, orients and cuts where allowed; other defects are errors.
    pub(crate) fn make_manifold(&mut self) -> Result<(), BuildError> {
        self.drop_duplicates()?;
        self.refuse_non_manifold_edges()?;
        self.reorient()?;
        self.cut_non_manifold()
    }

    fn edge_table(&self) -> EdgeTable {
        EdgeTable::new(self.vertex_count(), &self.triangles)
    }

    fn face_source(&self, face: u32) -> u32 {
        self.provenance.face_source[face as usize]
    }

    /// The edge of a side, in vertices of the soup.
    fn edge_source(&self, side: u32) -> VertexPair {
        let [a, b] = edge_ends(&self.triangles, side)
            .map(|vertex| self.provenance.vertex_source[vertex as usize]);
        VertexPair(a.min(b), a.max(b))
    }

    fn drop_duplicates(&mut self) -> Result<(), BuildError> {
        let table = self.edge_table();
        let mut duplicates = find_duplicates(&self.triangles, &table);
        if self.repair.drop_duplicates && self.repair.cut_non_manifold && !duplicates.is_empty() {
            duplicates = without_walls(&duplicates, &self.triangles, &table);
        }
        let Some(first) = duplicates.first() else {
            return Ok(());
        };
        let sources = duplicates.iter().map(|duplicate| self.face_source(duplicate.face));
        if !self.repair.drop_duplicates {
            return Err(BuildError::DuplicateFace {
                face: self.face_source(first.face),
                original: self.face_source(first.original),
                duplicates: sources.collect(),
            });
        }
        self.report.dropped_duplicates = sources.collect();
        let faces: Vec<u32> = duplicates.iter().map(|duplicate| duplicate.face).collect();
        self.remove_triangles(&faces);
        Ok(())
    }

    fn refuse_non_manifold_edges(&self) -> Result<(), BuildError> {
        if self.repair.cut_non_manifold {
            return Ok(());
        }
        let table = self.edge_table();
        let mut crowded = table.iter().filter(|sides| sides.len() > 2);
        let Some(first) = crowded.next() else {
            return Ok(());
        };
        let mut edges = Sample::from_iter([self.edge_source(first[0])]);
        edges.extend(crowded.map(|sides| self.edge_source(sides[0])));
        Err(BuildError::NonManifoldEdge {
            edge: self.edge_source(first[0]),
            faces: first.iter().map(|&side| self.face_source(side / 3)).collect(),
            edges,
        })
    }

    /// Reverses faces until neighbours agree.
    fn reorient(&mut self) -> Result<(), BuildError> {
        let table = self.edge_table();
        let disagreeing: Vec<[u32; 2]> = table
            .iter()
            .filter_map(|sides| <[u32; 2]>::try_from(sides).ok())
            .filter(|&[a, b]| same_direction(&self.triangles, a, b))
            .collect();
        let Some(&first) = disagreeing.first() else {
            return Ok(());
        };
        let Orientation { flipped, conflicts } = orient(&self.triangles, &table);
        if let (Some(&left), false) =
            (conflicts.first(), self.repair.reorient && self.repair.cut_non_manifold)
        {
            return Err(BuildError::NonOrientable {
                edge: self.edge_source(left[0]),
                faces: left.map(|side| self.face_source(side / 3)),
                edges: conflicts.iter().map(|sides| self.edge_source(sides[0])).collect(),
            });
        }
        if !self.repair.reorient {
            return Err(BuildError::InconsistentOrientation {
                edge: self.edge_source(first[0]),
                faces: first.map(|side| self.face_source(side / 3)),
                edges: disagreeing.iter().map(|sides| self.edge_source(sides[0])).collect(),
            });
        }
        self.reverse_faces((0..flipped.len()).filter(|&face| flipped[face]));
        Ok(())
    }

    fn cut_non_manifold(&mut self) -> Result<(), BuildError> {
        let table = self.edge_table();
        if !self.repair.cut_non_manifold {
            return self.refuse_pinched_vertices(&table);
        }
        let is_cut = |sides: &&[u32]| match **sides {
            [_] => false,
            [a, b] => same_direction(&self.triangles, a, b),
            _ => true,
        };
        self.report.cut_edges =
            table.iter().filter(is_cut).map(|sides| self.edge_source(sides[0])).collect();
        let vertex_count = self.vertex_count();
        let (positions, source) = (self.soup.positions(), &self.provenance.vertex_source);
        let position = |vertex: u32| positions[source[vertex as usize] as usize];
        let copies = cut_apart(vertex_count, position, self.triangles.to_mut(), &table);
        let vertex_source = &mut self.provenance.vertex_source;
        vertex_source.extend(
            copies.iter().map(|&vertex| vertex_source[vertex as usize]).collect::<Vec<_>>(),
        );
        self.report.split_vertices = vertex_source[vertex_count..].iter().copied().collect();
        Ok(())
    }

    fn refuse_pinched_vertices(&self, table: &EdgeTable) -> Result<(), BuildError> {
        let pinched = Fans::new(&self.triangles, table).pinched();
        let source = |vertex: u32| self.provenance.vertex_source[vertex as usize];
        match pinched.first() {
            None => Ok(()),
            Some(&(vertex, fans)) => Err(BuildError::PinchedVertex {
                vertex: source(vertex),
                fans,
                vertices: pinched.iter().map(|&(vertex, _)| source(vertex)).collect(),
            }),
        }
    }
}
