//! Animations of the file: which there are, and the one that is played.
//!
//! Channels that cannot be played are left out with a warning that names them; a limit that they exceed ends the
//! loading.

use super::FORMAT;
use super::accessor::{self, Component, Pick};
use super::buffers::Buffers;
use super::list::{Element, Index, label};
use super::model::{self, Kind, Root};
use super::pointer::Target;
use super::pose::Pose;
use super::sample::{Curve, Interpolation};
use crate::budget::Budget;
use crate::warnings::Warnings;
use crate::{AnimationInfo, Context, LoadError};
use overcoat_core::limits::Limits;
use overcoat_core::suggest::{nearest_name, suggestion};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Channels of an animation that can be played, before their key frames are read.
pub(super) struct Channels {
    /// Number of the animation.
    index: usize,
    /// Number of each channel, what it changes, and its sampler.
    list: Vec<(usize, Target, Index)>,
}

/// An animation that can be played.
pub(super) struct Animation {
    tracks: Vec<(Target, Arc<Curve>)>,
}

/// The animation with a name, else with a number.
///
/// # Errors
/// [`LoadError::NoSuch`] with those that there are.
pub(super) fn choose(root: &Root, chosen: &str) -> Result<usize, LoadError> {
    let by_name = root.animations.iter().position(|a| a.name.as_deref() == Some(chosen));
    let by_number = || chosen.parse().ok().filter(|&k| k < root.animations.len());
    if let Some(index) = by_name.or_else(by_number) {
        return Ok(index);
    }
    let names = root.animations.iter().enumerate().take(20);
    let mut known: Vec<String> = names.map(|(k, a)| label::<Named>(k, a.name.as_deref())).collect();
    let unlisted = root.animations.len().saturating_sub(known.len());
    if unlisted > 0 {
        known.push(format!("and {unlisted} more"));
    }
    let known = if known.is_empty() { " none".to_owned() } else { known.join(",") };
    let shown: String = chosen.escape_debug().take(64).collect();
    // Files may have very many: only the first are looked at.
    let names = root.animations.iter().take(1000).filter_map(|a| a.name.as_deref());
    let nearest = nearest_name(chosen, names).map(|name| name.escape_debug().take(64).collect::<String>());
    let hint = suggestion(nearest.as_deref());
    Err(LoadError::no_such(format!("there is no animation '{shown}'; the file has{known}{hint}")))
}

/// For lists of what there is: only the number before the name.
struct Named;
impl Element for Named {
    const KIND: &'static str = "";
}

/// Finds what an animation changes. Reads no data yet.
///
/// # Errors
/// [`LoadError::Limit`] if it has too many channels.
pub(super) fn channels(
    root: &Root,
    index: usize,
    limits: &Limits,
    warnings: &mut Warnings,
) -> Result<Channels, LoadError> {
    let given = root.animations.at(index)?;
    let count = given.channels.len() as u64;
    Limits::check(|| format!("{}: channels", name(root, index)), count, limits.nodes, "nodes")?;
    let mut list: Vec<(usize, Target, Index)> = Vec::new();
    let mut last: BTreeMap<Target, usize> = BTreeMap::new();
    for (k, channel) in given.channels.iter().enumerate() {
        let target = match target(root, channel) {
            Ok(Some(target)) => target,
            Ok(None) => continue,
            Err(reason) => {
                warnings.add(|| format!("{}: {reason}; left out", channel_name(root, index, k)));
                continue;
            }
        };
        let Some(sampler) = channel.sampler.filter(|s| s.get() < given.samplers.len()) else {
            warnings.add(|| format!("{}: it has no sampler; left out", channel_name(root, index, k)));
            continue;
        };
        if let Some(earlier) = last.insert(target, k) {
            let earlier = channel_name(root, index, earlier);
            warnings.add(|| format!("{earlier}: channel {k} changes the same; left out"));
        }
        list.push((k, target, sampler));
    }
    list.retain(|(k, target, _)| last.get(target) == Some(k));
    Ok(Channels { index, list })
}

/// Target of a channel; `None` if it animates nothing. The error says why it cannot be played.
fn target(root: &Root, channel: &model::Channel) -> Result<Option<Target>, String> {
    let given = &channel.target;
    let target = match given.path.as_str() {
        "pointer" => {
            let pointer = given.extensions.as_deref().and_then(|e| e.pointer.as_ref());
            let pointer = pointer.map_or("", |p| p.pointer.as_str());
            let shown = || pointer.escape_debug().take(120).collect::<String>();
            Target::of_pointer(root, pointer)
                .ok_or_else(|| format!("the pointer '{}' cannot be played", shown()))?
        }
        path => {
            // Such channels are for extensions that the file uses elsewhere.
            let Some(node) = given.node else { return Ok(None) };
            if node.get() >= root.nodes.len() {
                return Err(format!("there is no node {node}"));
            }
            let shown = || path.escape_debug().take(32).collect::<String>();
            Target::of_node(node.get(), path).ok_or_else(|| format!("unknown path '{}'", shown()))?
        }
    };
    match target {
        Target::Translation(node) | Target::Rotation(node) | Target::Scale(node)
            if root.nodes.get(node).is_some_and(|node| node.matrix.is_some()) =>
        {
            Err(format!("node {node} has a matrix, which cannot be animated"))
        }
        Target::Weights(_) | Target::MeshWeights(_) if target.width(root) == 0 => {
            Err("there are no morph targets".to_owned())
        }
        _ => Ok(Some(target)),
    }
}

impl Channels {
    /// Animated properties, in the order of the channels.
    pub(super) fn targets(&self) -> impl Iterator<Item = Target> {
        self.list.iter().map(|(_, target, _)| *target)
    }

    /// Reads the key frames.
    ///
    /// # Errors
    /// [`LoadError::Limit`] naming the channel; errors of reading buffers.
    pub(super) fn read(
        &self,
        root: &Root,
        buffers: &mut Buffers<'_>,
        context: &Context<'_>,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<Animation, LoadError> {
        let mut tracks = Vec::new();
        // The meaning of a sampler depends on its target.
        let mut known: BTreeMap<(Index, usize, bool), Option<Arc<Curve>>> = BTreeMap::new();
        for &(k, target, sampler) in &self.list {
            let width = target.width(root);
            let rotation = matches!(target, Target::Rotation(_));
            // Memory of the channel's values in a pose.
            budget.charge(|| channel_name(root, self.index, k), width as u64, 16)?;
            let curve = match known.get(&(sampler, width, rotation)) {
                Some(curve) => curve.clone(),
                None => {
                    let channel =
                        Sampled { root, animation: self.index, channel: k, sampler, width, rotation };
                    let read = match channel.read(buffers, context, budget, warnings) {
                        Ok(curve) => curve,
                        Err(LoadError::Malformed { message, .. }) => {
                            let name = channel_name(root, self.index, k);
                            warnings.add(|| format!("{name}: {message}; left out"));
                            None
                        }
                        Err(other) => return Err(other),
                    };
                    let curve = read.map(Arc::new);
                    known.insert((sampler, width, rotation), curve.clone());
                    curve
                }
            };
            tracks.extend(curve.map(|curve| (target, curve)));
        }
        if tracks.is_empty() {
            warnings.add(|| format!("{} changes nothing", name(root, self.index)));
        }
        Ok(Animation { tracks })
    }
}

/// A sampler as a channel uses it.
struct Sampled<'a> {
    root: &'a Root,
    animation: usize,
    channel: usize,
    sampler: Index,
    width: usize,
    rotation: bool,
}

impl Sampled<'_> {
    /// `Err` with [`LoadError::Malformed`] where it cannot be played.
    fn read(
        &self,
        buffers: &mut Buffers<'_>,
        context: &Context<'_>,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<Option<Curve>, LoadError> {
        let (root, width) = (self.root, self.width);
        let what = || channel_name(root, self.animation, self.channel);
        let malformed = |message: String| LoadError::malformed(FORMAT, message);
        let given = root.animations.at(self.animation)?.samplers.at(self.sampler.get())?;
        let interpolation = match given.interpolation.as_deref() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(other) => {
                let shown: String = other.escape_debug().take(32).collect();
                return Err(malformed(format!("unknown interpolation '{shown}'")));
            }
        };
        let (Some(input), Some(output)) = (given.input, given.output) else {
            return Err(malformed("its sampler lacks input or output".to_owned()));
        };
        let keys = accessor::get(root, input)?.count.0;
        let each = (width as u64).saturating_mul(interpolation.parts() as u64);
        let stored = accessor::get(root, output)?;
        let numbers = stored.count.0.saturating_mul(stored.kind.components() as u64);
        if numbers != keys.saturating_mul(each) {
            return Err(malformed(format!("{numbers} numbers for {keys} key frames of {each}")));
        }
        if keys == 0 {
            return Err(malformed("it has no key frames".to_owned()));
        }
        // Read as they are, then as numbers in a row.
        budget.charge(what, keys.saturating_mul(each.saturating_add(1)), 8)?;
        for index in [input, output] {
            accessor::require(root, index, buffers, context, budget)?;
        }
        buffers.decompress(context.jobs)?;
        let times = accessor::resolve(root, buffers, input)?;
        if times.kind != Kind::Scalar {
            return Err(malformed(format!("accessor {input} does not hold times")));
        }
        let times = times.floats::<1>(&Pick::Range(0..times.count))?.into_iter().flatten().collect();
        let mut values = accessor::resolve(root, buffers, output)?;
        // The specification knows normalised integers only, and some writers forget to say so; but what a pointer leads
        // to may be any number.
        values.normalized |= self.rotation && values.component != Component::F32;
        let all = Pick::Range(0..values.count);
        let values: Vec<f32> = match values.kind {
            Kind::Scalar => values.floats::<1>(&all)?.into_iter().flatten().collect(),
            Kind::Vec2 => values.floats::<2>(&all)?.into_iter().flatten().collect(),
            Kind::Vec3 => values.floats::<3>(&all)?.into_iter().flatten().collect(),
            Kind::Vec4 => values.floats::<4>(&all)?.into_iter().flatten().collect(),
            Kind::Mat4 | Kind::Other => {
                return Err(malformed(format!("accessor {output} has elements of the wrong type")));
            }
        };
        if !values.iter().all(|v| v.is_finite()) {
            return Err(malformed("a value is not a finite number".to_owned()));
        }
        let (curve, lost) = Curve::new(times, values, width, interpolation, self.rotation);
        if lost > 0 {
            warnings.add(|| format!("{}: {lost} key frames whose times do not ascend are left out", what()));
        }
        Ok(curve)
    }
}

impl Animation {
    /// The time of the last key frame in seconds.
    pub(super) fn length(&self) -> f64 {
        self.tracks.iter().map(|(_, curve)| curve.end()).fold(0.0, |a, b| if b > a { b } else { a })
    }

    /// Moments of all key frames in seconds, ascending, from 0 on; evenly chosen among them if there are more than `most`.
    pub(super) fn moments(&self, most: usize) -> Vec<f64> {
        let keys = self.tracks.iter().flat_map(|(_, curve)| curve.times());
        let mut all: Vec<f64> = keys.map(|&time| f64::from(time)).filter(|&time| time > 0.0).collect();
        all.sort_unstable_by(f64::total_cmp);
        all.dedup();
        let step = all.len().div_ceil(most.max(1)).max(1);
        // The last one is among them.
        let skipped = all.len().checked_sub(1).and_then(|last| last.checked_rem(step)).unwrap_or(0);
        std::iter::once(0.0).chain(all.into_iter().skip(skipped).step_by(step)).collect()
    }

    /// Values of all animated properties at a time in seconds.
    pub(super) fn pose(&self, time: f64) -> Pose {
        let mut pose = Pose::default();
        for (target, curve) in &self.tracks {
            let values = curve.at(time);
            let three = || values.first_chunk::<3>().copied();
            let weights = || values.iter().map(|&v| v as f32).collect::<Vec<_>>();
            match *target {
                Target::Translation(node) => pose.node_mut(node).translation = three(),
                Target::Rotation(node) => pose.node_mut(node).rotation = values.first_chunk::<4>().copied(),
                Target::Scale(node) => pose.node_mut(node).scale = three(),
                Target::Weights(node) => pose.node_mut(node).weights = Some(weights()),
                Target::Visible(node) => pose.node_mut(node).visible = values.first().map(|&v| v != 0.0),
                Target::MeshWeights(mesh) => pose.set_mesh_weights(mesh, weights()),
                Target::Surface(material, surface) => {
                    pose.surfaces.entry(material).or_default().push((surface, values));
                }
                Target::Light(light, property) => {
                    pose.lights.entry(light).or_default().push((property, values));
                }
                Target::Camera(camera, property) => {
                    pose.cameras.entry(camera).or_default().push((property, values));
                }
            }
        }
        pose
    }
}

/// All animations of a file. What cannot be found out of one is not said: nothing is lost by it as long as it is not
/// played.
///
/// # Errors
/// [`LoadError::Limit`].
pub(super) fn list(
    root: &Root,
    buffers: &mut Buffers<'_>,
    context: &Context<'_>,
    budget: &mut Budget,
) -> Result<Vec<AnimationInfo>, LoadError> {
    // Times are often shared.
    let mut ends: BTreeMap<Index, Option<f64>> = BTreeMap::new();
    let mut infos = Vec::new();
    for given in root.animations.iter() {
        let mut length: Option<f64> = None;
        for input in given.samplers.iter().filter_map(|sampler| sampler.input) {
            let end = match ends.get(&input) {
                Some(end) => *end,
                None => {
                    let end = match end_of(root, input, buffers, context, budget) {
                        Err(error @ LoadError::Limit(_)) => return Err(error),
                        end => end.ok().filter(|end| end.is_finite()),
                    };
                    ends.insert(input, end);
                    end
                }
            };
            length = match (length, end) {
                (Some(length), Some(end)) if length > end => Some(length),
                (length, end) => end.or(length),
            };
        }
        let name = given.name.as_deref().unwrap_or("").chars().take(256).collect();
        infos.push(AnimationInfo { name, length, channels: given.channels.len() });
    }
    Ok(infos)
}

/// The last of a sampler's times.
fn end_of(
    root: &Root,
    input: Index,
    buffers: &mut Buffers<'_>,
    context: &Context<'_>,
    budget: &mut Budget,
) -> Result<f64, LoadError> {
    accessor::require(root, input, buffers, context, budget)?;
    buffers.decompress(context.jobs)?;
    let times = accessor::resolve(root, buffers, input)?;
    match times.count.checked_sub(1) {
        Some(last) if times.kind == Kind::Scalar => {
            let [[end]] = times.floats::<1>(&Pick::Range(last..times.count))?[..] else {
                return Ok(f64::NAN);
            };
            Ok(end.into())
        }
        _ => Ok(f64::NAN),
    }
}

/// `animation 2 'name'`.
pub(super) fn name(root: &Root, index: usize) -> String {
    root.animations.label(index)
}

fn channel_name(root: &Root, index: usize, channel: usize) -> String {
    format!("{}, channel {channel}", name(root, index))
}
