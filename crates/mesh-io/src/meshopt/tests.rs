//! The codec against streams of another one: `golden.txt` has, for each stream that the npm package `meshoptimizer`
//! 1.3.0 has encoded, the mode, the filter, the number of values, their size, the stream, and what the reference
//! decoder of that package makes of it.

use super::filters::Filter;
use super::stream::Broken;
use super::{Mode, decode, encode};
use proptest::prelude::*;

struct Golden {
    mode: Mode,
    count: usize,
    stride: usize,
    stream: Vec<u8>,
    expected: Vec<u8>,
}

fn golden() -> Vec<Golden> {
    let bytes = |hex: &str| -> Vec<u8> {
        (0..hex.len() / 2)
            .map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap())
            .collect()
    };
    let line = |line: &str| {
        let fields: Vec<&str> = line.split(' ').collect();
        let filter = match fields[1] {
            "NONE" => Filter::None,
            "OCTAHEDRAL" => Filter::Octahedral,
            "QUATERNION" => Filter::Quaternion,
            "EXPONENTIAL" => Filter::Exponential,
            _ => Filter::Color,
        };
        let mode = match fields[0] {
            "ATTRIBUTES" => Mode::Attributes(filter),
            "TRIANGLES" => Mode::Triangles,
            _ => Mode::Indices,
        };
        let [count, stride] = [2, 3].map(|field: usize| fields[field].parse().unwrap());
        let [stream, expected] = [4, 5].map(|field: usize| bytes(fields[field]));
        Golden { mode, count, stride, stream, expected }
    };
    include_str!("golden.txt").lines().map(line).collect()
}

/// The components of values as numbers, for filters that may round differently by one.
fn components(golden: &Golden, bytes: &[u8]) -> Vec<i32> {
    let is_signed = golden.mode != Mode::Attributes(Filter::Color);
    let of = |bytes: &[u8]| match (bytes, is_signed) {
        (&[a, b], true) => i32::from(i16::from_le_bytes([a, b])),
        (&[a, b], false) => i32::from(u16::from_le_bytes([a, b])),
        (&[a], true) => i32::from(a.cast_signed()),
        _ => i32::from(bytes[0]),
    };
    bytes.chunks_exact(golden.stride / 4).map(of).collect()
}

#[test]
fn streams_of_another_encoder_are_decoded() {
    let all = golden();
    assert!(all.len() > 40);
    for (line, golden) in all.iter().enumerate() {
        let Golden { mode, count, stride, ref stream, ref expected } = *golden;
        let found = decode(mode, count, stride, stream).unwrap();
        match mode {
            Mode::Attributes(Filter::Octahedral | Filter::Quaternion | Filter::Color) => {
                let (found, expected) = (components(golden, &found), components(golden, expected));
                assert_eq!(found.len(), expected.len());
                let differ = |(a, b): (&i32, &i32)| (a - b).abs() > 1;
                let place = found.iter().zip(&expected).position(differ);
                assert_eq!(place, None, "line {}: {found:?} {expected:?}", line + 1);
            }
            _ => assert!(&found == expected, "line {}", line + 1),
        }
    }
}

/// What is decoded is encoded to the same bytes again, by our encoder, which has version 0 and no filters.
#[test]
fn streams_are_those_of_another_encoder() {
    let mut same = 0;
    for (line, golden) in golden().iter().enumerate() {
        let Golden { mode, stride, ref stream, ref expected, .. } = *golden;
        let is_plain = matches!(mode, Mode::Attributes(Filter::None)) && stream[0] == 0xa0
            || matches!(mode, Mode::Triangles | Mode::Indices);
        if is_plain {
            assert_eq!(&encode(mode, stride, expected).unwrap(), stream, "line {}", line + 1);
            same += 1;
        }
    }
    assert!(same > 20, "{same}");
}

/// Numbers with many small and some large differences.
fn numbers(most: usize) -> impl Strategy<Value = Vec<u32>> {
    let step = prop_oneof![4 => 0..4_u32, 2 => 0..300_u32, 1 => any::<u32>()];
    prop::collection::vec(step, 0..most).prop_map(|steps| {
        let sum = |sum: &mut u32, step: u32| {
            *sum = sum.wrapping_add(step);
            Some(*sum)
        };
        steps.into_iter().scan(0, sum).collect()
    })
}

proptest! {
    #[test]
    fn values_come_back(numbers in numbers(3000), words in 1..=64_usize) {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let stride = 4 * words;
        let bytes = &bytes[..bytes.len() / stride * stride];
        let mode = Mode::Attributes(Filter::None);
        let stream = encode(mode, stride, bytes).unwrap();
        prop_assert_eq!(&decode(mode, bytes.len() / stride, stride, &stream).unwrap(), bytes);
    }

    #[test]
    fn indices_come_back(numbers in numbers(500), is_short in any::<bool>()) {
        let stride = if is_short { 2 } else { 4 };
        let bytes: Vec<u8> =
            numbers.iter().flat_map(|n| n.to_le_bytes()[..stride].to_vec()).collect();
        if let Some(stream) = encode(Mode::Indices, stride, &bytes) {
            prop_assert_eq!(decode(Mode::Indices, numbers.len(), stride, &stream).unwrap(), bytes);
        } else {
            prop_assert!(!is_short);
        }
    }

    /// Triangles come back with the same corners in the same sense; only the first corner may differ.
    #[test]
    fn triangles_come_back(steps in prop::collection::vec(0..12_u32, 0..600), base in prop_oneof![Just(0_u32), any::<u32>()]) {
        let corners: Vec<u32> = steps.iter().enumerate()
            .map(|(place, step)| (base / 2).wrapping_add((place / 4) as u32).wrapping_add(*step))
            .collect();
        let corners = &corners[..corners.len() / 3 * 3];
        let bytes: Vec<u8> = corners.iter().flat_map(|corner| corner.to_le_bytes()).collect();
        let stream = encode(Mode::Triangles, 4, &bytes).unwrap();
        let found = decode(Mode::Triangles, corners.len(), 4, &stream).unwrap();
        let found: Vec<u32> = found.as_chunks().0.iter().map(|&c| u32::from_le_bytes(c)).collect();
        for (found, triangle) in found.as_chunks::<3>().0.iter().zip(corners.as_chunks::<3>().0) {
            let [a, b, c] = *triangle;
            prop_assert!([[a, b, c], [b, c, a], [c, a, b]].contains(found), "{found:?} {triangle:?}");
        }
    }
}

/// Every shorter stream ends too early; no changed byte makes a decoder panic, and none changes the size of the result.
#[test]
fn damaged_streams_are_errors_or_other_values() {
    let mut random = fastrand::Rng::with_seed(1);
    for golden in golden() {
        let Golden { mode, count, stride, stream, expected } = golden;
        for length in 0..stream.len() {
            assert!(decode(mode, count, stride, &stream[..length]).is_err(), "{mode:?} {length}");
        }
        let mut longer = stream.clone();
        longer.push(0);
        assert!(decode(mode, count, stride, &longer).is_err(), "{mode:?}");
        for _ in 0..200 {
            let mut damaged = stream.clone();
            for _ in 0..random.usize(1..4) {
                let place = random.usize(..damaged.len());
                damaged[place] = random.u8(..);
            }
            if let Ok(values) = decode(mode, count, stride, &damaged) {
                assert_eq!(values.len(), expected.len());
            }
        }
        let noise: Vec<u8> = (0..stream.len()).map(|_| random.u8(..)).collect();
        let _ = decode(mode, count, stride, &noise);
    }
}

#[test]
fn what_a_stream_cannot_hold_is_named() {
    let layout = |mode, count, stride| {
        assert_eq!(decode(mode, count, stride, &[]), Err(Broken::Layout { count, stride }));
    };
    layout(Mode::Attributes(Filter::None), 1, 0);
    layout(Mode::Attributes(Filter::None), 1, 6);
    layout(Mode::Attributes(Filter::None), 1, 260);
    layout(Mode::Attributes(Filter::None), usize::MAX, 8);
    layout(Mode::Attributes(Filter::Octahedral), 1, 12);
    layout(Mode::Attributes(Filter::Color), 1, 12);
    layout(Mode::Attributes(Filter::Quaternion), 1, 4);
    layout(Mode::Triangles, 4, 2);
    layout(Mode::Triangles, 3, 8);
    layout(Mode::Indices, 4, 1);
    let header = |mode, bytes: &[u8]| {
        assert_eq!(decode(mode, 3, 4, bytes), Err(Broken::Header(bytes[0])));
    };
    header(Mode::Attributes(Filter::None), &[0xa2; 80]);
    header(Mode::Triangles, &[0xe0; 80]);
    header(Mode::Indices, &[0xd0; 80]);
    // A channel mode that no version has: the last byte of a stream of version 1.
    let mut stream = [0; 32];
    (stream[0], stream[31]) = (0xa1, 3);
    assert_eq!(decode(Mode::Attributes(Filter::None), 0, 4, &stream), Err(Broken::Channel(3)));
    // The table at the end names a corner that is stored apart.
    let mut stream = [0; 17];
    (stream[0], stream[1]) = (0xe1, 0xf0);
    assert_eq!(decode(Mode::Triangles, 0, 4, &stream), Err(Broken::Table));
    // The largest table place that a code can name.
    assert_eq!(
        decode(Mode::Triangles, 0, 4, &{
            let mut s = [0; 17];
            s[0] = 0xe1;
            s
        }),
        Ok(vec![])
    );
}
