//! glTF and GLB, by the crate `gltf`, which checks the document; the data are read here.

use std::path::Path;

use base64::Engine;
use gltf::mesh::Mode;

use super::super::content::{Complaint, Content};

pub(super) fn read(path: &Path) -> Result<Content, Complaint> {
    let gltf::Gltf { document, mut blob } = gltf::Gltf::from_slice(&std::fs::read(path)?)?;
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let bytes = match buffer.source() {
            gltf::buffer::Source::Bin => blob.take().ok_or("a GLB without its binary chunk")?,
            gltf::buffer::Source::Uri(uri) => embedded(uri)?,
        };
        if bytes.len() < buffer.length() {
            return Err(format!("buffer {} is shorter than it says", buffer.index()).into());
        }
        buffers.push(bytes);
    }
    let mut content = Content::default();
    for mesh in document.meshes() {
        for primitive in mesh.primitives() {
            let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
            let positions: Vec<[f32; 3]> = reader.read_positions().ok_or("no positions")?.collect();
            let (first, count) = (content.positions.len() as u32, positions.len() as u32);
            content.positions.extend(positions.iter().map(|position| position.map(f64::from)));
            for normal in reader.read_normals().into_iter().flatten() {
                let length = normal.map(|x| x * x).iter().sum::<f32>().sqrt();
                content.see("normal", f64::from(length));
                if (length - 1.0).abs() > 1e-3 && content.not_finite.is_none() {
                    content.not_finite = Some(format!("normal of length {length}"));
                }
            }
            for uv in reader
                .read_tex_coords(0)
                .into_iter()
                .flat_map(gltf::mesh::util::ReadTexCoords::into_f32)
            {
                uv.iter().for_each(|&x| content.see("texture coordinate", f64::from(x)));
            }
            for color in reader
                .read_colors(0)
                .into_iter()
                .flat_map(gltf::mesh::util::ReadColors::into_rgba_f32)
            {
                color.iter().for_each(|&x| content.see("colour", f64::from(x)));
            }
            if primitive.mode() != Mode::Triangles {
                continue;
            }
            let corners: Vec<u32> = match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None => (0..count).collect(),
            };
            let (triangles, rest) = corners.as_chunks::<3>();
            if let Some(missing) = corners.iter().find(|&&corner| corner >= count) {
                return Err(format!("mesh {} has no vertex {missing}", mesh.index()).into());
            }
            if !rest.is_empty() {
                return Err(format!("mesh {} ends within a triangle", mesh.index()).into());
            }
            // Each node draws its mesh, and all of them are reported.
            let drawn = document.nodes().filter_map(|node| node.mesh());
            let times = drawn.filter(|drawn| drawn.index() == mesh.index()).count();
            for triangle in core::iter::repeat_n(triangles, times.max(1)).flatten() {
                content.push_face(triangle.map(|corner| first + corner));
            }
        }
    }
    Ok(content)
}

/// The bytes of a data URI.
fn embedded(uri: &str) -> Result<Vec<u8>, Complaint> {
    let (_, data) = uri.split_once(";base64,").ok_or("a buffer outside of the file")?;
    Ok(base64::engine::general_purpose::STANDARD.decode(data)?)
}

#[cfg(test)]
mod tests {
    use super::read;
    use mesh_io::{Model, WriteOptions};

    #[test]
    fn an_empty_mesh_is_a_document_that_others_read() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["empty.glb", "empty.gltf"] {
            let path = folder.path().join(name);
            mesh_io::write(&path, &Model::default(), &WriteOptions::default()).unwrap();
            let content = read(&path).map_err(|complaint| complaint.to_string()).unwrap();
            assert!(content.positions.is_empty());
        }
    }
}
