//! Measured indices of refraction by name.

use super::observer;
use super::table::Tabulated;
use crate::spelling::known;
use std::ops::RangeInclusive;

const CONDUCTORS: &str = include_str!("data/conductors.csv");
const DIELECTRICS: &str = include_str!("data/dielectrics.csv");
const DISPERSIVE: &str = include_str!("data/dispersive.csv");

fn rows(csv: &'static str) -> impl Iterator<Item = (&'static str, &'static str)> {
    csv.lines().filter(|l| !l.starts_with('#')).filter_map(|l| l.split_once(','))
}

fn names(csv: &'static str) -> Vec<&'static str> {
    let mut names: Vec<&str> = rows(csv).map(|(name, _)| name).collect();
    names.dedup();
    names
}

/// η and k of a conductor; the error lists the known names.
pub fn conductor(name: &str) -> Result<(Tabulated, Tabulated), String> {
    let (mut λ, mut eta, mut k) = (vec![], vec![], vec![]);
    for (_, row) in rows(CONDUCTORS).filter(|(n, _)| *n == name) {
        let mut numbers = row.split(',').filter_map(|w| w.parse::<f32>().ok());
        if let (Some(a), Some(b), Some(c)) = (numbers.next(), numbers.next(), numbers.next()) {
            λ.push(a);
            eta.push(b);
            k.push(c);
        }
    }
    if λ.is_empty() {
        let mut list = names(CONDUCTORS);
        list.push("none");
        return Err(known(name, &list));
    }
    Ok((Tabulated::new(λ.clone(), eta)?, Tabulated::new(λ, k)?))
}

/// η or k of a conductor in RGB mode: unlike a table that a scene gives for them, Mitsuba integrates those
/// that it knows by name without D65, and what lies outside the gamut becomes 0.
pub fn in_rgb(table: &Tabulated) -> [f32; 3] {
    observer::emission_to_rgb(table).map(|v| v.max(0.0) as f32)
}

/// The index of a dielectric that does not disperse; the error lists the known names.
pub fn dielectric(name: &str) -> Result<f64, String> {
    let lower = name.to_lowercase();
    let found = rows(DIELECTRICS).find(|(n, _)| *n == lower).and_then(|(_, value)| value.parse().ok());
    found.ok_or_else(|| known(&lower, &names(DIELECTRICS)))
}

/// How an index of refraction depends on wavelength, from 360 to 830 nm; formulas have poles beyond, and are
/// constant there.
#[derive(Clone, Debug, PartialEq)]
pub enum Dispersion {
    /// n² = 1 + Σ bᵢλ²/(λ² − cᵢ), λ in µm, cᵢ in µm².
    Sellmeier(Vec<(f64, f64)>),
    /// n = a + b/λ² + c/λ⁴, λ in µm.
    Cauchy([f64; 3]),
    /// Measured; constant beyond the ends of the table.
    Table(Tabulated),
}

impl Dispersion {
    /// A glass by name; the error lists the known names.
    pub fn named(name: &str) -> Result<Self, String> {
        let lower = name.to_lowercase();
        let row =
            rows(DISPERSIVE).find(|(n, _)| *n == lower).ok_or_else(|| known(&lower, &names(DISPERSIVE)))?;
        let numbers: Vec<f64> = row.1.split(',').filter_map(|w| w.parse().ok()).collect();
        Ok(Self::Sellmeier(numbers.chunks_exact(2).map(|c| (c[0], c[1])).collect()))
    }

    /// A wavelength in nm, of those from 360 to 830 and of a table, at which the index is not within `range`, and
    /// the index. Between whole wavelengths only a pole or a table's value can be far from what is found at them.
    pub fn outside(&self, range: &RangeInclusive<f64>) -> Option<(f64, f64)> {
        let visible = f64::from(observer::WAVELENGTH_MIN)..=f64::from(observer::WAVELENGTH_MAX);
        let between: Vec<(f64, f64)> = match self {
            Self::Sellmeier(terms) => {
                let poles = terms.iter().filter(|(b, _)| *b != 0.0).map(|(_, c)| 1e3 * c.sqrt());
                poles.map(|pole| (pole, f64::INFINITY)).collect()
            }
            Self::Cauchy(_) => vec![],
            Self::Table(table) => table.nodes().map(|(λ, eta)| (f64::from(λ), f64::from(eta))).collect(),
        };
        let whole = (observer::WAVELENGTH_MIN as u32..=observer::WAVELENGTH_MAX as u32).map(f64::from);
        let all = between.into_iter().chain(whole.map(|λ| (λ, self.eta(λ as f32))));
        // The bands of a film may ask for what a table has beyond the visible; formulas are constant there.
        let tabulated = matches!(self, Self::Table(_));
        all.filter(|(λ, _)| tabulated || visible.contains(λ)).find(|(_, eta)| !range.contains(eta))
    }

    /// The index at λ in nm; not finite or below zero where the formula has a pole.
    #[inline]
    pub fn eta(&self, λ_nm: f32) -> f64 {
        let λ = λ_nm.clamp(observer::WAVELENGTH_MIN, observer::WAVELENGTH_MAX) as f64 * 1e-3;
        let λ2 = λ * λ;
        match self {
            Self::Sellmeier(terms) => {
                (1.0 + terms.iter().map(|(b, c)| b * λ2 / (λ2 - c)).sum::<f64>()).sqrt()
            }
            Self::Cauchy([a, b, c]) => a + b / λ2 + c / (λ2 * λ2),
            Self::Table(table) => {
                let (min, max) = table.range();
                table.eval(λ_nm.clamp(min, max)) as f64
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glasses_have_their_published_index_and_abbe_number() {
        // n_d and V_d = (n_d − 1)/(n_F − n_C): Schott's catalogue, printed to 5 and 2 decimals; Malitson
        // 1965, 1972 and 1963 for silica, sapphire and fluorite; handbook values of less precision for
        // diamond and water.
        for (name, nd, nd_error, vd, vd_error) in [
            ("BK7", 1.51680, 6e-6, 64.17, 6e-3),
            ("N-FK51A", 1.48656, 6e-6, 84.47, 6e-3),
            ("F2", 1.62004, 6e-6, 36.37, 6e-3),
            ("SF10", 1.72825, 6e-6, 28.41, 6e-3),
            ("SF11", 1.78472, 6e-6, 25.76, 6e-3),
            ("N-SF11", 1.78472, 6e-6, 25.68, 6e-3),
            ("fused silica", 1.45846, 6e-6, 67.82, 6e-3),
            ("calcium fluoride", 1.43385, 2e-5, 95.0, 0.3),
            ("sapphire", 1.7682, 1e-4, 72.2, 0.2),
            ("diamond", 2.4175, 1e-3, 55.3, 0.3),
            ("water", 1.3334, 2e-4, 55.8, 0.3),
        ] {
            let glass = Dispersion::named(name).unwrap();
            let [f, d, c] = [486.1327, 587.5618, 656.2725].map(|λ| glass.eta(λ));
            assert!((d - nd).abs() < nd_error, "{name} {d}");
            let abbe = (d - 1.0) / (f - c);
            assert!((abbe - vd).abs() < vd_error, "{name} {abbe}");
        }
    }

    #[test]
    fn glasses_disperse_normally_over_the_whole_visible_range() {
        for name in names(DISPERSIVE) {
            let glass = Dispersion::named(name).unwrap();
            assert!((360..830).all(|λ| glass.eta(λ as f32) > glass.eta(λ as f32 + 1.0)), "{name}");
        }
    }

    #[test]
    fn conductors_have_the_colours_that_mitsuba_gives_them() {
        // The parameters of `conductor` in Mitsuba 3.9.1's scalar_rgb; the blue of TiO2's k shows that only
        // the negative channel was cut.
        for (name, eta, k) in [
            ("Au", [0.143_036, 0.375_307, 1.442_045], [3.982_997, 2.385_557, 1.603_359]),
            ("VN_palik", [2.865_602, 2.119_189, 1.940_091], [3.032_243, 2.056_116, 1.616_306]),
            ("TiO2", [3.456_61, 2.801_736, 2.905_175], [0.000_105_265, 0.0, 0.000_652_887]),
        ] {
            let (known_eta, known_k) = conductor(name).unwrap();
            let got = [in_rgb(&known_eta), in_rgb(&known_k)].concat();
            for (got, expected) in got.iter().zip(eta.iter().chain(&k)) {
                // λ and values are f32 here and f64 there.
                assert!((got - expected).abs() < 2e-6_f32.max(2e-6 * expected), "{name} {got} {expected}");
            }
        }
    }

    #[test]
    fn all_tables_are_well_formed() {
        let names = names(CONDUCTORS);
        assert_eq!(names.len(), 71);
        for name in names {
            let (eta, k) = conductor(name).unwrap();
            assert!(eta.range() == k.range() && eta.bounds().0 >= 0.0 && k.bounds().0 >= 0.0, "{name}");
        }
    }

    #[test]
    fn names_are_found_and_unknown_ones_listed() {
        assert_eq!(dielectric("BK7"), Ok(1.5046));
        assert!(dielectric("glas").unwrap_err().contains("bk7"));
        let (eta, k) = conductor("Au").unwrap();
        assert!((eta.eval(550.0) - 0.4).abs() < 0.2 && (k.eval(550.0) - 2.5).abs() < 0.5);
        assert!(conductor("Gold").unwrap_err().contains("Au"));
    }

    #[test]
    fn cauchy_is_its_formula() {
        assert_eq!(Dispersion::Cauchy([1.5, 0.01, 0.001]).eta(500.0), 1.5 + 0.01 / 0.25 + 0.001 / 0.0625);
    }

    #[test]
    fn tables_are_looked_at_as_far_as_they_are_asked() {
        let table = |nodes: &[(f32, f32)]| {
            let (nm, eta) = nodes.iter().copied().unzip();
            Dispersion::Table(Tabulated::new(nm, eta).unwrap())
        };
        let range = 0.1..=10.0;
        assert_eq!(table(&[(360.0, 1.5), (830.0, 1.5), (840.0, -1.5)]).outside(&range), Some((840.0, -1.5)));
        assert_eq!(table(&[(250.0, 1.5), (840.0, 1.4)]).outside(&range), None);
        // A pole of a formula beyond the visible is not asked for.
        assert_eq!(Dispersion::Sellmeier(vec![(1.0, 0.01)]).outside(&range), None);
    }
}
