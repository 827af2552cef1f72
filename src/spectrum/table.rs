//! Measured spectra: values at wavelengths, and straight lines between them.

/// A piecewise-linear function of wavelength in nm; zero outside its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Tabulated {
    wavelengths: Vec<f32>,
    values: Vec<f32>,
    search: Search,
}

/// How the interval of a wavelength is found.
#[derive(Clone, Debug, PartialEq)]
enum Search {
    /// The wavelengths are evenly spaced, this many for each nm.
    Even(f32),
    /// There are this many cells for each nm, and each knows the last wavelength before it, or the first; so does the
    /// end of the last one.
    Cells(f32, Vec<u32>),
}

/// How many cells there are for each wavelength: tables may be many times as dense in one place as on average.
const CELLS: usize = 4;

impl Search {
    fn cells(wavelengths: &[f32]) -> Self {
        let (first, last) = (wavelengths[0], wavelengths[wavelengths.len() - 1]);
        let count = CELLS * wavelengths.len();
        let per_nm = count as f32 / (last - first);
        // Rounding is monotonic, so what is in an earlier cell is less.
        let cell = |λ: f32| cell_of(λ - first, per_nm, count);
        let before = |at| wavelengths.partition_point(|&λ| cell(λ) < at).saturating_sub(1) as u32;
        Self::Cells(per_nm, (0..=count).map(before).collect())
    }
}

#[inline]
fn cell_of(distance: f32, per_nm: f32, count: usize) -> usize {
    ((distance * per_nm) as usize).min(count - 1)
}

/// The error says what is wrong with a table.
fn check(wavelengths: &[f32], values: &[f32]) -> Result<(), String> {
    if wavelengths.len() != values.len() {
        return Err(format!("{} wavelengths but {} values", wavelengths.len(), values.len()));
    }
    if wavelengths.len() < 2 {
        return Err("a table needs at least two wavelengths".into());
    }
    if let Some(i) = values.iter().chain(wavelengths).position(|v| !v.is_finite()) {
        return Err(format!("entry {} is not finite", i % values.len() + 1));
    }
    if let Some(i) = wavelengths.windows(2).position(|w| w[1] <= w[0]) {
        return Err(format!(
            "wavelengths must increase, but {} follows {}",
            wavelengths[i + 1],
            wavelengths[i]
        ));
    }
    Ok(())
}

impl Tabulated {
    /// Values at increasing wavelengths. The error says what is wrong with them.
    pub fn new(wavelengths: Vec<f32>, values: Vec<f32>) -> Result<Self, String> {
        check(&wavelengths, &values)?;
        let search = Search::cells(&wavelengths);
        Ok(Self { wavelengths, values, search })
    }

    /// Values spread evenly over [min, max] nm.
    pub fn regular(min: f32, max: f32, values: Vec<f32>) -> Result<Self, String> {
        let last = values.len().saturating_sub(1).max(1) as f32;
        let wavelengths: Vec<f32> =
            (0..values.len()).map(|i| min + (max - min) * (i as f32 / last)).collect();
        check(&wavelengths, &values)?;
        Ok(Self { wavelengths, values, search: Search::Even(last / (max - min)) })
    }

    /// Reads lines of "wavelength value", whatever follows, `#` starting a comment. The error names the line;
    /// a comma within a word is one, for "400 0,5" would be black.
    pub fn parse_spd(text: &str) -> Result<Self, String> {
        let (mut wavelengths, mut values) = (vec![], vec![]);
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        for (i, line) in text.lines().enumerate() {
            let line = line.split('#').next().unwrap_or("").trim();
            if line.is_empty() {
                continue;
            }
            let inside_word = |word: &str| word.trim_matches(',').contains(',');
            if line.contains(char::is_whitespace) && line.split_whitespace().any(inside_word) {
                return Err(format!("line {}: expected decimal points, not commas, found `{line}`", i + 1));
            }
            let mut words = line.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty());
            let mut number = || words.next()?.parse::<f32>().ok().filter(|v| v.is_finite());
            let (Some(λ), Some(value)) = (number(), number()) else {
                return Err(format!("line {}: expected a wavelength and a value, found `{line}`", i + 1));
            };
            if wavelengths.last().is_some_and(|&previous| λ <= previous) {
                return Err(format!("line {}: wavelengths must increase, found `{line}`", i + 1));
            }
            wavelengths.push(λ);
            values.push(value);
        }
        Self::new(wavelengths, values)
    }

    /// The value at a wavelength in nm.
    #[inline]
    pub fn eval(&self, λ: f32) -> f32 {
        let last = self.wavelengths.len() - 1;
        // Written so that a NaN is outside, too.
        if !(λ >= self.wavelengths[0] && λ <= self.wavelengths[last]) {
            return 0.0;
        }
        let distance = λ - self.wavelengths[0];
        let i = match &self.search {
            Search::Even(per_nm) => ((distance * per_nm) as usize).min(last - 1),
            Search::Cells(per_nm, before) => {
                let cell = cell_of(distance, *per_nm, before.len() - 1);
                let (from, to) = (before[cell] as usize, before[cell + 1] as usize);
                let i = from + self.wavelengths[from + 1..=to].partition_point(|&w| w <= λ);
                i.min(last - 1)
            }
        };
        let t = (λ - self.wavelengths[i]) / (self.wavelengths[i + 1] - self.wavelengths[i]);
        self.values[i] * (1.0 - t) + self.values[i + 1] * t
    }

    /// The first and last wavelength.
    pub fn range(&self) -> (f32, f32) {
        (self.wavelengths[0], self.wavelengths[self.wavelengths.len() - 1])
    }

    /// All wavelengths in nm, each with its value.
    pub fn nodes(&self) -> impl Iterator<Item = (f32, f32)> {
        self.wavelengths.iter().copied().zip(self.values.iter().copied())
    }

    /// The mean over the wavelengths from `min` to `max` nm.
    pub fn mean(&self, min: f32, max: f32) -> f64 {
        let of_piece = |(first, last): ((f32, f32), (f32, f32))| {
            let [(a, from), (b, to)] = [first, last].map(|(λ, v)| (f64::from(λ), f64::from(v)));
            let (begin, end) = (a.max(min.into()), b.min(max.into()));
            // A straight line has its mean in the middle.
            let middle = from + (to - from) * (0.5 * (begin + end) - a) / (b - a);
            if begin < end { (end - begin) * middle } else { 0.0 }
        };
        self.nodes().zip(self.nodes().skip(1)).map(of_piece).sum::<f64>() / f64::from(max - min)
    }

    /// The smallest and largest value.
    pub fn bounds(&self) -> (f32, f32) {
        self.values.iter().fold((f32::MAX, f32::MIN), |(lo, hi), &v| (lo.min(v), hi.max(v)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regular_and_irregular_tables_agree() {
        let values: Vec<f32> = (0..48).map(|i| ((i * 7919) % 13) as f32).collect();
        let regular = Tabulated::regular(360.0, 830.0, values.clone()).unwrap();
        let irregular = Tabulated::new((0..48).map(|i| 360.0 + 10.0 * i as f32).collect(), values).unwrap();
        for i in 0..10_000 {
            let λ = 350.0 + 0.05 * i as f32;
            assert!((regular.eval(λ) - irregular.eval(λ)).abs() < 1e-3, "{λ}");
        }
        assert_eq!(
            (regular.eval(359.9), regular.eval(830.0), regular.eval(f32::NAN)),
            (0.0, regular.values[47], 0.0)
        );
    }

    #[test]
    fn intervals_are_those_of_a_search() {
        let cubic = |x: f32| 300.0 + x * x * x / 27.0;
        // Dense in the middle, with neighbours that differ by a rounding.
        let mut wavelengths: Vec<f32> = (0..60).map(|i| cubic(i as f32 - 30.0)).collect();
        wavelengths.extend([1301.0, f32::from_bits(1301f32.to_bits() + 1), 90_000.0]);
        wavelengths.dedup();
        let values = (0..wavelengths.len()).map(|i| i as f32).collect();
        let table = Tabulated::new(wavelengths.clone(), values).unwrap();
        let between =
            wavelengths.windows(2).flat_map(|w| (0..8).map(|k| w[0] + (w[1] - w[0]) * k as f32 / 8.0));
        let beside = wavelengths
            .iter()
            .flat_map(|&λ| [-1, 0, 1].map(|k| f32::from_bits((λ.to_bits() as i32 + k) as u32)));
        let (first, last) = table.range();
        for λ in between.chain(beside).filter(|λ| (first..=last).contains(λ)) {
            let i = (wavelengths.partition_point(|&w| w <= λ) - 1).min(wavelengths.len() - 2);
            let t = (λ - wavelengths[i]) / (wavelengths[i + 1] - wavelengths[i]);
            assert_eq!(table.eval(λ), i as f32 * (1.0 - t) + (i + 1) as f32 * t, "{λ}");
        }
    }

    #[test]
    fn bad_tables_say_what_is_wrong() {
        assert!(Tabulated::new(vec![1.0, 1.0], vec![0.0, 0.0]).unwrap_err().contains("increase"));
        assert!(Tabulated::new(vec![1.0], vec![0.0]).unwrap_err().contains("two"));
        assert!(Tabulated::new(vec![1.0, 2.0], vec![0.0, f32::NAN]).unwrap_err().contains("entry 2"));
        assert!(Tabulated::parse_spd("400 1\n# c\n500 x\n").unwrap_err().contains("line 3"));
        assert!(Tabulated::parse_spd("400 1\n300 1\n").unwrap_err().contains("line 2"));
        assert!(Tabulated::parse_spd("400 1\n500 nan\n").unwrap_err().contains("line 2"));
        assert!(Tabulated::parse_spd("400 1\nx 500 1\n").unwrap_err().contains("line 2"));
        assert!(Tabulated::parse_spd("400 1\n500\n").unwrap_err().contains("line 2"));
        assert!(Tabulated::parse_spd("400 1\n500 0,5\n").unwrap_err().contains("line 2: expected decimal"));
        assert_eq!(Tabulated::parse_spd("400,1,7\n500,3,7\n").unwrap().eval(450.0), 2.0);
        assert!(Tabulated::regular(700.0, 400.0, vec![1.0, 2.0]).unwrap_err().contains("increase"));
        assert_eq!(Tabulated::parse_spd("400 1 # c\n\n500 3\n").unwrap().eval(450.0), 2.0);
        let more = Tabulated::parse_spd("400 1 0.5 measured\n500, 3, nan").unwrap();
        assert_eq!((more.range(), more.eval(450.0)), ((400.0, 500.0), 2.0));
    }
}
