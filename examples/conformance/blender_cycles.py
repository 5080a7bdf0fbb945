"""Draws the scenes of a conformance pack with Blender's Cycles.

    pip install bpy
    python blender_cycles.py PACK PICTURES

or, with a Blender that is installed, `blender --background --python blender_cycles.py -- PACK PICTURES`.

Each scene is the pack's glTF file as Blender imports it. Set from the JSON is what glTF cannot say or Blender reads
otherwise: the coat's index, its absorption as a tint, the sun's strength, which Blender counts in watts, and the map.
"""

import math
import os
import sys
import tempfile

import bpy
import addon_utils  # which bpy brings along

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import pack


def world(args, light):
    """Light from everywhere: a colour or a map."""
    bpy.context.scene.world = bpy.data.worlds.new("world")
    bpy.context.scene.world.use_nodes = True
    nodes = bpy.context.scene.world.node_tree.nodes
    links = bpy.context.scene.world.node_tree.links
    nodes.clear()
    background, output = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeOutputWorld")
    links.new(background.outputs[0], output.inputs[0])
    background.inputs["Strength"].default_value = 1.0
    if light["kind"] == "directional":
        background.inputs["Color"].default_value = (0, 0, 0, 1)
    elif light["formula"]["kind"] == "constant":
        background.inputs["Color"].default_value = (*light["formula"]["radiance"], 1)
    else:
        # Y up becomes Z up, and Z of glTF -Y: the column of a direction is the same in both.
        picture = nodes.new("ShaderNodeTexEnvironment")
        picture.image = bpy.data.images.load(pack.environment(args, light))
        picture.image.colorspace_settings.name = "Linear Rec.709"
        links.new(picture.outputs[0], background.inputs["Color"])


def sun(light):
    """Parallel light without width; its strength is irradiance in W/m2."""
    for item in bpy.context.scene.objects:
        if item.type == "LIGHT":
            item.data.energy, item.data.angle = light["irradiance"][0], 0.0


def materials(args, scene):
    """Parameters of the coat beyond glTF. The tint is the light that is left after the way down and up at normal incidence."""
    values = scene["parameters"]
    tint = [math.exp(-2.0 * e * values["coat_thickness"]) for e in values["coat_extinction"]]
    for material in bpy.data.materials:
        for node in material.node_tree.nodes if material.node_tree else []:
            if node.type == "BSDF_PRINCIPLED":
                node.inputs["Coat IOR"].default_value = values["coat_ior"]
                node.inputs["Coat Tint"].default_value = (*tint, 1.0)
                if args.one_bounce:
                    node.distribution = "GGX"


def settings(args, size):
    """Radiance as it is: a box filter, no clamp, no denoiser."""
    scene = bpy.context.scene
    # Without the add-on a package of Blender has no engine of that name.
    addon_utils.enable("cycles")
    scene.camera = next(item for item in scene.objects if item.type == "CAMERA")
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.cycles.device = "CPU"
    scene.cycles.samples = args.samples
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0.0
    scene.cycles.blur_glossy = 0.0
    scene.view_settings.view_transform = "Raw"
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"
    image.exr_codec = "PIZ"


def main():
    parser = pack.arguments(__doc__.split("\n")[0], 128, 8)
    parser.add_argument("--one-bounce", action="store_true", help="GGX without the light of further bounces between facets")
    given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    args = parser.parse_args(given)
    size, scenes = pack.scenes(args)
    # The pack's own reader of pictures.
    sys.path.insert(0, os.path.abspath(args.pack))
    import score

    for scene in scenes:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.import_scene.gltf(filepath=os.path.abspath(os.path.join(args.pack, "scenes", f"{scene['name']}.gltf")))
        settings(args, size)
        world(args, scene["light"])
        if scene["light"]["kind"] == "directional":
            sun(scene["light"])
        materials(args, scene)
        passes = []
        with tempfile.TemporaryDirectory() as folder:
            for seed in range(args.passes):
                bpy.context.scene.cycles.seed = seed
                path = os.path.join(folder, f"{seed}.exr")
                bpy.context.scene.render.filepath = path
                bpy.ops.render.render(write_still=True)
                picture = score.read(path)
                planes = picture.planes(["R", "G", "B"], "linear Rec. 709")
                passes.append(pack.np.array(planes).T.reshape(picture.height, picture.width, 3))
        pack.write(args, scene["name"], *pack.combined(passes))
    print("Blender", bpy.app.version_string)


if __name__ == "__main__":
    main()
