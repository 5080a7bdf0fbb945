//! Contents of a file: materials, meshes and their placement.

use glam::DVec3;

use super::mesh::Mesh;

/// A square picture, also of data such as normals.
#[derive(Clone, Debug)]
pub struct Image {
    /// Pixels a side.
    pub size: u32,
    /// sRGB for colours, linear for data; rows from the top.
    pub pixels: Vec<[u8; 3]>,
}

impl Image {
    /// Calls `pixel` for the centre (u, v) of every pixel.
    pub fn draw(size: u32, pixel: impl Fn(f64, f64) -> [u8; 3]) -> Self {
        let centre = |i: u32| (f64::from(i) + 0.5) / f64::from(size);
        let pixels = (0..size * size).map(|i| pixel(centre(i % size), centre(i / size))).collect::<Vec<_>>();
        Self { size, pixels }
    }

    /// The bytes of a PNG file.
    pub fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size, self.size);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.set_filter(png::Filter::Adaptive);
        let flat: Vec<u8> = self.pixels.iter().flatten().copied().collect();
        let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&flat));
        written.expect("writing to memory succeeds");
        bytes
    }
}

/// Transparency of a material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Alpha {
    /// None.
    #[default]
    Opaque,
    /// Blended by the colour's alpha.
    Blend,
}

/// A glTF material; maps are names of textures.
#[derive(Clone, Debug)]
pub struct Material {
    /// Unique in its model.
    pub name: &'static str,
    /// Linear base colour and alpha.
    pub color: [f64; 4],
    /// 0 or 1, or between for flakes.
    pub metallic: f64,
    /// Perceptual roughness.
    pub roughness: f64,
    /// Strength of the dielectric reflection, 1 for an ordinary surface.
    pub specular: f64,
    /// Strength of the clear coat.
    pub coat: f64,
    /// Perceptual roughness of the coat.
    pub coat_roughness: f64,
    /// True if the coat darkens the base by what it reflects back to it, as lacquer does.
    pub coat_darkens: bool,
    /// Emitted linear radiance.
    pub emissive: [f64; 3],
    /// sRGB.
    pub color_map: Option<&'static str>,
    /// Roughness in green, metallic in blue.
    pub roughness_map: Option<&'static str>,
    /// Tangent space, +Y up.
    pub normal_map: Option<&'static str>,
    /// Multiplies x and y of the normal map.
    pub normal_scale: f64,
    /// Normals of the coat.
    pub coat_normal_map: Option<&'static str>,
    /// Roughness of the coat in green.
    pub coat_roughness_map: Option<&'static str>,
    /// Transparency.
    pub alpha: Alpha,
    /// Drawn from both sides.
    pub double_sided: bool,
}

impl Material {
    /// An uncoated material of one colour.
    pub fn plain(name: &'static str, color: [f64; 3], metallic: f64, roughness: f64) -> Self {
        Self {
            name,
            color: [color[0], color[1], color[2], 1.0],
            metallic,
            roughness,
            specular: 1.0,
            coat: 0.0,
            coat_roughness: 0.0,
            coat_darkens: false,
            emissive: [0.0; 3],
            color_map: None,
            roughness_map: None,
            normal_map: None,
            normal_scale: 1.0,
            coat_normal_map: None,
            coat_roughness_map: None,
            alpha: Alpha::Opaque,
            double_sided: false,
        }
    }

    /// With a clear coat.
    pub fn coated(self, roughness: f64) -> Self {
        Self { coat: 1.0, coat_roughness: roughness, ..self }
    }

    /// True if meshes of this material need texture coordinates.
    pub fn is_textured(&self) -> bool {
        [self.color_map, self.roughness_map, self.normal_map, self.coat_normal_map, self.coat_roughness_map]
            .iter()
            .any(Option::is_some)
    }
}

/// A named group of (material, triangles).
#[derive(Clone, Debug)]
pub struct Group {
    /// For people who open the file.
    pub name: &'static str,
    /// Material index and triangles.
    pub parts: Vec<(usize, Mesh)>,
}

/// A placed group.
#[derive(Clone, Debug)]
pub struct Node {
    /// For people who open the file.
    pub name: &'static str,
    /// Index of the group.
    pub mesh: usize,
    /// Position of its origin, in metres.
    pub position: DVec3,
    /// Turned half around the y axis.
    pub turned: bool,
}

/// Everything of one file.
#[derive(Clone, Debug)]
pub struct Model {
    /// Also the file's stem.
    pub name: &'static str,
    /// Materials that the groups refer to.
    pub materials: Vec<Material>,
    /// Geometry.
    pub meshes: Vec<Group>,
    /// Placements.
    pub nodes: Vec<Node>,
}

impl Model {
    /// A model of one group at the origin; empty parts are left out.
    pub fn single(name: &'static str, materials: Vec<Material>, parts: Vec<(usize, Mesh)>) -> Self {
        let mut model = Self { name, materials, meshes: Vec::new(), nodes: Vec::new() };
        let mesh = model.group(name, parts);
        model.place(name, mesh, DVec3::ZERO, false);
        model
    }

    /// Adds a group and returns its index; parts of one material become one, empty ones are left out.
    pub fn group(&mut self, name: &'static str, parts: Vec<(usize, Mesh)>) -> usize {
        let mut joined: Vec<(usize, Mesh)> = Vec::new();
        for (material, part) in parts {
            if part.triangles.is_empty() {
                continue;
            }
            match joined.iter_mut().find(|(m, _)| *m == material) {
                Some((_, mesh)) => mesh.append(&part),
                None => joined.push((material, part)),
            }
        }
        self.meshes.push(Group { name, parts: joined });
        self.meshes.len() - 1
    }

    /// Places a group.
    pub fn place(&mut self, name: &'static str, mesh: usize, position: DVec3, turned: bool) {
        self.nodes.push(Node { name, mesh, position, turned });
    }

    /// Every part in its place: (material, triangles).
    pub fn flattened(&self) -> Vec<(usize, Mesh)> {
        let mut parts = Vec::new();
        for node in &self.nodes {
            for (material, mesh) in &self.meshes[node.mesh].parts {
                let mut mesh = mesh.clone();
                for vertex in &mut mesh.vertices {
                    if node.turned {
                        let half_turn = DVec3::new(-1.0, 1.0, -1.0);
                        vertex.position *= half_turn;
                        vertex.normal *= half_turn;
                    }
                    vertex.position += node.position;
                }
                parts.push((*material, mesh));
            }
        }
        parts
    }

    /// Triangles drawn, instances counted each time.
    pub fn triangle_count(&self) -> usize {
        let group = |i: usize| self.meshes[i].parts.iter().map(|(_, m)| m.triangles.len()).sum::<usize>();
        self.nodes.iter().map(|n| group(n.mesh)).sum()
    }
}
