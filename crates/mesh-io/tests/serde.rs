//! Models, options and reports through JSON.
#![cfg(feature = "serde")]
#![allow(clippy::unwrap_used)]

use mesh_io::{
    Alpha, Compression, Encoding, External, Format, Group, Image, ImageData, Material, Model,
    Precision, Quantization, ReadOptions, Scalars, StlColors, WriteOptions, WriteReport, write_to,
};
use mesh_shapes::polyhedra;
use serde::Serialize;
use serde::de::DeserializeOwned;

fn again<T: Serialize + DeserializeOwned>(value: &T) -> T {
    serde_json::from_str(&serde_json::to_string(value).unwrap()).unwrap()
}

#[test]
fn a_model_comes_back_as_it_was() {
    let mut model = Model::from(polyhedra::cube());
    let (vertices, faces) = (model.soup.vertex_count(), model.soup.face_count());
    model.vertex_colors = Some(vec![[0.1, 0.2, 0.3, 1.0]; vertices]);
    model.corner_uvs = Some(vec![[0.25, 0.5]; model.soup.corners().len()]);
    model.vertex_scalars = vec![Scalars::new("h", vec![0.1 + 0.2; vertices])];
    model.face_groups = Some(vec![0; faces]);
    model.groups = vec![Group { object: "o".into(), name: "g".into() }];
    model.face_materials = Some(vec![Model::NONE; faces]);
    model.materials = vec![Material { alpha: Alpha::Mask(0.5), ..Material::default() }];
    let data = ImageData::Bytes(vec![1, 2, 3]);
    model.images = vec![Image { name: "i".into(), media_type: String::new(), data }];
    assert_eq!(again(&model), model);
    // Omitted fields are empty.
    let sparse: Model = serde_json::from_str("{}").unwrap();
    assert_eq!(sparse, Model::default());
}

#[test]
fn options_and_reports_come_back_and_misspelt_ones_are_refused() {
    let options = WriteOptions {
        format: Some(Format::Glb),
        encoding: Encoding::LittleEndian,
        precision: Precision::Double,
        overwrite_companions: true,
        stl_colors: StlColors::Magics,
        compression: Compression::Meshopt,
        quantization: Some(Quantization::with_bits(12)),
    };
    assert_eq!(again(&options), options);
    assert!(serde_json::from_str::<WriteOptions>(r#"{"overwrite":true}"#).is_err());
    let reading = ReadOptions { external: External::None, ..ReadOptions::default() };
    assert_eq!(again(&reading).external, External::None);
    let cube = polyhedra::cube();
    let report: WriteReport =
        write_to(&mut Vec::new(), &cube, Format::Stl, &WriteOptions::default()).unwrap();
    assert_eq!(again(&report), report);
}
