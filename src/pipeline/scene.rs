//! Sections `[scene]` and `[scene.poses]`: the inputs of a run.

use std::path::PathBuf;

use glam::DVec3;

use crate::codec::poses::{self, PoseFormat, Target};
use crate::config::{Choice, Effect, Key, Keys, Leads, Problem, Section, Settings, Value};

/// Section `[scene]`: the inputs. All paths are resolved.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The triangle mesh.
    pub mesh: PathBuf,
    /// The folder of the images that the poses name.
    pub images: PathBuf,
    /// The folder of masks, `NAME.png` for an image `NAME`, 0 where a pixel is to be ignored.
    pub masks: Option<PathBuf>,
    /// The way up in the mesh's coordinates; any length but 0.
    pub up: [f64; 3],
    /// The cameras.
    pub poses: Poses,
}

/// Section `[scene.poses]`: the cameras.
#[derive(Debug, Clone, PartialEq)]
pub struct Poses {
    /// The format.
    pub format: &'static PoseFormat,
    /// The file or folder.
    pub path: PathBuf,
}

impl Choice for &'static PoseFormat {
    const NAMES: &'static [(&'static str, Self)] = &poses::NAMES;
}

impl Section for Scene {
    const NAME: &'static str = "scene";
    const ABOUT: &'static str = "The inputs: a mesh, photographs, and where the cameras stood.";
    const KEYS: &'static [Key] = &[
        Key {
            name: "mesh",
            doc: "The triangle mesh, PLY, OBJ, GLB, STL or OFF, in the coordinates of the poses. Large coordinates (UTM) are fine.",
            value: Value::Needed("\"mesh.ply\""),
        },
        Key {
            name: "images",
            doc: "The folder of the photographs, named as in the poses: JPEG, PNG, TIFF, EXR or HDR. They must have the \
                  camera's size, or be smaller by [decode] downscale. EXIF rotation is not applied, as COLMAP does not apply \
                  it.",
            value: Value::Needed("\"images\""),
        },
        Key {
            name: "masks",
            doc: "The folder of masks, if you have them: NAME.png for the image NAME, 0 where a pixel is to be ignored (sky, \
                  cars, people).",
            value: Value::Optional("\"masks\""),
        },
        Key {
            name: "up",
            doc: "The way up in the mesh's coordinates. COLMAP's own coordinates are often rotated: give yours.",
            value: Value::Default("[0.0, 0.0, 1.0]"),
        },
        Key { name: "poses", doc: "The poses of the cameras.", value: Value::Section },
    ];

    fn read(keys: &Keys<'_>) -> Self {
        let mesh = Leads::to_file("put the mesh there, a PLY or OBJ file, or name it: --set scene.mesh=PATH");
        let images = Leads::to_folder("put the photographs there, or name their folder: --set scene.images=PATH");
        let masks = Leads::to_folder("name the folder of masks, or take the key out if there are none");
        let up: [f64; 3] = keys.value("up");
        let length = DVec3::from(up).length_squared();
        let rule = "must be a finite vector that is not zero, as [0, 0, 1]";
        keys.check("up", length.is_finite() && length > 0.0, rule);
        Scene {
            mesh: keys.path("mesh", mesh),
            images: keys.path("images", images),
            masks: keys.optional_path("masks", masks),
            up,
            poses: Poses::read(&keys.section("poses", Poses::OUTLINE)),
        }
    }

    fn settings(&self) -> Settings {
        let Scene { mesh, images, masks, up, poses } = self;
        Settings::of(Self::NAME)
            .with("mesh", mesh, Effect::Input)
            .with("images", images, Effect::Input)
            .optional("masks", masks.as_ref(), Effect::Input)
            // The sky is the half that is up.
            .with("up", up, Effect::Light)
            .with("up", up, Effect::Axes)
            .and(poses.settings())
    }
}

impl Section for Poses {
    const NAME: &'static str = "scene.poses";
    const ABOUT: &'static str = "Where the cameras stood.";
    const KEYS: &'static [Key] = &[
        Key {
            name: "format",
            doc: "The format: \"colmap\", a COLMAP sparse model, binary or text, or another of those in docs/formats.md.",
            value: Value::Default("\"colmap\""),
        },
        Key {
            name: "path",
            doc: "The file or folder of the format: for \"colmap\" the folder that holds cameras.bin and images.bin, or both \
                  as .txt.",
            value: Value::Needed("\"sparse/0\""),
        },
    ];

    fn read(keys: &Keys<'_>) -> Self {
        let format: &'static PoseFormat = keys.choice("format");
        let missing = format!("{}: --set scene.poses.path=PATH", format.advice);
        let leads = match format.target {
            Target::Either => Leads::to_file_or_folder(missing),
            Target::Folder => Leads::to_folder(missing),
        };
        let path = keys.path("path", leads);
        // What a run makes may be half made.
        if !keys.is_made("path", &path)
            && keys.is_good("path")
            && let Some(missing) = (format.missing)(&path)
        {
            let problem = Problem::new(missing.rule).got(path.display().to_string());
            let instead = missing.instead.map(|instead| format!("did you mean {}?", instead.display()));
            keys.check("path", false, Problem { hint: instead, ..problem });
        }
        Poses { format, path }
    }

    fn settings(&self) -> Settings {
        let Poses { format, path } = self;
        Settings::of(Self::NAME).with("format", format.name, Effect::Input).with("path", path, Effect::Input)
    }
}
