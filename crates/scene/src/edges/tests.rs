//! Feature edges of solids, soups, sheets and of what files should not hold.

use super::*;

type Point = [f32; 3];

fn edges_of(positions: Vec<Point>, triangles: Vec<[u32; 3]>) -> FeatureEdges {
    let mesh = Mesh::new(MeshData { positions, triangles, ..MeshData::default() }).unwrap();
    find_edges(&mesh, &Jobs::new(1))
}

/// Every triangle with vertices of its own.
fn soup(positions: &[Point], triangles: &[[u32; 3]]) -> FeatureEdges {
    let corners = triangles.iter().flatten().map(|&v| positions[v as usize]).collect();
    edges_of(corners, (0..triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect())
}

/// The ends of lines, whatever their order.
fn places(lines: &EdgeLines) -> Vec<[Point; 2]> {
    let order = |a: &Point, b: &Point| a.partial_cmp(b).unwrap();
    let ends = |&[a, b, _]: &[u32; 3]| {
        let mut ends = [a, b].map(|v| lines.mesh.positions()[v as usize]);
        ends.sort_by(order);
        ends
    };
    let mut places: Vec<_> = lines.mesh.triangles().iter().map(ends).collect();
    places.sort_by(|a, b| a.partial_cmp(b).unwrap());
    places
}

/// A cube from 0 to 1: corner k has the bits of k as coordinates.
fn cube() -> (Vec<Point>, Vec<[u32; 3]>) {
    let corners = (0..8_u32).map(|k| [0, 1, 2].map(|axis| (k >> axis & 1) as f32)).collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (corners, faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// A solid of revolution about z, closed at both ends: radius and height of each ring.
fn turned(rings: &[[f32; 2]], sides: u32) -> (Vec<Point>, Vec<[u32; 3]>) {
    let mut positions = Vec::new();
    for [radius, height] in rings {
        for k in 0..sides {
            let angle = f64::from(k) / f64::from(sides) * std::f64::consts::TAU;
            let (sin, cos) = overcoat_core::math::double::sin_cos(angle);
            positions.push([radius * cos as f32, radius * sin as f32, *height]);
        }
    }
    let mut triangles = Vec::new();
    for ring in 0..rings.len() as u32 - 1 {
        for k in 0..sides {
            let at = |ring: u32, k: u32| ring * sides + k % sides;
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (positions, triangles)
}

fn cylinder(sides: u32) -> (Vec<Point>, Vec<[u32; 3]>) {
    turned(&[[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]], sides)
}

fn ball(sides: u32, noise: f32) -> (Vec<Point>, Vec<[u32; 3]>) {
    let ring = |k: u32| {
        let (sin, cos) =
            overcoat_core::math::double::sin_cos(f64::from(k) / f64::from(sides) * std::f64::consts::PI);
        [sin as f32, -cos as f32]
    };
    let (mut positions, triangles) = turned(&(0..=sides).map(ring).collect::<Vec<_>>(), sides);
    let mut state = 1_u32;
    for v in positions.as_flattened_mut() {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        *v += noise * ((state >> 8) as f32 / (1 << 24) as f32 - 0.5);
    }
    (positions, triangles)
}

#[test]
fn a_cube_has_its_twelve_edges_welded_or_not() {
    let (positions, triangles) = cube();
    let (whole, apart) = (edges_of(positions.clone(), triangles.clone()), soup(&positions, &triangles));
    let found = places(&whole.creases);
    assert_eq!(found.len(), 12);
    for [a, b] in &found {
        assert_eq!((0..3).filter(|&axis| a[axis] != b[axis]).count(), 1, "no diagonal");
    }
    assert_eq!(found, places(&apart.creases));
    for edges in [&whole, &apart] {
        assert!(edges.boundary.group_of.is_empty() && edges.is_of_part);
        assert_eq!((edges.creases.groups.len(), edges.creases.normals.len()), (1, 12));
        assert_eq!(edges.creases.groups[0], EdgeGroup { center: [0.5; 3], extent: 1.0 });
    }
}

#[test]
fn faces_that_are_inside_out_change_no_line() {
    let (positions, mut triangles) = cube();
    for triangle in triangles.iter_mut().step_by(3) {
        triangle.swap(0, 1);
    }
    let edges = edges_of(positions, triangles);
    assert_eq!(places(&edges.creases).len(), 12);
    assert!(edges.creases.normals.is_empty(), "nobody knows which side is outside");
}

#[test]
fn of_a_cylinder_the_rims_and_of_a_ball_nothing() {
    for sides in [12, 96] {
        let (positions, triangles) = cylinder(sides);
        let edges = soup(&positions, &triangles);
        let found = places(&edges.creases);
        assert_eq!(found.len(), 2 * sides as usize);
        assert!(found.iter().all(|[a, b]| a[2] == b[2]), "no line along the side");
        assert_eq!(edges.creases.groups.len(), 2);
        assert!(edges.is_of_part, "{sides}");
    }
    let (positions, triangles) = ball(64, 0.0);
    assert!(soup(&positions, &triangles).creases.group_of.is_empty());
    // Some of the edges of a large mesh tell as much.
    let part_of = |(positions, triangles): (Vec<Point>, Vec<[u32; 3]>)| {
        Mesh::new(MeshData { positions, triangles, ..MeshData::default() }).unwrap().may_be_part()
    };
    let step = |k: u32| [0, 1].map(|end| [(1 + k % 2) as f32, (k + end) as f32]);
    assert!(part_of(turned(&(0..400).flat_map(step).collect::<Vec<_>>(), 96)));
    assert!(!part_of(ball(256, 0.01)));
    // Few sides make sharp angles, and noise does: neither is a part.
    for (sides, noise) in [(8, 0.0), (64, 0.03)] {
        let (positions, triangles) = ball(sides, noise);
        let edges = soup(&positions, &triangles);
        assert!(!edges.is_of_part, "{sides} {noise}");
    }
}

#[test]
fn a_sheet_has_a_boundary_also_if_it_is_doubled() {
    let square = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let sheet = edges_of(square.clone(), vec![[0, 1, 2], [0, 2, 3]]);
    assert_eq!((places(&sheet.boundary).len(), places(&sheet.creases).len()), (4, 0));
    // Front and back: its border is a sharp edge, its diagonal of four faces none.
    let doubled = edges_of(square, vec![[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]]);
    assert_eq!((places(&doubled.boundary).len(), places(&doubled.creases).len()), (0, 4));
}

#[test]
fn faces_without_area_and_slivers_are_left_out() {
    let (mut positions, mut triangles) = cube();
    positions.extend([[0.5, 0.0, -0.0], [0.5, 1e-9, 0.0]]);
    triangles.extend([[0, 0, 1], [3, 3, 3], [0, 1, 8], [0, 9, 1]]);
    let edges = edges_of(positions, triangles);
    assert_eq!((places(&edges.creases).len(), edges.boundary.group_of.len()), (12, 0));
}

/// Parallel ridges: their density is the reciprocal of their distance, beyond one for each of sixteen cells.
#[test]
fn densities_count_lines_side_by_side() {
    let density = |count: u32| {
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for k in 0..=2 * count {
            let [y, z] = [k as f32 / (2 * count) as f32, 0.275 * (k % 2) as f32 / count as f32];
            positions.extend([[0.0, y, z], [1.0, y, z]]);
            if k > 0 {
                let v = 2 * k;
                triangles.extend([[v - 2, v - 1, v + 1], [v - 2, v + 1, v]]);
            }
        }
        let found = edges_of(positions, triangles).creases.densities;
        found.iter().sum::<f32>() / found.len() as f32
    };
    for count in [16, 32, 64] {
        let (all, found) = (2.0 * count as f32, density(count));
        assert!((found - (all - 16.0)).abs() < 0.15 * all, "{all} {found}");
    }
    let (positions, triangles) = cube();
    assert_eq!(edges_of(positions, triangles).creases.densities, [0.0; 12]);
}

#[test]
fn a_hundred_thousand_faces_at_one_edge_are_one_crease() {
    const COUNT: u32 = 100_000;
    let mut positions = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    positions.extend((0..COUNT).map(|k| [1.0, k as f32 / COUNT as f32, 0.5]));
    let triangles: Vec<_> = (2..COUNT + 2).map(|k| [0, 1, k]).collect();
    let edges = edges_of(positions.clone(), triangles.clone());
    assert_eq!(places(&edges.creases), [[positions[0], positions[1]]]);
    assert!(!edges.is_of_part);
    assert_eq!(places(&soup(&positions, &triangles).creases).len(), 1);
}

/// Positions that all fall into one bucket cost a sort and not a square.
#[test]
fn a_million_facets_and_a_point_that_all_share() {
    const COUNT: u32 = 1_000_000;
    let place = |k: u32| [(k % 1000) as f32, (k / 1000) as f32, 0.0];
    let corners: Vec<Point> = (0..COUNT)
        .flat_map(|k| {
            let [x, y, z] = place(k);
            [[x, y, z], [x + 1.0, y, z], [500.5, 500.5, 9.0]]
        })
        .collect();
    let triangles = (0..COUNT).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let edges = edges_of(corners, triangles);
    assert!(edges.creases.group_of.len() + edges.boundary.group_of.len() > 1_000_000);
}
