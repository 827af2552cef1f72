//! Partitions of the sphere into bins adapted to a distribution.
//!
//! Fixed grids do not resolve narrow lobes: at α = 0.01 all samples fall into one bin. Here a pilot sample
//! splits the (cos θ, φ) rectangle at medians, so that every bin has about the same expected count, whatever
//! the roughness. Within each bin splitting continues until a handful of pilot samples is left: quadrature
//! starts from these cells, so it cannot miss a lobe that sampling finds. Nor one about the directions that
//! lobes are usually about: cells shrink towards these too. The pilot is independent of the tested samples,
//! which keeps Pearson's test valid.

use std::f64::consts::PI;

use super::draw;
use crate::{
    quadrature::{Cell, Integral, integrate_all, integrate_known},
    scatterer::{DVec3, Scatterer, coordinates, direction},
    statistics::Stream,
};

/// Number of pilot samples per bin (between 3/4 and 3/2 of it).
const PER_BIN: usize = 64;
/// Number of pilot samples per cell that quadrature starts from.
const PER_CELL: usize = 8;

/// Largest extent of a cell in cos θ and φ, so that quadrature covers the sphere also where there are no
/// samples.
const LARGEST: [f64; 2] = [0.25, PI / 4.0];

/// Largest extent of a cell with points over the extent of its points.
const LOOSE: f64 = 4.0;

/// Extent of the cells about usual directions, in cos θ and φ: lobes narrower than that are as good as delta
/// lobes.
const FOCUS: f64 = 1e-6;

/// Largest ratio of a cell's expected count, if the density were everywhere that of any one of its points, to
/// its number of points: the rim of a narrow lobe in a cell of a broad one must not be missed.
const CROWDED: f64 = 16.0;

/// A direction of the pilot sample in (cos θ, φ), and the expected number of pilot samples per steradian at
/// its density.
type Point = [f64; 3];

/// Largest number of evaluations for one bin.
const BUDGET: usize = 200_000;

enum Node {
    Split { axis: usize, position: f64, children: [usize; 2] },
    Bin(usize),
}

/// A binary tree of splits whose leaves are the bins.
pub(super) struct Partition {
    nodes: Vec<Node>,
    bins: Vec<Vec<Cell>>,
}

impl Partition {
    /// About `bins` bins for the non-delta part of `scatterer` for the direction `wo`. The horizon is always
    /// a split, since distributions are discontinuous there.
    pub fn adapt(scatterer: &dyn Scatterer, wo: DVec3, stream: &mut Stream, bins: usize) -> Self {
        let pilot = (0..bins * PER_BIN).filter_map(|_| draw(scatterer, wo, stream));
        let directions = pilot.filter(|sample| !sample.delta && sample.wi.is_finite());
        let crowd = |pdf: f64| if pdf.is_finite() { pdf * (bins * PER_BIN) as f64 } else { 0.0 };
        let point = |[z, phi]: [f64; 2], pdf: f64| [z, phi, crowd(pdf)];
        let mut points: Vec<Point> =
            directions.map(|sample| point(coordinates(sample.wi), sample.pdf)).collect();
        let sphere = Cell { low: [-1.0, -PI], high: [1.0, PI] };
        let mut partition = Partition { nodes: Vec::new(), bins: Vec::new() };
        partition.cut(sphere, &mut points, Some((0, 0.0)));
        usual(scatterer, wo).into_iter().for_each(|direction| partition.focus(direction));
        partition
    }

    /// Makes cells the smaller the nearer they are to a direction. Each step leaves a quarter of the cell
    /// around it; halves would leave a neighbour large that has a lobe in its corner.
    fn focus(&mut self, about: DVec3) {
        let (at, bin) = (coordinates(about), self.locate(about));
        let cells = &mut self.bins[bin];
        let holds =
            |cell: &Cell| (0..2).all(|axis| cell.low[axis] <= at[axis] && at[axis] <= cell.high[axis]);
        let Some(place) = cells.iter().position(holds) else { return };
        let mut inner = cells.swap_remove(place);
        let extent = |cell: &Cell, axis: usize| cell.high[axis] - cell.low[axis];
        while (0..2).any(|axis| extent(&inner, axis) > FOCUS) {
            for (axis, middle) in at.into_iter().enumerate() {
                let eighth = extent(&inner, axis) / 8.0;
                let (low, high) = (middle - eighth, middle + eighth);
                if inner.low[axis] < low && low < inner.high[axis] {
                    let [outer, rest] = inner.split(axis, low);
                    cells.push(outer);
                    inner = rest;
                }
                if inner.low[axis] < high && high < inner.high[axis] {
                    let [rest, outer] = inner.split(axis, high);
                    cells.push(outer);
                    inner = rest;
                }
            }
        }
        cells.push(inner);
    }

    pub fn bins(&self) -> usize {
        self.bins.len()
    }

    /// The bin that holds `direction`.
    pub fn locate(&self, direction: DVec3) -> usize {
        let point = coordinates(direction);
        let mut node = 0;
        loop {
            match &self.nodes[node] {
                Node::Bin(bin) => return *bin,
                Node::Split { axis, position, children } => {
                    node = children[usize::from(point[*axis] >= *position)]
                }
            }
        }
    }

    /// In words, the angles from the normal and about it between which a bin lies, in degrees.
    pub fn place(&self, bin: usize) -> String {
        let around = |axis: usize| {
            let lows = self.bins[bin].iter().map(|cell| cell.low[axis]);
            let highs = self.bins[bin].iter().map(|cell| cell.high[axis]);
            (lows.fold(f64::INFINITY, f64::min), highs.fold(f64::NEG_INFINITY, f64::max))
        };
        let ((low, high), (from, to)) = (around(0), around(1));
        let polar = |z: f64| libm::acos(z.clamp(-1.0, 1.0)).to_degrees();
        let (near, far, from, to) = (polar(high), polar(low), from.to_degrees(), to.to_degrees());
        format!("{near:.2}° to {far:.2}° from the normal and {from:.1}° to {to:.1}° about it")
    }

    /// The integral over each bin of a function of `scatterer`, each with an error below `tolerance` / (number
    /// of bins) where the budget allows.
    pub fn integrate(
        &self,
        tolerance: f64,
        scatterer: &dyn Scatterer,
        function: impl Fn(DVec3) -> f64,
    ) -> Vec<Integral> {
        let tolerance = tolerance / self.bins.len() as f64;
        let at = answered(scatterer, |[z, phi]: [f64; 2]| function(direction(z, phi)));
        self.bins.iter().map(|cells| integrate_known(cells, tolerance, BUDGET, &at)).collect()
    }

    /// Integrals of `N` functions over the sphere, and a bound on the error of each.
    pub fn integrate_all<const N: usize>(
        &self,
        tolerance: f64,
        scatterer: &dyn Scatterer,
        function: impl Fn(DVec3) -> [f64; N],
    ) -> ([f64; N], f64) {
        let cells: Vec<Cell> = self.bins.iter().flatten().copied().collect();
        let budget = BUDGET * self.bins.len() / 8;
        let at = answered(scatterer, |[z, phi]: [f64; 2]| function(direction(z, phi)));
        integrate_all(&cells, tolerance, budget, at)
    }

    fn cut(&mut self, cell: Cell, points: &mut [Point], forced: Option<(usize, f64)>) -> usize {
        let node = self.nodes.len();
        self.nodes.push(Node::Bin(self.bins.len()));
        let split =
            forced.or_else(|| (2 * points.len() >= 3 * PER_BIN).then(|| median(&cell, points)).flatten());
        if let Some((axis, position)) = split {
            let (below, above) = separate(points, axis, position);
            let [low, high] = cell.split(axis, position);
            let children = [self.cut(low, below, None), self.cut(high, above, None)];
            self.nodes[node] = Node::Split { axis, position, children };
        } else {
            let mut cells = Vec::new();
            refine(cell, points, LARGEST, &mut cells);
            self.bins.push(cells);
        }
        node
    }
}

/// The directions that lobes are usually about: of reflection, of light that goes straight on or back, and of
/// refraction.
fn usual(scatterer: &dyn Scatterer, wo: DVec3) -> Vec<DVec3> {
    let laws = scatterer.laws();
    let ratio = laws.index(wo) / laws.index(-wo);
    let (x, y) = (-ratio * wo.x, -ratio * wo.y);
    let refracted = (1.0 - x * x - y * y).sqrt();
    let mut usual = vec![DVec3::new(-wo.x, -wo.y, wo.z), -wo, wo];
    if laws.eta.is_some() && refracted.is_finite() {
        usual.push(DVec3::new(x, y, -refracted.copysign(wo.z)));
    }
    usual
}

/// A function of a scatterer where the scatterer knows all that it is asked.
fn answered<T>(
    scatterer: &dyn Scatterer,
    function: impl Fn([f64; 2]) -> T,
) -> impl Fn([f64; 2]) -> Option<T> {
    move |point| {
        let before = scatterer.unanswered();
        let value = function(point);
        (scatterer.unanswered() == before).then_some(value)
    }
}

/// Splits `cell` into the cells that quadrature starts from: at midpoints while it is much larger than the
/// extent of its points (so that cells shrink towards a lobe, and none has the lobe in a corner where no
/// quadrature point falls), at medians while it contains many points, and at midpoints again while it exceeds
/// [`LARGEST`].
///
/// `cover` is the extent of the points in the smallest enclosing cell with enough of them to estimate it.
fn refine(cell: Cell, points: &mut [Point], cover: [f64; 2], cells: &mut Vec<Cell>) {
    let cover = if points.len() >= PER_CELL { extent(points) } else { cover };
    let area = (cell.high[0] - cell.low[0]) * (cell.high[1] - cell.low[1]);
    let crowd = points.iter().fold(0.0f64, |most, point| most.max(point[2]));
    let split = if points.is_empty() {
        halve(&cell, LARGEST)
    } else if let Some(split) = halve(&cell, cover.map(|cover| LOOSE * cover)) {
        Some(split)
    } else if crowd * area > CROWDED * points.len().max(PER_CELL) as f64 {
        // Splits towards the narrow lobe, along the axis on which it is thinner than the cell.
        let needle: Vec<Point> = points.iter().filter(|point| point[2] > 0.1 * crowd).copied().collect();
        halve(&cell, extent(&needle)).or_else(|| halve(&cell, LARGEST.map(|limit| limit * f64::EPSILON)))
    } else if points.len() >= 2 * PER_CELL {
        median(&cell, points)
    } else {
        halve(&cell, LARGEST)
    };
    let Some((axis, position)) = split else {
        cells.push(cell);
        return;
    };
    let (below, above) = separate(points, axis, position);
    let [low, high] = cell.split(axis, position);
    refine(low, below, cover, cells);
    refine(high, above, cover, cells);
}

/// The middle along the axis on which `cell` exceeds `limit` most; `None` if it does not, or cannot be split
/// further in f64.
fn halve(cell: &Cell, limit: [f64; 2]) -> Option<(usize, f64)> {
    let excess = [0, 1].map(|axis| (cell.high[axis] - cell.low[axis]) / limit[axis]);
    let axis = usize::from(excess[1] > excess[0]);
    let middle = cell.middle(axis);
    (excess[axis].is_finite() && excess[axis] > 1.0 && cell.low[axis] < middle && middle < cell.high[axis])
        .then_some((axis, middle))
}

/// The extent of `points` along each axis.
fn extent(points: &[Point]) -> [f64; 2] {
    [0, 1].map(|axis| range(points, axis)).map(|(low, high)| high - low)
}

fn range(points: &[Point], axis: usize) -> (f64, f64) {
    let values = || points.iter().map(|point| point[axis]);
    (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
}

/// The median along the axis on which `points` extend over the larger angle; `None` if it does not separate
/// them.
fn median(cell: &Cell, points: &mut [Point]) -> Option<(usize, f64)> {
    let (z, phi) = (range(points, 0), range(points, 1));
    let cosine = 0.5 * (z.0 + z.1);
    let sine_squared = (1.0 - cosine) * (1.0 + cosine);
    // Compares the angles dθ = dz / sin θ and sin θ dφ.
    let axis = usize::from((phi.1 - phi.0) * sine_squared > z.1 - z.0);
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
    let position = points[middle][axis];
    let separates = points.iter().any(|point| point[axis] < position);
    (separates && cell.low[axis] < position && position < cell.high[axis]).then_some((axis, position))
}

/// Reorders `points` into those below `position` and the rest.
fn separate(points: &mut [Point], axis: usize, position: f64) -> (&mut [Point], &mut [Point]) {
    points.sort_unstable_by(|a, b| a[axis].total_cmp(&b[axis]));
    let below = points.partition_point(|point| point[axis] < position);
    points.split_at_mut(below)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subjects::{Conductor, Lambert};

    #[test]
    fn bins_cover_the_sphere_once() {
        let partition = Partition::adapt(
            &Conductor { alpha: 0.1, r0: 0.9 },
            direction(0.5, 0.0),
            &mut Stream::new(0),
            64,
        );
        let lambert = Lambert { albedo: 0.5 };
        let area: Integral = partition.integrate(1.0, &lambert, |_| 1.0).into_iter().sum();
        assert!((area.value - 4.0 * PI).abs() < 1e-9);
        let mut stream = Stream::named("partition", 0);
        for _ in 0..1000 {
            let point = [2.0 * stream.uniform() - 1.0, PI * (2.0 * stream.uniform() - 1.0)];
            let bin = &partition.bins[partition.locate(direction(point[0], point[1]))];
            let inside = |cell: &&Cell| {
                (0..2).all(|axis| cell.low[axis] <= point[axis] && point[axis] <= cell.high[axis])
            };
            assert!(bin.iter().any(|cell| inside(&cell)));
        }
    }

    /// A Lambertian surface whose value, but not its sampling, has a lobe about the mirrored direction.
    struct Spike(f64);

    impl Scatterer for Spike {
        fn value(&self, wo: DVec3, wi: DVec3) -> f64 {
            let cosine = DVec3::new(-wo.x, -wo.y, wo.z).dot(wi).max(0.0);
            Lambert { albedo: 0.5 }.value(wo, wi) + (self.0 + 1.0) / (2.0 * PI) * libm::pow(cosine, self.0)
        }

        fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
            Lambert { albedo: 0.5 }.pdf(wo, wi)
        }

        fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<crate::Sample> {
            Lambert { albedo: 0.5 }.sample(wo, u)
        }
    }

    #[test]
    fn a_lobe_that_is_never_drawn_is_integrated_where_lobes_usually_are() {
        for wo in [direction(0.7, 0.4), direction(0.2, 3.0)] {
            for exponent in [1e3, 1e6, 1e8] {
                let spike = Spike(exponent);
                let partition = Partition::adapt(&spike, wo, &mut Stream::named("spike", 0), 64);
                let all: Integral =
                    partition.integrate(1e-4, &spike, |wi| spike.value(wo, wi)).into_iter().sum();
                // Half by the surface, and one by the lobe.
                assert!((all.value - 1.5).abs() < 1e-3 + all.error, "{wo} {exponent}: {all:?}");
            }
        }
    }

    #[test]
    fn narrow_lobes_fill_all_bins_evenly() {
        for alpha in [1e-3, 0.01, 0.5] {
            let (conductor, wo) = (Conductor { alpha, r0: 0.9 }, direction(0.8, 0.0));
            let partition = Partition::adapt(&conductor, wo, &mut Stream::new(1), 64);
            let masses = partition.integrate(1e-4, &conductor, |wi| conductor.pdf(wo, wi));
            let above = masses.iter().filter(|mass| mass.value > 0.2 / 64.0).count();
            assert!(above >= 60, "{above} of {} bins at α = {alpha}", partition.bins());
        }
        assert!(Partition::adapt(&Lambert { albedo: 0.5 }, DVec3::Z, &mut Stream::new(0), 64).bins() >= 60);
    }
}
