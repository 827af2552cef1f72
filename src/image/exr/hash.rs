//! The hash of an image's values.

use super::VARIANCE;
use crate::film::Accumulators;
use crate::image::Channel;
use xxhash_rust::xxh3::Xxh3;

/// XXH3 of the names and values of all channels and of the accumulators, whatever the order of the channels.
pub fn hash(channels: &[Channel], accumulators: Option<&Accumulators>) -> String {
    let mut named: Vec<(String, &[f32])> = vec![];
    for channel in channels {
        named.push((channel.name.clone(), &channel.mean));
        named.extend(channel.variance.iter().map(|of| (format!("{VARIANCE}{}", channel.name), &of[..])));
    }
    named.sort_by(|a, b| a.0.cmp(&b.0));
    let mut hash = Xxh3::new();
    let mut put = |words: &mut dyn Iterator<Item = u32>| {
        let bytes: Vec<u8> = words.flat_map(u32::to_le_bytes).collect();
        hash.update(&bytes);
    };
    for (name, values) in named {
        put(&mut name.bytes().map(u32::from));
        values.chunks(4096).for_each(|some| put(&mut some.iter().map(|value| value.to_bits())));
    }
    if let Some(accumulators) = accumulators {
        // Words by channel, for channels may come in another order.
        let mut order: Vec<usize> = (0..channels.len()).collect();
        order.sort_by_key(|channel| &channels[*channel].name);
        for y in 0..accumulators.height() {
            let pixels = (0..accumulators.width()).map(|x| accumulators.pixel(x, y));
            let sums = pixels.flat_map(|pixel| order.iter().map(move |channel| &pixel[*channel]));
            put(&mut sums.flat_map(|sum| (0..Accumulators::WORDS).map(move |i| sum.word(i))));
        }
    }
    format!("{:016x}", hash.digest())
}
