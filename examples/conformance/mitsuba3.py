"""Draws the scenes of a conformance pack with Mitsuba 3.

    pip install mitsuba
    python mitsuba3.py PACK PICTURES

Two ways to a coat. `--coat layers` (the default) builds it: a sphere of dielectric, rough or smooth, with an absorbing medium
around a sphere of the base, and path tracing does the rest. It is physics with one bounce between facets, and a gap of four
thousandths of the radius. Plastic by convention cannot be built: its base is `principled`'s. `--coat principled` is
Mitsuba's `principled` with its clear coat, which has an index of 1.5, a fixed strength and no absorption.
"""

import math
import os
import sys

import mitsuba as mi

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import pack

mi.set_variant("scalar_rgb")
# Bars of progress are no lines of a report.
mi.logger().clear_appenders()

# Distance of the spheres. Mitsuba starts the next part of a path 9e-5 (1 + largest coordinate) further on (`spawn_ray`, with floats of
# 32 bits), which the medium would miss.
GAP = 4e-3
SKIPPED = 1.6e-4

# The middle column of Mitsuba's maps is -Z, that of the pack's is +X.
TURN = 90.0


def rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values]}


def emitter(args, light):
    if light["kind"] == "directional":
        direction = [-v for v in light["towards"]]
        return {"type": "directional", "direction": direction, "irradiance": rgb(light["irradiance"])}
    if light["formula"]["kind"] == "constant":
        return {"type": "constant", "radiance": rgb(light["formula"]["radiance"])}
    turn = mi.ScalarTransform4f().rotate([0, 1, 0], TURN)
    return {"type": "envmap", "filename": pack.environment(args, light), "to_world": turn}


def metal_or_plastic(layers):
    """The base by its layers, without those of the coat."""
    last = layers[-1]
    if last["kind"] == "conductor":
        # Schlick's term of F0, one bounce.
        roughness = math.sqrt(last["ggx_alpha"])
        return {"type": "principled", "base_color": rgb(last["f0"]), "metallic": 1.0, "roughness": roughness}
    if len(layers) > 1:
        lobe = layers[0]
        if lobe["fresnel"] == "exact":
            return {
                "type": "roughplastic",
                "int_ior": lobe["index"],
                "alpha": max(lobe["ggx_alpha"], 1e-3),
                "distribution": "ggx",
                "nonlinear": True,
                "diffuse_reflectance": rgb(last["reflectance"]),
            }
        # Plastic as engines have it: `specular` of 0.5 is an F0 of 0.04.
        return {
            "type": "principled",
            "base_color": rgb(last["reflectance"]),
            "roughness": math.sqrt(lobe["ggx_alpha"]),
            "specular": 0.5,
        }
    return {"type": "diffuse", "reflectance": rgb(last["reflectance"])}


def layered(layers):
    """Spheres, one around the other."""
    if layers[0].get("fresnel") != "exact" or len(layers) < 3:
        return {"ball": {"type": "sphere", "bsdf": metal_or_plastic(layers)}}
    coat, medium = layers[0], layers[1]
    face = {"type": "dielectric", "int_ior": coat["index"], "ext_ior": 1.0}
    if coat["ggx_alpha"] > 0.0:
        face.update({"type": "roughdielectric", "alpha": coat["ggx_alpha"], "distribution": "ggx"})
    shell = {"type": "sphere", "bsdf": face}
    depth = [e * medium["thickness"] for e in medium["extinction"]]
    if any(depth):
        shell["interior"] = {"type": "homogeneous", "sigma_t": rgb(depth), "scale": 1.0 / (GAP - SKIPPED), "albedo": rgb([0.0] * 3)}
    return {"coat": shell, "ball": {"type": "sphere", "radius": 1.0 - GAP, "bsdf": metal_or_plastic(layers[2:])}}


def principled(parameters, coated):
    """Parameters as a user would set them. The clear coat of `principled` has a quarter of the strength that it says."""
    if parameters["specular"] == 0.0 and not coated:
        return {"type": "diffuse", "reflectance": rgb(parameters["base_color"])}
    return {
        "type": "principled",
        "base_color": rgb(parameters["base_color"]),
        "metallic": float(parameters["metallic"]),
        "roughness": float(parameters["base_roughness"]),
        "specular": 0.5 * float(parameters["specular"]),
        "clearcoat": 1.0 if coated else 0.0,
        "clearcoat_gloss": gloss(parameters["coat_roughness"]),
    }


def gloss(roughness):
    """Inverse of the alpha of the clear coat, which is 0.1 at a gloss of 0 and 0.001 at 1 (Burley 2012)."""
    return min(max((0.1 - roughness * roughness) / (0.1 - 0.001), 0.0), 1.0)


def parts(args, scene):
    """Shapes of each part of the surface, with its share. A ball is convex, so that the picture of a mixture is the mixture of pictures."""
    for surface in scene["surfaces"]:
        layers = surface["layers"]
        if args.coat == "layers":
            yield surface["share"], layered(layers)
        else:
            coated = layers[0].get("fresnel") == "exact"
            yield surface["share"], {"ball": {"type": "sphere", "bsdf": principled(scene["parameters"], coated)}}


def integrator(args, scene):
    """Paths from the camera never meet parallel light behind a face of glass, so those from the lamp are traced."""
    if args.coat == "layers" and scene["light"]["kind"] == "directional" and not is_bare(scene):
        return {"type": "ptracer", "max_depth": 64, "rr_depth": 8, "hide_emitters": True}
    medium = any(any(l.get("extinction", [])) for s in scene["surfaces"] for l in s["layers"])
    return {"type": "volpath" if medium else "path", "max_depth": 64, "rr_depth": 8}


def is_bare(scene):
    return scene["parameters"]["coat"] == 0


def main():
    parser = pack.arguments(__doc__.split("\n")[0], 64, 8)
    parser.add_argument("--coat", choices=["layers", "principled"], default="layers", help="see above [default: layers]")
    args = parser.parse_args()
    size, scenes = pack.scenes(args)
    for scene in scenes:
        camera = scene["camera"]
        sensor = {
            "type": "perspective",
            "fov_axis": "y",
            "fov": camera["vertical_fov_degrees"],
            "to_world": mi.ScalarTransform4f().look_at(camera["eye"], camera["target"], camera["up"]),
            "film": {
                "type": "hdrfilm",
                "width": size,
                "height": size,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": "independent"},
        }
        passes = [pack.np.zeros((size, size, 3)) for _ in range(args.passes)]
        for part, (share, shapes) in enumerate(parts(args, scene)):
            light = emitter(args, scene["light"])
            built = {"type": "scene", "integrator": integrator(args, scene), "sensor": sensor, "light": light, **shapes}
            drawn = mi.load_dict(built)
            # Few of the paths from a lamp reach a pixel.
            samples = args.samples * (8 if built["integrator"]["type"] == "ptracer" else 1)
            for seed in range(args.passes):
                picture = mi.render(drawn, spp=samples, seed=1 + seed + part * args.passes)
                passes[seed] += share * pack.np.array(picture, dtype=pack.np.float64)[..., :3]
        pack.write(args, scene["name"], *pack.combined(passes))
    print("Mitsuba", mi.__version__)


if __name__ == "__main__":
    main()
