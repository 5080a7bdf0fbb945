//! Prims of the stage as instances of a scene.

mod kinds;
mod tiles;

use super::FORMAT;
use super::compose::{Composed, Stage};
use super::layer::check_depth;
use super::look::{Look, Maker, Textures};
use super::mesh::{Geometry, Reads, display_color, element, of_shape, uv_name};
use super::{lights, shapes, xform};
use crate::mesh_formats::{add_placed, default_material, white_material};
use crate::text::quoted;
use crate::warnings::{Warnings, counted};
use crate::{LoadError, TextureLoading, udim};
use overcoat_core::limits::Limits;
use overcoat_scene::{AlphaMode, MaterialId, Mesh, MeshData, MeshId, PrimitiveKind, Scene, Transform};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Instances of instances of instances at most.
const NESTED: u64 = 32;

/// A mesh as it is cached: opinions on its prim, what its material reads, and the number of its part.
type MeshKey = (Vec<usize>, Reads, usize);

struct Builder<'c> {
    stage: Stage<'c>,
    loading: TextureLoading,
    is_z_up: bool,
    /// The environment is that of a dome light.
    has_dome: bool,
    scene: Scene,
    textures: Textures,
    /// By path; `None` for those without a surface that is known.
    looks: BTreeMap<String, Option<Look>>,
    /// By material and its variants.
    materials: BTreeMap<String, MaterialId>,
    /// `None` for meshes without triangles.
    meshes: BTreeMap<MeshKey, Option<MeshId>>,
    /// Meshes whose textures are in tiles, by these.
    tiled: BTreeMap<MeshKey, Vec<(u32, MeshId)>>,
    /// Materials of lines, by those that they are of.
    unlit: BTreeMap<MaterialId, MaterialId>,
    visits: u64,
    is_animated: bool,
    skipped: BTreeSet<String>,
}

/// State that prims have from those above.
#[derive(Clone)]
struct Inherited {
    transform: Transform,
    /// Path of the material.
    material: Option<String>,
    purpose: Option<String>,
    depth: u64,
    /// Instancers above.
    nested: u64,
}

/// Builds the scene of a stage.
pub(super) fn build(
    stage: Stage<'_>,
    unit: &Transform,
    is_z_up: bool,
    loading: TextureLoading,
) -> Result<(Scene, Warnings), LoadError> {
    let mut builder = Builder {
        stage,
        loading,
        is_z_up,
        has_dome: false,
        scene: Scene::new(),
        textures: Textures::default(),
        looks: BTreeMap::new(),
        materials: BTreeMap::new(),
        meshes: BTreeMap::new(),
        tiled: BTreeMap::new(),
        unlit: BTreeMap::new(),
        visits: 0,
        is_animated: false,
        skipped: BTreeSet::new(),
    };
    let root = builder.stage.root();
    let state = Inherited { transform: *unit, material: None, purpose: None, depth: 0, nested: 0 };
    for child in builder.stage.children(&root)? {
        builder.prim(&child, &state, unit)?;
    }
    let Builder { stage, scene, is_animated, skipped, .. } = builder;
    let mut warnings = stage.files.warnings;
    if !skipped.is_empty() {
        let names: Vec<&str> = skipped.iter().map(String::as_str).collect();
        let names = names.join(", ");
        warnings.add(|| format!("{FORMAT}: prims of these types have no effect: {names}"));
    }
    if is_animated {
        warnings.add(|| format!("{FORMAT}: animations have no effect: the first sample is drawn"));
    }
    Ok((scene, warnings))
}

impl Builder<'_> {
    /// Counts what is visited: instances can have instances.
    fn visit(&mut self, depth: u64) -> Result<(), LoadError> {
        self.visits = self.visits.saturating_add(1);
        let limits = self.stage.files.context.limits;
        check_depth("prims", depth, limits)?;
        Limits::check(|| format!("{FORMAT}: the number of prims"), self.visits, limits.nodes, "nodes")?;
        Ok(())
    }

    /// Draws a prim and those in it.
    fn prim(&mut self, prim: &Rc<Composed>, above: &Inherited, unit: &Transform) -> Result<(), LoadError> {
        self.visit(above.depth)?;
        if !prim.is_drawn() || prim.text("visibility").as_deref() == Some("invisible") {
            return Ok(());
        }
        let mut state = above.clone();
        state.depth = above.depth.saturating_add(1);
        if let Some(purpose) = prim.text("purpose").filter(|purpose| purpose != "default") {
            state.purpose = Some(purpose);
        }
        if matches!(state.purpose.as_deref(), Some("proxy" | "guide")) {
            return Ok(());
        }
        let moved = xform::local(prim).and_then(|(own, is_reset)| {
            if is_reset { unit.after(&own) } else { above.transform.after(&own) }
        });
        let Ok(transform) = moved else {
            let path = quoted(prim.path.as_bytes());
            self.stage.files.say(|| format!("{FORMAT}: prim {path}, which is moved too far, is left out"));
            return Ok(());
        };
        state.transform = transform;
        self.is_animated |= prim
            .property_names()
            .into_iter()
            .any(|name| (name.starts_with("xformOp:") || name == "points") && is_animated(prim, name));
        if let Some(material) = binding(prim) {
            state.material = Some(material);
        }
        let type_name = prim.type_name().to_owned();
        match type_name.as_str() {
            "Mesh" => self.mesh(prim, &state)?,
            "PointInstancer" => return self.instancer(prim, &state, unit),
            // Their own subtrees have no shapes.
            "Material" | "Shader" | "NodeGraph" | "GeomSubset" | "Skeleton" | "SkelAnimation" => {
                return Ok(());
            }
            "" | "Scope" | "Xform" | "SkelRoot" => {}
            "Points" => self.points(prim, &state)?,
            "BasisCurves" => self.curves(prim, &state)?,
            "Camera" => self.camera(prim, &state),
            name if lights::is_light(name) => self.light(prim, &state),
            name => match shapes::of(prim, name) {
                Some(shape) => self.shape(prim, shape, &state)?,
                None => {
                    if self.skipped.len() < 16 {
                        self.skipped.insert(quoted(name.as_bytes()));
                    }
                }
            },
        }
        for child in self.stage.children(prim)? {
            self.prim(&child, &state, unit)?;
        }
        Ok(())
    }

    fn shape(
        &mut self,
        prim: &Rc<Composed>,
        shape: shapes::Shape,
        state: &Inherited,
    ) -> Result<(), LoadError> {
        let (mut look, reads) = self.look(prim, state.material.as_deref())?;
        if let Some(path) = state.material.as_deref().filter(|_| self.is_tiled(look.as_deref())) {
            look = self.of_tile(path, udim::FIRST)?;
        }
        let material = self.material(look, prim, true)?;
        let key = (prim.identity(), reads.clone(), 0);
        let mesh = match self.meshes.get(&key) {
            Some(known) => *known,
            None => self.add_mesh(prim, key, of_shape(prim, shape, &reads))?,
        };
        self.place(prim, mesh, material, state)
    }

    fn place(
        &mut self,
        prim: &Composed,
        mesh: Option<MeshId>,
        material: MaterialId,
        state: &Inherited,
    ) -> Result<(), LoadError> {
        let Some(mesh) = mesh else { return Ok(()) };
        let object = self.scene.instances().len() as u32;
        add_placed(&mut self.scene, &element(prim), mesh, material, state.transform, object)?;
        self.scene.name_object(object, &prim.path);
        let limit = self.stage.files.context.limits.triangles;
        let count = self.scene.triangle_count();
        Limits::check(|| "the model's triangles".to_owned(), count, limit, "triangles")?;
        Ok(())
    }

    fn add_mesh(
        &mut self,
        prim: &Composed,
        key: MeshKey,
        data: MeshData,
    ) -> Result<Option<MeshId>, LoadError> {
        let is_cloud = data.kind == PrimitiveKind::Points && !data.positions.is_empty();
        let mesh = if data.triangles.is_empty() && !is_cloud {
            None
        } else {
            let size = (data.positions.len() as u64).saturating_mul(48);
            self.stage.files.budget.charge(|| element(prim), size, 1)?;
            let mesh = Mesh::new(data).map_err(LoadError::scene(element(prim)))?;
            Some(self.scene.add_mesh(mesh).map_err(LoadError::scene(element(prim)))?)
        };
        self.meshes.insert(key, mesh);
        Ok(mesh)
    }

    /// Draws a mesh by its parts: those of subsets with materials, and the rest.
    fn mesh(&mut self, prim: &Rc<Composed>, state: &Inherited) -> Result<(), LoadError> {
        let mut geometry = Geometry::read(prim);
        let mut parts: Vec<(Option<String>, Vec<i32>)> = Vec::new();
        for subset in self.stage.children(prim)? {
            let is_faces = subset.type_name() == "GeomSubset"
                && subset.text("elementType").is_none_or(|kind| kind == "face");
            if let Some(material) = binding(&subset).filter(|_| is_faces) {
                let indices = subset.value("indices").map(|v| v.ints().to_vec()).unwrap_or_default();
                parts.push((Some(material), indices));
            }
        }
        // Numbers of the parts that faces are in; 0 is the rest.
        let mut part_of = vec![0_u32; if parts.is_empty() { 0 } else { geometry.faces() }];
        for (number, (_, faces)) in parts.iter().enumerate() {
            for &face in faces {
                if let Some(slot) = usize::try_from(face).ok().and_then(|face| part_of.get_mut(face)) {
                    *slot = (number as u32).saturating_add(1);
                }
            }
        }
        let limit = self.stage.files.context.limits.nodes;
        let work = (parts.len() as u64).saturating_mul(geometry.faces() as u64) / 256;
        Limits::check(|| format!("{}: subsets by faces", element(prim)), work, limit, "nodes")?;
        if geometry.is_cage && !geometry.has_normals() {
            self.stage.files.say(|| format!("{FORMAT}: subdivision surfaces are drawn as their cages"));
        }
        if prim.property("skel:skeleton").is_some() || prim.property("primvars:skel:jointIndices").is_some() {
            self.stage.files.say(|| format!("{FORMAT}: skins are drawn at rest"));
        }
        let is_double = prim.value("doubleSided").is_some_and(|v| v.ints().first().is_some_and(|&v| v != 0));
        let all =
            std::iter::once(state.material.clone()).chain(parts.into_iter().map(|(material, _)| material));
        for (number, material) in all.enumerate() {
            let (look, reads) = self.look(prim, material.as_deref())?;
            let key = (prim.identity(), reads.clone(), number);
            if let Some(path) = material.as_deref().filter(|_| self.is_tiled(look.as_deref())) {
                let own = |face: usize| part_of.get(face).is_none_or(|&part| part as usize == number);
                let data = geometry.part(&reads, own, self.stage.files.context)?;
                self.tiles(prim, (key, data), path, is_double, state)?;
                continue;
            }
            let mesh = match self.meshes.get(&key) {
                Some(known) => *known,
                None => {
                    let own = |face: usize| part_of.get(face).is_none_or(|&part| part as usize == number);
                    let data = geometry.part(&reads, own, self.stage.files.context)?;
                    self.add_mesh(prim, key, data)?
                }
            };
            if mesh.is_some() {
                let material = self.material(look, prim, is_double)?;
                self.place(prim, mesh, material, state)?;
            }
        }
        if geometry.bad > 0 {
            let bad = counted(geometry.bad, "polygon");
            let element = element(prim);
            self.stage
                .files
                .say(|| format!("{element}: {bad} left out: vertices missing, not finite or beyond 1e15"));
        }
        Ok(())
    }

    /// Reads the material of a path under a name; of pictures in tiles the pictures of one of these.
    fn add_look(&mut self, name: &str, path: &str, tile: Option<u32>) -> Result<(), LoadError> {
        if self.looks.contains_key(name) {
            return Ok(());
        }
        let found = match self.stage.at(path)? {
            Some(of) => {
                let (stage, scene, textures) = (&mut self.stage, &mut self.scene, &mut self.textures);
                Maker::new(stage, scene, textures, self.loading).of_tile(tile).look(&of)?
            }
            None => {
                let path = quoted(path.as_bytes());
                self.stage.files.say(|| format!("{FORMAT}: there is no material {path}"));
                None
            }
        };
        self.looks.insert(name.to_owned(), found);
        Ok(())
    }

    /// The material of a path, and what a mesh has of what it reads.
    fn look(&mut self, prim: &Composed, path: Option<&str>) -> Result<(Option<String>, Reads), LoadError> {
        if let Some(path) = path {
            self.add_look(path, path, None)?;
        }
        let known = path.and_then(|path| Some((path, self.looks.get(path)?.as_ref()?)));
        let Some((path, look)) = known else {
            let (has_colors, _) = display_color(prim);
            let color = has_colors.then(|| "displayColor".to_owned());
            return Ok((None, Reads { color, ..Reads::default() }));
        };
        let mut reads = look.reads.clone();
        for name in reads.uvs.iter_mut().flatten() {
            if prim.value(&format!("primvars:{name}")).is_none()
                && let Some(other) = uv_name(prim)
            {
                *name = other;
            }
        }
        Ok((Some(path.to_owned()), reads))
    }

    /// The material of a look, or that of a prim without.
    fn material(
        &mut self,
        look: Option<String>,
        prim: &Composed,
        is_double: bool,
    ) -> Result<MaterialId, LoadError> {
        let (has_colors, is_translucent) = display_color(prim);
        let key = match &look {
            Some(path) => format!("{path} {is_double}"),
            None => format!(" {has_colors} {is_translucent}"),
        };
        if let Some(known) = self.materials.get(&key) {
            return Ok(*known);
        }
        let known = look.and_then(|path| self.looks.get(&path)?.as_ref());
        let material = match known {
            Some(look) => look.material.clone().with(|m| m.double_sided = is_double),
            None if has_colors => {
                let alpha_mode = if is_translucent { AlphaMode::Blend } else { AlphaMode::Opaque };
                white_material().with(|m| m.alpha_mode = alpha_mode)
            }
            None => default_material(),
        };
        let added = self.scene.add_material(material).map_err(LoadError::scene("USD: material"))?;
        self.materials.insert(key, added);
        Ok(added)
    }

    /// Draws the prototypes of an instancer at its points (UsdGeomPointInstancer).
    fn instancer(
        &mut self,
        prim: &Rc<Composed>,
        state: &Inherited,
        unit: &Transform,
    ) -> Result<(), LoadError> {
        if state.nested >= NESTED {
            self.stage.files.say(|| format!("{FORMAT}: instancers in too many others are left out"));
            return Ok(());
        }
        let targets = prim.property("prototypes").map(|found| found.targets).unwrap_or_default();
        let mut prototypes = Vec::new();
        for path in targets {
            prototypes.push(self.stage.at(&path)?);
        }
        let tuples = |name: &str| prim.value(name);
        let indices = tuples("protoIndices").map(|v| v.ints().to_vec()).unwrap_or_default();
        let positions: Vec<[f32; 3]> = tuples("positions").map(|v| v.tuples()).unwrap_or_default();
        let rotations: Vec<[f32; 4]> = tuples("orientations")
            .or_else(|| tuples("orientationsf"))
            .map(|v| v.tuples())
            .unwrap_or_default();
        let scales: Vec<[f32; 3]> = tuples("scales").map(|v| v.tuples()).unwrap_or_default();
        let ids = tuples("ids").map(|v| v.ints().to_vec()).unwrap_or_default();
        let hidden: BTreeSet<i32> =
            tuples("invisibleIds").map(|v| v.ints().iter().copied().collect()).unwrap_or_default();
        let mut inner = state.clone();
        inner.nested = state.nested.saturating_add(1);
        for (k, (&index, position)) in indices.iter().zip(positions).enumerate() {
            let id = ids.get(k).copied().unwrap_or(k as i32);
            let prototype = usize::try_from(index).ok().and_then(|index| prototypes.get(index)?.clone());
            let Some(prototype) = prototype.filter(|_| !hidden.contains(&id)) else { continue };
            let rotation = rotations.get(k).copied().unwrap_or([0.0, 0.0, 0.0, 1.0]).map(f64::from);
            let scale = scales.get(k).copied().unwrap_or([1.0; 3]).map(f64::from);
            let own = Transform::from_parts(position.map(f64::from), rotation, scale);
            let Ok(transform) = own.and_then(|own| state.transform.after(&own)) else { continue };
            inner.transform = transform;
            self.prim(&prototype, &inner, unit)?;
        }
        Ok(())
    }
}

/// The material that a prim is bound to, for pictures before all purposes.
fn binding(prim: &Composed) -> Option<String> {
    ["material:binding", "material:binding:preview", "material:binding:full"]
        .into_iter()
        .find_map(|name| prim.property(name)?.targets.into_iter().next())
}

fn is_animated(prim: &Composed, name: &str) -> bool {
    prim.property(name).is_some_and(|found| found.is_animated)
}
