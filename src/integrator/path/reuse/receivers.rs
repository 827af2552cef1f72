//! The receivers of a group, four to a register, and which of them see a source.

use super::shared::{Receiver, Shared, Source};
use crate::math::DVec3;
use crate::math::simd::{F64x4, dot};
use crate::scene::Scene;
use crate::shape::accel::Shaft;

/// Number of consecutive receivers, side by side on the film, that are tested together if not all of the
/// group see the source.
const RUN: usize = 16;

/// Fewest receivers for which a [`Shaft`] is worth trying: it costs about as much as five rays.
const MANY: usize = 8;

/// The points that the pixels of a group see; at most 64.
#[derive(Default)]
pub struct Receivers {
    blocks: Vec<Block>,
    whole: Shaft,
    runs: [Shaft; 4],
    classes: Vec<EdgeClass>,
}

/// Receivers with the same number of edges before them.
#[derive(Clone, Copy)]
pub struct EdgeClass {
    pub edges: u32,
    /// A bit for each of them.
    pub receivers: u64,
}

/// Four receivers; one that is missing has no normal, and so no weight.
struct Block {
    p: [F64x4; 3],
    n: [F64x4; 3],
}

impl Receivers {
    /// Sets the receivers to those of a group.
    pub fn begin(&mut self, group: &[Shared]) {
        let vectors = |four: &[Shared], f: &dyn Fn(&Receiver) -> DVec3| {
            let lane =
                |i: usize| four.get(i).and_then(|shared| shared.receiver.as_ref()).map_or(DVec3::ZERO, f);
            let lanes: [DVec3; 4] = std::array::from_fn(lane);
            [0, 1, 2].map(|axis| F64x4::new(lanes.map(|v| v[axis])))
        };
        self.blocks.clear();
        let block = |four| Block { p: vectors(four, &|r| r.p), n: vectors(four, &|r| r.n) };
        self.blocks.extend(group.chunks(4).map(block));
        self.classes.clear();
        for (i, receiver) in group.iter().enumerate().filter_map(|(i, s)| Some((i, s.receiver.as_ref()?))) {
            match self.classes.iter_mut().find(|class| class.edges == receiver.edges) {
                Some(class) => class.receivers |= 1 << i,
                None => self.classes.push(EdgeClass { edges: receiver.edges, receivers: 1 << i }),
            }
        }
        self.whole.begin(points(group));
        if group.len() > RUN {
            for (shaft, run) in self.runs.iter_mut().zip(group.chunks(RUN)) {
                shaft.begin(points(run));
            }
        }
    }

    /// The geometry term between a source and each receiver, without visibility; returns a bit for each that
    /// faces the source and has a bit in `of`.
    pub fn weights(&self, of: u64, source: &Source, weights: &mut [f64; 64]) -> u64 {
        let spread = |v: DVec3| v.to_array().map(F64x4::splat);
        let (p, n, ng) = (spread(source.p), spread(source.n), spread(source.ng));
        let (zero, most) = (F64x4::splat(0.0), F64x4::splat(f64::MAX));
        let mut facing = 0;
        for (i, block) in self.blocks.iter().enumerate() {
            let way = [0, 1, 2].map(|axis| p[axis] - block.p[axis]);
            let squared = dot(way, way);
            // Both cosines have the distance in them.
            let weight = dot(block.n, way) * dot(ng, way).abs() / (squared * squared);
            let faces = zero.below(weight) & weight.at_most(most) & dot(n, way).below(zero);
            facing |= u64::from(faces.bits()) << (4 * i);
            weights[4 * i..4 * i + 4].copy_from_slice(&weight.to_array());
        }
        facing & of
    }

    /// A bit for each receiver that has as many edges before it as that of a path.
    pub fn with_edges_of(&self, path: usize) -> u64 {
        self.classes.iter().find(|class| class.receivers >> path & 1 == 1).map_or(0, |class| class.receivers)
    }

    /// The receivers by their numbers of edges.
    pub fn classes(&self) -> &[EdgeClass] {
        &self.classes
    }

    /// A bit for each receiver that is known to see the source; the others may see it or not.
    pub fn in_sight(&mut self, scene: &Scene, source: &Source) -> u64 {
        let clear = |shaft: &mut Shaft| {
            shaft.count() >= MANY && scene.accel.is_clear(shaft, source.p, source.primitive)
        };
        if clear(&mut self.whole) {
            return u64::MAX;
        }
        let count = if 4 * self.blocks.len() > RUN { self.blocks.len().div_ceil(RUN / 4) } else { 0 };
        let runs = self.runs[..count].iter_mut().enumerate();
        runs.fold(0, |bits, (i, run)| bits | if clear(run) { 0xffff << (RUN * i) } else { 0 })
    }
}

/// Where the receivers are.
fn points(group: &[Shared]) -> impl Iterator<Item = DVec3> {
    group.iter().filter_map(|shared| Some(shared.receiver.as_ref()?.p))
}
