use super::*;
use crate::renderers::Renderer;
use crate::stage;
use crate::study::line::{lines, misses};
use etalon::spectrum::ColorMode;

const SEEDS: u32 = 3;

/// A folder with a picture of each seed that a study asks for, one under half the light, and a smaller one.
fn pictures() -> PathBuf {
    let folder = std::env::temp_dir().join(format!("etalon-bench-pictures-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let ball = stage::sphere([0.0; 3], 1.0, &stage::diffuse(0.5));
    let under = |radiance: f64, size: u32| {
        let place = stage::look_at([0.0, -4.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let camera = stage::pinhole(&place, 40.0, &stage::film(size, size));
        let lamp = stage::sphere([0.0, -3.0, 3.0], 0.5, &stage::area(radiance));
        stage::load(&stage::scene(&[&stage::path(3), &camera, &ball, &lamp]), ColorMode::Rgb).unwrap()
    };
    let scenes = [("", under(4.0, 8)), ("dark-", under(2.0, 8)), ("small-", under(4.0, 4))];
    let asked = [("trial", 1), ("reference", REFERENCES), ("picture", SEEDS)];
    for seed in asked.into_iter().flat_map(|(what, count)| (0..count).map(move |k| seed(what, k))) {
        for (name, scene) in &scenes {
            let settings = etalon::render::Settings { seed, ..etalon::render::Settings::of(scene, 0..8) };
            let image = stage::expose(scene, &settings).unwrap();
            etalon::image::write_exr(&folder.join(format!("{name}{seed}.exr")), &image).unwrap();
        }
    }
    folder
}

#[test]
fn renderers_that_fail_late_or_have_no_seed_are_named_and_nothing_is_lost() {
    let pictures = pictures();
    let shows = |file: &str| format!("cp {}/{file}.exr {{out}}", pictures.display());
    let failing = format!(
        "sh -c 'test {{seed}} != {} && cp {}/{{seed}}.exr {{out}}'",
        seed("picture", 1),
        pictures.display()
    );
    let commands = [
        ("steady", shows("{seed}")),
        ("late", failing),
        ("same", shows(&seed("trial", 0).to_string())),
        ("idle", "true {out}".to_owned()),
        ("dark", shows("dark-{seed}")),
        ("small", shows("small-{seed}")),
    ];
    let entry =
        |(name, command): (&str, String)| (name.to_owned(), Renderer { command, mean_of: None, color: None });
    let renderers: Renderers = commands.into_iter().map(entry).collect();
    let ladder = Ladder::Samples(vec![8]);
    let settings = Settings { ladder, seeds: SEEDS, reference: 1.0, threads: 1, processor_time: false };
    let scene = pictures.join("any.xml");
    std::fs::write(&scene, "<scene version=\"3.0.0\"/>").unwrap();
    let bench = Bench {
        scene,
        folder: pictures.join("study"),
        renderers: &renderers,
        settings: &settings,
        limit: None,
    };
    let names = ["steady", "late", "same", "idle", "dark", "small"];
    let failed = bench.measure(&names, &|_| ()).unwrap();
    let (runs, schedule) = (bench.runs().unwrap(), bench.schedule().unwrap());
    let lines = lines(&bench, &names, &runs).unwrap();
    // More samples that change nothing; another scene, and another command, in the same folder.
    let longer = Settings { ladder: Ladder::Samples(vec![4, 8]), ..settings.clone() };
    let two = Bench { folder: pictures.join("two"), settings: &longer, scene: bench.scene.clone(), ..bench };
    let deaf = two.measure(&["steady"], &|_| ()).unwrap();
    let scene = pictures.join("other.xml");
    std::fs::write(&scene, "<scene/>").unwrap();
    let moved = Bench { scene, folder: two.folder.clone(), ..two }.measure(&["steady"], &|_| ());
    let mut others = renderers.clone();
    others.insert("steady".into(), Renderer { command: "true".into(), mean_of: None, color: None });
    let renamed = Bench { renderers: &others, folder: two.folder.clone(), scene: two.scene.clone(), ..two };
    let renamed = renamed.measure(&["steady"], &|_| ());
    std::fs::remove_dir_all(&pictures).unwrap();
    assert!(deaf[0].1.ends_with("that of 4 samples: their number has no effect"), "{deaf:?}");
    assert!(moved.unwrap_err().contains("pictures of another scene"));
    assert!(renamed.unwrap_err().contains("pictures of steady by another command"));
    let of = |name: &str| runs.iter().filter(|run| run.renderer == name).count();
    assert_eq!(names.map(of), [3, 1, 0, 0, 3, 0]);
    assert_eq!(failed.len(), 1);
    assert!(
        failed[0].0 == "late" && failed[0].1.starts_with("seed 1, 8 samples: \"sh\" failed"),
        "{failed:?}"
    );
    let why = |name: &str| schedule[name].clone().unwrap_err();
    // The same relative errors, in pictures that are half as bright.
    let dark = lines.iter().find(|line| line.renderer == "dark").unwrap();
    let over = dark.mean_over_first.unwrap();
    assert!((over.value - 0.5).abs() < 1e-6 && misses(over), "{over:?}");
    assert!(lines[0].mean_over_first.is_none());
    assert!(why("same").contains("the seed has no effect"), "{}", why("same"));
    assert_eq!(why("small"), "its pictures have 4 × 4 pixels, those of steady 8 × 8");
    assert!(why("idle").starts_with("\"true\" ended well, but wrote no "), "{}", why("idle"));
}
