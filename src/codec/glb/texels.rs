//! One texel a triangle, row by row from the top left, in images whose sides are powers of two.

use std::io;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use crate::base::ids::TriangleId;
use crate::codec::image::to_srgb8;
use crate::scene::Material;

/// The longest side that common GPUs take.
const LONGEST: u64 = 16_384;

/// What a triangle without a material looks like: grey and matte.
const NOTHING: Material = Material { kd: [0.216; 3], ks: [0.0; 3], r: 1.0 };

/// The layout of the images.
#[derive(Debug, Clone, Copy)]
pub struct Texels {
    width: u32,
    height: u32,
}

impl Texels {
    /// A layout for this many triangles; `None` if there is none.
    pub fn new(triangles: usize) -> Option<Self> {
        let triangles = triangles as u64;
        let sides = (0u32..).map(|k| 1u64 << k).take_while(|&side| side <= LONGEST);
        let mut fitting = sides.flat_map(|w| [(w, (w / 2).max(1)), (w, w)]).filter(|(w, h)| w * h >= triangles);
        fitting.next().map(|(w, h)| Texels { width: w as u32, height: h as u32 })
    }

    /// Texture coordinates of a triangle's texel's centre; exact, since the sides are powers of two.
    pub fn centre(self, t: TriangleId) -> [f32; 2] {
        let along = |at: u32, side: u32| (f64::from(at) + 0.5) / f64::from(side);
        [along(t % self.width, self.width) as f32, along(t / self.width, self.height) as f32]
    }

    /// The PNG of the diffuse colours: RGB, sRGB.
    pub fn base_color(self, rows: &[[f32; Material::LEN]]) -> io::Result<Vec<u8>> {
        self.png(rows, ExtendedColorType::Rgb8, |m| m.kd.map(to_srgb8))
    }

    /// The PNG of the roughnesses: G roughness, B metallic, which is 0.
    pub fn roughness(self, rows: &[[f32; Material::LEN]]) -> io::Result<Vec<u8>> {
        self.png(rows, ExtendedColorType::Rgb8, |m| [0, linear8(m.r), 0])
    }

    /// The PNG of the specular scales: A the largest, RGB its share in sRGB.
    pub fn specular(self, rows: &[[f32; Material::LEN]]) -> io::Result<Vec<u8>> {
        self.png(rows, ExtendedColorType::Rgba8, |m| {
            let most = m.ks.into_iter().fold(0.0, f32::max);
            let [r, g, b] = m.ks.map(|v| if most > 0.0 { to_srgb8(v / most) } else { 255 });
            [r, g, b, linear8(most)]
        })
    }

    fn png<const N: usize>(
        self,
        rows: &[[f32; Material::LEN]],
        color: ExtendedColorType,
        texel: impl Fn(Material) -> [u8; N],
    ) -> io::Result<Vec<u8>> {
        let mut pixels = vec![[0; N]; self.width as usize * self.height as usize];
        for (pixel, row) in pixels.iter_mut().zip(rows) {
            let known = row.iter().all(|v| v.is_finite());
            *pixel = texel(if known { Material::from(*row) } else { NOTHING });
        }
        let mut png = Vec::new();
        let encoded = PngEncoder::new(&mut png).write_image(pixels.as_flattened(), self.width, self.height, color);
        encoded.map(|()| png).map_err(io::Error::other)
    }
}

/// A value in [0, 1] as a byte.
fn linear8(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}
