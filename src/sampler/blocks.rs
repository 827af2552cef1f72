//! Which block of numbers belongs to what. No two uses share one.

/// The block of the camera, or of the emitter where a light path begins.
pub const START: u32 = 0;

/// No path goes on beyond this many vertices. Roulette ends paths long before, except where nothing is ever
/// absorbed; such paths are counted and reported.
pub const MAX_VERTICES: u32 = 1 << 20;
/// Instead of a number of edges, for a meter on which a path begins: its numbers are those of a vertex that no path has.
pub const METER: u32 = MAX_VERTICES + 1;
/// How many emitter samples a vertex can take.
pub const MOST_EMITTER_SAMPLES: u32 = 1 << 10;
/// Blocks of a guided emitter sample at each vertex.
pub const GUIDED_OF_VERTEX: u32 = 1 << 5;
/// Blocks of a light path for a group of pixels: one for its emitter, one for each vertex.
pub const SHARED_OF_PATH: u32 = 1 << 4;
/// How many light paths a group of pixels can have.
pub const MOST_SHARED_LIGHT_PATHS: u32 = 64;

/// First block of the vertices of a path.
const VERTICES: u32 = 1;
/// First block of light paths for groups of pixels.
const SHARED_LIGHT_PATHS: u32 = 1 << 28;
/// First block of guided emitter samples.
const GUIDED: u32 = 1 << 29;
/// First block of emitter samples at vertices that take several.
const EMITTER_SAMPLES: u32 = 1 << 30;
/// First block of flights through media.
const FLIGHTS: u32 = 1 << 31;

const _: () = assert!(
    VERTICES + METER <= SHARED_LIGHT_PATHS
        // The number of a light path among those of all samples exceeds 32 bits by less than there are of a sample.
        && SHARED_LIGHT_PATHS + MOST_SHARED_LIGHT_PATHS * SHARED_OF_PATH <= GUIDED
        && GUIDED + MAX_VERTICES * GUIDED_OF_VERTEX <= EMITTER_SAMPLES
        && MAX_VERTICES * MOST_EMITTER_SAMPLES <= EMITTER_SAMPLES
        && EMITTER_SAMPLES + (MAX_VERTICES * MOST_EMITTER_SAMPLES - 1) < FLIGHTS
        && 2 * METER <= u32::MAX - FLIGHTS
);

/// The vertex of a path at the end of edge number `edges`, which is at least 1.
#[inline(always)]
pub fn vertex(edges: u32) -> u32 {
    VERTICES - 1 + edges
}

/// The vertex after so many edges, none at the emitter, of a light path for a group of pixels; `beyond` is the
/// overflow of its number above 32 bits.
#[inline(always)]
pub fn shared_light_path(beyond: u32, edges: u32) -> u32 {
    SHARED_LIGHT_PATHS + beyond * SHARED_OF_PATH + edges
}

/// One of the blocks of a guided emitter sample at a vertex with `depth` vertices before it.
#[inline(always)]
pub fn guided(depth: u32, which: u32) -> u32 {
    GUIDED + depth * GUIDED_OF_VERTEX + which
}

/// An emitter sample at a vertex with `depth` vertices before it, where that takes several; `beyond` is the
/// overflow of its number above 32 bits.
#[inline(always)]
pub fn emitter_sample(depth: u32, beyond: u32) -> u32 {
    EMITTER_SAMPLES + depth * MOST_EMITTER_SAMPLES + beyond
}

/// The flight along edge number `edges` of a path, which is at least 1.
#[inline(always)]
pub fn flight(edges: u32) -> u32 {
    FLIGHTS + 2 * (edges - 1)
}

/// The flight of the shadow ray from the end of that edge.
#[inline(always)]
pub fn shadow_flight(edges: u32) -> u32 {
    flight(edges) + 1
}
