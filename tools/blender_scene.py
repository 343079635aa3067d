#!/usr/bin/env python3
"""Loads a GLB and the frames of `mesotex render` into Blender, and saves them as one scene.

    mesotex export A.map.ply --to glb -o A.glb --sample A.sample
    mesotex render A.sample A.map.ply -o frames --sweep light-azimuth
    blender --background --python tools/blender_scene.py -- A.glb frames -o A.blend
    tools/blender_scene.py A.glb frames -o A.blend           # without Blender: pip install bpy

The scene has the model with its materials and attributes (`_TEXTON`, `Color`), the frames as an image sequence behind the camera's
picture, and a camera and a sun that stand where those of each frame stood: the model covers its frame, pixel by pixel. Blender has
z upwards: (x, y, z) of the mesh is (x, -z, y) there. The sun has the frames' irradiance. Frames with several lights give no sun.

Blender 4.2 or later.
"""

import argparse
import math
import re
import struct
import sys
from pathlib import Path

import bpy
from mathutils import Matrix, Vector

Z_UP = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


def read_header(path):
    """The attributes of an EXR file that this script needs: matrices (for row vectors), vectors, numbers and the window."""
    formats = {"m44f": "<16f", "v3f": "<3f", "float": "<f", "box2i": "<4i"}
    attributes = {}
    with open(path, "rb") as file:
        if file.read(4) != b"\x76\x2f\x31\x01":
            raise SystemExit(f"{path}: found no EXR file; expected a frame of `mesotex render`")
        file.read(4)
        while name := read_word(file):
            kind = read_word(file)
            (size,) = struct.unpack("<i", file.read(4))
            data = file.read(size)
            if kind in formats:
                values = struct.unpack(formats[kind], data)
                attributes[name] = values[0] if len(values) == 1 else values
    for name in ("worldToCamera", "worldToNDC", "dataWindow"):
        if name not in attributes:
            raise SystemExit(f"{path}: found no attribute {name}; expected a frame of `mesotex render`")
    return attributes


def read_word(file):
    """Bytes up to a zero, as text."""
    word = b""
    while (letter := file.read(1)) not in (b"", b"\0"):
        word += letter
    return word.decode("latin-1")


def matrix(values):
    """A matrix for column vectors, as Blender has them."""
    return Matrix([values[i : i + 4] for i in range(0, 16, 4)]).transposed()


class Pose:
    """Where a frame's camera and light stand, in Blender's axes."""

    def __init__(self, header):
        camera_from_world = matrix(header["worldToCamera"])
        ndc_from_camera = matrix(header["worldToNDC"]) @ camera_from_world.inverted()
        axes = Z_UP @ camera_from_world.inverted()
        up, ahead, self.position = axes.col[1].to_3d(), axes.col[2].to_3d(), axes.col[3].to_3d()
        right = ahead.cross(up)
        self.camera = Matrix((right, up, -ahead)).transposed().to_4x4()
        self.camera.translation = self.position
        # Rows of the picture per unit at depth 1, or everywhere without perspective; the picture is 1 high.
        rows = abs(ndc_from_camera[1][1])
        self.is_perspective = abs(ndc_from_camera[3][2]) > 1e-9
        self.fov = 2 * math.atan(0.5 / rows)
        self.height = 1 / rows
        light = header.get("lightDirection")
        self.light = None if light is None else Z_UP.to_3x3() @ Vector(light)
        self.irradiance = header.get("lightIrradiance", math.pi)
        left, top, last_column, last_row = header["dataWindow"]
        self.size = (last_column - left + 1, last_row - top + 1)


def read_poses(folder):
    """Frames by number."""
    named = [(re.fullmatch(r"frame\.(\d+)\.exr", path.name), path) for path in sorted(folder.glob("frame.*.exr"))]
    poses = {int(match[1]): (path, Pose(read_header(path))) for match, path in named if match}
    if not poses:
        raise SystemExit(f"{folder}: found no frame.0001.exr; expected a folder of `mesotex render`")
    return poses


def add_camera(scene, poses):
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    lens = camera.data
    lens.sensor_fit = "VERTICAL"
    for number, (_, pose) in poses.items():
        camera.matrix_world = pose.camera
        lens.type = "PERSP" if pose.is_perspective else "ORTHO"
        lens.clip_start, lens.clip_end = 1e-3 * pose.position.length, 1e3 * pose.position.length
        lens.angle, lens.ortho_scale = pose.fov, pose.height
        for channel in ("location", "rotation_euler"):
            camera.keyframe_insert(channel, frame=number)
        for channel in ("lens", "ortho_scale"):
            lens.keyframe_insert(channel, frame=number)
    return camera


def add_sun(scene, poses):
    if any(pose.light is None for _, pose in poses.values()):
        return
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    scene.collection.objects.link(sun)
    sun.data.angle = 0
    sun.rotation_mode = "QUATERNION"
    for number, (_, pose) in poses.items():
        sun.data.energy = pose.irradiance
        sun.rotation_quaternion = pose.light.to_track_quat("Z", "Y")
        sun.keyframe_insert("rotation_quaternion", frame=number)
        sun.data.keyframe_insert("energy", frame=number)


def add_frames(camera, poses):
    numbers = list(poses)
    image = bpy.data.images.load(str(poses[numbers[0]][0].resolve()))
    image.name = "frames"
    image.source = "SEQUENCE"
    camera.data.show_background_images = True
    background = camera.data.background_images.new()
    background.image, background.alpha = image, 0.5
    user = background.image_user
    user.frame_start, user.frame_offset = numbers[0], numbers[0] - 1
    user.frame_duration = numbers[-1] - numbers[0] + 1


def build(glb, folder):
    """Makes the scene; returns it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(glb))
    scene = bpy.context.scene
    poses = read_poses(folder)
    camera = add_camera(scene, poses)
    add_sun(scene, poses)
    add_frames(camera, poses)
    scene.frame_start, scene.frame_end = min(poses), max(poses)
    scene.frame_set(scene.frame_start)
    _, first = poses[scene.frame_start]
    scene.render.resolution_x, scene.render.resolution_y = first.size
    scene.render.resolution_percentage = 100
    scene.render.film_transparent = True
    scene.render.engine = "CYCLES"
    scene.view_settings.view_transform = "Standard"
    return scene


def main():
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("glb", type=Path)
    parser.add_argument("frames", type=Path, help="the folder that `mesotex render` wrote")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="SCENE.blend")
    arguments = parser.parse_args(words)
    if not arguments.glb.is_file():
        parser.error(f"{arguments.glb}: not there; expected a GLB file")
    scene = build(arguments.glb, arguments.frames)
    bpy.ops.wm.save_as_mainfile(filepath=str(arguments.output.resolve()))
    vertices = sum(len(mesh.vertices) for mesh in bpy.data.meshes)
    print(f"{arguments.output}: {vertices} vertices, frames {scene.frame_start} to {scene.frame_end}")


if __name__ == "__main__":
    main()
