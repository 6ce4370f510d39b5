"""Tangents by the reference implementation of MikkTSpace, as Blender carries it.

    blender -b --factory-startup -P tests/reference/tangents_blender.py -- tangents_blender.h
    blender -b --factory-startup -P tests/reference/tangents_blender.py -- OUT.txt MODEL.glb

The first form made the header beside this file (Blender 3.4.1): a bent sheet whose picture is
mirrored along x = 0, with a triangle that has no area in the picture. The second writes every
corner of a model, a line each: position, normal, u, v of glTF (down), tangent, sign, material;
mesh after mesh.

Blender's v runs up, glTF's down; tangents do not depend on it, and its sign is glTF's w.
"""
import sys

import numpy

# Blender 3.4's glTF importer uses names that numpy 1.24 has dropped.
for alias, kind in (("bool", bool), ("int", int), ("float", float), ("object", object)):
    if alias not in numpy.__dict__:
        setattr(numpy, alias, kind)

import bpy  # noqa: E402

COLUMNS, ROWS = 5, 3


def sheet():
    positions, uvs, faces = [], [], []
    for r in range(ROWS):
        for c in range(COLUMNS):
            x, y = c / 2 - 1, r / 2
            positions.append((x, y, 0.3 * x * x - 0.2 * y * y + 0.1 * x * y))
            uvs.append((abs(x) ** 1.3, y + 0.1 * x * x))
    for r in range(ROWS - 1):
        for c in range(COLUMNS - 1):
            a = r * COLUMNS + c
            b, d = a + 1, a + COLUMNS
            faces += [(a, b, d + 1), (a, d + 1, d)] if (r + c) % 2 else [(a, b, d), (b, d + 1, d)]
    positions.append((1.4, 0.1, 0.2))  # hangs on the right edge, its picture is a line
    uvs.append(uvs[COLUMNS - 1])
    faces.append((COLUMNS - 1, len(positions) - 1, 2 * COLUMNS - 1))
    mesh = bpy.data.meshes.new("sheet")
    mesh.from_pydata(positions, [], faces)
    layer = mesh.uv_layers.new(name="uv")
    for loop in mesh.loops:
        layer.data[loop.index].uv = uvs[loop.vertex_index]
    for face in mesh.polygons:
        face.use_smooth = True
    return mesh


def corners(mesh):
    mesh.calc_tangents()
    uv = mesh.uv_layers.active.data
    for loop in mesh.loops:
        u, v = uv[loop.index].uv
        yield (loop, mesh.vertices[loop.vertex_index].co, loop.normal, (u, 1.0 - v),
               loop.tangent, loop.bitangent_sign)


def row(values):
    return "{" + ", ".join("%.9gf" % v if "." in "%.9g" % v or "e" in "%.9g" % v else "%.9g" % v
                           for v in values) + "}"


def write_header(path):
    mesh = sheet()
    loops = list(corners(mesh))
    first = {}
    for loop in loops:
        first.setdefault(loop[0].vertex_index, loop)
    vertices = [first[i] for i in range(len(mesh.vertices))]
    with open(path, "w") as out:
        out.write("/* Made by tangents_blender.py with Blender %s; not edited by hand. */\n"
                  % bpy.app.version_string)
        out.write("#ifndef PBNDS_TESTS_TANGENTS_BLENDER_H\n#define PBNDS_TESTS_TANGENTS_BLENDER_H\n\n")
        out.write("#include <stdint.h>\n\n")
        out.write("enum { SHEET_VERTICES = %d, SHEET_CORNERS = %d };\n\n" % (len(vertices), len(loops)))
        for name, width, k in (("position", 3, 1), ("normal", 3, 2), ("uv", 2, 3)):
            out.write("static const float sheet_%s[SHEET_VERTICES][%d] = {\n" % (name, width))
            out.writelines("    %s,\n" % row(v[k]) for v in vertices)
            out.write("};\n")
        out.write("static const uint32_t sheet_index[SHEET_CORNERS] = {\n    ")
        out.write(", ".join(str(l[0].vertex_index) for l in loops) + "};\n")
        out.write("/* xyz, w of each corner */\nstatic const float sheet_tangent[SHEET_CORNERS][4] = {\n")
        out.writelines("    %s,\n" % row((*l[4], l[5])) for l in loops)
        out.write("};\n\n#endif /* PBNDS_TESTS_TANGENTS_BLENDER_H */\n")


def write_text(path, model):
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=model)
    with open(path, "w") as out:
        for mesh in bpy.data.meshes:
            if not mesh.uv_layers:
                continue
            out.write("mesh %d\n" % len(mesh.loops))
            for loop, p, n, uv, t, sign in corners(mesh):
                out.write(" ".join("%.9g" % v for v in (*p, *n, *uv, *t, sign)) + "\n")


arguments = sys.argv[sys.argv.index("--") + 1:]
if len(arguments) == 1:
    write_header(arguments[0])
else:
    write_text(*arguments)
