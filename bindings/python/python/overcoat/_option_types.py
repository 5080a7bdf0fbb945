"""Types of options. Made of crates/description/src/scene.schema.json by scripts/option_types.py."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal, Mapping, Sequence, TypedDict, Union

from . import _overcoat
from ._camera import CameraMatrices

if TYPE_CHECKING:
    import numpy.typing as npt

    Vector = Union[Sequence[float], npt.NDArray[Any]]
    Matrix = Union[Sequence[Sequence[float]], Sequence[float], npt.NDArray[Any]]
    Path = Union[str, "os.PathLike[str]"]

Aov = Literal["depth", "position", "normal", "camera-normal", "coat-normal", "tangent", "base-color", "roughness", "metallic", "specular-color", "occlusion", "emissive", "coat", "coat-thickness", "coat-color", "sheen-color", "sheen-roughness", "anisotropy", "iridescence", "second-lobe", "subsurface", "specular-occlusion", "bent-normal", "material-id", "object-id", "instance-id", "uv", "coverage", "visibility", "shadow", "ground"]
AovSample = Literal["center", "nearest"]
AreaLights = Literal["ltc", "facets"]
Edges = Literal["none", "creases", "boundary"]
Quality = Literal["draft", "fast", "good", "best"]
Shading = Literal["urp-desktop", "urp-mobile", "urp17", "hdrp-lit", "stacklit", "filament", "filament-mobile", "filament-cloth", "filament-2018", "three", "three-legacy", "gltf", "gltf-sampled", "openpbr", "velvet", "babylon", "standard", "stacklit-d"]
Up = Literal["+x", "-x", "+y", "-y", "+z", "-z", "x", "y", "z"]


class Camera(TypedDict, total=False):
    """The option `camera`: lengths in metres, angles in degrees. Without `eye` the model is framed automatically."""

    K: Matrix
    """Intrinsics in pixels, in place of a field of view: the matrix fx, 0, cx; 0, fy, cy; 0, 0, 1, or the list fx, fy, cx, cy."""
    camera: Union[str, int]
    """Camera of the model file, by name or by number from 0."""
    convention: Literal["opencv", "opengl"]
    """Meaning of the pose: opencv (world to camera, +x right, +y down, +z forward) or opengl (camera to world, +y up, -z forward)."""
    cx: float
    """Principal point in pixels from the left border: the first pixel's centre is at 0.5."""
    cy: float
    """Principal point in pixels from the upper border."""
    eye: Vector
    """Position of the camera in metres, in the scene: the upright model, +Y is up."""
    far: float
    """No surface farther from the camera than this many metres is drawn [default: no limit]."""
    fov_y_deg: float
    """Vertical field of view in degrees, 0.1 to 179 [default: 30]."""
    fx: float
    """Focal length in widths of a pixel; with fy, cx and cy in place of K."""
    fy: float
    """Focal length in heights of a pixel."""
    intrinsics_size: Union[int, Sequence[int]]
    """Width and height in pixels of the picture that the intrinsics are for; pictures of another size have its shape [default: that of the picture]."""
    near: float
    """Nothing nearer to the camera than this many metres is drawn [default: by the distance]."""
    ortho_height: float
    """Parallel projection that shows this many metres from top to bottom; 0 fits the model."""
    pose: Matrix
    """Position and direction of the camera, a 4 x 4 matrix: opencv, world to camera; opengl, camera to world, by convention."""
    target: Vector
    """Point in the centre of the picture, in metres [default: the middle of the model]."""
    up: Vector
    """Direction that is up in the picture [default: 0,1,0]."""
    view: Union[str, Vector]
    """Direction from which the model is framed: three-quarter, front, back, left, right, top, bottom, or x,y,z from the model towards the camera [default: three-quarter, or another one from the front and above that shows twice as much]."""


class ViewOptions(TypedDict, total=False):
    """Options of how a picture is drawn, whatever it shows: those of `overcoat.Viewport`."""

    anisotropy: int
    """Largest anisotropy of texture filtering, 1 to 16 [default: 8]."""
    aov_sample: AovSample
    """Surface of a pixel that planes of depth, place, direction and identity show: center or nearest [default: center]."""
    area_lights: AreaLights
    """Integration of the reflections of rectangles and tubes: ltc, as engines do, or facets, slower and within 1 percent [default: ltc]."""
    background: str
    """Background: transparent, env, #rrggbb (the # may be left out) or a colour name [default: transparent, of .jpg white]."""
    cavity: float
    """Strength by which concave creases are drawn darker and convex ones lighter, 0 to 2 [default: 1 of parts without colours (STL, 3MF, OBJ, PLY), but in draft; else 0]."""
    edge_width: float
    """Width of the lines of edges in pixels, 0.1 to 64 [default: 1.2 in 512x512, with the root of the shorter side]."""
    edges: Edges
    """Edges that are drawn as dark lines: none, creases (where faces meet at more than 40 degrees) or boundary (and where they end) [default: creases of parts without colours (STL, 3MF, OBJ, PLY); else none]."""
    exposure: Union[float, Literal["auto"]]
    """Exposure of 8-bit pictures in stops, -64 to 64: +1 doubles the light; auto meters the object [default: 0]."""
    ground: str
    """Floor under the model: none, shadow (only the model's shadow, over what is behind it), #rrggbb or a colour name (a matt floor that fades) [default: shadow; of bench and without maps none]."""
    ground_reflection: float
    """Share of the model's light that the floor mirrors, 0 to 1 [default: 0]."""
    line_width: float
    """Width of lines in pixels, 0.1 to 64 [default: 1.5]."""
    merge_angle_deg: float
    """Shade triangles smaller than two pixels as one where their normals differ by less than this many degrees: faster on dense meshes, with less smoothing of sharp reflections, 0 to 45 [default: 0]."""
    point_size: float
    """Diameter of points in pixels, 0.1 to 64 [default: by the distances between them, at least about a pixel; 3 if they are far apart]."""
    quality: Quality
    """Quality tier: draft (no shadows), fast (shadows of the environment), good (and light from other surfaces by rays) or best [default: fast; of bench draft]."""
    rim: float
    """Strength by which surfaces are drawn darker towards their outline, 0 to 2 [default: 1 of white models in the studio, but in draft; else 0]."""
    samples: Literal[1, 4, 8, 16]
    """Samples a pixel for smooth edges, 1, 4, 8 or 16 [default: 8]."""
    shade_everywhere: bool
    """Shade every surface at the shading rate, and not only where one shading would show."""
    shading: Shading
    """Shading model of every surface [default: what each material names, else standard]."""
    size: Union[int, Sequence[int]]
    """Width and height in pixels; one number makes a square [default: 512x512]."""
    specular_antialiasing: bool
    """Let roughness grow where normals vary within a pixel, against flickering highlights: Filament's way in its models, Tokuyoshi's and Kaplanyan's of 2019 in others, and for what normal maps lose as they shrink; those of three.js always have their own."""
    tone_mapping: Union[Literal["none", "neutral", "aces", "agx", "linear"], Sequence[Literal["none", "neutral", "aces", "agx", "linear"]]]
    """Tone curve of 8-bit pictures: none (or linear), neutral, aces, agx; of a list of names in a scene file the first counts [default: neutral]."""
    limits: Mapping[str, int]
    """Bounds on the work and on what a file may ask for, by the names of `overcoat render --limit`."""


class PictureOptions(ViewOptions, total=False):
    """Every option of `overcoat.render`, with its type; `help(overcoat.Options)` says what each does."""

    animation: Union[str, int]
    """Animation of the model file (glTF), by name or by number from 0 [default: none, the pose of the file]."""
    camera: Union[Camera, str, _overcoat.Orbit, CameraMatrices]
    """The camera. Without eye the model is framed automatically, seen along view."""
    env: Union[Path, _overcoat.Environment, npt.NDArray[Any]]
    """Equirectangular picture or cube (.hdr, .exr; .jpg, .png, .webp with a warning) that lights the scene, or one of the program's own: studio, car-studio, sky or none [default: studio]."""
    env_intensity: float
    """Factor of the environment's radiance [default: 1]."""
    env_rotation_deg: float
    """Turn of the environment about the vertical axis in degrees, counter-clockwise seen from above [default: 0]."""
    light: Sequence[Mapping[str, Any]]
    """Lights beside those of the model file."""
    lights: bool
    """False leaves out the lights of the model file."""
    loop: bool
    """Begin the animation again after its end."""
    map_size: int
    """Texels along a side of a depth map, 32 to 2048 [default: by the tier]."""
    maps: int
    """Directions of the environment's light, each with a depth map of the scene, 0 to 256 [default: by the tier]."""
    material: Union[Path, Mapping[str, Any]]
    """Material of every mesh: the path of a material file, or the name of a built-in one."""
    materials: Mapping[str, Union[Path, Mapping[str, Any]]]
    """Materials by the names of the model's materials that they replace."""
    plate: int
    """Plate of a 3MF project that is drawn alone, by its number from 1, 1 to 4294967295 [default: all of them, side by side]."""
    rays: int
    """Rays that each lobe sends for the light of other surfaces, 0 to 256 [default: by the tier]."""
    shading_rate: Literal[1, 4, 8, 9, 16]
    """Shadings a pixel where one would show (sharp highlights on curved surfaces, alpha masks, shining normal maps, textures without mip levels), with at least as many samples, 1, 4, 8, 9 or 16 [default: by the tier]."""
    time: float
    """Seconds in the animation; beyond its end it stays as it is there [default: 0]."""
    up: Up
    """Axis of the model file that is up; the model is turned upright, with its lights and cameras [default: that of the file or of its format; of formats that leave it to custom the one of +y and +z on which the model stands]."""
    aov: Union[Aov, Sequence[Aov]]
    """Planes of the G-buffer to draw as well."""
    format: str
    """Format of a model in memory, where its content does not tell."""
