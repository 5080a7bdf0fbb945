//! Signatures of paths, as imgproxy has them: HMAC-SHA256 of salt and path, in base64 for URLs without padding.

use super::error::{Kind, Problem};
use axum::http::header::WWW_AUTHENTICATE;
use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;
use std::fmt;

/// Placeholders for the signature where none is needed.
const UNSIGNED: [&str; 2] = ["unsafe", "_"];

/// Check of the signatures of paths.
#[derive(Clone, Default)]
pub struct Signer {
    pairs: Vec<Pair>,
    allow_unsigned: bool,
}

#[derive(Clone)]
struct Pair {
    key: Vec<u8>,
    salt: Vec<u8>,
}

impl fmt::Debug for Signer {
    // Keys stay out of logs.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Signer({} keys, unsigned: {})", self.pairs.len(), self.allow_unsigned)
    }
}

impl Signer {
    /// Signer from hexadecimal keys and as many salts.
    ///
    /// # Errors
    /// One line that names the option.
    pub fn new(keys: &[String], salts: &[String], allow_unsigned: bool) -> Result<Self, String> {
        if keys.len() != salts.len() {
            let (keys, salts) = (keys.len(), salts.len());
            return Err(format!("--key and --salt come in pairs: there are {keys} and {salts}"));
        }
        let read = |option: &str, text: &String| {
            let bytes = hexadecimal(text.trim()).filter(|bytes| !bytes.is_empty());
            bytes.ok_or_else(|| format!("{option}: expected an even number of hexadecimal digits"))
        };
        let pair = |(key, salt)| Ok(Pair { key: read("--key", key)?, salt: read("--salt", salt)? });
        let pairs = keys.iter().zip(salts).map(pair).collect::<Result<_, String>>()?;
        Ok(Self { pairs, allow_unsigned })
    }

    /// Checks the signature of a path, which begins with a slash.
    ///
    /// # Errors
    /// [`Kind::Unsigned`], [`Kind::Signature`].
    pub fn check(&self, signature: &str, path: &str) -> Result<(), Problem> {
        if UNSIGNED.contains(&signature) {
            let unsigned = || {
                let message = "paths need a signature here; --allow-unsigned takes them without";
                Problem::new(Kind::Unsigned, message).with(WWW_AUTHENTICATE, "HMAC-SHA256")
            };
            return self.allow_unsigned.then_some(()).ok_or_else(unsigned);
        }
        let given = URL_SAFE_NO_PAD.decode(signature.trim_end_matches('='));
        let signed = given.is_ok_and(|given| self.pairs.iter().any(|pair| pair.signed(path, &given)));
        signed
            .then_some(())
            .ok_or_else(|| Problem::new(Kind::Signature, "no key makes this signature of this path"))
    }

    /// The signature of bytes by the first key, if there is one: those of no path, as they begin with no slash.
    #[must_use]
    pub fn sign_bytes(&self, parts: &[&[u8]]) -> Option<String> {
        let mut mac = self.pairs.first()?.mac("")?;
        parts.iter().for_each(|part| mac.update(part));
        Some(URL_SAFE_NO_PAD.encode(mac.finalize().into_bytes()))
    }

    /// True if there is a key.
    #[must_use]
    pub fn has_key(&self) -> bool {
        !self.pairs.is_empty()
    }

    /// The signature of a path by the first key, if there is one.
    #[must_use]
    pub fn sign(&self, path: &str) -> Option<String> {
        let mac = self.pairs.first()?.mac(path)?;
        Some(URL_SAFE_NO_PAD.encode(mac.finalize().into_bytes()))
    }
}

impl Pair {
    fn mac(&self, path: &str) -> Option<Hmac<Sha256>> {
        let mut mac = Hmac::<Sha256>::new_from_slice(&self.key).ok()?;
        mac.update(&self.salt);
        mac.update(path.as_bytes());
        Some(mac)
    }

    /// In constant time.
    fn signed(&self, path: &str, given: &[u8]) -> bool {
        self.mac(path).is_some_and(|mac| mac.verify_slice(given).is_ok())
    }
}

fn hexadecimal(text: &str) -> Option<Vec<u8>> {
    if !text.is_ascii() || !text.len().is_multiple_of(2) {
        return None;
    }
    let digits = text.as_bytes().chunks(2);
    digits.map(|two| u8::from_str_radix(std::str::from_utf8(two).ok()?, 16).ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signer(pairs: &[(&str, &str)], unsigned: bool) -> Signer {
        let (keys, salts): (Vec<_>, Vec<_>) =
            pairs.iter().map(|(key, salt)| (key.to_string(), salt.to_string())).unzip();
        Signer::new(&keys, &salts, unsigned).unwrap()
    }

    /// The example of imgproxy's documentation.
    #[test]
    fn signatures_are_those_of_imgproxy() {
        let signer = signer(&[("736563726574", "68656C6C6F")], false);
        let path = "/rs:fill:300:400:0/g:sm/aHR0cDovL2V4YW1w/bGUuY29tL2ltYWdl/cy9jdXJpb3NpdHku/anBn.png";
        let signature = "oKfUtW34Dvo2BGQehJFR4Nr0_rIjOtdtzJ3QFsUcXH8";
        assert_eq!(signer.sign(path).unwrap(), signature);
        assert!(signer.check(signature, path).is_ok());
        assert_eq!(signer.check(signature, "/rs:fill:300:401").unwrap_err().kind, Kind::Signature);
        assert_eq!(signer.check("unsafe", path).unwrap_err().kind, Kind::Unsigned);
    }

    #[test]
    fn keys_rotate() {
        let (old, new) = (("aa", "bb"), ("cc", "dd"));
        let signature = signer(&[old], false).sign("/a").unwrap();
        assert!(signer(&[new, old], false).check(&signature, "/a").is_ok());
        assert!(signer(&[new], false).check(&signature, "/a").is_err());
        assert!(signer(&[], true).check("_", "/a").is_ok());
        for wrong in ["", "x", "é", "////"] {
            assert!(signer(&[old], true).check(wrong, "/a").is_err(), "{wrong}");
        }
        assert!(Signer::new(&["a".to_owned()], &["bb".to_owned()], false).is_err());
        assert!(Signer::new(&["aa".to_owned()], &[], false).is_err());
    }
}
