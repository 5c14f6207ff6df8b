//! Scenes made for tests, and an independent reader of accessors.
#![allow(dead_code, reason = "several test programs share this file")]
#![allow(clippy::unwrap_used, clippy::indexing_slicing)]

use serde_json::{Map, Value, json};

/// A document that grows.
#[derive(Clone)]
pub(crate) struct Builder {
    pub(crate) json: Value,
    bytes: Vec<u8>,
}

impl Builder {
    pub(crate) fn new() -> Self {
        let json = json!({
            "asset": { "version": "2.0", "generator": "a test" }, "scene": 0, "scenes": [{ "nodes": [] }],
            "accessors": [], "bufferViews": [],
        });
        Self { json, bytes: Vec::new() }
    }

    /// Appends an item to a list of the document, and returns its index.
    pub(crate) fn push(&mut self, list: &str, item: Value) -> usize {
        let document = self.json.as_object_mut().unwrap();
        let items = document.entry(list).or_insert_with(|| json!([])).as_array_mut().unwrap();
        items.push(item);
        items.len() - 1
    }

    /// A node at the top of the scene.
    pub(crate) fn node(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(index.into());
        index
    }

    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        self.push(
            "bufferViews",
            json!({ "buffer": 0, "byteOffset": start, "byteLength": bytes.len() }),
        )
    }

    pub(crate) fn accessor(
        &mut self,
        shape: &str,
        component: u32,
        count: usize,
        bytes: &[u8],
    ) -> usize {
        let view = self.view(bytes);
        let accessor = json!({ "bufferView": view, "componentType": component, "count": count, "type": shape });
        self.push("accessors", accessor)
    }

    pub(crate) fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(shape(N), 5126, values.len(), &bytes)
    }

    /// Positions, with the bounds that the format requires.
    pub(crate) fn positions(&mut self, values: &[[f32; 3]]) -> usize {
        let accessor = self.floats(values);
        let of = |k: usize| values.iter().map(move |value| value[k]);
        let least: Vec<f32> = (0..3).map(|k| of(k).fold(f32::INFINITY, f32::min)).collect();
        let most: Vec<f32> = (0..3).map(|k| of(k).fold(f32::NEG_INFINITY, f32::max)).collect();
        self.json["accessors"][accessor]["min"] = json!(least);
        self.json["accessors"][accessor]["max"] = json!(most);
        accessor
    }

    pub(crate) fn bytes<const N: usize>(&mut self, values: &[[u8; N]], normalized: bool) -> usize {
        let accessor = self.accessor(shape(N), 5121, values.len(), values.as_flattened());
        if normalized {
            self.json["accessors"][accessor]["normalized"] = true.into();
        }
        accessor
    }

    pub(crate) fn indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let corners = triangles.as_flattened();
        let bytes: Vec<u8> = corners.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor("SCALAR", 5125, corners.len(), &bytes)
    }

    /// Values of which all but a few are zero.
    pub(crate) fn sparse(&mut self, count: usize, values: &[(u32, [f32; 3])]) -> usize {
        let indices: Vec<u8> = values.iter().flat_map(|(index, _)| index.to_le_bytes()).collect();
        let numbers = values.iter().flat_map(|(_, value)| value);
        let numbers: Vec<u8> = numbers.flat_map(|v| v.to_le_bytes()).collect();
        let (indices, numbers) = (self.view(&indices), self.view(&numbers));
        self.push(
            "accessors",
            json!({
                "componentType": 5126, "count": count, "type": "VEC3",
                "min": [-1000, -1000, -1000], "max": [1000, 1000, 1000],
                "sparse": {
                    "count": values.len(), "indices": { "bufferView": indices, "componentType": 5125 },
                    "values": { "bufferView": numbers },
                },
            }),
        )
    }

    /// The document as a GLB file.
    pub(crate) fn glb(mut self) -> Vec<u8> {
        self.json["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        glb(&self.json, &self.bytes)
    }
}

fn shape(width: usize) -> &'static str {
    ["SCALAR", "VEC2", "VEC3", "VEC4"][width - 1]
}

pub(crate) fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 28 + text.len() + binary.len();
    let word = |length: usize| u32::try_from(length).unwrap().to_le_bytes();
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend(word(total));
    file.extend(word(text.len()));
    file.extend(b"JSON");
    file.extend(text);
    file.extend(word(binary.len()));
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}

/// The document and the binary chunk of a GLB file.
pub(crate) fn parts(file: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    let text = word(12);
    let json = serde_json::from_slice(&file[20..20 + text]).unwrap();
    let binary = file.get(28 + text..).unwrap_or_default().to_vec();
    (json, binary)
}

/// The values of an accessor, as the numbers in the file.
pub(crate) fn values(json: &Value, buffers: &[Vec<u8>], accessor: usize) -> Vec<Vec<f64>> {
    let accessor = &json["accessors"][accessor];
    let width = match accessor["type"].as_str().unwrap() {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 16,
    };
    let number = |value: &Value| value.as_u64().unwrap_or(0) as usize;
    let read = |place: &Value, kind: u64, width: usize, count: usize| -> Vec<Vec<f64>> {
        let size = match kind {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            _ => 4,
        };
        let view = &json["bufferViews"][number(&place["bufferView"])];
        let start = number(&view["byteOffset"]) + number(&place["byteOffset"]);
        let stride = match number(&view["byteStride"]) {
            0 => size * width,
            stride => stride,
        };
        let buffer = &buffers[number(&view["buffer"])];
        let component = |at: usize| {
            let b = &buffer[at..at + size];
            match kind {
                5120 => f64::from(b[0] as i8),
                5121 => f64::from(b[0]),
                5122 => f64::from(i16::from_le_bytes(b.try_into().unwrap())),
                5123 => f64::from(u16::from_le_bytes(b.try_into().unwrap())),
                5125 => f64::from(u32::from_le_bytes(b.try_into().unwrap())),
                _ => f64::from(f32::from_le_bytes(b.try_into().unwrap())),
            }
        };
        let value =
            |i: usize| (0..width).map(|k| component(start + i * stride + k * size)).collect();
        (0..count).map(value).collect()
    };
    let (kind, count) = (accessor["componentType"].as_u64().unwrap(), number(&accessor["count"]));
    let mut all = match accessor.get("bufferView") {
        Some(_) => read(accessor, kind, width, count),
        None => vec![vec![0.0; width]; count],
    };
    if let Some(sparse) = accessor.get("sparse") {
        let (count, indices) = (number(&sparse["count"]), &sparse["indices"]);
        let places = read(indices, indices["componentType"].as_u64().unwrap(), 1, count);
        for (place, value) in places.iter().zip(read(&sparse["values"], kind, width, count)) {
            all[place[0] as usize] = value;
        }
    }
    all
}

/// A tube along z: rings of vertices with the first column repeated at the cut of the texture.
pub(crate) struct Tube {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) uvs: Vec<[f32; 2]>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

pub(crate) fn tube(around: u32, along: u32) -> Tube {
    let mut tube = Tube { positions: vec![], normals: vec![], uvs: vec![], triangles: vec![] };
    for j in 0..=along {
        for i in 0..=around {
            let [u, v] = [i as f32 / around as f32, j as f32 / along as f32];
            // The two ends of a ring are at the same place.
            let angle = std::f32::consts::TAU * (i % around) as f32 / around as f32;
            let (sin, cos) = angle.sin_cos();
            tube.positions.push([cos, sin, 4.0 * v]);
            tube.normals.push([cos, sin, 0.0]);
            tube.uvs.push([u, v]);
        }
    }
    let at = |i: u32, j: u32| j * (around + 1) + i;
    for j in 0..along {
        for i in 0..around {
            tube.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            tube.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    tube
}

/// A sphere of latitudes and longitudes.
pub(crate) fn ball(around: u32, along: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut positions = vec![[0.0, 0.0, -1.0]];
    for j in 1..along {
        let latitude = std::f32::consts::PI * (j as f32 / along as f32 - 0.5);
        for i in 0..around {
            let (sin, cos) = (std::f32::consts::TAU * i as f32 / around as f32).sin_cos();
            positions.push([latitude.cos() * cos, latitude.cos() * sin, latitude.sin()]);
        }
    }
    positions.push([0.0, 0.0, 1.0]);
    let at = |i: u32, j: u32| 1 + (j - 1) * around + i % around;
    let last = positions.len() as u32 - 1;
    let mut triangles = Vec::new();
    for i in 0..around {
        triangles.push([0, at(i + 1, 1), at(i, 1)]);
        for j in 1..along - 1 {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
        triangles.push([at(i, along - 1), at(i + 1, along - 1), last]);
    }
    (positions, triangles)
}

/// A scene with everything: wheels that share a mesh at two scales, a skinned arm with an animation, morph targets,
/// two sets of texture coordinates, tangents, colours and numbers of vertices, a mesh of two primitives and lines, a
/// camera, a light, variants, an unknown extension, extras everywhere.
pub(crate) fn rich() -> Builder {
    let mut scene = Builder::new();
    let (positions, triangles) = ball(24, 12);
    let wheel = json!({
        "attributes": { "POSITION": scene.positions(&positions) }, "indices": scene.indices(&triangles),
        "extras": { "tread": [1, 2, 3] },
    });
    let wheel = scene.push("meshes", json!({ "name": "wheel", "primitives": [wheel] }));
    let arm = arm(&mut scene);
    let floor = floor(&mut scene);
    let front = json!({
        "name": "front", "mesh": wheel, "translation": [3, 0, 0.1], "extras": { "part": "A-113" },
    });
    let front = scene.push("nodes", front);
    let back =
        json!({ "name": "back", "mesh": wheel, "translation": [-9, 0, 0], "scale": [3, 3, 3] });
    let back = scene.push("nodes", back);
    scene.node(json!({ "name": "car", "children": [front, back] }));
    scene.node(json!({ "name": "floor", "mesh": floor }));
    let joints: Vec<usize> =
        (0..2).map(|i| scene.push("nodes", json!({ "name": format!("joint {i}") }))).collect();
    scene.json["nodes"][joints[1]]["translation"] = json!([0, 0, 2]);
    scene.json["nodes"][joints[0]]["children"] = json!([joints[1]]);
    scene.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(joints[0].into());
    let mut inverse = [[0.0_f32; 16]; 2];
    for (matrix, z) in inverse.iter_mut().zip([0.0, -2.0]) {
        (0..4).for_each(|k| matrix[5 * k] = 1.0);
        matrix[14] = z;
    }
    let bytes: Vec<u8> = inverse.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
    let inverse = scene.accessor("MAT4", 5126, 2, &bytes);
    let skin = scene.push("skins", json!({ "joints": joints, "inverseBindMatrices": inverse }));
    scene.node(json!({ "name": "arm", "mesh": arm, "skin": skin, "weights": [0.25] }));
    let (times, turns) = (
        scene.floats(&[[0.0], [1.0]]),
        scene.floats(&[[0.0, 0.0, 0.0, 1.0], [0.0, 0.6, 0.0, 0.8]]),
    );
    scene.json["accessors"][times]["min"] = json!([0]);
    scene.json["accessors"][times]["max"] = json!([1]);
    let channel = json!({ "sampler": 0, "target": { "node": joints[1], "path": "rotation" } });
    scene.push(
        "animations",
        json!({ "name": "wave", "channels": [channel], "samplers": [{ "input": times, "output": turns }] }),
    );
    let camera = json!({ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } });
    let camera = scene.push("cameras", camera);
    scene.node(json!({
        "name": "eye", "camera": camera, "extensions": { "KHR_lights_punctual": { "light": 0 } },
    }));
    scene.json["extensionsUsed"] = json!([
        "KHR_lights_punctual",
        "KHR_materials_variants",
        "KHR_texture_transform",
        "ACME_story"
    ]);
    scene.json["extensions"] = json!({
        "KHR_lights_punctual": { "lights": [{ "type": "point", "name": "lamp", "intensity": 3.5 }] },
        "KHR_materials_variants": { "variants": [{ "name": "day" }, { "name": "night" }] },
        "ACME_story": { "text": "once upon a time", "extras": { "page": 12 } },
    });
    scene.json["extras"] = json!({ "author": "somebody", "sum": 0.300_000_000_000_000_04_f64 });
    scene
}

/// A skinned tube that bends in the middle, with all kinds of attributes.
fn arm(scene: &mut Builder) -> usize {
    let tube = tube(24, 24);
    let count = tube.positions.len();
    let (mut joints, mut weights, mut colors) = (vec![], vec![], vec![]);
    let (mut heat, mut part, mut tangents, mut more_uvs) = (vec![], vec![], vec![], vec![]);
    for (position, normal) in tube.positions.iter().zip(&tube.normals) {
        let far = (position[2] / 4.0 * 255.0).round() as u8;
        joints.push([0_u8, 1, 0, 0]);
        weights.push([255 - far, far, 0, 0]);
        colors.push([far, 128, 255 - far, 255]);
        heat.push([20.0 + 5.0 * position[2]]);
        part.push([if position[2] < 2.0 { 7_u8 } else { 9 }]);
        tangents.push([-normal[1], normal[0], 0.0, 1.0]);
        more_uvs.push([position[2] / 8.0, 0.5]);
    }
    let moved: Vec<(u32, [f32; 3])> = (0..)
        .zip(&tube.positions)
        .filter(|(_, position)| position[2] > 3.0)
        .map(|(i, position)| (i, [0.0, 0.0, position[2] - 3.0]))
        .collect();
    let attributes = json!({
        "POSITION": scene.positions(&tube.positions), "NORMAL": scene.floats(&tube.normals),
        "TANGENT": scene.floats(&tangents), "TEXCOORD_0": scene.floats(&tube.uvs),
        "TEXCOORD_1": scene.floats(&more_uvs), "COLOR_0": scene.bytes(&colors, true),
        "JOINTS_0": scene.bytes(&joints, false), "WEIGHTS_0": scene.bytes(&weights, true),
        "_HEAT": scene.floats(&heat), "_PART": scene.bytes(&part, false),
    });
    let target = json!({ "POSITION": scene.sparse(count, &moved) });
    let primitive = json!({
        "attributes": attributes, "indices": scene.indices(&tube.triangles), "targets": [target],
    });
    let mesh = json!({
        "name": "arm", "primitives": [primitive], "weights": [0.5], "extras": { "targetNames": ["long"] },
    });
    scene.push("meshes", mesh)
}

/// A wavy floor of two materials, and lines.
fn floor(scene: &mut Builder) -> usize {
    const CELLS: u32 = 20;
    let mut positions = Vec::new();
    for i in 0..=CELLS {
        for j in 0..=CELLS {
            let [x, y] = [i, j].map(|k| k as f32 / CELLS as f32);
            positions.push([10.0 * x, 10.0 * y, 0.3 * (5.0 * x).sin() * (4.0 * y).cos()]);
        }
    }
    let at = |i: u32, j: u32| i * (CELLS + 1) + j;
    let mut halves = [vec![], vec![]];
    for i in 0..CELLS {
        for j in 0..CELLS {
            let half = &mut halves[usize::from(i >= CELLS / 2)];
            half.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            half.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    for name in ["wood", "stone"] {
        scene.push("materials", json!({ "name": name, "extras": { "id": name } }));
    }
    let positions = scene.positions(&positions);
    let variants = json!({ "KHR_materials_variants": {
        "mappings": [{ "material": 1, "variants": [1] }],
    }});
    let mut primitives: Vec<Value> = (0..2)
        .map(|half| {
            json!({
                "attributes": { "POSITION": positions }, "indices": scene.indices(&halves[half]),
                "material": half, "extensions": variants,
            })
        })
        .collect();
    primitives.push(json!({ "attributes": { "POSITION": positions }, "mode": 3 }));
    scene.push("meshes", json!({ "name": "floor", "primitives": primitives }))
}

/// The members of an object without some.
pub(crate) fn without(json: &Value, names: &[&str]) -> Map<String, Value> {
    let members = json.as_object().unwrap().iter();
    let kept = members.filter(|(name, _)| !names.contains(&name.as_str()));
    kept.map(|(name, value)| (name.clone(), value.clone())).collect()
}
