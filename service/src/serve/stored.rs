//! ZIP archives whose files are stored as they are (PKWARE APPNOTE 6.3.10, 4.3): pictures are compressed already.
//!
//! Every header has the size of its file, which readers that get an archive as a stream need; writers of crates that could be used put
//! it after the file.

/// An archive to which files are added.
#[derive(Debug, Default)]
pub struct Stored {
    bytes: Vec<u8>,
    directory: Vec<u8>,
    count: u16,
}

/// Version that is needed to read it: 2.0.
const VERSION: [u8; 2] = 20_u16.to_le_bytes();
/// Flags: names are UTF-8.
const UTF8: [u8; 2] = (1_u16 << 11).to_le_bytes();
/// The first day that there is, at midnight: archives of equal pictures are equal.
const TIME: [u8; 4] = [0, 0, 0x21, 0];

impl Stored {
    /// Adds a file. Names are unique, and there is no folder in them. Returns false, and adds nothing, where the archive would have more
    /// than such archives can have: 65,535 files, 4 GiB.
    #[must_use]
    pub fn add(&mut self, name: &str, content: &[u8]) -> bool {
        let (start, size) = (u32::try_from(self.bytes.len()), u32::try_from(content.len()));
        let (Ok(start), Ok(size), Ok(length)) = (start, size, u16::try_from(name.len())) else {
            return false;
        };
        let whole = self.bytes.len() + content.len() + self.directory.len() + 2 * (name.len() + 100);
        if self.count == u16::MAX || u32::try_from(whole).is_err() {
            return false;
        }
        let mut fields = [VERSION, UTF8, [0; 2]].concat();
        fields.extend(TIME);
        fields.extend(rawzip::crc32(content).to_le_bytes());
        fields.extend([size.to_le_bytes(), size.to_le_bytes()].concat());
        fields.extend(length.to_le_bytes());
        fields.extend([0; 2]);
        self.bytes.extend(b"PK\x03\x04");
        self.bytes.extend(&fields);
        self.bytes.extend(name.bytes());
        self.bytes.extend(content);
        self.directory.extend(b"PK\x01\x02");
        self.directory.extend(VERSION);
        self.directory.extend(fields);
        self.directory.extend([0; 10]);
        self.directory.extend(start.to_le_bytes());
        self.directory.extend(name.bytes());
        self.count += 1;
        true
    }

    /// The archive.
    #[must_use]
    pub fn finish(mut self) -> Vec<u8> {
        let ends = [self.directory.len(), self.bytes.len()].map(|value| (value as u32).to_le_bytes());
        self.bytes.extend(self.directory);
        self.bytes.extend(b"PK\x05\x06\0\0\0\0");
        self.bytes.extend([self.count.to_le_bytes(), self.count.to_le_bytes()].concat());
        self.bytes.extend(ends.concat());
        self.bytes.extend([0; 2]);
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_reader_finds_what_was_added() {
        let files = [("a.png", &b"one"[..]), ("b\u{e4}.json", b""), ("c", &[7; 70_000])];
        let mut stored = Stored::default();
        for (name, content) in files {
            assert!(stored.add(name, content));
        }
        assert!(!stored.add(&"x".repeat(1 << 16), b""));
        let bytes = stored.finish();
        let zip = rawzip::ZipArchive::from_slice(&bytes).unwrap();
        let mut found = Vec::new();
        for entry in zip.entries() {
            let entry = entry.unwrap();
            let data = zip.get_entry(entry.wayfinder()).unwrap();
            let content = data.data();
            assert_eq!(data.claim_verifier().crc, rawzip::crc32(content));
            found.push((String::from_utf8(entry.file_path().as_bytes().to_vec()).unwrap(), content.to_vec()));
        }
        assert_eq!(found, files.map(|(name, content)| (name.to_owned(), content.to_vec())));
    }
}
