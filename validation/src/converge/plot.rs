//! Error against seconds on logarithmic axes, as SVG with a legend of text beside it.

use super::axis::{Axis, number};
use super::{Curve, Measured};
use crate::html::escape;

/// Okabe and Ito's palette, which is distinguishable to colour-blind readers; black and yellow are left out
/// because they do not suit both the light and the dark theme.
pub(super) const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
/// Dash patterns: the pattern changes each time the colours repeat.
const DASHES: [&str; 4] = ["", "7 4", "2 3", "9 3 2 3"];
const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 380.0;
const LEFT: f64 = 52.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 44.0;

/// Colour, dash pattern and width of a curve.
fn look(index: usize) -> (&'static str, &'static str, f64) {
    let width = if index == 0 { 3.5 } else { 1.8 };
    (COLOURS[index % COLOURS.len()], DASHES[index / COLOURS.len() % DASHES.len()], width)
}

/// The plot. Bands are the intervals of the mean error; the first curve is drawn thick.
pub fn plot(curves: &[(&str, &Curve)], label: &str) -> String {
    let intervals = || curves.iter().flat_map(|(_, c)| c.errors.iter());
    let seconds = Axis::over(curves.iter().flat_map(|(_, c)| c.seconds.iter().map(|i| i.value)));
    let errors = Axis::over(intervals().flat_map(|i| [i.low.max(0.3 * i.value), i.value, i.high]));
    let x = |value: f64| LEFT + (WIDTH - LEFT - RIGHT) * seconds.share(value);
    let y = |value: f64| HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * errors.share(value);
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-size=\"13\" fill=\"currentColor\" role=\"img\" aria-label=\"{}\">",
        escape(label)
    );
    for (value, named) in seconds.ticks() {
        let at = x(value);
        svg += &rule(at, TOP, at, HEIGHT - BOTTOM, named);
        if named {
            let below = HEIGHT - BOTTOM + 17.0;
            svg +=
                &format!("<text x=\"{at:.1}\" y=\"{below}\" text-anchor=\"middle\">{}</text>", number(value));
        }
    }
    for (value, named) in errors.ticks() {
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
        let points = |which: fn(&Measured) -> f64| -> Vec<String> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_below_zero_stays_on_the_plot() {
        let at = |value: f64| Measured { value, low: -value, high: 2.0 * value };
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
