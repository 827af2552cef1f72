//! The mirrors of a scene: rectangles, disks, flat pieces of meshes, and balls seen from outside; and its
//! balls of glass.
//!
//! Glass is a mirror too, and from within a good one.

use super::element::Element;
use super::recognition::of_shape;
use super::{Connector, SpecularChain};
use crate::bsdf::AnyMaterial;
use crate::math::DVec3;
use crate::scene::Shape;
use crate::spectrum::ColorMode;

/// Most elements of a kind; the largest are taken.
const MOST_ELEMENTS: usize = 16;

/// Mirrors, or balls of glass, of which each emitter sample uses at most one.
#[derive(Debug)]
pub struct Elements(Vec<Element>);

impl Elements {
    /// The elements that reflect light, balls of glass with inner reflections among them, and the balls of glass that
    /// it goes straight through.
    pub fn of(shapes: &[Shape], materials: &[AnyMaterial], mode: ColorMode) -> [Self; 2] {
        let elements = shapes.iter().flat_map(|shape| of_shape(shape, materials, mode));
        let (glass_balls, mirrors): (Vec<_>, _) = elements.partition(Element::gathers);
        [mirrors, glass_balls].map(Self::largest)
    }

    fn largest(mut elements: Vec<Element>) -> Self {
        let size = |element: &Element| {
            element.around.radius * element.around.radius * element.strength[0].max(element.strength[1])
        };
        elements.retain(|element| size(element) > 0.0);
        elements.sort_by(|a, b| size(b).total_cmp(&size(a)));
        elements.truncate(MOST_ELEMENTS);
        Self(elements)
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn get(&self, index: usize) -> &Element {
        &self.0[index]
    }

    /// The weight of each for the light at x, and the number by which weights are divided to be
    /// probabilities.
    fn weights(&self, x: DVec3) -> ([f64; MOST_ELEMENTS], f64) {
        let mut weights = [0.0; MOST_ELEMENTS];
        self.0.iter().zip(&mut weights).for_each(|(element, weight)| *weight = element.weight(x));
        (weights, weights.iter().sum::<f64>().max(1.0))
    }

    /// Chooses one for the light at x by a number in [0, 1), or none, if all together contribute little: an
    /// element that contributes a hundredth of the light is chosen with a probability of a hundredth.
    pub fn choose(&self, x: DVec3, choice: f64) -> Option<Connector<'_>> {
        let (weights, all) = self.weights(x);
        let mut rest = choice * all;
        let chosen = weights[..self.0.len()].iter().position(|weight| {
            rest -= weight;
            rest < 0.0
        })?;
        Some(Connector { by: Some(self.get(chosen)), chance: weights[chosen] / all })
    }

    /// Index of the one whose links lead by such surfaces.
    pub fn of_chain(&self, chain: &SpecularChain) -> Option<usize> {
        self.0.iter().position(|element| match element.glass_ball() {
            Some(glass_ball) => chain.is_through(element.primitives[0], glass_ball.inner),
            None => chain.mirror.is_some_and(|primitive| {
                // A ball is no mirror from inside.
                chain.reflections == 1 && element.has(primitive) && !chain.is_through(primitive, 1)
            }),
        })
    }

    /// One of them, with the probability of choosing it for the light at x.
    pub fn connector(&self, x: DVec3, index: usize) -> Connector<'_> {
        let (weights, all) = self.weights(x);
        Connector { by: Some(self.get(index)), chance: weights[index] / all }
    }

    /// Whether a primitive is one of them.
    pub fn have(&self, primitive: u32) -> bool {
        self.0.iter().any(|element| element.has(primitive))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load_text;
    use crate::spectrum::ColorMode;

    #[test]
    fn mirrors_are_flat_or_balls_seen_from_outside() {
        let of = |shape: &str| {
            let text = format!(r#"<scene version="3.0.0"><sensor type="perspective"/>{shape}</scene>"#);
            let scene = load_text("mirrors.xml", &text, ColorMode::Rgb).expect("it loads");
            Elements::of(&scene.shapes, &scene.materials, ColorMode::Rgb)
        };
        let metal = r#"<bsdf type="conductor"><string name="material" value="none"/></bsdf>"#;
        let glass = r#"<bsdf type="dielectric"/>"#;
        let cube = of(&format!(r#"<shape type="cube">{glass}</shape>"#));
        assert_eq!(cube[0].0.iter().map(|mirror| mirror.primitives.len()).collect::<Vec<_>>(), [1; 6]);
        for (shape, count) in [
            (format!(r#"<shape type="sphere">{metal}</shape>"#), [1, 0]),
            // From outside and from inside, and through it.
            (format!(r#"<shape type="sphere">{glass}</shape>"#), [2, 1]),
            // Bends nothing.
            (r#"<shape type="sphere"><bsdf type="thindielectric"/></shape>"#.into(), [1, 0]),
            (format!(r#"<shape type="disk">{glass}</shape>"#), [1, 0]),
            (format!(r#"<shape type="cylinder">{metal}</shape>"#), [0, 0]),
            // Its mirror is inside.
            (
                format!(r#"<shape type="sphere"><boolean name="flip_normals" value="true"/>{metal}</shape>"#),
                [0, 0],
            ),
            (r#"<shape type="rectangle"><bsdf type="roughconductor"/></shape>"#.into(), [0, 0]),
            (r#"<shape type="rectangle"><bsdf type="plastic"/></shape>"#.into(), [0, 0]),
            (format!(r#"<shape type="rectangle"><bsdf type="mask">{metal}</bsdf></shape>"#), [0, 0]),
        ] {
            assert_eq!(of(&shape).map(|elements| elements.0.len()), count, "{shape}");
        }
    }

    #[test]
    fn chances_are_those_of_the_choice() {
        let text = r#"<scene version="3.0.0"><sensor type="perspective"/>
            <shape type="sphere"><point name="center" x="3"/><bsdf type="conductor"/></shape>
            <shape type="sphere"><point name="center" y="2"/><bsdf type="conductor"/></shape>
            <shape type="rectangle"><transform name="to_world"><translate z="-1.5"/></transform><bsdf type="dielectric"/></shape>
            <shape type="rectangle"><transform name="to_world"><translate z="1.5"/></transform><bsdf type="conductor"/></shape></scene>"#;
        let scene = load_text("mirrors.xml", text, ColorMode::Rgb).expect("it loads");
        let [mirrors, _] = Elements::of(&scene.shapes, &scene.materials, ColorMode::Rgb);
        for x in [DVec3::ZERO, DVec3::X * 9.0, DVec3::new(-1.0, 0.5, 0.2)] {
            const N: u32 = 20_000;
            let mut times = [0.0; 4];
            for i in 0..N {
                let u = (f64::from(i) + 0.5) / f64::from(N);
                if let Some(Connector { by: Some(mirror), chance }) = mirrors.choose(x, u) {
                    let index =
                        (0..4).position(|i| std::ptr::eq(mirrors.get(i), mirror)).expect("it is one of them");
                    times[index] += 1.0 / f64::from(N);
                    assert_eq!(mirrors.connector(x, index).chance, chance);
                }
            }
            for (index, times) in times.into_iter().enumerate() {
                let chance = mirrors.connector(x, index).chance;
                assert!((times - chance).abs() < 2.0 / f64::from(N), "{x}: {times} {chance}");
            }
            // Of metal that reflects at its front alone, nothing is seen from behind.
            assert!(times[..3].iter().sum::<f64>() <= 1.0);
        }
    }
}
