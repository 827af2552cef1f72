//! Plots as inline SVG: axes, bars and lines, coloured by the style sheet so that they follow the light or
//! dark theme.

use validation::html::escape;

const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 240.0;
const LEFT: f64 = 46.0;
const RIGHT: f64 = 8.0;
const TOP: f64 = 10.0;
const BOTTOM: f64 = 38.0;

/// A plot under construction: its ranges, and its elements so far.
pub struct Chart {
    x: [f64; 2],
    y: [f64; 2],
    body: String,
}

/// Number of kinds of lines and bars; the style sheet has the classes `series-0` to `series-6`.
pub const SERIES: usize = 7;

impl Chart {
    /// An empty plot of these ranges.
    pub fn new(x: [f64; 2], y: [f64; 2]) -> Self {
        Self { x, y, body: String::new() }
    }

    fn across(&self, x: f64) -> f64 {
        LEFT + (WIDTH - LEFT - RIGHT) * (x - self.x[0]) / (self.x[1] - self.x[0])
    }

    fn down(&self, y: f64) -> f64 {
        let share = ((y - self.y[0]) / (self.y[1] - self.y[0])).clamp(0.0, 1.0);
        HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * share
    }

    /// Adds grid lines with their labels, and the labels of the axes.
    pub fn axes(mut self, xs: &[(f64, String)], ys: &[(f64, String)], labels: [&str; 2]) -> Self {
        let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
        for (value, label) in xs {
            let (x, label, y) = (self.across(*value), escape(label), bottom + 14.0);
            self.body += &format!(
                "<path class=\"grid\" d=\"M{x:.1} {TOP}V{bottom}\"/><text class=\"middle\" x=\"{x:.1}\" y=\"{y}\">{label}</text>"
            );
        }
        for (value, label) in ys {
            let (y, label) = (self.down(*value), escape(label));
            let (x, baseline) = (LEFT - 5.0, y + 4.0);
            self.body += &format!(
                "<path class=\"grid\" d=\"M{LEFT} {y:.1}H{right}\"/><text class=\"end\" x=\"{x}\" y=\"{baseline:.1}\">{label}</text>"
            );
        }
        let [across, up] = labels.map(escape);
        let (middle, y, centre) = (0.5 * (LEFT + right), HEIGHT - 6.0, 0.5 * (TOP + bottom));
        self.body += &format!(
            "<text class=\"middle\" x=\"{middle}\" y=\"{y}\">{across}</text>\
             <text class=\"middle\" transform=\"translate(11 {centre}) rotate(-90)\">{up}</text>"
        );
        self
    }

    /// Adds a bar between two positions, from the bottom to `value`.
    pub fn bar(mut self, [from, to]: [f64; 2], value: f64, series: usize) -> Self {
        let (x, y) = (self.across(from), self.down(value));
        let (width, height) = ((self.across(to) - x - 0.6).max(0.3), HEIGHT - BOTTOM - y);
        self.body += &format!(
            "<rect class=\"bar series-{}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>",
            series % SERIES
        );
        self
    }

    /// Adds a line through points; those that are not finite are left out.
    pub fn line(mut self, points: impl IntoIterator<Item = [f64; 2]>, series: usize) -> Self {
        let finite = points.into_iter().filter(|point| point.iter().all(|v| v.is_finite()));
        let places: Vec<String> =
            finite.map(|[x, y]| format!("{:.1},{:.1}", self.across(x), self.down(y))).collect();
        self.body +=
            &format!("<polyline class=\"line series-{}\" points=\"{}\"/>", series % SERIES, places.join(" "));
        self
    }

    /// Adds a dot, if it is finite.
    pub fn dot(mut self, [x, y]: [f64; 2], series: usize) -> Self {
        if x.is_finite() && y.is_finite() {
            let (x, y) = (self.across(x), self.down(y));
            self.body += &format!(
                "<circle class=\"dot series-{}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\"/>",
                series % SERIES
            );
        }
        self
    }

    /// The plot; `about` describes it to those who cannot see it.
    pub fn svg(self, about: &str) -> String {
        let (about, body) = (escape(about), self.body);
        format!("<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{about}\">{body}</svg>")
    }
}

/// A figure with its title, and a caption below it.
pub fn figure(title: &str, drawing: &str, caption: &str) -> String {
    let title = escape(title);
    format!("<figure><h3>{title}</h3>{drawing}<figcaption>{caption}</figcaption></figure>")
}

/// A legend: names of series beside their colours.
pub fn legend<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let entry = |(i, name): (usize, &str)| {
        format!("<span class=\"key\"><i class=\"series-{}\"></i>{}</span> ", i % SERIES, escape(name))
    };
    names.into_iter().enumerate().map(entry).collect()
}

/// Round numbers from 0 to at least `most`, about four of them, with labels.
pub fn ticks(most: f64) -> Vec<(f64, String)> {
    let magnitude = libm::exp10(libm::floor(libm::log10(most.max(f64::MIN_POSITIVE))));
    let step = [0.2, 0.5, 1.0, 2.5].map(|s| s * magnitude).into_iter().find(|s| most / s <= 5.0);
    let step = step.unwrap_or(2.5 * magnitude);
    let label = |value: f64| if value >= 1e4 { format!("{}k", value / 1e3) } else { format!("{value}") };
    (0..).map(|i| f64::from(i) * step).take_while(|v| *v <= most).map(|v| (v, label(v))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_is_not_drawn() {
        let chart = Chart::new([0.0, 1.0], [0.0, 1.0]).line([[0.0, 0.0], [0.5, f64::NAN], [1.0, 1.0]], 0);
        let svg = chart.dot([f64::INFINITY, 0.0], 1).svg("<x>");
        assert!(svg.contains("points=\"46.0,202.0 412.0,10.0\"") && !svg.contains("circle"), "{svg}");
        assert!(svg.contains("aria-label=\"&lt;x&gt;\""));
    }

    #[test]
    fn ticks_are_few_and_round() {
        for most in [0.3, 1.0, 7.0, 950.0, 12_345.0] {
            let count = ticks(most).len();
            assert!((3..=6).contains(&count), "{most}: {:?}", ticks(most));
        }
    }
}
