//! Run times of the parts of a render: rays, trees, every material of the registry, random numbers, pixels,
//! and whole small frames.
//!
//! `cargo bench` prints the time of each, `cargo bench -- roughconductor` of those whose name contains the
//! word; only ratios between two runs on the same machine are meaningful.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use etalon::bsdf::{AnyMaterial, Bsdf, MATERIALS};
use etalon::film::ExactSum;
use etalon::math::{DVec2, DVec3, Ray, Transform, warp};
use etalon::render::{Progress, Settings, render};
use etalon::sampler::{Sampler, SamplerKind};
use etalon::scene::loader::Loader;
use etalon::scene::{Overrides, xml};
use etalon::shape::accel::Accel;
use etalon::shape::mesh_data::sea_urchin;
use etalon::shape::{Geometry, Mesh, Normals, SurfacePoint};
use etalon::spectrum::{ColorMode, Wavelengths};
use std::hint::black_box;
use std::path::Path;

/// Incoherent rays from a sphere around the mesh towards points in it, about half of which hit it.
fn rays() -> Vec<Ray> {
    let ray = |i: u32| {
        let u = Sampler::new(SamplerKind::Independent, 0, (i, 0), 0).block(0);
        let origin = warp::sphere(u.pair(0)) * 2.0;
        let target = warp::sphere(u.pair(1)) * (0.6 * u.one(4));
        Ray::free(origin, etalon::math::frame::unit(target - origin))
    };
    (0..4096).map(ray).collect()
}

fn traversal(criterion: &mut Criterion) {
    let mesh = Geometry::Mesh(Mesh::new(sea_urchin(7), &Transform::IDENTITY, Normals::default()));
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

fn trees(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("building a tree of a sea urchin");
    group.sample_size(10);
    for subdivision in [5, 7] {
        let mesh =
            Geometry::Mesh(Mesh::new(sea_urchin(subdivision), &Transform::IDENTITY, Normals::default()));
        group.bench_function(format!("{} triangles", mesh.primitives()), |b| b.iter(|| Accel::new(&[&mesh])));
    }
    group.finish();
}

/// Evaluates the first example of every material, for an oblique pair of directions.
fn materials(criterion: &mut Criterion) {
    let point = SurfacePoint::flat();
    let λ = Wavelengths::sample_visible(0.3);
    let direction = |x: f64, y: f64| DVec3::new(x, y, (1.0 - x * x - y * y).sqrt());
    let (wo, wi) = (direction(0.3, 0.4), direction(-0.25, -0.35));
    for entry in MATERIALS {
        let text = format!("<scene version=\"3.0.0\">{}</scene>", entry.examples[0]);
        let document = xml::read_text("example.xml", &text).expect("examples are well-formed");
        let loader = Loader::new(&document, ColorMode::Spectral).expect("examples can be loaded");
        let material =
            AnyMaterial::parse(&document.root.children[0], &loader).expect("examples are materials");
        let bsdf = material.at(&point, &λ);
        let mut group = criterion.benchmark_group(format!("material {}", entry.name));
        group.bench_function("prepare", |b| {
            b.iter(|| black_box(material.at(black_box(&point), black_box(&λ))))
        });
        group.bench_function("value and density", |b| b.iter(|| bsdf.evaluate(black_box(wo), black_box(wi))));
        let u = DVec2::new(0.3, 0.6);
        group.bench_function("sample", |b| {
            b.iter(|| bsdf.sample(black_box(wo), black_box(0.4), black_box(u)))
        });
        group.finish();
    }
}

fn numbers(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("a block of random numbers");
    for (name, kind) in [("independent", SamplerKind::Independent), ("sobol", SamplerKind::Sobol)] {
        let mut sample = 0;
        group.bench_function(name, |b| {
            b.iter(|| {
                sample += 1;
                Sampler::new(kind, 0, (3, 5), black_box(sample)).block(black_box(2))
            })
        });
    }
    group.finish();
}

fn film(criterion: &mut Criterion) {
    let mut sum = ExactSum::default();
    criterion.bench_function("film: one value into an exact sum", |b| b.iter(|| sum.add(black_box(0.3))));
}

fn frames(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("64x48 at 16 samples a pixel, one thread");
    group.sample_size(20);
    for name in ["cornell-spheres", "cornell-glossy", "prism"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).with_extension("xml");
        let overrides = Overrides { size: Some((64, 48)), ..Overrides::default() };
        let scene = etalon::load(&path, &[], ColorMode::Spectral, &overrides)
            .expect("the scene is the project's own");
        let settings = Settings::of(&scene, 0..16);
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

criterion_group!(benches, traversal, trees, materials, numbers, film, frames);
criterion_main!(benches);
