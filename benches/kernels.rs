//! Closest hits and shadow rays on a mesh of 327 680 triangles, and whole small frames.
//!
//! `cargo bench` prints the time of one ray and of one frame; ratios between two runs on the same machine are what
//! counts.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use etalon::math::{Ray, Transform, warp};
use etalon::render::{Progress, Settings, render};
use etalon::sampler::{Kind, Sampler};
use etalon::scene::{self, Overrides};
use etalon::shape::accel::Accel;
use etalon::shape::mesh_data::sea_urchin;
use etalon::shape::{Geometry, Mesh};
use etalon::spectrum::ColorMode;
use std::hint::black_box;
use std::path::Path;

/// Rays from a sphere around the mesh towards points in it: incoherent, and about half of them hit.
fn rays() -> Vec<Ray> {
    let ray = |i: u32| {
        let u = Sampler::new(Kind::Independent, 7, (i, 0), 0).block(0);
        let origin = warp::sphere(u.pair(0)) * 2.0;
        let target = warp::sphere(u.pair(1)) * (0.6 * u.one(4));
        Ray::free(origin, etalon::math::frame::unit(target - origin))
    };
    (0..4096).map(ray).collect()
}

fn traversal(criterion: &mut Criterion) {
    let mesh = Geometry::Mesh(Mesh::new(sea_urchin(7), &Transform::IDENTITY, false, false));
    let accel = Accel::new(&[&mesh]);
    let rays = rays();
    let mut group = criterion.benchmark_group("sea urchin, 4096 incoherent rays");
    group.bench_function("closest", |b| {
        b.iter(|| rays.iter().filter(|r| accel.closest(black_box(r)).is_some()).count())
    });
    group.bench_function("occluded", |b| {
        b.iter(|| rays.iter().filter(|r| accel.occluded(black_box(r))).count())
    });
    group.finish();
}

fn frames(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("64x48 at 16 samples a pixel, one thread");
    group.sample_size(20);
    for name in ["cornell-spheres", "cornell-glossy", "prism"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).with_extension("xml");
        let overrides = Overrides { size: Some((64, 48)), ..Overrides::default() };
        let scene =
            scene::load(&path, &[], ColorMode::Spectral, &overrides).expect("the scene is the project's own");
        let settings = Settings {
            samples: 0..16,
            seed: 0,
            window: scene.sensor.film.crop,
            threads: 1,
            shard: false,
            kernel: None,
        };
        group.bench_function(name, |b| {
            b.iter_batched(
                Progress::default,
                |progress| render(&scene, &settings, &progress),
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, traversal, frames);
criterion_main!(benches);
