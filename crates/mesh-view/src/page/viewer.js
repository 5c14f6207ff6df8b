'use strict';
// The viewer of a page: plain WebGL 2, no library, no request. What it shows is in the elements
// around it: `page` holds the description as JSON, `b0`, `b1`, ... hold arrays in base64.
//
// Faces are drawn without vertex buffers: the vertex shader looks up corners, positions and values
// in textures by `gl_VertexID`. So values of faces, flat shading and edges need no second copy of
// the mesh, and the number of a face is known to the shader that answers the pointer.
(() => {
const started = performance.now();
const element = id => document.getElementById(id);
const page = JSON.parse(element('page').textContent);
const canvas = element('canvas');
const live = element('live');

// ---------------------------------------------------------------- data

function bytesOf(blob) {
  const text = element('b' + blob).textContent;
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

const floatsOf = blob => new Float32Array(bytesOf(blob).buffer);

// Differences of neighbours, zigzag, in groups of seven bits.
function integersOf(blob, count) {
  const bytes = bytesOf(blob), out = new Uint32Array(count);
  let at = 0, last = 0;
  for (let i = 0; i < count; i++) {
    let value = 0, shift = 0, byte;
    do { byte = bytes[at++]; value |= (byte & 127) << shift; shift += 7; } while (byte > 127);
    last = (last + ((value >>> 1) ^ -(value & 1))) >>> 0;
    out[i] = last;
  }
  return out;
}

// A 32-bit number and what it lacks, in parts of the distance to the next one.
function exact(field, i) {
  const value = field.values[i];
  if (!field.fine || !Number.isFinite(value) || value === 0) return value;
  const exponent = Math.max((new Uint32Array(field.values.buffer, 4 * i, 1)[0] >>> 23) & 255, 1);
  return value + field.fine[i] / 254 * 2 ** (exponent - 150);
}

// A label is a whole number; the parts of the distance to the next one can be too coarse by less than a half.
const labelOf = (field, i) => field.label ? Math.round(exact(field, i)) : exact(field, i);

const digits = (x, n = 7) => {
  if (!Number.isFinite(x)) return 'no value';
  if (x === 0) return '0';
  const text = x.toPrecision(n);
  const [mantissa, exponent] = text.split('e');
  const short = mantissa.includes('.') ? mantissa.replace(/\.?0+$/, '') : mantissa;
  return exponent ? short + 'e' + exponent.replace('+', '') : short;
};
const grouped = n => n.toLocaleString('en-US');

// What people call the properties that this program writes.
const NAMES = {
  mean_curvature: 'mean curvature', abs_mean_curvature: 'absolute mean curvature', gaussian_curvature: 'Gaussian curvature',
  k1: 'largest principal curvature k1', k2: 'smallest principal curvature k2', abs_principal_sum: 'sum of |k1| and |k2|',
  abs_dihedral_curvature: 'absolute curvature from dihedral angles', willmore_energy: 'Willmore energy', k_plus: 'positive extrinsic curvature',
  k_minus: 'negative extrinsic curvature', shape_index: 'shape index', curvature_error: 'error of curvature',
  curvature_known: 'whether curvature is known', curvature_kind: 'kind of curvature',
  ...Object.fromEntries(['k1', 'k2'].flatMap(k => [...'xyz'].map(axis => [k + '_' + axis, `direction of ${k}, ${axis}`]))),
};
const titleOf = name => Object.hasOwn(NAMES, name) ? NAMES[name] : name;
// A name that may break after its words.
const wrapped = name => (name.match(/[^_]*_|[^_]+$/g) ?? []).flatMap((part, i) => i ? [document.createElement('wbr'), part] : [part]);
const LENGTH = 'model units';
// A number with its unit, as in a sentence: "3 per model unit".
const withUnit = (text, unit) => `${text} ${unit.replace(/^1 \/ /, 'per ')}`.trimEnd();

const meshes = page.meshes.map((source, number) => {
  const { positions, index } = source;
  const vertices = positions.count, faces = index.count;
  let local;
  if (positions.step) {
    const raw = new Uint16Array(bytesOf(positions.blob).buffer);
    local = new Float32Array(3 * vertices);
    for (let i = 0; i < 3 * vertices; i++) local[i] = positions.low[i % 3] + raw[i] * positions.step[i % 3];
  } else {
    local = floatsOf(positions.blob);
  }
  const fields = new Map();
  for (const f of source.fields) {
    const values = floatsOf(f.blob);
    const fine = f.fine === null ? null : new Int8Array(bytesOf(f.fine).buffer);
    fields.set(f.on + ':' + f.name, { ...f, title: titleOf(f.name), values, fine });
  }
  const mesh = { source, number, vertices, faces, local, fields, corners: integersOf(index.blob, 3 * faces),
    radius: 0.5 * Math.hypot(...source.extent) || 1e-9, cache: {} };
  const parts = source.facts.find(([name]) => name === 'components')?.[1] ?? '1';
  // Found only when they are asked for. With merged vertices, they would be others than those of the file.
  if (!['0', '1'].includes(parts) && !source.simplified && !fields.has('face:component')) {
    fields.set('face:component', { name: 'component', title: 'component', unit: '', on: 'face', signed: false, range: null, label: true, fine: null, lazy: true, get values() { return mesh.cache.components ??= componentsOf(mesh); } });
  }
  return mesh;
});

// The meshes that are compared with each other; a part is shown alone.
const wholes = meshes.some(m => !m.source.part) ? meshes.filter(m => !m.source.part) : meshes;

// The first vertex at the same place, where the file has several.
const same = mesh => mesh.cache.same ??= mesh.source.same === null ? null : integersOf(mesh.source.same, mesh.vertices);

// The component of every face, numbered by the smallest vertex.
function componentsOf(mesh) {
  const { corners, faces, vertices } = mesh, twins = same(mesh);
  const parent = Uint32Array.from({ length: vertices }, (_, v) => v);
  const root = v => { while (parent[v] !== v) v = parent[v] = parent[parent[v]]; return v; };
  const first = h => root(twins ? twins[corners[h]] : corners[h]);
  for (let f = 0; f < faces; f++) {
    const a = first(3 * f);
    for (const h of [3 * f + 1, 3 * f + 2]) {
      const b = first(h), c = root(a);
      if (b < c) parent[c] = b; else parent[b] = c;
    }
  }
  const out = new Float32Array(faces), numbers = new Float32Array(vertices).fill(-1), used = new Uint8Array(vertices);
  for (let f = 0; f < faces; f++) used[first(3 * f)] = 1;
  let n = 0;
  for (let v = 0; v < vertices; v++) if (used[v]) numbers[v] = n++;
  for (let f = 0; f < faces; f++) out[f] = numbers[first(3 * f)];
  return out;
}

// Whether the faces of a closed surface look into it.
function isInsideOut(mesh) {
  return mesh.cache.insideOut ??= (() => {
    const { local: p, corners, faces, source } = mesh, fact = name => source.facts.find(([found]) => found === name)?.[1];
    if (source.simplified || fact('boundary edges') !== '0' || (fact('inconsistent edges') ?? '0') !== '0') return false;
    let volume = 0, size = 0;
    for (let f = 0; f < faces; f++) {
      const [a, b, c] = [0, 1, 2].map(i => 3 * corners[3 * f + i]);
      const part = p[a] * (p[b + 1] * p[c + 2] - p[b + 2] * p[c + 1]) + p[a + 1] * (p[b + 2] * p[c] - p[b] * p[c + 2]) + p[a + 2] * (p[b] * p[c + 1] - p[b + 1] * p[c]);
      volume += part; size += Math.abs(part);
    }
    // Surfaces that are only in part inside out have about the same volume on both sides.
    return volume < -1e-6 * size;
  })();
}

function vertexNormals(mesh) {
  const { local: p, corners, faces, vertices } = mesh, twins = same(mesh);
  const sums = new Float32Array(3 * vertices);
  for (let f = 0; f < faces; f++) {
    let a = corners[3 * f], b = corners[3 * f + 1], c = corners[3 * f + 2];
    const ux = p[3 * b] - p[3 * a], uy = p[3 * b + 1] - p[3 * a + 1], uz = p[3 * b + 2] - p[3 * a + 2];
    const vx = p[3 * c] - p[3 * a], vy = p[3 * c + 1] - p[3 * a + 1], vz = p[3 * c + 2] - p[3 * a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    if (twins) { a = twins[a]; b = twins[b]; c = twins[c]; }
    sums[3 * a] += nx; sums[3 * a + 1] += ny; sums[3 * a + 2] += nz;
    sums[3 * b] += nx; sums[3 * b + 1] += ny; sums[3 * b + 2] += nz;
    sums[3 * c] += nx; sums[3 * c + 1] += ny; sums[3 * c + 2] += nz;
  }
  const out = new Int16Array(4 * vertices);
  for (let v = 0; v < vertices; v++) {
    const t = twins ? twins[v] : v, x = sums[3 * t], y = sums[3 * t + 1], z = sums[3 * t + 2];
    const scale = 32767 / (Math.hypot(x, y, z) || 1);
    out[4 * v] = x * scale; out[4 * v + 1] = y * scale; out[4 * v + 2] = z * scale;
  }
  return out;
}

// Edges with their faces, found by hashing; asked for only when lines along edges are.
function edgesOf(mesh) {
  if (mesh.cache.edges) return mesh.cache.edges;
  const { corners, faces } = mesh, twins = same(mesh), most = 3 * faces;
  let size = 4;
  while (size < 2 * most) size *= 2;
  const table = new Int32Array(size).fill(-1), mask = size - 1;
  const ends = new Uint32Array(2 * most), sides = new Int32Array(2 * most).fill(-1), count = new Uint8Array(most);
  let edges = 0;
  for (let h = 0; h < most; h++) {
    const f = (h / 3) | 0;
    let a = corners[h], b = corners[h % 3 === 2 ? h - 2 : h + 1];
    if (twins) { a = twins[a]; b = twins[b]; }
    if (a === b) continue;
    const low = Math.min(a, b), high = Math.max(a, b);
    let slot = (Math.imul(low, 0x9E3779B1) ^ Math.imul(high, 0x85EBCA6B)) & mask;
    while (table[slot] >= 0 && (ends[2 * table[slot]] !== low || ends[2 * table[slot] + 1] !== high)) slot = (slot + 1) & mask;
    let e = table[slot];
    if (e < 0) { e = table[slot] = edges++; ends[2 * e] = low; ends[2 * e + 1] = high; }
    if (count[e] < 2) sides[2 * e + count[e]] = f;
    if (count[e] < 255) count[e]++;
  }
  return mesh.cache.edges = { ends, sides, count, edges };
}

function faceNormal(mesh, f) {
  const p = mesh.local, [a, b, c] = [0, 1, 2].map(i => 3 * mesh.corners[3 * f + i]);
  const u = [p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]];
  const v = [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]];
  const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const length = Math.hypot(...n) || 1;
  return n.map(x => x / length);
}

// The segments of an overlay, as pairs of points.
function segmentsOf(mesh, wanted) {
  const { ends, sides, count, edges } = edgesOf(mesh), p = mesh.local, out = [], { face } = drawn(mesh);
  const isDrawn = e => [sides[2 * e], sides[2 * e + 1]].some(f => f >= 0 && face(f));
  for (let e = 0; e < edges; e++) if (wanted(count[e], sides[2 * e], sides[2 * e + 1]) && isDrawn(e)) {
    const a = 3 * ends[2 * e], b = 3 * ends[2 * e + 1];
    out.push(p[a], p[a + 1], p[a + 2], p[b], p[b + 1], p[b + 2]);
  }
  return new Float32Array(out);
}

function sharpSegments(mesh, degrees) {
  const limit = Math.cos(degrees * Math.PI / 180), normals = new Map();
  const normal = f => { let n = normals.get(f); if (!n) normals.set(f, n = faceNormal(mesh, f)); return n; };
  return segmentsOf(mesh, (n, f, g) => {
    if (n !== 2) return false;
    const a = normal(f), b = normal(g);
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] < limit;
  });
}

function meanEdge(mesh) {
  if (mesh.cache.meanEdge) return mesh.cache.meanEdge;
  const { corners, local: p, faces } = mesh, step = Math.max(1, Math.floor(faces / 20000));
  let sum = 0, n = 0;
  for (let f = 0; f < faces; f += step) for (let i = 0; i < 3; i++) {
    const a = 3 * corners[3 * f + i], b = 3 * corners[3 * f + (i + 1) % 3];
    sum += Math.hypot(p[a] - p[b], p[a + 1] - p[b + 1], p[a + 2] - p[b + 2]); n++;
  }
  return mesh.cache.meanEdge = sum / Math.max(n, 1);
}

// Directions are two bytes per vertex: a unit vector folded onto an octahedron.
function directionSegments(mesh, set, length) {
  const raw = new Uint8Array(bytesOf(set.blob).buffer), p = mesh.local, out = new Float32Array(6 * mesh.vertices);
  const half = 0.5 * length * meanEdge(mesh), { vertex } = drawn(mesh);
  let n = 0;
  for (let v = 0; v < mesh.vertices; v++) {
    if ((raw[2 * v] === 255 && raw[2 * v + 1] === 255) || !vertex(v)) continue;
    let x = raw[2 * v] / 127 - 1, y = raw[2 * v + 1] / 127 - 1;
    const z = 1 - Math.abs(x) - Math.abs(y);
    if (z < 0) [x, y] = [(1 - Math.abs(y)) * (x < 0 ? -1 : 1), (1 - Math.abs(x)) * (y < 0 ? -1 : 1)];
    const s = half / (Math.hypot(x, y, z) || 1);
    const [a, b, c] = [p[3 * v], p[3 * v + 1], p[3 * v + 2]];
    out.set([a - s * x, b - s * y, c - s * z, a + s * x, b + s * y, c + s * z], 6 * n++);
  }
  return out.subarray(0, 6 * n);
}

// ---------------------------------------------------------------- scene and state

const sceneLow = [0, 1, 2].map(i => Math.min(...wholes.map(m => m.source.center[i] - 0.5 * m.source.extent[i])));
const sceneHigh = [0, 1, 2].map(i => Math.max(...wholes.map(m => m.source.center[i] + 0.5 * m.source.extent[i])));
const sceneCenter = sceneLow.map((low, i) => 0.5 * (low + sceneHigh[i]));
const largest = Math.max(...wholes.map(m => m.radius));
const togetherRadius = 0.5 * Math.hypot(...sceneLow.map((low, i) => sceneHigh[i] - low)) || 1e-9;
// Meshes that have nothing to do with each other are each shown in the middle.
const alike = togetherRadius < 1.5 * largest && wholes.every(m => m.radius > 0.4 * largest);

const keys = new Set(meshes.flatMap(m => [...m.fields.keys()])), fieldNames = [...keys];
const anyMesh = test => meshes.some(m => test(m.source));
const COLORS = [['plain', 'Plain']];
if (anyMesh(m => m.materials !== null)) COLORS.push(['material', 'Materials']);
if (anyMesh(m => m.vertexColors !== null)) COLORS.push(['vertexColors', 'Colours of vertices']);
if (anyMesh(m => m.faceColors !== null)) COLORS.push(['faceColors', 'Colours of faces']);
for (const key of fieldNames) {
  const [on, name] = [key.slice(0, key.indexOf(':')), key.slice(key.indexOf(':') + 1)];
  COLORS.push([key, titleOf(name) + (keys.has((on === 'vertex' ? 'face:' : 'vertex:') + name) ? ` (${on})` : '')]);
}

const most = Math.max(...meshes.map(m => m.faces));
const lessMotion = matchMedia('(prefers-reduced-motion: reduce)');
const state = {
  layout: page.layout, color: 'plain', map: 'auto', range: 'auto', low: 0, high: 1, symmetric: false, log: false,
  smooth: page.start.smooth ?? most > 20000, edges: page.start.edges ?? (most <= 20000 && meshes.every(m => m.source.materials === null)), perspective: true, together: alike, backs: true, axes: true,
  overlays: new Set(page.start.overlays), sharp: 30, length: 0.8, wipe: 0.5, one: 0, blink: !lessMotion.matches, shown: 0,
  theme: 'auto', up: page.start.up, turn: [0, 0, 0, 1], target: [0, 0, 0], half: 1, picked: null, pinned: false,
  only: null, measuring: false, ends: [], cut: 'none', cutAt: 0, cutOther: false,
};
const FOV = 28 * Math.PI / 180;
const normalized = q => { const n = Math.hypot(...q); return q.map(x => x / n); };
const radius = () => state.together ? togetherRadius : largest;

function resetCamera() {
  // From the front, a little above and to the right.
  const seen = upright(times(around([1, 0, 0], 0.35), around([0, 1, 0], -0.6)));
  state.turn = normalized(state.up === page.start.up ? page.start.turn ?? seen : seen);
  fit();
  home = cameraNow();
}
// The camera as it was framed last; until it is moved, it follows the size of the window.
let home = '';
const cameraNow = () => [state.turn, state.target, state.half].join();
const isHome = () => cameraNow() === home;
// A rotation of a model whose y axis points up, for the axis that points up here.
function upright(q) {
  const H = Math.PI / 2;
  const turns = { x: [[0, 0, 1], H], y: [[0, 0, 1], 0], z: [[1, 0, 0], -H], '-x': [[0, 0, 1], -H], '-y': [[0, 0, 1], 2 * H], '-z': [[1, 0, 0], H] };
  return times(q, around(...turns[state.up]));
}
// The meshes that a frame holds: all that are compared, so that a change between them moves nothing.
// What is seen alone is framed alone.
function framed() {
  const shown = state.layout === 'one' ? [meshes[state.one]] : wholes;
  return isAlone() || shown.some(m => m.source.part) ? shown : wholes;
}
// The box around meshes as the camera sees them, on the plane of its target: right and up of the target.
function seenBox(list, isWhole = true) {
  const turned = rows(state.turn), away = state.half / Math.tan(FOV / 2), middle = turned.map(row => dot(row, state.target));
  const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
  for (const mesh of list) {
    const scale = state.together ? 1 : largest / mesh.radius, step = isWhole ? Math.max(1, Math.floor(mesh.faces / 4000)) : 1;
    const offset = mesh.source.center.map((c, i) => state.together ? c - sceneCenter[i] : 0), shows = isWhole ? null : drawn(mesh).face;
    for (let f = 0; f < 3 * mesh.faces; f += step) {
      if (shows && !shows((f / 3) | 0)) continue;
      const p = [0, 1, 2].map(i => mesh.local[3 * mesh.corners[f] + i] * scale + offset[i]);
      const nearer = state.perspective ? 1 / (1 - Math.min((dot(turned[2], p) - middle[2]) / away, 0.8)) : 1;
      for (const i of [0, 1]) {
        const x = (dot(turned[i], p) - middle[i]) * nearer;
        low[i] = Math.min(low[i], x); high[i] = Math.max(high[i], x);
      }
    }
  }
  return [low, high];
}
// As near as leaves everything in sight from here. The nearer the camera, the more the perspective
// spreads what is in front, so that a few rounds are needed.
function fit(isWhole = true) {
  const turned = rows(state.turn), { width, height } = canvas.getBoundingClientRect();
  const cell = cells(Math.max(1, width), Math.max(1, height))[0], aspect = cell.width / cell.height;
  // The share of the height that the names take, above the meshes.
  fitCanvas(); showNames();
  const names = Array.from(element('names').children, name => (name.offsetHeight + 8) / cell.height), above = Math.min(0.4, Math.max(0, ...names));
  state.target = [0, 0, 0]; state.half = radius();
  for (let round = 0; round < 6; round++) {
    const [low, high] = seenBox(framed(), isWhole);
    if (!(low[0] <= high[0])) return;
    const half = [0, 1].map(i => 0.5 * (high[i] - low[i])), tall = 1.1 * Math.max(half[1] / (1 - above), half[0] / aspect, 1e-5 * radius());
    const shift = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]) + tall * above];
    state.target = state.target.map((t, i) => t + shift[0] * turned[0][i] + shift[1] * turned[1][i]);
    state.half = tall * Math.min(1, aspect);
  }
}

const times = (a, b) => [
  a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
  a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]];
const around = (axis, angle) => [...axis.map(x => x * Math.sin(angle / 2)), Math.cos(angle / 2)];
// The rows are right, up and towards the camera.
function rows([x, y, z, w]) {
  return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]];
}
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

function turn(dx, dy) {
  state.turn = normalized(times(times(around([0, 1, 0], dx), around([1, 0, 0], dy)), state.turn));
  redraw();
}
function roll(angle) { state.turn = normalized(times(around([0, 0, 1], angle), state.turn)); redraw(); }
function pan(dx, dy) {
  const [right, up] = rows(state.turn);
  state.target = state.target.map((t, i) => t - state.half * (dx * right[i] - dy * up[i]));
  redraw();
}
// All distances to `fixed` change by the factor, so that this point stays where it is on the screen.
function zoom(factor, fixed = state.target) {
  const before = state.half;
  state.half = Math.min(Math.max(before * factor, 1e-5 * radius()), 50 * radius());
  state.target = state.target.map((t, i) => fixed[i] + (t - fixed[i]) * state.half / before);
  redraw();
}
// Places of files in the coordinates of the camera target.
const inScene = (mesh, world) => world.map((x, i) => state.together ? x - sceneCenter[i] : (x - mesh.source.center[i]) * largest / mesh.radius);
// What a zoom at a place of the canvas keeps there: the surface, or the plane of the target beside it.
function anchorAt(x, y) {
  const hit = pick(x, y);
  if (hit) return inScene(hit.mesh, hit.world);
  const width = canvas.clientWidth, height = canvas.clientHeight, up = height - y;
  const cell = cells(width, height).find(c => x >= c.clip[0] && x < c.clip[0] + c.clip[1] && up >= c.y && up < c.y + c.height);
  if (!cell) return state.target;
  const half = state.half / Math.min(1, cell.width / cell.height), scale = 2 * half / cell.height, [right, above] = rows(state.turn);
  const [dx, dy] = [(x - cell.x - cell.width / 2) * scale, (up - cell.y - cell.height / 2) * scale];
  return state.target.map((t, i) => t + dx * right[i] + dy * above[i]);
}

// ---------------------------------------------------------------- colours of values

const maps = page.maps.map(map => ({ ...map, colors: bytesOf(map.blob) }));
const LABELS = maps.find(map => map.name === 'labels');

const joined = new Map();
// All finite values under a name, over all meshes, in order.
function sorted(key) {
  if (joined.has(key)) return joined.get(key);
  const parts = meshes.map(m => m.fields.get(key)).filter(Boolean).map(f => f.values.filter(Number.isFinite));
  const all = new Float32Array(parts.reduce((n, p) => n + p.length, 0));
  let at = 0;
  for (const part of parts) { all.set(part, at); at += part.length; }
  joined.set(key, all.sort());
  return all;
}
const fieldOf = key => meshes.map(m => m.fields.get(key)).find(Boolean);
const isField = key => keys.has(key);

const labelLists = new Map();
// The different values under a name, over all meshes, in order.
function labelsOf(key) {
  if (labelLists.has(key)) return labelLists.get(key);
  const fields = meshes.map(m => m.fields.get(key)).filter(Boolean);
  const all = new Float64Array(fields.reduce((n, f) => n + f.values.length, 0));
  let at = 0;
  for (const field of fields) for (let i = 0; i < field.values.length; i++) { const x = labelOf(field, i); if (Number.isFinite(x)) all[at++] = x + 0; }
  const values = all.subarray(0, at).sort();
  let n = 0;
  for (let i = 0; i < values.length; i++) if (i === 0 || values[i] !== values[n - 1]) values[n++] = values[i];
  const list = values.slice(0, n), colors = LABELS.colors.length / 3;
  // Numbers that all have a colour of their own keep it, whatever else there is.
  const byNumber = list.every(x => Number.isInteger(x) && x >= 0 && x < colors);
  const found = { list, colors: byNumber ? Uint8Array.from(list) : Uint8Array.from(list, (_, i) => i % colors) };
  if (list.length > colors) keepApart(key, found, colors);
  labelLists.set(key, found);
  return found;
}
// Neighbours get different colours where those repeat: each label the next one that no neighbour before it has.
function keepApart(key, { list, colors }, count) {
  const neighbours = Array.from(list, () => new Set());
  for (const mesh of meshes) {
    const field = mesh.fields.get(key);
    if (!field) continue;
    const places = Int32Array.from(field.values, (_, i) => placeOf(list, labelOf(field, i))), { ends, sides, edges } = edgesOf(mesh);
    const of = field.on === 'vertex' ? ends : sides, at = i => i < 0 ? -1 : places[i];
    for (let e = 0; e < edges; e++) {
      const a = at(of[2 * e]), b = at(of[2 * e + 1]);
      if (a >= 0 && b >= 0 && a !== b) neighbours[Math.max(a, b)].add(Math.min(a, b));
    }
  }
  neighbours.forEach((others, i) => {
    const taken = new Set([...others].map(other => colors[other]));
    for (let tries = 0; taken.has(colors[i]) && tries < count; tries++) colors[i] = (colors[i] + 1) % count;
  });
}
// Whether the colours of labels suit values: whole numbers, few of them unless they are labels.
function areLabels(key) {
  const count = LABELS.colors.length / 3, isWhole = field => field.values.every(x => !Number.isFinite(x) || Number.isInteger(x));
  return fieldOf(key).label || (meshes.every(m => !m.fields.has(key) || isWhole(m.fields.get(key))) && labelsOf(key).list.length <= count);
}
// The place of a label in the list, or -1.
function placeOf(list, x) {
  let low = 0, high = list.length;
  while (low < high) { const middle = (low + high) >> 1; if (list[middle] < x) low = middle + 1; else high = middle; }
  return list[low] === x ? low : -1;
}
// The colour of each element of a mesh, as its place in the map of labels; -1 for none, -2 for what is hidden.
function labelColors(mesh, key) {
  const field = mesh.fields.get(key), { list, colors } = labelsOf(key), { only } = state;
  return Float32Array.from(field.values, (_, i) => {
    const at = placeOf(list, labelOf(field, i));
    return only !== null && list[at] !== only ? -2 : at < 0 ? -1 : colors[at];
  });
}
// The vertices and faces of a mesh that are drawn; all, unless one label is alone.
function drawn(mesh) {
  const field = isAlone() ? mesh.fields.get(state.color) : null, { corners } = mesh;
  if (!field) return { vertex: () => true, face: () => true };
  const has = i => labelOf(field, i) === state.only;
  if (field.on === 'vertex') return { vertex: has, face: f => [0, 1, 2].some(i => has(corners[3 * f + i])) };
  const vertices = new Uint8Array(mesh.vertices);
  for (let h = 0; h < corners.length; h++) if (has((h / 3) | 0)) vertices[corners[h]] = 1;
  return { vertex: v => vertices[v] === 1, face: has };
}
const showsLabels = () => isField(state.color) && currentMap().name === 'labels';
const isAlone = () => state.only !== null && showsLabels();
const labelColor = (key, at) => { const i = 3 * labelsOf(key).colors[at]; return `rgb(${LABELS.colors[i]} ${LABELS.colors[i + 1]} ${LABELS.colors[i + 2]})`; };
const labelText = x => Number.isInteger(x) ? String(x) : digits(x);
// What the legend tells: so many labels, or the one that is alone, and what is not among them.
function legendOf(key, most) {
  const { list } = labelsOf(key), notes = [];
  const shown = Array.from(list.subarray(0, most), (value, i) => ({ value, color: labelColor(key, i), text: labelText(value) }));
  // One that is alone is told, however many are before it.
  const at = isAlone() ? placeOf(list, state.only) : -1;
  if (at >= most) shown[most - 1] = { value: list[at], color: labelColor(key, at), text: labelText(list[at]) };
  if (list.length > most) notes.push(`and ${grouped(list.length - most)} more`);
  if (list.length > LABELS.colors.length / 3) notes.push('colours repeat');
  return { shown, notes };
}

function autoRange() {
  let values = sorted(state.color);
  if (state.log) values = values.subarray(values.findIndex(x => x > 0) < 0 ? values.length : values.findIndex(x => x > 0));
  if (!values.length) return [0, 1];
  const at = share => values[Math.round(share * (values.length - 1))];
  const cut = { auto: 0.02, five: 0.05, full: 0 }[state.range] ?? 0;
  let [low, high] = [at(cut), at(1 - cut)];
  // Where nearly all are alike, the others are what there is to see.
  if (low === high) [low, high] = [at(0), at(1)];
  if (state.symmetric && !state.log) { high = Math.max(Math.abs(low), Math.abs(high)); low = -high; }
  return [low, high];
}
function currentMap() {
  const name = state.map !== 'auto' ? state.map
    : page.start.map ?? (fieldOf(state.color)?.label && !page.start.range ? 'labels' : state.symmetric && !state.log ? 'red-blue' : 'viridis');
  return maps.find(m => m.name === name) ?? maps[0];
}
function place(x) {
  if (Number.isNaN(x) || (state.log && x <= 0)) return null;
  const u = state.log ? t => Math.log(Math.max(t, 1e-38)) : t => t;
  const extent = u(state.high) - u(state.low);
  return extent > 0 ? Math.min(Math.max((u(x) - u(state.low)) / extent, 0), 1) : 0.5;
}
function colorAt(t) {
  const { colors } = currentMap(), i = 3 * Math.round(t * (colors.length / 3 - 1));
  return `rgb(${colors[i]} ${colors[i + 1]} ${colors[i + 2]})`;
}

// ---------------------------------------------------------------- drawing

const gl = canvas.getContext('webgl2', { antialias: true, alpha: false, preserveDrawingBuffer: false, powerPreference: 'high-performance' });
if (!gl) {
  element('problem').hidden = false;
  return;
}

const HEAD = `#version 300 es
precision highp float; precision highp int;
precision highp sampler2D; precision highp usampler2D; precision highp isampler2D; precision highp sampler2DArray;
`;
const LOOKUP = `
uniform usampler2D tIndex; uniform sampler2D tPosition;
uniform mat3 uTurn; uniform vec3 uOffset; uniform float uScale; uniform float uAway; uniform mat4 uProjection;
ivec2 at(int i) { return ivec2(i & 4095, i >> 12); }
uniform vec4 uCut; out float vCut;
vec3 seen(vec3 p) { vCut = dot(uCut.xyz, p * uScale + uOffset) - uCut.w; return uTurn * (p * uScale + uOffset) - vec3(0., 0., uAway); }
`;
// The label of the nearest corner.
const NEAREST = `int nearest(vec3 at, vec3 labels) { return int(at.x >= at.y && at.x >= at.z ? labels.x : at.y >= at.z ? labels.y : labels.z); }
`;
const FACES = [`${HEAD}${LOOKUP}
uniform isampler2D tNormal; uniform sampler2D tValue; uniform usampler2D tUvIndex; uniform sampler2D tUv;
uniform usampler2D tFaceMaterial; uniform sampler2D tMaterial;
uniform int uMode; uniform bool uSmooth; uniform int uPass;
out vec3 vNormal; out vec3 vEye; out vec3 vBary; out vec2 vValue; out vec4 vColor; out vec2 vUv; flat out vec4 vMaterial; flat out vec4 vBase; flat out vec3 vLabel;
void main() {
  int face = gl_VertexID / 3, corner = gl_VertexID - 3 * face;
  ivec3 t = ivec3(texelFetch(tIndex, at(face), 0).xyz);
  int v = t[corner];
  vec3 p = texelFetch(tPosition, at(v), 0).xyz;
  if (uSmooth) vNormal = vec3(texelFetch(tNormal, at(v), 0).xyz);
  else {
    vec3 a = texelFetch(tPosition, at(t.x), 0).xyz, b = texelFetch(tPosition, at(t.y), 0).xyz, c = texelFetch(tPosition, at(t.z), 0).xyz;
    vNormal = cross(b - a, c - a);
  }
  vNormal = uTurn * normalize(dot(vNormal, vNormal) > 0. ? vNormal : vec3(0., 0., 1.));
  vBary = vec3(corner == 0, corner == 1, corner == 2);
  vLabel = vec3(-1.);
  vValue = vec2(0.); vColor = vec4(.78, .78, .76, 1.); vUv = vec2(0.); vMaterial = vec4(-1., 1., 0., 0.); vBase = vec4(1.);
  if (uMode == 1 || uMode == 2) {
    float x = texelFetch(tValue, at(uMode == 1 ? v : face), 0).x;
    bool missing = isnan(x);
    vValue = vec2(missing ? 0. : clamp(x, -1e37, 1e37), missing ? 1. : 0.);
  } else if (uMode == 3 || uMode == 4) vColor = texelFetch(tValue, at(uMode == 3 ? v : face), 0);
  else if (uMode == 6) vLabel = vec3(texelFetch(tValue, at(t.x), 0).x, texelFetch(tValue, at(t.y), 0).x, texelFetch(tValue, at(t.z), 0).x);
  else if (uMode == 7) vLabel = vec3(texelFetch(tValue, at(face), 0).x);
  else if (uMode == 5) {
    int m = int(texelFetch(tFaceMaterial, at(face), 0).x);
    vBase = texelFetch(tMaterial, at(2 * m), 0); vMaterial = texelFetch(tMaterial, at(2 * m + 1), 0);
    vUv = texelFetch(tUv, at(int(texelFetch(tUvIndex, at(face), 0)[corner])), 0).xy;
    bool blended = vMaterial.w < -.5;
    if (blended != (uPass == 1)) { gl_Position = vec4(2., 2., 2., 1.); return; }
  }
  vEye = seen(p);
  gl_Position = uProjection * vec4(vEye, 1.);
}`, `${HEAD}
in float vCut; in vec3 vNormal; in vec3 vEye; in vec3 vBary; in vec2 vValue; in vec4 vColor; in vec2 vUv; flat in vec4 vMaterial; flat in vec4 vBase; flat in vec3 vLabel;
uniform int uMode; uniform sampler2D tMap; uniform sampler2DArray tImages; uniform vec2 uRange; uniform bool uLog; uniform bool uEdges; uniform bool uTint; uniform vec3 uEdgeColor;
out vec4 color;
${NEAREST}void main() {
  if (vCut > 0.) discard;
  vec3 base = vColor.rgb; float alpha = 1.; vec3 n = normalize(vNormal); float rough = 1., metal = 0.;
  if (uMode == 1 || uMode == 2) {
    float x = vValue.x; bool missing = vValue.y > .001;
    if (uLog) { missing = missing || x <= 0.; x = log(max(x, 1e-38)); }
    float t = uRange.y > uRange.x ? (x - uRange.x) / (uRange.y - uRange.x) : .5;
    base = missing ? vec3(140. / 255.) : texture(tMap, vec2(clamp(t, 0., 1.) * 255. / 256. + .5 / 256., .5)).rgb;
  } else if (uMode == 6 || uMode == 7) {
    int i = nearest(vBary, vLabel);
    if (i == -2) discard;
    base = i < 0 ? vec3(140. / 255.) : texelFetch(tMap, ivec2(i, 0), 0).rgb;
  } else if (uMode == 5) {
    vec4 texel = vMaterial.x < 0. ? vec4(1.) : texture(tImages, vec3(vUv.x, 1. - vUv.y, vMaterial.x));
    base = pow(clamp(vBase.rgb, 0., 1.), vec3(1. / 2.2)) * texel.rgb;
    float opacity = vBase.a * texel.a;
    if (vMaterial.w > 0. && opacity < vMaterial.w) discard;
    if (vMaterial.w < -.5) alpha = opacity;
    rough = vMaterial.y; metal = vMaterial.z;
  }
  bool back = !gl_FrontFacing;
  if (n.z < 0.) n = -n;
  float light = .22 + .62 * max(dot(n, normalize(vec3(-.7, .6, 1.))), 0.) + .22 * max(dot(n, normalize(vec3(.9, 0., 1.))), 0.);
  vec3 lit = base * light;
  if (rough < 1.) lit += mix(vec3(1.), base, metal) * (1. - rough) * .6 * pow(max(dot(n, normalize(vec3(-.35, .3, 1.))), 0.), mix(80., 6., rough));
  if (back && uTint) lit = mix(lit, vec3(.45, .28, .5) * light, uMode == 0 ? .8 : .35);
  if (uEdges) {
    vec3 w = fwidth(vBary), d = smoothstep(vec3(0.), w * 1.1, vBary);
    float wide = max(w.x, max(w.y, w.z));
    lit = mix(lit, uEdgeColor, (1. - min(d.x, min(d.y, d.z))) * (1. - smoothstep(.12, .6, wide)) * .8);
  }
  color = vec4(lit, alpha);
}`];
const PICK = [`${HEAD}${LOOKUP}
flat out uint vFace; flat out vec3 vLabel; out vec3 vBary; uniform sampler2D tValue; uniform int uMode;
void main() {
  int face = gl_VertexID / 3, corner = gl_VertexID - 3 * face;
  ivec3 t = ivec3(texelFetch(tIndex, at(face), 0).xyz);
  vFace = uint(face);
  vBary = vec3(corner == 0, corner == 1, corner == 2);
  vLabel = vec3(0.);
  if (uMode == 6) vLabel = vec3(texelFetch(tValue, at(t.x), 0).x, texelFetch(tValue, at(t.y), 0).x, texelFetch(tValue, at(t.z), 0).x);
  else if (uMode == 7) vLabel = vec3(texelFetch(tValue, at(face), 0).x);
  gl_Position = uProjection * vec4(seen(texelFetch(tPosition, at(t[corner]), 0).xyz), 1.);
}`, `${HEAD}
flat in uint vFace; flat in vec3 vLabel; in vec3 vBary; in float vCut; uniform uint uMesh; out uvec2 id;
${NEAREST}void main() { if (vCut > 0. || nearest(vBary, vLabel) == -2) discard; id = uvec2(uMesh + 1u, vFace); }`];
const LINES = [`${HEAD}
layout(location = 0) in vec3 a; layout(location = 1) in vec3 b;
uniform mat3 uTurn; uniform vec3 uOffset; uniform float uScale; uniform float uAway; uniform mat4 uProjection; uniform vec2 uPixel; uniform float uWidth; uniform vec4 uCut;
out vec2 vAt; flat out float vLong; out float vCut;
void main() {
  vec3 p = uTurn * (a * uScale + uOffset) - vec3(0., 0., uAway), q = uTurn * (b * uScale + uOffset) - vec3(0., 0., uAway);
  vec4 s = uProjection * vec4(p, 1.), e = uProjection * vec4(q, 1.);
  vec2 across = (e.xy / e.w - s.xy / s.w) / uPixel;
  float long_ = length(across);
  vec2 along = long_ > 1e-6 ? across / long_ : vec2(1., 0.);
  bool end = gl_VertexID > 1; float side = gl_VertexID % 2 == 0 ? -1. : 1.;
  vec4 c = end ? e : s; float h = .5 * uWidth;
  vec2 shift = (end ? along : -along) * h + vec2(-along.y, along.x) * side * h;
  vAt = vec2(end ? long_ + h : -h, side * h); vLong = long_;
  vCut = dot(uCut.xyz, (end ? b : a) * uScale + uOffset) - uCut.w;
  c.xy += shift * uPixel * c.w; c.z -= .0006 * c.w;
  gl_Position = c;
}`, `${HEAD}
in vec2 vAt; in float vCut; flat in float vLong; uniform vec4 uColor; uniform float uWidth; out vec4 color;
void main() {
  vec2 d = vec2(vAt.x - clamp(vAt.x, 0., vLong), vAt.y);
  if (length(d) > .5 * uWidth || vCut > 0.) discard;
  color = uColor;
}`];

function program([vertex, fragment]) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text); gl.compileShader(shader); gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(gl.getProgramInfoLog(made) + gl.getAttachedShaders(made).map(s => gl.getShaderInfoLog(s)).join(' '));
  }
  const places = new Map();
  return { made, at: name => { if (!places.has(name)) places.set(name, gl.getUniformLocation(made, name)); return places.get(name); } };
}

let programs, empty, mapTexture, pickTarget;
const UNITS = { tIndex: 0, tPosition: 1, tNormal: 2, tValue: 3, tMap: 4, tUvIndex: 5, tUv: 6, tFaceMaterial: 7, tMaterial: 8, tImages: 9 };
// Where textures are filled, so that none that is in use loses its place.
const SPARE = 15;

function start() {
  programs = { faces: program(FACES), pick: program(PICK), lines: program(LINES) };
  for (const p of [programs.faces, programs.pick]) {
    gl.useProgram(p.made);
    for (const [name, unit] of Object.entries(UNITS)) gl.uniform1i(p.at(name), unit);
  }
  empty = gl.createVertexArray();
  mapTexture = null; pickTarget = null;
  for (const mesh of meshes) { mesh.textures = {}; mesh.overlays = new Map(); }
  const one = (kind, data) => table(kind, data, 1);
  start.none = {
    tNormal: one('RGBA16I', new Int16Array(4)), tValue: one('RGBA8', new Uint8Array(4)), tUvIndex: one('RGB32UI', new Uint32Array(3)),
    tUv: one('RG32F', new Float32Array(2)), tFaceMaterial: one('R32UI', new Uint32Array(1)), tMaterial: one('RGBA32F', new Float32Array(4)),
  };
  start.none.tImages = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D_ARRAY, start.none.tImages);
  gl.texImage3D(gl.TEXTURE_2D_ARRAY, 0, gl.RGBA8, 1, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array([255, 255, 255, 255]));
}

const KINDS = {
  RGB32UI: [3, 'RGB_INTEGER', 'UNSIGNED_INT', Uint32Array], RGB32F: [3, 'RGB', 'FLOAT', Float32Array], RGBA16I: [4, 'RGBA_INTEGER', 'SHORT', Int16Array],
  R32F: [1, 'RED', 'FLOAT', Float32Array], RGBA8: [4, 'RGBA', 'UNSIGNED_BYTE', Uint8Array], RG32F: [2, 'RG', 'FLOAT', Float32Array],
  R32UI: [1, 'RED_INTEGER', 'UNSIGNED_INT', Uint32Array], RGBA32F: [4, 'RGBA', 'FLOAT', Float32Array],
};
// An array as a texture of rows of 4096.
function table(kind, data, width = 4096) {
  const [channels, format, type, Kind] = KINDS[kind], count = data.length / channels, height = Math.max(1, Math.ceil(count / width));
  const texture = gl.createTexture();
  bind(SPARE, texture);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl[kind], width, height);
  for (const [name, value] of [['MIN_FILTER', 'NEAREST'], ['MAG_FILTER', 'NEAREST'], ['WRAP_S', 'CLAMP_TO_EDGE'], ['WRAP_T', 'CLAMP_TO_EDGE']]) {
    gl.texParameteri(gl.TEXTURE_2D, gl['TEXTURE_' + name], gl[value]);
  }
  const whole = Math.floor(count / width), rest = count - whole * width;
  if (whole) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, whole, gl[format], gl[type], data.subarray(0, whole * width * channels));
  if (rest) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, whole, rest, 1, gl[format], gl[type], Kind.from(data.subarray(whole * width * channels)));
  return texture;
}

const textureOf = (mesh, name, make) => mesh.textures[name] ??= make();

function bind(unit, texture, target = gl.TEXTURE_2D) {
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(target, texture);
}

// For each material red, green, blue, opacity, picture, roughness, metallic and alpha; see page.rs.
const materialsOf = mesh => mesh.cache.materials ??= floatsOf(mesh.source.materials.list);
const isBlended = mesh => mesh.cache.isBlended ??= materialsOf(mesh).some((x, i) => i % 8 === 7 && x < 0);

// The side of the squares that hold pictures. One large picture must not make thousands of small ones large: the squares
// have at most 1 GiB, or four times the pixels of all pictures.
function sideOfPictures(sizes, limit) {
  const longest = sizes.reduce((most, size) => Math.max(most, ...size), 1);
  const most = Math.max(2 ** 28, 4 * sizes.reduce((sum, [width, height]) => sum + width * height, 0));
  let side = Math.min(2048, limit, 2 ** Math.ceil(Math.log2(longest)));
  while (side > 1 && side * side * sizes.length > most) side /= 2;
  return side;
}

// Pictures of one size in an array, so that a mesh is one draw whatever its materials.
async function loadImages(mesh) {
  const { materials } = mesh.source;
  if (!materials?.images.length) return;
  const bitmaps = await Promise.all(materials.images.map(image =>
    createImageBitmap(new Blob([bytesOf(image.blob)], { type: image.type })).catch(() => null)));
  const size = sideOfPictures(bitmaps.map(b => b ? [b.width, b.height] : [1, 1]), gl.getParameter(gl.MAX_TEXTURE_SIZE));
  mesh.cache.images = bitmaps.map(bitmap => {
    const sheet = new OffscreenCanvas(size, size), pen = sheet.getContext('2d');
    if (bitmap) pen.drawImage(bitmap, 0, 0, size, size);
    else { pen.fillStyle = '#fff'; pen.fillRect(0, 0, size, size); }
    return pen.getImageData(0, 0, size, size);
  });
}
function imagesTexture(mesh) {
  const images = mesh.cache.images;
  if (!images?.length) return start.none.tImages;
  return textureOf(mesh, 'images', () => {
    const texture = gl.createTexture(), size = images[0].width;
    bind(SPARE, texture, gl.TEXTURE_2D_ARRAY);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, Math.log2(size) + 1, gl.RGBA8, size, size, images.length);
    images.forEach((image, i) => gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, i, size, size, 1, gl.RGBA, gl.UNSIGNED_BYTE, image.data));
    gl.generateMipmap(gl.TEXTURE_2D_ARRAY);
    gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    return texture;
  });
}

function bindMesh(mesh) {
  bind(0, textureOf(mesh, 'index', () => table('RGB32UI', mesh.corners)));
  bind(1, textureOf(mesh, 'positions', () => table('RGB32F', mesh.local)));
}

// The labels as they are drawn. Of those that were alone, the last is kept.
function labelTexture(mesh) {
  const { color, only } = state, { textures } = mesh, make = () => table('R32F', labelColors(mesh, color));
  if (only === null) return textureOf(mesh, 'labels ' + color, make);
  const key = color + ' ' + only;
  if (textures.aloneOf !== key) { gl.deleteTexture(textures.alone ?? null); textures.alone = make(); textures.aloneOf = key; }
  return textures.alone;
}

// Which data colour a mesh; the number is that of the shader.
function bindColors(mesh) {
  const { source } = mesh, none = start.none;
  for (const name of ['tValue', 'tUvIndex', 'tUv', 'tFaceMaterial', 'tMaterial']) bind(UNITS[name], none[name]);
  bind(UNITS.tImages, none.tImages, gl.TEXTURE_2D_ARRAY);
  bind(UNITS.tNormal, state.smooth ? textureOf(mesh, 'normals', () => table('RGBA16I', vertexNormals(mesh))) : none.tNormal);
  const field = mesh.fields.get(state.color);
  if (field && showsLabels()) {
    bind(3, labelTexture(mesh));
    return field.on === 'vertex' ? 6 : 7;
  }
  if (field) {
    bind(3, textureOf(mesh, state.color, () => table('R32F', field.values)));
    return field.on === 'vertex' ? 1 : 2;
  }
  if (state.color === 'vertexColors' && source.vertexColors !== null) {
    bind(3, textureOf(mesh, 'vertexColors', () => table('RGBA8', bytesOf(source.vertexColors))));
    return 3;
  }
  if (state.color === 'faceColors' && source.faceColors !== null) {
    bind(3, textureOf(mesh, 'faceColors', () => table('RGBA8', bytesOf(source.faceColors))));
    return 4;
  }
  if (state.color === 'material' && source.materials) {
    const { materials: m } = source;
    bind(5, textureOf(mesh, 'uvIndex', () => table('RGB32UI', m.uvIndex === null ? new Uint32Array(3 * mesh.faces) : integersOf(m.uvIndex, 3 * mesh.faces))));
    bind(6, textureOf(mesh, 'uv', () => table('RG32F', m.uvs === null ? new Float32Array(2) : floatsOf(m.uvs))));
    bind(7, textureOf(mesh, 'faceMaterial', () => table('R32UI', integersCached(mesh))));
    bind(8, textureOf(mesh, 'materials', () => table('RGBA32F', materialsOf(mesh))));
    bind(9, imagesTexture(mesh), gl.TEXTURE_2D_ARRAY);
    return 5;
  }
  return 0;
}

// Whether what is seen from behind is tinted: a tint would spoil values and materials.
const isTinted = mesh => state.backs && !mesh.fields.has(state.color) && !(state.color === 'material' && mesh.source.materials);
// What is in front of this plane is cut off: its normal, and its distance from the camera target.
function cutPlane(turned) {
  // A plane so far away that it cuts nothing.
  if (state.cut === 'none') return [0, 0, 0, 1];
  const axis = 'xyz'.indexOf(state.cut), away = axis < 0 ? turned[2] : [0, 1, 2].map(i => Number(i === axis));
  // Half the size of what there is to cut, in this direction.
  const reach = axis < 0 ? radius() : state.together ? 0.5 * (sceneHigh[axis] - sceneLow[axis]) : Math.max(...meshes.map(m => 0.5 * m.source.extent[axis] * largest / m.radius));
  const side = state.cutOther ? -1 : 1;
  return [...away.map(x => side * x), side * (state.cutAt * reach - dot(away, state.target))];
}
function setCamera(p, mesh, aspect) {
  const turned = rows(state.turn), scale = state.together ? 1 : largest / mesh.radius;
  const away = state.half / Math.tan(FOV / 2);
  const offset = mesh.source.center.map((c, i) => (state.together ? c - sceneCenter[i] : 0) - state.target[i]);
  // The nearest and farthest that anything can be.
  const reach = Math.hypot(...state.target) + 1.05 * radius();
  let near = Math.max(away - reach, 1e-3 * away), far = away + reach;
  // A narrow window must not cut the sides off.
  const half = state.half / Math.min(1, aspect);
  let m;
  if (state.perspective) {
    const f = away / half;
    m = [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (near + far) / (near - far), -1, 0, 0, 2 * near * far / (near - far), 0];
  } else {
    near = away - reach; far = away + reach;
    m = [1 / (half * aspect), 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, 2 / (near - far), 0, 0, 0, (near + far) / (near - far), 1];
  }
  gl.uniformMatrix3fv(p.at('uTurn'), true, turned.flat());
  gl.uniform3fv(p.at('uOffset'), offset);
  gl.uniform4fv(p.at('uCut'), cutPlane(turned));
  gl.uniform1f(p.at('uScale'), scale);
  gl.uniform1f(p.at('uAway'), away);
  gl.uniformMatrix4fv(p.at('uProjection'), false, m);
  return { turned, scale, away, offset, half, aspect };
}

// The number of the mesh on the left of the border, and the place of the border in this width.
function border(width) {
  const first = Math.min(Math.floor(state.wipe), wholes.length - 2);
  return { first, cut: Math.round((1 - (state.wipe - first)) * width) };
}
// Which mesh is where, in pixels of the canvas from its lower left.
function cells(width, height) {
  const whole = { x: 0, y: 0, width, height };
  const clipped = (mesh, x, w) => ({ mesh, ...whole, clip: [x, w] });
  const n = wholes.length;
  if (state.layout === 'one') return [clipped(meshes[state.one], 0, width)];
  if (n > 1 && state.layout === 'wipe') {
    const { first, cut } = border(width);
    return [clipped(wholes[first], 0, cut), clipped(wholes[first + 1], cut, width - cut)].filter(c => c.clip[1] > 0);
  }
  if (n > 1 && state.layout !== 'side') {
    return [clipped(state.layout === 'blink' ? wholes[state.shown % n] : levelNow(), 0, width)];
  }
  let best = 1, size = 0;
  for (let columns = 1; columns <= n; columns++) {
    const side = Math.min(width / columns, height / Math.ceil(n / columns));
    if (side > size * 1.02) [best, size] = [columns, side];
  }
  const lines = Math.ceil(n / best);
  return wholes.map((mesh, i) => {
    const [left, right] = [i % best, i % best + 1].map(k => Math.round(k * width / best));
    const [bottom, top] = [lines - 1 - Math.floor(i / best), lines - Math.floor(i / best)].map(k => Math.round(k * height / lines));
    return { mesh, x: left, y: bottom, width: right - left, height: top - bottom, clip: [left, right - left] };
  });
}

// Half the height of the picture, on the plane of the target: a narrow one does not cut the sides off.
const halfHeight = () => state.half / Math.min(1, canvas.clientWidth / canvas.clientHeight);
// The level that the share of the diagonal in the height of the picture asks for.
const coverage = () => largest / halfHeight();
function levelNow() {
  const share = coverage();
  return wholes.find(m => m.source.coverage !== null && share >= m.source.coverage) ?? wholes.at(-1);
}

// Ends the names of lines on what is drawn of a mesh while one label is alone.
const ALONE = '\0';
function overlaysOf(mesh) {
  const { source } = mesh, list = [], alone = isAlone() ? ALONE + state.color + state.only : '';
  const add = (name, color, width, make, on = true) => {
    if (on && state.overlays.has(name)) {
      const key = name + (name === 'Sharp edges' ? state.sharp : '') + (source.directions.some(d => d.name === name) ? state.length : '') + alone;
      if (!mesh.overlays.has(key)) mesh.overlays.set(key, lineArray(make()));
      list.push({ ...mesh.overlays.get(key), color, width });
    }
  };
  add('Sharp edges', [0.95, 0.55, 0.05], 2.2, () => sharpSegments(mesh, state.sharp));
  add('Boundary', [0.02, 0.55, 0.9], 3, () => segmentsOf(mesh, n => n === 1));
  add('Non-manifold edges', [0.85, 0.05, 0.3], 4, () => segmentsOf(mesh, n => n > 2));
  for (const d of source.directions) add(d.name, d.color.map(c => c / 255), 1.4, () => directionSegments(mesh, d, state.length));
  for (const l of source.lines) add(l.name, l.color.map(c => c / 255), l.width, () => floatsOf(l.blob));
  return list;
}
function lineArray(segments) {
  const vao = gl.createVertexArray(), buffer = gl.createBuffer();
  gl.bindVertexArray(vao);
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, segments, gl.STATIC_DRAW);
  for (const place of [0, 1]) {
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 24, 12 * place);
    gl.vertexAttribDivisor(place, 1);
  }
  gl.bindVertexArray(null);
  return { vao, buffer, count: segments.length / 6 };
}
function drawLines(line, pixel) {
  const p = programs.lines;
  gl.uniform2f(p.at('uPixel'), ...pixel);
  gl.uniform1f(p.at('uWidth'), line.width * drawLines.ratio);
  gl.uniform4f(p.at('uColor'), ...line.color, 1);
  gl.bindVertexArray(line.vao);
  gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, line.count);
}

const themeNow = () => state.theme === 'auto' ? (matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light') : state.theme;
const behind = () => themeNow() === 'dark' ? [0.09, 0.1, 0.115] : [1, 1, 1];

function draw(width, height, ratio) {
  drawLines.ratio = ratio;
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.enable(gl.DEPTH_TEST); gl.enable(gl.SCISSOR_TEST); gl.disable(gl.BLEND); gl.depthMask(true);
  gl.clearColor(...behind(), 1);
  gl.scissor(0, 0, width, height);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  const isLog = state.log, [low, high] = [state.low, state.high].map(x => isLog ? Math.log(Math.max(x, 1e-38)) : x);
  if (!mapTexture || mapTexture.name !== currentMap().name) {
    const { name, colors } = currentMap(), texture = mapTexture?.texture ?? gl.createTexture();
    bind(4, texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, colors.length / 3, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, colors);
    for (const name of ['WRAP_S', 'WRAP_T']) gl.texParameteri(gl.TEXTURE_2D, gl['TEXTURE_' + name], gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    mapTexture = { texture, name };
  }
  for (const cell of cells(width, height)) {
    const { mesh, clip } = cell, p = programs.faces, aspect = cell.width / cell.height;
    gl.viewport(cell.x, cell.y, cell.width, cell.height);
    gl.scissor(clip[0], cell.y, clip[1], cell.height);
    gl.useProgram(p.made);
    gl.bindVertexArray(empty);
    const mode = bindColors(mesh);
    bindMesh(mesh);
    bind(4, mapTexture.texture);
    setCamera(p, mesh, aspect);
    gl.uniform1i(p.at('uMode'), mode);
    gl.uniform1i(p.at('uSmooth'), state.smooth);
    gl.uniform1i(p.at('uEdges'), state.edges);
    gl.uniform1i(p.at('uTint'), isTinted(mesh));
    gl.uniform3f(p.at('uEdgeColor'), 0.1, 0.1, 0.12);
    gl.uniform2f(p.at('uRange'), low, high);
    gl.uniform1i(p.at('uLog'), isLog);
    gl.uniform1i(p.at('uPass'), 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3 * mesh.faces);
    if (mode === 5 && isBlended(mesh)) {
      gl.enable(gl.BLEND); gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA); gl.depthMask(false);
      gl.uniform1i(p.at('uPass'), 1);
      gl.drawArrays(gl.TRIANGLES, 0, 3 * mesh.faces);
      gl.disable(gl.BLEND); gl.depthMask(true);
    }
    gl.useProgram(programs.lines.made);
    setCamera(programs.lines, mesh, aspect);
    const pixel = [2 / cell.width, 2 / cell.height];
    for (const overlay of overlaysOf(mesh)) drawLines(overlay, pixel);
    drawMeasured(mesh, pixel);
    if (state.picked) {
      const at = state.picked.world.map((x, i) => state.together ? x - mesh.source.center[i] : state.picked.mesh === mesh ? x - mesh.source.center[i] : NaN);
      if (!Number.isNaN(at[0])) {
        const dot = lineArray(new Float32Array([...at, ...at]));
        drawLines({ ...dot, color: [0, 0, 0], width: 10 }, pixel);
        gl.depthFunc(gl.LEQUAL);
        drawLines({ ...dot, color: [1, 0.85, 0], width: 6 }, pixel);
        gl.depthFunc(gl.LESS);
        gl.deleteVertexArray(dot.vao); gl.deleteBuffer(dot.buffer);
      }
    }
  }
}

// The measured line shows through the surface, so that its length is seen from anywhere.
function drawMeasured(mesh, pixel) {
  const { ends } = state;
  if (!ends.length || !(state.together || ends.every(end => end.mesh === mesh))) return;
  const places = ends.map(end => end.world.map((x, i) => x - mesh.source.center[i]));
  const line = lineArray(new Float32Array([...places[0], ...places.at(-1)])), dots = lineArray(new Float32Array(places.flatMap(at => [...at, ...at])));
  gl.disable(gl.DEPTH_TEST);
  gl.uniform4f(programs.lines.at('uCut'), 0, 0, 0, 1);
  for (const [color, width, dot] of [[[0, 0, 0], 5, 12], [[1, 0.85, 0], 2.5, 8]]) { drawLines({ ...line, color, width }, pixel); drawLines({ ...dots, color, width: dot }, pixel); }
  gl.enable(gl.DEPTH_TEST);
  setCamera(programs.lines, mesh, pixel[1] / pixel[0]);
  for (const { vao, buffer } of [line, dots]) { gl.deleteVertexArray(vao); gl.deleteBuffer(buffer); }
}
const distanceOf = ([a, b]) => Math.hypot(...a.world.map((x, i) => x - b.world[i]));
function measure(hit) {
  if (!hit) { live.textContent = 'Nothing here'; return; }
  if (state.ends.length === 2) state.ends = [];
  state.ends.push({ mesh: hit.mesh, world: hit.world });
  showMeasured(true);
  redraw();
}
function showMeasured(aloud) {
  const [a, b] = state.ends, box = element('measured');
  let text = !state.measuring ? '' : a ? 'Click the second point.' : 'Click the first point, or press X for the middle of the picture.';
  if (b) {
    const across = a.world.map((x, i) => Math.abs(x - b.world[i]));
    text = `Distance ${withUnit(digits(distanceOf(state.ends), 5), LENGTH)} (x ${digits(across[0], 4)}, y ${digits(across[1], 4)}, z ${digits(across[2], 4)})`;
  }
  box.textContent = text;
  if (aloud) live.textContent = text;
}
function setMeasuring(on) {
  state.measuring = on;
  if (!on) state.ends = [];
  controls.measure.setAttribute('aria-pressed', String(on));
  controls.measure.textContent = on ? 'Stop measuring (M)' : 'Measure a distance (M)';
  canvas.classList.toggle('aim', on);
  showMeasured(true);
  redraw();
}
// The number beside the middle of its line.
function showLength() {
  const box = element('length-of'), { ends } = state, width = canvas.width / ratio(), height = canvas.height / ratio();
  const cell = ends.length === 2 && cells(width, height).find(c => state.together || ends.every(end => end.mesh === c.mesh));
  box.hidden = !cell;
  if (!cell) return;
  const middle = ends[0].world.map((x, i) => 0.5 * (x + ends[1].world[i]));
  const seen = inScene(cell.mesh, middle).map((x, i) => x - state.target[i]), turned = rows(state.turn).map(row => dot(row, seen));
  const away = state.half / Math.tan(FOV / 2), nearer = state.perspective ? away / (away - turned[2]) : 1, half = state.half / Math.min(1, cell.width / cell.height);
  const scale = cell.height / (2 * half) * nearer, x = cell.x + 0.5 * cell.width + turned[0] * scale, y = height - cell.y - 0.5 * cell.height - turned[1] * scale;
  box.textContent = withUnit(digits(distanceOf(ends), 5), LENGTH);
  box.hidden = !(nearer > 0 && x >= 0 && x <= width && y >= 0 && y <= height);
  box.style.left = x + 'px'; box.style.top = y + 'px';
}

// Nothing is drawn until the pictures are there: the first picture is whole.
let isLoaded = false, asked = false, version = 0;
const viewer = { ready: false, frames: 0, loaded: null, frame: null, state, meshes, sideOfPictures, error: null };
window.curvmesh = viewer;
function redraw() {
  version++;
  if (asked || !isLoaded) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    if (gl.isContextLost()) return;
    fitCanvas();
    draw(canvas.width, canvas.height, ratio());
    showNames();
    showBorder();
    showAxes();
    showLevel();
    showLength();
    writeLater();
    viewer.frames++;
    if (!viewer.ready) { viewer.ready = true; gl.finish(); viewer.loaded = performance.now() - started; viewer.first = performance.now(); }
  });
}
const ratio = () => Math.min(devicePixelRatio || 1, 2);
function fitCanvas() {
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio())), height = Math.max(1, Math.round(canvas.clientHeight * ratio()));
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
}
// A frame from start to end, in milliseconds: for those who measure.
viewer.time = () => {
  const pixel = new Uint8Array(4), before = performance.now();
  draw(canvas.width, canvas.height, ratio());
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  return performance.now() - before;
};

// ---------------------------------------------------------------- what is under the pointer

// Numbers of meshes and faces, drawn once for a view and then only read.
function pickBuffer() {
  const width = Math.max(1, canvas.clientWidth), height = Math.max(1, canvas.clientHeight);
  if (pickTarget?.version === version && pickTarget.width === width && pickTarget.height === height) return pickTarget;
  if (pickTarget?.width !== width || pickTarget?.height !== height) {
    if (pickTarget) { gl.deleteFramebuffer(pickTarget.frame); gl.deleteRenderbuffer(pickTarget.ids); gl.deleteRenderbuffer(pickTarget.depth); }
    const [frame, ids, depth] = [gl.createFramebuffer(), gl.createRenderbuffer(), gl.createRenderbuffer()];
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    for (const [buffer, kind, place] of [[ids, gl.RG32UI, gl.COLOR_ATTACHMENT0], [depth, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]]) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorage(gl.RENDERBUFFER, kind, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
    }
    pickTarget = { frame, ids, depth, width, height };
  }
  const p = programs.pick;
  gl.bindFramebuffer(gl.FRAMEBUFFER, pickTarget.frame);
  gl.enable(gl.DEPTH_TEST); gl.enable(gl.SCISSOR_TEST); gl.disable(gl.BLEND); gl.depthMask(true);
  gl.scissor(0, 0, width, height);
  gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
  gl.clear(gl.DEPTH_BUFFER_BIT);
  gl.useProgram(p.made);
  gl.bindVertexArray(empty);
  for (const cell of cells(width, height)) {
    gl.viewport(cell.x, cell.y, cell.width, cell.height);
    gl.scissor(cell.clip[0], cell.y, cell.clip[1], cell.height);
    bindMesh(cell.mesh);
    const field = isAlone() ? cell.mesh.fields.get(state.color) : null;
    bind(UNITS.tValue, field ? labelTexture(cell.mesh) : start.none.tValue);
    gl.uniform1i(p.at('uMode'), field ? field.on === 'vertex' ? 6 : 7 : 0);
    setCamera(p, cell.mesh, cell.width / cell.height);
    gl.uniform1ui(p.at('uMesh'), cell.mesh.number);
    gl.drawArrays(gl.TRIANGLES, 0, 3 * cell.mesh.faces);
  }
  pickTarget.version = version;
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  return pickTarget;
}

// What is at a place of the canvas, in CSS pixels from its upper left.
function pick(x, y) {
  if (gl.isContextLost()) return null;
  const target = pickBuffer(), id = new Uint32Array(4), flipped = target.height - 1 - Math.floor(y);
  gl.bindFramebuffer(gl.FRAMEBUFFER, target.frame);
  gl.readPixels(Math.floor(x), flipped, 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, id);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  if (id[0] === 0) return null;
  const mesh = meshes[id[0] - 1], face = id[1];
  const cell = cells(target.width, target.height).find(c => c.mesh === mesh);
  gl.useProgram(programs.pick.made);
  const camera = setCamera(programs.pick, mesh, cell.width / cell.height);
  const nx = 2 * (x - cell.x) / cell.width - 1, ny = 2 * (target.height - y - cell.y) / cell.height - 1;
  const across = [nx * camera.half * camera.aspect, ny * camera.half];
  // The line of sight in the coordinates of the mesh.
  const model = v => [0, 1, 2].map(i => camera.turned[0][i] * v[0] + camera.turned[1][i] * v[1] + camera.turned[2][i] * v[2]);
  const from = model(state.perspective ? [0, 0, camera.away] : [...across, camera.away]).map((c, i) => (c - camera.offset[i]) / camera.scale);
  const along = model(state.perspective ? [...across, -camera.away] : [0, 0, -1]);
  const corners = [0, 1, 2].map(i => mesh.corners[3 * face + i]);
  const points = corners.map(v => [0, 1, 2].map(i => mesh.local[3 * v + i]));
  const n = faceNormal(mesh, face), t = dot(points[0].map((p, i) => p - from[i]), n) / (dot(along, n) || 1e-30);
  const hit = from.map((f, i) => f + t * along[i]);
  const doubled = (a, b, c) => { const u = b.map((q, i) => q - a[i]), v = c.map((q, i) => q - a[i]);
    return dot([u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]], n); };
  const area = doubled(...points) || 1e-30;
  let weights = [doubled(hit, points[1], points[2]) / area, doubled(points[0], hit, points[2]) / area, doubled(points[0], points[1], hit) / area];
  weights = weights.map(w => Number.isFinite(w) ? Math.min(Math.max(w, 0), 1) : 1 / 3);
  const sum = weights[0] + weights[1] + weights[2] || 1;
  weights = weights.map(w => w / sum);
  const nearest = weights.indexOf(Math.max(...weights));
  const point = [0, 1, 2].map(i => points[0][i] * weights[0] + points[1][i] * weights[1] + points[2][i] * weights[2]);
  return { mesh, face, corners, weights, vertex: corners[nearest], world: point.map((c, i) => c + mesh.source.center[i]) };
}

function numberOf(mesh, list, i) {
  const blob = mesh.source[list];
  if (blob === null) return i;
  mesh.cache[list] ??= integersOf(blob, list === 'vertexNumbers' ? mesh.vertices : mesh.faces);
  return mesh.cache[list][i];
}

// As many digits as the positions have.
function coordinates(mesh, world) {
  const step = mesh.source.positions.step ? Math.max(...mesh.source.positions.step) : 0;
  const places = step > 0 ? Math.min(Math.max(Math.ceil(-Math.log10(step)), 0), 12) : null;
  return world.map(x => places === null ? digits(x) : x.toFixed(places)).join(', ');
}

function describe(hit) {
  const { mesh } = hit, rows = [];
  if (meshes.length > 1) rows.push(['mesh', mesh.source.name]);
  for (const [key, field] of mesh.fields) {
    const current = key === state.color, text = i => field.label ? labelText(labelOf(field, i)) : digits(exact(field, i));
    if (field.lazy && !current) continue;
    if (field.on === 'face') {
      const value = text(hit.face);
      rows.push([field.title, withUnit(value, field.unit), current]);
    } else {
      const value = text(hit.vertex);
      const here = [0, 1, 2].reduce((s, i) => s + hit.weights[i] * field.values[hit.corners[i]], 0);
      rows.push([field.title, `${withUnit(value, field.unit)} at the vertex` + (current && !field.label ? `, ${digits(here, 4)} here` : ''), current]);
    }
  }
  rows.sort((a, b) => Boolean(b[2]) - Boolean(a[2]));
  rows.push(['place', coordinates(mesh, hit.world)]);
  rows.push(['vertex', grouped(numberOf(mesh, 'vertexNumbers', hit.vertex))]);
  rows.push(['face', grouped(numberOf(mesh, 'faceNumbers', hit.face))]);
  if (mesh.source.materials) {
    const material = (mesh.cache.materialNames ??= mesh.source.materials.names.split('\n'))[integersCached(mesh)[hit.face]];
    if (material) rows.push(['material', material]);
  }
  return rows;
}
const integersCached = mesh => mesh.cache.faceMaterial ??= integersOf(mesh.source.materials.faces, mesh.faces);

function showPicked(hit, aloud) {
  const box = element('picked'), changed = hit !== state.picked;
  state.picked = hit;
  box.replaceChildren();
  box.hidden = !hit;
  element('unpicked').hidden = Boolean(hit);
  if (hit) {
    const list = describe(hit);
    for (const [name, value, current] of list) {
      const line = make('div', { className: current ? 'current' : '' }, make('dt', {}, make('bdi', {}, ...wrapped(name))), make('dd', {}, make('bdi', { textContent: value })));
      box.append(line);
    }
    if (aloud) live.textContent = list.map(([name, value]) => `${name}: ${value}`).join('; ');
  } else if (aloud) {
    live.textContent = 'Nothing here';
  }
  if (changed) redraw();
  return hit;
}

// Pinned values stay until the next click.
function setPinned(on) {
  state.pinned = on;
  element('pinned').hidden = !on;
}
function letGo() {
  setPinned(false);
  showPicked(null);
  live.textContent = 'The values follow the pointer again';
}
// The view has not changed by showing what is under the pointer: keep the numbers.
function point(x, y, aloud) {
  const before = version, hit = pick(x, y);
  if (!state.pinned) showPicked(hit, aloud);
  if (pickTarget && pickTarget.version === before) pickTarget.version = version;
  viewer.picked = hit && { vertex: hit.vertex, face: hit.face, mesh: hit.mesh.number, world: hit.world, rows: describe(hit) };
  return viewer.picked;
}
// What a click does: it pins values, or sets an end of the measured line.
function read(x, y) {
  setPinned(false);
  point(x, y, !state.measuring);
  if (state.measuring) measure(state.picked);
  else setPinned(state.picked !== null);
}
viewer.point = (x, y) => point(x, y, false);

// ---------------------------------------------------------------- controls

function make(kind, properties = {}, ...children) {
  const made = document.createElement(kind);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith('aria-') || name === 'for' || name === 'role') made.setAttribute(name, value);
    else made[name] = value;
  }
  made.append(...children);
  return made;
}
let labels = 0;
function labelled(text, input) {
  input.id ||= 'c' + labels++;
  return make('div', { className: 'line' }, make('label', { htmlFor: input.id, textContent: text }), input);
}
function select(text, options, value, change, id = '') {
  const input = make('select', { id }, ...options.map(([v, name]) => make('option', { value: v, textContent: name, selected: v === value })));
  input.addEventListener('change', () => { change(input.value); });
  const line = labelled(text, input);
  line.classList.add('choice');
  return [line, input];
}
function checkbox(text, value, change, id = '') {
  const input = make('input', { type: 'checkbox', checked: value, id });
  input.id ||= 'c' + labels++;
  input.addEventListener('change', () => change(input.checked));
  return [make('div', { className: 'check' }, input, make('label', { htmlFor: input.id, textContent: text })), input];
}
function slider(text, [low, high, step], value, change, id = '') {
  const input = make('input', { type: 'range', min: low, max: high, step, value, id });
  input.addEventListener('input', () => change(Number(input.value)));
  return [labelled(text, input), input];
}
const button = (text, press, id = '', title = '') => {
  const made = make('button', { type: 'button', textContent: text, id, title });
  made.addEventListener('click', press);
  return made;
};
function section(title, open, ...children) {
  return make('details', { open }, make('summary', { textContent: title }), make('div', { className: 'inside' }, ...children));
}

const controls = {};
const panel = element('controls');

function buildControls() {
  const view = [], colors = [], lines = [];
  if (meshes.length > 1) {
    const layouts = [...(wholes.length > 1 ? [['side', 'Side by side'], ['wipe', 'Wipe'], ['blink', 'Blink']] : []), ['one', 'One of them']];
    if (meshes.some(m => m.source.coverage !== null)) layouts.push(['distance', 'By size on the screen']);
    const [line, input] = select('Arrange', layouts, state.layout, setLayout, 'layout');
    const [wipeLine, wipe] = slider('Move the border', [0, wholes.length - 1, 0.01], state.wipe, setWipe, 'wipe');
    const [oneLine, one] = select('Show', meshes.map((m, i) => [String(i), m.source.name]), String(state.one), x => setOne(Number(x)), 'one');
    const [blinkLine, blink] = checkbox('Autoplay (B shows the next)', state.blink, setBlink, 'blink');
    const level = make('p', { id: 'level', className: 'note' });
    const [levelLine, levels] = slider('Level', [0, meshes.length - 1, 1], state.one, setOne, 'levels');
    const hasLevels = meshes.some(m => m.source.coverage !== null);
    const [togetherLine, together] = checkbox('Same place and scale for all', state.together, x => { state.together = x; resetCamera(); redraw(); }, 'together');
    Object.assign(controls, { layout: input, wipe, one, blink, together });
    controls.byLayout = { wipe: [wipeLine], one: hasLevels ? [oneLine, levelLine] : [oneLine], blink: [blinkLine], distance: [level] };
    controls.levels = levels;
    view.push(line, wipeLine, oneLine, ...(hasLevels ? [levelLine] : []), blinkLine, level, togetherLine);
  }
  let lineOf;
  [lineOf, controls.smooth] = checkbox('Smooth shading (G)', state.smooth, x => { state.smooth = x; redraw(); }, 'smooth'); view.push(lineOf);
  [lineOf, controls.edges] = checkbox('Edges (E)', state.edges, x => { state.edges = x; redraw(); }, 'edges'); view.push(lineOf);
  [lineOf, controls.backs] = checkbox('Tint what is seen from behind', state.backs, x => { state.backs = x; redraw(); }, 'backs'); view.push(lineOf);
  [lineOf, controls.perspective] = checkbox('Perspective (O)', state.perspective, x => { state.perspective = x; stayHome(); redraw(); }, 'perspective'); view.push(lineOf);
  [lineOf, controls.axes] = checkbox('Axes', state.axes, x => { state.axes = x; redraw(); }, 'show-axes'); view.push(lineOf);
  [lineOf, controls.theme] = select('Brightness', [['auto', 'System'], ['light', 'Light'], ['dark', 'Dark']], 'auto', x => { state.theme = x; showTheme(); }, 'theme'); view.push(lineOf);
  [lineOf, controls.up] = select('Up', ['x', 'y', 'z', '-x', '-y', '-z'].map(axis => [axis, axis.replace('-', '\u2212')]), state.up, x => { state.up = x; resetCamera(); redraw(); }, 'up'); view.push(lineOf);
  const full = button('Full screen', () => document.querySelector('main').requestFullscreen().catch(() => { live.textContent = 'The browser allows no full screen here'; }), 'full');
  full.className = 'broad';
  full.hidden = !document.fullscreenEnabled;
  const sides = make('div', { className: 'buttons', role: 'group', 'aria-label': 'Look from' }, ...SIDES.map(([name, q], i) => button(name, () => { state.turn = normalized(upright(q)); redraw(); }, '', 'Key ' + (i + 1))));
  view.push(sides, make('div', { className: 'buttons two' }, button('Reset view', () => { resetCamera(); redraw(); }, 'reset', 'Key 0'), button('Frame the mesh', () => { fit(!isAlone()); redraw(); }, 'frame', 'Key F'), button('Save picture', savePicture, 'save', 'Key S'), button('Copy link', copyLink, 'link', 'The address with this view and these settings'), full));

  controls.address = make('input', { type: 'text', readOnly: true, id: 'address' });
  const address = labelled('Link', controls.address);
  address.hidden = true;
  view.push(address);

  [lineOf, controls.color] = select('Colour by', COLORS, state.color, setColor, 'color'); colors.push(lineOf);
  [lineOf, controls.map] = select('Colours', [], 'auto', x => { state.map = x; if (state.only !== null) setOnly(null); showRange(); redraw(); }, 'map');
  const mapLine = lineOf;
  controls.scaleOnly = [];
  [lineOf, controls.range] = select('Range', [['auto', '2nd to 98th percentile'], ['five', '5th to 95th percentile'], ['full', 'All values'], ['given', 'Custom']], 'auto', x => { state.range = x; setRange(); }, 'range');
  controls.scaleOnly.push(lineOf);
  const number = (id, label) => {
    const input = make('input', { type: 'text', inputMode: 'decimal', id, autocomplete: 'off', 'aria-label': label });
    input.addEventListener('change', () => givenRange());
    return input;
  };
  controls.low = number('low', 'Lowest value'); controls.high = number('high', 'Highest value');
  controls.scaleOnly.push(make('div', { className: 'line' }, make('span', { textContent: 'From, to' }), make('span', { className: 'pair' }, controls.low, controls.high)));
  [lineOf, controls.symmetric] = checkbox('Symmetric about zero', false, x => { state.symmetric = x; if (x) { state.log = controls.log.checked = false; } setRange(); }, 'symmetric'); controls.scaleOnly.push(lineOf);
  [lineOf, controls.log] = checkbox('Logarithmic', false, x => { state.log = x; if (x) { state.symmetric = controls.symmetric.checked = false; } setRange(); }, 'log'); controls.scaleOnly.push(lineOf);
  controls.histogram = make('div', { id: 'histogram', role: 'img' });
  controls.fieldOnly = [mapLine, controls.histogram];
  colors.push(mapLine, ...controls.scaleOnly, controls.histogram);

  const toggle = name => { const [line, input] = checkbox(name, state.overlays.has(name), x => { if (x) state.overlays.add(name); else state.overlays.delete(name); redraw(); }); input.dataset.overlay = name; return line; };
  lines.push(toggle('Boundary'), toggle('Non-manifold edges'), toggle('Sharp edges'));
  [lineOf, controls.sharp] = slider('Sharp from (degrees)', [1, 179, 1], state.sharp, x => { state.sharp = x; controls.sharpOut.textContent = x + '°'; redraw(); }, 'sharp');
  controls.sharpOut = make('output', { textContent: state.sharp + '°' }); lineOf.append(controls.sharpOut); lines.push(lineOf);
  const own = [...new Set(meshes.flatMap(m => m.source.lines.map(l => l.name)))], directions = [...new Set(meshes.flatMap(m => m.source.directions.map(l => l.name)))];
  for (const name of [...own, ...directions]) lines.push(toggle(name));
  if (directions.length) { [lineOf, controls.length] = slider('Length of directions', [0.2, 4, 0.1], state.length, x => { state.length = x; redraw(); }, 'length'); lines.push(lineOf); }

  controls.measure = button('Measure a distance (M)', () => setMeasuring(!state.measuring), 'measure');
  controls.measure.setAttribute('aria-pressed', 'false');
  const cutting = [make('div', { className: 'buttons one' }, controls.measure), make('p', { id: 'measured', className: 'note' })];
  [lineOf, controls.cut] = select('Cut', [['none', 'Nothing'], ['view', 'What is nearest'], ['x', 'Along x'], ['y', 'Along y'], ['z', 'Along z']], state.cut, x => { state.cut = x; showCut(); redraw(); }, 'cut'); cutting.push(lineOf);
  [lineOf, controls.cutAt] = slider('Cut at', [-1, 1, 0.005], state.cutAt, x => { state.cutAt = x; redraw(); }, 'cut-at'); cutting.push(lineOf);
  controls.cutOnly = [lineOf];
  [lineOf, controls.cutOther] = checkbox('Keep the other side', state.cutOther, x => { state.cutOther = x; redraw(); }, 'cut-other'); cutting.push(lineOf);
  controls.cutOnly.push(lineOf);
  showCut();

  panel.append(section('View', true, ...view), section('Measure and cut', true, ...cutting), section('Colours', true, ...colors), section('Lines', own.length + state.overlays.size > 0, ...lines));
  const facts = element('facts');
  for (const part of page.report) facts.append(section(part.title, part.open, reportPart(part)));
  facts.append(section('Keys', false, make('dl', { className: 'keys' }, ...KEYS.flatMap(([key, what]) => [make('dt', {}, make('kbd', { textContent: key })), make('dd', { textContent: what })]))));
}

// After a link was read: every control as the state is.
function showControls() {
  for (const name of ['smooth', 'edges', 'backs', 'perspective', 'axes', 'blink', 'together', 'symmetric', 'log', 'cutOther']) if (controls[name]) controls[name].checked = state[name];
  if (controls.levels) controls.levels.value = String(state.one);
  for (const name of ['layout', 'wipe', 'one', 'theme', 'up', 'color', 'map', 'range', 'sharp', 'length', 'cut', 'cutAt']) if (controls[name]) controls[name].value = String(state[name]);
  for (const input of panel.querySelectorAll('[data-overlay]')) input.checked = state.overlays.has(input.dataset.overlay);
  controls.sharpOut.textContent = state.sharp + '°';
  showCut();
}

const KEYS = [['Arrows', 'turn (with Shift: move)'], ['+ −', 'nearer, farther'], [', .', 'roll'], ['0', 'the first view'], ['1 … 6', 'from the front, back, left, right, top, bottom'],
  ['X', 'read the middle of the picture'], ['Esc', 'let go of what was clicked'], ['M', 'measure a distance'], ['I', 'only the label in the middle, or all'], ['C', 'next colours'], ['F', 'frame the mesh'], ['G', 'flat or smooth'], ['E', 'edges'], ['O', 'perspective'], ['A', 'next arrangement'], ['B', 'next mesh'], ['[ ]', 'move the border'], ['D', 'dark or light'], ['S', 'save the picture']];
const R = Math.SQRT1_2;
const SIDES = [['Front', [0, 0, 0, 1]], ['Back', [0, 1, 0, 0]], ['Left', [0, R, 0, R]], ['Right', [0, -R, 0, R]], ['Top', [R, 0, 0, R]], ['Bottom', [-R, 0, 0, R]]];

// Shows one label of a field alone, from a table.
function aloneButton(key, text) {
  const press = button(text, () => {
    const value = Number(text);
    if (state.color === key && state.only === value) { setOnly(null); return; }
    if (state.color !== key) setColor(key);
    if (!showsLabels()) { state.map = 'auto'; controls.map.value = 'auto'; showRange(); }
    if (showsLabels()) setOnly(value);
  });
  press.dataset.labels = key;
  press.value = text;
  press.setAttribute('aria-pressed', 'false');
  return press;
}

function reportPart(part) {
  const box = make('div');
  if (part.text) box.append(make('p', { textContent: part.text }));
  if (part.rows.length) {
    box.append(make('table', {}, ...part.rows.map(([name, value]) => make('tr', {}, make('th', { scope: 'row' }, make('bdi', { textContent: name })), make('td', {}, make('bdi', { textContent: value }))))));
  }
  if (part.lines.length) {
    box.append(make('div', { className: 'scroll', tabIndex: 0, role: 'region', 'aria-label': part.title }, make('table', { className: 'wide' },
      make('tr', {}, ...part.header.map(text => make('th', { scope: 'col', textContent: text }))),
      ...part.lines.map(line => make('tr', {}, ...line.map((text, i) => make('td', {}, i === 0 && part.labels ? aloneButton(part.labels, text) : make('bdi', { textContent: text }))))))));
  }
  return box;
}

// A link without a camera is framed with its settings, so that an untouched view is, too.
function stayHome() { if (isHome()) resetCamera(); }
function setLayout(layout) {
  state.layout = layout;
  stayHome();
  showLayout(); showFacts(); redraw();
}
// Shows one mesh; a part comes into the frame.
function setOne(number) {
  const isPart = [state.one, number].some(i => meshes[i].source.part);
  state.one = number;
  controls.one.value = controls.levels.value = String(number);
  controls.levels.setAttribute('aria-valuetext', meshes[number].source.name);
  if (isHome()) resetCamera(); else if (isPart) fit();
  showFacts(); redraw();
}
function showLayout() {
  for (const [name, lines] of Object.entries(controls.byLayout ?? {})) for (const line of lines) line.hidden = state.layout !== name;
  if (controls.layout) controls.layout.value = state.layout;
}
function showCut() { for (const line of controls.cutOnly) line.hidden = state.cut === 'none'; }
function showTheme() {
  document.documentElement.dataset.theme = themeNow();
  if (controls.theme) controls.theme.value = state.theme;
  redraw();
}
function setColor(key) {
  if (state.only !== null) setOnly(null);
  state.color = key;
  controls.color.value = key;
  if (isField(key)) {
    const field = fieldOf(key);
    state.symmetric = field.signed; state.log = false; state.range = 'auto';
    if (field.range) { state.range = 'given'; [state.low, state.high] = field.range; }
    controls.symmetric.checked = state.symmetric; controls.log.checked = false;
    showMaps();
    setRange();
  }
  showFieldControls();
  element('bar').hidden = !isField(key);
  if (state.picked) showPicked(state.picked);
  redraw();
}
// The maps that suit the values; the chosen one stays if it does.
function showMaps() {
  const names = ['auto', ...maps.filter(m => m !== LABELS || areLabels(state.color)).map(m => m.name)];
  if (!names.includes(state.map)) state.map = 'auto';
  controls.map.replaceChildren(...names.map(name => make('option', { value: name, textContent: name === 'auto' ? 'Default' : name, selected: name === state.map })));
}
function showFieldControls() {
  for (const line of controls.fieldOnly) line.hidden = !isField(state.color);
  for (const line of controls.scaleOnly) line.hidden = !isField(state.color) || showsLabels();
}
function setRange() {
  if (state.range !== 'given') [state.low, state.high] = autoRange();
  else if (state.symmetric) { state.high = Math.max(Math.abs(state.low), Math.abs(state.high)); state.low = -state.high; }
  showRange();
  redraw();
}
function givenRange() {
  const [low, high] = [controls.low, controls.high].map(input => Number(input.value.trim().replace(',', '.')));
  const good = Number.isFinite(low) && Number.isFinite(high) && low < high && !(state.log && low <= 0) && controls.low.value.trim() && controls.high.value.trim();
  for (const input of [controls.low, controls.high]) input.setAttribute('aria-invalid', String(!good));
  if (!good) { live.textContent = state.log ? 'The range needs two growing numbers above zero' : 'The range needs two growing numbers'; return; }
  state.low = low; state.high = high; state.range = 'given';
  if (state.symmetric && low !== -high) { state.symmetric = controls.symmetric.checked = false; }
  showRange();
  redraw();
}

// Round numbers from low to high.
function ticks() {
  const { low, high } = state, out = [];
  if (!(high > low)) return [low];
  if (state.log) {
    for (let e = Math.floor(Math.log10(Math.max(low, 1e-38))); e <= Math.ceil(Math.log10(high)); e++) for (const f of [1, 2, 5]) out.push(f * 10 ** e);
    const inside = out.filter(t => t >= low && t <= high), tens = inside.filter(t => Number.isInteger(Math.log10(t)));
    return tens.length >= 3 ? tens : inside.length ? inside : [low, high];
  }
  const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough)), step = [1, 2, 5, 10].map(f => f * power).find(s => s >= rough) ?? rough;
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step && out.length < 20; i++) out.push(i * step);
  return out.length > 1 ? out : [low, high];
}
const tickText = t => digits(Math.abs(t) < 1e-12 * Math.max(Math.abs(state.low), Math.abs(state.high)) ? 0 : t, 4);

function showSwatches() {
  const isShown = showsLabels(), list = element('swatches');
  element('scale').hidden = isShown;
  list.hidden = !isShown;
  // A picture has no buttons for readers of the screen.
  element('bar').setAttribute('role', isShown ? 'group' : 'img');
  list.replaceChildren();
  if (!isShown) return;
  const { shown, notes } = legendOf(state.color, ROWS);
  for (const { value, color, text } of shown) {
    const swatch = make('span'), press = button('', () => setOnly(state.only === value ? null : value));
    swatch.style.setProperty('--color', color);
    press.append(swatch, text);
    press.value = value;
    list.append(make('li', {}, press));
  }
  list.append(...notes.map(note => make('li', { textContent: note })));
  showOnly();
}
// So many labels have a row in the legend.
const ROWS = 400;
// Shows one label alone, or all.
function setOnly(value) {
  state.only = value;
  for (const mesh of meshes) for (const [key, { vao, buffer }] of mesh.overlays) if (key.includes(ALONE)) { gl.deleteVertexArray(vao); gl.deleteBuffer(buffer); mesh.overlays.delete(key); }
  if (value !== null && ![...element('swatches').querySelectorAll('button')].some(press => press.value === String(value))) showSwatches();
  else showOnly();
  const name = fieldOf(state.color)?.title;
  live.textContent = value === null ? 'All labels are shown' : `Only ${name} ${labelText(value)} is shown. Press again for all.`;
  redraw();
}
function showOnly() {
  const isOne = isAlone(), list = element('swatches'), { shown, notes } = legendOf(state.color, LABELS.colors.length / 3);
  list.classList.toggle('alone', isOne);
  for (const press of [...list.querySelectorAll('button'), ...element('facts').querySelectorAll('[data-labels]')]) {
    const isHere = !press.dataset.labels || press.dataset.labels === state.color;
    press.setAttribute('aria-pressed', String(isOne && isHere && press.value === String(state.only)));
  }
  list.querySelector('[aria-pressed="true"]')?.scrollIntoView({ block: 'nearest' });
  const more = isOne ? `; only ${labelText(state.only)} is shown` : notes.map(note => '; ' + note).join('');
  element('bar').setAttribute('aria-label', `${fieldOf(state.color).title}: a colour for each label: ${shown.map(({ text }) => text).join(', ')}${more}`);
}
function showRange() {
  showFieldControls();
  controls.range.value = state.range;
  controls.low.value = digits(state.low, 5); controls.high.value = digits(state.high, 5);
  for (const input of [controls.low, controls.high]) input.setAttribute('aria-invalid', 'false');
  const stops = Array.from({ length: 33 }, (_, i) => colorAt(i / 32)).join(', ');
  element('ramp').style.setProperty('--stops', stops);
  const field = fieldOf(state.color), values = field ? sorted(state.color) : [];
  element('quantity').replaceChildren(...wrapped(field ? field.title : ''));
  element('quantity').title = field ? field.name : '';
  element('unit').textContent = field ? field.unit : '';
  element('ticks').replaceChildren(...ticks().map(t => { const mark = make('span', { textContent: tickText(t) }); mark.style.setProperty('--at', 100 * (place(t) ?? 0) + '%'); return mark; }));
  // An arrow at each end that values go beyond: they have the colour of the end.
  const beyond = { below: values.length > 0 && values[0] < state.low, above: values.length > 0 && values[values.length - 1] > state.high };
  for (const [name, end] of [['below', 0], ['above', 1]]) {
    element(name).classList.toggle('beyond', beyond[name]);
    element(name).style.setProperty('--color', colorAt(end));
  }
  const further = Object.keys(beyond).filter(name => beyond[name]);
  element('bar').setAttribute('aria-label', field ? `${field.title}: colours from ${digits(state.low, 4)} to ${digits(state.high, 4)} ${field.unit}`.trimEnd() + (further.length ? `; some values are ${further.join(' or ')}` : '') : '');
  showSwatches();
  showHistogram();
}

// Bars of these heights and colours.
function bars(counts, colorOf) {
  const step = 240 / counts.length, top = counts.reduce((a, b) => Math.max(a, b), 1);
  return drawing('svg', { viewBox: '0 0 240 64', preserveAspectRatio: 'none', 'aria-hidden': 'true' }, ...Array.from(counts, (n, i) => {
    const height = 62 * n / top;
    return drawing('rect', { x: step * i, y: 64 - height, width: 0.92 * step, height, fill: colorOf(i) });
  }));
}
// How many elements each label has; only the first where there are many.
function showCounts(box) {
  const { list } = labelsOf(state.color), counts = new Uint32Array(list.length);
  for (const mesh of meshes) {
    const field = mesh.fields.get(state.color);
    for (let i = 0; i < (field?.values.length ?? 0); i++) { const at = placeOf(list, labelOf(field, i)); if (at >= 0) counts[at]++; }
  }
  const most = counts.reduce((best, n, i) => n > counts[best] ? i : best, 0);
  const text = list.length ? `${grouped(list.length)} different values, most often ${labelText(list[most])} (${grouped(counts[most])} times)` : 'no values';
  box.setAttribute('aria-label', 'How often each value occurs: ' + text);
  box.append(bars(counts.subarray(0, 96), i => labelColor(state.color, i)), make('p', { className: 'note', textContent: text }));
}

function showHistogram() {
  const box = controls.histogram;
  box.replaceChildren();
  if (!isField(state.color)) return;
  if (showsLabels()) { showCounts(box); return; }
  const values = sorted(state.color), bins = new Uint32Array(48);
  const pad = state.log ? 0 : 0.08 * (state.high - state.low), low = state.low - pad, high = state.high + pad;
  const u = state.log ? x => x > 0 ? Math.log(x) : NaN : x => x, [a, b] = [u(low), u(high)];
  let outside = 0;
  for (const x of values) { const i = Math.floor((u(x) - a) / ((b - a) || 1) * 48); if (i >= 0 && i < 48) bins[i]++; else outside++; }
  const svg = bars(bins, i => { const middle = a + (i + 0.5) / 48 * (b - a); return colorAt(place(state.log ? Math.exp(middle) : middle) ?? 0); });
  const at = s => values.length ? values[Math.round(s * (values.length - 1))] : NaN;
  const text = values.length ? `least ${digits(at(0), 4)}, median ${digits(at(0.5), 4)}, largest ${digits(at(1), 4)}` + (outside ? `; ${grouped(outside)} of ${grouped(values.length)} beyond the range` : '') : 'no values';
  box.setAttribute('aria-label', 'How often each value occurs: ' + text);
  box.append(svg, make('p', { className: 'note', textContent: text }));
}

// An element of a vector picture.
function drawing(kind, properties, ...children) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', kind);
  for (const [name, value] of Object.entries(properties)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}
// The axes of the model as the camera sees them, the nearest last: names, and ends right, up and near.
const seenAxes = () => [...'xyz'].map((name, i) => ({ name, end: rows(state.turn).map(row => row[i]) })).sort((a, b) => a.end[2] - b.end[2]);
function showAxes() {
  element('axes').toggleAttribute('hidden', !state.axes);
  element('axes').replaceChildren(...seenAxes().map(({ name, end: [x, y] }) => {
    const letter = drawing('text', { x: 29 * x, y: -29 * y });
    letter.textContent = name;
    const axis = drawing('g', {}, drawing('line', { x2: 22 * x, y2: -22 * y }), letter);
    axis.style.setProperty('--color', `var(--${name})`);
    return axis;
  }));
}

// The names of the meshes over their pictures.
function showNames() {
  const box = element('names'), scale = 1 / ratio();
  const list = cells(canvas.width, canvas.height);
  const wanted = meshes.length > 1 || meshes[0].source.simplified || meshes.some(isInsideOut);
  const key = JSON.stringify([state.backs, state.color, list.map(c => [c.mesh.number, c.x, c.y, c.clip, c.height])]);
  if (showNames.key === key) return;
  showNames.key = key;
  box.replaceChildren(...(wanted ? list : []).map(cell => {
    const { source } = cell.mesh, note = source.simplified ? ` (shown with ${grouped(cell.mesh.faces)} of ${grouped(source.simplified)} faces)` : '';
    const name = make('div', {}, make('bdi', { textContent: source.name }), note);
    if (isInsideOut(cell.mesh)) name.append(make('br'), isTinted(cell.mesh) ? 'Inside out: violet is the inner side' : 'Inside out');
    name.style.left = cell.clip[0] * scale + 'px'; name.style.maxWidth = cell.clip[1] * scale - 16 + 'px';
    name.style.top = (canvas.height - cell.y - cell.height) * scale + 'px';
    return name;
  }));
}
function showLevel() {
  if (state.layout !== 'distance' || meshes.length < 2) return;
  const level = levelNow(), [low, high] = seenBox([level]), share = (high[1] - low[1]) / (2 * halfHeight());
  element('level').textContent = `The mesh fills ${Math.round(100 * share)} % of the height (${Math.round(share * canvas.clientHeight)} pixels). Its diagonal would fill ${Math.round(100 * coverage())} %, which asks for: ${level.source.name}. Zoom to see the change.`;
}

function showBorder() {
  const line = element('border');
  line.hidden = state.layout !== 'wipe';
  line.style.left = border(canvas.clientWidth).cut + 'px';
}

// Counts of each mesh.
function showFacts() {
  const box = element('counts'), listed = state.layout === 'one' && meshes[state.one].source.part ? [meshes[state.one]] : wholes;
  const names = [...new Set(listed.flatMap(m => m.source.facts.map(([name]) => name)))];
  const head = meshes.length > 1 ? [make('tr', {}, make('td'), ...listed.map(m => make('th', { scope: 'col' }, make('bdi', { textContent: m.source.name }))))] : [];
  const lines = names.map(name => make('tr', {}, make('th', { scope: 'row', textContent: name }),
    ...listed.map(m => make('td', {}, make('bdi', { textContent: m.source.facts.find(([n]) => n === name)?.[1] ?? '' })))));
  box.replaceChildren(make('table', { className: 'wide' }, ...head, ...lines));
  const notes = meshes.filter(m => m.source.simplified).map(m => make('p', { className: 'note', textContent: `${m.source.name}: ${grouped(m.source.simplified)} faces are too many for a page; shown are ${grouped(m.faces)}, made by merging vertices that are close together. Values, numbers of vertices and of faces are those of the original.` }));
  const reversed = meshes.filter(isInsideOut).map(m => make('p', { className: 'note', textContent: `${m.source.name} is inside out: its faces look into the closed surface. What is seen from outside is their back, which is violet where neither values nor materials are shown. Curvatures have the opposite sign. \u201ccurvmesh repair --reorient\u201d turns the faces.` }));
  box.append(...notes, ...reversed);
}

async function savePicture() {
  const scale = 2, width = canvas.clientWidth * scale, height = canvas.clientHeight * scale, before = [canvas.width, canvas.height];
  canvas.width = width; canvas.height = height;
  draw(width, height, scale);
  const isLegend = isField(state.color), aside = isLegend ? 150 * scale : 0;
  const sheet = new OffscreenCanvas(width + aside, height), pen = sheet.getContext('2d');
  pen.fillStyle = themeNow() === 'dark' ? '#17191d' : '#ffffff';
  pen.fillRect(0, 0, width + aside, height);
  pen.drawImage(canvas, 0, 0);
  [canvas.width, canvas.height] = before;
  redraw();
  const ink = pen.fillStyle = themeNow() === 'dark' ? '#e8eaed' : '#1a1c20';
  pen.font = `${13 * scale}px system-ui, sans-serif`;
  pen.textBaseline = 'middle';
  pen.lineWidth = scale;
  if (isLegend && showsLabels()) {
    const { shown, notes } = isAlone() ? { shown: [{ color: labelColor(state.color, placeOf(labelsOf(state.color).list, state.only)), text: labelText(state.only) }], notes: [] } : legendOf(state.color, LABELS.colors.length / 3), left = width + 8 * scale, step = Math.min(21 * scale, (height - 90 * scale) / (shown.length + notes.length));
    let y = 64 * scale;
    for (const { color, text } of shown) { pen.fillStyle = color; pen.fillRect(left, y - 7 * scale, 18 * scale, Math.min(14 * scale, step)); pen.fillStyle = ink; pen.fillText(text, left + 25 * scale, y, aside - 40 * scale); y += step; }
    for (const note of notes) { pen.fillText(note, left, y, aside - 16 * scale); y += step; }
    pen.fillText(fieldOf(state.color).title, left, 32 * scale, aside - 16 * scale);
  } else if (isLegend) {
    const top = 64 * scale, tall = Math.min(320 * scale, height - 100 * scale), left = width + 8 * scale, wide = 18 * scale;
    for (let row = 0; row < tall; row++) { pen.fillStyle = colorAt(1 - row / tall); pen.fillRect(left, top + row, wide, 1); }
    for (const [name, end, from, to] of [['above', 1, top, top - 10 * scale], ['below', 0, top + tall, top + tall + 10 * scale]]) {
      if (!element(name).classList.contains('beyond')) continue;
      pen.fillStyle = colorAt(end);
      pen.beginPath(); pen.moveTo(left, from); pen.lineTo(left + wide, from); pen.lineTo(left + wide / 2, to); pen.closePath(); pen.fill(); pen.strokeStyle = ink; pen.stroke();
    }
    pen.fillStyle = ink;
    for (const t of ticks()) { const y = top + tall * (1 - (place(t) ?? 0)); pen.fillRect(left + wide, y, 4 * scale, scale); pen.fillText(tickText(t), left + wide + 7 * scale, y); }
    // A long name is made narrower, never cut.
    const { title, unit } = fieldOf(state.color);
    pen.fillText(title, left, top - 40 * scale, aside - 16 * scale);
    pen.fillText(unit, left, top - 22 * scale, aside - 16 * scale);
  }
  if (meshes.length > 1) for (const cell of cells(width, height)) pen.fillText(cell.mesh.source.name, cell.clip[0] + 12 * scale, height - cell.y - cell.height + 18 * scale);
  const style = getComputedStyle(document.documentElement), corner = [width - 44 * scale, height - 44 * scale];
  pen.textAlign = 'center';
  pen.lineWidth = 2 * scale;
  for (const { name, end: [x, y] } of state.axes ? seenAxes() : []) {
    const at = reach => [corner[0] + reach * scale * x, corner[1] - reach * scale * y];
    pen.fillStyle = pen.strokeStyle = style.getPropertyValue('--' + name);
    pen.beginPath(); pen.moveTo(...corner); pen.lineTo(...at(22)); pen.stroke();
    pen.fillText(name, ...at(29));
  }
  pen.textAlign = 'left';
  pen.fillStyle = ink;
  const length = element('length-of');
  if (!length.hidden) {
    const at = [length.offsetLeft, length.offsetTop].map(x => x * scale), wide = pen.measureText(length.textContent).width + 12 * scale, ink = pen.fillStyle;
    pen.fillStyle = themeNow() === 'dark' ? '#17191d' : '#ffffff';
    pen.fillRect(at[0] - wide / 2, at[1] - 28 * scale, wide, 20 * scale);
    pen.fillStyle = ink;
    pen.textAlign = 'center';
    pen.fillText(length.textContent, at[0], at[1] - 18 * scale);
    pen.textAlign = 'left';
  }
  const blob = await sheet.convertToBlob({ type: 'image/png' });
  viewer.saved = blob.size;
  const link = make('a', { href: URL.createObjectURL(blob), download: (page.file || 'view') + '.png' });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  live.textContent = 'The picture is saved';
}
viewer.save = savePicture;

// ---------------------------------------------------------------- pointer and keys

const fingers = new Map();
const local = event => { const box = canvas.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
let moved = 0, waiting = null, anchor = null, anchoredIn = '', isTouch = false;
const viewNow = () => cameraNow() + state.perspective;
canvas.addEventListener('pointerdown', event => {
  canvas.setPointerCapture(event.pointerId);
  // Who turns the mesh has found the way.
  element('hints').open = false;
  fingers.set(event.pointerId, { at: local(event), button: event.button, pan: event.shiftKey || event.ctrlKey || event.button > 0 });
  moved = 0;
  isTouch = event.pointerType === 'touch';
});
canvas.addEventListener('pointermove', event => {
  const finger = fingers.get(event.pointerId), at = local(event);
  if (!finger) {
    anchor = null;
    if (event.pointerType !== 'touch') { waiting ??= requestAnimationFrame(() => { waiting = null; if (!state.pinned) point(...waitingAt, false); }); waitingAt = at; }
    return;
  }
  const [dx, dy] = [at[0] - finger.at[0], at[1] - finger.at[1]], size = canvas.clientHeight;
  moved += Math.abs(dx) + Math.abs(dy);
  if (fingers.size === 1) {
    if (finger.pan) pan(2 * dx / size, 2 * dy / size);
    else turn(dx * 6 / size, dy * 6 / size);
  } else if (fingers.size === 2) {
    const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
    const before = Math.hypot(finger.at[0] - other.at[0], finger.at[1] - other.at[1]), now = Math.hypot(at[0] - other.at[0], at[1] - other.at[1]);
    if (before > 0 && now > 0) {
      anchor ??= anchorAt(0.5 * (at[0] + other.at[0]), 0.5 * (at[1] + other.at[1]));
      zoom(before / now, anchor);
      const angle = Math.atan2(at[1] - other.at[1], at[0] - other.at[0]) - Math.atan2(finger.at[1] - other.at[1], finger.at[0] - other.at[0]);
      if (Math.abs(angle) < 1) roll(-angle);
    }
    pan(dx / size, dy / size);
  }
  finger.at = at;
});
let waitingAt = [0, 0];
const lift = event => {
  const finger = fingers.get(event.pointerId);
  fingers.delete(event.pointerId);
  if (!finger || event.type !== 'pointerup' || moved >= 6) return;
  read(...finger.at);
  if (isTouch) countTaps(event);
};
canvas.addEventListener('pointerup', lift);
canvas.addEventListener('pointercancel', lift);
// The border stays between the same two meshes while it is dragged.
let pair = 0;
element('border').addEventListener('pointerdown', event => {
  event.target.setPointerCapture(event.pointerId);
  pair = border(1).first;
});
element('border').addEventListener('pointermove', event => {
  if (event.target.hasPointerCapture(event.pointerId)) setWipe(pair + Math.min(Math.max(1 - local(event)[0] / canvas.clientWidth, 0), 0.999));
});
canvas.addEventListener('contextmenu', event => event.preventDefault());
canvas.addEventListener('wheel', event => {
  event.preventDefault();
  // While the pointer rests and nothing else moves the camera, the point under it stays the same.
  if (anchoredIn !== viewNow()) anchor = null;
  anchor ??= anchorAt(...local(event));
  zoom(Math.exp(Math.max(-60, Math.min(60, event.deltaY * (event.deltaMode ? 30 : 1))) * 0.0022), anchor);
  anchoredIn = viewNow();
}, { passive: false });
function centre(x, y) {
  const hit = pick(x, y);
  if (!hit) return;
  state.target = inScene(hit.mesh, hit.world);
  anchor = null;
  redraw();
}
// Not all browsers tell of double taps, so that those are found here.
let tap = { time: -Infinity, at: [0, 0] };
function countTaps(event) {
  const at = local(event), isSecond = event.timeStamp - tap.time < 500 && Math.hypot(at[0] - tap.at[0], at[1] - tap.at[1]) < 30;
  tap = { time: isSecond ? -Infinity : event.timeStamp, at };
  if (isSecond) centre(...at);
}
canvas.addEventListener('dblclick', event => { if (!isTouch) centre(...local(event)); });

// Shows only the label in the middle of the picture, or all.
function isolate() {
  if (state.only !== null) { setOnly(null); return; }
  const hit = showsLabels() ? pick(canvas.clientWidth / 2, canvas.clientHeight / 2) : null, field = hit?.mesh.fields.get(state.color);
  const value = field ? labelOf(field, field.on === 'vertex' ? hit.vertex : hit.face) : NaN;
  if (Number.isFinite(value)) setOnly(value + 0); else live.textContent = 'No label here';
}
function flip(name) {
  controls[name].click();
  live.textContent = `${controls[name].labels[0].textContent.replace(/ \(.\)$/, '')}: ${state[name] ? 'on' : 'off'}`;
}
const sayChoice = name => { live.textContent = `${controls[name].labels[0].textContent}: ${controls[name].selectedOptions[0].textContent}`; };
const next = (list, value) => list[(list.indexOf(value) + 1) % list.length];
function nextMesh() {
  if (meshes.length < 2) return;
  if (state.layout === 'one') setOne((state.one + 1) % meshes.length);
  else {
    if (state.layout !== 'blink') { setBlink(false); setLayout('blink'); }
    state.shown = (state.shown + 1) % wholes.length;
    redraw();
  }
  live.textContent = (state.layout === 'one' ? meshes[state.one] : wholes[state.shown]).source.name;
}
function setBlink(on) {
  state.blink = on;
  if (controls.blink) controls.blink.checked = on;
}
function setWipe(place) {
  state.wipe = Math.min(Math.max(place, 0), wholes.length - 1);
  controls.wipe.value = state.wipe;
  redraw();
}
function moveBorder(by) {
  if (wholes.length < 2) return;
  setWipe(state.wipe + by);
  if (state.layout !== 'wipe') setLayout('wipe');
}
const ACTIONS = {
  '+': () => zoom(1 / 1.15), '=': () => zoom(1 / 1.15), '-': () => zoom(1.15), ',': () => roll(0.1), '.': () => roll(-0.1),
  '0': () => { resetCamera(); redraw(); }, Home: () => { resetCamera(); redraw(); },
  x: () => { element('cross').hidden = false; read(canvas.clientWidth / 2, canvas.clientHeight / 2); },
  m: () => setMeasuring(!state.measuring), Escape: () => { if (state.measuring) setMeasuring(false); else if (state.pinned) letGo(); else if (isAlone()) setOnly(null); },
  c: () => { setColor(next(optionsOf('color')(), state.color)); sayChoice('color'); }, f: () => { fit(!isAlone()); redraw(); }, i: isolate, g: () => flip('smooth'), e: () => flip('edges'), o: () => flip('perspective'),
  a: () => { if (controls.layout) { setLayout(next(optionsOf('layout')(), state.layout)); sayChoice('layout'); } },
  b: nextMesh, '[': () => moveBorder(-0.05), ']': () => moveBorder(0.05),
  d: () => { state.theme = themeNow() === 'dark' ? 'light' : 'dark'; showTheme(); }, s: savePicture,
};
// Keys belong to the picture only: elsewhere, letters are for controls and for readers of the screen.
canvas.addEventListener('keydown', event => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  if (arrows) {
    if (event.shiftKey) pan(arrows[0] * 0.08, arrows[1] * 0.08); else turn(arrows[0] * 0.12, arrows[1] * 0.12);
    event.preventDefault();
    return;
  }
  const side = SIDES[Number(event.key) - 1];
  if (side && /^[1-6]$/.test(event.key)) { state.turn = normalized(upright(side[1])); redraw(); return; }
  const action = ACTIONS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (action) { action(); event.preventDefault(); }
});
// Who scrolls pinned values has left the picture.
element('values').addEventListener('keydown', event => { if (event.key === 'Escape' && state.pinned) letGo(); });

// ---------------------------------------------------------------- the link to this view

const flag = name => ({ get: () => state[name] ? '1' : '0', set: text => { state[name] = text === '1'; } });
const amount = (name, low, high) => ({ get: () => digits(state[name], 6), set: text => { const x = Number(text); if (text !== '' && x >= low && x <= high) state[name] = x; } });
const choice = (name, list) => ({ get: () => String(state[name]), set: text => { if (list().includes(text)) state[name] = text; } });
const vector = (name, count, made = x => x) => ({
  get: () => state[name].map(x => digits(x, 7)).join(),
  set: text => { const list = text.split(',').map(Number); if (list.length === count && list.every(Number.isFinite) && (count < 4 || Math.hypot(...list) > 0.1)) state[name] = made(list); },
});
const optionsOf = name => () => controls[name] ? [...controls[name].options].map(o => o.value) : [state[name]];
// What a link holds, in the order in which it is set. Texts from links are checked like any input.
const LINKED = {
  layout: choice('layout', optionsOf('layout')), wipe: amount('wipe', 0, wholes.length - 1), blink: { ...flag('blink'), set: text => setBlink(text === '1' && !lessMotion.matches) }, together: flag('together'),
  level: { get: () => String(state.one), set: text => { if (/^[0-9]+$/.test(text) && Number(text) < meshes.length) state.one = Number(text); } },
  smooth: flag('smooth'), edges: flag('edges'), backs: flag('backs'), perspective: flag('perspective'), axes: flag('axes'),
  theme: choice('theme', optionsOf('theme')), up: choice('up', optionsOf('up')),
  color: { get: () => state.color, set: text => { if (COLORS.some(([key]) => key === text)) setColor(text); } },
  map: choice('map', optionsOf('map')),
  only: { get: () => isAlone() ? String(state.only) : '', set: text => { const x = Number(text); state.only = text !== '' && showsLabels() && placeOf(labelsOf(state.color).list, x) >= 0 ? x : null; } },
  symmetric: flag('symmetric'), log: flag('log'), range: choice('range', optionsOf('range')),
  ends: {
    get: () => state.range === 'given' ? [state.low, state.high].join() : '',
    set: text => { const [low, high] = text.split(',').map(Number); if (state.range === 'given' && low < high && Number.isFinite(high - low) && !(state.log && low <= 0)) { state.low = low; state.high = high; } },
  },
  lines: {
    get: () => JSON.stringify([...state.overlays].sort()),
    set: text => { try { const names = JSON.parse(text); state.overlays = new Set([...panel.querySelectorAll('[data-overlay]')].map(i => i.dataset.overlay).filter(n => names.includes(n))); } catch { /* not a list: a damaged link changes nothing */ } },
  },
  sharp: amount('sharp', 1, 179), length: amount('length', 0.2, 4),
  cut: choice('cut', optionsOf('cut')), cutAt: amount('cutAt', -1, 1), cutOther: flag('cutOther'),
  measured: {
    get: () => state.ends.map(end => [end.mesh.number, ...end.world.map(x => digits(x, 12))].join()).join(';'),
    set: text => {
      const list = text.split(';').map(part => part.split(',').map(Number)).filter(part => part.length === 4 && part.every(Number.isFinite) && meshes[part[0]]);
      setMeasuring(list.length > 0);
      state.ends = list.slice(0, 2).map(([number, ...world]) => ({ mesh: meshes[number], world }));
      showMeasured(false);
    },
  },
  turn: vector('turn', 4, normalized), target: vector('target', 3), half: amount('half', 0, Infinity),
};
const CAMERA = ['turn', 'target', 'half'];
let initial = null, written = '', writing = null;
const settings = () => Object.fromEntries(Object.entries(LINKED).map(([name, { get }]) => [name, get()]));
// Only what differs from the page as it opened; the camera only if it was moved, because it is framed again elsewhere.
function linkText() {
  const now = settings(), parts = new URLSearchParams(), framed = isHome();
  for (const name in now) if (CAMERA.includes(name) ? !framed : now[name] !== initial[name]) parts.set(name, now[name]);
  const text = String(parts);
  return text && '#' + text;
}
function writeLink() {
  clearTimeout(writing); writing = null;
  if (!initial || linkText() === written) return;
  written = linkText();
  // Some frames may not change their address; the button then still tells it.
  try { history.replaceState(null, '', written || location.pathname + location.search); } catch { viewer.link = written; }
}
// Addresses may only change a few times per second.
function writeLater() { if (initial && !writing) writing = setTimeout(writeLink, 400); }
function readLink() {
  const parts = new URLSearchParams(location.hash.slice(1));
  for (const [name, { set }] of Object.entries(LINKED)) if (!CAMERA.includes(name)) set(parts.get(name) ?? initial[name]);
  // Without a camera, or with a part of one, the rest is as this window frames it.
  resetCamera();
  for (const name of CAMERA) LINKED[name].set(parts.get(name) ?? '');
  state.half = Math.min(Math.max(state.half, 1e-5 * radius()), 50 * radius());
  if (isField(state.color)) setRange();
  anchor = null;
  showControls();
  showLayout(); showTheme(); showFacts();
  written = linkText();
}
async function copyLink() {
  writeLink();
  const address = location.href.split('#')[0] + written, said = element('link');
  try {
    await navigator.clipboard.writeText(address);
    said.textContent = 'Copied';
    live.textContent = 'The link is copied';
    setTimeout(() => { said.textContent = 'Copy link'; }, 2000);
  } catch {
    // Without the right to copy, the address is there to be copied by hand.
    controls.address.parentElement.hidden = false;
    controls.address.value = address;
    controls.address.select();
  }
}
addEventListener('hashchange', () => { if (location.hash !== written) readLink(); });

element('leave').addEventListener('click', () => document.exitFullscreen());
document.addEventListener('fullscreenchange', () => { element('leave').hidden = !document.fullscreenElement; });

canvas.addEventListener('webglcontextlost', event => event.preventDefault());
canvas.addEventListener('webglcontextrestored', () => { start(); redraw(); });
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', showTheme);
lessMotion.addEventListener('change', () => { if (lessMotion.matches) setBlink(false); });
new ResizeObserver(() => { if (isHome()) resetCamera(); redraw(); }).observe(canvas);
setInterval(() => { if (state.layout === 'blink' && state.blink && wholes.length > 1 && !document.hidden) { state.shown = (state.shown + 1) % wholes.length; redraw(); } }, 700);

async function begin() {
  start();
  resetCamera();
  buildControls();
  showFacts();
  // Room for all that is told about a point, so that pointing moves nothing.
  element('values').style.setProperty('--rows', Math.max(...meshes.map(m => m.fields.size * 1.7 + (m.source.materials ? 1 : 0))) + (meshes.length > 1 ? 5 : 4));
  showPicked(null);
  showLayout();
  const first = COLORS.find(([key]) => key === page.start.color) ?? COLORS.find(([key]) => key === 'material') ?? COLORS.slice(1).find(([key]) => !isField(key) || !fieldOf(key).lazy) ?? COLORS[0];
  setColor(page.start.color === 'plain' ? 'plain' : first[0]);
  // The legend takes room beside the picture, which is known only now.
  resetCamera();
  if (page.start.range && isField(state.color)) { state.range = 'given'; [state.low, state.high] = page.start.range; state.symmetric = controls.symmetric.checked &&= state.low === -state.high; setRange(); }
  showTheme();
  initial = settings();
  readLink();
  element('loading').hidden = !anyMesh(m => m.materials?.images.length);
  // A mesh whose pictures cannot be shown is shown without them.
  await Promise.allSettled(meshes.map(loadImages));
  element('loading').hidden = true;
  isLoaded = true;
  redraw();
}
begin().catch(error => {
  viewer.error = String(error);
  element('problem').hidden = false;
  element('problem').append(make('p', { textContent: String(error) }));
  throw error;
});
})();
