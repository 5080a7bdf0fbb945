//! Upload of a client: a model, or a model with its files in a form.

use super::body::Held;
use super::error::{Kind, Problem};
use super::media;
use crate::batch::items::is_model;
use crate::files::MemoryFiles;
use axum::http::{HeaderMap, header};
use bytes::Bytes;
use overcoat_worker::converters::Registry;
use std::collections::BTreeMap;

/// Parts of a form at most.
const PARTS: usize = 1000;
/// Bytes of the name of a file at most.
const LONGEST_NAME: usize = 300;
/// Bytes of a field at most that is no file.
const LONGEST_FIELD: usize = 1 << 16;

/// A model as it came.
#[derive(Debug, Default)]
pub struct Upload {
    /// The name of its file, perhaps without a folder, perhaps empty.
    pub name: String,
    /// Its media type, if one was told.
    pub media_type: Option<String>,
    /// Content of the model's file.
    pub model: Bytes,
    /// The files that came with it.
    pub files: MemoryFiles,
    /// Options that came in fields of the form.
    pub fields: Vec<(String, String)>,
    /// Its bytes, counted.
    pub held: Held,
}

impl Upload {
    /// Upload from a body and its headers.
    ///
    /// # Errors
    /// [`Kind::Options`] if it is no form that can be read.
    pub async fn new(headers: &HeaderMap, body: Bytes, held: Held) -> Result<Self, Problem> {
        let text = |name| headers.get(name).and_then(|value: &axum::http::HeaderValue| value.to_str().ok());
        let media_type = text(header::CONTENT_TYPE).map(str::to_owned);
        if let Some(boundary) = media_type.as_deref().and_then(|text| multer::parse_boundary(text).ok()) {
            return Ok(Self { held, ..form(body, boundary).await? });
        }
        let name = text(header::CONTENT_DISPOSITION).and_then(file_name_of).unwrap_or_default();
        Ok(Self { name, media_type, model: body, held, ..Self::default() })
    }

    /// Takes a name that is told elsewhere, and gives one to what has none. Without files beside it the name of a model says
    /// nothing but its extension: pictures of equal models are the same then, and nobody's names are told to others.
    pub fn settle_name(&mut self, told: Option<&str>, converters: &Registry) {
        if let Some(told) = told {
            self.name = told.to_owned();
        }
        if self.files.files.is_empty() {
            let mut extension = media::extension(&self.name);
            if extension.is_empty() {
                let type_of = |name| media::extension_of_type(name, converters);
                let by_type = self.media_type.as_deref().and_then(type_of);
                extension = by_type.unwrap_or_default().to_owned();
            }
            let plain = extension.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'.');
            self.name = match extension.as_str() {
                extension if !extension.is_empty() && plain && extension.len() < 20 => {
                    format!("model.{extension}")
                }
                _ => "model".to_owned(),
            };
        }
    }

    /// Identity of the upload's files, which tells them from those of others.
    #[must_use]
    pub fn identity(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        for (name, bytes) in &self.files.files {
            hasher.update(&(name.len() as u64).to_le_bytes());
            hasher.update(name.as_bytes());
            hasher.update(blake3::hash(bytes).as_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }
}

/// The name of a file by a Content-Disposition.
fn file_name_of(disposition: &str) -> Option<String> {
    disposition.split(';').map(str::trim).find_map(|part| {
        let (key, value) = part.split_once('=')?;
        let value = value.trim().trim_matches('"');
        match key.trim().to_ascii_lowercase().as_str() {
            "filename" => Some(value.to_owned()),
            "filename*" => {
                let encoded = value.rsplit('\'').next()?;
                percent_encoding::percent_decode_str(encoded).decode_utf8().ok().map(Into::into)
            }
            _ => None,
        }
    })
}

async fn form(body: Bytes, boundary: String) -> Result<Upload, Problem> {
    let wrong = |e: multer::Error| Problem::new(Kind::Options, format!("the form: {e}"));
    let once = futures_util::stream::once(async { Ok::<_, std::io::Error>(body) });
    let mut parts = multer::Multipart::new(once, boundary);
    let mut upload = Upload::default();
    let mut files: Vec<(bool, String, Option<String>, Bytes)> = Vec::new();
    let mut count = 0;
    while let Some(part) = parts.next_field().await.map_err(wrong)? {
        count += 1;
        if count > PARTS {
            return Err(Problem::new(Kind::Options, format!("the form has more than {PARTS} parts")));
        }
        let is_model = part.name() == Some("model");
        let key = part.name().unwrap_or_default().to_owned();
        // Pages send files that were not chosen so: without a name.
        let told = part.file_name().filter(|name| !name.is_empty()).map(clean).transpose()?;
        let (name, is_unchosen) = (told, part.file_name().is_some_and(str::is_empty));
        let media_type = part.content_type().map(ToString::to_string);
        let bytes = part.bytes().await.map_err(wrong)?;
        match name {
            None if is_unchosen && bytes.is_empty() => {}
            None if !is_model => {
                let text = String::from_utf8(bytes.to_vec()).ok().filter(|text| text.len() <= LONGEST_FIELD);
                let text = text.ok_or_else(|| Problem::new(Kind::Options, format!("{key}: no text")))?;
                // Fields of pages that were left empty ask for nothing.
                if !text.is_empty() {
                    upload.fields.push((key, text));
                }
            }
            name => files.push((is_model, name.unwrap_or_default(), media_type, bytes)),
        }
    }
    let by_part = files.iter().position(|(is_model, ..)| *is_model);
    let by_name = || {
        let is_archive = |name: &str| media::extension(name) == "zip";
        let model = files.iter().position(|(_, name, ..)| is_model(name));
        model.or_else(|| files.iter().position(|(_, name, ..)| is_archive(name)))
    };
    let alone = || (files.len() == 1).then_some(0);
    let at = by_part.or_else(by_name).or_else(alone).ok_or_else(|| {
        Problem::new(
            Kind::Options,
            "the form has no model: a part that is called model, or a file with a model's name",
        )
    })?;
    let (_, name, media_type, model) = files.swap_remove(at);
    let mut beside = BTreeMap::new();
    for (_, name, _, bytes) in files {
        // The model may mean either of them.
        if let Some((name, _)) = beside.insert(name.clone(), bytes).map(|bytes| (name, bytes)) {
            return Err(Problem::new(
                Kind::Options,
                format!("the form has two files that are called '{name}'"),
            ));
        }
    }
    Ok(Upload { name, media_type, model, files: MemoryFiles { files: beside }, ..upload })
}

/// A relative name, as models write it.
fn clean(name: &str) -> Result<String, Problem> {
    let name = name.replace('\\', "/");
    let parts = name.split('/').filter(|part| !matches!(*part, "" | "." | ".."));
    let name = parts.collect::<Vec<_>>().join("/");
    let name: String = name.chars().filter(|c| !c.is_control()).collect();
    let wrong = |what: &str| Problem::new(Kind::Options, format!("a file of the form has {what}"));
    match name.len() {
        0 => Err(wrong("a name that names no file")),
        1..=LONGEST_NAME => Ok(name),
        _ => Err(wrong(&format!("a name of more than {LONGEST_NAME} bytes"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn upload(headers: &[(&str, &str)], body: &str) -> Result<Upload, Problem> {
        let mut all = HeaderMap::new();
        for (name, value) in headers {
            all.insert(axum::http::HeaderName::from_bytes(name.as_bytes()).unwrap(), value.parse().unwrap());
        }
        let body = Bytes::copy_from_slice(body.as_bytes());
        tokio::runtime::Builder::new_current_thread().build().unwrap().block_on(Upload::new(
            &all,
            body,
            Held::default(),
        ))
    }

    #[test]
    fn names_come_from_where_they_are() {
        for (headers, told, name) in [
            (&[("content-disposition", "attachment; filename=\"my car.GLB\"")][..], None, "model.glb"),
            (&[("content-disposition", "inline; filename*=UTF-8''b%C3%A4r.obj.gz")], None, "model.obj.gz"),
            (&[("content-type", "model/stl")], None, "model.stl"),
            (&[("content-type", "model/stl")], Some("x.ply"), "model.ply"),
            (&[("content-type", "text/plain")], Some("x.p<y"), "model"),
            (&[], None, "model"),
        ] {
            let mut upload = upload(headers, "x").unwrap();
            upload.settle_name(told, &Registry::default());
            assert_eq!(upload.name, name);
        }
    }

    #[test]
    fn forms_have_a_model_and_files_and_options() {
        let body = "--B\r\nContent-Disposition: form-data; name=\"size\"\r\n\r\n64\r\n\
            --B\r\nContent-Disposition: form-data; name=\"file\"; filename=\"t/../a.png\"\r\n\r\nP\r\n\
            --B\r\nContent-Disposition: form-data; name=\"file\"; filename=\"m.gltf\"\r\nContent-Type: model/gltf+json\r\n\r\n{}\r\n\
            --B--\r\n";
        let kind = ("content-type", "multipart/form-data; boundary=B");
        let mut form = upload(&[kind], body).unwrap();
        form.settle_name(None, &Registry::default());
        assert_eq!((form.name.as_str(), &form.model[..]), ("m.gltf", &b"{}"[..]));
        assert_eq!(form.fields, [("size".to_owned(), "64".to_owned())]);
        assert_eq!(form.files.files.keys().collect::<Vec<_>>(), ["t/a.png"]);
        for body in [
            "--B--\r\n",
            "--B\r\nContent-Disposition: form-data; name=\"size\"\r\n\r\n64\r\n--B--\r\n",
            "xyz",
        ] {
            assert_eq!(upload(&[kind], body).unwrap_err().kind, Kind::Options, "{body}");
        }
    }

    #[test]
    fn files_of_forms_have_names_of_their_own() {
        let kind = ("content-type", "multipart/form-data; boundary=B");
        let file = |name: &str, content: &str| {
            format!(
                "--B\r\nContent-Disposition: form-data; name=\"f\"; filename=\"{name}\"\r\n\r\n{content}\r\n"
            )
        };
        let of = |files: &[(&str, &str)]| {
            let parts: String = files.iter().map(|(name, content)| file(name, content)).collect();
            upload(&[kind], &format!("{parts}--B--\r\n"))
        };
        let long = "x".repeat(LONGEST_NAME + 1);
        for (name, what) in
            [("../a.png", "two files"), ("/a.png", "two files"), ("..", "names no file"), (&long, "300")]
        {
            let problem = of(&[("m.obj", "v"), ("a.png", "P"), (name, "Q")]).unwrap_err();
            assert_eq!(problem.kind, Kind::Options);
            assert!(problem.message.contains(what), "{name}: {}", problem.message);
        }
        // Nothing was chosen here.
        assert!(of(&[("m.obj", "v"), ("", "")]).unwrap().files.files.is_empty());
        // An archive has a model where nothing else is one.
        assert_eq!(of(&[("notes.txt", "x"), ("car.ZIP", "PK")]).unwrap().model, "PK");
        assert_eq!(of(&[("car.zip", "PK"), ("m.obj", "v")]).unwrap().model, "v");
    }
}
