//! Matrices of calibrated cameras.

use super::Kind;
use super::names::Named;
use super::numbers::write_double;
use super::vectors::list_schema;
use crate::name::file_name;
use crate::tree::Node;
use crate::value::Value;
use overcoat_scene::{Intrinsics, PoseConvention};
use serde_json::{Value as Json, json};
use std::ffi::OsStr;
use std::io::Read;
use std::path::Path;

/// Form of a pose as text.
const SIXTEEN: &str = "16 numbers, a 4 x 4 matrix row by row";

/// Numbers with commas, blanks or brackets around them; `None` if there is anything else.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let is_between = |c: char| c.is_whitespace() || matches!(c, ',' | ';' | '[' | ']');
    text.split(is_between).filter(|part| !part.is_empty()).map(|part| part.parse().ok()).collect()
}

/// A list of `N` numbers.
fn row<const N: usize>(node: &Node<'_>) -> Option<[f64; N]> {
    let list = node.list()?.iter().map(Node::number).collect::<Option<Vec<f64>>>()?;
    <[f64; N]>::try_from(list).ok()
}

/// A list of `N` lists of `N` numbers.
fn matrix<const N: usize>(node: &Node<'_>) -> Option<[[f64; N]; N]> {
    let rows = node.list()?.iter().map(row::<N>).collect::<Option<Vec<[f64; N]>>>()?;
    <[[f64; N]; N]>::try_from(rows).ok()
}

fn write_list(numbers: &[f64]) -> Result<Json, String> {
    numbers.iter().copied().map(write_double).collect()
}

fn json_numbers(text: &str, count: usize, expected: &str) -> Result<Json, String> {
    let all = numbers(text).filter(|all| all.len() == count).ok_or(expected)?;
    write_list(&all)
}

/// A number of pixels, of double precision.
pub(crate) struct Pixels;

impl Kind for Pixels {
    type Value = f64;

    fn parse(&self, text: &str) -> Result<f64, String> {
        let number = text.parse::<f64>().ok().filter(|v| v.is_finite());
        number.ok_or_else(|| "expected a number of pixels".to_owned())
    }

    fn read(&self, value: &Value<'_>) -> Result<f64, String> {
        value.node.number().ok_or_else(|| value.expected("a number of pixels"))
    }

    fn write(&self, value: &f64) -> Result<Json, String> {
        write_double(*value)
    }

    fn schema(&self) -> Json {
        json!({"type": "number"})
    }

    fn query(&self, text: &str) -> Result<Json, String> {
        json_numbers(text, 1, "a number").map(|list| list[0].clone())
    }
}

/// Intrinsics `fx, fy, cx, cy`, which scene files may write as a matrix K.
pub(crate) struct MatrixK;

impl Kind for MatrixK {
    type Value = [f64; 4];

    fn parse(&self, text: &str) -> Result<[f64; 4], String> {
        let four = numbers(text).and_then(|all| <[f64; 4]>::try_from(all).ok());
        four.ok_or_else(|| "expected four numbers fx,fy,cx,cy, in pixels".to_owned())
    }

    fn read(&self, value: &Value<'_>) -> Result<[f64; 4], String> {
        if let Some(four) = row::<4>(&value.node) {
            return Ok(four);
        }
        let k = matrix::<3>(&value.node);
        let k = k.ok_or_else(|| value.expected("3 rows of 3 numbers, or a list of 4, fx, fy, cx and cy"))?;
        Intrinsics::numbers_of(k).map_err(|error| value.message(error))
    }

    fn write(&self, value: &[f64; 4]) -> Result<Json, String> {
        write_list(value)
    }

    fn schema(&self) -> Json {
        json!({"anyOf": [square_schema(3), list_schema(4)]})
    }

    fn query(&self, text: &str) -> Result<Json, String> {
        json_numbers(text, 4, "four numbers with commas")
    }
}

/// Pose of a camera: 4 rows of 4 numbers. As an argument, a file that has them, too.
pub(crate) struct PoseMatrix;

/// Bytes of a file with a pose at most.
const MAX_BYTES: u64 = 1 << 16;

/// Text of a small file. It is read more than once, which pipes cannot be.
fn read_file(path: &Path) -> Result<String, String> {
    let message = |error: std::io::Error| error.to_string();
    if !std::fs::metadata(path).map_err(message)?.is_file() {
        return Err("no regular file".to_owned());
    }
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(message)?;
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(message)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(format!("too large for {SIXTEEN}"));
    }
    String::from_utf8(bytes).map_err(|_| "not a text file".to_owned())
}

/// Rows of sixteen numbers.
fn rows_of(all: &[f64]) -> Option<[[f64; 4]; 4]> {
    let (rows, rest) = all.as_chunks::<4>();
    rest.is_empty().then_some(())?;
    <[[f64; 4]; 4]>::try_from(rows).ok()
}

impl Kind for PoseMatrix {
    type Value = [[f64; 4]; 4];

    fn parse(&self, text: &str) -> Result<[[f64; 4]; 4], String> {
        self.parse_os(OsStr::new(text))
    }

    fn parse_os(&self, text: &OsStr) -> Result<[[f64; 4]; 4], String> {
        if let Some(all) = text.to_str().and_then(numbers) {
            return rows_of(&all)
                .ok_or_else(|| format!("expected {SIXTEEN}, or a file; found {}", all.len()));
        }
        let path = Path::new(text);
        let about = |message: String| format!("{}: {message}", file_name(path));
        let text = read_file(path).map_err(about)?;
        let all = numbers(&text).ok_or_else(|| about(format!("expected {SIXTEEN}, and nothing else")))?;
        rows_of(&all).ok_or_else(|| about(format!("expected {SIXTEEN}; found {}", all.len())))
    }

    fn read(&self, value: &Value<'_>) -> Result<[[f64; 4]; 4], String> {
        let flat = row::<16>(&value.node).and_then(|all| rows_of(&all));
        flat.or_else(|| matrix::<4>(&value.node)).ok_or_else(|| value.expected("4 rows of 4 numbers"))
    }

    fn write(&self, value: &[[f64; 4]; 4]) -> Result<Json, String> {
        value.iter().map(|row| write_list(row)).collect()
    }

    fn schema(&self) -> Json {
        json!({"anyOf": [square_schema(4), list_schema(16)]})
    }

    fn query(&self, text: &str) -> Result<Json, String> {
        json_numbers(text, 16, SIXTEEN)
    }
}

/// Schema of a matrix.
fn square_schema(side: usize) -> Json {
    json!({"type": "array", "items": list_schema(side), "minItems": side, "maxItems": side})
}

impl Named for PoseConvention {
    const EXPECTED: &'static str = "opencv or opengl";
    fn all() -> &'static [Self] {
        Self::ALL
    }
    fn name(self) -> &'static str {
        Self::name(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_is_sixteen_numbers_or_a_file_of_them() {
        let text = "1 0 0 -2.5\n0 1 0 0\n0 0 1 3e-1\n0 0 0 1\n";
        let rows = [[1.0, 0.0, 0.0, -2.5], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.3], [0.0, 0.0, 0.0, 1.0]];
        assert_eq!(PoseMatrix.parse(text), Ok(rows));
        assert_eq!(PoseMatrix.parse("[[1,0,0,-2.5],[0,1,0,0],[0,0,1,.3],[0,0,0,1]]"), Ok(rows));
        let wrong = PoseMatrix.parse("1,0,0,0,1,0,0,0,1").unwrap_err();
        assert_eq!(wrong, "expected 16 numbers, a 4 x 4 matrix row by row, or a file; found 9");
        let folder = std::env::temp_dir().join(format!("overcoat-pose-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("pose.txt");
        let parse = |text: &str| {
            std::fs::write(&file, text).unwrap();
            PoseMatrix.parse_os(file.as_os_str())
        };
        assert_eq!(parse(text), Ok(rows));
        let few = "pose.txt: expected 16 numbers, a 4 x 4 matrix row by row; found 3";
        assert!(parse("1 2 3").unwrap_err().ends_with(few));
        assert!(parse("pose: 1").unwrap_err().ends_with("and nothing else"));
        assert!(parse(&"1 ".repeat(1 << 20)).unwrap_err().contains("too large"));
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(PoseMatrix.parse_os(file.as_os_str()).unwrap_err().contains("pose.txt: "));
        // A request names no file.
        assert!(PoseMatrix.query("/etc/hostname").is_err() && PoseMatrix.query(text).is_ok());
    }
}
