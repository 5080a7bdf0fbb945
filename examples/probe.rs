use overcoat::{render::*, scene::*};
fn main() {
    let mut scene = Scene::new();
    let n = 64;
    let mut d = MeshData::default();
    for i in 0..=n {
        for j in 0..=2 * n {
            let (t, p) =
                (i as f64 / n as f64 * std::f64::consts::PI, j as f64 / n as f64 * std::f64::consts::PI);
            #[allow(clippy::disallowed_methods)]
            let v = [(t.sin() * p.cos()) as f32, t.cos() as f32, (t.sin() * p.sin()) as f32];
            d.positions.push(v);
            d.normals.push(v);
            d.uvs[0].push([j as f32 / n as f32, i as f32 / n as f32]);
        }
    }
    let w = 2 * n + 1;
    for i in 0..n {
        for j in 0..2 * n {
            let a = i * w + j;
            d.triangles.push([a, a + 1, a + w]);
            d.triangles.push([a + 1, a + w + 1, a + w]);
        }
    }
    let m = scene.add_material(Material { base_color: [0.8, 0.3, 0.2, 1.0], ..Default::default() }).unwrap();
    let mesh = scene.add_mesh(Mesh::new(d).unwrap()).unwrap();
    scene.add_instance(Instance { mesh, material: m, transform: Transform::IDENTITY, object: 0 }).unwrap();
    let camera = Framing::default().camera(&scene);
    let mut r = Renderer::new(0);
    let o = RenderOptions::default();
    for simd in overcoat::math::lanes::SimdLevel::available() {
        for (t, s) in [(1, 16), (2, 32), (3, 64)] {
            let mut r = Renderer::new(t);
            let x =
                r.render(&scene, &camera, &RenderOptions { simd, tile_size: Some(s), ..o.clone() }).unwrap();
            println!("{simd} {t} {s} {} {:?}", x.frame.frame_hash(), x.stats);
        }
    }
    let x = r.render(&scene, &camera, &o).unwrap();
    let f = std::fs::File::create("/tmp/probe/o.png").unwrap();
    let mut e = png::Encoder::new(f, o.width, o.height);
    e.set_color(png::ColorType::Rgba);
    e.set_depth(png::BitDepth::Eight);
    let b: Vec<u8> = x
        .frame
        .pixels
        .iter()
        .flat_map(|p| {
            let a = p[3];
            let q = |v: f32| ((v / a.max(1e-9)).clamp(0.0, 1.0).sqrt() * 255.0) as u8;
            [q(p[0]), q(p[1]), q(p[2]), (a * 255.0) as u8]
        })
        .collect();
    e.write_header().unwrap().write_image_data(&b).unwrap();
}
