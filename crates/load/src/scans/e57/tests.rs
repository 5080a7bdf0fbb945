//! Files that are written bit by bit, and read again.

use super::pages::checksum_of;
use crate::hostile::{attack, limits, load, load_beside, warnings};
use crate::{Format, Loaded, MemoryResolver};
use overcoat_core::color::srgb::srgb8_to_linear;
use overcoat_scene::Axis;

const PAGE: usize = 256;

/// A scan to be written: XML of its fields, bits of each, and the codes of its points.
struct Scan<'a> {
    xml: &'a str,
    bits: &'a [u32],
    points: Vec<Vec<u64>>,
    /// XML beside its points.
    more: &'a str,
    /// Points of a packet.
    packet: usize,
}

fn packed(bits: u32, codes: impl Iterator<Item = u64>) -> Vec<u8> {
    let (mut bytes, mut all, mut filled) = (Vec::new(), 0_u128, 0);
    for code in codes {
        all |= u128::from(code) << filled;
        filled += bits;
        while filled >= 8 {
            bytes.push(all as u8);
            all >>= 8;
            filled -= 8;
        }
    }
    if filled > 0 {
        bytes.push(all as u8);
    }
    bytes
}

/// Physical place of a logical one.
fn physical(place: usize) -> usize {
    place / (PAGE - 4) * PAGE + place % (PAGE - 4)
}

/// A section of points; its place is a multiple of four.
fn section(scan: &Scan<'_>, place: usize) -> Vec<u8> {
    let mut packets = Vec::new();
    // An empty packet, which says nothing.
    packets.extend([2, 0, 3, 0]);
    // Streams go on through packets, which have whole bytes of them.
    let all: Vec<Vec<u8>> = (scan.bits.iter().enumerate())
        .map(|(field, &bits)| packed(bits, scan.points.iter().map(|point| point[field])))
        .collect();
    for first in (0..scan.points.len()).step_by(scan.packet) {
        let after = first + scan.packet;
        let part = |(stream, &bits): (&Vec<u8>, &u32)| {
            let end = if after >= scan.points.len() { stream.len() } else { after * bits as usize / 8 };
            stream[first * bits as usize / 8..end].to_vec()
        };
        let streams: Vec<Vec<u8>> = all.iter().zip(scan.bits).map(part).collect();
        let mut packet = vec![1, 0, 0, 0];
        packet.extend((streams.len() as u16).to_le_bytes());
        streams.iter().for_each(|stream| packet.extend((stream.len() as u16).to_le_bytes()));
        streams.iter().for_each(|stream| packet.extend(stream));
        packet.resize(packet.len().next_multiple_of(4), 0);
        let length = packet.len() as u16 - 1;
        packet[2..4].copy_from_slice(&length.to_le_bytes());
        packets.extend(packet);
    }
    let mut bytes = vec![1, 0, 0, 0, 0, 0, 0, 0];
    bytes.extend((32 + packets.len() as u64).to_le_bytes());
    bytes.extend((physical(place + 32) as u64).to_le_bytes());
    bytes.extend([0; 8]);
    [bytes, packets].concat()
}

fn paged(content: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for page in content.chunks(PAGE - 4) {
        let mut page = page.to_vec();
        page.resize(PAGE - 4, 0);
        let sum = checksum_of(&page);
        bytes.extend([page, sum.to_be_bytes().to_vec()].concat());
    }
    bytes
}

fn file(scans: &[Scan<'_>], more: &str) -> Vec<u8> {
    let mut content = vec![0; 48];
    let mut xml = "<?xml version=\"1.0\"?><e57Root type=\"Structure\" xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\" \
                   xmlns:nor=\"n\"><data3D type=\"Vector\">"
        .to_owned();
    for scan in scans {
        let place = content.len();
        xml += &format!(
            "<vectorChild type=\"Structure\"><guid type=\"String\"><![CDATA[a]]></guid>{}\
             <points type=\"CompressedVector\" fileOffset=\"{}\" recordCount=\"{}\"><prototype type=\"Structure\">{}</prototype>\
             <codecs type=\"Vector\"/></points></vectorChild>",
            scan.more,
            physical(place),
            scan.points.len(),
            scan.xml
        );
        content.extend(section(scan, place));
    }
    xml += &format!("</data3D>{more}</e57Root>");
    let place = content.len();
    content.extend(xml.as_bytes());
    let mut header = b"ASTM-E57\x01\0\0\0\0\0\0\0".to_vec();
    let length = physical(content.len().next_multiple_of(PAGE - 4)) as u64;
    for number in [length, physical(place) as u64, xml.len() as u64, PAGE as u64] {
        header.extend(number.to_le_bytes());
    }
    content[..48].copy_from_slice(&header);
    paged(&content)
}

/// A point in coordinates of ten bits with a colour, and one that is not valid; turned by 90 degrees about z and moved.
fn cartesian() -> Scan<'static> {
    Scan {
        xml: "<cartesianX type=\"ScaledInteger\" minimum=\"-500\" maximum=\"500\" scale=\"0.01\" offset=\"1\"/>\
              <cartesianY type=\"ScaledInteger\" minimum=\"-500\" maximum=\"500\" scale=\"0.01\"/>\
              <cartesianZ type=\"Float\" precision=\"single\"/>\
              <colorRed type=\"Integer\" minimum=\"0\" maximum=\"255\"/><colorGreen type=\"Integer\" minimum=\"0\" maximum=\"255\"/>\
              <colorBlue type=\"Integer\" minimum=\"7\" maximum=\"7\"/>\
              <rowIndex type=\"Integer\" minimum=\"0\" maximum=\"3\"/>\
              <nor:normalX type=\"Float\" precision=\"single\"/><nor:normalY type=\"Float\" precision=\"single\"/>\
              <nor:normalZ type=\"Float\" precision=\"single\"/>\
              <isColorInvalid type=\"Integer\" minimum=\"0\" maximum=\"1\"/>\
              <cartesianInvalidState type=\"Integer\" minimum=\"0\" maximum=\"2\"/>",
        bits: &[10, 10, 32, 8, 8, 0, 2, 32, 32, 32, 1, 2],
        points: (0..40)
            .map(|k| {
                let [z, one] = [k as f32, 1.0].map(|v: f32| u64::from(v.to_bits()));
                let [red, invalid] = [200 + k, u64::from(k == 7)];
                vec![500 + k, 500, z, red, 0, 0, k % 4, one, 0, 0, u64::from(k == 3), 2 * invalid]
            })
            .collect(),
        more: "<pose type=\"Structure\"><rotation type=\"Structure\"><w type=\"Float\">2</w><x type=\"Float\"/>\
               <y type=\"Float\">0</y><z type=\"Float\">2</z></rotation><translation type=\"Structure\"><x>10</x>\
               <z>-1</z></translation></pose>",
        packet: 9,
    }
}

fn spherical() -> Scan<'static> {
    let turn = std::f64::consts::FRAC_PI_2;
    let point = |v: [f64; 3], intensity: f32, invalid: u64| {
        let [r, a, e] = v.map(f64::to_bits);
        vec![r, a, e, u64::from(intensity.to_bits()), invalid]
    };
    Scan {
        xml: "<sphericalRange type=\"Float\"/><sphericalAzimuth type=\"Float\" precision=\"double\"/>\
              <sphericalElevation type=\"Float\"/><intensity type=\"Float\" precision=\"single\"/>\
              <sphericalInvalidState type=\"Integer\" minimum=\"0\" maximum=\"2\"/>",
        bits: &[64, 64, 64, 32, 2],
        points: vec![
            point([2.0, 0.0, 0.0], 0.0, 0),
            point([2.0, turn, 0.0], 0.5, 0),
            point([2.0, 0.0, turn], 1.0, 0),
            point([9.0, 1.0, 1.0], 1.0, 1),
        ],
        more: "",
        packet: 3,
    }
}

fn near(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-5)
}

fn within(bytes: &[u8], vertices: u64) -> Loaded {
    let limits = limits().with_vertices(vertices);
    load_beside(bytes, Format::E57, &MemoryResolver::default(), &limits).unwrap()
}

#[test]
fn scans_stand_where_their_poses_put_them() {
    let images = "<images2D type=\"Vector\"><vectorChild type=\"Structure\"/></images2D>";
    let bytes = file(&[cartesian(), spherical()], images);
    assert_eq!(Format::detect(&bytes), Some(Format::E57));
    let loaded = load(&bytes, Format::E57).unwrap();
    assert_eq!(warnings(&loaded), ["E57: 1 picture left out"]);
    assert_eq!(loaded.scene.orientation().up, Axis::PositiveZ);
    let [colored, plain] = loaded.scene.meshes() else { panic!("{:?}", loaded.scene.meshes().len()) };
    assert_eq!(colored.positions().len(), 39);
    // x = 1, and a hundredth more for each point, becomes y.
    assert!(near(colored.positions()[0], [10.0, 1.0, -1.0]), "{:?}", colored.positions()[0]);
    assert!(near(colored.positions()[38], [10.0, 1.39, 38.0]), "{:?}", colored.positions()[38]);
    assert!(near(colored.normals()[5], [0.0, 1.0, 0.0]));
    let [r, b] = [202, 7].map(srgb8_to_linear);
    assert_eq!(colored.colors()[2], [r, srgb8_to_linear(0), b, 1.0]);
    assert!(colored.colors()[3][1] > 0.2, "the colour that is not known is grey");
    assert!(near(plain.positions()[0], [2.0, 0.0, 0.0]));
    assert!(near(plain.positions()[1], [0.0, 2.0, 0.0]));
    assert!(near(plain.positions()[2], [0.0, 0.0, 2.0]));
    assert!(plain.positions().len() == 3 && plain.colors()[2] == [1.0; 4] && plain.colors()[0][0] < 0.1);
}

#[test]
fn more_points_than_the_limits_allow_are_thinned() {
    let bytes = file(&[cartesian()], "");
    let loaded = within(&bytes, 40);
    assert_eq!(warnings(&loaded), ["E57: of 40 points one in 2 is drawn: the limits allow no more"]);
    // The eighth is not valid, and every other is skipped, across packets.
    let ys: Vec<f32> = loaded.scene.meshes()[0].positions().iter().map(|p| p[2] + 1.0).collect();
    assert_eq!(ys, (0..20).map(|k| 2.0 * k as f32).collect::<Vec<_>>());
    assert_eq!(within(&bytes, 2).scene.meshes()[0].positions().len(), 1);
}

#[test]
fn damage_is_named() {
    let good = file(&[cartesian()], "");
    let mut bytes = good.clone();
    bytes[300] ^= 1;
    assert_eq!(
        warnings(&load(&bytes, Format::E57).unwrap()),
        ["E57: 1 page with a wrong checksum: points may be wrong"]
    );
    let error = load(&good[..good.len() - 2 * PAGE], Format::E57).unwrap_err().to_string();
    assert!(error.contains("the file ends before its XML section does"), "{error}");
    let text = |from: &str, to: &str| {
        let mut scan = cartesian();
        let xml = scan.xml.replace(from, to);
        scan.xml = &xml;
        load(&file(&[scan], ""), Format::E57)
    };
    let error = text("\"single\"/><colorRed", "\"half\"/><colorRed").unwrap_err().to_string();
    assert!(error.contains("field 'cartesianZ' has a type or range that is not known"), "{error}");
    let loaded = text("cartesianZ", "depth").unwrap();
    assert_eq!(warnings(&loaded)[0], "E57: scan 1 left out: it has no positions");
    // One field more than the packets have.
    let error = text("<rowIndex", "<las:a type=\"Integer\"/><rowIndex").unwrap_err().to_string();
    assert!(error.contains("scan 1: the streams of a packet are not within it"), "{error}");
    let mut scan = cartesian();
    scan.points.truncate(20);
    let mut bytes = file(&[scan], "");
    let place = bytes.windows(16).position(|w| w == b"recordCount=\"20\"").unwrap();
    bytes[place + 13] = b'9';
    let loaded = load(&bytes, Format::E57).unwrap();
    assert_eq!(warnings(&loaded)[1], "E57: scan 1 ends after 20 of 90 points: its section ends");
}

#[test]
fn colors_have_the_range_that_the_file_says() {
    let mut scan = cartesian();
    scan.more = "<colorLimits type=\"Structure\"><colorRedMaximum type=\"Integer\">1023</colorRedMaximum></colorLimits>";
    let xml = scan.xml.replace("minimum=\"0\" maximum=\"255\"", "minimum=\"0\" maximum=\"1023\"");
    scan.xml = &xml;
    let bits = [10, 10, 32, 10, 10, 0, 2, 32, 32, 32, 1, 2];
    scan.bits = &bits;
    scan.points.iter_mut().for_each(|point| point[3] = 1023);
    let loaded = load(&file(&[scan], ""), Format::E57).unwrap();
    assert_eq!(loaded.scene.meshes()[0].colors()[0][0], 1.0);
}

#[test]
fn hostile_files_end_in_a_scene_or_a_message() {
    attack(&file(&[cartesian(), spherical()], ""), Format::E57);
    attack(&file(&[spherical()], "<images2D/>"), Format::E57);
}
