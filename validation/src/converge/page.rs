//! One self-contained page: log–log plots of error against seconds with their intervals, and tables.

use std::fmt::Write;

use super::{Curve, Interval, Ratio};
use crate::html::escape;

/// A renderer's two curves.
pub struct Line<'a> {
    pub name: &'a str,
    pub trimmed: &'a Curve,
    pub whole: &'a Curve,
}

const COLOURS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 400.0;
const EDGE: f64 = 56.0;

/// The page.
pub fn page(
    scene: &str,
    lines: &[Line],
    ratios: &[(String, Option<&Ratio>, Option<&Ratio>)],
    missing: &[(&str, &str)],
) -> String {
    let mut rows = String::new();
    for line in lines {
        for (what, c) in [("trimmed", line.trimmed), ("whole", line.whole)] {
            let optional = |i: Option<Interval>| i.map_or("–".into(), show);
            let cells = [
                escape(line.name),
                what.into(),
                show(c.efficiency),
                optional(c.slope),
                optional(c.seconds_to.first().copied().flatten()),
                optional(c.seconds_to.get(1).copied().flatten()),
            ];
            row(&mut rows, &cells);
        }
    }
    let mut compared = String::new();
    for (name, trimmed, whole) in ratios {
        let cell = |r: &Option<&Ratio>| {
            r.map_or("no answer".into(), |r| {
                let verdict = if r.different { "different" } else { "not told apart" };
                format!("{} ({verdict}, p = {:.1e})", show(r.ratio), r.p_value)
            })
        };
        row(&mut compared, &[escape(name), cell(trimmed), cell(whole)]);
    }
    let mut absent = String::new();
    for (name, reason) in missing {
        row(&mut absent, &[escape(name), escape(reason)]);
    }
    let plots = [("trimmed by 0.1 %", true), ("whole", false)].map(|(title, trimmed)| {
        let curves: Vec<&Curve> = lines.iter().map(|l| if trimmed { l.trimmed } else { l.whole }).collect();
        format!("<h2>relMSE, {title}</h2>{}", plot(lines, &curves))
    });
    let scene = escape(scene);
    format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>Error against run time</title><style>body{{font:16px/1.4 sans-serif;max-width:60rem;margin:auto;padding:1rem}}\
         svg{{width:100%;height:auto}}.wide{{overflow-x:auto}}td,th{{padding:.2rem .6rem;text-align:left;\
         border-bottom:1px solid #ccc}}</style><h1>Error against run time</h1><p>{scene}; brackets and bands are 95 % intervals.</p>{}{}\
         <h2>Curves</h2><div class=wide><table><tr><th>renderer<th>relMSE<th>1/(error · s)<th>slope<th>s to 1 %<th>s to 0.1 %</tr>\
         {rows}</table></div><h2>Efficiency ratios</h2><div class=wide><table><tr><th>of<th>trimmed<th>whole</tr>{compared}</table></div>\
         <h2>Missing</h2><table>{absent}</table></html>\n",
        plots[0], plots[1]
    )
}

fn row(table: &mut String, cells: &[String]) {
    let cells: String = cells.iter().map(|cell| format!("<td>{cell}")).collect();
    table.push_str(&format!("<tr>{cells}</tr>"));
}

fn show(i: Interval) -> String {
    format!("{} [{}, {}]", figures(i.value), figures(i.low), figures(i.high))
}

fn figures(value: f64) -> String {
    if value != 0.0 && !(1e-2..1e4).contains(&value.abs()) {
        format!("{value:.2e}")
    } else {
        format!("{value:.3}")
    }
}

/// Decades of positive values: the exponents below and above.
fn decades(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let logs = values.filter(|v| *v > 0.0 && v.is_finite()).map(libm::log10);
    let [low, high] = logs.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
    if low > high { [0.0, 1.0] } else { [low.floor(), high.ceil().max(low.floor() + 1.0)] }
}

fn plot(lines: &[Line], curves: &[&Curve]) -> String {
    let seconds = decades(curves.iter().flat_map(|c| c.seconds.iter().map(|i| i.value)));
    let errors = decades(curves.iter().flat_map(|c| c.errors.iter().flat_map(|i| [i.low, i.value, i.high])));
    let place = |value: f64, [low, high]: [f64; 2]| (libm::log10(value).max(low) - low) / (high - low);
    let x = |value: f64| EDGE + (WIDTH - 2.0 * EDGE) * place(value, seconds);
    let y = |value: f64| HEIGHT - EDGE - (HEIGHT - 2.0 * EDGE) * place(value.max(f64::MIN_POSITIVE), errors);
    let mut svg = format!("<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-size=\"13\" role=\"img\">");
    let mut add = |text: String| svg.push_str(&text);
    for [from, to, across] in [[seconds[0], seconds[1], 1.0], [errors[0], errors[1], 0.0]] {
        for k in from as i32..=to as i32 {
            let value = libm::exp10(f64::from(k));
            let (x1, y1, x2, y2) = if across == 1.0 {
                (x(value), EDGE, x(value), HEIGHT - EDGE)
            } else {
                (EDGE, y(value), WIDTH - EDGE, y(value))
            };
            add(format!("<path d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\" stroke=\"#ddd\"/>"));
            let (tx, ty) = if across == 1.0 { (x1 - 10.0, y2 + 18.0) } else { (8.0, y1 + 4.0) };
            add(format!("<text x=\"{tx:.1}\" y=\"{ty:.1}\">1e{k}</text>"));
        }
    }
    for (i, (line, c)) in lines.iter().zip(curves).enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        let points = |which: fn(&Interval) -> f64| -> Vec<String> {
            c.seconds
                .iter()
                .zip(&c.errors)
                .map(|(s, e)| format!("{:.1},{:.1}", x(s.value), y(which(e))))
                .collect()
        };
        let band: Vec<String> =
            points(|e| e.low).into_iter().chain(points(|e| e.high).into_iter().rev()).collect();
        add(format!("<polygon points=\"{}\" fill=\"{colour}\" opacity=\"0.2\"/>", band.join(" ")));
        add(format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>",
            points(|e| e.value).join(" ")
        ));
        let (tx, ty) = (WIDTH - EDGE - 190.0, EDGE + 16.0 * (i as f64 + 1.0));
        add(format!("<text x=\"{tx}\" y=\"{ty}\" fill=\"{colour}\">{}</text>", escape(line.name)));
    }
    let (middle, bottom) = (0.5 * WIDTH, HEIGHT - 10.0);
    // Writing to a String cannot fail.
    let _written = write!(
        svg,
        "<text x=\"{middle}\" y=\"{bottom}\">seconds</text><text x=\"8\" y=\"20\">relMSE</text></svg>"
    );
    svg
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::converge::{Rung, curve};

    #[test]
    fn the_page_is_whole_and_escapes_names() {
        let rung = |samples: u32| {
            let n = f64::from(samples);
            Rung { samples, errors: vec![1.0 / n, 1.1 / n], seconds: vec![n, n] }
        };
        let c = curve(&[rung(1), rung(100)], 0).unwrap();
        let html =
            page("a.xml", &[Line { name: "<b>", trimmed: &c, whole: &c }], &[], &[("x", "not & here")]);
        assert!(html.contains("&lt;b&gt;") && !html.contains("<b>") && html.contains("not &amp; here"));
        assert_eq!(html.matches("<svg").count(), 2);
        assert_eq!(html.matches("</svg>").count(), 2);
        assert!(!html.contains("NaN") && !html.contains("inf"), "{html}");
    }
}
