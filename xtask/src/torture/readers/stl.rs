//! STL, by `stl_io`.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::super::content::{Complaint, Content};

pub(super) fn read(path: &Path) -> Result<Content, Complaint> {
    let mut file = BufReader::new(File::open(path)?);
    let mut content = Content::default();
    for triangle in stl_io::create_stl_reader(&mut file)? {
        let triangle = triangle?;
        triangle.normal.0.iter().for_each(|&x| content.see("normal", f64::from(x)));
        let first = content.positions.len() as u32;
        content.positions.extend(triangle.vertices.map(|vertex| vertex.0.map(f64::from)));
        content.push_face(first..first + 3);
    }
    Ok(content)
}
