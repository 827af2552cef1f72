//! A forest plot of one renderer's efficiency relative to others, a row for each scene, as a standalone SVG.

use super::Measured;
use super::axis::{Axis, number};
use super::page::figures;
use super::plot::COLOURS;
use crate::html::escape;

/// The row of a scene.
pub struct Row<'a> {
    pub name: &'a str,
    /// The mark of each group of other renderers.
    pub marks: Vec<Mark>,
}

/// A ratio in a row.
pub struct Mark {
    /// The other renderers' error over this one's, at equal time.
    pub ratio: Option<Measured>,
    /// The ratio that is aimed at.
    pub aim: f64,
}

const WIDTH: f64 = 760.0;
const LEFT: f64 = 132.0;
const RIGHT: f64 = 104.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 44.0;
const LINE: f64 = 13.0;

/// The plot: dots with their intervals, and a stroke for each aim. `groups` are the names of the groups of
/// other renderers, at most two.
pub fn forest(groups: &[&str], rows: &[Row], about: &str) -> String {
    let marks = || rows.iter().flat_map(|row| &row.marks);
    let ends = marks().filter_map(|mark| mark.ratio).flat_map(|ratio| [ratio.low, ratio.value, ratio.high]);
    let axis = Axis::over(ends.chain(marks().map(|mark| mark.aim)).chain([1.0]));
    let x = |value: f64| LEFT + (WIDTH - LEFT - RIGHT) * axis.share(value);
    let band = LINE * groups.len() as f64 + 7.0;
    let bottom = TOP + band * rows.len() as f64;
    let height = bottom + BOTTOM;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" font-family=\"sans-serif\" font-size=\"12\" \
         fill=\"#222\" role=\"img\" aria-label=\"{}\">\n<rect width=\"{WIDTH}\" height=\"{height}\" fill=\"white\"/>\n",
        escape(about)
    );
    for (value, named) in axis.ticks() {
        let at = x(value);
        let strength = match named {
            true if value == 1.0 => "#222",
            true => "#bbb",
            false => "#eee",
        };
        svg += &format!("<path d=\"M{at:.1} {TOP}V{bottom:.1}\" stroke=\"{strength}\"/>");
        if named {
            let below = bottom + 16.0;
            svg += &format!(
                "<text x=\"{at:.1}\" y=\"{below:.1}\" text-anchor=\"middle\">{}</text>",
                number(value)
            );
        }
        svg.push('\n');
    }
    for (i, row) in rows.iter().enumerate() {
        let top = TOP + band * i as f64;
        let (right, middle) = (LEFT - 8.0, top + 0.5 * band + 4.0);
        svg += &format!(
            "<text x=\"{right}\" y=\"{middle:.1}\" text-anchor=\"end\">{}</text>\n",
            escape(row.name)
        );
        for (k, mark) in row.marks.iter().enumerate() {
            let at = top + 0.5 * (band - LINE * (row.marks.len() as f64 - 1.0)) + LINE * k as f64;
            svg += &drawn(mark, COLOURS[k % COLOURS.len()], at, x);
        }
    }
    for (k, group) in groups.iter().enumerate() {
        let (colour, at) = (COLOURS[k % COLOURS.len()], LEFT + 250.0 * k as f64);
        svg += &format!(
            "<circle cx=\"{at:.1}\" cy=\"18\" r=\"4\" fill=\"{colour}\"/><text x=\"{:.1}\" y=\"22\">{}</text>\n",
            at + 10.0,
            escape(group)
        );
    }
    let (middle, foot) = (0.5 * (LEFT + WIDTH - RIGHT), height - 10.0);
    svg += &format!(
        "<text x=\"{middle:.1}\" y=\"{foot:.1}\" text-anchor=\"middle\">{}</text>\n</svg>\n",
        escape(about)
    );
    svg
}

/// A dot with its interval, the stroke of its aim, and its value at the right.
fn drawn(mark: &Mark, colour: &str, at: f64, x: impl Fn(f64) -> f64) -> String {
    let aim = x(mark.aim);
    let mut svg = format!("<path d=\"M{aim:.1} {:.1}v10\" stroke=\"#222\" stroke-width=\"2\"/>", at - 5.0);
    let (beside, baseline) = (WIDTH - RIGHT + 10.0, at + 4.0);
    let Some(ratio) = mark.ratio else {
        return svg + &format!("<text x=\"{beside}\" y=\"{baseline:.1}\" fill=\"{colour}\">–</text>\n");
    };
    let (low, value, high) = (x(ratio.low), x(ratio.value), x(ratio.high));
    let shown = figures(ratio.value);
    svg += &format!(
        "<path d=\"M{low:.1} {at:.1}H{high:.1}\" stroke=\"{colour}\" stroke-width=\"2\"/>\
         <circle cx=\"{value:.1}\" cy=\"{at:.1}\" r=\"4\" fill=\"{colour}\"/>\
         <text x=\"{beside}\" y=\"{baseline:.1}\" fill=\"{colour}\">{shown}</text>\n"
    );
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_its_marks_and_names_are_escaped() {
        let at = |value: f64| Some(Measured { value, low: 0.0, high: 2.0 * value });
        let mark = |ratio: Option<Measured>| Mark { ratio, aim: 3.0 };
        let rows = [
            Row { name: "<pool>", marks: vec![mark(at(28.0)), mark(at(0.1))] },
            Row { name: "ring", marks: vec![mark(at(10.0)), mark(None)] },
        ];
        let svg = forest(&["Mitsuba", "a & b"], &rows, "less error");
        // Three dots for the rows and two in the legend.
        assert_eq!(svg.matches("<circle").count(), 5);
        assert_eq!(svg.matches("stroke-width=\"2\"/>").count(), 4 + 3, "aims and intervals");
        assert!(svg.contains("&lt;pool&gt;") && svg.contains("a &amp; b") && svg.contains(">28.0<"), "{svg}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }

    #[test]
    fn nothing_measured_is_a_drawing_too() {
        assert!(forest(&["Mitsuba"], &[], "nothing").ends_with("</svg>\n"));
    }
}
