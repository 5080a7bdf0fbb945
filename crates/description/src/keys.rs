//! The table of options. A row says everything about one: its key in scene files, its place in a [`Description`], the kind of its
//! values, its sentence and default, how the command line takes it and whether a request may set it. Scene files, their schema
//! (of which the types of Python and TypeScript are made), arguments with help and completion, and queries of the service follow.

use super::Description;
use super::argument::{Argument, Group};
use super::camera::CameraDescription;
use super::kind::{
    Axes, BackgroundColor, Direction, EnvironmentSource, Exposure, FloorColor, Kind, Material, MatrixK,
    ModelPart, Names, Number, OneOf, Path, Pixels, PoseMatrix, Position, Seconds, Size, Switch, Views, Whole,
};
use super::light::LightDescription;
use super::materials::MaterialSource;
use super::schema;
use super::value::Value;
use super::write;
use overcoat_core::color::ToneCurve;
use overcoat_core::frame::PlaneSample;
use overcoat_core::suggest::{nearest_name, same_name, suggestion};
use overcoat_load::Warning;
use overcoat_render::{Edges, Quality};
use overcoat_scene::{AreaLightMethod, PoseConvention, ShadingModel};
use serde_json::Value as Json;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ffi::OsStr;

/// An option: a key of a table of scene files.
pub(super) struct Key<T: 'static> {
    /// In lower case with `_` between words; other spellings are read with a warning.
    pub(super) name: &'static str,
    /// Its meaning, in one line.
    pub(super) about: &'static str,
    /// The default, in words.
    pub(super) default: Option<&'static str>,
    /// Puts a value of a scene file where it belongs, or says what was expected.
    pub(super) set: fn(&mut T, &Value<'_>) -> Result<(), String>,
    /// Puts an argument of the command line where it belongs, or says what was expected.
    pub(super) set_argument: fn(&mut T, &OsStr) -> Result<(), String>,
    /// Its value as it is written, if there is one, or why it cannot be.
    pub(super) get: fn(&T) -> Result<Option<Json>, String>,
    /// JSON schema of its values.
    pub(super) schema: fn() -> Json,
    /// Text of a query as a value of a scene file, or what was expected.
    pub(super) query: fn(&str) -> Result<Json, String>,
    /// Values with names.
    pub(super) names: fn() -> Vec<&'static str>,
    /// Bounds of its values, in words.
    pub(super) range: fn() -> Option<String>,
    /// True if a request to a service may set it: never an option that names files.
    pub(super) in_requests: bool,
    /// Its argument of the command line, if there is one.
    pub(super) argument: Option<Argument>,
}

impl<T> Key<T> {
    /// A key without a place: nothing of it is kept.
    pub(super) const fn new(name: &'static str, about: &'static str) -> Self {
        Self {
            name,
            about,
            default: None,
            set: |_, _| Ok(()),
            set_argument: |_, _| Ok(()),
            get: |_| Ok(None),
            schema: schema::anything,
            query: |text| Ok(text.into()),
            names: || Vec::new(),
            range: || None,
            in_requests: false,
            argument: None,
        }
    }

    /// With a default, in words.
    pub(super) const fn default(self, default: &'static str) -> Self {
        Self { default: Some(default), ..self }
    }

    /// With an argument of the command line.
    const fn argument(self, argument: Argument) -> Self {
        Self { argument: Some(argument), ..self }
    }

    /// With the right of requests to set it.
    const fn in_requests(self) -> Self {
        Self { in_requests: true, ..self }
    }

    /// Its meaning, range and default.
    pub(super) fn sentence(&self) -> Cow<'static, str> {
        self.sentence_of(self.about)
    }

    /// A sentence with its range and default.
    pub(super) fn sentence_of(&self, about: &'static str) -> Cow<'static, str> {
        let range = (self.range)().map(|range| format!(", {range}"));
        let default = self.default.map(|default| format!(" [default: {default}]"));
        if range.is_none() && default.is_none() {
            return about.into();
        }
        format!("{about}{}{}", range.unwrap_or_default(), default.unwrap_or_default()).into()
    }
}

/// An option of a table: name, place, kind of its values, meaning.
macro_rules! key {
    ($table:ty, $name:literal, $target:ident . $($place:ident).+, $kind:expr, $about:literal) => {
        Key {
            set: |$target: &mut $table, value| {
                $target.$($place).+ = Some($kind.read(value)?);
                Ok(())
            },
            set_argument: |$target, text| {
                $target.$($place).+ = Some($kind.parse_os(text)?);
                Ok(())
            },
            get: |$target| $target.$($place).+.as_ref().map(|value| $kind.write(value)).transpose(),
            schema: || $kind.schema(),
            query: |text| $kind.query(text),
            names: || $kind.names(),
            range: || $kind.range(),
            ..Key::new($name, $about)
        }
    };
}
pub(super) use key;

/// Help of the shading models.
fn shading_models() -> String {
    let named = |model: &ShadingModel| format!("{} ({})", model.name(), model.version());
    ShadingModel::ALL.iter().map(named).collect::<Vec<_>>().join(", ") + "."
}

/// An option of the file.
macro_rules! scene {
    ($($row:tt)+) => { key!(Description, $($row)+) };
}

/// An option of the camera.
macro_rules! camera {
    ($($row:tt)+) => { key!(CameraDescription, $($row)+) };
}

/// Keys of the file.
pub(super) static SCENE: &[Key<Description>] = &[
    scene!("model", s.model, Path("the path of a model file"), "The model file"),
    scene!("up", s.up, Axes, "Axis of the model file that is up; the model is turned upright, with its lights and cameras")
        .default("that of the file or of its format; of formats that leave it to custom the one of +y and +z on which the model stands")
        .argument(Argument::new(Group::Input, "up", "AXIS").hyphen().help(
            "Which axis of the model file is up: +x, -x, +y, -y, +z or -z; the model is turned upright, with its lights and cameras",
        ).more(|| {
            "Its front is then +Z of the file, as in glTF; -Y where +z is up, as in slicers and Blender, +Y where -z is.".to_owned()
        }))
        .in_requests(),
    scene!("plate", s.plate, Whole(1..=u32::MAX), "Plate of a 3MF project that is drawn alone, by its number from 1")
        .default("all of them, side by side")
        .argument(Argument::new(Group::Input, "plate", "N"))
        .in_requests(),
    scene!(
        "env",
        s.env,
        EnvironmentSource,
        "Equirectangular picture or cube (.hdr, .exr; .jpg, .png, .webp with a warning) that lights the scene, or one of the program's own: studio, car-studio, sky or none"
    )
    .default("studio")
    .argument(Argument::new(Group::Light, "env", "FILE|NAME")),
    scene!(
        "env_rotation_deg",
        s.env_rotation_degrees,
        Number::any("degrees"),
        "Turn of the environment about the vertical axis in degrees, counter-clockwise seen from above"
    )
    .default("0")
    .argument(Argument::new(Group::Light, "env-rotation", "DEGREES"))
    .in_requests(),
    scene!("env_intensity", s.env_intensity, Number::positive("a factor"), "Factor of the environment's radiance")
        .default("1")
        .argument(Argument::new(Group::Light, "env-intensity", "FACTOR"))
        .in_requests(),
    scene!("lights", s.lights, Switch, "False leaves out the lights of the model file")
        .argument(Argument::flag(Group::Light, "no-lights", false).help("Leave out the lights of the model file"))
        .in_requests(),
    Key {
        set: |s: &mut Description, v| {
            v.each("a list of lights", |v| {
                s.lights_to_add.push(LightDescription::read(v)?);
                Ok(())
            })
        },
        get: |s| write::lights(&s.lights_to_add),
        schema: || schema::list(LightDescription::schema()),
        query: |text| serde_json::from_str(text).map_err(|e| format!("JSON ({e})")),
        ..Key::new("light", "Lights beside those of the model file")
    }
    .in_requests(),
    Key {
        set: |s, v| v.table(CAMERA, &mut s.camera),
        get: |s| write::table(CAMERA, &s.camera),
        schema: || schema::table(CAMERA, &[]),
        ..Key::new("camera", "The camera. Without eye the model is framed automatically, seen along view")
    },
    scene!("animation", s.animation, ModelPart("an animation"), "Animation of the model file (glTF), by name or by number from 0")
        .default("none, the pose of the file")
        .argument(Argument::new(Group::Animation, "animation", "NAME|INDEX"))
        .in_requests(),
    scene!("time", s.time, Seconds, "Seconds in the animation; beyond its end it stays as it is there")
        .default("0")
        .argument(Argument::new(Group::Animation, "time", "SECONDS"))
        .in_requests(),
    scene!("loop", s.repeat, Switch, "Begin the animation again after its end")
        .argument(Argument::flag(Group::Animation, "loop", true))
        .in_requests(),
    scene!("size", s.size, Size, "Width and height in pixels; one number makes a square")
        .default("512x512")
        .argument(Argument::new(Group::Picture, "size", "WxH").hyphen()),
    scene!(
        "background",
        s.background,
        BackgroundColor,
        "Background: transparent, env, #rrggbb (the # may be left out) or a colour name"
    )
    .default("transparent, of .jpg white")
    .argument(Argument::new(Group::Display, "background", "COLOR"))
    .in_requests(),
    scene!(
        "tone_mapping",
        s.tone_curve,
        Names::<ToneCurve>::OF,
        "Tone curve of 8-bit pictures: none (or linear), neutral, aces, agx; of a list of names in a scene file the first counts"
    )
    .default("neutral")
    .argument(
        Argument::new(Group::Display, "tone-map", "CURVE")
            .help("Tone curve of 8-bit pictures: none (or linear), neutral, aces, agx"),
    )
    .in_requests(),
    scene!(
        "exposure",
        s.exposure,
        Exposure,
        "Exposure of 8-bit pictures in stops, -64 to 64: +1 doubles the light; auto meters the object"
    )
    .default("0")
    .argument(Argument::new(Group::Display, "exposure", "STOPS|auto").more(|| {
        "auto makes one tenth of the object brighter than 0.7 (linear), by -24 to 24 stops: its 90th percentile of \
         luminance is metered, of the first frame in moving pictures. Unless it is set, it is metered as well where the lights \
         of a scene leave more than a third of the object white; a warning says how much lower it is then."
            .to_owned()
    }))
    .in_requests(),
    scene!("samples", s.samples, OneOf(&["1", "4", "8", "16"]), "Samples a pixel for smooth edges")
        .default("8")
        .argument(Argument::new(Group::Picture, "samples", "N"))
        .in_requests(),
    scene!(
        "quality",
        s.quality,
        Names::<Quality>::OF,
        "Quality tier: draft (no shadows), fast (shadows of the environment), good (and light from other surfaces by rays) or best"
    )
    .default("fast; of bench draft")
    .argument(Argument::new(Group::Picture, "quality", "TIER").more(|| {
        "Sets --maps, --map-size, --rays and --shading-rate: draft 0, 256, 0, 1; fast 64, 128, 0, 1; good 64, 256, 4, 4; \
         best 128, 512, 16, 4. In enclosed spaces (rooms, boxes, caves) fast sends a ray as well."
            .to_owned()
    }))
    .in_requests(),
    scene!(
        "maps",
        s.maps,
        Whole(0..=256),
        "Directions of the environment's light, each with a depth map of the scene"
    )
    .default("by the tier")
    .argument(Argument::new(Group::Picture, "maps", "N"))
    .in_requests(),
    scene!("map_size", s.map_size, Whole(32..=2048), "Texels along a side of a depth map")
        .default("by the tier")
        .argument(Argument::new(Group::Picture, "map-size", "N"))
        .in_requests(),
    scene!("rays", s.rays, Whole(0..=256), "Rays that each lobe sends for the light of other surfaces")
        .default("by the tier")
        .argument(Argument::new(Group::Picture, "rays", "N"))
        .in_requests(),
    scene!(
        "shading_rate",
        s.shading_rate,
        OneOf(&["1", "4", "8", "9", "16"]),
        "Shadings a pixel where one would show (sharp highlights on curved surfaces, alpha masks, shining normal maps, textures \
         without mip levels), with at least as many samples"
    )
    .default("by the tier")
    .argument(Argument::new(Group::Picture, "shading-rate", "N"))
    .in_requests(),
    scene!(
        "shade_everywhere",
        s.shade_everywhere,
        Switch,
        "Shade every surface at the shading rate, and not only where one shading would show"
    )
    .argument(
        Argument::flag(Group::Picture, "shade-everywhere", true)
            .help("Shade every surface as often as --shading-rate says"),
    )
    .in_requests(),
    scene!(
        "ground",
        s.ground,
        FloorColor,
        "Floor under the model: none, shadow (only the model's shadow, over what is behind it), #rrggbb or a colour name (a matt \
         floor that fades)"
    )
    .default("shadow; of bench and without maps none")
    .argument(Argument::new(Group::Picture, "ground", "SHADOW|COLOR").more(|| {
        "The floor lies at the lowest point of the model and is seen from above. The environment and all lights shine on it \
         past the model, by the depth maps of --maps, or by those of --quality fast if there are none. It fades before the \
         border of the picture, where automatic cameras leave some room for it. Unless one is asked for, there is none where \
         nothing blocks light (in --quality draft, with --maps 0) and in bench."
            .to_owned()
    }))
    .in_requests(),
    scene!(
        "ground_reflection",
        s.ground_reflection,
        Number::within("of 1", 0.0, 1.0),
        "Share of the model's light that the floor mirrors"
    )
    .default("0")
    .argument(Argument::new(Group::Picture, "ground-reflection", "PART").more(|| {
        "The mirrored model is a second picture, with everything that the first has, and costs as much. It fades with the \
         floor."
            .to_owned()
    }))
    .in_requests(),
    scene!("shading", s.shading, Names::<ShadingModel>::OF, "Shading model of every surface")
        .default("what each material names, else standard")
        .argument(Argument::new(Group::Picture, "shading", "MODEL").more(shading_models))
        .in_requests(),
    scene!(
        "material",
        s.material,
        Material,
        "Material of every mesh: the path of a material file, or the name of a built-in one"
    ),
    Key {
        set: |s, v| v.materials(&mut s.materials),
        get: |s| write::materials(&s.materials),
        schema: schema::materials,
        ..Key::new("materials", "Materials by the names of the model's materials that they replace")
    },
    scene!("anisotropy", s.anisotropy, Whole(1..=16), "Largest anisotropy of texture filtering")
        .default("8")
        .argument(Argument::new(Group::Picture, "anisotropy", "N"))
        .in_requests(),
    scene!(
        "specular_antialiasing",
        s.specular_antialiasing,
        Switch,
        "Let roughness grow where normals vary within a pixel, against flickering highlights: Filament's way in its models, \
         Tokuyoshi's and Kaplanyan's of 2019 in others, and for what normal maps lose as they shrink; those of three.js always \
         have their own"
    )
    .argument(Argument::flag(Group::Picture, "specular-antialiasing", true))
    .in_requests(),
    scene!(
        "area_lights",
        s.area_lights,
        Names::<AreaLightMethod>::OF,
        "Integration of the reflections of rectangles and tubes: ltc, as engines do, or facets, slower and within 1 percent"
    )
    .default("ltc")
    .argument(Argument::new(Group::Picture, "area-lights", "METHOD"))
    .in_requests(),
    scene!(
        "merge_angle_deg",
        s.merge_angle_degrees,
        Number::within("degrees", 0.0, 45.0),
        "Shade triangles smaller than two pixels as one where their normals differ by less than this many degrees: faster on \
         dense meshes, with less smoothing of sharp reflections"
    )
    .default("0")
    .argument(Argument::new(Group::Picture, "merge-angle", "DEGREES"))
    .in_requests(),
    scene!(
        "edges",
        s.edges,
        Names::<Edges>::OF,
        "Edges that are drawn as dark lines: none, creases (where faces meet at more than 40 degrees) or boundary (and where they end)"
    )
    .default("creases of parts without colours (STL, 3MF, OBJ, PLY); else none")
    .argument(Argument::new(Group::Picture, "edges", "EDGES").more(|| {
        "Hidden lines are hidden, and creases that would blacken the picture are left out: those of scans, of relief and of parts \
         that are small on the screen. Surfaces that are cut out, blended or let light through have none."
            .to_owned()
    }))
    .in_requests(),
    scene!("edge_width", s.edge_width, Number::within("pixels", 0.1, 64.0), "Width of the lines of edges in pixels")
        .default("1.2 in 512x512, with the root of the shorter side")
        .argument(Argument::new(Group::Picture, "edge-width", "PIXELS"))
        .in_requests(),
    scene!(
        "cavity",
        s.cavity,
        Number::within("strength", 0.0, 2.0),
        "Strength by which concave creases are drawn darker and convex ones lighter"
    )
    .default("1 of parts without colours (STL, 3MF, OBJ, PLY), but in draft; else 0")
    .argument(Argument::new(Group::Picture, "cavity", "STRENGTH"))
    .in_requests(),
    scene!(
        "rim",
        s.rim,
        Number::within("strength", 0.0, 2.0),
        "Strength by which surfaces are drawn darker towards their outline"
    )
    .default("1 of white models in the studio, but in draft; else 0")
    .argument(Argument::new(Group::Picture, "rim", "STRENGTH").more(|| {
        "White stands out from a white page by it. A model is white where four fifths of what is seen of it are of materials whose \
         base colour is at least sRGB #c0 in all channels, without a texture."
            .to_owned()
    }))
    .in_requests(),
    scene!("line_width", s.line_width, Number::within("pixels", 0.1, 64.0), "Width of lines in pixels")
        .default("1.5")
        .argument(Argument::new(Group::Picture, "line-width", "PIXELS"))
        .in_requests(),
    scene!("point_size", s.point_size, Number::within("pixels", 0.1, 64.0), "Diameter of points in pixels")
        .default("by the distances between them, at least about a pixel; 3 if they are far apart")
        .argument(Argument::new(Group::Picture, "point-size", "PIXELS"))
        .in_requests(),
    scene!(
        "aov_sample",
        s.aov_sample,
        Names::<PlaneSample>::OF,
        "Surface of a pixel that planes of depth, place, direction and identity show: center or nearest"
    )
    .default("center")
    .argument(Argument::new(Group::Picture, "aov-sample", "WHICH").more(|| {
        "center: the surface at the pixel's centre, evaluated there, whatever --samples. nearest: of all surfaces that the samples of \
         the pixel see, the one nearest to the camera. Neither is a mean, so that every depth is that of a surface."
            .to_owned()
    }))
    .in_requests(),
    Key::new("name", "A name, for readers"),
    Key::new("note", "A note, for readers"),
    Key::new("peers", "Pictures of other programs, for readers"),
    Key::new("ground_truth", "Pictures to compare with, for readers"),
];

/// Keys of the table `camera`.
pub(super) static CAMERA: &[Key<CameraDescription>] = &[
    camera!("view", c.view, Views,
        "Direction from which the model is framed: three-quarter, front, back, left, right, top, bottom, or x,y,z from the model \
         towards the camera"
    )
    .default("three-quarter, or another one from the front and above that shows twice as much")
    .argument(Argument::new(Group::Camera, "view", "VIEW").hyphen().conflicts(&["eye", "camera"]))
    .in_requests(),
    camera!("camera", c.from_model, ModelPart("a camera"), "Camera of the model file, by name or by number from 0")
        .argument(Argument::new(Group::Camera, "camera", "NAME|INDEX").conflicts(&["eye"]))
        .in_requests(),
    camera!("eye", c.eye, Position, "Position of the camera in metres, in the scene: the upright model, +Y is up")
        .argument(Argument::new(Group::Camera, "eye", "X,Y,Z").hyphen())
        .in_requests(),
    camera!("target", c.target, Position, "Point in the centre of the picture, in metres")
        .default("the middle of the model")
        .argument(Argument::new(Group::Camera, "target", "X,Y,Z").hyphen().requires("eye"))
        .in_requests(),
    camera!("up", c.up, Direction, "Direction that is up in the picture")
        .default("0,1,0")
        .argument(
            Argument::new(Group::Camera, "camera-up", "X,Y,Z").hyphen()
                .help("Direction that is up in the picture; the model stays as it is (--up turns it)")
                .conflicts(&["camera"]),
        )
        .in_requests(),
    camera!("near", c.near, Number::positive("metres"), "Nothing nearer to the camera than this many metres is drawn")
        .default("by the distance")
        .argument(Argument::new(Group::Camera, "near", "DISTANCE").conflicts(&["camera"]))
        .in_requests(),
    camera!("far", c.far, Number::positive("metres"), "No surface farther from the camera than this many metres is drawn")
        .default("no limit")
        .argument(Argument::new(Group::Camera, "far", "DISTANCE").conflicts(&["camera"]))
        .in_requests(),
    camera!("fov_y_deg", c.fov_y_degrees, Number::within("degrees", 0.1, 179.0), "Vertical field of view in degrees")
        .default("30")
        .argument(Argument::new(Group::Camera, "fov", "DEGREES").conflicts(&["camera", "ortho"]))
        .in_requests(),
    camera!(
        "ortho_height",
        c.orthographic_height,
        Number::positive("metres"),
        "Parallel projection that shows this many metres from top to bottom; 0 fits the model"
    )
    .argument(
        Argument::new(Group::Camera, "ortho", "HEIGHT")
            .help(
                "Parallel projection, HEIGHT metres from the top of the picture to its bottom [default: fits the model]",
            )
            .conflicts(&["camera"])
            .without_value("0"),
    )
    .in_requests(),
    camera!("K", c.k, MatrixK,
        "Intrinsics in pixels, in place of a field of view: the matrix fx, 0, cx; 0, fy, cy; 0, 0, 1, or the list fx, fy, cx, cy"
    )
    .argument(
        Argument::new(Group::Camera, "intrinsics", "FX,FY,CX,CY")
            .hyphen()
            .help("Intrinsics, in place of a field of view: focal lengths and principal point in pixels")
            .conflicts(&["camera", "fov", "ortho"])
            .more(|| {
                "The centre of the first pixel is at 0.5, 0.5; the principal point may lie outside of the picture, up to eight of its \
                 widths and heights from its middle. Calibrations that have the centre of the first pixel at 0, 0, as those of \
                 OpenCV do, want 0.5 more for CX and CY."
                    .to_owned()
            }),
    )
    .in_requests(),
    camera!("fx", c.fx, Pixels, "Focal length in widths of a pixel; with fy, cx and cy in place of K").in_requests(),
    camera!("fy", c.fy, Pixels, "Focal length in heights of a pixel").in_requests(),
    camera!("cx", c.cx, Pixels, "Principal point in pixels from the left border: the first pixel's centre is at 0.5")
        .in_requests(),
    camera!("cy", c.cy, Pixels, "Principal point in pixels from the upper border").in_requests(),
    camera!("intrinsics_size", c.intrinsics_size, Size,
        "Width and height in pixels of the picture that the intrinsics are for; pictures of another size have its shape"
    )
    .default("that of the picture")
    .argument(Argument::new(Group::Camera, "intrinsics-size", "WxH").hyphen().requires("intrinsics"))
    .in_requests(),
    camera!("pose", c.pose, PoseMatrix,
        "Position and direction of the camera, a 4 x 4 matrix: opencv, world to camera; opengl, camera to world, by convention"
    )
    .argument(
        Argument::new(Group::Camera, "pose", "16 NUMBERS|FILE")
            .hyphen()
            .help("Position and direction of the camera: a 4 x 4 matrix row by row, or a file that has it")
            .conflicts(&["view", "camera", "eye", "target", "camera-up"])
            .requires("pose-convention"),
    )
    .in_requests(),
    camera!("convention", c.convention, Names::<PoseConvention>::OF,
        "Meaning of the pose: opencv (world to camera, +x right, +y down, +z forward) or opengl (camera to world, +y up, -z forward)"
    )
    .argument(Argument::new(Group::Camera, "pose-convention", "NAME").requires("pose"))
    .in_requests(),
];

impl Value<'_> {
    /// Reads a table by its keys.
    pub(super) fn table<T>(&self, keys: &'static [Key<T>], target: &mut T) -> Result<(), String> {
        let entries = self.node.table().ok_or_else(|| self.expected("a table"))?;
        let names = || keys.iter().map(|key| key.name);
        let mut given: Vec<&str> = Vec::new();
        for (written, node) in entries {
            let mut value = self.within(&written, node);
            let key = keys.iter().find(|key| key.name == written).or_else(|| {
                let name = same_name(&written, names())?;
                keys.iter().find(|key| key.name == name)
            });
            let Some(key) = key else {
                let hint = match nearest_name(&written, names()) {
                    Some(name) => suggestion(Some(name)),
                    None => format!("; known are {}", names().collect::<Vec<_>>().join(", ")),
                };
                return Err(value.message(format_args!("there is no such key{hint}")));
            };
            if given.contains(&key.name) {
                return Err(value.message("the key is given twice"));
            }
            given.push(key.name);
            if key.name != written {
                let message = value.message(format_args!("the key is spelt {}", key.name));
                self.warnings.borrow_mut().push(Warning::new(message));
                value = self.within(key.name, node);
            }
            if !node.is_null() {
                (key.set)(target, &value)?;
            }
        }
        Ok(())
    }

    /// Materials by the names of those of the model.
    fn materials(&self, materials: &mut BTreeMap<String, MaterialSource>) -> Result<(), String> {
        for (name, node) in self.node.table().ok_or_else(|| self.expected("a table of materials"))? {
            let source = Material.read(&self.within(&name, node))?;
            materials.insert(name.into_owned(), source);
        }
        Ok(())
    }
}
