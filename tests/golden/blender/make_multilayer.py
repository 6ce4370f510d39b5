"""Renders multilayer.exr, a file as Blender 3.4 writes it, with passes whose values the
tests know:

    blender --background --factory-startup --python make_multilayer.py -- multilayer.exr

Cycles, 48 x 32, 16 samples, film transparent, half floats, ZIP. A sphere of metal (base
colour 0.8 0.4 0.2, metallic 1, roughness 0.25) of radius 1 at the origin and a matte floor
(0.2 0.5 0.3, roughness 0.75) at z = -1, each with value AOVs `roughness` and `metallic` and a
colour AOV `albedo` (GlossCol of this metal is white in Blender 3.4); a small lamp panel that emits (4, 2, 1). The camera stands at (3, -4, 2.5), looks at the
origin and sees 40 degrees vertically.
"""
import math
import sys

import bpy
from mathutils import Vector

out = sys.argv[sys.argv.index("--") + 1]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene


def material(name, color, metallic, roughness, emission=None):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    nodes = m.node_tree.nodes
    shader = nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1)
    shader.inputs["Metallic"].default_value = metallic
    shader.inputs["Roughness"].default_value = roughness
    if emission:
        shader.inputs["Emission"].default_value = (*emission, 1)
        shader.inputs["Emission Strength"].default_value = 1
    for key, value in (("roughness", roughness), ("metallic", metallic)):
        node = nodes.new("ShaderNodeOutputAOV")
        node.name = key
        node.inputs["Value"].default_value = value
    node = nodes.new("ShaderNodeOutputAOV")
    node.name = "albedo"
    node.inputs["Color"].default_value = (*color, 1)
    return m


def place(index, material):
    o = bpy.context.object
    o.pass_index = index
    material.pass_index = 10 + index
    o.data.materials.append(material)


bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=1)
bpy.ops.object.shade_smooth()
place(1, material("copper", (0.8, 0.4, 0.2), 1.0, 0.25))
bpy.ops.mesh.primitive_plane_add(size=6, location=(0, 0, -1))
place(2, material("floor", (0.2, 0.5, 0.3), 0.0, 0.75))
bpy.ops.mesh.primitive_plane_add(size=2, location=(-2.2, 0.5, 0.2), rotation=(math.pi / 2, 0, 0))
place(3, material("lamp", (0.1, 0.1, 0.1), 0.0, 0.5, (4, 2, 1)))

camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
camera.location = (3, -4, 2.5)
camera.rotation_euler = (-Vector(camera.location)).to_track_quat("-Z", "Y").to_euler()
camera.data.sensor_fit = "VERTICAL"
camera.data.angle_y = math.radians(40)
scene.collection.objects.link(camera)
scene.camera = camera
sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
sun.rotation_euler = (0.5, 0.3, 0)
scene.collection.objects.link(sun)

layer = scene.view_layers[0]
layer.use_pass_z = layer.use_pass_position = layer.use_pass_normal = True
layer.use_pass_diffuse_color = layer.use_pass_glossy_color = layer.use_pass_emit = True
layer.use_pass_object_index = layer.use_pass_material_index = True
for key, kind in (("roughness", "VALUE"), ("metallic", "VALUE"), ("albedo", "COLOR")):
    aov = layer.aovs.add()
    aov.name = key
    aov.type = kind

scene.render.engine = "CYCLES"
scene.cycles.samples = 16
scene.cycles.use_denoising = False
scene.cycles.use_adaptive_sampling = False
scene.render.film_transparent = True
scene.render.resolution_x, scene.render.resolution_y = 48, 32
scene.render.resolution_percentage = 100
scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
scene.render.image_settings.color_depth = "16"
scene.render.image_settings.exr_codec = "ZIP"
scene.render.use_stamp_filename = scene.render.use_stamp_date = False
scene.render.threads_mode = "FIXED"
scene.render.threads = 1
scene.render.filepath = "//multilayer.exr" if out == "-" else out
bpy.ops.render.render(write_still=True)
