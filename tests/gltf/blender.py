"""Blender's reading of a run's GLB beside the run's materials.npy. argv: the run's folder."""

import sys
from pathlib import Path

import bpy
import numpy as np

run = Path(sys.argv[1])
truth = np.nan_to_num(np.load(run / "materials.npy"))
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=str(run / "export/scene.glb"))
(thing,) = [o for o in bpy.context.scene.objects if o.type == "MESH"]
(slot,) = thing.material_slots
mesh = thing.data
assert len(mesh.polygons) == len(truth), f"{len(mesh.polygons)} faces, {len(truth)} materials"

bsdf = next(n for n in slot.material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")


def texels(socket: str) -> tuple[np.ndarray, str, bpy.types.Node]:
    """The image behind a socket as [height, width, 4], bottom row first; the channel that is taken; its node."""
    channel = "Color"
    link = bsdf.inputs[socket].links[0]
    while link.from_node.type != "TEX_IMAGE":
        if link.from_node.type == "SEPARATE_COLOR":
            channel = link.from_socket.name
        link = next(i.links[0] for i in link.from_node.inputs if i.links)
    if link.from_socket.name == "Alpha":
        channel = "Alpha"
    image = link.from_node.image
    assert link.from_node.interpolation == "Closest", link.from_node.interpolation
    pixels = np.array(image.pixels, np.float32).reshape(image.size[1], image.size[0], 4)
    return pixels, channel, link.from_node


uv = np.empty(2 * len(mesh.loops), np.float32)
mesh.uv_layers[0].data.foreach_get("uv", uv)
uv = uv.reshape(-1, 3, 2).mean(1)


def at_faces(pixels: np.ndarray) -> np.ndarray:
    height, width = pixels.shape[:2]
    return pixels[(uv[:, 1] * height).astype(int), (uv[:, 0] * width).astype(int)]


# Blender keeps the order of the faces.
pixels, channel, node = texels("Roughness")
assert (channel, node.image.colorspace_settings.is_data) == ("Green", True), channel
roughness = np.abs(at_faces(pixels)[:, 1] - truth[:, 6]).max()
pixels, channel, node = texels("Base Color")
srgb = np.clip(truth[:, :3], 0, 1)
srgb = np.where(srgb <= 0.0031308, 12.92 * srgb, 1.055 * srgb ** (1 / 2.4) - 0.055)
color = np.abs(at_faces(pixels)[:, :3] - srgb).max()
pixels, channel, node = texels("Specular IOR Level")
specular = np.abs(at_faces(pixels)[:, 3] - truth[:, 3:6].max(1)).max()
print(f"{len(truth)} faces; largest errors: roughness {roughness:.4f}, base colour {color:.4f}, specular {specular:.4f}")
assert channel == "Alpha" and max(roughness, color, specular) <= 0.5001 / 255 + 1e-4
