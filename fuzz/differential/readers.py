"""Reads damaged mesh files with curvmesh, trimesh and PyMeshLab, and compares what they read.

    python readers.py PROGRAM FOLDER COUNT SEED

PROGRAM is the program `curvmesh`. The script writes its seed meshes to FOLDER/seeds, damages COUNT
copies of them, and reads each copy with the three readers. More seeds can be put into that folder.
The same seeds and the same SEED give the same files. The script prints the files on which trimesh and
PyMeshLab agree with each other and curvmesh does not, sorted into kinds, and keeps them in
FOLDER/differences.
"""

import collections
import json
import math
import pathlib
import queue
import random
import re
import struct
import subprocess
import sys
import threading

LIMIT = 20.0
PEERS = ["trimesh", "pymeshlab"]


# Seeds.

def cube():
    points = [(x, y, z) for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.5)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return points, quads


def prism():
    ring = [(2 * math.cos(a), math.sin(a)) for a in (2 * math.pi * i / 5 for i in range(5))]
    points = [(round(x, 4), round(y, 4), z) for z in (-1.0, 0.5) for x, y in ring]
    sides = [(i, (i + 1) % 5, 5 + (i + 1) % 5, 5 + i) for i in range(5)]
    return points, [(4, 3, 2, 1, 0), (5, 6, 7, 8, 9), *sides]


def triangles(faces):
    return [(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)]


def number(value):
    return f"{value:g}"


def obj(points, faces, corner):
    lines = ["# a seed", "o part"]
    lines += ["v " + " ".join(map(number, point)) for point in points]
    lines += ["vt 0 0", "vt 1 0", "vt 0.5 1", "vn 0 0 1", "g side", "s off"]
    lines += ["f " + " ".join(corner(v, len(points)) for v in face) for face in faces]
    return "\n".join(lines) + "\n"


def ply(points, faces, layout, extra):
    kind = {"ascii": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}[layout]
    colour = ["property uchar red", "property uchar green", "property uchar blue"] if extra else []
    after = ["property uchar quality"] if extra else []
    # PyMeshLab does not read doubles in big endian.
    position = "double" if extra and layout != ">" else "float"
    head = ["ply", f"format {kind} 1.0", "comment a seed", f"element vertex {len(points)}"]
    head += [f"property {position} {axis}" for axis in "xyz"] + colour
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", *after]
    head = "\n".join([*head, "end_header"]) + "\n"
    if layout == "ascii":
        tail = [9] if extra else []
        rows = [[*map(number, point), *([200, 100, 50] if extra else [])] for point in points]
        rows += [[len(face), *face, *tail] for face in faces]
        return (head + "".join(" ".join(map(str, row)) + "\n" for row in rows)).encode()
    body = head.encode()
    for point in points:
        row = ("3d" if position == "double" else "3f") + ("3B" if extra else "")
        body += struct.pack(layout + row, *point, *([200, 100, 50] if extra else []))
    for face in faces:
        body += struct.pack(f"{layout}B{len(face)}i", len(face), *face) + (b"\x09" if extra else b"")
    return body


def stl_text(points, faces):
    lines = ["solid seed"]
    for face in triangles(faces):
        lines += ["  facet normal 0 0 1", "    outer loop"]
        lines += ["      vertex " + " ".join(map(number, points[v])) for v in face]
        lines += ["    endloop", "  endfacet"]
    return "\n".join([*lines, "endsolid seed"]) + "\n"


def stl_binary(points, faces):
    faces = triangles(faces)
    body = b"a seed".ljust(80, b"\0") + struct.pack("<I", len(faces))
    for face in faces:
        body += struct.pack("<12fH", 0, 0, 1, *(x for v in face for x in points[v]), 0)
    return body


def off(points, faces, coloured):
    lines = ["COFF" if coloured else "OFF", "# a seed", f"{len(points)} {len(faces)} 0"]
    lines += [" ".join(map(number, point)) + (" 0.2 0.4 0.6 1" if coloured else "") for point in points]
    lines += [f"{len(face)} " + " ".join(map(str, face)) for face in faces]
    return "\n".join(lines) + "\n"


def glb(points, faces, kind):
    """A scene of two nodes that show one mesh."""
    faces = triangles(faces)
    code, component = {"H": ("H", 5123), "I": ("I", 5125), "B": ("B", 5121)}[kind]
    place = struct.pack(f"<{3 * len(points)}f", *(x for point in points for x in point))
    index = struct.pack(f"<{3 * len(faces)}{code}", *(v for face in faces for v in face))
    index += b"\0" * (-len(index) % 4)
    low, high = ([f(point[i] for point in points) for i in range(3)] for f in (min, max))
    scene = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"mesh": 0, "translation": [3, 0, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3", "min": low, "max": high},
            {"bufferView": 1, "componentType": component, "count": 3 * len(faces), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(place)},
            {"buffer": 0, "byteOffset": len(place), "byteLength": len(index)},
        ],
        "buffers": [{"byteLength": len(place) + len(index)}],
    }
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text
    body += struct.pack("<I4s", len(place) + len(index), b"BIN\0") + place + index
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def write_seeds(folder):
    folder.mkdir(parents=True, exist_ok=True)
    corners = {
        "plain": lambda v, n: f"{v + 1}", "full": lambda v, n: f"{v + 1}/{v % 3 + 1}/1",
        "back": lambda v, n: f"{v - n}", "normal": lambda v, n: f"{v + 1}//1",
    }
    # Trimesh reads no faces of different sizes from binary PLY and OFF files.
    points, faces = prism()
    for name, (points, faces) in {"cube": cube(), "prism": (points, triangles(faces))}.items():
        files = {f"{style}.obj": obj(points, faces, corner) for style, corner in corners.items()}
        for layout, title in {"ascii": "text", "<": "little", ">": "big"}.items():
            files |= {f"{title}{extra:d}.ply": ply(points, faces, layout, extra) for extra in (False, True)}
        files |= {"text.stl": stl_text(points, faces), "binary.stl": stl_binary(points, faces)}
        files |= {"plain.off": off(points, faces, False), "colour.off": off(points, faces, True)}
        files |= {f"{kind}.glb": glb(points, faces, kind) for kind in "BHI"}
        for file, content in files.items():
            content = content if isinstance(content, bytes) else content.encode()
            (folder / f"{name}-{file}").write_bytes(content)


# Damage. A function gets the bytes and a source of random numbers, and returns the damaged bytes.

INTEGERS = [
    "-1", "0", "1", "2", "3", "7", "9", "10", "11", "-2", "-8", "-9", "255", "256", "65536", "2147483647",
    "2147483648", "4294967295", "4294967296", "4294967297", "18446744073709551616", "-9223372036854775809",
    "+1", "1.0", "1.5", "01", "0x1", "1e0", "nan",
]
REALS = [
    "nan", "NaN", "-nan", "inf", "-Infinity", "1e39", "1e400", "-1e308", "1e-400", "1e-46", "+1", ".5", "5.", "1d3",
    "0x1p3", "1,5", "1_0", "1e", "--1", "1e+05", "1.#IND", "1.#QNAN", "0.1f", "1.5.2", "",
]
ODD_LINES = {
    "obj": [
        "#", "# f 1 2 3", "vp 0.5", "l 1 2", "p 1", "f 1 2", "f 1 1 2", "f", "v", "v 1 2", "v 1 2 3 1", "v 1 2 3 2",
        "v 1 2 3 1 0 0", "usemtl none", "mtllib none.mtl", "call x", "F 1 2 3", "V 9 9 9", "\\", "g", "o", "f 1 2 3 #x",
    ],
    "ply": [
        "comment x", "obj_info x", "element edge 0", "property float w", "property list uchar int other", "",
        "3 0 1 2", "0", "1 0", "2 0 1", "3 0 0 1", "end_header", "element face 0", "element vertex 1",
    ],
    "stl": [
        "", "solid two", "endsolid", "vertex 1 2 3", "facet normal 0 0 0", "endloop", "VERTEX 1 2 3", "color 1 0 0",
    ],
    "off": ["", "#", "# 3 0 1 2", "3 0 1 2", "2 0 1", "1 0", "0", "3 0 0 1", "9 9 9", "OFF"],
}


def lines_of(data):
    return data.split(b"\n")


def at_random_line(change):
    def damage(data, rng, kind):
        lines = lines_of(data)
        change(lines, rng.randrange(len(lines)), rng, kind)
        return b"\n".join(lines)

    return damage


def cut_line(lines, i, rng, kind):
    del lines[i]


def repeat_line(lines, i, rng, kind):
    lines.insert(i, lines[i])


def move_line(lines, i, rng, kind):
    lines.insert(rng.randrange(len(lines)), lines.pop(i))


def odd_line(lines, i, rng, kind):
    lines.insert(i, rng.choice(ODD_LINES.get(kind, [""])).encode())


def empty_line(lines, i, rng, kind):
    lines.insert(i, rng.choice([b"", b" ", b"\t", b"#", b"\r"]))


def continued_line(lines, i, rng, kind):
    words = lines[i].split(b" ")
    at = rng.randrange(len(words))
    lines[i] = b" ".join(words[:at]) + b" \\\n " + b" ".join(words[at:])


def broken_line(lines, i, rng, kind):
    words = lines[i].split(b" ")
    at = rng.randrange(len(words))
    lines[i] = b" ".join(words[:at]) + b"\n" + b" ".join(words[at:])


def joined_line(lines, i, rng, kind):
    if i + 1 < len(lines):
        lines[i : i + 2] = [lines[i] + b" " + lines[i + 1]]


def longer_line(lines, i, rng, kind):
    lines[i] += rng.choice([b" 1", b" x", b" # x", b" 1 2 3", b"\r", b" ", b"\t", b"\0"])


def shorter_line(lines, i, rng, kind):
    lines[i] = b" ".join(lines[i].split(b" ")[:-1])


def other_case(lines, i, rng, kind):
    lines[i] = lines[i].swapcase()


def spaces(lines, i, rng, kind):
    lines[i] = rng.choice([b" ", b"\t", b""]) + lines[i].replace(b" ", rng.choice([b"\t", b"  ", b"\x0b", b" \t "]))


def replace_word(pattern, words):
    def damage(data, rng, kind):
        found = list(re.finditer(pattern, data))
        if not found:
            return data
        place = rng.choice(found)
        return data[: place.start()] + rng.choice(words).encode() + data[place.end() :]

    return damage


def line_ends(data, rng, kind):
    end = rng.choice([b"\r\n", b"\r", b"\n\r", b"\n\n"])
    return data.replace(b"\n", end)


def byte_order_mark(data, rng, kind):
    return b"\xef\xbb\xbf" + data


def no_last_end(data, rng, kind):
    return data.rstrip(b"\n")


def flip_bit(data, rng, kind):
    data = bytearray(data)
    data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(data)


def any_byte(data, rng, kind):
    data = bytearray(data)
    data[rng.randrange(len(data))] = rng.choice([0, 10, 13, 32, 45, 46, 48, 57, 92, 127, 128, 255])
    return bytes(data)


def cut_end(data, rng, kind):
    return data[: rng.randrange(1, len(data))]


def cut_few(data, rng, kind):
    return data[: -rng.randrange(1, 9)]


def append(data, rng, kind):
    return data + rng.choice([b"\0", b"\n", b"x", b"\0" * 50, b"1 2 3\n", data])


def body_start(data):
    """Where the binary part of a file starts."""
    end = data.find(b"end_header\n")
    return end + 11 if end >= 0 else 80


def four_bytes(data, rng, kind):
    order = rng.choice("<>")
    whole = (0, 1, 2, 7, 8, 9, 255, 2**16, 2**31 - 1, 2**31, 2**32 - 2, 2**32 - 1)
    special = [struct.pack(order + "I", n) for n in whole]
    special += [struct.pack(order + "f", x) for x in (math.nan, math.inf, -math.inf, 3e38, 1e-44, -0.0)]
    at = min(body_start(data) + rng.randrange(max(1, len(data) - body_start(data))), len(data) - 4)
    return data[:at] + rng.choice(special) + data[at + 4 :]


def header_word(data, rng, kind):
    end = max(body_start(data), 0) if kind == "ply" else len(data)
    words = b"int uint short char uchar float double int32 float64 uint8 x list".split()
    found = list(re.finditer(rb"\b(int|uchar|float|double)\b", data[:end]))
    if not found:
        return data
    place = rng.choice(found)
    return data[: place.start()] + rng.choice(words) + data[place.end() :]


def json_value(data, rng, kind):
    size = struct.unpack("<I", data[12:16])[0]
    text, rest = data[20 : 20 + size], data[20 + size :]
    found = list(re.finditer(rb"-?\d[\d.e+-]*|\"[A-Za-z0-9]+\"|\[|\{", text))
    place = rng.choice(found)
    values = "0 1 2 -1 3 4 5 5120 5121 5123 5125 5126 1.5 1e9 4294967296 null \"x\" [] {}".split()
    text = text[: place.start()] + rng.choice(values).encode() + text[place.end() :]
    text += b" " * (-len(text) % 4)
    sizes = struct.pack("<II4s", 20 + len(text) + len(rest), len(text), b"JSON")
    return data[:8] + sizes + text + rest


LINES = [
    cut_line, repeat_line, move_line, odd_line, empty_line, continued_line, broken_line, joined_line, longer_line,
    shorter_line, other_case, spaces,
]
BYTES = [flip_bit, any_byte, cut_end, append]
TEXT = {change.__name__: at_random_line(change) for change in LINES}
TEXT |= {change.__name__: change for change in [*BYTES, line_ends, byte_order_mark, no_last_end]}
TEXT |= {
    "integer": replace_word(rb"(?<![\w.])-?\d+(?![\w.])", INTEGERS),
    "real": replace_word(rb"(?<![\w.])-?\d+(\.\d+)?(?![\w.])", REALS),
}
BINARY = {change.__name__: change for change in [*BYTES, cut_few, four_bytes]}
HEADER = "integer cut_line repeat_line move_line odd_line spaces longer_line line_ends".split()


def header_only(change):
    def damage(data, rng, kind):
        start = body_start(data)
        return change(data[:start], rng, kind) + data[start:]

    return damage


def damages_of(data, kind):
    if kind == "glb":
        return BINARY | {"json_value": json_value}
    if kind == "ply" and b"format ascii" not in data:
        of_header = {"header_" + name: header_only(TEXT[name]) for name in HEADER}
        return BINARY | of_header | {"header_type": header_word}
    if kind == "stl" and not data.startswith(b"solid"):
        return BINARY
    return TEXT | ({"header_type": header_word} if kind == "ply" else {})


def variants(seeds, count, seed):
    for i in range(count):
        rng = random.Random(f"{seed}/{i}")
        path = rng.choice(seeds)
        data, kind, names = path.read_bytes(), path.suffix[1:], []
        for _ in range(rng.choice([1, 1, 1, 2])):
            damages = damages_of(data, kind)
            names.append(rng.choice(sorted(damages)))
            try:
                data = damages[names[-1]](data, rng, kind) or b"\0"
            except (ValueError, IndexError, struct.error):  # The first damage left nothing for the second.
                break
        yield path, f"{i:05}{path.suffix}", names, data


# Readers. A result is None for a refusal, or a dictionary.

def measure(parts):
    """Counts, bounding boxes of all and of used vertices, and area of parts of positions and triangles."""
    import numpy

    parts = [(numpy.asarray(p, float).reshape(-1, 3), numpy.asarray(t, int).reshape(-1, 3)) for p, t in parts]
    vertices, faces = sum(len(p) for p, _ in parts), sum(len(t) for _, t in parts)
    if vertices == 0:
        return None
    boxes = []
    for points in [numpy.vstack([p for p, _ in parts]), numpy.vstack([p[t.ravel()] for p, t in parts])]:
        points = points[numpy.isfinite(points).all(axis=1)]
        boxes.append([points.min(axis=0).tolist(), points.max(axis=0).tolist()] if len(points) else None)
    with numpy.errstate(all="ignore"):
        area = sum(
            float(numpy.linalg.norm(numpy.cross(p[t[:, 1]] - p[t[:, 0]], p[t[:, 2]] - p[t[:, 0]]), axis=1).sum() / 2)
            for p, t in parts
        )
    return {"vertices": vertices, "faces": faces, "boxes": boxes, "area": area if math.isfinite(area) else None}


def read_trimesh(path):
    import trimesh

    scene = trimesh.load_scene(path, process=False)
    parts = []
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        shape = scene.geometry[name]
        points = trimesh.transform_points(shape.vertices, transform)
        parts.append((points, getattr(shape, "faces", [])))
    return measure(parts)


def read_pymeshlab(path):
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(path)
    return measure([(m.transformed_vertex_matrix(), m.face_matrix()) for m in meshes])


def serve(name):
    """Answers paths from stdin; what the packages print goes to stderr."""
    import os

    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    read = {"trimesh": read_trimesh, "pymeshlab": read_pymeshlab}[name]
    for line in sys.stdin:
        try:
            answer = {"read": read(line.strip())}
        except BaseException as error:
            answer = {"read": None, "why": f"{type(error).__name__}: {error}"[:200]}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


class Peer:
    """A reader in a process of its own, which is started again after a crash or the time limit."""

    def __init__(self, name):
        self.name, self.process = name, None

    def start(self):
        command = [sys.executable, __file__, "--serve", self.name]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        self.answers = queue.Queue()
        threading.Thread(target=self.collect, args=(self.process.stdout, self.answers), daemon=True).start()

    @staticmethod
    def collect(stream, answers):
        for line in stream:
            answers.put(line)
        answers.put("")

    def read(self, path):
        if self.process is None:
            self.start()
        try:
            self.process.stdin.write(f"{path}\n")
            self.process.stdin.flush()
            line = self.answers.get(timeout=LIMIT)
        except (BrokenPipeError, queue.Empty):
            line = ""
        if line:
            return json.loads(line)
        self.process.kill()
        self.process = None
        return {"read": None, "why": "crash or time limit"}


def read_curvmesh(program, path):
    try:
        run = subprocess.run([program, "info", str(path), "--json"], capture_output=True, timeout=LIMIT, check=False)
        answer = json.loads(run.stdout)
    except subprocess.TimeoutExpired:
        return {"read": None, "why": "time limit", "fault": True}
    except ValueError:
        return {"read": None, "why": run.stderr.decode(errors="replace")[-300:], "fault": True}
    if "error" in answer:
        return {"read": None, "why": answer["error"]["message"]}
    box = [answer["bbox_min"], answer["bbox_max"]]
    if box[0] is None or None in box[0] + box[1]:
        box = None
    # Other triangles of a polygon that is not flat have another area.
    area = None if answer["quadrilaterals"] or answer["larger_polygons"] else answer["area"]
    read = {"vertices": answer["vertices"], "faces": answer["faces"], "boxes": [box], "area": area}
    return {"read": read, "why": " ".join(answer.get("warnings", [])) or "read"}


# Comparison.

def close(a, b):
    return abs(a - b) <= 1e-4 * max(1.0, abs(a), abs(b))


def same_box(a, b):
    if a is None or b is None:
        return a is b
    return all(close(x, y) for p, q in zip(a, b) for x, y in zip(p, q))


def differs(a, b, fields):
    """What two results differ in, or None."""
    if a is None or b is None:
        return None if a is b else "refused"
    if a["faces"] != b["faces"]:
        return "faces"
    if not any(same_box(x, y) for x in a["boxes"] for y in b["boxes"]):
        return "box"
    if None not in (a["area"], b["area"]) and not close(a["area"], b["area"]):
        return "area"
    return "vertices" if "vertices" in fields and a["vertices"] != b["vertices"] else None


def shape_of(message):
    """A message without its numbers and quotations, to sort by."""
    message = re.sub(r"^.*?\.(obj|ply|stl|off|glb): ", "", message)
    return re.sub(r"\d+", "N", re.sub(r"\"[^\"]*\"", '"_"', message))[:110]


def main(program, folder, count, seed):
    folder = pathlib.Path(folder).resolve()
    write_seeds(folder / "seeds")
    formats = {".obj", ".ply", ".stl", ".off", ".glb"}
    seeds = sorted(path for path in (folder / "seeds").iterdir() if path.suffix in formats)
    peers = [Peer(name) for name in PEERS]

    # Readers split and merge vertices by rules of their own. The numbers of vertices of a seed are compared only where
    # all agree on the seed itself.
    fields = {}
    for path in seeds:
        ours, *others = [read_curvmesh(program, path), *(peer.read(path) for peer in peers)]
        for peer, other in zip(peers, others):
            if difference := differs(ours["read"], other["read"], ()):
                print(f"seed {path.name}: {peer.name} differs in {difference}: {other.get('why', other['read'])}")
        counts = {result["read"] and result["read"]["vertices"] for result in [ours, *others]}
        fields[path] = ("vertices",) if len(counts) == 1 else ()

    kept = folder / "differences"
    kept.mkdir(exist_ok=True)
    kinds, totals, faults = collections.defaultdict(list), collections.Counter(), []
    for path, name, names, data in variants(seeds, int(count), seed):
        place = folder / f"current{path.suffix}"
        place.write_bytes(data)
        ours, first, second = [read_curvmesh(program, place), *(peer.read(place) for peer in peers)]
        totals["files"] += 1
        totals["read by curvmesh"] += ours["read"] is not None
        if ours.get("fault"):
            faults.append((name, ours["why"]))
            (kept / name).write_bytes(data)
        if differs(first["read"], second["read"], fields[path]):
            totals["the others disagree"] += 1
            continue
        difference = differs(ours["read"], first["read"], fields[path])
        if difference is None:
            totals["all agree"] += 1
            continue
        totals["curvmesh differs"] += 1
        if difference == "refused":
            difference = "only curvmesh reads" if first["read"] is None else "only curvmesh refuses"
        (kept / name).write_bytes(data)
        kind = (path.suffix[1:], difference, shape_of(ours["why"]))
        kinds[kind].append((name, path.name, "+".join(names), ours, first))

    for total, number_of in totals.items():
        print(f"{total}: {number_of}")
    for name, why in faults:
        print(f"FAULT {name}: {why}")
    for (kind, difference, message), members in sorted(kinds.items(), key=lambda item: -len(item[1])):
        print(f"\n{len(members)} x {kind}, {difference}: {message}")
        for name, path, names, ours, other in members[:6]:
            print(f"    {name} from {path}, {names}")
            if ours["read"] and other["read"]:
                print(f"        curvmesh {ours['read']}\n        others   {other['read']}")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        serve(sys.argv[2])
    elif len(sys.argv) == 5:
        main(*sys.argv[1:])
    else:
        sys.exit(__doc__)
