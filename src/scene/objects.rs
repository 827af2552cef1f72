//! Shapes, materials and emitters, from their elements.

use super::error::{SceneError, known};
use super::instances::{Instances, ShapeGroup};
use super::loader::Loader;
use super::params::{Params, Usage};
use super::registry::construct;
use super::xml::{Attribute, Element};
use super::{Interface, Shape, Side};
use crate::bsdf::{AnyMaterial, Material, Traits};
use crate::emitter::select::SceneEmitter;
use crate::emitter::{AnyEmitter, EMITTERS, area};
use crate::math::bounds::half_extent;
use crate::math::ray::NO_PRIMITIVE;
use crate::math::{DVec3, Transform};
use crate::sensor::Sensor;
use crate::shape::{Chart, Declared, Geometry, SHAPES};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Shapes, materials and emitters of a scene, as far as it has been read.
pub struct Objects<'a, 'd> {
    loader: &'a Loader<'d>,
    pub shapes: Vec<Shape>,
    pub instances: Instances,
    /// Numbers of the groups that were read, by their element.
    known_groups: BTreeMap<*const Element, u32>,
    /// Number of primitives of all shapes and instances.
    primitives: u64,
    pub materials: Vec<AnyMaterial>,
    /// Sides already built, by material element, so that shapes share them.
    known_sides: BTreeMap<*const Element, [Side; 2]>,
    pub emitters: Vec<SceneEmitter>,
    /// Sides of surfaces without a material: grey ones, and black ones for those that emit.
    default_sides: [Option<[Side; 2]>; 2],
}

/// What a surface is made of, the element of what it emits, and the media that it parts.
struct Attachments<'d> {
    sides: [Side; 2],
    emitter: Option<&'d Element>,
    interface: Option<Box<Interface>>,
    /// Where textures are looked up, if one of them is an attribute of the mesh.
    chart: Option<Arc<Chart>>,
}

impl<'a, 'd> Objects<'a, 'd> {
    pub fn new(loader: &'a Loader<'d>) -> Self {
        Self {
            loader,
            shapes: vec![],
            instances: Instances::default(),
            known_groups: BTreeMap::new(),
            primitives: 0,
            materials: vec![],
            known_sides: BTreeMap::new(),
            emitters: vec![],
            default_sides: [None; 2],
        }
    }

    /// What is known of both sides of each surface. A material that no surface has decides nothing.
    pub fn sides(&self) -> impl Iterator<Item = Traits> {
        self.surfaces().flat_map(|shape| shape.sides.map(|side| side.traits))
    }

    /// All shapes, those of groups too.
    pub fn surfaces(&self) -> impl Iterator<Item = &Shape> {
        self.shapes.iter().chain(self.instances.shapes())
    }

    /// Reads a `<shape>` with its material and its emitter, a group, or an instance. Returns what measures on it.
    pub fn shape(&mut self, element: &'d Element) -> Result<Option<Sensor>, SceneError> {
        let mut params = Params::new(element, self.loader, Usage::Unbounded)?;
        match declared(&mut params)? {
            Declared::Geometry(geometry) => self.surface(geometry, params),
            Declared::Group => self.group(element, params).map(|_| None),
            Declared::Instance(to_world) => self.instance(to_world, element, params).map(|()| None),
        }
    }

    fn surface(
        &mut self,
        mut geometry: Geometry,
        mut params: Params<'_, 'd>,
    ) -> Result<Option<Sensor>, SceneError> {
        let sensor = params.object("sensor", "what measures the light that the surface receives")?;
        let Attachments { sides, emitter, interface, chart } =
            self.attachments(&mut geometry, &mut params)?;
        let emitter = match emitter {
            None => None,
            Some(element) => {
                let read = || construct(EMITTERS, element, self.loader, Usage::Emission);
                let emitter = self.loader.on_mesh(chart.as_ref(), read)?;
                if !matches!(emitter, AnyEmitter::Area(_)) {
                    let message = format!("a shape cannot be a `{}` emitter", emitter.name());
                    return Err(SceneError::at(&element.span, message, "expected an `area` emitter"));
                }
                self.emitters.push(SceneEmitter { emitter, shape: Some(self.shapes.len() as u32) });
                Some(self.emitters.len() as u32 - 1)
            }
        };
        if let Geometry::Mesh(mesh) = &mut geometry
            && (emitter.is_some() || sensor.is_some())
        {
            mesh.prepare_sampling();
        }
        // The primitives of instances come after all of these, wherever they stand in the file.
        let first_primitive = self.shapes.last().map_or(0, |s| s.first_primitive + s.geometry.primitives());
        self.count(geometry.primitives(), params.element)?;
        let shape = Shape { geometry, first_primitive, sides, emitter, interface };
        let read = |element| Sensor::of_shape(element, self.loader, &shape);
        let sensor = sensor.map(read).transpose()?;
        self.shapes.push(shape);
        Ok(sensor)
    }

    /// What is attached to a surface.
    fn attachments(
        &mut self,
        geometry: &mut Geometry,
        params: &mut Params<'_, 'd>,
    ) -> Result<Attachments<'d>, SceneError> {
        let material = params
            .object("bsdf", "what the surface is made of; by default matte grey, or black if it shines")?;
        let emitter = params.object("emitter", "what the surface emits")?;
        let interior = params.medium("interior", "the medium behind the surface, for `volpath`")?;
        let exterior = params.medium("exterior", "the medium before the surface, for `volpath`")?;
        params.float("silhouette_sampling_weight", 1.0, "Mitsuba's, for derivatives; ignored")?;
        params.finish()?;
        check_extent(geometry.bounds(), geometry.primitives(), params.element)?;
        let chart = self.chart(geometry, [material, emitter])?;
        let sides = match (material, &chart) {
            (Some(element), None) => self.material(element)?,
            // Of this mesh alone.
            (Some(element), Some(_)) => {
                let material =
                    self.loader.on_mesh(chart.as_ref(), || AnyMaterial::parse(element, self.loader))?;
                self.add(material)
            }
            (None, _) => self.default_sides(emitter.is_some()),
        };
        let parts = interior.is_some() || exterior.is_some();
        let interface = parts.then(|| Box::new(Interface { interior, exterior }));
        Ok(Attachments { sides, emitter, interface, chart })
    }

    /// The chart of a mesh on which some object has textures that are attributes.
    fn chart(
        &self,
        geometry: &mut Geometry,
        objects: [Option<&'d Element>; 2],
    ) -> Result<Option<Arc<Chart>>, SceneError> {
        let Geometry::Mesh(mesh) = geometry else { return Ok(None) };
        for object in objects.into_iter().flatten() {
            if self.loader.needs_chart(object)? {
                return Ok(mesh.draw_chart());
            }
        }
        Ok(None)
    }

    /// Reads a group, once, and returns its number. As in Mitsuba, its shapes neither emit nor are groups or
    /// instances themselves.
    fn group(&mut self, element: &'d Element, params: Params<'_, 'd>) -> Result<u32, SceneError> {
        params.finish()?;
        if let Some(number) = self.known_groups.get(&(element as *const Element)) {
            return Ok(*number);
        }
        let mut shapes: Vec<Shape> = vec![];
        for child in &element.children {
            let member = self.loader.resolve(child)?;
            let mut params = Params::new(member, self.loader, Usage::Unbounded)?;
            let Declared::Geometry(mut geometry) = declared(&mut params)? else {
                let message = "groups and instances cannot be grouped again";
                return Err(SceneError::at(&child.span, message, "expected a shape with a surface"));
            };
            let Attachments { sides, emitter, interface, .. } =
                self.attachments(&mut geometry, &mut params)?;
            if let Some(emitter) = emitter {
                // A shape outside of the group may have it too, by a <ref> to it.
                let is_emitter = |site: &&Element| {
                    self.loader.resolve(site).is_ok_and(|nested| std::ptr::eq(nested, emitter))
                };
                let site = member.children.iter().find(is_emitter).unwrap_or(emitter);
                let message = "a shape in a group cannot shine";
                return Err(SceneError::at(&site.span, message, "put the shape outside of the group"));
            }
            let first_primitive = shapes.last().map_or(0, |s| s.first_primitive + s.geometry.primitives());
            check_count(u64::from(first_primitive) + u64::from(geometry.primitives()), member)?;
            shapes.push(Shape { geometry, first_primitive, sides, emitter: None, interface });
        }
        let number = self.instances.add_group(ShapeGroup::new(shapes));
        self.known_groups.insert(element, number);
        Ok(number)
    }

    fn instance(
        &mut self,
        to_world: Transform,
        element: &'d Element,
        params: Params<'_, 'd>,
    ) -> Result<(), SceneError> {
        params.finish()?;
        for child in &element.children {
            let nested = self.loader.resolve(child)?;
            if nested.tag == "shape" {
                let mut params = Params::new(nested, self.loader, Usage::Unbounded)?;
                let Declared::Group = declared(&mut params)? else {
                    let message = "an instance of a shape that is no group";
                    return Err(SceneError::at(&child.span, message, "expected a `shapegroup`"));
                };
                let group = self.group(nested, params)?;
                if self.instances.is_empty_group(group) {
                    continue;
                }
                let (bounds, primitives) = self.instances.place(group, to_world);
                check_extent(bounds, primitives, element)?;
                self.count(primitives, element)?;
            }
        }
        Ok(())
    }

    /// Counts further primitives.
    fn count(&mut self, primitives: u32, element: &Element) -> Result<(), SceneError> {
        self.primitives += u64::from(primitives);
        check_count(self.primitives, element)
    }

    /// Adds a material. A two-sided one at the top is resolved here, once and for all.
    fn add(&mut self, material: AnyMaterial) -> [Side; 2] {
        match material {
            AnyMaterial::TwoSided(both) => {
                let irreversible = both.traits().irreversible;
                let (front, back) = both.into_sides();
                let front = self.side(front, false);
                let sides =
                    [front, back.map_or(Side { turned: true, ..front }, |back| self.side(back, true))];
                sides.map(|side| Side { traits: Traits { irreversible, ..side.traits }, ..side })
            }
            other => [self.side(other, false); 2],
        }
    }

    fn side(&mut self, material: AnyMaterial, turned: bool) -> Side {
        let traits = material.traits();
        self.materials.push(material);
        Side { material: self.materials.len() as u32 - 1, turned, traits }
    }

    /// Reads a material, once, and returns the two sides of a surface with it.
    pub fn material(&mut self, element: &'d Element) -> Result<[Side; 2], SceneError> {
        if let Some(sides) = self.known_sides.get(&(element as *const Element)) {
            return Ok(*sides);
        }
        let material = AnyMaterial::parse(element, self.loader)?;
        let sides = self.add(material);
        self.known_sides.insert(element, sides);
        Ok(sides)
    }

    fn default_sides(&mut self, shines: bool) -> [Side; 2] {
        let known = self.default_sides[usize::from(shines)];
        let sides = known.unwrap_or_else(|| self.add(AnyMaterial::matte(if shines { 0.0 } else { 0.5 })));
        self.default_sides[usize::from(shines)] = Some(sides);
        sides
    }

    /// Reads an emitter that does not belong to a shape.
    pub fn emitter(&mut self, element: &'d Element) -> Result<(), SceneError> {
        let is_of_shapes = |kind: &Attribute| kind.value == area::NAME && element.attribute("id").is_some();
        if self.loader.needs_chart(element)? && element.attribute("type").is_some_and(is_of_shapes) {
            return Ok(());
        }
        let emitter = construct(EMITTERS, element, self.loader, Usage::Emission)?;
        if matches!(emitter, AnyEmitter::Area(_)) {
            // One with an `id` is used where shapes refer to it.
            let help = "put it inside a <shape>, or give it an `id` that a shape refers to";
            let named = element.attribute("id").map(drop);
            return named
                .ok_or_else(|| SceneError::at(&element.span, "an `area` emitter without a shape", help));
        }
        if emitter.is_environment() && self.emitters.iter().any(|e| e.emitter.is_environment()) {
            return Err(SceneError::at(&element.span, "a second environment", "expected only one"));
        }
        self.emitters.push(SceneEmitter { emitter, shape: None });
        Ok(())
    }
}

/// Reads a surface that is none of the scene; what it is made of does not matter.
pub fn geometry<'d>(element: &'d Element, loader: &Loader<'d>) -> Result<Geometry, SceneError> {
    let mut params = Params::new(element, loader, Usage::Unbounded)?;
    let Declared::Geometry(mut geometry) = declared(&mut params)? else {
        return Err(SceneError::at(&element.span, "no surface", "expected a shape with one"));
    };
    params.object("bsdf", "ignored")?;
    params.finish()?;
    check_extent(geometry.bounds(), geometry.primitives(), element)?;
    if let Geometry::Mesh(mesh) = &mut geometry {
        mesh.prepare_sampling();
    }
    Ok(geometry)
}

/// Reads the geometry of a `<shape>`, without material and emitter.
fn declared(params: &mut Params) -> Result<Declared, SceneError> {
    let kind = params.element.require("type")?;
    let entry = SHAPES.iter().find(|e| e.name == kind.value).ok_or_else(|| {
        let names: Vec<&str> = SHAPES.iter().map(|e| e.name).collect();
        SceneError::at(
            &kind.value_span,
            format!("unknown shape `{}`", kind.value),
            known(&kind.value, &names),
        )
    })?;
    (entry.parse)(params)
}

/// Refuses more primitives than can be numbered.
fn check_count(primitives: u64, element: &Element) -> Result<(), SceneError> {
    if primitives < u64::from(NO_PRIMITIVE) {
        return Ok(());
    }
    let message = format!("{primitives} primitives, those of every instance counted");
    Err(SceneError::at(&element.span, message, format!("expected fewer than {NO_PRIMITIVE}")))
}

/// Refuses shapes whose coordinates overflow, and such as are too small for them.
fn check_extent((lo, hi): (DVec3, DVec3), primitives: u32, element: &Element) -> Result<(), SceneError> {
    /// The largest coordinate whose square is still finite in f64 and which f32 vertices can hold.
    const LARGEST: f64 = 1e37;
    /// Of a size whose fourth power, a squared area, is still a normal `f64`.
    const SMALLEST: f64 = 1e-76;
    let largest = lo.abs().max(hi.abs()).max_element();
    if primitives > 0 && (largest.is_nan() || largest >= LARGEST) {
        return Err(SceneError::at(
            &element.span,
            "the shape's coordinates overflow",
            "expected a smaller shape",
        ));
    }
    if primitives > 0 && half_extent((lo, hi)) < SMALLEST {
        return Err(SceneError::at(
            &element.span,
            "the shape is as good as a point, or is one after rounding",
            "expected a larger shape",
        ));
    }
    Ok(())
}
