//! overcoat renders meshes to pictures on machines that have only a processor: no GPU, no display, no driver, no
//! network; and gives the same bytes on every machine.
//!
//! Data flows one way:
//!
//! ```text
//! bytes --load--> Scene --geometry--> triangles --tile--> bins --raster--> visible samples
//!       --gbuffer--> surface fragments --shade--> radiance --render--> Frame --output--> files
//! ```
//!
//! [`load`] turns files into a [`Scene`], which is valid by construction, so that no later stage can meet malformed
//! input; all it reads goes through one [`load::Resolver`] and all it counts is held against [`Limits`]. A scene can
//! be built by hand just as well, see [`scene`].
//!
//! [`Renderer::render`] takes a scene, a [`scene::Camera`] (for example from [`scene::Framing`]) and
//! [`RenderOptions`], and runs the stages over square tiles in parallel: `geometry` transforms, clips and snaps
//! triangles to a fixed-point grid, `raster` finds which sample sees which triangle, `gbuffer` makes of them
//! fragments, sixteen at a time, `shade` evaluates the material models of `coat` under the lights of `light`. Out
//! comes a [`Frame`] of linear light; [`Frame::frame_hash`] names its bits. [`Renderer::render_image`] makes a picture for
//! screens tile by tile, with four bytes a pixel in place of twenty.
//!
//! The formulas of the models, and where engines differ, are on a page of their own: [`guide::clear_coat`].
//!
//! Whole programs, from a file to pixels and from nothing to a scene, are on a page: [`guide::library`].
//!
//! Applications that draw the same things again and again keep them in a [`world::World`], whose parts have names that stay, and
//! draw them through a [`viewport::Viewport`] into the memory of a window.
//!
//! [`output`] makes files of it, [`golden`] compares them, and [`decode`] reads them again. [`description`] reads a whole
//! picture, with camera, lights and options, from a scene file, and the program `overcoat` is a command line over all of it.
//!
//! [`truth`] measures what the models are an approximation of: random walks through stacks of coats, without a renderer.
//!
//! [`sandbox`] gives up what none of this needs from the system, before the first byte of input is read.
//!
//! The same bits everywhere come from `math`: shading is written over lanes, whose operations IEEE
//! 754 rounds exactly, and [`jobs`] keeps the order of results independent of threads. How each layer keeps them, how a
//! change breaks them, and which releases may change pictures is on a page: [`guide::bit_identity`].
//!
//! The stages and the formulas are packages of their own (`overcoat-stages`, `overcoat-shading`, `overcoat-core`), open to this
//! project's tests, benches and fuzz targets: they are not part of the promise, and change in any release.
//!
//! ```
//! use overcoat::scene::{Framing, Instance, Material, Mesh, MeshData, Transform};
//! use overcoat::{RenderOptions, Renderer, Scene};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut scene = Scene::new();
//! let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let mesh = scene.add_mesh(Mesh::new(MeshData::new(positions, vec![[0, 1, 2]]))?)?;
//! let mut paint = Material::default();
//! paint.base_color = [0.8, 0.1, 0.1, 1.0];
//! paint.coat = 1.0;
//! let material = scene.add_material(paint)?;
//! scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY))?;
//!
//! let camera = Framing::default().camera(&scene);
//! let options = RenderOptions::new(64, 64);
//! let rendered = Renderer::new(1).render(&scene, &camera, &options)?;
//! assert!(rendered.frame.pixels.iter().any(|pixel| pixel[3] == 1.0));
//! # Ok(())
//! # }
//! ```

#[cfg(feature = "cache")]
pub mod cache;
pub mod guide;
pub mod viewport;
pub mod world;

/// Transfer functions and tone curves.
pub mod color {
    #[doc(inline)]
    pub use overcoat_core::color::{ToneCurve, UnknownToneCurve, hex_color, srgb};
}

/// Encoded pictures to numbers: what textures, environments and pictures to compare are read with. Whatever a file says, its
/// claims are checked against [`Limits`] before anything of that size is allocated, and nothing panics.
pub mod decode {
    #[doc(inline)]
    pub use overcoat_image::decode::{
        DecodeError, DecodedPicture, ExrPlane, ExrSamples, FORMATS, FrameTime, Motion, MotionFrame,
        SampleKind, extensions, read_display_image,
    };
}

/// The description of a picture: what it shows, from where, in which light, how large. A typed `Description`, and the scene
/// files that it is read from, JSON or TOML with the same keys.
#[cfg(feature = "description")]
pub mod description {
    #[doc(inline)]
    pub use overcoat_description::{
        BackgroundChoice, CameraDescription, Description, DescriptionError, EnvironmentChoice,
        ExposureChoice, LightDescription, Machine, MaterialChoice, MaterialSource, Materials, Picture,
        Setting, ViewDirection, cone_cosine, scene_schema,
    };
}

/// Formats of files: their names, extensions and media types.
pub mod formats {
    #[doc(inline)]
    pub use overcoat_core::formats::{
        APNG, BMP, EXR, FileFormat, GIF, GLB, GLTF, HDR, JPEG, KTX2, OBJ, PLY, PNG, PNM, QOI, STL, TGA,
        THREE_MF, TIFF, WEBP,
    };
}

/// Frames: pixel planes in linear light, and pictures for screens made of them.
pub mod frame {
    #[doc(inline)]
    pub use overcoat_core::frame::{
        Aov, AovPlane, Clipping, DisplayImage, DisplayOptions, Frame, Meter, PixelFormat, PlaneSample, Target,
    };
}

/// Golden pictures: what a renderer drew once, was looked at, and must draw again. For any project: nothing here knows
/// how pictures are made.
#[cfg(feature = "golden")]
pub mod golden {
    #[doc(inline)]
    pub use overcoat_golden::{DescribedGolden, Golden, GoldenError, GoldenFolder};

    /// Two pictures compared.
    pub mod check {
        #[doc(inline)]
        pub use overcoat_golden::check::{FileResult, Verdict, compare_all_frames, compare_pictures};
    }

    /// Distances between two pictures.
    pub mod metrics {
        #[doc(inline)]
        pub use overcoat_golden::metrics::exact::ExactDifference;
        #[doc(inline)]
        pub use overcoat_golden::metrics::{Measured, MetricSettings, Metrics, measure};
    }

    /// Limits on the distance between two pictures, by file name.
    pub mod thresholds {
        #[doc(inline)]
        pub use overcoat_golden::thresholds::{Preset, ThresholdFile, ThresholdProblem, Thresholds};
    }
}

/// Worker threads: ordered parallel map and for-each over fixed chunks.
pub mod jobs {
    #[doc(inline)]
    pub use overcoat_core::jobs::{Jobs, MAX_THREADS};
}

/// Error of the clear coats of engines: the same coated surface by a shading model and by the referee.
#[cfg(feature = "truth")]
pub mod lab {
    #[doc(inline)]
    pub use overcoat_lab::lab::{
        Base, Bench, CONFIDENCE_95, Distance, Fit, LabError, Light, Measured, MeasuredBrdf, MeasuredError,
        ModelError, OVERHEAD, Progressive, Quantity, Referee, Residual, Row, Slice, Specimen, StandardErrors,
        Summary, Translation, Translator, luminance,
    };
}

/// Every bound on untrusted input and on work, in one table.
pub mod limits {
    #[doc(inline)]
    pub use overcoat_core::limits::{LimitExceeded, Limits, MEMORY};
}

/// Bytes to scenes. Every reference to another file goes through one `Resolver`, every count through
/// [`Limits`]. `load` ends where `scene` begins: what comes out is valid.
pub mod load {
    #[doc(inline)]
    pub use overcoat_load::{
        AnimatedModel, AnimationChoice, AnimationInfo, Context, DirectoryResolver, ENVIRONMENT_FORMATS,
        Format, LoadError, LoadOptions, Loaded, LoadedEnvironment, MemoryResolver, NamedEnvironment,
        NoResolver, Plate, ResolveError, Resolver, TEXTURE_FORMATS, TextureLoading, Warning,
        add_smooth_normals, add_tangents, environment, load_bytes, load_bytes_with, load_environment,
        load_environment_file, load_file, load_file_with, model, model_from_memory,
    };
    #[cfg(feature = "description")]
    #[doc(inline)]
    pub use overcoat_load::{
        AssignError, BuiltinMaterial, GivenPictures, MaterialError, MaterialErrorReason, MaterialFile,
        MaterialKey, MaterialValueKind, material_keys, material_value,
    };
}

/// Encoders: from a [`Frame`] to the bytes of a file.
pub mod output {
    #[doc(inline)]
    pub use overcoat_image::output::{
        DEFAULT_JPEG_QUALITY, ExrPrecision, MovieFormat, MovieFrame, OutputError, OutputFormat,
        OutputOptions, TerminalFormat, durations, encode, encode_aov_png, encode_exr, encode_hdr,
        encode_image, encode_jpeg, encode_movie, encode_png, encode_png_rgb, encode_terminal, encode_webp,
        write_atomically,
    };
}

/// The renderer: scene and options in, frame out.
pub mod render {
    #[doc(inline)]
    pub use overcoat_render::{
        Annotation, Background, Cancellation, Edges, EnvironmentStore, Ground, Hit, Quality, ReducedLight,
        RenderError, RenderOptions, RenderStats, Rendered, RenderedImage, RenderedInto, Renderer,
        RendererBuilder, StageHashes, Unseen, Visibility, WorkDone, names_of_ids, optical_flow,
    };
}

/// Giving up rights before input is read: what a program that has been taken over by a hostile file could still do.
#[cfg(feature = "sandbox")]
pub mod sandbox {
    #[doc(inline)]
    pub use overcoat_sandbox::{Grants, Sandbox, SandboxError, enter};
}

/// The resolved scene: what is to be drawn, valid by construction.
pub mod scene {
    #[doc(inline)]
    pub use overcoat_scene::{
        AlphaMode, AlphaUse, Anisotropy, AreaLightMethod, Axis, BabylonOptions, Bounds, Camera,
        CameraMatrices, CoatMedium, CoatSurface, ColorParameter, ColorSpace, Crowd, DualNormalFix,
        Environment, EnvironmentSource, EquirectImage, Filament2018Options, FilamentOptions, Filter, Fit,
        Flakes, Framing, GltfOptions, Image, Instance, Intrinsics, Iridescence, LEAST_SPLAT_OPACITY, Light,
        LightKind, Lobes, MAX_COORDINATE, MAX_SPLAT_SCALE, MAX_VERTICES, Material, MaterialId, Mesh,
        MeshData, MeshId, MipFilter, MipLevel, ModelOptions, NormalTexture, OcclusionCone, OpenPbrOptions,
        Orientation, Pose, PoseConvention, PrimitiveKind, Projection, ReflectionOcclusion, Sampler,
        ScalarParameter, Scene, SceneError, SecondLobe, ShadingModel, Sheen, SpecularOcclusionMethod, Splat,
        SplatCloud, SplatCloudBuilder, SplatCloudId, SplatColorSpace, SplatInstance, SplatOrder,
        StackLitOptions, Subsurface, Surfels, Texture, TextureId, TextureRef, ThreeOptions, Transform,
        Transmission, UvTransform, Workflow, Wrap, primitives,
    };
}

/// The referee: what a stack of coats really does, by a random walk through it that is right on average.
#[cfg(feature = "truth")]
pub mod truth {
    #[doc(inline)]
    pub use overcoat_lab::truth::{
        Albedo, CHUNK, Estimate, Evaluation, Interface, Layer, MAX_INTERFACES, Masking, Medium, Outcome,
        Sample, Samples, Stack, StackBuilder, StackError,
    };
}

pub use frame::Frame;
pub use limits::Limits;
pub use overcoat_core::math::lanes::{SimdLevel, UnknownLevel};
pub use render::{RenderOptions, Renderer};
pub use scene::Scene;
