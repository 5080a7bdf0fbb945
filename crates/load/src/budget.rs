//! Budget of memory: bytes granted to a file so far, held against its limit.
use crate::image::Header;
use crate::shares::{Pass, Shares};
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_scene::level_size;
use std::collections::BinaryHeap;

/// From so many bytes on the system is asked whether it has them.
const LARGE: u64 = 1 << 20;

/// Counts decoded bytes against [`Limits::decoded_bytes`]. Charged before memory is allocated, in the order of the
/// file and never from a worker thread, so that the same file meets the limit at the same element every time.
#[derive(Debug)]
pub(crate) struct Budget {
    used: u64,
    /// Bytes among them that textures take.
    textures: u64,
    limit: u64,
    /// Texels of textures as they are kept, against [`Limits::total_texture_pixels`].
    pixels: u64,
    pixel_limit: u64,
    /// Texels of textures as they are stored, against [`DECODED`] times as many.
    stored: u64,
    /// Bytes of textures that are made of others.
    made: u64,
    /// Shares of textures that the file names one by one.
    shares: Option<Shares>,
}

/// Part of all bytes, one in so many, that textures that are made of others take before all others are measured: they are decoded at
/// once, and if not all fit that was in vain.
const MADE: u64 = 8;

/// Texels that a file may store for each texel that may be kept: decoding takes time, and no memory where it goes by rows.
const DECODED: u64 = 8;

/// Texels up to which a texture is not made smaller.
const SMALL: u64 = 64 * 64;

/// Texture that asks for a part of the budget.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Claim {
    /// Width and height in texels, as it is stored.
    pub(crate) size: [u32; 2],
    /// Bytes that each texel takes.
    pub(crate) per_texel: u64,
    /// Mip level that is the finest one kept; 0 is the image itself.
    pub(crate) finest: u32,
    /// Bytes that decoding takes for a while.
    pub(crate) transient: u64,
    /// Beyond what may be decoded.
    pub(crate) left_out: bool,
    /// It is made of others, which are decoded for themselves.
    pub(crate) is_made: bool,
}

impl Claim {
    /// Claim to the whole of a texture.
    pub(crate) fn new(size: [u32; 2], per_texel: u64) -> Self {
        Self { size, per_texel, finest: 0, transient: 0, left_out: false, is_made: false }
    }

    /// Claim to the whole of a texture that is made of others.
    fn made(size: [u32; 2], per_texel: u64) -> Self {
        Self { is_made: true, ..Self::new(size, per_texel) }
    }

    /// Claim to the whole of a picture with this header, or to as much as one picture may have.
    pub(crate) fn of(header: &Header, per_texel: u64) -> Self {
        let (transient, finest) = (header.transient_bytes(), header.excess());
        Self { transient, finest, ..Self::new([header.width, header.height], per_texel) }
    }

    /// The claim to as many of its levels as the limit of one texture allows.
    pub(crate) fn within(mut self, limits: &Limits) -> Self {
        while self.texels() > limits.texture_pixels && self.texels() > 1 {
            self.finest = self.finest.saturating_add(1);
        }
        self
    }

    /// Texels that are kept.
    fn texels(&self) -> u64 {
        if self.left_out { 0 } else { area(level_size(self.size, self.finest)) }
    }

    /// Kept texels that count as texels of textures.
    fn pixels(&self) -> u64 {
        if self.is_made { 0 } else { self.texels() }
    }

    /// Texels that are decoded.
    fn stored(&self) -> u64 {
        if self.is_made { 0 } else { area(self.size) }
    }

    fn bytes(&self) -> u64 {
        self.texels().saturating_mul(self.per_texel)
    }

    /// Takes one of equal shares: the finest levels go while they are larger.
    pub(crate) fn reduce_to(&mut self, share: &mut Share) {
        let stored = self.stored();
        if stored > share.largest || stored == share.largest && share.count == 0 {
            self.left_out = true;
            return;
        }
        if stored == share.largest {
            share.count = share.count.saturating_sub(1);
        }
        while self.texels() > share.texels && self.texels() > SMALL {
            self.finest = self.finest.saturating_add(1);
        }
    }
}

/// Part of a budget that each of several textures may have: depending on their sizes only, so that equals are kept equally.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Share {
    /// Most texels that are kept, but for textures of [`SMALL`] and fewer.
    texels: u64,
    /// Stored texels of the largest that are decoded,
    largest: u64,
    /// and number of those that have so many.
    count: u64,
}

/// Texels of an image. Two numbers of 32 bits have a product of 64.
fn area([width, height]: [u32; 2]) -> u64 {
    u64::from(width).saturating_mul(height.into())
}

impl Budget {
    /// Budget of which nothing is used yet.
    pub(crate) fn new(limits: &Limits) -> Self {
        Self {
            used: 0,
            limit: limits.decoded_bytes,
            pixels: 0,
            pixel_limit: limits.total_texture_pixels,
            textures: 0,
            stored: 0,
            made: 0,
            shares: None,
        }
    }

    /// Budget of which nothing is used yet, for a reader that names textures one by one: they are granted by [`Budget::grant`].
    pub(crate) fn shared(limits: &Limits, shares: &Shares) -> Self {
        shares.start();
        Self { shares: Some(shares.clone()), ..Self::new(limits) }
    }

    /// Grants `count` elements of `size` bytes.
    ///
    /// # Errors
    /// [`LimitExceeded`] naming `what` if that is more than what is left.
    pub(crate) fn charge(
        &mut self,
        what: impl FnOnce() -> String,
        count: u64,
        size: u64,
    ) -> Result<(), LimitExceeded> {
        let bytes = count.saturating_mul(size);
        let asked = self.used.saturating_add(bytes);
        if asked <= self.limit && bytes >= LARGE {
            Limits::check_memory(what, bytes)?;
        } else {
            Limits::check(what, asked, self.limit, "decoded_bytes")?;
        }
        self.used = asked;
        if let Some(shares) = &self.shares {
            shares.count_others(self.used.saturating_sub(self.textures));
        }
        Ok(())
    }

    /// Grants bytes of textures.
    fn charge_bytes(
        &mut self,
        what: impl FnOnce() -> String,
        count: u64,
        size: u64,
    ) -> Result<(), LimitExceeded> {
        let bytes = count.saturating_mul(size);
        self.textures = self.textures.saturating_add(bytes);
        let granted = self.charge(what, count, size);
        if granted.is_err() {
            self.textures = self.textures.saturating_sub(bytes);
        }
        granted
    }

    /// Grants a texture that is one of many, as finely as its share allows; false if it is only measured this time.
    ///
    /// # Errors
    /// [`LimitExceeded`] naming it, if it is to be left out.
    pub(crate) fn grant(&mut self, name: &str, claim: &mut Claim) -> Result<bool, LimitExceeded> {
        let what = || name.to_owned();
        let Some(shares) = self.shares.clone() else {
            self.fit_one(claim);
            return self.charge_texture(what, claim).map(|()| true);
        };
        match shares.pass() {
            Pass::Trial => {
                shares.note(*claim);
                let is_granted = self.charge_texture(what, claim).is_ok();
                if is_granted {
                    shares.say_reduced(name, claim.size, claim.finest);
                } else {
                    shares.measure();
                }
                Ok(is_granted)
            }
            Pass::Survey => {
                shares.note(*claim);
                Ok(false)
            }
            Pass::Shared => {
                shares.reduce(claim);
                if claim.left_out {
                    let what =
                        format!("{name}, with the texels of textures that are no larger as they are stored");
                    return Err(LimitExceeded::beyond(&what, self.stored_limit(), "total_texture_pixels"));
                }
                self.charge_texture(what, claim)?;
                shares.say_reduced(name, claim.size, claim.finest);
                Ok(true)
            }
        }
    }

    /// Grants a texture that is made of others, of so many bytes for each texel; its size, or `None` if it is only measured this time.
    ///
    /// # Errors
    /// [`LimitExceeded`] naming it, if it is to be left out.
    pub(crate) fn grant_made(
        &mut self,
        name: &str,
        size: [u32; 2],
        per_texel: u64,
    ) -> Result<Option<[u32; 2]>, LimitExceeded> {
        let mut claim = Claim::made(size, per_texel);
        let Some(shares) = self.shares.clone() else {
            return self.charge(|| name.to_owned(), area(size), per_texel).map(|()| Some(size));
        };
        match shares.pass() {
            Pass::Trial => {
                shares.note(claim);
                self.made = self.made.saturating_add(claim.bytes());
                let is_granted = self.made <= self.limit / MADE
                    && self.charge_bytes(String::new, area(size), per_texel).is_ok();
                if !is_granted {
                    shares.measure();
                }
                Ok(is_granted.then_some(size))
            }
            Pass::Survey => {
                shares.note(claim);
                Ok(None)
            }
            Pass::Shared => {
                // It is as small as its parts are, as a rule.
                shares.reduce(&mut claim);
                self.charge_bytes(|| name.to_owned(), claim.texels(), per_texel)?;
                shares.say_reduced(name, size, claim.finest);
                Ok(Some(level_size(size, claim.finest)))
            }
        }
    }

    /// Makes textures fit into what is left, if they do not: the largest beyond what may be decoded are left out, then again and
    /// again the largest lose their finest level. Those of [`SMALL`] and fewer texels stay as they are.
    pub(crate) fn fit(&self, claims: &mut [Claim]) {
        let mut share = self.share(claims, false);
        claims.iter_mut().for_each(|claim| claim.reduce_to(&mut share));
    }

    /// Equal shares of textures that claims are to the whole of, into what is left, if they do not fit. All else may be granted
    /// already.
    pub(crate) fn share(&self, claims: &[Claim], is_last: bool) -> Share {
        let mut share = self.decodable(claims);
        let (mut claims, mut decoded) = (claims.to_vec(), share);
        claims.iter_mut().for_each(|claim| claim.reduce_to(&mut decoded));
        let (mut pixels, mut bytes) = claims
            .iter()
            .fold((0_u64, 0_u64), |(p, b), c| (p.saturating_add(c.pixels()), b.saturating_add(c.bytes())));
        let pixel_room = self.pixel_limit.saturating_sub(self.pixels);
        let transient = claims.iter().map(|claim| claim.transient).max().unwrap_or(0);
        let left = self.left().saturating_sub(transient);
        if pixels <= pixel_room && bytes <= left {
            return share;
        }
        // Geometry comes after them.
        let byte_room = if bytes > left && !is_last { left / 2 } else { left };
        let mut largest: BinaryHeap<(u64, usize)> =
            claims.iter().enumerate().map(|(k, claim)| (claim.texels(), k)).collect();
        while pixels > pixel_room || bytes > byte_room {
            let Some((most, _)) = largest.peek().copied().filter(|(texels, _)| *texels > SMALL) else {
                break;
            };
            share.texels = most.saturating_sub(1);
            // Equals together.
            while largest.peek().is_some_and(|(texels, _)| *texels == most) {
                let Some((_, k)) = largest.pop() else { break };
                let Some(claim) = claims.get_mut(k) else { break };
                let before = (claim.pixels(), claim.bytes());
                claim.finest = claim.finest.saturating_add(1);
                pixels = pixels.saturating_sub(before.0).saturating_add(claim.pixels());
                bytes = bytes.saturating_sub(before.1).saturating_add(claim.bytes());
                largest.push((claim.texels(), k));
            }
        }
        share
    }

    /// Share without the largest textures, as many as are more than may be decoded.
    fn decodable(&self, claims: &[Claim]) -> Share {
        let mut share = Share { texels: u64::MAX, largest: u64::MAX, count: u64::MAX };
        let mut room = self.stored_limit().saturating_sub(self.stored);
        let mut sizes: Vec<u64> = claims.iter().map(Claim::stored).collect();
        sizes.sort_unstable();
        for same in sizes.chunk_by(|a, b| a == b) {
            let Some(&texels) = same.first() else { continue };
            let count = same.len() as u64;
            let fitting = room.checked_div(texels).unwrap_or(u64::MAX).min(count);
            if fitting < count && texels > SMALL {
                return Share { largest: texels, count: fitting, ..share };
            }
            room = room.saturating_sub(texels.saturating_mul(count));
        }
        share.count = u64::MAX;
        share
    }

    /// Most texels of textures as they are stored.
    fn stored_limit(&self) -> u64 {
        self.pixel_limit.saturating_mul(DECODED)
    }

    /// Makes one of several textures fit, of which the others are not known: into half of the texels and a quarter of the bytes that
    /// are left for them, if need be, so that something is left for later ones.
    pub(crate) fn fit_one(&self, claim: &mut Claim) {
        let pixels = self.pixel_limit.saturating_sub(self.pixels) / 2;
        // Geometry that comes after them has an eighth for itself.
        let bytes = self.left().saturating_sub(claim.transient).saturating_sub(self.limit / 8) / 4;
        while claim.texels() > SMALL && (claim.texels() > pixels || claim.bytes() > bytes) {
            claim.finest = claim.finest.saturating_add(1);
        }
    }

    /// Grants a texture.
    ///
    /// # Errors
    /// [`LimitExceeded`] naming `what` if its texels are too many together with those of the textures before, or if decoding it
    /// takes more than what is left then.
    pub(crate) fn charge_texture(
        &mut self,
        what: impl Fn() -> String,
        claim: &Claim,
    ) -> Result<(), LimitExceeded> {
        let asked = self.pixels.saturating_add(claim.texels());
        Limits::check(&what, asked, self.pixel_limit, "total_texture_pixels")?;
        let stored = self.stored.saturating_add(area(claim.size));
        let all = || format!("{}, with the texels of textures before it as they are stored", what());
        Limits::check(all, stored, self.stored_limit(), "total_texture_pixels")?;
        self.charge_bytes(&what, claim.texels(), claim.per_texel)?;
        Limits::check(what, claim.transient, self.left(), "decoded_bytes")?;
        (self.pixels, self.stored) = (asked, stored);
        Ok(())
    }

    /// Bytes that can still be granted.
    pub(crate) fn left(&self) -> u64 {
        self.limit.saturating_sub(self.used)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grants_up_to_the_limit_and_not_one_byte_more() {
        let mut budget = Budget::new(&Limits::default().with_decoded_bytes(100));
        budget.charge(|| "a".into(), 10, 6).unwrap();
        assert_eq!(budget.left(), 40);
        let error = budget.charge(|| "accessor 3".into(), 41, 1).unwrap_err();
        assert_eq!(error.to_string(), "accessor 3: 101 exceeds the limit of 100 (decoded_bytes)");
        // A refusal takes nothing.
        budget.charge(|| "b".into(), 40, 1).unwrap();
        assert_eq!(budget.left(), 0);
        budget.charge(|| "c".into(), u64::MAX, u64::MAX).unwrap_err();
    }

    #[test]
    fn textures_are_counted_in_pixels_too() {
        let claim = |pixels: u32| Claim::new([pixels, 1], 4);
        let mut budget = Budget::new(&Limits::default().with_total_texture_pixels(100));
        budget.charge_texture(|| "a".into(), &claim(60)).unwrap();
        let error = budget.charge_texture(|| "image 1".into(), &claim(41)).unwrap_err();
        assert_eq!(error.to_string(), "image 1: 101 exceeds the limit of 100 (total_texture_pixels)");
        budget.charge_texture(|| "b".into(), &claim(40)).unwrap();
        budget.charge_texture(|| "c".into(), &Claim::new([u32::MAX; 2], u64::MAX)).unwrap_err();
        // Stored texels may be eight times as many as kept ones.
        let halved = Claim { finest: 1, ..Claim::new([2, 2], 4) };
        let mut budget = Budget::new(&Limits::default().with_total_texture_pixels(100));
        for _ in 0..100 {
            budget.charge_texture(|| "d".into(), &halved).unwrap();
        }
        let mut budget = Budget::new(&Limits::default().with_total_texture_pixels(100));
        let quartered = Claim { finest: 2, ..Claim::new([4, 4], 4) };
        for _ in 0..50 {
            budget.charge_texture(|| "e".into(), &quartered).unwrap();
        }
        let error = budget.charge_texture(|| "image 50".into(), &quartered).unwrap_err().to_string();
        assert!(
            error.starts_with("image 50, with ")
                && error.ends_with("816 exceeds the limit of 800 (total_texture_pixels)")
        );
    }

    #[test]
    fn the_largest_textures_become_smaller_until_all_fit() {
        let levels = |limits: Limits, sizes: &[[u32; 2]]| {
            let mut claims: Vec<_> = sizes.iter().map(|&size| Claim::new(size, 6)).collect();
            let mut budget = Budget::new(&limits);
            budget.fit(&mut claims);
            let charged = claims.iter().try_for_each(|claim| budget.charge_texture(String::new, claim));
            (claims.iter().map(|claim| claim.finest).collect::<Vec<_>>(), charged.is_ok())
        };
        let pixels = |pixels| Limits::default().with_total_texture_pixels(pixels);
        let sizes = [[1024, 1024], [512, 512], [1024, 1024], [256, 128]];
        let all = 2 * (1 << 20) + (1 << 18) + (1 << 15);
        assert_eq!(levels(pixels(all), &sizes), (vec![0; 4], true));
        // Equals together.
        assert_eq!(levels(pixels(all - 1), &sizes), (vec![1, 0, 1, 0], true));
        assert_eq!(levels(pixels(1 << 20), &sizes), (vec![1, 0, 1, 0], true));
        assert_eq!(levels(pixels(600_000), &sizes), (vec![2, 1, 2, 0], true));
        assert_eq!(levels(Limits::default().with_decoded_bytes(6 * all), &sizes), (vec![0; 4], true));
        assert_eq!(
            levels(Limits::default().with_decoded_bytes(6 * all - 1), &sizes),
            (vec![1, 0, 1, 0], true)
        );
        // Small ones stay, and are refused.
        assert_eq!(levels(pixels(4096), &[[64, 64], [64, 64]]), (vec![0, 0], false));
        assert!(!levels(pixels(0), &[[u32::MAX; 2]]).1);

        // The last of the largest are left out where they are more than may be decoded, and nothing of them is charged.
        let mut claims = [[512, 512], [256, 256], [512, 512], [64, 64]].map(|size| Claim::new(size, 6));
        let mut budget = Budget::new(&pixels((1 << 16) - 1));
        budget.fit(&mut claims);
        assert_eq!(claims.map(|claim| claim.left_out), [false, false, true, false]);
        for claim in claims.iter().filter(|claim| !claim.left_out) {
            budget.charge_texture(String::new, claim).unwrap();
        }

        let budget = Budget::new(&pixels(1 << 20));
        let one = |size| {
            let mut claim = Claim::new(size, 6);
            budget.fit_one(&mut claim);
            claim.finest
        };
        assert_eq!([[512, 512], [1024, 512], [1024, 1024], [1 << 20, 1]].map(one), [0, 0, 1, 1]);

        // Hundreds of them leave most of an eighth of the bytes to what comes after: those of a few texels stay as they are.
        let mut budget = Budget::new(&Limits::default().with_decoded_bytes(64 << 20));
        for _ in 0..200 {
            let mut claim = Claim::new([1024, 1024], 4);
            budget.fit_one(&mut claim);
            if budget.charge_texture(String::new, &claim).is_err() {
                break;
            }
        }
        assert!(budget.left() >= 4 << 20, "{}", budget.left());
    }
}
