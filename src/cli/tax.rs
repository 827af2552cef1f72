//! The cost of features for scenes that do not use them.

use etalon::scene::{Features, Scene};

/// Table by `benches/tax.py`: for each feature, and each of some scenes that do not use it, by how many per
/// cent a program with the feature takes more instructions than one without.
const TABLE: &str = include_str!("tax.csv");

/// The largest tax of a feature in per cent; `None` if it was not measured.
fn percent(feature: &str) -> Option<f64> {
    let row = TABLE.lines().find_map(|line| line.strip_prefix(feature)?.strip_prefix(','))?;
    row.split(',').filter_map(|value| value.parse().ok()).reduce(f64::max)
}

/// The features that a scene does not use and their cost in per cent; `None` where that was not measured.
pub fn of(scene: &Scene, left_out: Features) -> Vec<(&'static str, Option<f64>)> {
    let mut features = left_out.names();
    let others = [
        ("thin lens", scene.sensor.camera.name() != "thinlens"),
        ("specfilm", scene.sensor.film.bands.is_empty()),
    ];
    features.extend(others.iter().filter(|(_, unused)| *unused).map(|(name, _)| *name));
    features.into_iter().map(|feature| (feature, percent(feature))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;
    use std::fs::read_to_string;
    use std::path::Path;

    /// The removals of `benches/tax`.
    fn removals() -> Vec<Value> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/tax");
        let paths = folder.read_dir().unwrap().map(|entry| entry.unwrap().path());
        paths.map(|path| serde_json::from_str(&read_to_string(path).unwrap()).unwrap()).collect()
    }

    #[test]
    fn removals_still_apply() {
        for removal in removals() {
            let mut texts = std::collections::BTreeMap::new();
            for edit in removal["edits"].as_array().unwrap() {
                let [file, find, replace] =
                    ["file", "find", "replace"].map(|key| edit[key].as_str().unwrap());
                let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
                let text: &mut String = texts.entry(file).or_insert_with(|| read_to_string(path).unwrap());
                let expected = edit["count"].as_u64().unwrap_or(1) as usize;
                assert_eq!(text.matches(find).count(), expected, "{}: {find} in {file}", removal["feature"]);
                *text = text.replace(find, replace);
            }
        }
    }

    #[test]
    fn figures_are_those_of_removals() {
        let removals = removals();
        let known: Vec<&str> = removals.iter().map(|removal| removal["feature"].as_str().unwrap()).collect();
        for feature in Features(Features::ALL).names().into_iter().chain(["thin lens", "specfilm"]) {
            assert!(known.contains(&feature), "{feature}");
        }
        let mut lines = TABLE.lines();
        let scenes = lines.next().unwrap().split(',').count() - 1;
        for line in lines {
            let (feature, figures) = line.split_once(',').unwrap();
            let figures: Vec<f64> = figures.split(',').map(|figure| figure.parse().unwrap()).collect();
            assert!(known.contains(&feature) && figures.len() == scenes, "{line}");
            assert!(figures.iter().all(|figure| figure.abs() < 100.0), "{line}");
            assert_eq!(percent(feature), figures.into_iter().reduce(f64::max), "{line}");
        }
        assert!(percent("caustics").is_some());
        assert_eq!(percent("feature"), None);
        assert_eq!(percent("no such feature"), None);
    }
}
