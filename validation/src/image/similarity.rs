//! Structural similarity of two images.

use super::pair::Pair;

/// Standard deviation of the Gaussian window, in pixels.
const DEVIATION: f64 = 1.5;
/// Half width of the window, in pixels.
const REACH: usize = 5;

/// Constants that stabilise the quotients of dark or flat windows: (0.01 L)² and (0.03 L)² for a range of L =
/// 1.
const FLOORS: [f64; 2] = [1e-4, 9e-4];

/// Sums over a window: of its weights, of a, b, a², b² and ab.
type Sums = [f64; 6];

/// The mean over pixels of the structural similarity (Wang, Bovik, Sheikh and Simoncelli 2004, "Image Quality
/// Assessment", eq. 13) under a Gaussian window; 1 for equal images.
///
/// The similarity is defined for values within a range, which radiance lacks. Values v are mapped to v/(|v| +
/// m), with the mean m of the reference a, so that the result does not depend on the unit. Pixels that are
/// not finite are left out.
pub(super) fn similarity(pair: &Pair) -> f64 {
    let finite = || pair.pixels().map(|(_, _, pixel)| pixel).filter(|pixel| pixel.difference().is_finite());
    let count = finite().count() as f64;
    let mean = finite().map(|pixel| pixel.a.abs()).sum::<f64>() / count;
    let within = |v: f64| if v == 0.0 { 0.0 } else { v / (v.abs() + mean) };
    let sums: Vec<Sums> = pair
        .pixels()
        .map(|(_, _, pixel)| {
            let [a, b] = [pixel.a, pixel.b].map(within);
            if pixel.difference().is_finite() { [1.0, a, b, a * a, b * b, a * b] } else { [0.0; 6] }
        })
        .collect();
    let windows = blurred(&blurred(&sums, pair.width, pair.height, [1, 0]), pair.width, pair.height, [0, 1]);
    let each = windows.iter().zip(&sums).filter(|(_, own)| own[0] > 0.0).map(|(window, _)| of_window(window));
    each.sum::<f64>() / count
}

fn of_window(&[weight, a, b, aa, bb, ab]: &Sums) -> f64 {
    let [a, b, aa, bb, ab] = [a, b, aa, bb, ab].map(|sum| sum / weight);
    let (of_a, of_b, together) = (aa - a * a, bb - b * b, ab - a * b);
    let [light, contrast] = FLOORS;
    (2.0 * a * b + light) * (2.0 * together + contrast)
        / ((a * a + b * b + light) * (of_a.max(0.0) + of_b.max(0.0) + contrast))
}

/// Sums over a Gaussian window along one axis; pixels outside the image have no weight.
fn blurred(sums: &[Sums], width: usize, height: usize, [dx, dy]: [usize; 2]) -> Vec<Sums> {
    let kernel: Vec<f64> = (0..=2 * REACH)
        .map(|i| (i as f64 - REACH as f64) / DEVIATION)
        .map(|x| libm::exp(-0.5 * x * x))
        .collect();
    let at = |x: usize, y: usize| {
        let mut total = [0.0; 6];
        for (i, weight) in kernel.iter().enumerate() {
            let (x, y) = ((x + i * dx).wrapping_sub(REACH * dx), (y + i * dy).wrapping_sub(REACH * dy));
            if x < width && y < height {
                total.iter_mut().zip(sums[y * width + x]).for_each(|(total, sum)| *total += weight * sum);
            }
        }
        total
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;
    use crate::image::synthetic::grey;

    fn alike(a: &Image, b: &Image) -> f64 {
        similarity(&Pair::all(a, b).0[0])
    }

    /// A checkerboard of a dark and a light value.
    fn board(low: f64, high: f64) -> Image {
        let values: Vec<f64> =
            (0..32 * 32).map(|i| if (i / 4 + i / 128) % 2 == 0 { low } else { high }).collect();
        grey(32, &values, 0.0)
    }

    #[test]
    fn equal_images_are_alike_in_any_unit_and_the_opposite_is_not() {
        let a = board(1.0, 3.0);
        assert!((alike(&a, &a) - 1.0).abs() < 1e-12);
        assert!(alike(&a, &board(3.0, 1.0)) < -0.5);
        let (near, tiny) =
            (alike(&a, &board(1.2, 2.8)), alike(&board(1e-20, 3e-20), &board(1.2e-20, 2.8e-20)));
        assert!(near > 0.8 && near < 0.99 && (near - tiny).abs() < 1e-9, "{near} {tiny}");
    }

    /// A firefly lowers the similarity of its neighbourhood; a pixel that is not finite is left out.
    #[test]
    fn what_is_wrong_in_one_place_counts_there() {
        let a = board(1.0, 3.0);
        let spoilt = |value: f64| {
            let mut b = a.clone();
            b.channels[0].mean[16 * 32 + 16] = value;
            alike(&a, &b)
        };
        assert!(spoilt(1e6) < 0.999 && spoilt(1e6) > 0.9);
        assert!((spoilt(f64::NAN) - 1.0).abs() < 1e-12);
    }

    /// Two flat images differ in luminance only: (2ab + C)/(a² + b² + C) of the mapped values.
    #[test]
    fn flat_images_follow_the_formula() {
        let [a, b] = [2.0, 6.0].map(|value| grey(8, &[value; 64], 0.0));
        let (x, y) = (2.0 / 4.0, 6.0 / 8.0);
        let expected = (2.0 * x * y + FLOORS[0]) / (x * x + y * y + FLOORS[0]);
        assert!((alike(&a, &b) - expected).abs() < 1e-12);
    }
}
