"""Draws a scene that `typodont render --geometry` exported with Blender's path tracer (Cycles).

blender -b --python-exit-code 1 -P draw.py -- FOLDER [SAMPLES]

FOLDER contains frame.json and geometry.ply. The result is FOLDER/light.npz, from which develop.py makes the picture. It
has the camera of the left eye, and the lamp and the room of the export.
"""

import json
import os
import sys

import bpy
import numpy as np
from mathutils import Matrix, Vector

HERE = os.path.dirname(os.path.abspath(__file__))
TOOL = 255


def load_geometry(file):
    """Vertices as a structured array, triangles as an (n, 3) array, the tissues' names, and the origins of the bodies'
    own frames (mm)."""
    with open(file, "rb") as f:
        names, origins, counts, fields, element = {}, {}, {}, [], None
        kinds = {"float": "<f4", "uchar": "u1"}
        while (line := f.readline().decode().split()) != ["end_header"]:
            if line[:2] == ["comment", "tissue"]:
                names[int(line[2])] = line[3]
            elif line[:2] == ["comment", "origin"]:
                origins[int(line[2])] = np.array(line[3:], float)
            elif line[0] == "element":
                element = line[1]
                counts[element] = int(line[2])
            elif line[0] == "property" and element == "vertex":
                fields.append((line[2], kinds[line[1]]))
        vertices = np.frombuffer(f.read(counts["vertex"] * np.dtype(fields).itemsize), np.dtype(fields))
        face = np.dtype([("n", "u1"), ("i", "<u4", 3)])
        triangles = np.frombuffer(f.read(counts["face"] * face.itemsize), face)["i"]
    return vertices, triangles, names, origins


def noise(p):
    """noise() of shaders/tooth.glsl: a smooth function of the position with random values 0..1 at integer positions.
    `p`: (n, 3)."""

    def hashed(p):
        p = p * np.float32([0.1031, 0.1030, 0.0973])
        p -= np.floor(p)
        p += (p * (p[:, [1, 0, 2]] + np.float32(33.33))).sum(1, keepdims=True)
        value = (p[:, 0] + p[:, 1]) * p[:, 2]
        return value - np.floor(value)

    p = p.astype(np.float32)
    first = np.floor(p)
    f = p - first
    f = f * f * (3 - 2 * f)
    total = np.zeros(len(p), np.float32)
    for corner in np.ndindex(2, 2, 2):
        weight = np.where(corner, f, 1 - f).prod(1)
        total += weight * hashed(first + np.float32(corner))
    return total


# The colour textures of shaders/gum.glsl and shaders/tooth.glsl that are coarse enough for the vertices of the mesh:
# frequency of the noise (1/m), and the factors of the colour where the noise is 0 and 1.
TEXTURES = {
    "enamel": (900, (0.97, 0.97, 0.97), (1.03, 1.03, 1.03)),
    "gingiva": (420, (0.93, 0.83, 0.86), (1.07, 1.17, 1.14)),
    "mucosa": (260, (0.93, 0.84, 0.84), (1.05, 1.06, 1.05)),
    "skin": (500, (0.96, 0.96, 0.96), (1.04, 1.04, 1.04)),
}


# The random walks of Cycles 3.4 reflect slightly more than the stated colour: the colours of thick flat plates in
# uniform light, and their reflectance divided by their colour (mean of 300,000 paths each).
PLATES = ((0.05, 0.12, 0.22, 0.40, 0.55, 0.70, 0.85, 0.95), (1.011, 1.008, 1.012, 1.010, 1.008, 1.008, 1.006, 0.958))


def textured(color, tissue, names, position, cut):
    """The reflectance of the vertices with the program's texture. `position`: mm, frame of the body. A cut surface has no
    such texture."""
    color = color.copy()
    for number, name in names.items():
        mine = tissue == number
        if name in TEXTURES and mine.any():
            frequency, low, high = TEXTURES[name]
            share = noise(position[mine] * 1e-3 * frequency)[:, None]
            factor = (1 - share) * low + share * high
            color[mine] *= factor + (1 - factor) * cut[mine, None]
    return color


def linear(srgb):
    c = np.asarray(srgb, float)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


class Tissues:
    """Reflectance, mean free path and gloss of each vertex, from the values in tissues.json."""

    def __init__(self, values, colors, names):
        self.values, self.colors, self.names = values, colors, names

    def drawn(self, name, shown):
        """Reflectance of a tissue without published absorption. A lower tissue that shines through changes it by the
        same factor as the program's colour."""
        return self.infinite(name) * shown / np.maximum(linear(self.colors[name]), 1e-6)

    def infinite(self, name):
        """Diffuse reflectance of a thick layer: Kubelka-Munk with K = 2 absorption, S = 3/4 scattering - 1/4
        absorption, or the reflectance itself where it was measured."""
        t = self.values[name]
        if "reflectance" in t:
            return linear(self.colors[name]) if t["reflectance"] == "scene" else np.array(t["reflectance"])
        s, k = self.coefficients(name)
        a = 1 + k / s
        return a - np.sqrt(a * a - 1)

    def coefficients(self, name):
        t = self.values[name]
        scattering, absorption = (np.array(t[key]) for key in ("reduced_scattering_per_mm", "absorption_per_mm"))
        return 0.75 * scattering - 0.25 * absorption, 2 * absorption

    def layer(self, name, depth, below):
        """Reflectance of a layer of this depth (mm) over tissue with the reflectance `below`."""
        if "absorption_per_mm" not in self.values[name]:
            return self.infinite(name)
        s, k = self.coefficients(name)
        a = 1 + k / s
        b = np.sqrt(a * a - 1)
        c = b / np.tanh(b * s * depth[:, None])
        return (1 - below * (a - c)) / (a - below + c)

    def free_path(self, name):
        t = self.values[name]
        return 1 / (np.array(t["reduced_scattering_per_mm"]) + np.array(t.get("absorption_per_mm", [0.3] * 3)))

    def of(self, tissue, first, under, depth, shown, cut):
        """Arrays over the vertices: reflectance, mean free path (mm), roughness, reflectance of the film at normal
        incidence, metal. `shown`: the program's linear colour for the vertices' `first` tissue. `cut`: 0..1, whether a
        cut made the surface."""
        n = len(tissue)
        color, path = np.zeros((n, 3)), np.ones((n, 3))
        rough, mirror, metal = np.full(n, 0.5), np.full(n, 0.04), np.zeros(n)
        film = self.values["film"]
        for number, name in self.names.items():
            mine = tissue == number
            if name not in self.values or not mine.any():
                continue
            t = self.values[name]
            color[mine] = self.infinite(name)
            if "absorption_per_mm" not in t and not t.get("metal"):
                layered = mine & (under > 0) & (tissue == first)
                color[layered] = self.drawn(name, shown[layered])
            if not t.get("metal"):
                path[mine] = self.free_path(name)
                of_cut = {"roughness": t["roughness"], "wet": t["wet"]} | t.get("cut", {})
                wet, roughness = (t[key] + cut[mine] * (of_cut[key] - t[key]) for key in ("wet", "roughness"))
                water, index = film["refractive_index"], t["refractive_index"]
                outer, inner = ((water - 1) / (water + 1)) ** 2, ((index - water) / (index + water)) ** 2
                dry = ((index - 1) / (index + 1)) ** 2
                mirror[mine] = (1 - wet) * dry + wet * (outer + (1 - outer) ** 2 * inner)
                rough[mine] = (1 - wet) * roughness + wet * np.minimum(roughness, film["roughness"])
            else:
                metal[mine], rough[mine] = 1, t["roughness"]
            # A tissue that light passes: what lies below it shines through.
            below = np.where(under > 0, under, 0)
            thick = depth.astype(float).copy()
            if "thickness_mm" in t:
                usual = mine & (under == 0)
                below = np.where(usual, self.number("dentin"), below)
                thick[usual] = t["thickness_mm"]
            for lower, lower_name in self.names.items():
                both = mine & (below == lower)
                if lower_name not in self.values or lower == number or not both.any():
                    continue
                if t.get("metal") or "absorption_per_mm" not in t:
                    continue
                d = np.maximum(thick[both], 0.02)
                color[both] = self.layer(name, d, self.infinite(lower_name))
                # Light crosses the layer and is scattered in the tissue below.
                path[both] = np.minimum(self.free_path(lower_name) + 0.5 * d[:, None], self.free_path(name))
        return color, path, rough, mirror, metal

    def number(self, name):
        return next(n for n, known in self.names.items() if known == name)


def unfolded(points, normals, triangles):
    """Removes folded triangles, whose front side faces into the body. A light path that meets a folded triangle would
    start on the wrong side of the surface, which causes a dark mark. First, edges of folded triangles are flipped. Then
    the vertices of triangles that are still folded move along the surface towards the middle of their neighbours.
    Returns the new points and triangles. A few folded triangles of a coarse mesh may remain."""
    points, triangles = points.astype(float), triangles.astype(np.int64)
    # Blocks of the mesh have their own vertices at their borders. Vertices at the same place count as one.
    places, place = np.unique(points, axis=0, return_inverse=True)
    straight = np.zeros_like(places)
    np.add.at(straight, place, normals)
    straight /= np.maximum(np.linalg.norm(straight, axis=1, keepdims=True), 1e-9)

    def folded(corners):
        p = places[place[corners]]
        n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
        return (n * normals[corners].sum(1)).sum(1) <= 0

    def edges_of(t):
        ends = place[triangles[t]]
        return [(ends[k], ends[(k + 1) % 3]) for k in range(3)]

    beside = {edge: t for t in range(len(triangles)) for edge in edges_of(t)}

    def flip(t):
        for k in range(3):
            a, b, c = np.roll(triangles[t], -k)
            other = beside.get((place[b], place[a]))
            if other is None:
                continue
            d = next(v for v in triangles[other] if place[v] not in (place[a], place[b]))
            new = np.array([[c, a, d], [d, b, c]])
            known = {(place[c], place[d]), (place[d], place[c])} & beside.keys()
            if known or folded(new).any():
                continue
            for edge in edges_of(t) + edges_of(other):
                beside.pop(edge, None)
            triangles[[t, other]] = new
            beside.update({edge: now for now in (t, other) for edge in edges_of(now)})
            return

    for _ in range(3):
        for _ in range(2):
            for t in np.flatnonzero(folded(triangles)):
                flip(t)
        corners = place[triangles]
        moving = np.unique(corners[folded(triangles)])
        total, count = np.zeros_like(places), np.zeros((len(places), 1))
        for i, j in ((0, 1), (1, 2), (2, 0)):
            for here, there in ((i, j), (j, i)):
                np.add.at(total, corners[:, here], places[corners[:, there]])
                np.add.at(count, corners[:, here], 1)
        step = total[moving] / count[moving] - places[moving]
        step -= straight[moving] * (step * straight[moving]).sum(1, keepdims=True)
        places[moving] += 0.5 * step
    return places[place], triangles


def add_body(name, vertices, triangles, origin, tissues, material):
    points, normals = (np.stack([vertices[c] for c in names], 1) for names in ("xyz", ("nx", "ny", "nz")))
    corners = points
    if tissues:
        points, triangles = unfolded(points, normals, triangles)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.ravel().astype(np.int32))
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(len(triangles), 3, np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(triangles), bool))
    mesh.update(calc_edges=True)
    mesh.use_auto_smooth = True
    mesh.normals_split_custom_set_from_vertices(normals.tolist())

    def attribute(name, kind, data):
        layer = mesh.attributes.new(name, kind, "POINT")
        layer.data.foreach_set("vector" if kind == "FLOAT_VECTOR" else "value", data.astype(np.float32).ravel())

    if tissues:
        attribute("share", "FLOAT", vertices["share"])
        shown = np.stack([vertices[c] for c in ("red", "green", "blue")], 1)
        for which, tissue in (("first", vertices["tissue"]), ("second", vertices["second"])):
            color, path, rough, mirror, metal = tissues.of(
                tissue, vertices["tissue"], vertices["under"], vertices["depth"], shown, vertices["cut"]
            )
            color = textured(color, tissue, tissues.names, corners - origin, vertices["cut"])
            color = np.where(metal[:, None] > 0, color, color / np.interp(color, *PLATES))
            attribute(which + "_color", "FLOAT_VECTOR", color)
            attribute(which + "_path", "FLOAT_VECTOR", path)
            attribute(which + "_gloss", "FLOAT_VECTOR", np.stack([rough, mirror, metal], 1))
    mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, mesh))


def tissue_material():
    """Random-walk subsurface scattering under a film that reflects by Fresnel's equations. The boundary between two
    tissues lies where the fraction of the second one passes one half."""
    material = bpy.data.materials.new("tissue")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()

    def node(kind, **settings):
        n = nodes.new(kind)
        for key, value in settings.items():
            setattr(n, key, value)
        return n

    share = node("ShaderNodeAttribute", attribute_name="share")
    second = node("ShaderNodeMath", operation="GREATER_THAN")
    second.inputs[1].default_value = 0.5
    links.new(share.outputs["Fac"], second.inputs[0])

    def chosen(what):
        mix = node("ShaderNodeMixRGB")
        links.new(second.outputs[0], mix.inputs["Fac"])
        for socket, which in (("Color1", "first_"), ("Color2", "second_")):
            source = node("ShaderNodeAttribute", attribute_name=which + what)
            links.new(source.outputs["Vector"], mix.inputs[socket])
        return mix.outputs[0]

    color, gloss = chosen("color"), node("ShaderNodeSeparateRGB")
    links.new(chosen("gloss"), gloss.inputs[0])
    inside = node("ShaderNodeSubsurfaceScattering", falloff="RANDOM_WALK_FIXED_RADIUS")
    # Cycles divides the scattering distance of this method by 4π, so that its pictures resemble those of older methods
    # (bssrdf_setup_radius in kernel/closure/bssrdf.h). This scale compensates for the division.
    inside.inputs["Scale"].default_value = 4 * np.pi
    links.new(color, inside.inputs["Color"])
    links.new(chosen("path"), inside.inputs["Radius"])
    film = node("ShaderNodeBsdfGlossy", distribution="GGX")
    film.inputs["Color"].default_value = (1, 1, 1, 1)  # Blender's default is 0.8
    links.new(gloss.outputs[0], film.inputs["Roughness"])
    # The index of refraction with this reflectance at normal incidence: n = (1 + sqrt F) / (1 - sqrt F).
    root = node("ShaderNodeMath", operation="SQRT")
    plus = node("ShaderNodeMath", operation="ADD")
    minus = node("ShaderNodeMath", operation="SUBTRACT")
    index = node("ShaderNodeMath", operation="DIVIDE")
    plus.inputs[0].default_value = minus.inputs[0].default_value = 1
    links.new(gloss.outputs[1], root.inputs[0])
    links.new(root.outputs[0], plus.inputs[1])
    links.new(root.outputs[0], minus.inputs[1])
    links.new(plus.outputs[0], index.inputs[0])
    links.new(minus.outputs[0], index.inputs[1])
    fresnel = node("ShaderNodeFresnel")
    links.new(index.outputs[0], fresnel.inputs["IOR"])
    wet = node("ShaderNodeMixShader")
    links.new(fresnel.outputs[0], wet.inputs["Fac"])
    links.new(inside.outputs[0], wet.inputs[1])
    links.new(film.outputs[0], wet.inputs[2])
    metal = node("ShaderNodeBsdfGlossy", distribution="GGX")
    links.new(color, metal.inputs["Color"])
    links.new(gloss.outputs[0], metal.inputs["Roughness"])
    whole = node("ShaderNodeMixShader")
    links.new(gloss.outputs[2], whole.inputs["Fac"])
    links.new(wet.outputs[0], whole.inputs[1])
    links.new(metal.outputs[0], whole.inputs[2])
    links.new(whole.outputs[0], node("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def metal_material(values):
    """Steel that was turned on a lathe: its grooves run around the upright tool and spread a reflection along it. The
    two GGX widths are those of brushed_metal() in shaders/metal.glsl."""
    material = bpy.data.materials.new("metal")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    width = values["roughness"] ** 2
    along, across = 0.4 * width, 5 * width
    metal = nodes.new("ShaderNodeBsdfAnisotropic")
    metal.distribution = "GGX"
    metal.inputs["Color"].default_value = (*values["reflectance"], 1)
    # Cycles computes the two widths as roughness² · (1 - anisotropy) and roughness² / (1 - anisotropy).
    metal.inputs["Roughness"].default_value = (along * across) ** 0.25
    metal.inputs["Anisotropy"].default_value = 1 - (along / across) ** 0.5
    groove = nodes.new("ShaderNodeTangent")
    groove.direction_type, groove.axis = "RADIAL", "Z"
    links.new(groove.outputs[0], metal.inputs["Tangent"])
    links.new(metal.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def add_light(light):
    """The lamp as a distant disc, and the room as light from all directions."""
    sun = bpy.data.lights.new("lamp", "SUN")
    sun.energy = light["lamp_strength"]
    sun.angle = 2 * light["lamp_half_angle"]
    sun.color = light["lamp_color"]
    lamp = bpy.data.objects.new("lamp", sun)
    lamp.rotation_mode = "QUATERNION"
    lamp.rotation_quaternion = Vector(light["toward_lamp"]).to_track_quat("Z", "Y")
    bpy.context.scene.collection.objects.link(lamp)

    world = bpy.data.worlds.new("room")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    background = nodes["Background"]
    direction = nodes.new("ShaderNodeTexCoord").outputs["Generated"]

    def along(axis, low, high):
        dot = nodes.new("ShaderNodeVectorMath")
        dot.operation = "DOT_PRODUCT"
        links.new(direction, dot.inputs[0])
        dot.inputs[1].default_value = axis
        ramp = nodes.new("ShaderNodeMapRange")
        ramp.interpolation_type = "SMOOTHSTEP"
        links.new(dot.outputs["Value"], ramp.inputs["Value"])
        ramp.inputs["From Min"].default_value, ramp.inputs["From Max"].default_value = low, high
        return ramp.outputs[0]

    def mixed(kind, factor, first, second):
        mix = nodes.new("ShaderNodeMixRGB")
        mix.blend_type = kind
        links.new(factor, mix.inputs["Fac"])
        for socket, value in (("Color1", first), ("Color2", second)):
            if isinstance(value, list):
                mix.inputs[socket].default_value = (*value, 1)
            else:
                links.new(value, mix.inputs[socket])
        return mix.outputs[0]

    room = light["room"]
    color = mixed("MIX", along(light["up"], -0.9, 0.9), room["floor"], room["ceiling"])
    color = mixed("ADD", along(light["window"], 0.45, 1.05), color, room["window"])
    links.new(color, background.inputs["Color"])
    background.inputs["Strength"].default_value = 1


def add_camera(eye, size):
    f = eye["frustum"]
    width, height = f["right"] - f["left"], f["top"] - f["bottom"]
    camera = bpy.data.cameras.new("eye")
    camera.sensor_fit = "HORIZONTAL"
    camera.sensor_width = 36
    camera.lens = 36 * f["near"] / width
    camera.shift_x = (f["left"] + f["right"]) / (2 * width)
    camera.shift_y = (f["bottom"] + f["top"]) / (2 * width)
    camera.clip_start, camera.clip_end = f["near"], f["far"]
    seen = bpy.data.objects.new("eye", camera)
    seen.matrix_world = Matrix([eye["view"][4 * i : 4 * i + 4] for i in range(4)]).inverted()
    scene = bpy.context.scene
    scene.collection.objects.link(seen)
    scene.camera = seen
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    aspect = (width / size[0]) / (height / size[1])
    scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = max(aspect, 1.0), max(1 / aspect, 1.0)


def draw_light(folder, samples):
    """Draws the picture twice, with different random numbers. Returns the parts of the light as arrays, rows from
    bottom to top. Diffuse and mirrored light: each a (2, height, width, 3) array without the colour of the surface."""
    scene = bpy.context.scene
    layer = scene.view_layers[0]
    passes = {"diffuse_direct": "DiffDir", "diffuse_indirect": "DiffInd", "diffuse_color": "DiffCol"}
    passes |= {"glossy_direct": "GlossDir", "glossy_indirect": "GlossInd", "glossy_color": "GlossCol"}
    passes |= {"normal": "Normal", "position": "Position"}
    for name in passes:
        setattr(layer, "use_pass_" + name, True)
    # The compositor's output node is the way to get the passes as files.
    scene.use_nodes = True
    nodes, links = scene.node_tree.nodes, scene.node_tree.links
    nodes.clear()
    source, out = nodes.new("CompositorNodeRLayers"), nodes.new("CompositorNodeOutputFile")
    links.new(source.outputs["Image"], nodes.new("CompositorNodeComposite").inputs[0])
    out.base_path = folder
    out.format.file_format, out.format.color_depth, out.format.color_mode = "OPEN_EXR", "32", "RGBA"
    out.file_slots.clear()
    for number, kind in enumerate(["Image", *passes.values()]):
        out.file_slots.new(kind)
        links.new(source.outputs[kind], out.inputs[number])
    width, height = scene.render.resolution_x, scene.render.resolution_y

    def read(kind):
        image = bpy.data.images.load(os.path.join(folder, f"{kind}{scene.frame_current:04d}.exr"), check_existing=False)
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
        return pixels.reshape(height, width, 4)

    scene.cycles.samples = max(samples // 2, 1)
    halves = []
    for scene.cycles.seed in (1, 2):
        bpy.ops.render.render()
        parts = {name: read(kind)[..., :3] for name, kind in passes.items()}
        parts["opacity"] = read("Image")[..., 3:]
        halves.append(parts)
    return {name: np.stack([half[name] for half in halves]) for name in halves[0]}


def main():
    arguments = sys.argv[sys.argv.index("--") + 1 :]
    folder = os.path.abspath(arguments[0])
    samples = int(arguments[1]) if len(arguments) > 1 else 512
    with open(os.path.join(folder, "frame.json")) as f:
        frame = json.load(f)
    with open(os.path.join(HERE, "tissues.json")) as f:
        values = json.load(f)
    vertices, triangles, names, origins = load_geometry(os.path.join(folder, "geometry.ply"))
    tissues = Tissues(values, frame["colors"], names)

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    tissue, metal = tissue_material(), metal_material(values["tool"])
    for body in np.unique(vertices["body"]):
        mine = np.flatnonzero(vertices["body"] == body)
        number = np.full(len(vertices), -1)
        number[mine] = np.arange(len(mine))
        own = number[triangles[vertices["body"][triangles[:, 0]] == body]]
        is_tool = body == TOOL
        look = (None, metal) if is_tool else (tissues, tissue)
        add_body(f"body {body}", vertices[mine], own, origins.get(body), *look)
    add_light(frame["light"])
    add_camera(frame["left"], frame["size"])

    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.use_adaptive_sampling = True
    scene.cycles.adaptive_threshold = 0.01
    scene.cycles.sample_clamp_indirect = 10
    # By default, Cycles allows only four diffuse and four glossy reflections among all reflections.
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = 16
    scene.cycles.use_denoising = False  # Debian's package has no denoiser; develop.py replaces it
    scene.render.film_transparent = True
    np.savez(os.path.join(folder, "light.npz"), **draw_light(folder, samples))


main()
