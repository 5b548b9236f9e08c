//! Images with one texel a triangle, row by row from the top left. Their sides are powers of two.

use std::io::{self, Write};

use png::{BitDepth, ColorType, Compression, EncodingError, Filter};

use crate::base::convert::{Cut, to_f32};
use crate::base::ids::TriangleId;
use crate::codec::images::to_srgb8;
use crate::scene::Material;

/// The longest side that common GPUs take.
const LONGEST: u32 = 16_384;

/// The look of a triangle without a material: grey and matte.
const NOTHING: Material = Material { kd: [0.216; 3], ks: [0.0; 3], r: 1.0 };

/// The bytes of a PNG's chunks of pixels.
const CHUNK: usize = 1 << 16;

/// The layout of the images.
#[derive(Debug, Clone, Copy)]
pub(super) struct Texels {
    width: u32,
    height: u32,
}

/// One of the images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Image {
    /// The diffuse colours: RGB, sRGB.
    BaseColor,
    /// The roughnesses: G roughness, B metallic, which is 0.
    Roughness,
    /// The specular scales: A the largest, RGB its share in sRGB.
    Specular,
}

impl Image {
    /// All images, in the order of the file's views.
    pub(super) const ALL: [Image; 3] = [Image::BaseColor, Image::Roughness, Image::Specular];

    fn color(self) -> ColorType {
        if self == Image::Specular { ColorType::Rgba } else { ColorType::Rgb }
    }

    /// The texel of a material. An image of three channels has no fourth byte.
    fn texel(self, m: Material) -> [u8; 4] {
        match self {
            Image::BaseColor => {
                let [r, g, b] = m.kd.map(to_srgb8);
                [r, g, b, 0]
            }
            Image::Roughness => [0, linear8(m.r), 0, 0],
            Image::Specular => {
                let most = m.ks.into_iter().fold(0.0, f32::max);
                let [r, g, b] = m.ks.map(|v| if most > 0.0 { to_srgb8(v / most) } else { 255 });
                [r, g, b, linear8(most)]
            }
        }
    }
}

impl Texels {
    /// The smallest layout for this many triangles; `None` if the longest sides are too short.
    pub(super) fn new(triangles: usize) -> Option<Self> {
        let sides = (0..).map(|k| 1u32 << k).take_while(|&side| side <= LONGEST);
        let layouts = sides.flat_map(|side| [(side / 2).max(1), side].map(|height| Texels { width: side, height }));
        let holds = |t: &Texels| u64::from(t.width) * u64::from(t.height) >= triangles as u64;
        layouts.into_iter().find(holds)
    }

    /// The texture coordinates of the centre of a triangle's texel; exact, since the sides are powers of two.
    pub(super) fn centre(self, t: TriangleId) -> [f32; 2] {
        let along = |at: u32, side: u32| to_f32((f64::from(at) + 0.5) / f64::from(side));
        [along(t.0 % self.width, self.width), along(t.0 / self.width, self.height)]
    }

    /// Writes an image as PNG. No more than a row is held.
    pub(super) fn write(self, image: Image, rows: &[[f32; Material::LEN]], out: impl Write) -> io::Result<()> {
        let color = image.color();
        let mut encoder = png::Encoder::new(out, self.width, self.height);
        encoder.set_color(color);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::Fast);
        encoder.set_filter(Filter::Adaptive);
        let mut writer = encoder.write_header().map_err(plain)?;
        let mut stream = writer.stream_writer_with_size(CHUNK).map_err(plain)?;
        let width = self.width as usize;
        let mut line = Vec::with_capacity(width * color.samples());
        for y in 0..self.height as usize {
            line.clear();
            for x in 0..width {
                let texel = rows.get(y * width + x).map_or([0; 4], |row| {
                    let known = row.iter().all(|v| v.is_finite());
                    image.texel(if known { Material::from(*row) } else { NOTHING })
                });
                line.extend_from_slice(&texel[..color.samples()]);
            }
            stream.write_all(&line)?;
        }
        stream.finish().map_err(plain)?;
        writer.finish().map_err(plain)
    }
}

/// The error of the output itself, if the encoder passes one on.
fn plain(why: EncodingError) -> io::Error {
    match why {
        EncodingError::IoError(why) => why,
        other => io::Error::other(other),
    }
}

/// A value in [0, 1] as a byte.
fn linear8(value: f32) -> u8 {
    u8::cut((value.clamp(0.0, 1.0) * 255.0).round())
}
