//! What no expectation shows: who shares with whom, and how much.

use super::exchange::Exchange;
use super::receivers::Receivers;
use super::rivals::Rivals;
use super::shared::{Receiver, Shared, Source};
use super::*;
use crate::integrator::{CameraPath, Counters};
use crate::load_text;
use crate::math::frame::unit;
use crate::math::{DVec3, Ray, Transform};
use crate::sampler::{Sampler, SamplerKind};
use crate::spectrum::{ColorMode, Spectrum, Wavelengths};
use std::collections::BTreeMap;

#[test]
fn groups_are_runs_of_a_cell_and_part_the_film() {
    let film = (21, 13);
    for pixels in PIXELS {
        for sample in [0, 1, 6] {
            let mut seen = BTreeMap::new();
            for corner in (0..3).flat_map(|x| (0..2).map(move |y| (x * CELL, y * CELL))) {
                let cell: Vec<_> = cell(corner, sample, film).collect();
                let groups: Vec<GroupId> = cell.iter().map(|of| super::group(*of, pixels)).collect();
                let mut distinct = groups.clone();
                distinct.dedup();
                let runs = distinct.len();
                distinct.sort_by_key(|group| group.number);
                distinct.dedup();
                assert_eq!(runs, distinct.len(), "a group in two pieces");
                for (of, group) in cell.iter().zip(groups) {
                    assert_eq!((of.sample, group.sample, group.corner()), (sample, sample, corner));
                    assert_eq!(seen.insert(of.pixel, group), None);
                    let edge = correlated_edge(pixels, ColorMode::Rgb);
                    let partners = cell.iter().filter(|other| super::group(**other, pixels) == group);
                    let near = |a: u32, b: u32| a / edge == b / edge;
                    assert!(
                        partners.clone().all(|p| near(p.pixel.0, of.pixel.0) && near(p.pixel.1, of.pixel.1))
                    );
                    assert!(partners.count() <= pixels as usize);
                }
            }
            assert_eq!(seen.len(), (film.0 * film.1) as usize);
            let full = seen.values().filter(|group| group.cell == (0, 0) && group.number == 0).count();
            assert_eq!(full, pixels as usize);
        }
    }
}

#[test]
fn receivers_share_with_their_like_on_the_side_that_is_matte() {
    let receiver = |x: f64, edges: u32| {
        let (p, n) = (DVec3::new(x, 0.0, 0.0), DVec3::Z);
        Shared {
            receiver: Some(Receiver {
                p,
                error: 0.0,
                n,
                primitive: 0,
                weight: Spectrum::ONE,
                lobes: None,
                edges,
            }),
            ..Shared::NOTHING
        }
    };
    let group = [(-1.0, 0), (-0.5, 1), (0.5, 0), (1.0, 1)].map(|(x, edges)| receiver(x, edges));
    let mut receivers = Receivers::default();
    receivers.begin(&group);
    let mut weights = [0.0; 64];
    let mut facing = |path: usize, n: DVec3| {
        let source = Source {
            p: DVec3::new(0.0, 0.0, 2.0),
            error: 0.0,
            n,
            ng: n,
            primitive: 1,
            albedo: Spectrum::ONE,
            lobes: None,
        };
        let facing = receivers.weights(receivers.with_edges_of(path), &source, &mut weights);
        // The cosine at the floor, that at the source, and the distance.
        for (i, x) in [-1.0, -0.5, 0.5, 1.0f64].into_iter().enumerate() {
            let way = DVec3::new(-x, 0.0, 2.0);
            let geometry = (way.z * n.dot(way)).abs() / way.dot(way).powi(2);
            assert!((weights[i] / geometry - 1.0).abs() < 1e-12, "{i}");
        }
        facing
    };
    let ceiling = -DVec3::Z;
    let to_the_left = unit(DVec3::new(-1.0, 0.0, -0.1));
    assert_eq!([0, 1].map(|path| facing(path, ceiling)), [0b0101, 0b1010]);
    assert_eq!([0, 1].map(|path| facing(path, to_the_left)), [0b0001, 0b0010]);
}

/// A ray that ended on its source's surface would be stopped there as often as rounding says, and neighbours
/// would go without.
#[test]
fn sources_do_not_hide_themselves() {
    let axis = DVec3::new(1.0, 2.0, 3.0);
    let turn = Transform::rotate(axis, 25.0).unwrap();
    let placed = |kind: &str, scale: f64, z: f64| {
        format!(
            r#"<shape type="{kind}"><transform name="to_world"><scale value="{scale}"/><translate z="{z}"/>
                <rotate x="1" y="2" z="3" angle="25"/></transform></shape>"#
        )
    };
    // A floor and a ceiling with something beyond both, or no ray would ask them.
    let things =
        [("rectangle", 2.0, 0.0), ("rectangle", 2.0, 2.0), ("sphere", 0.5, -3.0), ("sphere", 0.5, 5.0)];
    let things: String = things.map(|(kind, scale, z)| placed(kind, scale, z)).concat();
    let text = format!(r#"<scene version="3.0.0"><sensor type="perspective"/>{things}</scene>"#);
    let scene = load_text("t", &text, ColorMode::Rgb).unwrap();
    let up = turn.vector(DVec3::Z);
    let part = |i: u32, step: f64| (f64::from(i) * step).fract() - 0.5;
    let camera = CameraPath {
        ray: Ray::free(DVec3::ZERO, DVec3::Z),
        λ: Wavelengths::rgb(),
        sampler: Sampler::new(SamplerKind::Sobol, 0, (0, 0), 0),
        group: 0,
        radiance: Spectrum::ZERO,
        covered: false,
    };
    let mut exchange = Exchange::default();
    for i in 0..1000 {
        let place = |j: u32, z: f64| {
            let i = 8 * i + j;
            turn.point(DVec3::new(2.0 * part(i, 0.618_033_989), 2.0 * part(i, 0.754_877_666), z))
        };
        let group = [0, 1, 2, 3].map(|j| Shared {
            receiver: Some(Receiver {
                p: place(j, 0.0),
                error: scene.point_error(0, place(j, 0.0)),
                n: up,
                primitive: 0,
                weight: Spectrum::ONE,
                lobes: None,
                edges: 0,
            }),
            source: Some(Source {
                p: place(j + 4, 2.0),
                error: scene.point_error(1, place(j + 4, 2.0)),
                n: -up,
                ng: -up,
                primitive: 1,
                albedo: Spectrum::ONE,
                lobes: None,
            }),
            own: Spectrum::ONE,
            radiance: Spectrum::ONE,
        });
        let mut paths = vec![camera; 4];
        exchange.share(&scene, u32::MAX, &mut paths, &group, &mut vec![], &mut Counters::default());
        // Both cosines are the height over the distance.
        let weight = |receiver: u32, source: u32| {
            (place(source + 4, 2.0) - place(receiver, 0.0)).length_squared().powi(2).recip()
        };
        for receiver in 0..4 {
            let part =
                |source: u32| weight(receiver, source) / (0..4).map(|r| weight(r, source)).sum::<f64>();
            let expected: f64 = (0..4).map(part).sum();
            let found = f64::from(paths[receiver as usize].radiance.0[0]);
            assert!((found - expected).abs() < 1e-6, "{i} {receiver}: {found} for {expected}");
        }
    }
}

/// Camera paths, connections and light paths have one whole together, however unlikely some of them are.
#[test]
fn techniques_part_what_all_of_them_find() {
    let ladder = [1e-30, 1e-6, 1.0, 1e6, 1e30];
    for (by_light, density) in ladder.into_iter().flat_map(|c| ladder.map(|s| (c, s))) {
        for to_source in [0.0, 1e-3, 1e3] {
            let rivals = Rivals::new(by_light, to_source, 8);
            let camera = rivals.camera(density);
            let all = camera * (1.0 + rivals.connected) + rivals.light(density);
            assert!((all - 1.0).abs() < 1e-12, "{by_light} {density} {to_source}: {all}");
        }
    }
}
