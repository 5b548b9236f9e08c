//! The 7-vector that gonio recovers for every triangle.

/// A surface's reflectance, `[kd.r kd.g kd.b ks.r ks.g ks.b r]`, each component in [0, 1]. In memory it is the
/// 7-vector.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Material {
    /// Diffuse albedo, linear RGB.
    pub kd: [f32; 3],
    /// Scale of the dielectric's Fresnel reflection, linear RGB.
    pub ks: [f32; 3],
    /// Perceptual roughness; the Trowbridge-Reitz width is its square.
    pub r: f32,
}

impl Material {
    /// Components of the vector.
    pub const LEN: usize = 7;

    /// The vector's components by name, in order.
    pub const NAMES: [&str; Self::LEN] = ["kd_r", "kd_g", "kd_b", "ks_r", "ks_g", "ks_b", "roughness"];

    /// The material as a 7-vector.
    pub fn to_array(self) -> [f32; Self::LEN] {
        let Material { kd, ks, r } = self;
        [kd[0], kd[1], kd[2], ks[0], ks[1], ks[2], r]
    }

    /// The Trowbridge-Reitz width, `max(r^2, 1e-3)`.
    pub fn alpha(&self) -> f32 {
        (self.r * self.r).max(1e-3)
    }
}

impl From<[f32; Material::LEN]> for Material {
    fn from(v: [f32; Material::LEN]) -> Self {
        Material { kd: [v[0], v[1], v[2]], ks: [v[3], v[4], v[5]], r: v[6] }
    }
}
