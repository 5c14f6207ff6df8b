//! OBJ, line by line.

use std::path::Path;

use super::super::content::{Complaint, Content};

pub(super) fn read(path: &Path) -> Result<Content, Complaint> {
    let text = String::from_utf8(std::fs::read(path)?)?;
    let mut content = Content::indexed();
    let [mut textures, mut normals] = [0_usize; 2];
    let mut faces: Vec<(usize, &str)> = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let (keyword, rest) = line.trim().split_once([' ', '\t']).unwrap_or((line.trim(), ""));
        let at = |error: &dyn std::fmt::Display| format!("line {}: {error}", number + 1);
        let numbers =
            || rest.split_whitespace().map(str::parse::<f64>).collect::<Result<Vec<_>, _>>();
        match keyword {
            "v" => match *numbers().map_err(|e| at(&e))? {
                [x, y, z, ref colors @ ..] => {
                    content.positions.push([x, y, z]);
                    colors.iter().for_each(|&color| content.see("colour", color));
                }
                _ => return Err(at(&"a vertex of fewer than three coordinates").into()),
            },
            "vt" | "vn" => {
                let what = if keyword == "vt" { "texture coordinate" } else { "normal" };
                numbers().map_err(|e| at(&e))?.iter().for_each(|&x| content.see(what, x));
                *(if keyword == "vt" { &mut textures } else { &mut normals }) += 1;
            }
            "f" => faces.push((number, rest)),
            _ => {}
        }
    }
    let counts = [content.positions.len(), textures, normals];
    for (number, face) in faces {
        let corners = face.split_whitespace().map(|corner| vertex(corner, counts));
        let corners: Result<Vec<u32>, Complaint> = corners.collect();
        content.push_face(corners.map_err(|error| format!("line {}: {error}", number + 1))?);
    }
    Ok(content)
}

/// The vertex of a corner `v/vt/vn`; all its parts must be in range.
fn vertex(corner: &str, counts: [usize; 3]) -> Result<u32, Complaint> {
    let mut vertex = None;
    for ((part, count), what) in
        corner.split('/').zip(counts).zip(["vertex", "texture coordinate", "normal"])
    {
        if part.is_empty() && vertex.is_some() {
            continue;
        }
        let index: i64 = part.parse().map_err(|_| format!("{part:?} is no index"))?;
        let index = if index < 0 { count as i64 + index } else { index - 1 };
        let index = usize::try_from(index).ok().filter(|&index| index < count);
        let index = index.ok_or_else(|| format!("there is no {what} {part}"))?;
        vertex.get_or_insert(index as u32);
    }
    vertex.ok_or_else(|| "an empty corner".into())
}
