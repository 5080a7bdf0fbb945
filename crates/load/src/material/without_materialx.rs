//! Stands in for the reader of MaterialX in builds without its XML.

use super::GivenPictures;
use super::error::{MaterialError, MaterialErrorReason};
use crate::Context;

pub(super) fn is_xml(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().first() == Some(&b'<')
}

pub(super) fn to_toml(
    _: &str,
    _: &GivenPictures,
    _: &Context<'_>,
) -> Result<super::Translated, MaterialError> {
    let message = "documents of MaterialX are not read by this program".to_owned();
    Err(MaterialError::whole(MaterialErrorReason::Unreadable(message)))
}
