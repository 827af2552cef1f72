//! What decides which kernel renders a scene.

/// What a scene uses beyond what every scene does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Features(pub u32);

impl Features {
    /// Texture coordinates: something varies over a surface.
    pub const TEXTURES: u32 = 1;
    /// A material with a preferred direction.
    pub const ANISOTROPY: u32 = 2;
    /// Refraction that separates wavelengths.
    pub const DISPERSION: u32 = 4;
    /// Light from outside the scene.
    pub const ENVIRONMENT: u32 = 8;
    /// Light paths look for caustics, or emitters are sampled by specular surfaces.
    pub const CAUSTICS: u32 = 16;
    /// Pixels share what their paths find.
    pub const REUSE: u32 = 32;
    /// Instances of groups of shapes.
    pub const INSTANCES: u32 = 64;
    /// All of them.
    pub const ALL: u32 = 127;
    /// The kernel for textured scenes: features that often come together, cheap if unused.
    pub const TEXTURED: u32 = Self::TEXTURES | Self::ANISOTROPY | Self::ENVIRONMENT | Self::INSTANCES;

    /// Whether all of the other's are among these.
    pub fn cover(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// These but for the other's.
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// The names of the features, for people.
    pub fn names(self) -> Vec<&'static str> {
        let all = [
            (Self::TEXTURES, "textures"),
            (Self::ANISOTROPY, "anisotropy"),
            (Self::DISPERSION, "dispersion"),
            (Self::ENVIRONMENT, "environment"),
            (Self::CAUSTICS, "caustics"),
            (Self::REUSE, "path re-use"),
            (Self::INSTANCES, "instances"),
        ];
        all.into_iter().filter(|(bit, _)| self.0 & bit != 0).map(|(_, name)| name).collect()
    }
}
