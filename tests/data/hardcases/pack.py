#!/usr/bin/env python3
"""Packs the hard cases from their text form into the files beside this script.

    python3 pack.py DIRECTORY_WITH_TEXT_FILES     pack
    python3 pack.py --unpack DIRECTORY            write the text files back, to compare

README.md describes both forms. Packing is deterministic: the same text gives the same bytes.
"""

import gzip
import pathlib
import struct
import sys

HERE = pathlib.Path(__file__).parent
KINDS = ["none", "point", "segment", "area"]
PAIR_FILES = 2


def planes(columns):
    """Columns of 64-bit words, one byte plane after another: equal bytes side by side pack well."""
    return b"".join(bytes(w >> 8 * k & 255 for w in column) for column in columns for k in range(8))


def unplanes(data, count, width):
    column = lambda c: [
        sum(data[(8 * c + k) * count + i] << 8 * k for k in range(8)) for i in range(count)
    ]
    return list(zip(*(column(c) for c in range(width))))


def write(name, data):
    packed = gzip.compress(data, 9, mtime=0)
    assert len(packed) < 1_000_000, (name, len(packed))
    (HERE / name).write_bytes(packed)
    print(f"{name}: {len(data)} -> {len(packed)} bytes")


def name_bytes(name):
    return struct.pack("<B", len(name)) + name.encode("ascii")


def words(text):
    return [int(h, 16) for h in text]


def pack_pairs(text):
    rows = [l.split() for l in text.splitlines() if not l.startswith("#")]
    families = list(dict.fromkeys(r[0] for r in rows))
    share = -(-len(families) // PAIR_FILES)
    for part in range(PAIR_FILES):
        names = families[part * share : (part + 1) * share]
        mine = [r for r in rows if r[0] in names]
        assert all((r[1] == "1") == (r[2] != "none") for r in mine)
        data = struct.pack("<II", len(mine), len(names)) + b"".join(map(name_bytes, names))
        data += bytes(names.index(r[0]) for r in mine)
        data += bytes(KINDS.index(r[2]) for r in mine)
        data += planes(zip(*(words(r[3:]) for r in mine)))
        write(f"pairs-{part}.bin.gz", data)


def pack_meshes(text):
    lines = iter(l.split() for l in text.splitlines() if not l.startswith("#"))
    data, count = b"", 0
    for _, name, *sizes in lines:
        vertices_a, faces_a, vertices_b, faces_b, pairs = map(int, sizes)
        data += name_bytes(name) + struct.pack("<5I", *map(int, sizes))
        for field, length in ("q", 4), ("R", 9), ("t", 3):
            row = next(lines)
            assert row[0] == field and len(row) == length + 1
            data += struct.pack(f"<{length}Q", *words(row[1:]))
        for vertices, faces in (vertices_a, faces_a), (vertices_b, faces_b):
            for _ in range(vertices):
                data += struct.pack("<3Q", *words(next(lines)[1:]))
            for _ in range(faces):
                data += struct.pack("<3I", *map(int, next(lines)[1:]))
        for _ in range(pairs):
            data += struct.pack("<2I", *map(int, next(lines)[1:]))
        count += 1
    write("meshes.bin.gz", struct.pack("<I", count) + data)


def pack_transforms(text):
    rows = [words(l.split()) for l in text.splitlines() if not l.startswith("#")]
    write("transforms.bin.gz", struct.pack("<I", len(rows)) + planes(zip(*rows)))


def hexes(numbers):
    return " ".join(f"{n:016x}" for n in numbers)


def unpack_pairs():
    for part in range(PAIR_FILES):
        data = gzip.decompress((HERE / f"pairs-{part}.bin.gz").read_bytes())
        (count, families), at, names = struct.unpack_from("<II", data), 8, []
        for _ in range(families):
            names.append(data[at + 1 : at + 1 + data[at]].decode())
            at += 1 + data[at]
        rows = unplanes(data[at + 2 * count :], count, 18)
        for family, kind, row in zip(data[at:], data[at + count :], rows):
            yield f"{names[family]} {int(kind > 0)} {KINDS[kind]} {hexes(row)}"


def unpack_meshes():
    data = gzip.decompress((HERE / "meshes.bin.gz").read_bytes())
    at = 0

    def take(form):
        nonlocal at
        at += struct.calcsize(form)
        return struct.unpack_from(form, data, at - struct.calcsize(form))

    for _ in range(take("<I")[0]):
        name = take(f"{take('<B')[0]}s")[0].decode()
        sizes = take("<5I")
        yield f"case {name} {' '.join(map(str, sizes))}"
        for field, length in ("q", 4), ("R", 9), ("t", 3):
            yield f"{field} {hexes(take(f'<{length}Q'))}"
        for vertices, faces in sizes[:2], sizes[2:4]:
            yield from (f"v {hexes(take('<3Q'))}" for _ in range(vertices))
            yield from ("f %d %d %d" % take("<3I") for _ in range(faces))
        yield from ("p %d %d" % take("<2I") for _ in range(sizes[4]))


def unpack_transforms():
    data = gzip.decompress((HERE / "transforms.bin.gz").read_bytes())
    count = struct.unpack_from("<I", data)[0]
    for row in unplanes(data[4:], count, 22):
        yield f"{hexes(row[:10])}  {hexes(row[10:])}"


FORMS = {
    "dev.txt": (pack_pairs, unpack_pairs),
    "dev_meshes.txt": (pack_meshes, unpack_meshes),
    "transforms.txt": (pack_transforms, unpack_transforms),
}


def main(arguments):
    unpacking = arguments[:1] == ["--unpack"]
    (directory,) = arguments[1:] if unpacking else arguments
    for name, (pack, unpack) in FORMS.items():
        path = pathlib.Path(directory) / name
        if unpacking:
            path.write_text("\n".join(unpack()) + "\n")
        else:
            pack(path.read_text())


if __name__ == "__main__":
    main(sys.argv[1:])
