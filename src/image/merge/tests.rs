use super::*;
use crate::image::exr::encode;
use crate::image::provenance::tests::example;
use proptest::prelude::*;
use std::ops::Range;

const CHANNELS: [&str; 2] = ["R", "G"];

/// Some sample values of wide range, given by their address.
fn sample(x: u32, y: u32, channel: usize, index: u64) -> f64 {
    let mix = (u64::from(x) * 31 + u64::from(y) * 17 + channel as u64 * 7 + index + 1)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let value = (mix >> 11) as f64 / (1u64 << 53) as f64;
    libm::scalbn(value, (mix % 97) as i32 - 48)
}

fn render(crop: Window, samples: Range<u64>, shard: bool) -> Image {
    let mut accumulators = Accumulators::new(crop.width, crop.height, CHANNELS.len());
    for y in 0..crop.height {
        for x in 0..crop.width {
            for (c, channel) in accumulators.pixel_mut(x, y).iter_mut().enumerate() {
                samples.clone().for_each(|s| channel.add(s, sample(crop.x + x, crop.y + y, c, s)));
            }
        }
    }
    let names = CHANNELS.map(String::from);
    Image::from_accumulators((16, 12), crop, &names, example(samples), accumulators, shard)
}

fn window(x: u32, y: u32, width: u32, height: u32) -> Window {
    Window { x, y, width, height }
}

fn named(images: Vec<Image>) -> Vec<(PathBuf, Image)> {
    images.into_iter().enumerate().map(|(i, image)| (format!("{i}.exr").into(), image)).collect()
}

/// Divides a window and a sample range at random, a cut at a time, along a random axis.
fn divisions() -> impl Strategy<Value = Vec<(Window, Range<u64>)>> {
    prop::collection::vec((any::<prop::sample::Index>(), 0..3, any::<prop::sample::Index>()), 0..8)
        .prop_map(|cuts| {
            let mut parts = vec![(window(2, 3, 9, 7), 8u64..31)];
            for (which, axis, place) in cuts {
                let (mut a, mut a_samples) = parts.swap_remove(which.index(parts.len()));
                let (mut b, mut b_samples) = (a, a_samples.clone());
                if axis == 0 && a.width > 1 {
                    a.width = 1 + place.index(a.width as usize - 1) as u32;
                    (b.x, b.width) = (b.x + a.width, b.width - a.width);
                } else if axis == 1 && a.height > 1 {
                    a.height = 1 + place.index(a.height as usize - 1) as u32;
                    (b.y, b.height) = (b.y + a.height, b.height - a.height);
                } else if axis == 2 && a_samples.end - a_samples.start > BLOCK {
                    let blocks = (a_samples.end - a_samples.start - 1) / BLOCK;
                    let cut = a_samples.start + BLOCK * (1 + place.index(blocks as usize) as u64);
                    (a_samples.end, b_samples.start) = (cut, cut);
                } else {
                    parts.push((a, a_samples));
                    continue;
                }
                parts.extend([(a, a_samples), (b, b_samples)]);
            }
            parts
        })
        .prop_shuffle()
}

proptest! {
    #[test]
    fn any_division_in_any_order_gives_the_file_of_one_run(parts in divisions()) {
        let shards = parts.into_iter().map(|(window, samples)| render(window, samples, true)).collect();
        let merged = merge(named(shards));
        prop_assert_eq!(merged.and_then(|image| encode(&image)), encode(&render(window(2, 3, 9, 7), 8..31, true)));
    }
}

#[test]
fn files_merge_like_images_and_errors_name_them() -> std::io::Result<()> {
    let folder = tempfile::tempdir()?;
    let path = |name: &str| folder.path().join(name);
    for shard in [true, false] {
        let parts = [(window(5, 0, 3, 4), "a"), (window(0, 0, 5, 2), "b"), (window(0, 2, 5, 2), "c")];
        for (crop, name) in parts {
            assert_eq!(super::super::write_exr(&path(name), &render(crop, 0..16, shard)), Ok(()));
        }
        let files = |names: &[&str]| names.iter().map(|name| path(name)).collect::<Vec<_>>();
        let merged = merge_files(files(&["b", "a", "c"])).and_then(|image| encode(&image));
        assert_eq!(merged, encode(&render(window(0, 0, 8, 4), 0..16, shard)));
        let error = merge_files(files(&["a", "b", "b"])).map_err(|error| error.to_string());
        let both = error.expect_err("they overlap");
        assert!(both.contains("b and") && both.contains("the same samples"), "{both}");
        // The head says what the file is; that the rest is missing shows when it is read.
        let bytes = std::fs::read(path("c"))?;
        std::fs::write(path("c"), &bytes[..bytes.len() - 9])?;
        for names in [["a", "b", "c"], ["a", "b", "gone"]] {
            let error = merge_files(files(&names)).expect_err("it cannot be read");
            assert_eq!(error.path, Some(path(names[2])));
        }
    }
    Ok(())
}

#[test]
fn merging_can_be_nested() {
    let whole = window(0, 0, 4, 4);
    let shards = [0..8, 8..12, 12..24].map(|samples| render(whole, samples, true));
    let [a, b, c] = shards;
    let inner = merge(named(vec![c, b]));
    let outer = inner.and_then(|inner| merge(named(vec![inner, a])));
    assert_eq!(outer, Ok(render(whole, 0..24, true)));
}

#[test]
fn crops_of_equal_samples_need_no_accumulators() {
    let crops = [window(5, 0, 3, 4), window(0, 0, 5, 2), window(0, 2, 5, 2)];
    let merged = merge(named(crops.map(|crop| render(crop, 0..16, false)).into()));
    assert_eq!(merged, Ok(render(window(0, 0, 8, 4), 0..16, false)));
}

#[test]
fn a_channel_without_variance_stays_without() {
    let mut shards = [0..8, 8..16].map(|samples| render(window(0, 0, 2, 2), samples, true));
    shards.iter_mut().for_each(|shard| shard.channels[1].variance = None);
    let merged = merge(named(shards.into()));
    assert_eq!(merged.map(|image| image.channels[1].variance.clone()), Ok(None));
}

#[test]
fn channels_are_matched_by_name() {
    let whole = window(0, 0, 2, 2);
    let mut other = render(whole, 8..16, true);
    other.channels.reverse();
    let accumulators = other.accumulators.as_mut().expect("a shard");
    (0..2).for_each(|y| (0..2).for_each(|x| accumulators.pixel_mut(x, y).reverse()));
    assert_eq!(merge(named(vec![render(whole, 0..8, true), other])), Ok(render(whole, 0..16, true)));
}

#[test]
fn refusals_name_both_files_and_the_reason() {
    let part = |samples, shard| render(window(0, 0, 2, 2), samples, shard);
    let change = |change: fn(&mut Image)| {
        let mut image = part(8..16, true);
        change(&mut image);
        image
    };
    let cases: [(Image, &str); 7] = [
        (change(|i| i.provenance.as_mut().expect("set").seed = 3), "their seed differs"),
        (
            change(|i| i.provenance.as_mut().expect("set").scene = "x".into()),
            "their scene differs, `9f86d081884c7d65` and `x`",
        ),
        (change(|i| i.full = (32, 32)), "their films differ, 16 × 12 and 32 × 32"),
        (change(|i| i.channels[0].name = "B".into()), "their channels differ"),
        (part(8..16, false), "one of them was rendered with --samples and the other was not"),
        (part(4..12, true), "the same samples of the same pixels"),
        (part(12..16, true), "samples 8..12 of pixel (0, 0) are missing"),
    ];
    for (image, reason) in cases {
        let message = merge(named(vec![part(0..8, true), image])).map_err(|error| error.to_string());
        let message = message.expect_err("must be refused");
        assert!(message.contains(reason), "{message}");
        assert!(
            reason.contains("missing") || message.starts_with("0.exr and 1.exr cannot be merged: "),
            "{message}"
        );
    }
    let foreign = merge(named(vec![part(0..8, true), change(|i| i.provenance = None)]));
    let message = foreign.map_err(|error| error.to_string()).expect_err("must be refused");
    assert!(message.contains("1.exr") && !message.contains("0.exr"), "{message}");
    assert!(message.contains("does not say what was rendered"), "{message}");
    let plain = merge(named(vec![part(0..8, false), part(8..16, false)])).map_err(|error| error.to_string());
    let reason =
        "0.exr and 1.exr cannot be merged: they hold different samples, 0..8 and 8..16, but are not shards";
    assert_eq!(plain.err().as_deref(), Some(reason));
    assert!(merge(vec![]).is_err());
}
