//! In place of archives where the feature `3mf` is left out: what names its parts, which stand in the open, tells 3MF.

/// Begins every archive that holds a file.
pub(crate) const MAGIC: &[u8; 4] = b"PK\x03\x04";

/// The usual name of a model, if it is in the directory at the end.
pub(crate) fn names(bytes: &[u8], most: usize) -> Vec<String> {
    const MODEL: &[u8] = b".model";
    let end = bytes.get(bytes.len().saturating_sub(1 << 16)..).unwrap_or(bytes);
    let found = end.windows(MODEL.len()).any(|window| window.eq_ignore_ascii_case(MODEL));
    found.then(|| "3d/3dmodel.model".to_owned()).into_iter().take(most).collect()
}
