//! Scenes of several tiles as one.

use super::FORMAT;
use super::instances::IDENTITY;
use crate::{LoadError, Warning};
use overcoat_core::limits::Limits;
use overcoat_scene::{Instance, Scene, SplatInstance, Transform, settle};

/// Most warnings of all tiles together.
const WARNINGS: usize = 100;

/// A scene that grows by tiles; +Y is up.
#[derive(Default)]
pub(super) struct Assembly {
    pub(super) scene: Scene,
    pub(super) warnings: Vec<Warning>,
    /// Point that coordinates are relative to: the place of the first tile.
    origin: Option<[f64; 3]>,
    /// Number of the next object.
    objects: u32,
    /// Vertices of all meshes, and triangles of all instances.
    vertices: u64,
    triangles: u64,
}

impl Assembly {
    /// Limits of the next tile: what the others have left.
    pub(super) fn left(&self, limits: &Limits) -> Limits {
        let texels = self.scene.textures().iter().map(|texture| {
            let [width, height] = [texture.width(), texture.height()].map(u64::from);
            width.saturating_mul(height)
        });
        let texels = texels.fold(0, u64::saturating_add);
        let bytes = self.vertices.saturating_mul(64).saturating_add(texels.saturating_mul(6));
        limits
            .clone()
            .with_triangles(limits.triangles.saturating_sub(self.triangles))
            .with_vertices(limits.vertices.saturating_sub(self.vertices))
            .with_total_texture_pixels(limits.total_texture_pixels.saturating_sub(texels))
            .with_decoded_bytes(limits.decoded_bytes.saturating_sub(bytes))
    }

    /// Adds warnings of a tile, each once.
    pub(super) fn warn(&mut self, warnings: impl IntoIterator<Item = Warning>) {
        for warning in warnings {
            if self.warnings.len() < WARNINGS && !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
    }

    /// Adds a scene at each of some places, which are relative to a point.
    pub(super) fn add(
        &mut self,
        part: &Scene,
        places: &[Transform],
        at: [f64; 3],
        limits: &Limits,
    ) -> Result<(), LoadError> {
        let failed = || LoadError::scene(format!("{FORMAT}: a tile"));
        let count = (places.len() as u64).saturating_mul(part.instances().len() as u64);
        let all = (self.scene.instances().len() as u64).saturating_add(count);
        Limits::check(|| format!("{FORMAT}: the number of instances"), all, limits.nodes, "nodes")?;
        let own = part.triangle_count().saturating_mul(places.len() as u64);
        self.triangles = self.triangles.saturating_add(own);
        let what = || format!("{FORMAT}: the triangles of all instances");
        Limits::check(what, self.triangles, limits.triangles, "triangles")?;
        let vertices = part.meshes().iter().map(|mesh| mesh.positions().len() as u64).sum::<u64>();
        self.vertices = self.vertices.saturating_add(vertices);
        let what = || format!("{FORMAT}: the vertices of all tiles");
        Limits::check(what, self.vertices, limits.vertices, "vertices")?;

        let scene = &mut self.scene;
        let add = |texture: &overcoat_scene::Texture| scene.add_texture(texture.clone()).map_err(failed());
        let textures = part.textures().iter().map(add).collect::<Result<Vec<_>, _>>()?;
        let mut materials = Vec::with_capacity(part.materials().len());
        for material in part.materials() {
            let mut material = material.clone();
            settle(&mut material, &|id| textures.get(id.index()).copied());
            materials.push(scene.add_material(material).map_err(failed())?);
        }
        let add = |mesh: &overcoat_scene::Mesh| scene.add_mesh(mesh.clone()).map_err(failed());
        let meshes = part.meshes().iter().map(add).collect::<Result<Vec<_>, _>>()?;
        let add = |cloud: &overcoat_scene::SplatCloud| scene.add_splats(cloud.clone()).map_err(failed());
        let clouds = part.splats().iter().map(add).collect::<Result<Vec<_>, _>>()?;

        let inner = Transform::translation(part.origin()).map_err(failed())?;
        let origin = *self.origin.get_or_insert_with(|| sum(at, part.origin()));
        let outer = Transform::translation(difference(at, origin)).map_err(failed())?;
        let objects = part.instances().iter().map(|instance| instance.object);
        let objects = objects.chain(part.splat_instances().iter().map(|instance| instance.object));
        let objects = objects.max().map_or(0, |last| last.saturating_add(1));
        for place in places {
            let moved = |own: &Transform| outer.after(place)?.after(&inner)?.after(own);
            for instance in part.instances() {
                let (mesh, material) =
                    (meshes.get(instance.mesh.index()), materials.get(instance.material.index()));
                let (Some(&mesh), Some(&material)) = (mesh, material) else { continue };
                let transform = moved(&instance.transform).map_err(failed())?;
                let object = self.objects.saturating_add(instance.object);
                let instance = Instance::new(mesh, material, transform).with_object(object);
                scene.add_instance(instance).map_err(failed())?;
            }
            for instance in part.splat_instances() {
                let Some(&cloud) = clouds.get(instance.cloud.index()) else { continue };
                let transform = moved(&instance.transform).map_err(failed())?;
                let object = self.objects.saturating_add(instance.object);
                let instance = SplatInstance::new(cloud, transform).with_object(object);
                scene.add_splat_instance(instance).map_err(failed())?;
            }
            self.objects = self.objects.saturating_add(objects);
        }
        scene.set_origin(origin);
        Ok(())
    }
}

fn sum([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [a + x, b + y, c + z]
}

fn difference([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [a - x, b - y, c - z]
}

/// A point of a tile, of which +Z is up, in axes of which +Y is up.
pub(super) fn upright([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, z, -y]
}

/// A map of axes of which +Z is up as one of those of which +Y is up: of what is in the former, or in the latter if it is
/// `turned` before, as models in tiles are.
pub(super) fn upright_map(map: &Transform, turned: bool) -> Result<Transform, LoadError> {
    let failed = || LoadError::scene(format!("{FORMAT}: an instance"));
    let [x, y, z] = IDENTITY;
    let row = |[a, b, c]: [f64; 3], sign: f64| [sign * a, sign * b, sign * c, 0.0];
    let up = Transform::from_rows([row(x, 1.0), row(z, 1.0), row(y, -1.0)]).map_err(failed())?;
    let down = Transform::from_rows([row(x, 1.0), row(z, -1.0), row(y, 1.0)]).map_err(failed())?;
    let map = up.after(map).map_err(failed())?;
    if turned { map.after(&down).map_err(failed()) } else { Ok(map) }
}
