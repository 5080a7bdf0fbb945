//! Writer of Apache Parquet files: plain, uncompressed columns of optional numbers and texts, and of lists of texts.
//!
//! After the format's specification (parquet-format 2.11: README.md, Encodings.md, LogicalTypes.md, parquet.thrift) and Thrift's compact
//! protocol. (The crate of Arrow turns on `arch` of libm for the whole program, by which glam computes what has to be the same on every
//! machine, so that all packages would be built twice.)

/// First and last bytes of a file.
const MAGIC: &[u8; 4] = b"PAR1";

/// Values of a column, one for each row.
pub enum Values {
    /// UTF-8.
    Texts(Vec<Option<String>>),
    /// 64 bits.
    Counts(Vec<Option<i64>>),
    /// 64 bits.
    Numbers(Vec<Option<f64>>),
    /// Lists of UTF-8.
    Lists(Vec<Vec<String>>),
}

impl Values {
    fn kind(&self) -> i64 {
        match self {
            Self::Counts(_) => 2,
            Self::Numbers(_) => 5,
            Self::Texts(_) | Self::Lists(_) => 6,
        }
    }

    fn path<'a>(&self, name: &'a str) -> Vec<&'a str> {
        if matches!(self, Self::Lists(_)) { vec![name, "list", "element"] } else { vec![name] }
    }

    /// Repetition levels, definition levels and values of a page.
    fn page(&self) -> (Option<Vec<u8>>, Vec<u8>, Vec<u8>) {
        let mut bytes = Vec::new();
        let mut put = |value: &[u8]| bytes.extend_from_slice(value);
        let text = |text: &str| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
        match self {
            Self::Texts(rows) => {
                rows.iter().flatten().for_each(|value| put(&text(value)));
                (None, present(rows), bytes)
            }
            Self::Counts(rows) => {
                rows.iter().flatten().for_each(|value| put(&value.to_le_bytes()));
                (None, present(rows), bytes)
            }
            Self::Numbers(rows) => {
                rows.iter().flatten().for_each(|value| put(&value.to_le_bytes()));
                (None, present(rows), bytes)
            }
            Self::Lists(rows) => {
                let (mut repetitions, mut definitions) = (Vec::new(), Vec::new());
                for row in rows {
                    // An empty list has a level and no value.
                    repetitions.push(0);
                    definitions.push(u8::from(!row.is_empty()));
                    for _ in 1..row.len() {
                        repetitions.push(1);
                        definitions.push(1);
                    }
                    row.iter().for_each(|value| put(&text(value)));
                }
                (Some(repetitions), definitions, bytes)
            }
        }
    }
}

/// Definition levels of optional values: 1 where there is one.
fn present<T>(rows: &[Option<T>]) -> Vec<u8> {
    rows.iter().map(|value| value.is_some().into()).collect()
}

/// Levels of one bit as runs, after their length (Encodings.md, "Run Length Encoding / Bit-Packing Hybrid").
fn runs(levels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for run in levels.chunk_by(|a, b| a == b) {
        varint(&mut bytes, (run.len() as u64) << 1);
        bytes.push(run[0]);
    }
    [&(bytes.len() as u32).to_le_bytes(), &bytes[..]].concat()
}

fn varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

/// A structure of Thrift's compact protocol.
#[derive(Default)]
struct Struct {
    bytes: Vec<u8>,
    last: u8,
}

/// Types of fields of the compact protocol.
const I32: u8 = 5;
const I64: u8 = 6;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const STRUCT: u8 = 12;

impl Struct {
    /// Header of a field, whose numbers rise by less than 16.
    fn field(mut self, id: u8, kind: u8) -> Self {
        self.bytes.push((id - self.last) << 4 | kind);
        self.last = id;
        self
    }

    fn int(self, id: u8, kind: u8, value: i64) -> Self {
        let mut of = self.field(id, kind);
        varint(&mut of.bytes, zigzag(value));
        of
    }

    fn text(self, id: u8, value: &str) -> Self {
        let mut of = self.field(id, BINARY);
        of.bytes.extend(binary(value));
        of
    }

    fn inner(self, id: u8, value: Self) -> Self {
        let mut of = self.field(id, STRUCT);
        of.bytes.extend(value.end());
        of
    }

    fn list(self, id: u8, kind: u8, values: &[Vec<u8>]) -> Self {
        let mut of = self.field(id, LIST);
        match values.len() {
            count @ ..15 => of.bytes.push((count as u8) << 4 | kind),
            count => {
                of.bytes.push(0xf0 | kind);
                varint(&mut of.bytes, count as u64);
            }
        }
        values.iter().for_each(|value| of.bytes.extend_from_slice(value));
        of
    }

    fn end(mut self) -> Vec<u8> {
        self.bytes.push(0);
        self.bytes
    }
}

fn zigzag(value: i64) -> u64 {
    (value << 1 ^ value >> 63) as u64
}

fn binary(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    varint(&mut bytes, text.len() as u64);
    bytes.extend_from_slice(text.as_bytes());
    bytes
}

/// A file that grows by groups of rows.
pub struct Parquet {
    bytes: Vec<u8>,
    schema: Vec<Vec<u8>>,
    groups: Vec<Vec<u8>>,
    rows: i64,
}

impl Parquet {
    /// A file without rows. Its columns are those of the values, of which there need be none.
    #[must_use]
    pub fn new(columns: &[(&str, Values)]) -> Self {
        let mut schema = vec![Struct::default().text(4, "schema").int(5, I32, columns.len() as i64).end()];
        for (name, values) in columns {
            schema.extend(elements(name, values));
        }
        Self { bytes: MAGIC.to_vec(), schema, groups: Vec::new(), rows: 0 }
    }

    /// Adds a group of so many rows.
    pub fn add(&mut self, rows: usize, columns: &[(&str, Values)]) {
        let begin = self.bytes.len();
        let chunks: Vec<Vec<u8>> = columns.iter().map(|(name, values)| self.chunk(name, values)).collect();
        let length = (self.bytes.len() - begin) as i64;
        let group = Struct::default().list(1, STRUCT, &chunks).int(2, I64, length).int(3, I64, rows as i64);
        self.groups.push(group.end());
        self.rows += rows as i64;
    }

    /// Adds a column of a group, of one page. Returns its description.
    fn chunk(&mut self, name: &str, values: &Values) -> Vec<u8> {
        let begin = self.bytes.len();
        let (repetitions, definitions, plain) = values.page();
        let (count, levels) = (definitions.len() as i64, repetitions.map(|levels| runs(&levels)));
        let page = [levels.unwrap_or_default(), runs(&definitions), plain].concat();
        // Plain values, and levels as runs.
        let of_data = Struct::default().int(1, I32, count).int(2, I32, 0).int(3, I32, 3).int(4, I32, 3);
        let size = page.len() as i64;
        let header = Struct::default().int(1, I32, 0).int(2, I32, size).int(3, I32, size).inner(5, of_data);
        self.bytes.extend(header.end());
        self.bytes.extend(page);
        let (at, length) = (begin as i64, (self.bytes.len() - begin) as i64);
        let encodings = [0, 3].map(|encoding| zigzag(encoding) as u8).map(|byte| vec![byte]);
        let path: Vec<Vec<u8>> = values.path(name).into_iter().map(binary).collect();
        let metadata = Struct::default()
            .int(1, I32, values.kind())
            .list(2, I32, &encodings)
            .list(3, BINARY, &path)
            .int(4, I32, 0)
            .int(5, I64, count)
            .int(6, I64, length)
            .int(7, I64, length)
            .int(9, I64, at);
        Struct::default().int(2, I64, at).inner(3, metadata).end()
    }

    /// The bytes of the file.
    #[must_use]
    pub fn finish(self) -> Vec<u8> {
        let Self { mut bytes, schema, groups, rows } = self;
        let footer = Struct::default()
            .int(1, I32, 1)
            .list(2, STRUCT, &schema)
            .int(3, I64, rows)
            .list(4, STRUCT, &groups)
            .text(6, concat!("overcoat version ", env!("CARGO_PKG_VERSION")))
            .end();
        bytes.extend_from_slice(&footer);
        bytes.extend_from_slice(&(footer.len() as u32).to_le_bytes());
        bytes.extend_from_slice(MAGIC);
        bytes
    }
}

/// Elements of the schema for a column: a leaf, or a group of a repeated group of one (LogicalTypes.md, "Lists").
fn elements(name: &str, values: &Values) -> Vec<Vec<u8>> {
    const REQUIRED: i64 = 0;
    const OPTIONAL: i64 = 1;
    const REPEATED: i64 = 2;
    let leaf = |name, repetition| {
        let of = Struct::default().int(1, I32, values.kind()).int(3, I32, repetition).text(4, name);
        match values {
            // As text, by the old annotation and the new one.
            Values::Texts(_) | Values::Lists(_) => {
                let string = Struct::default().inner(1, Struct::default());
                of.int(6, I32, 0).inner(10, string).end()
            }
            Values::Counts(_) | Values::Numbers(_) => of.end(),
        }
    };
    let group = |name, repetition| Struct::default().int(3, I32, repetition).text(4, name).int(5, I32, 1);
    match values {
        Values::Lists(_) => {
            let list = Struct::default().inner(3, Struct::default());
            vec![
                group(name, REQUIRED).int(6, I32, 3).inner(10, list).end(),
                group("list", REPEATED).end(),
                leaf("element", REQUIRED),
            ]
        }
        _ => vec![leaf(name, OPTIONAL)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_runs() {
        assert_eq!(runs(&[]), [0, 0, 0, 0]);
        assert_eq!(runs(&[1, 1, 1, 0]), [4, 0, 0, 0, 6, 1, 2, 0]);
        assert_eq!(runs(&[1; 100]), [3, 0, 0, 0, 0xc8, 1, 1]);
    }

    #[test]
    fn structures_are_compact() {
        let of = Struct::default().int(1, I32, -1).text(4, "ab").inner(5, Struct::default());
        assert_eq!(of.end(), [0x15, 1, 0x38, 2, b'a', b'b', 0x1c, 0, 0]);
        assert_eq!((zigzag(0), zigzag(-1), zigzag(150), zigzag(i64::MIN)), (0, 1, 300, u64::MAX));
        let long = Struct::default().list(1, I32, &vec![vec![2]; 20]).end();
        assert_eq!(&long[..4], [0x19, 0xf5, 20, 2]);
    }

    #[test]
    fn pages_have_levels_and_values() {
        let text = |text: &str| Some(text.to_owned());
        let (none, levels, values) = Values::Texts(vec![text("ab"), None, text("")]).page();
        assert_eq!((none, levels, values), (None, vec![1, 0, 1], vec![2, 0, 0, 0, b'a', b'b', 0, 0, 0, 0]));
        let lists = vec![vec!["a".to_owned(), "b".to_owned()], Vec::new(), vec!["c".to_owned()]];
        let (repetitions, definitions, values) = Values::Lists(lists).page();
        assert_eq!((repetitions, definitions), (Some(vec![0, 1, 0, 0]), vec![1, 1, 0, 1]));
        assert_eq!(values.len(), 15);
        assert_eq!(Values::Counts(vec![Some(258)]).page().2, [2, 1, 0, 0, 0, 0, 0, 0]);
    }
}
