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
    /// The names of properties that are NaN.
    nan: Vec<String>,
    /// Whether the element has no curvature, so its quantities are NaN.
    is_unknown: bool,
    /// Whether the point is umbilic, so it has no principal directions.
    is_umbilic: bool,
}

impl Element {
    fn complaint(self) -> Option<String> {
        let Self { complaint, nan, is_unknown, is_umbilic, .. } = self;
        let is_direction = |name: &str| name.starts_with("k1_") || name.starts_with("k2_");
        let is_fault = |name: &String| {
            let is_expected =
                is_unknown || name == "curvature_error" || is_umbilic && is_direction(name);
            !is_expected
        };
        complaint.or_else(|| nan.into_iter().find(is_fault).map(|name| format!("{name} NaN")))
    }
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self {
            position: [f64::NAN; 3],
            vertices: Vec::new(),
            complaint: None,
            nan: Vec::new(),
            is_unknown: false,
            is_umbilic: false,
        }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match (name, &property) {
            ("vertex_indices" | "vertex_index", list) => match list.to_u32_list() {
                Some(vertices) => self.vertices = vertices,
                None => self.complaint = Some("a face with a vertex below zero".into()),
            },
            _ => match (["x", "y", "z"].iter().position(|&axis| axis == name), number(&property)) {
                (Some(axis), Some(number)) => self.position[axis] = number,
                (None, Some(number)) if number.is_nan() => self.nan.push(name.to_owned()),
                (None, Some(number)) if number.is_infinite() => {
                    self.complaint = Some(format!("{name} {number}"));
                }
                (None, Some(number)) => match name {
                    "curvature_known" => self.is_unknown = number == 0.0,
                    "curvature_kind" => self.is_umbilic = number == 1.0,
                    _ => {}
                },
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
        Property::UChar(number) => Some(f64::from(*number)),
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
            elements.into_iter().find_map(Element::complaint).or(content.not_finite);
    }
    Ok(content)
}
