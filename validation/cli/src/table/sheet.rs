//! The table's page: a summary, and for each scene its plots, its figures, and pictures of equal time with
//! maps of their error.

use etalon::image::{Rgb8, encode_srgb, write_png};
use validation::converge::page::{Line as PageLine, curves, figures, frame, missing, row};
use validation::converge::{Picture, Reference, relative_squares};
use validation::html::escape;

use super::measure::Bench;
use super::summary::{Against, Scene, Table};
use crate::renderers::{mean_of, read};
use crate::report::pictures::data_uri;

/// Relative squared errors from here on are drawn brightest; a map spans [`DECADES`] below it.
const BRIGHTEST: f64 = 1.0;
const DECADES: f64 = 5.0;

/// The page of all scenes measured so far.
pub fn page(table: &Table, sections: &[String]) -> String {
    let clock = if table.settings.processor_time { "processor seconds" } else { "seconds" };
    let mut rows = String::new();
    for scene in &table.scenes {
        let mut cells = vec![format!("<a href=\"#{0}\">{0}</a>", escape(&scene.name)), escape(&scene.class)];
        for against in &scene.against {
            cells.extend(cells_of(against));
        }
        rows += &row(&cells);
    }
    let facts: String =
        table.machine.iter().map(|(name, value)| format!("{}: {}; ", escape(name), escape(value))).collect();
    let body = format!(
        "<p>How many times less relative squared error {} makes in equal time than the best variant of Mitsuba and the best of \
         the other renderers, each against a converged mean, its own or that of a renderer with the same; rungs of {:?} {clock}, {} seeds; brackets and bands are \
         95 % intervals. ✓ the aim is reached by the whole interval, ✗ it is missed by the whole interval, ○ open.</p>\
         <div class=\"wide\"><table><tr><th>scene<th>class<th>best Mitsuba<th>trimmed<th>whole<th>aim<th>best other<th>trimmed\
         <th>whole<th>aim</tr>{rows}</table></div><p class=\"note\">{facts}</p>{}",
        escape(&table.ours),
        table.settings.seconds,
        table.settings.seeds,
        sections.concat()
    );
    frame("Error against run time", &body)
}

fn cells_of(against: &Against) -> [String; 4] {
    let cell = |best: &Option<(String, validation::converge::Ratio)>| {
        best.as_ref().map_or("–".to_string(), |(_, r)| validation::converge::page::show(r.ratio))
    };
    let sign = match against.verdict.as_str() {
        "reached" => "✓",
        "missed" => "✗",
        "open" => "○",
        _ => "–",
    };
    let name = against.best_trimmed.as_ref().map_or("–".into(), |b| escape(&b.0));
    [name, cell(&against.best_trimmed), cell(&against.best_whole), format!("{sign} {}", against.aim)]
}

/// One scene.
pub fn section(scene: &Scene, bench: &Bench) -> Result<String, String> {
    let lines: Vec<PageLine> = scene
        .lines
        .iter()
        .map(|line| PageLine {
            name: &line.renderer,
            trimmed: line.trimmed.as_ref(),
            whole: line.whole.as_ref(),
            ratio_trimmed: line.ratio_trimmed.as_ref(),
            ratio_whole: line.ratio_whole.as_ref(),
            mean_of: &line.mean_of,
            brightness: line.brightness,
            startup: Some(line.startup),
        })
        .collect();
    let absent: Vec<(&str, &str)> =
        scene.missing.iter().map(|(name, why)| (name.as_str(), why.as_str())).collect();
    let shown = scene.lines.first().map(|line| line.renderer.clone());
    let best = scene.against.iter().filter_map(|a| a.best_trimmed.as_ref().map(|b| b.0.clone()));
    let mut pictures = String::new();
    for name in shown.into_iter().chain(best) {
        pictures += &figure(&name, scene, bench)?;
    }
    let pictures = if pictures.is_empty() {
        String::new()
    } else {
        format!(
            "<h3>After {} s</h3><p class=\"note\">Above the picture, below the relative squared error, from 10⁻⁵ (black) to 1 \
             (white).</p><div class=\"pictures\">{pictures}</div>",
            bench.settings.seconds.last().copied().unwrap_or(0.0)
        )
    };
    let plots = if lines.is_empty() { String::new() } else { curves(&lines) };
    Ok(format!(
        "<h2 id=\"{0}\">{0}</h2><p>{1}, {2} × {3} pixels</p>{plots}{pictures}{4}",
        escape(&scene.name),
        escape(&scene.class),
        scene.size[0],
        scene.size[1],
        missing(&absent)
    ))
}

fn figure(name: &str, scene: &Scene, bench: &Bench) -> Result<String, String> {
    let file = bench.folder.join("pictures").join(format!("{name}.exr"));
    let Some(reference) = bench.stored_reference(mean_of(bench.renderers, name))?.filter(|_| file.is_file())
    else {
        return Ok(String::new());
    };
    let (picture, width, height) = read(&file)?;
    if picture.len() != reference.mean.len() || picture.len() != 3 * width * height {
        return Err(format!("{name}: its pictures differ in size"));
    }
    let scratch = bench.folder.join("scratch.png");
    let uri = |pixels: Vec<[u8; 3]>| {
        let image = Rgb8 { width: width as u32, height: height as u32, pixels };
        write_png(&scratch, &image).map_err(|e| e.to_string())?;
        data_uri(&scratch)
    };
    let (seen, map) = (uri(develop(&picture, &reference))?, uri(error_map(&picture, &reference))?);
    let line = scene.lines.iter().find(|line| line.renderer == name);
    let last = line.and_then(|l| l.trimmed.as_ref()).and_then(|c| c.errors.last());
    let (name, error) = (escape(name), last.map_or("–".into(), |i| figures(i.value)));
    let samples = line.and_then(|l| l.samples.last()).copied().unwrap_or(0);
    Ok(format!(
        "<figure><img alt=\"{name}\" src=\"{seen}\"><img alt=\"error of {name}\" src=\"{map}\"><figcaption>{name}<br>\
         {samples} samples, relMSE {error} (trimmed)</figcaption></figure>"
    ))
}

/// In sRGB, white where the reference's values have their 98th percentile.
fn develop(picture: &Picture, reference: &Reference) -> Vec<[u8; 3]> {
    let mut values = reference.mean.clone();
    values.sort_by(f64::total_cmp);
    let white = values.get(values.len() * 98 / 100).copied().filter(|v| *v > 0.0).unwrap_or(1.0);
    let count = picture.len() / 3;
    (0..count).map(|i| [0, 1, 2].map(|c| encode_srgb((picture[c * count + i] / white) as f32))).collect()
}

/// The mean over the channels of the relative squared error, on a logarithmic scale from black over red and
/// yellow to white.
fn error_map(picture: &Picture, reference: &Reference) -> Vec<[u8; 3]> {
    let (squares, count) = (relative_squares(picture, reference), picture.len() / 3);
    let heat = |value: f64| {
        let share = 1.0 + libm::log10((value / BRIGHTEST).max(f64::MIN_POSITIVE)) / DECADES;
        [0.0, 1.0, 2.0].map(|first| (255.0 * (3.0 * share - first).clamp(0.0, 1.0)) as u8)
    };
    (0..count).map(|i| heat((0..3).map(|c| squares[c * count + i]).sum::<f64>() / 3.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use validation::converge::reference;

    #[test]
    fn a_map_is_black_without_error_and_white_with_much() {
        let flat = vec![1.0; 6];
        let reference = reference(&[flat.clone(), flat.clone()]).unwrap();
        let mut spoiled = flat;
        spoiled[0] = 9.0;
        assert_eq!(error_map(&spoiled, &reference), [[255; 3], [0; 3]]);
        assert_eq!(develop(&spoiled, &reference)[1], [255; 3]);
    }
}
