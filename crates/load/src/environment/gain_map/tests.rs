use super::*;
use overcoat_core::color::srgb::srgb8_to_linear;
use overcoat_core::frame::DisplayImage;
use overcoat_image::output::encode_jpeg;

/// A JPEG of one grey.
fn grey(code: u8, width: u32, height: u32) -> Vec<u8> {
    let pixels = vec![[code, code, code, 255]; (width * height) as usize];
    encode_jpeg(&DisplayImage { width, height, pixels }, 100).unwrap()
}

/// A JPEG with a further segment.
fn with_segment(jpeg: &[u8], marker: u8, payload: &[&[u8]]) -> Vec<u8> {
    let payload = payload.concat();
    let length = (payload.len() as u16 + 2).to_be_bytes();
    [&jpeg[..2], &[0xff, marker], &length, &payload, &jpeg[2..]].concat()
}

fn with_xmp(jpeg: &[u8], attributes: &str, elements: &str) -> Vec<u8> {
    let text = format!(
        "<x:xmpmeta xmlns:x='adobe:ns:meta/'><rdf:RDF xmlns:rdf='http://www.w3.org/1999/02/22-rdf-syntax-ns#'><rdf:Description \
         rdf:about=\"\" xmlns:hdrgm=\"{NAMESPACE}\" hdrgm:Version=\"1.0\" {attributes}>{elements}</rdf:Description></rdf:RDF></x:xmpmeta>"
    );
    with_segment(jpeg, 0xe1, &[XMP, text.as_bytes()])
}

/// Metadata of ISO 21496-1 as libultrahdr writes it: numerators over 64.
fn iso(flags: u8, words: &[i32]) -> Vec<u8> {
    let words = words.iter().flat_map(|word| word.to_be_bytes());
    [0, 0, 0, 0, flags].into_iter().chain(words).collect()
}

/// Light of the pictures of a file, and whether its gain map is used.
fn light_of(file: &[u8], width: u32, height: u32) -> (Vec<[f32; 3]>, Option<Result<(), String>>) {
    let mut light = vec![[0.25, 0.5, 1.0]; (width * height) as usize];
    let done = apply(file, (width, height), &mut light, &Limits::default());
    (light, done)
}

/// Light that the specification gives for 0.25, 0.5 and 1.
fn expected(power: [f32; 3], before: f32, after: f32) -> [f32; 3] {
    [0, 1, 2].map(|k| ([0.25, 0.5, 1.0][k] + before) * exp2(power[k]) - after)
}

fn is_near(found: [f32; 3], expected: [f32; 3]) {
    assert!(
        found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 2e-6 * b.abs()),
        "{found:?}, {expected:?}"
    );
}

#[test]
fn gains_are_those_of_the_specification() {
    let first = with_xmp(&grey(128, 8, 4), "", "");
    // A quarter of the map's range: 51 of 255 is a fifth.
    let map = grey(51, 4, 2);
    let fifth = 0.2;
    let defaults = with_xmp(&map, "hdrgm:GainMapMax=\"3\" hdrgm:HDRCapacityMax=\"3\"", "");
    let (light, done) = light_of(&[first.clone(), defaults].concat(), 8, 4);
    assert_eq!(done, Some(Ok(())));
    light.iter().for_each(|pixel| is_near(*pixel, expected([3.0 * fifth; 3], 1.0 / 64.0, 1.0 / 64.0)));

    let elements = "<hdrgm:GainMapMax><rdf:Seq><rdf:li>1</rdf:li> <rdf:li>2</rdf:li><rdf:li>3</rdf:li></rdf:Seq></hdrgm:GainMapMax>\
                    <hdrgm:Gamma>\n2\n</hdrgm:Gamma>";
    let each =
        with_xmp(&map, "hdrgm:GainMapMin='-1' hdrgm:OffsetSDR = \"0.5\" hdrgm:OffsetHDR=\"0.25\"", elements);
    let (light, done) = light_of(&[first.clone(), each].concat(), 8, 4);
    assert_eq!(done, Some(Ok(())));
    let root = fifth.sqrt();
    let power = [1.0, 2.0, 3.0].map(|most| most * root - (1.0 - root));
    is_near(light[31], expected(power, 0.5, 0.25));

    // One channel with a common denominator; three, each with its own; another version.
    let one = iso(8, &[64, 0, 192, -64, 128, 64, 1, 2]);
    let mut words = vec![0, 1, 3, 1];
    for most in [1, 2, 3] {
        words.extend([-2, 2, most * 5, 5, 1, 1, 1, 64, 1, 64]);
    }
    let three = iso(0x80, &words);
    for (metadata, most, after) in [(&one, [2.0; 3], 2.0 / 64.0), (&three, [1.0, 2.0, 3.0], 1.0 / 64.0)] {
        let second = with_segment(&map, 0xe2, &[ISO, metadata]);
        let (light, done) = light_of(&[grey(128, 8, 4), second].concat(), 8, 4);
        assert_eq!(done, Some(Ok(())));
        is_near(light[5], expected(most.map(|most| -0.8 + most * fifth), 1.0 / 64.0, after));
    }
}

#[test]
fn maps_are_stretched_by_bilinear_weights() {
    assert_eq!(places(4, 2), [[0.0, 1.0, 0.0], [0.0, 1.0, 0.25], [0.0, 1.0, 0.75], [1.0, 1.0, 0.0]]);
    assert_eq!(places(1, 4), [[1.0, 2.0, 0.5]]);
    let texels = [0.0, 255.0].map(|v| [v, v, v, 255.0]);
    let mut map = DecodedPicture::from_bytes(&grey(0, 2, 1), &Limits::default()).unwrap();
    map.pixels = texels.to_vec();
    let three = [0.0; 3];
    let gains = Gains { least: three, most: [2.0; 3], gamma: [1.0; 3], before: three, after: three };
    let mut light = vec![[1.0; 3]; 8];
    gains.multiply(&map, [4, 2], &mut light).unwrap();
    let row = [1.0, exp2(0.5), exp2(1.5), 4.0].map(|v| [v; 3]);
    light.iter().zip([row, row].concat()).for_each(|(found, expected)| is_near(*found, expected));
}

#[test]
fn what_is_broken_says_why_and_changes_nothing() {
    let first = with_xmp(&grey(128, 8, 4), "", "");
    let map = grey(51, 4, 2);
    let xmp = |attributes: &str| [first.clone(), with_xmp(&map, attributes, "")].concat();
    let of_iso = |metadata: &[u8]| [first.clone(), with_segment(&map, 0xe2, &[ISO, metadata])].concat();
    let whole = xmp("hdrgm:GainMapMax=\"3\"");
    let huge = {
        // Claims 65,535 pixels squared.
        let mut map = with_xmp(&map, "hdrgm:GainMapMax=\"3\"", "");
        let frame = find(&map, &[0xff, 0xc0]).unwrap();
        map[frame + 5..frame + 9].fill(0xff);
        [first.clone(), map].concat()
    };
    for (file, why) in [
        (first.clone(), "not in the file"),
        (first.clone().into_iter().chain([0xff, 0xd8, 0xff]).collect(), "not in the file"),
        (xmp("hdrgm:GainMapMin=\"3\""), "not in the file"),
        (xmp("hdrgm:GainMapMax=\"much\""), "GainMapMax: 'much'"),
        (xmp("hdrgm:GainMapMax=\"1 2\""), "GainMapMax: '1 2'"),
        (xmp("hdrgm:GainMapMax=\"NaN\""), "NaN"),
        (xmp("hdrgm:GainMapMax=\"-1\""), "2 to the power 0 to -1"),
        (xmp("hdrgm:GainMapMax=\"1000\""), "2 to the power 0 to 1000"),
        (xmp("hdrgm:GainMapMax=\"1\" hdrgm:Gamma=\"0\""), "gamma of 0"),
        (xmp("hdrgm:GainMapMax=\"1\" hdrgm:OffsetHDR=\"7\""), "an offset of 7"),
        (xmp("hdrgm:GainMapMax=\"1\" hdrgm:BaseRenditionIsHDR=\"True\""), "the one of more range"),
        (of_iso(&[]), "ends early"),
        (of_iso(&iso(8, &[64, 0, 192, -64])), "ends early"),
        (of_iso(&[0, 9, 0, 9, 0]), "version 9"),
        (of_iso(&iso(8, &[0, 0, 192, -64, 128, 64, 1, 2])), "-inf to inf"),
        (of_iso(&iso(12, &[64, 0, 192, -64, 128, 64, 1, 2])), "the one of more range"),
        (of_iso(&iso(8, &[64, 192, 0, -64, 128, 64, 1, 2])), "the one of more range"),
        (huge, ""),
    ] {
        let (light, done) = light_of(&file, 8, 4);
        let reason = done.unwrap().unwrap_err();
        assert!(reason.contains(why), "{why}: {reason}");
        assert!(light.iter().all(|pixel| *pixel == [0.25, 0.5, 1.0]), "{why}");
    }
    // Whatever is missing of a file, and whatever is after it.
    for end in 0..whole.len() {
        let (light, done) = light_of(&whole[..end], 8, 4);
        assert!(done == Some(Ok(())) || light.iter().all(|pixel| *pixel == [0.25, 0.5, 1.0]), "{end}");
    }
    assert_eq!(light_of(&[whole, b"trailer".to_vec()].concat(), 8, 4).1, Some(Ok(())));
    assert_eq!(light_of(&grey(128, 8, 4), 8, 4).1, None);
    assert_eq!(light_of(&[grey(128, 8, 4), grey(3, 8, 4)].concat(), 8, 4).1, None, "a picture for previews");
}

#[test]
fn environments_have_the_light_of_their_gain_map() {
    let second =
        with_xmp(&grey(255, 4, 2), "hdrgm:GainMapMax=\"4\" hdrgm:OffsetSDR=\"0\" hdrgm:OffsetHDR=\"0\"", "");
    let file = [with_xmp(&grey(188, 16, 8), "", ""), second].concat();
    let environment = super::super::tests::open(&file);
    assert!(environment.warnings.is_empty(), "{:?}", environment.warnings);
    let light = 16.0 * srgb8_to_linear(188);
    assert!(environment.image.pixels().iter().flatten().all(|v| (v / light - 1.0).abs() < 1e-5));

    let broken =
        [with_xmp(&grey(188, 16, 8), "", ""), with_xmp(&grey(255, 4, 2), "hdrgm:GainMapMax=\"x\"", "")]
            .concat();
    let environment = super::super::tests::open(&broken);
    let [warning] = environment.warnings.as_slice() else { panic!("{:?}", environment.warnings) };
    assert!(warning.message.contains("gain map, which has more, is not used: GainMapMax: 'x'"), "{warning}");
    assert!(environment.image.pixels().iter().flatten().all(|v| (v - srgb8_to_linear(188)).abs() < 1e-6));
}
