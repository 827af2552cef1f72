//! HTML pages about error and time: their frame and their tables. They are self-contained and load nothing
//! from a network.

use super::plot::{legend, plot};
use super::{Curve, Measured, Ratio};
use crate::html::escape;

/// A renderer's curves, and the ratios of the first renderer's efficiency to its own.
pub struct Line<'a> {
    pub name: &'a str,
    /// Curve of the trimmed error.
    pub trimmed: Option<&'a Curve>,
    /// Curve of the mean over all values.
    pub whole: Option<&'a Curve>,
    pub ratio_trimmed: Option<&'a Ratio>,
    pub ratio_whole: Option<&'a Ratio>,
    /// The renderer whose converged mean is the reference.
    pub mean_of: &'a str,
    /// Mean of the pictures over that of the reference.
    pub brightness: Option<Measured>,
    /// The converged mean over that of the first renderer.
    pub mean_over_first: Option<Measured>,
    /// Mean start-up in seconds.
    pub startup: Option<f64>,
}

const STYLE: &str = "body{font:16px/1.45 system-ui,sans-serif;max-width:76rem;margin:auto;padding:1rem}\
svg,img{max-width:100%}.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.9rem}td,th{padding:.25rem .6rem;\
text-align:left;border-bottom:1px solid #8886;white-space:nowrap}td.wrap{white-space:normal;min-width:14rem}\
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,26rem),1fr));gap:1rem}.plots svg{width:100%}\
.legend{display:flex;flex-wrap:wrap;gap:.2rem 1.2rem;list-style:none;padding:0;font-size:.85rem}\
.pictures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(48%,15rem),1fr));gap:.6rem}figure{margin:0}\
.pictures img{width:100%;image-rendering:pixelated;display:block;margin-bottom:.3rem}figcaption{font-size:.8rem;overflow-wrap:anywhere}\
h2{margin-top:2.5rem}.note{opacity:.75;font-size:.9rem}\
@media(prefers-color-scheme:dark){body{background:#16181c;color:#e4e4e4}a{color:#8bf}}";

/// A whole page.
pub fn frame(title: &str, body: &str) -> String {
    format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <meta name=\"color-scheme\" content=\"light dark\"><title>{0}</title><style>{STYLE}</style></head><body>\
         <h1>{0}</h1>{body}</body></html>\n",
        escape(title)
    )
}

/// Plots and tables of one scene; ratios are those of the first line over the others.
pub fn curves(lines: &[Line]) -> String {
    let drawing = |title: &str, of: for<'a> fn(&Line<'a>) -> Option<&'a Curve>| {
        let drawn: Vec<(&str, &Curve)> = lines.iter().filter_map(|l| Some((l.name, of(l)?))).collect();
        format!("<div><h3>relMSE, {title}</h3>{}</div>", plot(&drawn, title))
    };
    let names: Vec<&str> = lines.iter().map(|l| l.name).collect();
    let mut rows = String::new();
    for line in lines {
        let optional = |i: Option<Measured>| i.map_or("–".into(), show);
        let ratio = |r: Option<&Ratio>| {
            r.map_or("–".to_string(), |r| {
                format!("{}{}", show(r.ratio), if r.different { "" } else { " (not told apart)" })
            })
        };
        let slope = |c: Option<&Curve>| optional(c.and_then(|c| c.slope));
        let to =
            |c: Option<&Curve>, k: usize| optional(c.and_then(|c| c.seconds_to.get(k).copied().flatten()));
        let own = line.mean_of == line.name;
        let whose = if own { String::new() } else { format!(" of {}", escape(line.mean_of)) };
        let cells = [
            escape(line.name),
            ratio(line.ratio_trimmed),
            ratio(line.ratio_whole),
            slope(line.trimmed),
            to(line.trimmed, 0),
            to(line.trimmed, 1),
            optional(line.brightness) + &whose,
            optional(line.mean_over_first),
            line.startup.map_or("–".into(), figures),
        ];
        rows += &row(&cells);
    }
    let first = escape(lines.first().map_or("", |l| l.name));
    format!(
        "<div class=\"plots\">{}{}</div>{}<div class=\"wide\"><table><tr><th>renderer<th>{first} is better, trimmed<th>whole\
         <th>slope<th>s to 1 %<th>s to 0.1 %<th>brightness<th>mean over that of {first}<th>s start-up</tr>{rows}</table></div>",
        drawing("without the 0.1 % largest values", |l| l.trimmed),
        drawing("whole", |l| l.whole),
        legend(&names)
    )
}

/// A list of names with reasons, or nothing if it is empty.
pub fn missing(entries: &[(String, String)]) -> String {
    let rows: String = entries.iter().map(|(name, why)| row(&[escape(name), escape(why)])).collect();
    if rows.is_empty() {
        String::new()
    } else {
        format!(
            "<details><summary>Missing</summary><div class=\"wide\"><table>{}</table></div></details>",
            rows.replace("<td>", "<td class=\"wrap\">")
        )
    }
}

/// A table row of cells that are already HTML.
pub fn row(cells: &[String]) -> String {
    let cells: String = cells.iter().map(|cell| format!("<td>{cell}</td>")).collect();
    format!("<tr>{cells}</tr>")
}

/// A value with its interval.
pub fn show(i: Measured) -> String {
    format!("{} [{}, {}]", figures(i.value), figures(i.low), figures(i.high))
}

/// Three significant figures.
pub fn figures(value: f64) -> String {
    let digits = if value == 0.0 { 0.0 } else { libm::floor(libm::log10(value.abs())) };
    if !(-3.0..5.0).contains(&digits) {
        format!("{value:.2e}")
    } else {
        format!("{value:.*}", (2.0 - digits).max(0.0) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::converge::{Rung, curve};

    #[test]
    fn the_page_is_whole_and_escapes_names() {
        let rung = |samples: u32| {
            let n = f64::from(samples);
            Rung { samples, errors: vec![1.0 / n, 1.1 / n], seconds: vec![n, n], ..Rung::default() }
        };
        let c = curve(&[rung(1), rung(100)], 0).unwrap();
        let line = Line {
            name: "<b>",
            trimmed: Some(&c),
            whole: Some(&c),
            ratio_trimmed: None,
            ratio_whole: None,
            mean_of: "<i>",
            brightness: None,
            mean_over_first: None,
            startup: None,
        };
        let html = frame("a & b", &(curves(&[line]) + &missing(&[("x".into(), "not & here".into())])));
        assert!(
            html.contains("&lt;b&gt;")
                && html.contains("&lt;i&gt;")
                && !html.contains("<b>")
                && html.contains("not &amp; here")
        );
        assert_eq!(html.matches("<svg").count(), html.matches("</svg>").count());
        assert!(!html.contains("NaN") && !html.contains("inf"), "{html}");
    }

    #[test]
    fn figures_are_three() {
        let shown = [1234.5, 12.345, 0.012345, 0.0, 1e-9].map(figures);
        assert_eq!(shown, ["1234", "12.3", "0.0123", "0.00", "1.00e-9"]);
    }
}
