"""GLB files read by themselves, as the format says, to be compared with what they were made of."""

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
from numpy.typing import NDArray

Array = NDArray[Any]

_TYPES = {5126: np.float32, 5125: np.uint32, 5123: np.uint16}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@dataclass
class Glb:
    """A file's JSON and binary chunk."""

    json: dict[str, Any]
    data: bytes

    def accessor(self, number: int) -> Array:
        said = self.json["accessors"][number]
        view = self.json["bufferViews"][said["bufferView"]]
        raw = self.data[view["byteOffset"] :][: view["byteLength"]]
        values = np.frombuffer(raw, _TYPES[said["componentType"]])
        return values.reshape(said["count"], _WIDTHS[said["type"]])

    def picture(self, texture: dict[str, Any], folder: Path) -> Array:
        """(H, W, C) codes of what a textureInfo shows, in 0..1."""
        found = self.json["textures"][texture["index"]]
        source = found.get("source")
        if source is None:
            source = found["extensions"]["EXT_texture_webp"]["source"]
        said = self.json["images"][source]
        view = self.json["bufferViews"][said["bufferView"]]
        file = folder / f"picture.{said['mimeType'].rpartition('/')[2]}"
        file.write_bytes(self.data[view["byteOffset"] :][: view["byteLength"]])
        config = OpenImageIO.ImageSpec()
        config.attribute("oiio:UnassociatedAlpha", 1)
        picture: Any = OpenImageIO.ImageInput.open(str(file), config)
        pixels = np.atleast_3d(np.asarray(picture.read_image("float")))
        picture.close()
        return pixels

    def placed(self) -> Iterator[tuple[dict[str, Any], Array]]:
        """Every node with (4, 4) its place in glTF's world."""
        todo = [(number, np.eye(4)) for number in self.json["scenes"][0].get("nodes", [])]
        while todo:
            number, above = todo.pop()
            node = self.json["nodes"][number]
            world = above @ local(node)
            yield node, world
            todo += [(child, world) for child in node.get("children", [])]

    def triangles(self) -> dict[str, Array]:
        """(M, 3, 3) corners in the world, Z up, by the prim; what is mirrored is turned round."""
        found: dict[str, list[Array]] = {}
        for node, world in self.placed():
            if "mesh" not in node:
                continue
            for primitive in self.json["meshes"][node["mesh"]]["primitives"]:
                rows = self.accessor(primitive["indices"]).reshape(-1, 3)
                points = self.accessor(primitive["attributes"]["POSITION"])
                corners = (points @ world[:3, :3].T + world[:3, 3])[rows]
                if np.linalg.det(world[:3, :3]) < 0:
                    corners = corners[:, ::-1]
                x, y, z = np.moveaxis(corners, -1, 0)
                corners = np.stack([x, -z, y], axis=-1)
                found.setdefault(node["extras"]["prim"], []).append(corners)
        return {prim: np.concatenate(parts) for prim, parts in found.items()}

    def named(self, kind: str, name: str) -> dict[str, Any]:
        (found,) = (item for item in self.json[kind] if item["name"] == name)
        return found


def local(node: dict[str, Any]) -> Array:
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = np.eye(4)
    matrix[:3, :3] = turn * node.get("scale", (1, 1, 1))
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix


def read(path: Path) -> Glb:
    whole = path.read_bytes()
    magic, version, length = struct.unpack_from("<4sII", whole)
    assert (magic, version, length) == (b"glTF", 2, len(whole))
    size, kind = struct.unpack_from("<I4s", whole, 12)
    assert kind == b"JSON" and size % 4 == 0
    said = json.loads(whole[20 : 20 + size])
    assert said["asset"]["version"] == "2.0"
    return Glb(said, whole[28 + size :])


def volume(corners: Array) -> float:
    """Signed volume inside of triangles, positive where they face outwards."""
    a, b, c = np.moveaxis(corners.astype(np.float64), 1, 0)
    return float((np.cross(a, b) * c).sum() / 6.0)
