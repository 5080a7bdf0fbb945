//! The referee on every machine: what `overcoat lab` says of a few coats, to the last bit.
//!
//! They go through what the program can ask of it: rough and smooth faces, metals with all bounces, a matt base, plastic by
//! convention and below an interface, media that absorb, light from one direction, from everywhere and from a soft box. Media that scatter are in `tests/truth/bits.rs`.

use super::record::Hashes;
use serde_json::Value;
use xxhash_rust::xxh3::xxh3_128;

/// Name, and the options of `overcoat lab`.
pub const RUNS: [(&str, &str); 4] = [
    (
        "referee-metal",
        "--over light --view 40 --steps 4 --samples 256 --coat-roughness 0.3 --metal --base-roughness 0.4 \
         --color 0.9,0.6,0.3 --extinction 0.1,0.4,1 --models stacklit-d,openpbr",
    ),
    (
        "referee-plastic",
        "--over view --steps 3 --samples 256 --coat-roughness 0 --base-roughness 0.5 --color 0.1,0.3,0.6 --coat 0.8 \
         --base convention --models gltf",
    ),
    (
        "referee-interface",
        "--over view --steps 3 --samples 256 --coat-roughness 0.3 --base-roughness 0.5 --color 0.1,0.3,0.6 --coat 0.8 \
         --base seen --base-ior 1.7 --extinction 0.1,0.4,1 --models openpbr",
    ),
    (
        "referee-matt",
        "--over view --steps 2 --samples 256 --light overhead --coat-roughness 0 --coat-ior 1.7 --base-roughness 0 --specular 0 --models gltf",
    ),
];

/// The words of a command line.
pub fn words(options: &str) -> Vec<String> {
    ["lab", "--json", "--threads", "1"]
        .into_iter()
        .chain(options.split_whitespace())
        .map(str::to_owned)
        .collect()
}

/// The hashes of a report: those of the referee's numbers in the place of the frame's, those of the models' in that of the
/// file's.
pub fn hashes(report: &str) -> Result<Hashes, String> {
    let report: Value = serde_json::from_str(report).map_err(|e| format!("its report is no JSON: {e}"))?;
    let (mut referee, mut models) = (Vec::new(), Vec::new());
    for row in report["rows"].as_array().ok_or("its report has no rows")? {
        for name in ["truth", "standard_error", "truth_coat"] {
            bits(&row[name], &mut referee)?;
        }
        for model in row["models"].as_array().ok_or("a row has no models")? {
            bits(&model["radiance"], &mut models)?;
        }
    }
    let [frame, file] = [referee, models].map(|bytes| format!("{:032x}", xxh3_128(&bytes)));
    Ok(Hashes { frame, format: "json".to_owned(), file })
}

/// Three numbers, which reports give to the last bit.
fn bits(value: &Value, out: &mut Vec<u8>) -> Result<(), String> {
    let numbers: Option<Vec<f64>> =
        value.as_array().map(|list| list.iter().filter_map(Value::as_f64).collect());
    let numbers = numbers.filter(|numbers| numbers.len() == 3).ok_or("there are not three numbers")?;
    out.extend(numbers.iter().flat_map(|x| x.to_bits().to_le_bytes()));
    Ok(())
}

#[test]
fn a_bit_is_another_hash() {
    let report = |x: &str, y: &str| {
        format!(
            "{{\"rows\":[{{\"truth\":[0.1,0.2,{x}],\"standard_error\":[0,0,1e-9],\"truth_coat\":[0,0,0],\
             \"models\":[{{\"radiance\":[{y},0,0]}}]}}]}}"
        )
    };
    let of = |x: &str, y: &str| hashes(&report(x, y)).unwrap();
    let first = of("0.3", "0.5");
    assert_eq!(first, of("0.30", "5e-1"));
    let second = of("0.30000000000000004", "0.5");
    assert!(second.frame != first.frame && second.file == first.file);
    assert!(of("0.3", "0.50000000000000011").file != first.file);
    assert!(hashes("{}").is_err() && hashes("-").is_err() && hashes(&report("null", "0")).is_err());
}
