//! PLY, by `ply-rs-bw`.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use super::super::content::{Complaint, Content};

/// A vertex or face.
struct Element {
    position: [f64; 3],
    vertices: Vec<u32>,
    /// The reason why this is not a vertex or face.
    complaint: Option<String>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self { position: [f64::NAN; 3], vertices: Vec::new(), complaint: None }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match (name, &property) {
            ("vertex_indices" | "vertex_index", list) => match list.to_u32_list() {
                Some(vertices) => self.vertices = vertices,
                None => self.complaint = Some("a face with a vertex below zero".into()),
            },
            _ => match (["x", "y", "z"].iter().position(|&axis| axis == name), number(&property)) {
                (Some(axis), Some(number)) => self.position[axis] = number,
                (None, Some(number)) if !number.is_finite() => {
                    self.complaint = Some(format!("{name} {number}"));
                }
                _ => {}
            },
        }
        PropertyAccessResult::Set
    }
}

fn number(property: &Property) -> Option<f64> {
    match property {
        Property::Float(number) => Some(f64::from(*number)),
        Property::Double(number) => Some(*number),
        _ => None,
    }
}

pub(super) fn read(path: &Path) -> Result<Content, Complaint> {
    let mut reader = Reader::new(BufReader::new(File::open(path)?));
    let parser = Parser::<Element>::new();
    let header = parser.read_header(&mut reader)?;
    let mut content = Content::indexed();
    for (name, definition) in &header.elements {
        let elements = parser.read_payload_for_element(&mut reader, definition, &header)?;
        match name.as_str() {
            "vertex" => {
                content.positions = elements.iter().map(|element| element.position).collect();
            }
            "face" => {
                for element in &elements {
                    content.push_face(element.vertices.iter().copied());
                }
            }
            other => return Err(format!("it has elements named {other}").into()),
        }
        content.not_finite =
            elements.into_iter().find_map(|element| element.complaint).or(content.not_finite);
    }
    Ok(content)
}
