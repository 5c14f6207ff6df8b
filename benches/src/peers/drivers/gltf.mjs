// One run of a glTF tool on a raw mesh: gltfpack|gltf-transform faces COUNT THREADS REPEATS INPUT OUTPUT.
//
// Prints the least time of the calls in seconds, the faces of the result, a dash for the memory, and the least time that
// cores worked. Both tools are WebAssembly. gltfpack reads and writes a file, which counts.

import fs from "node:fs";
import { Document, NodeIO } from "@gltf-transform/core";
import { simplify, weld } from "@gltf-transform/functions";
import { pack } from "gltfpack";
import { MeshoptSimplifier } from "meshoptimizer";

const ENOUGH = 10;
const [name, , count, , repeats, input, output] = process.argv.slice(2);

function read(path) {
  const { buffer } = new Uint8Array(fs.readFileSync(path));
  const [vertices, triangles] = new BigUint64Array(buffer, 0, 2);
  const end = 16 + 24 * Number(vertices);
  const positions = new Float32Array(new Float64Array(buffer, 16, 3 * Number(vertices)));
  return [positions, new Uint32Array(buffer.slice(end, end + 12 * Number(triangles)))];
}

function write(path, positions, indices) {
  const counts = new BigUint64Array([positions.length, indices.length].map((n) => BigInt(n / 3)));
  const parts = [counts, new Float64Array(positions), new Uint32Array(indices)];
  fs.writeFileSync(path, Buffer.concat(parts.map((part) => Buffer.from(part.buffer))));
}

function documentOf([positions, indices]) {
  const document = new Document();
  const buffer = document.createBuffer();
  const accessor = (type, array) => document.createAccessor().setType(type).setArray(array).setBuffer(buffer);
  const primitive = document.createPrimitive();
  primitive.setAttribute("POSITION", accessor("VEC3", positions)).setIndices(accessor("SCALAR", indices));
  const node = document.createNode().setMesh(document.createMesh().addPrimitive(primitive));
  document.getRoot().setDefaultScene(document.createScene().addChild(node));
  return document;
}

// The arrays of all primitives, which a tool may have split.
function arraysOf(document) {
  const positions = [], indices = [];
  for (const mesh of document.getRoot().listMeshes())
    for (const primitive of mesh.listPrimitives()) {
      const first = positions.length / 3;
      for (const index of primitive.getIndices().getArray()) indices.push(first + index);
      for (const x of primitive.getAttribute("POSITION").getArray()) positions.push(x);
    }
  return [positions, indices];
}

// Functions that prepare a call, make it, and take the result. No limit of the error: the face count is the target.
const TOOLS = {
  "gltf-transform": {
    prepare: documentOf,
    call: (document, ratio) =>
      document.transform(weld(), simplify({ simplifier: MeshoptSimplifier, ratio, error: 1 })),
    take: arraysOf,
  },
  gltfpack: {
    prepare: async (mesh) => ({ bytes: await new NodeIO().writeBinary(documentOf(mesh)) }),
    // Without quantisation and renaming. The tool keeps an error of at most 1 % of the extent otherwise.
    call: async (files, ratio) => {
      const io = { read: () => files.bytes, write: (_, data) => (files.result = data.slice()) };
      const options = ["-noq", "-si", `${ratio}`, "-se", "1"];
      await pack(["-i", "input.glb", "-o", "output.glb", ...options], io);
    },
    take: async (files) => arraysOf(await new NodeIO().readBinary(files.result)),
  },
};

await MeshoptSimplifier.ready;
const { prepare, call, take } = TOOLS[name];
const mesh = read(input);
const ratio = count / (mesh[1].length / 3);
let least = Infinity, leastCpu = Infinity, total = 0, prepared;
for (let i = 0; i < Number(repeats) && total < ENOUGH; i++) {
  prepared = await prepare(mesh);
  const worked = process.cpuUsage(), start = performance.now();
  await call(prepared, ratio);
  const seconds = (performance.now() - start) / 1e3;
  const { user, system } = process.cpuUsage(worked);
  [least, leastCpu, total] = [Math.min(least, seconds), Math.min(leastCpu, (user + system) / 1e6), total + seconds];
}
const [positions, indices] = await take(prepared);
write(output, positions, indices);
console.log(`${least} ${indices.length / 3} - ${leastCpu}`);
