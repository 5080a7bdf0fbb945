//! Packages of 3MF files.

/// A zip archive of parts as they are (APPNOTE.TXT of PKWARE, sections 4.3.7, 4.3.12 and 4.3.16).
pub fn stored_zip(parts: &[(&str, &[u8])]) -> Vec<u8> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in parts {
        let size = content.len() as u32;
        // Version, flags, method, time and date; checksum and both sizes; lengths of the name and of what is extra.
        let mut about: Vec<u8> = [20_u16, 0, 0, 0, 0x21].into_iter().flat_map(u16::to_le_bytes).collect();
        about.extend([crc32fast::hash(content), size, size].into_iter().flat_map(u32::to_le_bytes));
        about.extend([name.len() as u16, 0].into_iter().flat_map(u16::to_le_bytes));
        directory.extend(b"PK\x01\x02\x14\0");
        directory.extend(&about);
        // No comment, disk 0, no attributes.
        directory.extend([0; 2 + 2 + 2 + 4]);
        directory.extend((bytes.len() as u32).to_le_bytes());
        directory.extend(name.bytes());
        bytes.extend(b"PK\x03\x04");
        bytes.extend(about);
        bytes.extend(name.bytes());
        bytes.extend(*content);
    }
    let start = bytes.len() as u32;
    let count = parts.len() as u16;
    bytes.extend(&directory);
    bytes.extend(b"PK\x05\x06");
    bytes.extend([0, 0, count, count].into_iter().flat_map(u16::to_le_bytes));
    bytes.extend([directory.len() as u32, start].into_iter().flat_map(u32::to_le_bytes));
    bytes.extend([0; 2]);
    bytes
}
