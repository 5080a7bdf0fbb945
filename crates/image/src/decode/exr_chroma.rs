//! Luminance and chroma of OpenEXR: `Y`, and `RY` and `BY` with a sample for every other pixel of every other row.

use super::DecodeError;
use super::exr_sampling::fill_between;
use super::openexr::{File, floats, for_each_block, for_each_run};
use exr::meta::MetaData;
use exr::meta::header::Header;
use overcoat_core::color::primaries::Primaries;

/// Layer whose colours are luminance and chroma, and which of its channels are Y, RY and BY.
pub(super) struct ChromaLayer<'a> {
    pub index: usize,
    pub header: &'a Header,
    channels: [usize; 3],
}

impl<'a> ChromaLayer<'a> {
    pub fn choose(meta: &'a MetaData) -> Option<Self> {
        meta.headers.iter().enumerate().find_map(|(index, header)| {
            let list = &header.channels.list;
            let find = |wanted: &str| list.iter().position(|c| is_called(&c.name.to_string(), wanted));
            let channels = [find("Y")?, find("RY")?, find("BY")?];
            let y = list.get(channels[0])?;
            (y.sampling.area() == 1).then_some(Self { index, header, channels })
        })
    }

    /// Colours, row by row. Y is the luminance of primaries with these weights, RY and BY are (R - Y) / Y and (B - Y) / Y
    /// (`ImfRgbaYca.h`). Between the samples, chroma is their mean; OpenEXR's own reader has a filter of 27 samples there.
    pub fn read(&self, file: &File<'_>, weights: [f32; 3]) -> Result<Vec<[f32; 3]>, DecodeError> {
        let (width, area) = (self.header.layer_size.width(), self.header.layer_size.area());
        let mut planes = [(); 3].map(|()| vec![0.0; area]);
        for_each_block(
            file,
            |index| index == self.index,
            |_, block| {
                for_each_run(self.header, block, |channel, [x, y], bytes| {
                    for (plane, _) in planes.iter_mut().zip(self.channels).filter(|(_, own)| *own == channel)
                    {
                        let description = self.header.channels.list.get(channel)?;
                        let start = y.checked_mul(width)?.checked_add(x)?;
                        let row = plane.get_mut(start..)?;
                        let targets = row.iter_mut().step_by(description.sampling.x().max(1));
                        floats(description.sample_type, bytes, targets);
                    }
                    Some(())
                })
            },
        )?;
        for (plane, channel) in planes.iter_mut().zip(self.channels) {
            let Some(description) = self.header.channels.list.get(channel) else { continue };
            fill_between(plane, width, [description.sampling.x(), description.sampling.y()]);
        }
        let [y, ry, by] = planes;
        let chroma = ry.iter().zip(&by);
        Ok(y.iter().zip(chroma).map(|(y, (ry, by))| color(*y, [*ry, *by], weights)).collect())
    }
}

/// True of a channel of that name, in a layer or not.
fn is_called(name: &str, wanted: &str) -> bool {
    name.rsplit('.').next().is_some_and(|last| last.eq_ignore_ascii_case(wanted))
}

/// Red, green and blue whose weighted sum is the luminance.
fn color(y: f32, [ry, by]: [f32; 2], [wr, wg, wb]: [f32; 3]) -> [f32; 3] {
    let (r, b) = ((ry + 1.0) * y, (by + 1.0) * y);
    [r, (y - r * wr - b * wb) / wg, b]
}

/// Luminance of red, green and blue of Rec. 709 (ITU-R BT.709-6, item 3.2, to six places).
const REC_709: [f64; 3] = [0.212_639, 0.715_169, 0.072_192];

/// Luminance of red, green and blue: that of the colours of Rec. 709 that the primaries are. Those of Rec. 709 themselves where the
/// primaries are no colour space or green has no luminance.
pub(super) fn weights(primaries: Option<Primaries>) -> [f32; 3] {
    let matrix = primaries.and_then(|primaries| primaries.to_rec_709());
    let own = matrix.map(|[r, g, b]| {
        [0, 1, 2].map(|k: usize| {
            let column = [&r, &g, &b].map(|row| row.get(k).copied().unwrap_or(0.0));
            column.iter().zip(REC_709).map(|(share, weight)| share * weight).sum::<f64>()
        })
    });
    own.filter(|[_, green, _]| *green > 1e-3).unwrap_or(REC_709).map(|weight| weight as f32)
}
