//! Agreement of values and densities with Mitsuba 3.9.1: a test for every example of every material; the
//! golden file must cover the registry completely.

use etalon::bsdf::MATERIALS;
use libtest_mimic::{Arguments, Trial};
use validate::agreement::Golden;

/// A known difference: the example, bounds on the differences of values and densities, and the reason. The
/// bounds are the differences found, rounded up: they detect a change, but do not prove agreement. Only the
/// masking was traced to a formula in both programs; the other reasons are the likely ones.
type Known = (&'static str, [f64; 2], &'static str);

/// Mitsuba's density of visible normals uses Walter et al.'s rational approximation of Beckmann's masking
/// (below 0.35 %); here the density is the exact one, which integrates to 1, and only values use the
/// approximation.
const MASKING: &str = "Beckmann's masking is approximated in Mitsuba's density";
/// Both select lobes by mean reflectances: Mitsuba over the spectrum, Etalon over the wavelengths of the
/// path.
const LOBES: &str = "lobes are chosen with other probabilities";
/// Coefficients of upsampled colours are f32, and a polynomial in nanometres amplifies their rounding errors.
const UPSAMPLING: &str = "upsampled colours are f32 polynomials";
/// For a coat's facets 1 + (α² − 1) cos² θ suffers from cancellation near the mirror direction, in f32.
const COAT: &str = "the coat's density is rounded in Mitsuba";
/// Mitsuba's luminance of a base colour is computed from the path's wavelengths; `principled-tint` compares
/// tints in rgb, where it is not.
const LUMINANCE: &str = "a tint's luminance depends on the wavelengths";
/// Mitsuba tabulates the transmittance of rough interfaces in f32 with its own quadrature.
const TRANSMITTANCE: &str = "rough transmittance comes from another table";

const KNOWN: &[Known] = &[
    ("roughconductor[0]", [0.0, 3e-3], MASKING),
    ("roughconductor[3]", [1e-5, 3e-3], MASKING),
    ("roughdielectric[0]", [0.0, 3e-3], MASKING),
    ("roughdielectric[2]", [2e-5, 2e-3], UPSAMPLING),
    ("plastic[1]", [1e-5, 2e-2], LOBES),
    ("plastic[2]", [0.0, 5e-2], LOBES),
    ("roughplastic[0]", [0.0, 3e-3], MASKING),
    ("roughplastic[1]", [5e-4, 1e-2], TRANSMITTANCE),
    ("roughplastic[2]", [1e-4, 5e-2], LOBES),
    ("roughplastic[3]", [1e-3, 3e-3], TRANSMITTANCE),
    ("principled[2]", [2e-5, 2e-5], COAT),
    ("principled[3]", [2e-5, 0.0], UPSAMPLING),
    ("principled[4]", [0.5, 1e-5], LUMINANCE),
    ("principledthin[1]", [2e-5, 0.0], UPSAMPLING),
    ("principledthin[2]", [2e-5, 0.0], UPSAMPLING),
    // The density where Mitsuba rounds the half vector of two grazing directions.
    ("principledthin[3]", [0.2, 5e-5], LUMINANCE),
    ("twosided[2]", [1e-4, 5e-3], TRANSMITTANCE),
    ("mask[1]", [0.0, 3e-3], MASKING),
    ("blendbsdf[0]", [0.0, 2e-3], MASKING),
    ("blendbsdf[2]", [1e-4, 2e-3], TRANSMITTANCE),
    ("bumpmap[1]", [0.0, 3e-3], MASKING),
];

fn main() {
    let arguments = Arguments::from_args();
    let golden: &'static Golden = match Golden::load() {
        Ok(golden) => Box::leak(Box::new(golden)),
        Err(message) => {
            eprintln!("{message}");
            std::process::exit(1);
        }
    };
    let mut tests = vec![];
    for entry in MATERIALS {
        for (i, snippet) in entry.examples.iter().enumerate() {
            let name = format!("{}[{i}]", entry.name);
            let example = golden.examples.iter().find(|e| e.name == name && e.snippet == *snippet);
            let missing = example.is_some_and(|e| e.missing.is_some());
            let test = Trial::test(format!("{name}::agreement"), move || {
                let example =
                    example.ok_or("the golden file lacks this; run validation/peers/golden_bsdf.py")?;
                let known = KNOWN.iter().find(|(known, ..)| *known == example.name);
                let found = golden.check(example)?;
                match (found.message, known) {
                    (None, None) => Ok(()),
                    (None, Some(_)) => Err("listed as a known difference, but agrees".into()),
                    (Some(_), Some((_, bounds, _))) if (0..2).all(|k| found.worst[k] <= bounds[k]) => Ok(()),
                    (Some(message), _) => Err(message.into()),
                }
            });
            tests.push(test.with_ignored_flag(missing));
        }
    }
    libtest_mimic::run(&arguments, tests).exit();
}
