//! Occluders of a scene.

use super::blockers::{Blockers, Cutout, Masked};
use super::repeated::Repeated;
use super::slab::List;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_scene::{AlphaMode, Instance, Material, Mesh, PrimitiveKind, Scene, Texture, Wrap};
use std::collections::BTreeMap;

/// Most texels of a cutout are the square of this; of a larger texture, a smaller mip level is taken. The texels of a depth
/// map are far coarser.
const CUTOUT_SIDE: u32 = 1024;

/// Bytes that copies of meshes that stand at several places take at most. Without copies, bringing corners to their places
/// takes longer than drawing 48 maps of 96 x 96 texels.
const COPIES: u64 = 1 << 23;

/// Part of [`Limits::frame_bytes`] that they take at most.
const PART_OF_COPIES: u64 = 16;

/// Corners that are placed by one thread.
const POSITIONS_PER_JOB: usize = 1 << 13;

/// Occlusion by the triangles of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blocking {
    /// Not at all.
    Nothing,
    /// Everywhere.
    Solid,
    /// Only where alpha reaches the cutoff.
    Masked,
}

/// The instances whose triangles block light, for depth maps and for rays: their numbers among all of a scene, and how. What
/// is blended or transmits light does not block any, nor do lines, points, splats and what cannot be seen.
pub fn blocking_draws(scene: &Scene) -> impl Iterator<Item = (u32, &Instance, Blocking)> {
    let draws = scene.seen_draws().map(|(draw, instance)| (draw, instance, of_instance(scene, instance)));
    draws.filter(|(_, _, blocking)| *blocking != Blocking::Nothing)
}

impl Blockers {
    /// The triangles of all instances that block light ([`blocking_draws`]), from the sides that a camera would see them from
    /// (fronts alone unless the material is double-sided), where they are: opaque ones everywhere, alpha-masked ones where
    /// their alpha (base colour's, texture's by the nearest texel, vertices') reaches the cutoff.
    /// Unfinished once the work is cancelled.
    ///
    /// # Errors
    /// [`LimitExceeded`] if they would take more than [`Limits::frame_bytes`].
    pub fn of_scene(scene: &Scene, limits: &Limits, jobs: &Jobs) -> Result<Self, LimitExceeded> {
        Self::with_copies(scene, limits, jobs, COPIES.min(limits.frame_bytes / PART_OF_COPIES))
    }

    /// [`Blockers::of_scene`] with copies of meshes that stand at several places, up to so many bytes.
    pub(super) fn with_copies(
        scene: &Scene,
        limits: &Limits,
        jobs: &Jobs,
        copies: u64,
    ) -> Result<Self, LimitExceeded> {
        let instances: Vec<(&Instance, Kind)> = blocking_draws(scene)
            .map(|(_, instance, blocking)| (instance, Kind::of(scene, instance, blocking)))
            .collect();
        let places = Places::of(scene, instances.iter().map(|(_, kind)| *kind), copies);
        let mut out = Self::default();
        out.reserve(scene, &places, limits)?;
        let mut cutouts = Cutouts::of(scene);
        let mut numbers: BTreeMap<Kind, usize> = BTreeMap::new();
        for (instance, kind) in instances {
            if jobs.is_cancelled() {
                break;
            }
            if places.get(&kind).is_some_and(|places| places.are_copied) {
                out.add(scene, (instance, kind), &mut cutouts, jobs);
                continue;
            }
            let number = *numbers.entry(kind).or_insert_with(|| {
                let repeated = out.repeat(scene, kind, &mut cutouts);
                out.repeated.push(repeated);
                out.repeated.len() - 1
            });
            out.repeated[number].add(instance.transform);
        }
        Ok(out)
    }

    /// Adds the triangles of a mesh at one place.
    fn add(
        &mut self,
        scene: &Scene,
        (instance, kind): (&Instance, Kind),
        cutouts: &mut Cutouts,
        jobs: &Jobs,
    ) {
        let mesh = &scene.meshes()[kind.mesh];
        let first = self.place(instance, mesh, jobs);
        let triangles = || kind.triangles(mesh).map(|triangle| triangle.map(|vertex| vertex + first));
        match kind.list {
            List::Solid => self.triangles.extend(triangles()),
            List::OneSided => self.one_sided.extend(triangles()),
            List::Masked => {
                let material = &scene.materials()[kind.material];
                let cutout = cutouts.number(scene, kind.material, &mut self.cutouts);
                let masked =
                    kind.triangles(mesh).map(|triangle| masked(mesh, material, &triangle, first, cutout));
                self.masked.extend(masked);
            }
        }
    }

    /// A mesh that stands at several places, at none of them yet.
    fn repeat(&mut self, scene: &Scene, kind: Kind, cutouts: &mut Cutouts) -> Repeated {
        let mesh = &scene.meshes()[kind.mesh];
        let repeated = Repeated::new(mesh, kind.list, kind.is_turned);
        if kind.list != List::Masked {
            return repeated;
        }
        let material = &scene.materials()[kind.material];
        let cutout = cutouts.number(scene, kind.material, &mut self.cutouts);
        let holes = kind.triangles(mesh).map(|triangle| masked(mesh, material, &triangle, 0, cutout));
        repeated.with_holes(holes.collect())
    }

    /// Makes room for what blocks of meshes at so many places.
    fn reserve(
        &mut self,
        scene: &Scene,
        places: &BTreeMap<Kind, Places>,
        limits: &Limits,
    ) -> Result<(), LimitExceeded> {
        let what = || "triangles that block light".to_owned();
        let (mut positions, mut solid, mut one_sided) = (0_usize, 0_usize, 0_usize);
        let (mut masked, mut cutouts) = (0_usize, 0_usize);
        let mut repeated = 0_u64;
        let mut has_cutout = vec![false; scene.materials().len()];
        for (kind, &Places { count: places, are_copied }) in places {
            let mesh = &scene.meshes()[kind.mesh];
            let triangles = mesh.triangles().len();
            if kind.list == List::Masked {
                cutouts += usize::from(!has_cutout[kind.material]);
                has_cutout[kind.material] = true;
            }
            if !are_copied {
                let holes = if kind.list == List::Masked { triangles } else { 0 };
                repeated = repeated.saturating_add(Repeated::bytes_of(mesh, places, holes));
                continue;
            }
            positions = positions.saturating_add(mesh.positions().len().saturating_mul(places));
            let count = match kind.list {
                List::Solid => &mut solid,
                List::OneSided => &mut one_sided,
                List::Masked => &mut masked,
            };
            *count = count.saturating_add(triangles.saturating_mul(places));
        }
        let parts = [
            (positions, size_of::<[f32; 3]>()),
            (solid.saturating_add(one_sided), size_of::<[u32; 3]>()),
            (masked, size_of::<Masked>()),
            (cutouts, (CUTOUT_SIDE as usize).pow(2)),
        ];
        let bytes = parts.iter().fold(0_usize, |sum, (n, size)| sum.saturating_add(n.saturating_mul(*size)));
        let bytes = repeated.saturating_add(bytes as u64);
        Limits::check(what, bytes, limits.frame_bytes, "frame_bytes")?;
        Limits::check(what, positions as u64, u64::from(u32::MAX), "vertices")?;
        Limits::check_memory(what, bytes)?;
        self.positions.reserve_exact(positions);
        self.triangles.reserve_exact(solid);
        self.one_sided.reserve_exact(one_sided);
        self.masked.reserve_exact(masked);
        Ok(())
    }

    /// Adds an instance's vertices, those that no triangle uses as no numbers, and says where they begin.
    fn place(&mut self, instance: &Instance, mesh: &Mesh, jobs: &Jobs) -> u32 {
        let first = self.positions.len();
        let vertices = mesh.positions();
        self.positions.resize(first + vertices.len(), [f32::NAN; 3]);
        let used = mesh.used_vertices();
        jobs.for_each_chunk_mut(&mut self.positions[first..], POSITIONS_PER_JOB, |job, places| {
            let start = job * POSITIONS_PER_JOB;
            for (k, (place, vertex)) in places.iter_mut().zip(&vertices[start..]).enumerate() {
                if used.as_ref().is_none_or(|used| used[start + k]) {
                    *place = instance.transform.point(vertex.map(f64::from)).map(|c| c as f32);
                }
            }
        });
        first as u32
    }
}

/// Triangles that may be kept once for all instances that have them: those of a mesh that block light alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    mesh: usize,
    list: List,
    /// Index of the material with the holes; 0 of what has none.
    material: usize,
    /// Corners change their order, to be counter-clockwise in the scene where that matters.
    is_turned: bool,
}

/// Places of the triangles of one kind.
#[derive(Clone, Copy, Debug, Default)]
struct Places {
    count: usize,
    /// Each has triangles of its own.
    are_copied: bool,
}

impl Places {
    /// Places of all kinds. Kinds with several are copied, in their order, while the copies take no more than so many bytes.
    fn of(scene: &Scene, kinds: impl Iterator<Item = Kind>, copies: u64) -> BTreeMap<Kind, Self> {
        let mut all: BTreeMap<Kind, Self> = BTreeMap::new();
        kinds.for_each(|kind| all.entry(kind).or_default().count += 1);
        let mut left = copies;
        for (kind, places) in &mut all {
            let bytes =
                if places.count == 1 { 0 } else { kind.bytes(scene).saturating_mul(places.count as u64) };
            places.are_copied = bytes <= left;
            left -= if places.are_copied { bytes } else { 0 };
        }
        all
    }
}

impl Kind {
    /// Bytes of one copy.
    fn bytes(self, scene: &Scene) -> u64 {
        let mesh = &scene.meshes()[self.mesh];
        let triangle = if self.list == List::Masked { size_of::<Masked>() } else { size_of::<[u32; 3]>() };
        mesh.positions().len() as u64 * size_of::<[f32; 3]>() as u64
            + mesh.triangles().len() as u64 * triangle as u64
    }

    fn of(scene: &Scene, instance: &Instance, blocking: Blocking) -> Self {
        let number = instance.material.index();
        let two_sided = scene.materials()[number].double_sided;
        let (list, material) = match blocking {
            Blocking::Solid if two_sided => (List::Solid, 0),
            Blocking::Solid => (List::OneSided, 0),
            _ => (List::Masked, number),
        };
        let is_turned = !two_sided && instance.transform.determinant() < 0.0;
        Self { mesh: instance.mesh.index(), list, material, is_turned }
    }

    /// The triangles of the mesh in that order.
    fn triangles(self, mesh: &Mesh) -> impl Iterator<Item = [u32; 3]> {
        mesh.triangles().iter().map(move |&[a, b, c]| if self.is_turned { [a, c, b] } else { [a, b, c] })
    }
}

/// Numbers of the cutouts of materials, once they have been made.
struct Cutouts(Vec<Option<u32>>);

impl Cutouts {
    fn of(scene: &Scene) -> Self {
        Self(vec![None; scene.materials().len()])
    }

    fn number(&mut self, scene: &Scene, material: usize, cutouts: &mut Vec<Cutout>) -> u32 {
        *self.0[material].get_or_insert_with(|| {
            cutouts.push(cutout_of(scene, &scene.materials()[material]));
            cutouts.len() as u32 - 1
        })
    }
}

/// Occlusion by the triangles of an instance, from its material and the kind of its mesh.
fn of_instance(scene: &Scene, instance: &Instance) -> Blocking {
    let mesh = &scene.meshes()[instance.mesh.index()];
    let material = &scene.materials()[instance.material.index()];
    if material.is_transmissive() || mesh.kind() != PrimitiveKind::Triangles {
        return Blocking::Nothing;
    }
    match material.alpha_mode {
        AlphaMode::Opaque => Blocking::Solid,
        AlphaMode::Blend => Blocking::Nothing,
        AlphaMode::Mask { cutoff } => {
            let texture = material.base_color_texture.map(|t| &scene.textures()[t.texture.index()]);
            let whole = texture.is_none_or(Texture::is_opaque) && mesh.colors().is_empty();
            let present = material.base_color[3] >= cutoff;
            match (whole, present) {
                (true, true) => Blocking::Solid,
                (true, false) => Blocking::Nothing,
                (false, _) => Blocking::Masked,
            }
        }
    }
}

/// Alpha mask of a material's triangles.
fn cutout_of(scene: &Scene, material: &Material) -> Cutout {
    let cutoff = if let AlphaMode::Mask { cutoff } = material.alpha_mode { cutoff } else { 0.0 };
    let Some(reference) = &material.base_color_texture else {
        return Cutout { size: [1; 2], alphas: vec![255], wrap: [Wrap::Repeat; 2], cutoff };
    };
    let texture = &scene.textures()[reference.texture.index()];
    let sampler = texture.sampler();
    let wrap = [sampler.wrap_u, sampler.wrap_v];
    let (size, texels) = small_level(texture, CUTOUT_SIDE);
    Cutout { size, alphas: texels.iter().map(|texel| texel[3]).collect(), wrap, cutoff }
}

/// Size and texels of the largest level of a texture that has no more texels than a square of this side.
pub(super) fn small_level(texture: &Texture, side: u32) -> ([usize; 2], Vec<[u8; 4]>) {
    let small = texture.levels().find(|level| level.texels.len() <= (side as usize).pow(2));
    if let Some(level) = small {
        return ([level.width as usize, level.height as usize], level.texels.to_vec());
    }
    // Without smaller levels, some of its texels.
    let image = texture.image();
    let whole = [image.width(), image.height()];
    let size = whole.map(|n| n.min(side));
    let at = |k: u32, axis: usize| (u64::from(k) * u64::from(whole[axis]) / u64::from(size[axis])) as u32;
    let texels = (0..size[1])
        .flat_map(|row| (0..size[0]).map(move |column| (column, row)))
        .map(|(column, row)| image.texel(at(column, 0), at(row, 1)).unwrap_or_default())
        .collect();
    (size.map(|n| n as usize), texels)
}

/// One triangle with holes, whose mesh's vertices begin at `first`.
fn masked(mesh: &Mesh, material: &Material, triangle: &[u32; 3], first: u32, cutout: u32) -> Masked {
    let place = |vertex: u32| {
        let Some(reference) = &material.base_color_texture else { return [0.0; 2] };
        let uvs = mesh.uvs(usize::from(reference.uv_set));
        let [u, v] = uvs.get(vertex as usize).copied().unwrap_or([0.0; 2]);
        reference.transform.rows.map(|row| (row[0] * u + row[1] * v) + row[2])
    };
    let alpha = |vertex: u32| {
        let own = mesh.colors().get(vertex as usize).map_or(1.0, |color| color[3]);
        own * material.base_color[3]
    };
    let (corners, two_sided) = (triangle.map(|vertex| vertex + first), material.double_sided);
    Masked { corners, two_sided, uvs: triangle.map(place), alphas: triangle.map(alpha), cutout }
}
