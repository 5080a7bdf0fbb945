//! Measured BRDFs of few angles: the file of MERL and the tensor file of the RGL.

/// Name and bytes of each.
pub fn all() -> Vec<(&'static str, Vec<u8>)> {
    vec![("merl", merl()), ("rgl", rgl())]
}

/// Two angles of each kind; one cell was not measured.
fn merl() -> Vec<u8> {
    let mut bytes: Vec<u8> = [2_i32; 3].into_iter().flat_map(i32::to_le_bytes).collect();
    for cell in 0..24 {
        let value = if cell == 7 { -1.0 } else { 100.0 / (1.0 + f64::from(cell % 8)) };
        bytes.extend(value.to_le_bytes());
    }
    bytes
}

/// A tensor file of tables of 2 x 2, seen from two angles.
fn rgl() -> Vec<u8> {
    let table = |count: usize| -> Vec<f32> { (0..count).map(|k| 1.0 + 0.25 * (k % 4) as f32).collect() };
    let fields: [(&str, &[u64], Vec<f32>); 7] = [
        ("phi_i", &[1], vec![0.0]),
        ("theta_i", &[2], vec![0.0, 1.5]),
        ("ndf", &[2, 2], table(4)),
        ("sigma", &[2, 2], table(4)),
        ("vndf", &[1, 2, 2, 2], table(8)),
        ("luminance", &[1, 2, 2, 2], table(8)),
        ("rgb", &[1, 2, 3, 2, 2], table(24)),
    ];
    let description = b"a seed";
    let head_of = |name: &str, rank: usize| 2 + name.len() + 2 + 1 + 8 + 8 * rank;
    let heads: usize = fields.iter().map(|(name, shape, _)| head_of(name, shape.len())).sum();
    let mut place = 12 + 2 + 4 + heads + head_of("description", 1) + head_of("jacobian", 1);
    let (mut head, mut body) = (b"tensor_file\0\x01\x00\x09\x00\x00\x00".to_vec(), Vec::new());
    let mut add = |name: &str, kind: u8, shape: &[u64], bytes: &[u8]| {
        head.extend((name.len() as u16).to_le_bytes());
        head.extend(name.as_bytes());
        head.extend((shape.len() as u16).to_le_bytes());
        head.push(kind);
        head.extend((place as u64).to_le_bytes());
        head.extend(shape.iter().flat_map(|length| length.to_le_bytes()));
        body.extend(bytes);
        place += bytes.len();
    };
    add("description", 1, &[description.len() as u64], description);
    add("jacobian", 1, &[1], &[1]);
    for (name, shape, values) in fields {
        add(name, 10, shape, &super::floats(&values));
    }
    [head, body].concat()
}
