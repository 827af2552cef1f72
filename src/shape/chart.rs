//! Places on a mesh by triangle, for textures that are attributes of its vertices or triangles.

use super::mesh_data::{Answer, AttributeFile, MeshError};
use crate::math::DVec2;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// What textures on a mesh with attributes need of it.
///
/// Textures are asked by two coordinates. On such a mesh these are not the file's, which may not tell one
/// triangle from another, but those of a chart in which triangle number t lies in 2t ≤ x ≤ 2t + 1: x − 2t and
/// y are its barycentric coordinates u and v. So nothing that passes coordinates on needs to know of
/// triangles, and no scene without attributes pays for them. What asks for the file's coordinates has them
/// from here.
#[derive(Debug)]
pub struct Chart {
    triangles: Vec<[u32; 3]>,
    uvs: Option<Vec<[f32; 2]>>,
    /// The area of each triangle (world).
    areas: Vec<f64>,
    pub file: AttributeFile,
    /// What the file has answered.
    answers: Mutex<BTreeMap<String, Arc<Answer>>>,
}

/// A point of a mesh: p₀ + u(p₁ − p₀) + v(p₂ − p₀) of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnTriangle {
    pub triangle: u32,
    pub corners: [u32; 3],
    pub u: f64,
    pub v: f64,
}

impl Chart {
    pub fn new(
        triangles: Vec<[u32; 3]>,
        uvs: Option<Vec<[f32; 2]>>,
        areas: Vec<f64>,
        file: AttributeFile,
    ) -> Self {
        Self { triangles, uvs, areas, file, answers: Mutex::default() }
    }

    /// An attribute by name; however many textures ask for it, it is read once.
    ///
    /// # Errors
    /// See [`AttributeFile::read`].
    pub fn attribute(&self, name: &str) -> Result<Arc<Answer>, MeshError> {
        // The table is whole also where a thread has ended with it.
        let mut answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = answers.get(name) {
            return Ok(known.clone());
        }
        let answer = Arc::new(self.file.read(name)?);
        answers.insert(name.to_owned(), answer.clone());
        Ok(answer)
    }

    /// The mean over the surface of what a triangle has on the mean, given its number and those of its corners.
    pub fn mean(&self, of: impl Fn(usize, [u32; 3]) -> f64) -> f64 {
        let triangles = || self.triangles.iter().zip(&self.areas).enumerate();
        let sum: f64 = triangles().map(|(i, (corners, area))| area * of(i, *corners)).sum();
        let area: f64 = self.areas.iter().sum();
        if area > 0.0 { sum / area } else { 0.0 }
    }

    /// Bytes of its arrays.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.triangles) + self.uvs.as_deref().map_or(0, size_of_val) + size_of_val(&*self.areas)
    }

    /// Coordinates in the chart. Rounding never leads into another triangle: 2t + 1 is exact.
    #[inline]
    pub fn coordinates(triangle: u32, u: f64, v: f64) -> DVec2 {
        DVec2::new(2.0 * f64::from(triangle) + u, v)
    }

    /// The point at coordinates in the chart.
    pub fn place(&self, chart: DVec2) -> OnTriangle {
        let triangle = (0.5 * chart.x) as u32;
        let corners = self.triangles[triangle as usize];
        OnTriangle { triangle, corners, u: chart.x - 2.0 * f64::from(triangle), v: chart.y }
    }

    /// The texture coordinates of the file at coordinates in the chart.
    pub fn uv(&self, chart: DVec2) -> DVec2 {
        let OnTriangle { corners, u, v, .. } = self.place(chart);
        let Some(uvs) = &self.uvs else { return DVec2::new(u, v) };
        let [t0, t1, t2] = corners.map(|i| DVec2::from(uvs[i as usize].map(f64::from)));
        t0 + (t1 - t0) * u + (t2 - t0) * v
    }

    /// How many vertices the triangles use at most, and how many triangles there are.
    pub fn counts(&self) -> (usize, usize) {
        let vertices = self.triangles.iter().flatten().max().map_or(0, |last| *last as usize + 1);
        (vertices, self.triangles.len())
    }
}

impl OnTriangle {
    /// The weights of the corners.
    pub fn weights(&self) -> [f64; 3] {
        [(1.0 - self.u - self.v).max(0.0), self.u, self.v]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// And vertices that no triangle has are not asked for.
    #[test]
    fn means_are_by_area() {
        let triangles = vec![[0, 1, 2], [4, 2, 1]];
        let chart = Chart::new(triangles, None, vec![3.0, 1.0], AttributeFile { path: "a.ply".into() });
        assert_eq!(chart.mean(|triangle, _| [2.0, 6.0][triangle]), 3.0);
        let vertices = [1.0, 2.0, 3.0, f64::NAN, 10.0];
        let of_corners =
            |_, corners: [u32; 3]| corners.map(|i| vertices[i as usize]).iter().sum::<f64>() / 3.0;
        assert_eq!(chart.mean(of_corners), (3.0 * 2.0 + 5.0) / 4.0);
    }

    #[test]
    fn a_place_comes_back_from_its_coordinates() {
        let triangles: Vec<[u32; 3]> = (0..1000).map(|i| [i, i + 1, i + 2]).collect();
        let uvs = (0..1002).map(|i| [i as f32, 2.0 * i as f32]).collect();
        let chart = Chart::new(triangles, Some(uvs), vec![1.0; 1000], AttributeFile { path: "a.ply".into() });
        assert_eq!(chart.counts(), (1002, 1000));
        for triangle in [0, 1, 7, 999] {
            for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.25, 0.5), (1.0 - f64::EPSILON / 2.0, 0.0)] {
                let coordinates = Chart::coordinates(triangle, u, v);
                let place = chart.place(coordinates);
                assert_eq!((place.triangle, place.v), (triangle, v));
                assert!((place.u - u).abs() <= f64::EPSILON * 2000.0, "{place:?}");
                let x = f64::from(triangle) + place.u + 2.0 * v;
                assert!((chart.uv(coordinates) - DVec2::new(x, 2.0 * x)).length() < 1e-9);
            }
        }
        // As far as triangles can be numbered.
        let last = Chart::coordinates(u32::MAX, 1.0, 0.0);
        assert_eq!((0.5 * last.x) as u32, u32::MAX);
    }
}
