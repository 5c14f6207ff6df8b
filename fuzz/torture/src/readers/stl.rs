//! STL, by `stl_io`.

use std::io::Cursor;
use std::path::Path;

use super::super::content::{Complaint, Content};

pub(super) fn read(path: &Path) -> Result<Content, Complaint> {
    let bytes = std::fs::read(path)?;
    let mut content = Content::default();
    for solid in solids(&bytes) {
        for triangle in stl_io::create_stl_reader(&mut Cursor::new(solid))? {
            let triangle = triangle?;
            triangle.normal.0.iter().for_each(|&x| content.see("normal", f64::from(x)));
            let first = content.positions.len() as u32;
            content.positions.extend(triangle.vertices.map(|vertex| vertex.0.map(f64::from)));
            content.push_face(first..first + 3);
        }
    }
    Ok(content)
}

/// The solids of a text file one by one, since the library stops after the first; a binary file unchanged.
fn solids(bytes: &[u8]) -> Vec<&[u8]> {
    let end = b"\nendsolid";
    let is_text = bytes.starts_with(b"solid") && bytes.windows(end.len()).any(|part| part == end);
    if !is_text {
        return vec![bytes];
    }
    let mut starts = vec![0];
    let begin = b"\nsolid";
    starts.extend((0..bytes.len()).filter(|&at| bytes[at..].starts_with(begin)).map(|at| at + 1));
    let ends = starts.iter().skip(1).copied().chain([bytes.len()]);
    starts.iter().zip(ends).map(|(&start, end)| &bytes[start..end]).collect()
}
