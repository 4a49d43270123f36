"""Read malicious files as every format, in a process with limits.

Print the results as JSON. ``python hostile_files.py FOLDER KIB``: the folder to write them into,
and the size of those that are merely large; files that expand grow to 256 times that.
"""

import json
import os
import resource
import struct
import sys
import zlib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
LARGE = int(sys.argv[2]) << 10  # bytes
UNPACKED = 256 * LARGE
resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
resource.setrlimit(resource.RLIMIT_CPU, (120, 120))

from worldgen.errors import WorldgenError  # noqa: E402
from worldgen.interop import FORMATS, read_map  # noqa: E402


def png(width, height, data=b"", extra=()):
    """Return a one-bit grey PNG with these sizes in its header; its pixels are the given bytes, or
    zeros.
    """

    def chunk(kind, body):
        return (
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        )

    head = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    pixels = data or zlib.compress(b"\0" * min((width // 8 + 1) * height, UNPACKED), 1)
    chunks = [
        chunk(b"IHDR", head),
        *(chunk(*one) for one in extra),
        chunk(b"IDAT", pixels),
        chunk(b"IEND", b""),
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


def npy(header, body=b""):
    """Return an array file with this header."""
    text = header.encode() + b"\n"
    return b"\x93NUMPY\x02\x00" + struct.pack("<I", len(text)) + text + body


KEYS = "resolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
LAUGHS = "a0: &a0 [x, x]\n" + "".join(f"a{n}: &a{n} [{f'*a{n - 1}, ' * 9}]\n" for n in range(1, 12))
ENTITIES = "".join(f'<!ENTITY e{n} "{f"&e{n - 1};" * 10}">' for n in range(1, 12))
XML = (
    f'<?xml version="1.0"?><!DOCTYPE sdf [<!ENTITY e0 "ha">{ENTITIES}]><sdf '
    f'version="1.6"><world '
    f'name="&e11;"/></sdf>'
)
OUTSIDE = (
    '<?xml version="1.0"?><!DOCTYPE sdf [<!ENTITY e SYSTEM "file:///etc/hostname">]><sdf '
    'version="1.6">&e;</sdf>'
)
SAME_FOR_ALL = {
    "empty": b"",
    "zeros": b"\0" * LARGE,
    "line-ends": b"\n" * LARGE,
    "spaces": b" " * LARGE,
    "letters": b"a" * LARGE,
    "hashes": b"#" * LARGE,
    "digits": b"9" * LARGE,
    "brackets": b"[" * LARGE,
    "braces": b'{"a":' * (LARGE // 4),
    "tags": b"<a>" * (LARGE // 3),
    "quotes": b'"\\' * (LARGE // 2),
    "dashes": b"- " * (LARGE // 2),
    "entities": XML.encode(),
    "outside": OUTSIDE.encode(),
    "laughs": LAUGHS.encode(),
    "long-number": b"1" * 60_000 + b": " + b"1" * 4_000,
}
PICTURES = {
    "wide.png": png(30_000, 30_000),
    "claims.png": png(2**31 - 1, 2**31 - 1, b"x"),
    "more.png": png(8, 8, zlib.compress(b"\0" * UNPACKED, 1)),
    "text.png": png(8, 8, extra=[(b"zTXt", b"a\0\0" + zlib.compress(b"a" * UNPACKED, 1))]),
    "broken.png": png(64, 64, b"\x78\x9c" + b"\xff" * 40),
    "many.pgm": b"P5\n20000 20000\n255\n",
    "plain.pgm": b"P2\n3000 2000\n255\n" + b"1 " * 1000,
}
OF_ONE = {
    "movingai": {
        "huge": b"type octile\nheight 999999999\nwidth 999999999\nmap\n",
        "tall": b"type octile\nheight 20000\nwidth 3000\nmap\n" + b"\n" * LARGE,
        "one-row": b"type octile\nheight 1\nwidth 20000\nmap\n" + b"." * LARGE,
    },
    "npy": {
        "huge": npy("{'descr': '|b1', 'fortran_order': False, 'shape': (99999999, 99999999), }"),
        "negative": npy("{'descr': '|b1', 'fortran_order': False, 'shape': (-1, 4), }"),
        "objects": npy(
            "{'descr': '|O', 'fortran_order': False, 'shape': (1, 1), }", b"cos\nsystem\n(S'x'\ntR."
        ),
        "deep": npy("(" * 100_000),
        "header": b"\x93NUMPY\x02\x00" + b"\xff" * 4 + b"{",
        "wide-type": npy("{'descr': '|V1000000000', 'fortran_order': False, 'shape': (1, 1), }"),
    },
    "ros": {f"image-{name}": f"image: {name}\n{KEYS}".encode() for name in PICTURES}
    | {
        f"leads-out-{number}": f"image: {name}\n{KEYS}".encode()
        for number, name in enumerate(
            ["/dev/zero", "../../../../etc/hostname", "pipe", "zero", "folder", "~/x.pgm"]
        )
    }
    | {
        "laughs": f"image: more.png\n{KEYS}{LAUGHS}".encode(),
        "deep": f"image: a\n{KEYS}b: {'[' * 50_000}".encode(),
    },
    "irsim": {
        "many": b"world: {height: 10, width: 10}\nobstacle:\n  - {number: 1000000000, shape: "
        b"{name: circle}}\n",
        "wide": b"world: {height: 1.0e+9, width: 1.0e+9}\nobstacle:\n  - {shape: {name: circle, "
        b"radius: 1.0e+9}}\n",
        "device": b"world: {height: 10, width: 10, obstacle_map: /dev/zero}\n",
        "pipe": b"world: {height: 10, width: 10, obstacle_map: pipe}\n",
        "bomb": b"world: {height: 10, width: 10, obstacle_map: wide.png}\n",
        "laughs": b"world: {height: 10, width: 10}\n" + LAUGHS.encode(),
    },
    "tiled": {
        "huge": b'{"type": "map", "width": 999999999, "height": 999999999, "layers": []}',
        "numbers": b'{"type": "map", "width": 1e999999, "height": ' + b"9" * 100_000 + b"}",
        "deep": b'{"type": "map", "layers": ' + b"[" * 200_000,
    },
    "svg": {
        "points": b'<svg><polyline stroke="red" points="' + b"1 1 " * (LARGE // 4) + b'"/></svg>',
        "shapes": b"<svg>" + b'<circle r="9"/>' * (LARGE // 512) + b"</svg>",
        "rules": b"<svg><style>" + b".a{fill:red}" * (LARGE // 12) + b"</style></svg>",
        "commands": b'<svg><path d="' + b"A1 1 0 1 1 .1 .1" * (LARGE // 16) + b'"/></svg>',
    },
    "dxf": {
        "lines": b"0\nSECTION\n2\nENTITIES\n" + b"0\nLINE\n8\n0\n" * (LARGE // 12),
        "tags": b"0\nSECTION\n" + b"999\nx\n" * (LARGE // 6),
    },
    "geojson": {
        "points": b'{"type": "LineString", "coordinates": ['
        + b"[1,2]," * (LARGE // 6)
        + b"[3,4]]}",
        "rings": b'{"type": "Polygon", "coordinates": ['
        + b"[[1,2],[2,2],[2,3]]," * (LARGE // 20)
        + b"[]]}",
    },
    "building": {
        "walls": b"levels:\n  L1:\n    vertices: [[0, 0], [1, 1]]\n    walls:\n"
        + b"      - [0, 1]\n" * (LARGE // 15),
        "laughs": b"levels:\n" + LAUGHS.encode(),
    },
    "webots": {
        "deep": b"#VRML_SIM R2023b utf8\n" + b"Group { children [ " * (LARGE // 19),
        "lists": b"#VRML_SIM R2023b utf8\nSolid { translation " + b"[ " * (LARGE // 2),
        "strings": b"#VRML_SIM R2023b utf8\nWorldInfo { info [ " + b'"\\' * (LARGE // 2),
        "numbers": b"#VRML_SIM R2023b utf8\nSolid { translation " + b"1 " * (LARGE // 2) + b"}",
        "copies": b"#VRML_SIM R2023b utf8\nDEF A0 Group { }\n"
        + b"".join(
            b"DEF A%d Group { children [ %s] }\n" % (n, 9 * (b"USE A%d " % (n - 1)))
            for n in range(1, 40)
        ),
        "boxes": b"#VRML_SIM R2023b utf8\n" + b"Shape{geometry Box{size 9 9 1}}" * (LARGE // 1024),
    },
    "png": PICTURES,
}


def bombs_of_tiled():
    """Layers whose compressed data expand a thousandfold, or are invalid."""
    import base64

    for name, packed in (
        ("bomb", zlib.compress(b"\0" * UNPACKED, 1)),
        ("broken", b"\x78\x9c" + b"\xff" * 64),
    ):
        layer = {
            "type": "tilelayer", "width": 8, "height": 8, "encoding": "base64", "compression": "zlib",
            "data": base64.b64encode(packed).decode(), "name": "walls", "x": 0, "y": 0,
        }  # fmt: skip
        yield name, json.dumps({"type": "map", "width": 8, "height": 8, "tilewidth": 8, "tileheight": 8,
                                "orientation": "orthogonal", "layers": [layer], "tilesets": []}).encode()  # fmt: skip


def main(folder):
    """Write the files, read each, and report the result."""
    os.mkfifo(folder / "pipe")
    (folder / "zero").symlink_to("/dev/zero")
    (folder / "folder").mkdir()
    for name, data in PICTURES.items():
        (folder / name).write_bytes(data)
    outcomes = []
    for name in [name for name in FORMATS if FORMATS.get(name).read is not None]:
        contents = {
            **SAME_FOR_ALL,
            **OF_ONE.get(name, {}),
            **(dict(bombs_of_tiled()) if name == "tiled" else {}),
        }
        for kind, data in contents.items():
            path = folder / (
                kind if kind in PICTURES else f"{name}-{kind}{FORMATS.get(name).suffixes[0]}"
            )
            path.write_bytes(data)
            outcomes.append((name, kind, _outcome(path, name)))
        outcomes += [
            (name, kind, _outcome(folder / kind, name))
            for kind in ("pipe", "zero", "folder", "missing")
        ]
    print(json.dumps(outcomes))


def _outcome(path, name):
    """The result is ``read``, the message of a refusal, or the name of an exception that nobody
    should see.
    """
    try:
        read_map(path, name)
        return "read"
    except WorldgenError as error:
        return f"refused: {error}"
    except BaseException as error:  # noqa: BLE001  whatever comes out is what is looked for
        return f"{type(error).__name__}: {error}"


if __name__ == "__main__":
    main(Path(sys.argv[1]))
