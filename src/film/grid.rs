//! The accumulators of a rectangle of pixels.

use super::{ChannelAccumulator, ExactSum};

/// The accumulators of `width × height` pixels with a fixed number of channels each, stored pixel by pixel in
/// rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Accumulators {
    width: u32,
    height: u32,
    channels: usize,
    data: Vec<ChannelAccumulator>,
}

impl Accumulators {
    /// Number of 32-bit words in the stored form of one channel of one pixel.
    pub const WORDS: usize = 2 * ExactSum::WORDS + 2;

    /// Empty accumulators.
    pub fn new(width: u32, height: u32, channels: usize) -> Accumulators {
        let data = vec![ChannelAccumulator::default(); width as usize * height as usize * channels];
        Accumulators { width, height, channels, data }
    }

    /// Number of columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Number of channels of a pixel.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The channels of the pixel in column `x` and row `y`.
    pub fn pixel(&self, x: u32, y: u32) -> &[ChannelAccumulator] {
        let first = self.index(x, y);
        &self.data[first..first + self.channels]
    }

    /// The channels of the pixel in column `x` and row `y`, mutably.
    pub fn pixel_mut(&mut self, x: u32, y: u32) -> &mut [ChannelAccumulator] {
        let first = self.index(x, y);
        &mut self.data[first..first + self.channels]
    }

    /// All accumulators, pixel by pixel in rows.
    pub fn all(&self) -> &[ChannelAccumulator] {
        &self.data
    }

    /// The same, to be changed.
    pub fn all_mut(&mut self) -> &mut [ChannelAccumulator] {
        &mut self.data
    }

    /// The accumulators of one channel, pixel by pixel in rows.
    pub fn channel(&self, channel: usize) -> impl Iterator<Item = &ChannelAccumulator> {
        self.data.iter().skip(channel).step_by(self.channels)
    }

    fn index(&self, x: u32, y: u32) -> usize {
        (y as usize * self.width as usize + x as usize) * self.channels
    }
}

impl ChannelAccumulator {
    /// One word of the stored form: those of the sum, of the sum of squares, and the low and high half of the
    /// incomplete block.
    pub fn word(&self, index: usize) -> u32 {
        const SQUARES: usize = ExactSum::WORDS;
        const OPEN: usize = 2 * ExactSum::WORDS;
        match index {
            0..SQUARES => self.sum.to_words()[index],
            SQUARES..OPEN => self.squares.to_words()[index - SQUARES],
            OPEN => self.open_bits() as u32,
            _ => (self.open_bits() >> 32) as u32,
        }
    }

    /// The bits of the incomplete block in the stored form, which has only one NaN: its sign and payload
    /// depend on how it came about.
    fn open_bits(&self) -> u64 {
        if self.open.is_nan() { f64::NAN.to_bits() } else { self.open.to_bits() }
    }

    /// The accumulator with this stored form, or `None` if the words are damaged.
    pub fn from_words(words: &[u32; Accumulators::WORDS]) -> Option<ChannelAccumulator> {
        let (sum, rest) = words.split_first_chunk()?;
        let (squares, open) = rest.split_first_chunk()?;
        Some(ChannelAccumulator {
            sum: ExactSum::from_words(sum)?,
            squares: ExactSum::from_words(squares)?,
            open: f64::from_bits(u64::from(*open.get(1)?) << 32 | u64::from(*open.first()?)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_and_channels_address_the_same_cells() {
        let mut grid = Accumulators::new(3, 2, 2);
        grid.pixel_mut(2, 1)[1].add(0, 5.0);
        let cells: Vec<f64> = grid.channel(1).map(|channel| channel.mean(1)).collect();
        assert_eq!(cells, [0.0, 0.0, 0.0, 0.0, 0.0, 5.0]);
        assert!(grid.channel(0).all(|channel| channel.mean(1) == 0.0));
    }

    #[test]
    fn words_bring_an_accumulator_back() {
        let mut channel = ChannelAccumulator::default();
        (0..10).for_each(|i| channel.add(i, 0.1 + i as f64 * 1e5));
        let words = std::array::from_fn(|i| channel.word(i));
        assert_eq!(ChannelAccumulator::from_words(&words), Some(channel));
        assert_eq!(ChannelAccumulator::from_words(&[u32::MAX; Accumulators::WORDS]), None);
    }
}
