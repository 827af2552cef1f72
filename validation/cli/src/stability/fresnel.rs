//! Fresnel's equations against values of 60 digits.

use super::Case;
use etalon::bsdf::fresnel::dielectric;
use validation::statistics::worst_of;

/// Table of η, cos, R, T, cos′ for η from 10⁻⁴ to 10⁴ and 1 ± 10⁻⁷, to 10⁻⁷ rad of grazing and of the
/// critical angle.
const TABLE: &str = include_str!("../../data/fresnel.csv");

pub fn cases() -> Vec<Case> {
    let worst = |column: usize, near_critical: bool| -> super::Worst {
        Box::new(move |_| {
            let rows: Vec<Vec<f64>> = rows().filter(|row| is_near_critical(row) == near_critical).collect();
            if rows.len() < 8 {
                return Err(format!("{} rows are too few", rows.len()));
            }
            Ok(rows.iter().map(|row| error(row, column)).fold(0.0, worst_of))
        })
    };
    let mut cases = vec![];
    for (column, what) in [(2, "reflectance"), (3, "transmittance"), (4, "cosine")] {
        cases.push(Case::at_most(
            what,
            format!("relative error of the {what}: 10⁻¹³ away from the critical angle"),
            1e-13,
            worst(column, false),
        ));
    }
    for (column, what) in [(2, "reflectance"), (3, "transmittance"), (4, "cosine")] {
        cases.push(Case::at_most(
            format!("{what}_near_critical"),
            format!("relative error of the {what} within 1 % of g² of the critical angle: a hundredth of what f32 resolves"),
            6e-10,
            worst(column, true),
        ));
    }
    cases
}

fn rows() -> impl Iterator<Item = Vec<f64>> {
    let rows =
        TABLE.lines().map(|line| line.split(',').filter_map(|word| word.parse().ok()).collect::<Vec<f64>>());
    rows.filter(|row| row.len() == 5)
}

/// Whether η² − sin² suffers from cancellation.
fn is_near_critical(row: &[f64]) -> bool {
    let (eta, cos_transmitted) = (row[0], row[4]);
    eta < 1.0 && cos_transmitted * cos_transmitted < 0.01
}

fn error(row: &[f64], column: usize) -> f64 {
    let found = dielectric(row[1], row[0]);
    let found = [found.reflectance, found.transmittance, found.cos_transmitted][column - 2];
    let expected = row[column];
    if expected == 0.0 { found.abs() } else { (found / expected - 1.0).abs() }
}
