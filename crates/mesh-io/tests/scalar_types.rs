//! Named numbers keep their type and their value from file to file.

#![allow(clippy::unwrap_used)]

use glam::DVec3;
use mesh_core::PolygonSoup;
use mesh_io::{
    Blend, Encoding, Format, Model, Precision, ReadOptions, ScalarType, ScalarValues, Scalars,
    WriteOptions, read_from, write_to,
};
use proptest::prelude::*;

const ENCODINGS: [Encoding; 3] = [Encoding::Text, Encoding::LittleEndian, Encoding::BigEndian];

/// As many vertices as faces: triangles around an axis.
fn fan(count: usize) -> PolygonSoup {
    let mut soup = PolygonSoup::new();
    for i in 0..count as u32 {
        soup.push_vertex([f64::from(i % 7), f64::from(i / 7), 0.25]);
    }
    for i in 0..count as u32 {
        let n = count as u32;
        soup.push_face(&[i, (i + 1) % n, (i + 2) % n]).unwrap();
    }
    soup
}

fn written(model: &Model, format: Format, encoding: Encoding) -> Vec<u8> {
    let mut bytes = Vec::new();
    let options = WriteOptions { encoding, ..WriteOptions::default() };
    write_to(&mut bytes, model, format, &options).unwrap();
    bytes
}

fn parsed(bytes: &[u8]) -> Model {
    read_from(&mut &*bytes, &ReadOptions::default()).unwrap()
}

fn round_trip(model: &Model, format: Format, encoding: Encoding) -> Model {
    parsed(&written(model, format, encoding))
}

fn any_values(count: usize) -> impl Strategy<Value = ScalarValues> {
    use proptest::collection::vec;
    macro_rules! of {
        ($number:ty) => {
            vec(any::<$number>(), count).prop_map(ScalarValues::from).boxed()
        };
    }
    let finite_32 = any::<f32>().prop_filter("finite", |x| x.is_finite());
    let finite_64 = any::<f64>().prop_filter("finite", |x| x.is_finite());
    prop_oneof![
        of!(i8),
        of!(u8),
        of!(i16),
        of!(u16),
        of!(i32),
        of!(u32),
        of!(i64),
        of!(u64),
        vec(finite_32, count).prop_map(ScalarValues::from),
        vec(finite_64, count).prop_map(ScalarValues::from),
    ]
}

fn any_model() -> impl Strategy<Value = Model> {
    (3_usize..12).prop_flat_map(|count| {
        let columns = || proptest::collection::vec(any_values(count), 0..4);
        (columns(), columns(), any::<bool>()).prop_map(move |(vertices, faces, colored)| {
            let named = |all: Vec<ScalarValues>| {
                let named = all.into_iter().enumerate();
                named.map(|(i, values)| Scalars::new(format!("n{i}"), values)).collect()
            };
            Model {
                vertex_scalars: named(vertices),
                face_scalars: named(faces),
                face_colors: colored.then(|| vec![[1.0, 0.0, 0.2, 1.0]; count]),
                ..Model::from(fan(count))
            }
        })
    })
}

/// Whether columns have the same names and numbers, and the same labels among whole numbers. Others are labels if they
/// look like it.
fn are_kept(again: &[Scalars], columns: &[Scalars]) -> bool {
    let same = |(new, old): (&Scalars, &Scalars)| {
        let is_free = !old.values.is_integer();
        (&new.name, &new.values) == (&old.name, &old.values)
            && (is_free || new.is_label == old.is_label)
    };
    again.len() == columns.len() && again.iter().zip(columns).all(same)
}

proptest! {
    #[test]
    fn ply_keeps_every_type(model in any_model()) {
        for encoding in ENCODINGS {
            let again = round_trip(&model, Format::Ply, encoding);
            for (again, columns) in [
                (&again.vertex_scalars, &model.vertex_scalars),
                (&again.face_scalars, &model.face_scalars),
            ] {
                prop_assert!(are_kept(again, columns), "{encoding:?} {again:?} {columns:?}");
            }
            prop_assert!(again.notes.is_empty(), "{:?}", again.notes);
        }
    }

    #[test]
    fn labels_are_taken_and_never_made(
        model in any_model(),
        weights in proptest::collection::vec([0.01..1.0_f64, 0.01..1.0, 0.01..1.0], 1..9),
    ) {
        let count = model.soup.vertex_count() as u32;
        let blends: Vec<Blend> = weights
            .iter()
            .zip(0_u32..)
            .map(|(w, i)| {
                let sum: f64 = w.iter().sum();
                Blend {
                    sources: [i % count, (i + 1) % count, (i + 2) % count],
                    weights: w.map(|w| w / sum),
                }
            })
            .collect();
        let positions = vec![DVec3::ZERO; blends.len()];
        let new = model.blended(&positions, &[], &blends, &[], &[]).unwrap();
        for (new, old) in new.vertex_scalars.iter().zip(&model.vertex_scalars) {
            prop_assert_eq!(new.values.scalar_type(), old.values.scalar_type());
            let old = old.values.to_f64();
            prop_assert_eq!(new.values.len(), blends.len());
            for (value, blend) in new.values.iter().zip(&blends) {
                if new.is_label {
                    prop_assert_eq!(value.to_bits(), old[blend.nearest() as usize].to_bits());
                } else {
                    let of = blend.sources.map(|s| old[s as usize]);
                    let low = of.into_iter().fold(f64::INFINITY, f64::min);
                    let high = of.into_iter().fold(f64::NEG_INFINITY, f64::max);
                    let slack = 1e-6 * low.abs().max(high.abs());
                    prop_assert!(value >= low - slack && value <= high + slack);
                }
            }
        }
    }

    #[test]
    fn glb_keeps_short_integers(
        bytes in proptest::collection::vec(any::<u8>(), 5),
        signed in proptest::collection::vec(any::<i8>(), 5),
        shorts in proptest::collection::vec(any::<i16>(), 5),
        words in proptest::collection::vec(any::<u16>(), 5),
        singles in proptest::collection::vec(-1e9..1e9_f32, 5),
    ) {
        let mut model = Model::from(fan(5));
        model.vertex_scalars = vec![
            Scalars::new("a", bytes),
            Scalars::new("b", signed),
            Scalars::new("c", shorts),
            Scalars::new("d", words.clone()),
            Scalars::new("e", singles),
            Scalars::new("f", words.into_iter().map(i64::from).collect::<Vec<_>>()),
        ];
        for format in [Format::Glb, Format::Gltf] {
            let again = round_trip(&model, format, Encoding::Usual);
            prop_assert!(are_kept(&again.vertex_scalars[..5], &model.vertex_scalars[..5]));
            prop_assert!(again.vertex_scalars[5].is_label);
            prop_assert_eq!(
                again.vertex_scalars[5].values.to_f64(),
                model.vertex_scalars[5].values.to_f64()
            );
        }
    }
}

/// A text file with one property of vertices in this type and with these values, among lists.
fn text_ply(kind: &str, values: [&str; 3]) -> String {
    let [a, b, c] = values;
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
         property float z\nproperty {kind} n\nproperty list uchar int near\nelement face 1\n\
         property list uchar int vertex_indices\nproperty {kind} m\nend_header\n\
         0 0 0 {a} 1 2\n1 0 0 {b} 0\n0 1 0 {c} 2 0 1\n3 0 1 2 {a}\n"
    )
}

#[test]
fn every_spelling_of_a_type_is_that_type() {
    for (words, expected) in [
        (&["char", "int8"][..], ScalarType::I8),
        (&["uchar", "uint8"], ScalarType::U8),
        (&["short", "int16"], ScalarType::I16),
        (&["ushort", "uint16"], ScalarType::U16),
        (&["int", "int32"], ScalarType::I32),
        (&["uint", "uint32"], ScalarType::U32),
        (&["int64", "long"], ScalarType::I64),
        (&["uint64", "ulong"], ScalarType::U64),
        (&["float", "float32"], ScalarType::F32),
        (&["double", "float64"], ScalarType::F64),
    ] {
        for word in words {
            let model = parsed(text_ply(word, ["1", "2", "3"]).as_bytes());
            let [of_vertices, of_faces] = [&model.vertex_scalars[0], &model.face_scalars[0]];
            assert_eq!(of_vertices.values.scalar_type(), expected, "{word}");
            assert_eq!(of_faces.values.scalar_type(), expected, "{word}");
            assert!(of_vertices.is_label, "{word}");
            // One number tells nothing.
            assert_eq!(of_faces.is_label, expected.is_integer(), "{word}");
            assert_eq!(model.vertex_scalars[0].values, [1.0, 2.0, 3.0]);
        }
    }
}

#[test]
fn whole_numbers_of_64_bits_are_exact_in_text() {
    let numbers = ["9007199254740993", "-9223372036854775808", "9223372036854775807"];
    let model = parsed(text_ply("int64", numbers).as_bytes());
    let expected = [9_007_199_254_740_993, i64::MIN, i64::MAX];
    assert_eq!(model.vertex_scalars[0].values, ScalarValues::I64(expected.into()));
    let model = parsed(text_ply("uint64", ["0", "18446744073709551615", "1"]).as_bytes());
    assert_eq!(model.vertex_scalars[0].values, ScalarValues::U64(vec![0, u64::MAX, 1]));
}

#[test]
fn a_number_beyond_its_declared_type_widens_the_column() {
    for (kind, numbers, expected) in [
        ("uchar", ["1", "300", "2"], ScalarType::I64),
        ("char", ["-1", "200", "2"], ScalarType::I64),
        ("int", ["1", "-4000000000", "2"], ScalarType::I64),
        ("int64", ["1", "18446744073709551615", "2"], ScalarType::U64),
        ("ushort", ["1", "2.5", "3"], ScalarType::F64),
        ("int", ["1", "nan", "3"], ScalarType::F64),
    ] {
        let model = parsed(text_ply(kind, numbers).as_bytes());
        let found = &model.vertex_scalars[0];
        assert_eq!(found.values.scalar_type(), expected, "{kind}");
        let exact = numbers.map(|n| n.parse::<f64>().unwrap().to_bits());
        assert_eq!(found.values.iter().map(f64::to_bits).collect::<Vec<_>>(), exact);
        assert!(model.notes.iter().any(|note| note.contains(kind)), "{:?}", model.notes);
    }
}

#[test]
fn the_precision_option_concerns_floating_point_only() {
    let mut model = Model::from(fan(3));
    model.vertex_scalars = vec![
        Scalars::new("whole", vec![1_u64, 2, u64::MAX]),
        Scalars::new("single", vec![0.1_f32, 0.2, 0.3]),
        Scalars::new("double", vec![0.1, 0.2, 0.3]),
    ];
    for (precision, types) in [
        (Precision::Exact, [ScalarType::U64, ScalarType::F32, ScalarType::F64]),
        (Precision::Single, [ScalarType::U64, ScalarType::F32, ScalarType::F32]),
        (Precision::Double, [ScalarType::U64, ScalarType::F64, ScalarType::F64]),
    ] {
        let options = WriteOptions { precision, ..WriteOptions::default() };
        let mut bytes = Vec::new();
        write_to(&mut bytes, &model, Format::Ply, &options).unwrap();
        let found = parsed(&bytes).vertex_scalars;
        let found: Vec<ScalarType> = found.iter().map(|s| s.values.scalar_type()).collect();
        assert_eq!(found, types, "{precision:?}");
    }
}

/// Numbers without fractions are labels in any type, also after a format without large whole numbers.
#[test]
fn few_numbers_without_fractions_are_labels() {
    let labels = |values: &ScalarValues, format: Format| {
        let mut model = Model::from(fan(6));
        model.vertex_scalars = vec![Scalars::new("class", values.clone())];
        let read = round_trip(&model, format, Encoding::LittleEndian);
        let back = &read.vertex_scalars[0];
        (back.is_label, (0..6).filter_map(|i| back.values.get(i)).collect::<Vec<_>>())
    };
    let classes = [2.0, 6.0, 2.0, 2.0, 6.0, 9.0];
    let large = [-7, 70_000, -7, -7, 70_000, 0];
    for format in [Format::Ply, Format::Glb] {
        let single: Vec<f32> = classes.iter().map(|&class| class as f32).collect();
        assert_eq!(labels(&single.into(), format), (true, classes.to_vec()), "{format:?}");
        let wide = large.map(f64::from).to_vec();
        assert_eq!(labels(&large.to_vec().into(), format), (true, wide), "{format:?}");
        for measured in [vec![0.5_f32, 1.0, 2.0, 3.0, 4.0, 5.0], vec![4.0; 6]] {
            assert!(!labels(&measured.into(), format).0, "{format:?}");
        }
    }
}
