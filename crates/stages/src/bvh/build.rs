//! From triangles to a hierarchy.

use super::{Child, Hierarchy, Leaf, Node, Tree};
use overcoat_core::jobs::Jobs;
use overcoat_core::math::lanes::LANES;
use std::ops::Range;

/// Planes that a range of triangles may be divided at, along each axis.
const BINS: usize = 16;

/// Below this depth ranges are divided by surface area, beyond it into halves: no file makes a tree deeper than this and the
/// logarithm of its number of triangles.
const MAX_UNBALANCED: u32 = 40;

/// Ranges of so many triangles are worked on by one thread each.
const TRIANGLES_PER_JOB: usize = 8192;

/// A box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub low: [f32; 3],
    pub high: [f32; 3],
}

impl Bounds {
    pub(super) const NOTHING: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    pub(super) fn add(&mut self, other: &Self) {
        for k in 0..3 {
            self.low[k] = lower(self.low[k], other.low[k]);
            self.high[k] = higher(self.high[k], other.high[k]);
        }
    }

    pub(super) fn of(triangle: &[[f32; 3]; 3]) -> Self {
        let mut bounds = Self::NOTHING;
        for corner in triangle {
            bounds.add(&Self { low: *corner, high: *corner });
        }
        bounds
    }

    /// Twice the centre.
    fn centre(&self, axis: usize) -> f32 {
        self.low[axis] + self.high[axis]
    }

    /// The largest of all coordinates; 0 of nothing.
    pub(super) fn largest(&self) -> f32 {
        let finite = self.low.iter().chain(&self.high).filter(|v| v.is_finite());
        finite.fold(0.0, |most, v| higher(most, v.abs()))
    }

    /// Half of the surface; 0 of nothing.
    fn area(&self) -> f32 {
        let size: [f32; 3] = std::array::from_fn(|k| self.high[k] - self.low[k]);
        if size[0] >= 0.0 { size[0] * (size[1] + size[2]) + size[1] * size[2] } else { 0.0 }
    }
}

fn lower(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

fn higher(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// A node of the binary tree.
#[derive(Clone, Debug)]
struct Binary {
    bounds: Bounds,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    /// The two halves, by their numbers.
    Inner([u32; 2]),
    /// A range of the order.
    Leaf(Range<usize>),
}

/// Range of triangles that is still to be split, and the node that it fills.
struct Task {
    node: u32,
    range: Range<usize>,
    depth: u32,
}

/// Part of the largest coordinate that boxes are made larger by: rounding of the slabs' distances never leaves so much of
/// the box.
const MARGIN: f32 = 1.0 / (1 << 21) as f32;

impl Hierarchy {
    /// Builds it over triangles in world space. Those with corners that are not finite are left out, and so are those beyond
    /// [`Hierarchy::MAX_TRIANGLES`]. Once the work is cancelled it is left unfinished: nothing may be kept of it.
    #[must_use]
    pub fn new(triangles: &[[[f32; 3]; 3]], jobs: &Jobs) -> Self {
        Self { once: Tree::new(triangles, jobs), ..Self::default() }
    }
}

impl Tree {
    /// Builds it over triangles: see [`Hierarchy::new`].
    pub(super) fn new(triangles: &[[[f32; 3]; 3]], jobs: &Jobs) -> Self {
        let triangles = &triangles[..triangles.len().min(Hierarchy::MAX_TRIANGLES)];
        let mut items = jobs.map(triangles.len().div_ceil(TRIANGLES_PER_JOB), |part| {
            let start = part * TRIANGLES_PER_JOB;
            let end = triangles.len().min(start + TRIANGLES_PER_JOB);
            let finite = |k: &usize| triangles[*k].iter().flatten().all(|v| v.is_finite());
            let item = |k: usize| Item { bounds: Bounds::of(&triangles[k]), triangle: k as u32 };
            (start..end).filter(finite).map(item).collect::<Vec<_>>()
        });
        let items: Vec<Item> = if items.len() == 1 { items.remove(0) } else { items.concat() };
        Self::of_items(items, Some(triangles), jobs)
    }

    /// Builds it over boxes, which are its leaves.
    pub(super) fn of_boxes(boxes: &[Bounds], jobs: &Jobs) -> Self {
        let item = |(number, bounds): (usize, &Bounds)| Item { bounds: *bounds, triangle: number as u32 };
        Self::of_items(boxes.iter().enumerate().map(item).collect(), None, jobs)
    }

    fn of_items(mut items: Vec<Item>, triangles: Option<&[[[f32; 3]; 3]]>, jobs: &Jobs) -> Self {
        if items.is_empty() {
            return Self::default();
        }
        let tree = binary_tree(&mut items, jobs);
        if jobs.is_cancelled() {
            return Self::default();
        }
        let margin = tree[0].bounds.largest() * MARGIN;
        Opened::new(&tree, &items, triangles, margin, jobs).opened
    }

    /// Gives its triangles other numbers, in the same order.
    pub(super) fn renumber(&mut self, number_of: impl Fn(u32) -> u32) {
        let numbers = self.leaves.iter_mut().flat_map(|leaf| &mut leaf.triangles);
        numbers.filter(|number| **number != u32::MAX).for_each(|number| *number = number_of(*number));
    }
}

/// A triangle, or a box, to be put somewhere.
#[derive(Clone, Copy, Debug)]
struct Item {
    bounds: Bounds,
    triangle: u32,
}

/// The binary tree over items, which are put in its order. The first node is the root.
fn binary_tree(items: &mut [Item], jobs: &Jobs) -> Vec<Binary> {
    let mut tree = vec![Binary { bounds: Bounds::NOTHING, kind: Kind::Leaf(0..items.len()) }];
    // The top, until ranges are small enough for one thread each.
    let mut small = Vec::new();
    let mut tasks = vec![Task { node: 0, range: 0..items.len(), depth: 0 }];
    while let Some(task) = tasks.pop().filter(|_| !jobs.is_cancelled()) {
        if task.range.len() <= TRIANGLES_PER_JOB {
            small.push(task);
        } else {
            divide(&mut tree, items, 0, task, &mut tasks);
        }
    }
    small.sort_by_key(|task| task.range.start);
    let mut rest = items;
    let mut parts = Vec::with_capacity(small.len());
    for task in small {
        let (part, after) = rest.split_at_mut(task.range.len());
        rest = after;
        parts.push((task, part, Vec::new()));
    }
    jobs.for_each_mut(&mut parts, |_, (task, items, subtree)| {
        let first = task.range.start;
        *subtree = vec![Binary { bounds: Bounds::NOTHING, kind: Kind::Leaf(task.range.clone()) }];
        let mut tasks = vec![Task { node: 0, range: task.range.clone(), depth: task.depth }];
        while let Some(task) = tasks.pop().filter(|_| !jobs.is_cancelled()) {
            divide(subtree, items, first, task, &mut tasks);
        }
    });
    // A subtree's root takes its place in the tree, the others follow at the end.
    for (task, _, subtree) in parts {
        let shift = tree.len() as u32 - 1;
        for (number, mut node) in subtree.into_iter().enumerate() {
            if let Kind::Inner(halves) = &mut node.kind {
                halves.iter_mut().for_each(|half| *half += shift);
            }
            if number == 0 {
                tree[task.node as usize] = node;
            } else {
                tree.push(node);
            }
        }
    }
    tree
}

/// Gives a node its box and, if it holds more than a leaf can, two halves, which become tasks. `items` begin with number
/// `first` of the order.
fn divide(tree: &mut Vec<Binary>, items: &mut [Item], first: usize, task: Task, tasks: &mut Vec<Task>) {
    let Task { node, range, depth } = task;
    let own = &mut items[range.start - first..range.end - first];
    let mut bounds = Bounds::NOTHING;
    own.iter().for_each(|item| bounds.add(&item.bounds));
    tree[node as usize].bounds = bounds;
    if own.len() <= LANES {
        tree[node as usize].kind = Kind::Leaf(range);
        return;
    }
    let plane = if depth < MAX_UNBALANCED { best_plane(own) } else { None };
    let count = match plane {
        Some(plane) => partition(own, |item| plane.bin(&item.bounds) < plane.end),
        None => own.len() / 2,
    };
    let middle = range.start + count;
    let halves = [tree.len() as u32, tree.len() as u32 + 1];
    tree[node as usize].kind = Kind::Inner(halves);
    for (half, range) in halves.into_iter().zip([range.start..middle, middle..range.end]) {
        tree.push(Binary { bounds: Bounds::NOTHING, kind: Kind::Leaf(range.clone()) });
        tasks.push(Task { node: half, range, depth: depth + 1 });
    }
}

/// Split plane of the binned build: triangles whose bin along `axis` is below `end` go to the first half.
struct Plane {
    axis: usize,
    low: f32,
    scale: f32,
    end: usize,
}

impl Plane {
    fn bin(&self, bounds: &Bounds) -> usize {
        // Saturates; what is not a number counts as 0.
        (((bounds.centre(self.axis) - self.low) * self.scale) as usize).min(BINS - 1)
    }
}

/// The plane with the least sum of surface times leaves on its two sides; `None` if all centres are one point.
fn best_plane(items: &[Item]) -> Option<Plane> {
    let mut centres = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for item in items {
        for k in 0..3 {
            centres[0][k] = lower(centres[0][k], item.bounds.centre(k));
            centres[1][k] = higher(centres[1][k], item.bounds.centre(k));
        }
    }
    let [low, high] = centres;
    let planes: [Plane; 3] = std::array::from_fn(|axis| Plane {
        axis,
        low: low[axis],
        scale: BINS as f32 / (high[axis] - low[axis]),
        end: 0,
    });
    let mut bins = [[(Bounds::NOTHING, 0_usize); BINS]; 3];
    for item in items {
        for (plane, bins) in planes.iter().zip(&mut bins) {
            let (bounds, count) = &mut bins[plane.bin(&item.bounds)];
            bounds.add(&item.bounds);
            *count += 1;
        }
    }
    let mut best: Option<(f32, Plane)> = None;
    for (plane, bins) in planes.into_iter().zip(&bins) {
        // An axis along which all centres are one, or too far apart for numbers.
        if !(plane.scale > 0.0 && plane.scale.is_finite()) {
            continue;
        }
        if let Some((cost, end)) = least_cost(bins)
            && best.as_ref().is_none_or(|(least, _)| cost < *least)
        {
            best = Some((cost, Plane { end, ..plane }));
        }
    }
    best.map(|(_, plane)| plane)
}

/// Least cost of a split between bins, and the number of bins in its first half; `None` if only one is not empty.
fn least_cost(bins: &[(Bounds, usize); BINS]) -> Option<(f32, usize)> {
    // A leaf costs as much with one triangle as with sixteen.
    let cost = |bounds: &Bounds, count: usize| bounds.area() * count.div_ceil(LANES) as f32;
    let mut after = [(0.0, 0); BINS];
    let (mut bounds, mut count) = (Bounds::NOTHING, 0);
    for k in (1..BINS).rev() {
        bounds.add(&bins[k].0);
        count += bins[k].1;
        after[k] = (cost(&bounds, count), count);
    }
    let mut best: Option<(f32, usize)> = None;
    let (mut bounds, mut count) = (Bounds::NOTHING, 0);
    for k in 1..BINS {
        bounds.add(&bins[k - 1].0);
        count += bins[k - 1].1;
        let (right, right_count) = after[k];
        if count == 0 || right_count == 0 {
            continue;
        }
        let sum = cost(&bounds, count) + right;
        if best.is_none_or(|(least, _)| sum < least) {
            best = Some((sum, k));
        }
    }
    best
}

/// Moves the items of the first half before the others and returns their number. The order within the halves does not
/// matter, but it is the same every time.
fn partition(items: &mut [Item], is_first: impl Fn(&Item) -> bool) -> usize {
    let mut count = 0;
    for k in 0..items.len() {
        if is_first(&items[k]) {
            items.swap(count, k);
            count += 1;
        }
    }
    count
}

/// A binary tree being opened into a wide one.
struct Opened<'a> {
    tree: &'a [Binary],
    items: &'a [Item],
    /// Nothing where the items are no triangles: their boxes are leaves then.
    triangles: Option<&'a [[[f32; 3]; 3]]>,
    margin: f32,
    opened: Tree,
}

impl<'a> Opened<'a> {
    fn new(
        tree: &'a [Binary],
        items: &'a [Item],
        triangles: Option<&'a [[[f32; 3]; 3]]>,
        margin: f32,
        jobs: &Jobs,
    ) -> Self {
        let mut opened = Self { tree, items, triangles, margin, opened: Tree::default() };
        let mut todo = vec![(0, 0)];
        opened.opened.nodes.push(Node::EMPTY);
        while let Some((binary, node)) = todo.pop().filter(|_| !jobs.is_cancelled()) {
            opened.open(binary, node, &mut todo);
        }
        opened
    }

    /// Fills a wide node: of its children the one with the largest surface is replaced by its halves, while there is room.
    fn open(&mut self, binary: u32, node: usize, todo: &mut Vec<(u32, usize)>) {
        let mut children = vec![binary];
        while children.len() < LANES {
            let mut largest: Option<(f32, usize)> = None;
            for (place, &child) in children.iter().enumerate() {
                let Binary { bounds, kind: Kind::Inner(_) } = &self.tree[child as usize] else { continue };
                let area = bounds.area();
                if largest.is_none_or(|(other, _)| area > other) {
                    largest = Some((area, place));
                }
            }
            let Some((_, place)) = largest else { break };
            if let Kind::Inner([first, second]) = self.tree[children[place] as usize].kind {
                children[place] = first;
                children.push(second);
            }
        }
        for (place, child) in children.into_iter().enumerate() {
            let Binary { bounds, kind } = &self.tree[child as usize];
            let number = match kind {
                Kind::Inner(_) => {
                    let number = self.opened.nodes.len();
                    self.opened.nodes.push(Node::EMPTY);
                    todo.push((child, number));
                    Child::node(number)
                }
                Kind::Leaf(range) => match self.triangles {
                    Some(triangles) => {
                        self.opened.leaves.push(self.leaf(triangles, range.clone()));
                        Child::leaf(self.opened.leaves.len() - 1)
                    }
                    None => {
                        let mut boxes = Node::EMPTY;
                        for (place, item) in self.items[range.clone()].iter().enumerate() {
                            let child = Child::leaf(item.triangle as usize);
                            boxes.put(place, &item.bounds, self.margin, child);
                        }
                        self.opened.nodes.push(boxes);
                        Child::node(self.opened.nodes.len() - 1)
                    }
                },
            };
            self.opened.nodes[node].put(place, bounds, self.margin, number);
        }
    }

    /// The leaf of a range of items, in the order of their triangles.
    fn leaf(&self, triangles: &[[[f32; 3]; 3]], range: Range<usize>) -> Leaf {
        let mut numbers: Vec<u32> = self.items[range].iter().map(|item| item.triangle).collect();
        numbers.sort_unstable();
        let mut leaf = Leaf { corners: [[[0.0; LANES]; 3]; 3], triangles: [u32::MAX; LANES] };
        for (place, number) in numbers.into_iter().enumerate() {
            leaf.triangles[place] = number;
            for (corner, position) in leaf.corners.iter_mut().zip(&triangles[number as usize]) {
                for (row, value) in corner.iter_mut().zip(position) {
                    row[place] = *value;
                }
            }
        }
        leaf
    }
}

impl Node {
    const EMPTY: Self = Self {
        low: [[f32::INFINITY; LANES]; 3],
        high: [[f32::NEG_INFINITY; LANES]; 3],
        children: [Child(0); LANES],
    };

    /// Takes a child, with a box around it that is larger than its own by a margin.
    fn put(&mut self, place: usize, bounds: &Bounds, margin: f32, child: Child) {
        for k in 0..3 {
            self.low[k][place] = bounds.low[k] - margin;
            self.high[k][place] = bounds.high[k] + margin;
        }
        self.children[place] = child;
    }
}
