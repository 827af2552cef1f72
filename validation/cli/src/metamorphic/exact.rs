//! Changes of a scene that must not change a bit of the image, except for an exact factor.

use super::still_life::*;
use super::{Relation, Term};
use crate::stage::*;
use etalon::film::Window;
use etalon::spectrum::ColorMode;

pub fn relations() -> Vec<Relation> {
    let plain = || Term::new(with(""));
    let spectral = |term: Term| Term { mode: ColorMode::Spectral, ..term };
    let mut all = vec![];
    for power in [-40, -1, 7, 40] {
        let factor = libm::exp2(f64::from(power));
        let brighter = Term::new(with_light(&lamp(8.0 * factor)));
        all.push(Relation::bits(format!("emission_2^{power}"), plain().times(factor), brighter));
        all.push(Relation::bits(
            format!("length_2^{power}"),
            plain(),
            Term::new(placed(objects, factor, [0.0; 3])),
        ));
    }
    let brighter = spectral(Term::new(with_light(&lamp(16.0))));
    all.push(Relation::bits("emission_2_spectral", spectral(plain()).times(2.0), brighter));
    let window = Window { x: 5, y: 7, width: 11, height: 9 };
    let (cut, cropped) = (Some(window), Some(window));
    all.push(Relation::bits("crop", Term { cut, ..plain() }, Term { window: cropped, ..plain() }));
    let shards = &[0.3, 0.5, 0.8];
    all.push(Relation::bits("sample_ranges", plain(), Term { shards, ..plain() }).samples(128));
    let sobol = |term: Term| Term { scene: term.scene.replace(INDEPENDENT, ""), ..term };
    all.push(
        Relation::bits("sample_ranges_sobol", sobol(plain()), sobol(Term { shards, ..plain() })).samples(128),
    );
    let mut objects = objects(&[]);
    objects.reverse();
    let swapped = scene(&[&path(4), &lamp(8.0), &objects.concat(), &camera()]);
    all.push(Relation::bits("order_of_shapes", plain(), Term::new(swapped)));
    let named = with("").replace("<scene version=\"3.0.0\">", "<scene version=\"3.0.0\"><!-- a remark -->");
    all.push(Relation::bits("remarks", plain(), Term::new(named)));
    all
}
