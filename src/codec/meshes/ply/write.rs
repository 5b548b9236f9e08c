//! Writes binary little-endian PLY: vertices `double x y z` in the coordinates of the file that the mesh came from; faces
//! `list uchar uint vertex_indices`, then one value a face for each column.

use std::io::{self, Write};

use crate::base::ids::TriangleId;
use crate::scene::Mesh;

/// A property of the faces.
pub struct FaceColumn<'a> {
    /// The name of the property: ASCII letters, digits and underscores.
    pub name: &'a str,
    /// The values of the property.
    pub values: Values<'a>,
}

/// The values of a property. Each is asked for once, in the order of the triangles.
pub enum Values<'a> {
    /// `float`.
    F32(Box<dyn Fn(TriangleId) -> f32 + 'a>),
    /// `uchar`.
    U8(Box<dyn Fn(TriangleId) -> u8 + 'a>),
    /// `uint`.
    U32(Box<dyn Fn(TriangleId) -> u32 + 'a>),
}

impl Values<'_> {
    fn type_name(&self) -> &'static str {
        match self {
            Values::F32(_) => "float",
            Values::U8(_) => "uchar",
            Values::U32(_) => "uint",
        }
    }
}

/// Writes a mesh with columns for its faces. No more than a face is held; `out` should be buffered.
///
/// # Errors
/// Those of `out`; `InvalidInput` for a column whose name is empty, used twice, or not of letters, digits and
/// underscores.
pub fn write_mesh(out: &mut impl Write, mesh: &Mesh, columns: &[FaceColumn<'_>]) -> io::Result<()> {
    write_with(out, &[], mesh, columns)
}

/// Writes a mesh with columns for its faces, and comments of a line each.
///
/// # Errors
/// Those of [`write_mesh`].
pub(crate) fn write_with(
    out: &mut impl Write,
    comments: &[String],
    mesh: &Mesh,
    columns: &[FaceColumn<'_>],
) -> io::Result<()> {
    for (at, column) in columns.iter().enumerate() {
        let plain = !column.name.is_empty() && column.name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
        let taken = column.name == "vertex_indices" || columns[..at].iter().any(|c| c.name == column.name);
        if !plain || taken {
            let message = format!("{:?} cannot name a property of a PLY face", column.name);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
    }
    write!(out, "ply\nformat binary_little_endian 1.0\n")?;
    comments.iter().try_for_each(|comment| writeln!(out, "comment {comment}"))?;
    writeln!(out, "element vertex {}", mesh.positions.len())?;
    write!(out, "property double x\nproperty double y\nproperty double z\n")?;
    write!(out, "element face {}\nproperty list uchar uint vertex_indices\n", mesh.len())?;
    for column in columns {
        writeln!(out, "property {} {}", column.values.type_name(), column.name)?;
    }
    writeln!(out, "end_header")?;
    for position in mesh.positions.iter() {
        for value in (position.as_dvec3() + mesh.origin).to_array() {
            out.write_all(&value.to_le_bytes())?;
        }
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        out.write_all(&[3])?;
        for corner in corners {
            out.write_all(&corner.to_le_bytes())?;
        }
        for column in columns {
            let t = TriangleId::at(triangle);
            match &column.values {
                Values::F32(value) => out.write_all(&value(t).to_le_bytes()),
                Values::U8(value) => out.write_all(&[value(t)]),
                Values::U32(value) => out.write_all(&value(t).to_le_bytes()),
            }?;
        }
    }
    Ok(())
}
