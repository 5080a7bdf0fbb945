//! Every bound on untrusted input and on work, in one table.

/// Bounds on what a file may ask for and on what a render may cost. All are inclusive: N is accepted, N + 1 is not.
///
/// The defaults suit a server that makes thumbnails of unknown files on a small machine.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Bytes of any one input file or buffer. Default 1 GiB.
    pub input_bytes: u64,
    /// Bytes that all buffers, images and meshes of a scene take once decoded. Default 1 GiB.
    pub decoded_bytes: u64,
    /// Triangles, every instance counted. Default 2^26.
    pub triangles: u64,
    /// Vertices over all meshes. A pose that a skin or morph targets make is a mesh of its own, and each target counts as its
    /// vertices once more. Default 2^26.
    pub vertices: u64,
    /// Nodes of the scene graph, and any other array of small objects in a file (materials, accessors...). Default 2^20.
    pub nodes: u64,
    /// Depth of the scene graph. Default 1024.
    pub depth: u64,
    /// Distinct textures. Default 4096.
    pub textures: u64,
    /// Pixels of one texture or environment. Default 2^26 (8192 x 8192).
    pub texture_pixels: u64,
    /// Pixels of all textures of a scene together, as they are kept: beyond, models' largest textures lose their finest mip levels.
    /// Files may store four times as many. Default 2^27.
    pub total_texture_pixels: u64,
    /// Lights of a scene: each of them shines on every fragment that it reaches. Default 256.
    pub lights: u64,
    /// Width and height of the output in pixels. Default [`Limits::LARGEST_OUTPUT_SIDE`].
    pub output_side: u32,
    /// Pixels of the output. Default 2^26.
    pub output_pixels: u64,
    /// Surface fragments that one frame shades. Default 2^30.
    pub fragments: u64,
    /// Shading of one frame, in units of about a nanosecond, for each pixel of the picture: the
    /// frame may take so many times the number of its pixels, or times 2^18 (512 x 512) if it has fewer; all of it for each
    /// shading a pixel. Beyond, lobes send fewer rays. Default 2^13.
    pub shading: u64,
    /// Blocks of 4 x 4 pixels that the triangles of one frame are drawn into, hidden ones included: the rasterizer's
    /// work. Depth maps of occluders count groups of sixteen triangles and of sixteen texels, apart from these.
    /// Default 2^27.
    pub blocks: u64,
    /// Fragments of blended surfaces in one frame, which are kept until their tile is done. Default 2^25.
    pub blend_entries: u64,
    /// Bytes that drawing one frame takes beside the scene and the picture: objects, vertices and triangles on the
    /// screen, the tiles' lists of them. Depth maps of occluders may take as many again. Default 512 MiB.
    pub frame_bytes: u64,
    /// Frames of one moving picture. Default 3600.
    pub frames: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            input_bytes: 1 << 30,
            decoded_bytes: 1 << 30,
            triangles: 1 << 26,
            vertices: 1 << 26,
            nodes: 1 << 20,
            depth: 1024,
            textures: 4096,
            texture_pixels: 1 << 26,
            total_texture_pixels: 1 << 27,
            lights: 256,
            output_side: Self::LARGEST_OUTPUT_SIDE,
            output_pixels: 1 << 26,
            fragments: 1 << 30,
            shading: 1 << 13,
            blocks: 1 << 27,
            blend_entries: 1 << 25,
            frame_bytes: 1 << 29,
            frames: 3600,
        }
    }
}

impl Limits {
    /// The same with another [`Limits::input_bytes`].
    #[must_use]
    pub fn with_input_bytes(self, input_bytes: u64) -> Self {
        Self { input_bytes, ..self }
    }

    /// The same with another [`Limits::decoded_bytes`].
    #[must_use]
    pub fn with_decoded_bytes(self, decoded_bytes: u64) -> Self {
        Self { decoded_bytes, ..self }
    }

    /// The same with another [`Limits::triangles`].
    #[must_use]
    pub fn with_triangles(self, triangles: u64) -> Self {
        Self { triangles, ..self }
    }

    /// The same with another [`Limits::vertices`].
    #[must_use]
    pub fn with_vertices(self, vertices: u64) -> Self {
        Self { vertices, ..self }
    }

    /// The same with another [`Limits::nodes`].
    #[must_use]
    pub fn with_nodes(self, nodes: u64) -> Self {
        Self { nodes, ..self }
    }

    /// The same with another [`Limits::depth`].
    #[must_use]
    pub fn with_depth(self, depth: u64) -> Self {
        Self { depth, ..self }
    }

    /// The same with another [`Limits::textures`].
    #[must_use]
    pub fn with_textures(self, textures: u64) -> Self {
        Self { textures, ..self }
    }

    /// The same with another [`Limits::texture_pixels`].
    #[must_use]
    pub fn with_texture_pixels(self, texture_pixels: u64) -> Self {
        Self { texture_pixels, ..self }
    }

    /// The same with another [`Limits::total_texture_pixels`].
    #[must_use]
    pub fn with_total_texture_pixels(self, total_texture_pixels: u64) -> Self {
        Self { total_texture_pixels, ..self }
    }

    /// The same with another [`Limits::lights`].
    #[must_use]
    pub fn with_lights(self, lights: u64) -> Self {
        Self { lights, ..self }
    }

    /// The same with another [`Limits::output_side`].
    #[must_use]
    pub fn with_output_side(self, output_side: u32) -> Self {
        Self { output_side, ..self }
    }

    /// The same with another [`Limits::output_pixels`].
    #[must_use]
    pub fn with_output_pixels(self, output_pixels: u64) -> Self {
        Self { output_pixels, ..self }
    }

    /// The same with another [`Limits::fragments`].
    #[must_use]
    pub fn with_fragments(self, fragments: u64) -> Self {
        Self { fragments, ..self }
    }

    /// The same with another [`Limits::shading`].
    #[must_use]
    pub fn with_shading(self, shading: u64) -> Self {
        Self { shading, ..self }
    }

    /// The same with another [`Limits::blocks`].
    #[must_use]
    pub fn with_blocks(self, blocks: u64) -> Self {
        Self { blocks, ..self }
    }

    /// The same with another [`Limits::blend_entries`].
    #[must_use]
    pub fn with_blend_entries(self, blend_entries: u64) -> Self {
        Self { blend_entries, ..self }
    }

    /// The same with another [`Limits::frame_bytes`].
    #[must_use]
    pub fn with_frame_bytes(self, frame_bytes: u64) -> Self {
        Self { frame_bytes, ..self }
    }

    /// The same with another [`Limits::frames`].
    #[must_use]
    pub fn with_frames(self, frames: u64) -> Self {
        Self { frames, ..self }
    }
}

/// The field of a [`LimitExceeded`] that is none of [`Limits`]: the system does not give so much memory.
pub const MEMORY: &str = "memory";

/// Bytes that stay free beside the amount asked for. More than the C library of Linux keeps for itself when it is
/// given back.
#[doc(hidden)]
pub const HEADROOM: u64 = 33 << 20;

/// Something asked for more than [`Limits`] allows.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub struct LimitExceeded {
    /// The element that asked, e.g. `accessor 3` or `image 'wood.png'`.
    pub what: String,
    /// Amount asked for; `None` if the work was stopped when it passed the limit.
    pub asked: Option<u64>,
    /// Amount allowed.
    pub limit: u64,
    /// Field of [`Limits`] with the limit.
    pub field: &'static str,
}

impl LimitExceeded {
    /// Error of work that was stopped when it passed the limit.
    #[must_use]
    #[doc(hidden)]
    pub fn beyond(what: &str, limit: u64, field: &'static str) -> Self {
        Self { what: what.to_owned(), asked: None, limit, field }
    }
}

impl std::fmt::Display for LimitExceeded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { what, asked, limit, field } = self;
        match asked {
            Some(asked) => write!(f, "{what}: {asked} exceeds the limit of {limit} ({field})"),
            None => write!(f, "{what}: more than the limit of {limit} ({field})"),
        }
    }
}

impl Limits {
    /// Upper bound of [`Limits::output_side`]: the rasterizer's fixed-point positions reach no further.
    pub const LARGEST_OUTPUT_SIDE: u32 = 16384;

    /// `Ok` if `asked` is at most `limit`.
    ///
    /// # Errors
    /// [`LimitExceeded`] naming the element and the field otherwise.
    #[doc(hidden)]
    pub fn check(
        what: impl FnOnce() -> String,
        asked: u64,
        limit: u64,
        field: &'static str,
    ) -> Result<(), LimitExceeded> {
        if asked <= limit {
            Ok(())
        } else {
            Err(LimitExceeded { what: what(), asked: Some(asked), limit, field })
        }
    }

    /// `Ok` if the system would give so many bytes, and [`HEADROOM`] besides: asked before they are used, because an
    /// allocation that fails ends the process. Where the system promises more than it has, as Linux does unless the
    /// process has a limit of its own, it always would.
    ///
    /// # Errors
    /// [`LimitExceeded`] naming the element, with [`MEMORY`] as the field, otherwise.
    #[doc(hidden)]
    pub fn check_memory(what: impl FnOnce() -> String, asked: u64) -> Result<(), LimitExceeded> {
        // Memory of WebAssembly never shrinks.
        if cfg!(target_family = "wasm") {
            return Ok(());
        }
        let mut probe = Vec::<u8>::new();
        let bytes = usize::try_from(asked.saturating_add(HEADROOM)).unwrap_or(usize::MAX);
        let given = probe.try_reserve_exact(bytes).is_ok();
        // What nobody looks at would not be asked for.
        std::hint::black_box(&probe);
        if given { Ok(()) } else { Err(LimitExceeded::beyond(&what(), 0, MEMORY)) }
    }
}
