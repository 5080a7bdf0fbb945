//! Names of what is in a [`World`](super::World), which stay while other things come and go.

use super::WorldError;

/// Bits of each part of a handle: slots of a list, how often each was used, worlds of a process.
const SLOT_BITS: u32 = 24;
const GENERATION_BITS: u32 = 20;
const WORLD_BITS: u32 = 20;
const _: () = assert!(SLOT_BITS + GENERATION_BITS + WORLD_BITS == 64);

/// Elements of one kind at most.
pub(super) const MOST_SLOTS: usize = 1 << SLOT_BITS;
/// Generation of the last use of a place in a list, which stays empty after it.
pub(super) const LAST_GENERATION: u32 = (1 << GENERATION_BITS) - 1;
/// Worlds have numbers from 1 to this, and then from 1 again.
pub(super) const LAST_WORLD: u32 = (1 << WORLD_BITS) - 1;

/// The parts of a handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Parts {
    pub world: u32,
    pub generation: u32,
    pub slot: u32,
}

impl Parts {
    fn to_bits(self) -> u64 {
        let Self { world, generation, slot } = self;
        u64::from(world) << (GENERATION_BITS + SLOT_BITS)
            | u64::from(generation) << SLOT_BITS
            | u64::from(slot)
    }

    fn from_bits(bits: u64) -> Self {
        let part = |from: u32, count: u32| (bits >> from & ((1 << count) - 1)) as u32;
        Self {
            world: part(GENERATION_BITS + SLOT_BITS, WORLD_BITS),
            generation: part(SLOT_BITS, GENERATION_BITS),
            slot: part(0, SLOT_BITS),
        }
    }
}

/// Something that has a name.
pub(super) trait Handle: Copy {
    /// Name of the kind of object, for messages.
    const WHAT: &'static str;
    fn new(parts: Parts) -> Self;
    fn parts(self) -> Parts;
}

macro_rules! handle {
    ($name:ident, $what:literal) => {
        #[doc = concat!("Names a ", $what, " of one [`World`](super::World) until it is removed. Used afterwards, or with another \
                 world, it is an error and never another ", $what, ".")]
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(Parts);

        impl $name {
            /// As a number, for languages that have no types of their own for it; never 0.
            #[must_use]
            pub fn to_bits(self) -> u64 {
                self.0.to_bits()
            }

            /// Its place among its kind.
            #[allow(dead_code, reason = "not asked of every kind")]
            pub(super) fn slot(self) -> u32 {
                self.0.slot
            }

            /// From [`Self::to_bits`]. Any other number is a name of nothing.
            #[must_use]
            pub fn from_bits(bits: u64) -> Self {
                Self(Parts::from_bits(bits))
            }
        }

        impl Handle for $name {
            const WHAT: &'static str = $what;
            fn new(parts: Parts) -> Self {
                Self(parts)
            }
            fn parts(self) -> Parts {
                self.0
            }
        }
    };
}
handle!(ModelHandle, "model");
handle!(InstanceHandle, "instance");
handle!(MeshHandle, "mesh");
handle!(MaterialHandle, "material");
handle!(TextureHandle, "texture");
handle!(LightHandle, "light");

/// Elements with names, in places that are used again. The place of an element is its number in the list that it stands for.
#[derive(Debug)]
pub(super) struct Slots<T> {
    places: Vec<Place<T>>,
    free: Vec<u32>,
}

#[derive(Debug)]
struct Place<T> {
    generation: u32,
    content: Option<T>,
}

impl<T> Default for Slots<T> {
    fn default() -> Self {
        Self { places: Vec::new(), free: Vec::new() }
    }
}

impl<T> Slots<T> {
    /// The place that the next element gets: a free one, or one more.
    pub(super) fn next(&self) -> usize {
        self.free.last().map_or(self.places.len(), |slot| *slot as usize)
    }

    /// Puts an element into the [next](Slots::next) place.
    pub(super) fn add<H: Handle>(&mut self, world: u32, content: T) -> Result<H, WorldError> {
        let slot = self.next();
        if slot >= MOST_SLOTS {
            return Err(WorldError::TooMany { what: H::WHAT });
        }
        if self.free.pop().is_none() {
            self.places.push(Place { generation: 0, content: None });
        }
        let place = &mut self.places[slot];
        place.content = Some(content);
        Ok(H::new(Parts { world, generation: place.generation, slot: slot as u32 }))
    }

    /// The place of an element.
    pub(super) fn place<H: Handle>(&self, world: u32, handle: H) -> Result<usize, WorldError> {
        let Parts { world: own, generation, slot } = handle.parts();
        if own != world {
            return Err(WorldError::Foreign { what: H::WHAT });
        }
        let place = self.places.get(slot as usize);
        let found = place.is_some_and(|place| place.generation == generation && place.content.is_some());
        if found { Ok(slot as usize) } else { Err(WorldError::Gone { what: H::WHAT }) }
    }

    pub(super) fn get<H: Handle>(&self, world: u32, handle: H) -> Result<&T, WorldError> {
        let slot = self.place(world, handle)?;
        self.places[slot].content.as_ref().ok_or(WorldError::Gone { what: H::WHAT })
    }

    pub(super) fn get_mut<H: Handle>(&mut self, world: u32, handle: H) -> Result<&mut T, WorldError> {
        let slot = self.place(world, handle)?;
        self.places[slot].content.as_mut().ok_or(WorldError::Gone { what: H::WHAT })
    }

    /// The occupant of a place.
    pub(super) fn at(&self, slot: usize) -> Option<&T> {
        self.places.get(slot)?.content.as_ref()
    }

    /// The occupant of a place.
    pub(super) fn at_mut(&mut self, slot: usize) -> Option<&mut T> {
        self.places.get_mut(slot)?.content.as_mut()
    }

    /// The name of what is in a place.
    pub(super) fn handle<H: Handle>(&self, world: u32, slot: usize) -> Option<H> {
        let place = self.places.get(slot)?;
        place.content.as_ref()?;
        Some(H::new(Parts { world, generation: place.generation, slot: slot as u32 }))
    }

    /// Names of all, in the order of their places.
    pub(super) fn handles<H: Handle>(&self, world: u32) -> impl Iterator<Item = H> + '_ {
        (0..self.places.len()).filter_map(move |slot| self.handle(world, slot))
    }

    /// Takes an element away. Its place is used again, under another name.
    pub(super) fn remove<H: Handle>(&mut self, world: u32, handle: H) -> Result<T, WorldError> {
        let slot = self.place(world, handle)?;
        let place = &mut self.places[slot];
        let content = place.content.take().ok_or(WorldError::Gone { what: H::WHAT })?;
        // A place that was used so often that its next name would be an old one stays empty.
        if place.generation < LAST_GENERATION {
            place.generation += 1;
            self.free.push(slot as u32);
        }
        Ok(content)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_outlive_neither_their_element_nor_their_world() {
        let mut slots = Slots::default();
        let a: MeshHandle = slots.add(1, "a").unwrap();
        let b: MeshHandle = slots.add(1, "b").unwrap();
        assert_eq!(slots.remove(1, a).unwrap(), "a");
        assert!(matches!(slots.get(1, a), Err(WorldError::Gone { what: "mesh" })));
        assert!(matches!(slots.remove(1, a), Err(WorldError::Gone { .. })));
        let c: MeshHandle = slots.add(1, "c").unwrap();
        assert_eq!((slots.place(1, c).unwrap(), *slots.get(1, b).unwrap()), (0, "b"));
        assert_ne!(a, c);
        assert!(slots.get(1, a).is_err());
        assert!(matches!(slots.get(2, c), Err(WorldError::Foreign { what: "mesh" })));
        assert_eq!(slots.handles(1).collect::<Vec<MeshHandle>>(), [c, b]);
    }

    #[test]
    fn names_are_numbers_and_back() {
        for parts in [
            Parts { world: 1, generation: 0, slot: 0 },
            Parts { world: LAST_WORLD, generation: LAST_GENERATION, slot: MOST_SLOTS as u32 - 1 },
            Parts { world: 7, generation: 300, slot: 70_000 },
        ] {
            let handle = LightHandle::new(parts);
            assert_eq!(LightHandle::from_bits(handle.to_bits()), handle);
            assert_ne!(handle.to_bits(), 0);
        }
        let slots = Slots::<()>::default();
        for bits in [0, 1, u64::MAX, 0x1234_5678_9abc_def0] {
            assert!(slots.get(1, LightHandle::from_bits(bits)).is_err());
        }
    }

    #[test]
    fn a_place_is_not_used_for_ever() {
        let mut slots = Slots::default();
        let mut seen = std::collections::BTreeSet::new();
        for _ in 0..=LAST_GENERATION {
            let handle: LightHandle = slots.add(1, ()).unwrap();
            assert!(seen.insert(handle), "each name is new");
            slots.remove(1, handle).unwrap();
        }
        let next: LightHandle = slots.add(1, ()).unwrap();
        assert!(seen.insert(next));
        assert_eq!(next.parts().slot, 1);
    }
}
