//! The table's page: a summary, and for each scene its plots, its figures, and pictures of equal time with
//! maps of their error.

use validation::converge::page::{frame, missing, row, show};
use validation::html::escape;

use super::summary::{Against, Scene, Standing, Table};
use crate::study::bench::Bench;
use crate::study::line::{curves, warnings};
use crate::study::pictures::pictures;

/// The page of all scenes measured so far.
pub fn page(table: &Table, sections: &[String]) -> String {
    let mut rows = String::new();
    for scene in &table.scenes {
        let mut cells = vec![format!("<a href=\"#{0}\">{0}</a>", escape(&scene.name)), escape(&scene.class)];
        for against in &scene.against {
            cells.extend(cells_of(against));
        }
        rows += &row(&cells);
    }
    let with = table.with().into_iter().map(|with| ("rendered with", with));
    let facts: String = table
        .machine
        .iter()
        .map(|(name, value)| (name.as_str(), value.as_str()))
        .chain(with)
        .map(|(name, value)| format!("{}: {}; ", escape(name), escape(value)))
        .collect();
    let body = format!(
        "<p>How many times less relative squared error {} makes in equal time than the best variant of Mitsuba and the best of \
         the other renderers, each against a converged mean, its own or that of a renderer with the same; {}; brackets and bands are \
         95 % intervals. ✓ the aim is reached by the whole interval, ✗ it is missed by the whole interval, ○ open.</p>{}\
         <div class=\"wide\"><table><tr><th>scene<th>class<th>best Mitsuba<th>trimmed<th>whole<th>aim<th>best other<th>trimmed\
         <th>whole<th>aim</tr>{rows}</table></div><p class=\"note\">{facts}</p>{}",
        escape(&table.ours),
        table.settings.words(),
        table.drawing(),
        sections.concat()
    );
    frame("Error against run time", &body)
}

fn cells_of(against: &Against) -> [String; 4] {
    let sign = match against.standing {
        Standing::Reached => "✓",
        Standing::Missed => "✗",
        Standing::Open => "○",
        Standing::NoAnswer => "–",
    };
    let [trimmed, whole] = against.ratios(|ratio| show(*ratio)).map(|cell| escape(&cell));
    [escape(against.name()), trimmed, whole, format!("{sign} {}", against.aim)]
}

/// The section of one scene; `ours` is the renderer that all are compared with.
pub fn section(scene: &Scene, bench: &Bench, ours: &str) -> Result<String, String> {
    let shown = scene.lines.first().map(|line| line.renderer.clone());
    let best = scene.against.iter().filter_map(|a| a.best_trimmed.as_ref().map(|b| b.0.clone()));
    let names: Vec<String> = shown.into_iter().chain(best).collect();
    Ok(format!(
        "<h2 id=\"{0}\">{0}</h2><p>{1}, {2} × {3} pixels</p>{4}{5}{6}{7}",
        escape(&scene.name),
        escape(&scene.class),
        scene.size[0],
        scene.size[1],
        curves(&scene.lines),
        warnings(&scene.lines, ours),
        pictures(&names, &scene.lines, bench)?,
        missing(&scene.missing)
    ))
}
