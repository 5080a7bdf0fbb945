//! Arguments of the command line.

use crate::keys::KEYS;
use overcoat::render::Quality;
use overcoat::scene::ShadingModel;
use std::ffi::OsString;
use std::path::PathBuf;

const HELP: &str = "\
Shows a model in a window, drawn by the processor alone

Usage: overcoat-viewer [OPTIONS] [MODEL]

  MODEL               a file of any format that overcoat reads; or drop one on the window
  --size WxH          of the window in pixels [default: 1280x720]
  --quality TIER      reached when nothing moves: draft, fast, good, best [default: good]
  --shading MODEL     of all materials, as `overcoat formats` lists them [default: those of the materials]
  --threads N         [default: one per processor]
  --frames N          turns the model so many times, says how fast that was, and ends

In the window:
";

/// Text of `--help`.
pub fn help() -> String {
    let keys = KEYS.map(|[key, meaning]| format!("  {key:24}{meaning}\n"));
    format!("{HELP}{}", keys.concat())
}

/// Arguments as parsed.
#[derive(Clone, Debug)]
pub struct Arguments {
    pub model: Option<PathBuf>,
    pub size: [u32; 2],
    pub quality: Quality,
    pub shading: Option<ShadingModel>,
    pub threads: usize,
    pub frames: Option<u32>,
}

impl Arguments {
    /// `None` if help is asked for.
    pub fn from_env() -> Result<Option<Self>, String> {
        Self::parse(std::env::args_os().skip(1))
    }

    fn parse(mut words: impl Iterator<Item = OsString>) -> Result<Option<Self>, String> {
        let mut own = Self {
            model: None,
            size: [1280, 720],
            quality: Quality::Good,
            shading: None,
            threads: 0,
            frames: None,
        };
        while let Some(word) = words.next() {
            let option =
                word.to_str().filter(|text| text.starts_with('-') && text.len() > 1).map(str::to_owned);
            let Some(option) = option else {
                if own.model.replace(word.into()).is_some() {
                    return Err("one model at a time (see --help)".to_owned());
                }
                continue;
            };
            if option == "-h" || option == "--help" {
                return Ok(None);
            }
            let value = words.next().and_then(|value| value.into_string().ok());
            let value = value.ok_or_else(|| format!("{option} wants a value (see --help)"))?;
            let wrong = |allowed: &str| format!("{option}: '{value}' is not {allowed}");
            match option.as_str() {
                "--size" => {
                    own.size = size(&value).ok_or_else(|| wrong("a width and a height, as 1280x720"))?
                }
                "--quality" => {
                    own.quality =
                        Quality::from_name(&value).ok_or_else(|| wrong("draft, fast, good or best"))?;
                }
                "--shading" => {
                    own.shading =
                        Some(ShadingModel::from_name(&value).ok_or_else(|| wrong("a shading model"))?);
                }
                "--threads" => own.threads = value.parse().map_err(|_| wrong("a number"))?,
                "--frames" => {
                    let frames = value.parse().ok().filter(|frames| *frames > 0);
                    own.frames = Some(frames.ok_or_else(|| wrong("a number from 1 on"))?);
                }
                _ => return Err(format!("there is no option {option} (see --help)")),
            }
        }
        Ok(Some(own))
    }
}

fn size(text: &str) -> Option<[u32; 2]> {
    let (width, height) = text.split_once('x')?;
    let side = |text: &str| text.parse().ok().filter(|side| (1..=16384).contains(side));
    Some([side(width)?, side(height)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(words: &[&str]) -> Result<Option<Arguments>, String> {
        Arguments::parse(words.iter().map(OsString::from))
    }

    #[test]
    fn words_are_taken_and_nonsense_is_named() {
        let own =
            parse(&["a.glb", "--size", "40x30", "--quality", "draft", "--frames", "7"]).unwrap().unwrap();
        assert_eq!((own.model, own.size, own.frames), (Some("a.glb".into()), [40, 30], Some(7)));
        assert_eq!(own.quality, Quality::Draft);
        assert!(parse(&["--help"]).unwrap().is_none());
        for (words, part) in [
            (&["--size"][..], "--size wants a value"),
            (&["--size", "0x9"], "--size: '0x9' is not a width and a height"),
            (&["--frames", "0"], "'0' is not a number from 1 on"),
            (&["--shading", "cel"], "'cel' is not a shading model"),
            (&["--speed", "9"], "no option --speed"),
            (&["a", "b"], "one model at a time"),
        ] {
            let error = parse(words).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }
}
