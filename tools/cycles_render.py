"""Renders a glTF file with Blender's Cycles as pbnds sees it, and scores two pictures.

    blender -b --factory-startup -P tools/cycles_render.py -- render SCENE FACTS.json OUT.exr [options]
    blender -b --factory-startup -P tools/cycles_render.py -- score NAME OURS1.exr OURS2.exr MASK.exr CYCLES.exr
    blender -b --factory-startup -P tools/cycles_render.py -- vary SCENE OUT.glb lambert|metal|flat

tools/judge_cycles calls them; see tools/JUDGE.md for what is compared and why. FACTS.json is
what `pbnds info --json` says of pbnds' own render: the exact camera, and how the light map is
turned. Written for Blender 3.4 (Debian 12).
"""
import argparse
import base64
import json
import math
import os
import sys
import urllib.parse

import numpy

# Blender 3.4's glTF importer uses names that numpy 1.24 has dropped.
for alias, kind in (("bool", bool), ("int", int), ("float", float), ("object", object)):
    if alias not in numpy.__dict__:
        setattr(numpy, alias, kind)

import bpy  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402

# glTF is y-up, Blender z-up: (x, y, z) becomes (x, -z, y), as its importer does.
Z_UP = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))
# u of the convention less u of gltf, in turns.
ROLL = {"gltf": 0.0, "openexr": -0.25, "falcor": 0.25, "pbnds": 0.5}
ALPHA_MIN = 1e-3  # narrowest lobe of pbnds (brdf_ggx.h)
# The index whose Fresnel curve is nearest to Schlick's without being far above it.
PRINCIPLED_IOR = 1.3


# ------------------------------------------------------------------ directional albedo tables

TABLE = 64


def hammersley(count):
    i = numpy.arange(count)
    bits = i.astype(numpy.uint32)
    for shift, mask in ((1, 0x55555555), (2, 0x33333333), (4, 0x0F0F0F0F), (8, 0x00FF00FF)):
        bits = ((bits & mask) << shift) | ((bits >> shift) & mask)
    second = ((bits << 16) | (bits >> 16)).astype(numpy.float64) / 2.0**32
    return (i + 0.5) / count, second + 0.5 / count


def visible_normals(wo, alpha, count):
    """Half vectors by their visible share (Heitz 2018), rows of an array."""
    u1, u2 = hammersley(count)
    v = numpy.array((alpha * wo[0], 0.0, wo[2]))
    v /= numpy.linalg.norm(v)
    t1 = numpy.array((0.0, 1.0, 0.0))
    t2 = numpy.cross(v, t1)
    r, phi, s = numpy.sqrt(u1), 2.0 * math.pi * u2, 0.5 * (1.0 + v[2])
    p1 = r * numpy.cos(phi)
    p2 = (1.0 - s) * numpy.sqrt(1.0 - p1 * p1) + s * r * numpy.sin(phi)
    p3 = numpy.sqrt(numpy.maximum(1.0 - p1 * p1 - p2 * p2, 0.0))
    h = p1[:, None] * t1 + p2[:, None] * t2 + p3[:, None] * v
    h = numpy.stack((alpha * h[:, 0], alpha * h[:, 1], numpy.maximum(h[:, 2], 1e-9)), 1)
    return h / numpy.linalg.norm(h, axis=1, keepdims=True)


def principled_fresnel(cos):
    """What Cycles' Principled metal puts in place of Schlick's (1 - cos)^5: the Fresnel term
    of its index, from 0 at normal incidence to 1."""
    n = PRINCIPLED_IOR
    g = numpy.sqrt(n * n - 1.0 + cos * cos)
    f = 0.5 * ((g - cos) / (g + cos)) ** 2 * (
        1.0 + ((cos * (g + cos) - 1.0) / (cos * (g - cos) + 1.0)) ** 2)
    f0 = ((n - 1.0) / (n + 1.0)) ** 2
    return (f - f0) / (1.0 - f0)


def ggx_albedo(cos_o, alpha, count):
    """What GGX seen at cos_o returns of light from everywhere: with pbnds' terms, the
    height-correlated Smith and k = (1 - wo.h)^5, for F = 1 - k and F = k (the albedo is f0
    times the first plus f90 times the second); with those of Cycles 3.4, the product G1 G1
    and its own k, for F = 1, 1 - k and k."""
    wo = numpy.array((math.sqrt(max(1.0 - cos_o * cos_o, 0.0)), 0.0, cos_o))
    h = visible_normals(wo, alpha, count)
    o_h = h @ wo
    cos_i = 2.0 * o_h * h[:, 2] - cos_o
    up = cos_i > 0.0
    cos_i = numpy.where(up, cos_i, 1.0)

    def smith(c):  # Lambda
        return 0.5 * (numpy.sqrt(1.0 + alpha * alpha * (1.0 / (c * c) - 1.0)) - 1.0)

    lo, li = smith(cos_o), smith(cos_i)
    correlated = numpy.where(up, (1.0 + lo) / (1.0 + lo + li), 0.0)
    separable = numpy.where(up, 1.0 / (1.0 + li), 0.0)
    k = numpy.clip(1.0 - o_h, 0.0, 1.0) ** 5
    q = principled_fresnel(numpy.clip(o_h, 0.0, 1.0))
    return ((correlated * (1.0 - k)).mean(), (correlated * k).mean(), separable.mean(),
            (separable * (1.0 - q)).mean(), (separable * q).mean())


def albedo_tables():
    """ggx_albedo() by (roughness, cos); row 0 is roughness 0."""
    table = numpy.empty((TABLE, TABLE, 5))
    for y in range(TABLE):
        alpha = max((y / (TABLE - 1)) ** 2, ALPHA_MIN)
        for x in range(TABLE):
            table[y, x] = ggx_albedo(max(x / (TABLE - 1), 1e-3), alpha, 1024)
    return table


def float_image(name, rgb, alpha=None):
    """A picture of floats that Cycles reads as they are; row 0 is the lowest."""
    height, width = rgb.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True, is_data=True)
    image.alpha_mode = "CHANNEL_PACKED"
    rgba = numpy.ones((height, width, 4), numpy.float32)
    rgba[..., :3] = rgb
    if alpha is not None:
        rgba[..., 3] = alpha
    image.pixels.foreach_set(rgba.ravel())
    image.update()
    image.pack()
    return image


# ------------------------------------------------------------------ node trees

class Tree:
    """Nodes by formula. A value is a socket, a number or a triple."""

    def __init__(self, node_tree):
        self.tree = node_tree

    def node(self, kind, **attributes):
        n = self.tree.nodes.new(kind)
        for key, value in attributes.items():
            setattr(n, key, value)
        return n

    def put(self, socket, value):
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(socket, value)
        elif isinstance(value, (int, float)):
            vector = hasattr(socket.default_value, "__len__")
            socket.default_value = (value,) * 3 if vector else value
        elif len(socket.default_value) == 4:
            socket.default_value = (*value[:3], 1.0)
        else:
            socket.default_value = value[:3]

    def math(self, operation, a, b=0.0):
        n = self.node("ShaderNodeMath", operation=operation)
        self.put(n.inputs[0], a)
        self.put(n.inputs[1], b)
        return n.outputs[0]

    def vector(self, operation, a, b=(0.0, 0.0, 0.0)):
        n = self.node("ShaderNodeVectorMath", operation=operation)
        self.put(n.inputs[0], a)
        self.put(n.inputs[1], b)
        return n.outputs["Value" if operation in ("DOT_PRODUCT", "LENGTH") else "Vector"]

    def add(self, a, b):
        return self.vector("ADD", a, b)

    def mul(self, a, b):
        return self.vector("MULTIPLY", a, b)

    def lerp(self, a, b, t):
        """a + t (b - a) of colours, t a number."""
        return self.add(a, self.mul(self.vector("SUBTRACT", b, a), t))

    def split(self, color):
        n = self.node("ShaderNodeSeparateXYZ")
        self.put(n.inputs[0], color)
        return n.outputs[0], n.outputs[1], n.outputs[2]

    def color_input(self):
        """(socket that the importer fills, socket to read it from)"""
        n = self.node("ShaderNodeMix", data_type="RGBA", blend_type="MIX")
        n.inputs["Factor"].default_value = 0.0
        n.inputs[6].default_value = (1.0, 1.0, 1.0, 1.0)
        return n.inputs[6], n.outputs[2]

    def float_input(self, value=1.0):
        n = self.node("ShaderNodeMath", operation="ADD")
        n.inputs[0].default_value, n.inputs[1].default_value = value, 0.0
        return n.inputs[0], n.outputs[0]

    def add_shaders(self, a, b):
        n = self.node("ShaderNodeAddShader")
        self.put(n.inputs[0], a)
        self.put(n.inputs[1], b)
        return n.outputs[0]


class Materials:
    """glTF materials as Cycles nodes: the factors, textures and vertex colours by the
    importer's helpers, the BSDF as near to pbnds' as nodes come."""

    def __init__(self, options):
        from io_scene_gltf2.blender.imp import gltf2_blender_pbrMetallicRoughness as helpers
        from io_scene_gltf2.blender.imp.gltf2_blender_texture import texture
        from io_scene_gltf2.io.com.gltf2_io import Material, TextureInfo
        self.options, self.helpers, self.importers_texture = options, helpers, texture
        self.texture_info, self.material = TextureInfo, Material
        helpers.texture = self.texture
        table = albedo_tables()
        self.ours = float_image("albedo of pbnds", table[..., 0:3])
        self.theirs = float_image("albedo of Principled", table[..., [3, 4, 4]])

    def texture(self, mh, tex_info, location, label, color_socket, alpha_socket=None,
                is_data=False, forced_image=None):
        """The importer's, but that an image may serve as colour and as data."""
        nodes = mh.node_tree.nodes
        before = {n.name for n in nodes}
        self.importers_texture(mh, tex_info, location, label, color_socket, alpha_socket,
                               False, forced_image)
        for node in nodes:
            if node.name not in before and node.type == "TEX_IMAGE":
                node["is_data"] = is_data

    def of_meshes_without(self):
        """The material that glTF 2.0 gives where there is none; the importer gives none."""
        from io_scene_gltf2.blender.imp.gltf2_blender_material import MaterialHelper
        bare = bpy.data.materials.new("default")
        bare.use_nodes = True
        bare.node_tree.nodes.clear()
        self.metallic_roughness(MaterialHelper(None, self.material.from_dict({}), bare, None))
        for mesh in bpy.data.meshes:
            if not mesh.materials:
                mesh.materials.append(bare)
            for i, material in enumerate(mesh.materials):
                if material is None:
                    mesh.materials[i] = bare

    def install(self):
        from io_scene_gltf2.blender.imp import gltf2_blender_material as material
        material.pbr_metallic_roughness = self.metallic_roughness
        material.pbr_specular_glossiness = self.specular_glossiness
        material.unlit = self.unlit

    def look_up(self, t, image, x, y):
        """Bilinear in a TABLE x TABLE picture whose texel centres are at 0 and 1."""
        scale, shift = (TABLE - 1) / TABLE, 0.5 / TABLE
        n = t.node("ShaderNodeCombineXYZ")
        t.put(n.inputs[0], t.math("ADD", t.math("MULTIPLY", x, scale), shift))
        t.put(n.inputs[1], t.math("ADD", t.math("MULTIPLY", y, scale), shift))
        look = t.node("ShaderNodeTexImage", image=image, interpolation="Linear",
                      extension="EXTEND")
        t.put(look.inputs[0], n.outputs[0])
        return t.split(look.outputs["Color"])

    def read_texture(self, mh, t, info, is_data):
        """(color, alpha) of a textureInfo in an extension's dictionary."""
        color, out = t.color_input()
        alpha, alpha_out = t.float_input()
        self.texture(mh, self.texture_info.from_dict(info), (0, 0), "", color, alpha, is_data)
        return out, alpha_out

    def normal(self, mh, t):
        info = mh.pymat.normal_texture
        if info is None:
            return t.node("ShaderNodeNewGeometry").outputs["Normal"]
        scale = 1.0 if info.scale is None else info.scale
        color, out = t.color_input()
        self.texture(mh, info, (0, 0), "NORMALMAP", color, None, True)
        # x and y are scaled, z is not: glTF 2.0, 3.9.3; Blender's strength is another formula
        n = t.node("ShaderNodeNormalMap")
        uv = info.tex_coord or 0
        uv = ((info.extensions or {}).get("KHR_texture_transform") or {}).get("texCoord", uv)
        n.uv_map = "UVMap" if uv == 0 else "UVMap.%03d" % uv
        half = (0.5, 0.5, 0.5)
        scaled = t.mul(t.vector("SUBTRACT", out, half), (scale, scale, 1.0))
        t.put(n.inputs["Color"], t.add(scaled, half))
        return n.outputs["Normal"]

    def cos_of_bent(self, t, normal):
        """dot(n, wo) of the normal that shades in pbnds: bent where its mirror direction lies
        below the face (engine/scene/surface.c, leave_face()). Cycles bends the normal of its
        closures itself, by a rule of its own; only the tables have to be told."""
        geometry = t.node("ShaderNodeNewGeometry")
        wo, ng = geometry.outputs["Incoming"], geometry.outputs["True Normal"]

        def dot(a, b):
            return t.vector("DOT_PRODUCT", a, b)

        def times(a, b):
            return t.math("MULTIPLY", a, b)

        def root(a):
            return t.math("SQRT", t.math("MAXIMUM", a, 0.0))

        eye, up, cos = dot(wo, ng), dot(normal, ng), dot(normal, wo)
        h = t.math("MINIMUM", 0.01, times(0.5, eye))
        x = t.vector("NORMALIZE", t.vector("SUBTRACT", normal, t.mul(ng, up)))
        b = dot(wo, x)
        square = t.math("ADD", times(eye, eye), times(b, b))
        rest = times(b, root(t.math("SUBTRACT", square, times(h, h))))
        c = t.math("DIVIDE", t.math("SUBTRACT", times(eye, h), rest), square)
        half = times(0.5, c)
        bent = t.math("ADD", times(eye, root(t.math("ADD", 0.5, half))),
                      times(b, root(t.math("SUBTRACT", 0.5, half))))
        mirror = t.math("SUBTRACT", times(2.0, times(cos, up)), eye)
        hidden = t.math("LESS_THAN", mirror, h)
        kept = times(t.math("SUBTRACT", 1.0, hidden), cos)
        return t.math("MAXIMUM", t.math("ADD", times(hidden, bent), kept), 0.0)

    def emission(self, mh, t):
        factor = mh.pymat.emissive_factor or [0.0, 0.0, 0.0]
        extension = (mh.pymat.extensions or {}).get("KHR_materials_emissive_strength") or {}
        strength = extension.get("emissiveStrength", 1.0)
        color = tuple(f * strength for f in factor)
        if max(color) == 0.0:
            return None
        if mh.pymat.emissive_texture is not None:
            into, out = t.color_input()
            self.texture(mh, mh.pymat.emissive_texture, (0, 0), "EMISSIVE", into)
            color = t.mul(out, color)
        n = t.node("ShaderNodeEmission")
        t.put(n.inputs["Color"], color)
        return n.outputs[0]

    def finish(self, mh, t, shader, alpha):
        """alpha: None where the material is opaque."""
        if alpha is not None:
            if mh.pymat.alpha_mode == "MASK":
                cutoff = 0.5 if mh.pymat.alpha_cutoff is None else mh.pymat.alpha_cutoff
                # 1 where alpha >= cutoff
                alpha = t.math("SUBTRACT", 1.0, t.math("LESS_THAN", alpha, cutoff))
            n = t.node("ShaderNodeMixShader")
            t.put(n.inputs[0], alpha)
            t.put(n.inputs[1], t.node("ShaderNodeBsdfTransparent").outputs[0])
            t.put(n.inputs[2], shader)
            shader = n.outputs[0]
        out = t.node("ShaderNodeOutputMaterial")
        t.put(out.inputs["Surface"], shader)

    def base(self, mh, t, diffuse=False):
        color_in, color = t.color_input()
        alpha_in, alpha = t.float_input() if not mh.is_opaque() else (None, None)
        self.helpers.base_color(mh, (0, 0), color_in, alpha_in, is_diffuse=diffuse)
        return color, alpha

    def bsdf(self, mh, t, base, metallic, f0, f90, roughness, alpha):
        """pbnds' material (engine/shade/bsdf.h) as near as nodes come. base, f0 and f90 (of
        the part that is no metal) are colours. A node's colour cannot depend on the light's
        direction, so what does is replaced by its mean over light from everywhere: the
        albedo at every view is pbnds', the lobes' shapes are nearly so.

        Diffuse: (1 - metallic) base (1 - E(wo)), E the specular albedo of the non-metal.
        Specular: Principled as a metal, whose Fresnel term is one of wo.h, scaled to stay
        below pbnds' albedo, and a plain GGX for the rest."""
        normal = self.normal(mh, t)
        cos_o = self.cos_of_bent(t, normal)
        first, second, plain = self.look_up(t, self.ours, cos_o, roughness)
        their_first, their_second, _ = self.look_up(t, self.theirs, cos_o, roughness)
        narrowest = t.math("MAXIMUM", roughness, math.sqrt(ALPHA_MIN))

        r, g, b = t.split(t.mul(f0, 1.0))
        most = t.math("MAXIMUM", r, t.math("MAXIMUM", g, b))
        kept = t.math("SUBTRACT", 1.0, t.math("ADD", t.math("MULTIPLY", most, first),
                                              t.math("MULTIPLY", t.split(f90)[0], second)))
        diffuse = t.node("ShaderNodeBsdfDiffuse")
        t.put(diffuse.inputs["Color"], t.mul(t.mul(base, t.math("SUBTRACT", 1.0, metallic)),
                                             kept))
        t.put(diffuse.inputs["Normal"], normal)

        f0 = t.lerp(f0, base, metallic)
        f90 = t.lerp(f90, (1.0, 1.0, 1.0), metallic)
        wanted = t.add(t.mul(f0, first), t.mul(f90, second))
        given = t.add(t.mul(f0, their_first), t.mul(f90, their_second))
        r, g, b = t.split(t.vector("DIVIDE", wanted, t.vector("MAXIMUM", given, (1e-6,) * 3)))
        scale = t.math("MINIMUM", 1.0, t.math("MINIMUM", r, t.math("MINIMUM", g, b)))
        strength = t.split(f90)[0]
        principled = t.node("ShaderNodeBsdfPrincipled", distribution="GGX")
        t.put(principled.inputs["Base Color"],
              t.vector("DIVIDE", f0, t.vector("MAXIMUM", f90, (1e-6,) * 3)))
        principled.inputs["Metallic"].default_value = 1.0
        principled.inputs["Specular"].default_value = \
            (1.0 - 2.0 / (PRINCIPLED_IOR + 1.0)) ** 2 / 0.08
        t.put(principled.inputs["Roughness"], narrowest)
        t.put(principled.inputs["Normal"], normal)
        part = t.node("ShaderNodeMixShader")
        t.put(part.inputs[0], t.math("MULTIPLY", scale, strength))
        t.put(part.inputs[2], principled.outputs[0])

        rest = t.vector("SUBTRACT", wanted, t.mul(given, scale))
        glossy = t.node("ShaderNodeBsdfGlossy", distribution="GGX")
        t.put(glossy.inputs["Color"],
              t.mul(t.vector("MAXIMUM", rest, (0.0, 0.0, 0.0)),
                    t.math("DIVIDE", 1.0, t.math("MAXIMUM", plain, 1e-6))))
        t.put(glossy.inputs["Roughness"], narrowest)
        t.put(glossy.inputs["Normal"], normal)

        shader = t.add_shaders(diffuse.outputs[0],
                               t.add_shaders(part.outputs[0], glossy.outputs[0]))
        emission = self.emission(mh, t)
        if emission:
            shader = t.add_shaders(shader, emission)
        self.finish(mh, t, shader, alpha)

    def metallic_roughness(self, mh):
        t = Tree(mh.node_tree)
        color, alpha = self.base(mh, t)
        metallic_in, metallic = t.float_input()
        roughness_in, roughness = t.float_input()
        self.helpers.metallic_roughness(mh, (0, 0), metallic_in, roughness_in)
        extensions = mh.pymat.extensions or {}
        ior = (extensions.get("KHR_materials_ior") or {}).get("ior", 1.5)
        ior_f0 = ((ior - 1.0) / (ior + 1.0)) ** 2 if ior > 0.0 else 1.0
        specular = extensions.get("KHR_materials_specular") or {}
        # f0 = specular min(ior_f0 specular_color, 1), f90 = specular
        strength = specular.get("specularFactor", 1.0)
        tint = specular.get("specularColorFactor", (1.0, 1.0, 1.0))
        if "specularColorTexture" in specular:
            tint = t.mul(self.read_texture(mh, t, specular["specularColorTexture"], False)[0],
                         tint)
        if "specularTexture" in specular:
            strength = t.math(
                "MULTIPLY", self.read_texture(mh, t, specular["specularTexture"], True)[1],
                strength)
        f0 = t.vector("MINIMUM", t.mul(tint, (ior_f0,) * 3), (1.0, 1.0, 1.0))
        self.bsdf(mh, t, color, metallic, t.mul(f0, strength),
                  t.mul((1.0, 1.0, 1.0), strength), roughness, alpha)

    def specular_glossiness(self, mh):
        t = Tree(mh.node_tree)
        extension = mh.pymat.extensions["KHR_materials_pbrSpecularGlossiness"]
        color, alpha = self.base(mh, t, diffuse=True)
        f0 = tuple(extension.get("specularFactor", (1.0, 1.0, 1.0)))
        gloss = extension.get("glossinessFactor", 1.0)
        if "specularGlossinessTexture" in extension:
            rgb, a = self.read_texture(mh, t, extension["specularGlossinessTexture"], False)
            f0, gloss = t.mul(rgb, f0), t.math("MULTIPLY", a, gloss)
        r, g, b = t.split(t.mul(f0, 1.0))
        most = t.math("MAXIMUM", r, t.math("MAXIMUM", g, b))
        c_diff = t.mul(color, t.math("SUBTRACT", 1.0, most))
        self.bsdf(mh, t, c_diff, 0.0, f0, t.mul((1.0, 1.0, 1.0), 1.0),
                  t.math("SUBTRACT", 1.0, gloss), alpha)

    def unlit(self, mh):
        t = Tree(mh.node_tree)
        color, alpha = self.base(mh, t)
        n = t.node("ShaderNodeEmission")
        t.put(n.inputs["Color"], color)
        self.finish(mh, t, n.outputs[0], alpha)


def linear_image(image):
    image.alpha_mode = "CHANNEL_PACKED"
    rgba = numpy.empty(image.size[0] * image.size[1] * 4, numpy.float32)
    image.pixels.foreach_get(rgba)
    rgba = rgba.reshape(image.size[1], image.size[0], 4)
    c = rgba[..., :3]
    decoded = numpy.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    return float_image(image.name + ".linear", decoded, rgba[..., 3])


def linearise_images():
    """sRGB textures are turned to linear floats texel by texel, as glTF wants them filtered:
    Cycles would filter the codes and decode afterwards."""
    linear, data = {}, {}
    for material in bpy.data.materials:
        for node in material.node_tree.nodes if material.node_tree else ():
            image = getattr(node, "image", None)
            if node.type != "TEX_IMAGE" or not image or image.is_float:
                continue
            kept = data if node["is_data"] else linear
            if image.name not in kept:
                if not node["is_data"]:
                    kept[image.name] = linear_image(image)
                else:
                    kept[image.name] = image.copy()
                    kept[image.name].colorspace_settings.is_data = True
                    kept[image.name].alpha_mode = "CHANNEL_PACKED"
            node.image = kept[image.name]


# ------------------------------------------------------------------ scene

def read_gltf(path):
    """The JSON of a .gltf or .glb, and the binary chunk of the latter."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:4] != b"glTF":
        return json.loads(data), b""
    size = int.from_bytes(data[12:16], "little")
    return json.loads(data[20:20 + size]), data[28 + size:]


def read_uri(folder, uri):
    if uri.startswith("data:"):
        return base64.b64decode(uri.split(",", 1)[1])
    with open(os.path.join(folder, urllib.parse.unquote(uri)), "rb") as file:
        return file.read()


def pack_gltf(path):
    """(JSON, binary) of the same scene with every buffer and image in one binary."""
    document, chunk = read_gltf(path)
    folder = os.path.dirname(os.path.abspath(path))
    blob, starts = bytearray(), []
    for buffer in document.get("buffers", []):
        starts.append(len(blob))
        blob += read_uri(folder, buffer["uri"]) if "uri" in buffer else chunk
        blob += b"\0" * (-len(blob) % 4)
    views = document.setdefault("bufferViews", [])
    for view in views:
        view["byteOffset"] = view.get("byteOffset", 0) + starts[view["buffer"]]
        view["buffer"] = 0
    for image in document.get("images", []):
        if "uri" in image:
            data = read_uri(folder, image.pop("uri"))
            image["mimeType"] = "image/png" if data[:4] == b"\x89PNG" else "image/jpeg"
            image["bufferView"] = len(views)
            views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data)})
            blob += data + b"\0" * (-len(data) % 4)
    document["buffers"] = [{"byteLength": len(blob)}]
    return document, bytes(blob)


def vary(options):
    """The scene with other materials. flat: without normal maps. lambert: and nothing but
    the diffuse part. metal: and nothing but the specular part, of a metal."""
    document, blob = pack_gltf(options.scene)
    for material in document.setdefault("materials", []):
        material.pop("normalTexture", None)
        if options.kind == "flat":
            continue
        pbr = material.setdefault("pbrMetallicRoughness", {})
        extensions = {k: v for k, v in material.get("extensions", {}).items()
                      if k in ("KHR_materials_unlit", "KHR_materials_emissive_strength")}
        if options.kind == "lambert":
            pbr.pop("metallicRoughnessTexture", None)
            pbr["metallicFactor"], pbr["roughnessFactor"] = 0.0, 1.0
            extensions["KHR_materials_specular"] = {"specularFactor": 0.0}
        else:
            pbr.pop("metallicRoughnessTexture", None)
            pbr["metallicFactor"] = 1.0
            pbr["roughnessFactor"] = max(pbr.get("roughnessFactor", 1.0), 0.4)
        material["extensions"] = extensions
    used = set(document.get("extensionsUsed", [])) | {"KHR_materials_specular"}
    document["extensionsUsed"] = sorted(used)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(options.output, "wb") as file:
        for part in (b"glTF", (2).to_bytes(4, "little"),
                     (28 + len(text) + len(blob)).to_bytes(4, "little"),
                     len(text).to_bytes(4, "little"), b"JSON", text,
                     len(blob).to_bytes(4, "little"), b"BIN\0", blob):
            file.write(part)


def punctual_lights(path):
    """KHR_lights_punctual by its own formulas: the importer knows no range, and its spot
    fades by another law. Intensities as radiometric ones (the importer in mode COMPAT)."""
    document, _ = read_gltf(path)
    lights = document.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    by_name = {light.get("name"): light for light in lights}
    for thing in [o for o in bpy.data.objects if o.type == "LIGHT"]:
        light = thing.data
        source = by_name.get(light.name, by_name.get(light.name.rsplit(".", 1)[0]))
        if source is None and len(lights) == 1:
            source = lights[0]
        if source is None:
            sys.exit("judge: lights of one name cannot be told apart; name them")
        color = numpy.array(source.get("color", (1.0, 1.0, 1.0)))
        intensity = source.get("intensity", 1.0)
        light.use_nodes = True
        t = Tree(light.node_tree)
        light.node_tree.nodes.clear()
        emission = t.node("ShaderNodeEmission")
        t.put(emission.inputs["Color"], tuple(color))
        light.color = (1.0, 1.0, 1.0)
        light.use_shadow = True
        factor = 1.0
        if source["type"] == "directional":
            light.energy, light.angle = intensity, 0.0
        else:
            spot = source.get("spot", {})
            light.type = "POINT"
            light.energy, light.shadow_soft_size = intensity * 4.0 * math.pi, 0.0
            path_node = t.node("ShaderNodeLightPath")
            if source.get("range"):
                ratio = t.math("DIVIDE", path_node.outputs["Ray Length"], source["range"])
                window = t.math("SUBTRACT", 1.0, t.math("POWER", ratio, 4.0))
                factor = t.math("MINIMUM", t.math("MAXIMUM", window, 0.0), 1.0)
            if source["type"] == "spot":
                outer = math.cos(spot.get("outerConeAngle", math.pi / 4))
                inner = math.cos(spot.get("innerConeAngle", 0.0))
                axis = thing.matrix_world.to_3x3().normalized() @ Vector((0.0, 0.0, -1.0))
                # from the light to what it lights: against the ray that found the light
                way = t.node("ShaderNodeNewGeometry").outputs["Incoming"]
                cos = t.vector("DOT_PRODUCT", way, tuple(axis))
                scale = 1.0 / max(0.001, inner - outer)
                ramp = t.math("MULTIPLY", t.math("SUBTRACT", cos, outer), scale)
                ramp = t.math("MINIMUM", t.math("MAXIMUM", ramp, 0.0), 1.0)
                factor = t.math("MULTIPLY", t.math("MULTIPLY", ramp, ramp), factor)
        t.put(emission.inputs["Strength"], factor)
        out = t.node("ShaderNodeOutputLight")
        t.put(out.inputs[0], emission.outputs[0])


def import_scene(options):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    materials = None if options.principled else Materials(options)
    if materials:
        materials.install()
    bpy.ops.import_scene.gltf(filepath=os.path.abspath(options.scene), merge_vertices=False,
                              import_shading="NORMALS", convert_lighting_mode="COMPAT",
                              guess_original_bind_pose=False)
    if materials:
        materials.of_meshes_without()
        linearise_images()
    if options.no_scene_lights:
        for thing in [o for o in bpy.data.objects if o.type == "LIGHT"]:
            bpy.data.objects.remove(thing)
    else:
        punctual_lights(options.scene)
    pose(options.time)
    for thing in bpy.data.objects:
        if thing.type == "MESH":
            # Workarounds for faceted meshes that move shadow rays and weigh light.
            thing.cycles.shadow_terminator_offset = 0.0
            thing.cycles.shadow_terminator_geometry_offset = 0.0


def pose(time):
    """The animation at that time; without one, as the nodes stand."""
    scene = bpy.context.scene
    if time is None:
        for things in (bpy.data.objects, bpy.data.shape_keys):
            for thing in things:
                thing.animation_data_clear()
    else:
        frame = time * scene.render.fps / scene.render.fps_base
        scene.frame_set(math.floor(frame), subframe=frame % 1.0)


def set_camera(facts):
    camera = bpy.data.cameras.new("judge")
    thing = bpy.data.objects.new("judge", camera)
    bpy.context.scene.collection.objects.link(thing)
    m = facts["pbnds:worldFromCamera"]  # column-major
    thing.matrix_world = Z_UP @ Matrix([[m[4 * c + r] for c in range(4)] for r in range(4)])
    camera.sensor_fit, camera.sensor_height = "VERTICAL", 24.0
    camera.clip_start, camera.clip_end = 1e-5, 1e7
    if facts["pbnds:projection"] == "orthographic":
        camera.type, camera.ortho_scale = "ORTHO", 2.0 * facts["pbnds:ymag"]
    else:
        camera.lens = 12.0 / math.tan(0.5 * facts["pbnds:yfov"])
    bpy.context.scene.camera = thing


def set_world(facts, env):
    world = bpy.data.worlds.new("judge")
    bpy.context.scene.world = world
    world.use_nodes = True
    world.node_tree.nodes.clear()
    t = Tree(world.node_tree)
    background = t.node("ShaderNodeBackground")
    if env:
        image = bpy.data.images.load(os.path.abspath(env))
        rgba = numpy.empty(image.size[0] * image.size[1] * 4, numpy.float32)
        image.pixels.foreach_get(rgba)
        # pbnds' rule: what is no radiance counts as none
        rgb = numpy.nan_to_num(rgba.reshape(image.size[1], image.size[0], 4)[..., :3])
        clean = float_image("light", numpy.maximum(rgb, 0.0))
        yaw = facts["pbnds:envYaw"] + 360.0 * ROLL[facts["pbnds:envConvention"] or "gltf"]
        turn = t.node("ShaderNodeMapping", vector_type="POINT")
        turn.inputs["Rotation"].default_value[2] = -math.radians(yaw)
        t.put(turn.inputs["Vector"],
              t.node("ShaderNodeTexCoord").outputs["Generated"])
        look = t.node("ShaderNodeTexEnvironment", image=clean, projection="EQUIRECTANGULAR",
                      interpolation="Closest")
        t.put(look.inputs[0], turn.outputs[0])
        t.put(background.inputs["Color"], look.outputs["Color"])
        background.inputs["Strength"].default_value = facts["pbnds:envStrength"]
        world.cycles.sampling_method = "MANUAL"
        world.cycles.sample_map_resolution = max(image.size[0], 1024)
    else:
        t.put(background.inputs["Color"], (0.0, 0.0, 0.0))
    world.cycles.max_bounces = 1024
    out = t.node("ShaderNodeOutputWorld")
    t.put(out.inputs["Surface"], background.outputs[0])


def set_render(options, size):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = int(size[0]), int(size[1])
    scene.render.resolution_percentage = 100
    scene.render.threads_mode, scene.render.threads = "FIXED", options.threads
    scene.render.film_transparent = False
    scene.render.use_compositing = scene.render.use_sequencer = False
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.exr_codec = "ZIP"
    c = scene.cycles
    c.device, c.feature_set = "CPU", "SUPPORTED"
    c.samples, c.seed, c.use_adaptive_sampling = options.spp, options.seed, False
    c.use_denoising = False
    # Every ray through the centre of its pixel. Not BOX: its width is 1 whatever is set.
    c.pixel_filter_type, c.filter_width = "BLACKMAN_HARRIS", 0.01
    for name in ("max", "diffuse", "glossy", "transmission", "volume"):
        setattr(c, name + "_bounces", options.bounces)
    c.transparent_max_bounces = 1024
    c.sample_clamp_direct = c.sample_clamp_indirect = 0.0
    c.caustics_reflective = c.caustics_refractive = True
    c.blur_glossy, c.light_sampling_threshold = 0.0, 0.0
    c.min_light_bounces = c.min_transparent_bounces = 0
    c.use_fast_gi = False
    c.auto_scrambling_distance, c.scrambling_distance = False, 1.0
    scene.render.use_persistent_data = False


def render(options):
    with open(options.facts) as file:
        facts = json.load(file)
    import_scene(options)
    set_camera(facts["attributes"])
    set_world(facts["attributes"], options.env)
    set_render(options, facts["size"])
    bpy.context.scene.render.filepath = os.path.abspath(options.output)
    bpy.ops.render.render(write_still=True)


# ------------------------------------------------------------------ score

def read_picture(path):
    """Linear RGB, row 0 on top."""
    image = bpy.data.images.load(os.path.abspath(path))
    image.colorspace_settings.is_data = True
    rgba = numpy.empty(image.size[0] * image.size[1] * 4, numpy.float32)
    image.pixels.foreach_get(rgba)
    return rgba.reshape(image.size[1], image.size[0], 4)[::-1, :, :3].astype(numpy.float64)


def pbr_neutral(c):
    """Khronos PBR Neutral Tone Mapper, 2024, https://github.com/KhronosGroup/ToneMapping"""
    start, desaturation = 0.8 - 0.04, 0.15
    low = c.min(axis=2, keepdims=True)
    c = c - numpy.where(low < 0.08, low - 6.25 * low * low, 0.04)
    peak = c.max(axis=2, keepdims=True)
    d = 1.0 - start
    new_peak = 1.0 - d * d / numpy.maximum(peak + d - start, 1e-9)
    g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0)
    squeezed = c * new_peak / numpy.maximum(peak, 1e-9)
    squeezed = squeezed * (1.0 - g) + new_peak * g
    return numpy.where(peak < start, c, squeezed)


def displayed(linear, exposure):
    c = numpy.clip(pbr_neutral(numpy.maximum(linear, 0.0) * 2.0**exposure), 0.0, 1.0)
    return numpy.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1.0 / 2.4) - 0.055)


def psnr(a, b, where):
    mse = ((a - b)[where] ** 2).mean()
    return -10.0 * math.log10(mse) if mse > 0.0 else math.inf


def save_png(path, pixels):
    height, width = pixels.shape[:2]
    image = bpy.data.images.new("sheet", width, height)
    rgba = numpy.ones((height, width, 4), numpy.float32)
    rgba[..., :3] = pixels[::-1]
    image.pixels.foreach_set(rgba.ravel())
    image.filepath_raw, image.file_format = os.path.abspath(path), "PNG"
    image.save()


def score(options):
    first, second, mask, cycles = (read_picture(p) for p in options.pictures)
    ours = 0.5 * (first + second)
    where = mask[..., 0] > 0.0
    if not where.any():
        sys.exit("judge: %s: nothing is covered" % options.name)
    luminance = ours[where] @ (0.2126, 0.7152, 0.0722)
    exposure = math.log2(0.25 / max(luminance.mean(), 1e-9))
    a, b = displayed(ours, exposure), displayed(cycles, exposure)
    row = {
        "scene": options.name,
        "psnr": psnr(a, b, where),
        "floor": psnr(displayed(first, exposure), displayed(second, exposure), where),
        "psnr_all": psnr(a, b, numpy.ones_like(where)),
        "relmse": ((ours - cycles)[where] ** 2 / (ours[where] ** 2 + 1e-2 * luminance.mean() ** 2)).mean(),
        "ratio": ours[where].mean() / cycles[where].mean(),
        "exposure": exposure,
    }
    save_png(options.sheet,
             numpy.concatenate((a, b, numpy.clip(0.5 + 8.0 * (a - b), 0.0, 1.0)), 1))
    with open(options.json, "w") as file:
        json.dump(row, file)


def main():
    arguments = sys.argv[sys.argv.index("--") + 1:]
    parser = argparse.ArgumentParser(prog="cycles_render.py")
    commands = parser.add_subparsers(dest="command", required=True)
    r = commands.add_parser("render")
    r.add_argument("scene")
    r.add_argument("facts")
    r.add_argument("output")
    r.add_argument("--env", default="")
    r.add_argument("--spp", type=int, default=256)
    r.add_argument("--seed", type=int, default=0)
    r.add_argument("--bounces", type=int, default=8)
    r.add_argument("--threads", type=int, default=1)
    r.add_argument("--time", type=float)
    r.add_argument("--principled", action="store_true")
    r.add_argument("--no-scene-lights", action="store_true")
    s = commands.add_parser("score")
    s.add_argument("name")
    s.add_argument("pictures", nargs=4)
    s.add_argument("--sheet", required=True)
    s.add_argument("--json", required=True)
    v = commands.add_parser("vary")
    v.add_argument("scene")
    v.add_argument("output")
    v.add_argument("kind", choices=("flat", "lambert", "metal"))
    options = parser.parse_args(arguments)
    {"render": render, "score": score, "vary": vary}[options.command](options)


if __name__ == "__main__":
    main()
