//! Error against seconds on logarithmic axes, as SVG with a legend of text beside it.

use super::{Curve, Interval};
use crate::html::escape;

/// Okabe and Ito's palette, which colour-blind eyes can tell apart; black and yellow are left out for the
/// sake of both themes.
const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
/// The second, third … time that a colour comes around, the line is dashed in another way.
const DASHES: [&str; 4] = ["", "7 4", "2 3", "9 3 2 3"];
const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 380.0;
const LEFT: f64 = 52.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 44.0;

/// What a line of the plot looks like.
fn look(index: usize) -> (&'static str, &'static str, f64) {
    let width = if index == 0 { 3.5 } else { 1.8 };
    (COLOURS[index % COLOURS.len()], DASHES[index / COLOURS.len() % DASHES.len()], width)
}

/// The plot; bands are the intervals of the mean error. The first curve is drawn thick.
pub fn plot(curves: &[(&str, &Curve)], label: &str) -> String {
    let intervals = || curves.iter().flat_map(|(_, c)| c.errors.iter());
    let seconds = range(curves.iter().flat_map(|(_, c)| c.seconds.iter().map(|i| i.value)));
    let errors = range(intervals().flat_map(|i| [i.low.max(0.3 * i.value), i.value, i.high]));
    let x = |value: f64| LEFT + (WIDTH - LEFT - RIGHT) * share(value, seconds);
    let y = |value: f64| HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * share(value, errors);
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-size=\"13\" fill=\"currentColor\" role=\"img\" aria-label=\"{}\">",
        escape(label)
    );
    for (value, named) in ticks(seconds) {
        let at = x(value);
        svg += &rule(at, TOP, at, HEIGHT - BOTTOM, named);
        if named {
            let below = HEIGHT - BOTTOM + 17.0;
            svg +=
                &format!("<text x=\"{at:.1}\" y=\"{below}\" text-anchor=\"middle\">{}</text>", number(value));
        }
    }
    for (value, named) in ticks(errors) {
        let at = y(value);
        svg += &rule(LEFT, at, WIDTH - RIGHT, at, named);
        if named {
            let (beside, at) = (LEFT - 6.0, at + 4.0);
            svg +=
                &format!("<text x=\"{beside}\" y=\"{at:.1}\" text-anchor=\"end\">{}</text>", number(value));
        }
    }
    for (i, (_, curve)) in curves.iter().enumerate().rev() {
        let (colour, dash, width) = look(i);
        let points = |which: fn(&Interval) -> f64| -> Vec<String> {
            let pairs = curve.seconds.iter().zip(&curve.errors);
            pairs.map(|(s, e)| format!("{:.1},{:.1}", x(s.value), y(which(e)))).collect()
        };
        let band: Vec<String> =
            points(|e| e.low).into_iter().chain(points(|e| e.high).into_iter().rev()).collect();
        svg += &format!("<polygon points=\"{}\" fill=\"{colour}\" opacity=\"0.16\"/>", band.join(" "));
        svg += &format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-dasharray=\"{dash}\"/>",
            points(|e| e.value).join(" ")
        );
    }
    let (middle, bottom) = (0.5 * (LEFT + WIDTH - RIGHT), HEIGHT - 8.0);
    svg += &format!("<text x=\"{middle}\" y=\"{bottom}\" text-anchor=\"middle\">seconds</text></svg>");
    svg
}

/// The legend of [`plot`], as a list that wraps.
pub fn legend(names: &[&str]) -> String {
    let entry = |(i, name): (usize, &&str)| {
        let (colour, dash, width) = look(i);
        format!(
            "<li><svg viewBox=\"0 0 36 8\" width=\"36\" height=\"8\" aria-hidden=\"true\"><path d=\"M0 4H36\" stroke=\"{colour}\" \
             stroke-width=\"{width}\" stroke-dasharray=\"{dash}\"/></svg> {}</li>",
            escape(name)
        )
    };
    format!("<ul class=\"legend\">{}</ul>", names.iter().enumerate().map(entry).collect::<String>())
}

fn rule(x1: f64, y1: f64, x2: f64, y2: f64, named: bool) -> String {
    let strength = if named { 0.3 } else { 0.1 };
    format!("<path d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\" stroke=\"currentColor\" opacity=\"{strength}\"/>")
}

/// Common logarithms of the smallest and the largest positive value, a little widened.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let logs = values.filter(|v| *v > 0.0 && v.is_finite()).map(libm::log10);
    let [low, high] = logs.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
    if low > high { [0.0, 1.0] } else { [low - 0.08, high + 0.08] }
}

fn share(value: f64, [low, high]: [f64; 2]) -> f64 {
    ((libm::log10(value.max(f64::MIN_POSITIVE)) - low) / (high - low)).clamp(0.0, 1.0)
}

/// Whole multiples of powers of ten within the range. Powers are named; so are 2 and 5 where there are few
/// powers.
fn ticks([low, high]: [f64; 2]) -> Vec<(f64, bool)> {
    let few = high.floor() - low.ceil() < 2.0;
    let decades = low.floor() as i32..=high.floor() as i32;
    let all = decades.flat_map(|k| (1..10).map(move |m| (m, f64::from(m) * libm::exp10(f64::from(k)))));
    let within = all.filter(|(_, v)| (low..=high).contains(&libm::log10(*v)));
    within.map(|(m, v)| (v, m == 1 || few && (m == 2 || m == 5))).collect()
}

fn number(value: f64) -> String {
    if (1e-2..1e4).contains(&value) {
        format!("{}", libm::round(value * 100.0) / 100.0)
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_lie_within_and_some_are_named() {
        let found = ticks([-3.2, -0.9]);
        assert!(found.iter().all(|(v, _)| (-3.2..=-0.9).contains(&libm::log10(*v))));
        let named: Vec<String> = found.iter().filter(|t| t.1).map(|t| number(t.0)).collect();
        assert_eq!(named, ["1e-3", "0.01", "0.1"]);
        assert!(ticks([0.1, 0.5]).iter().filter(|t| t.1).count() == 1);
    }

    #[test]
    fn an_error_below_zero_stays_on_the_plot() {
        let at = |value: f64| Interval { value, low: -value, high: 2.0 * value };
        let curve = Curve {
            errors: vec![at(0.1), at(0.01)],
            seconds: vec![at(1.0), at(10.0)],
            efficiency: at(1.0),
            slope: None,
            seconds_to: vec![],
        };
        let svg = plot(&[("a", &curve)], "<a>");
        assert!(!svg.contains("NaN") && !svg.contains("inf") && svg.contains("&lt;a&gt;"), "{svg}");
    }
}
