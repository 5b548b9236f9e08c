//! Sections `[scene]` and `[scene.poses]`: the inputs of a run.

use std::path::PathBuf;

use glam::{DVec3, Vec3};

use super::crs::Written;
use crate::base::paths::Paths;
use crate::codec::poses::{self, PoseFormat, Target};
use crate::config::raw::Node;
use crate::config::{Choice, Effect, FromToml, Key, Keys, Leads, Problem, Section, Settings, Value};
use crate::scene::georeference::{Crs, Georeference};
use crate::scene::up::Upright;

/// Section `[scene]`: the inputs. All paths are resolved.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The triangle mesh, in one file or several.
    pub mesh: Paths,
    /// The folder of the images that the poses name.
    pub images: PathBuf,
    /// The folder of masks; 0 where a pixel is to be ignored.
    pub masks: Option<PathBuf>,
    /// The way up in the mesh's coordinates; any length but 0.
    pub up: [f64; 3],
    /// Where the way up is known from.
    pub up_from: UpFrom,
    /// The system of the coordinates, given or told by what lies beside poses and mesh.
    pub crs: Option<Crs>,
    /// What is added to the mesh's coordinates to give those of the system, given or told likewise.
    pub offset: Option<[f64; 3]>,
    /// The cameras.
    pub poses: Poses,
}

/// Where the way up is known from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum UpFrom {
    /// The pipeline file, or a city that is made.
    Given,
    /// Cameras and ground; `None` where the poses could not be read.
    Scene(Option<Upright>),
}

/// The way up, as a pipeline file has it.
#[derive(Default)]
struct Up(Option<[f64; 3]>);

impl FromToml for Up {
    fn from_toml(node: &Node) -> Result<Self, Problem> {
        if node.text() == Some("auto") {
            return Ok(Up(None));
        }
        let rule = |_| Problem::new("must be \"auto\" or a list of 3 numbers");
        <[f64; 3]>::from_toml(node).map(|up| Up(Some(up))).map_err(rule)
    }
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
            doc: "The triangle mesh, PLY, OBJ, glTF, STL or OFF, in the coordinates of the poses. Large coordinates (UTM) are fine. A \
                  * stands for any part of a name: \"tiles/*.obj\" is all of these files, as one mesh. So is a list, [\"a.obj\", \"b.ply\"].",
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
            doc: "The folder of masks, if you have them: NAME.png, NAME_mask.png or NAME.mask.png for the image NAME; a pixel is \
                  ignored where all colours are 0 or alpha is (sky, cars, people).",
            value: Value::Optional("\"masks\""),
        },
        Key {
            name: "up",
            doc: "The way up in the mesh's coordinates. \"auto\": crs tells it, or cameras that are held level, or else the \
                  ground; or a vector, as [0.0, 0.0, 1.0].",
            value: Value::Default("\"auto\""),
        },
        Key {
            name: "crs",
            doc: "The coordinate reference system that the mesh lies in: its EPSG number, a UTM zone, or \
                  \"ENU:latitude,longitude\". Without it, what OpenDroneMap, Metashape, a BlocksExchange, or a metadata.xml or \
                  .prj beside the mesh says. Exports and report.json name it.",
            value: Value::Optional("\"EPSG:32633\""),
        },
        Key {
            name: "offset",
            doc: "What is added to the mesh's coordinates to give coordinates of crs. Without it, what OpenDroneMap, or a \
                  metadata.xml or offset.xyz beside the mesh says, or nothing.",
            value: Value::Optional("[412000.0, 5812000.0, 0.0]"),
        },
        Key { name: "poses", doc: "The poses of the cameras.", value: Value::Section },
    ];

    fn read(keys: &Keys<'_>) -> Self {
        let mesh = Leads::to_files("put the mesh there, a PLY or OBJ file, or name it: --set scene.mesh=PATH");
        let images = Leads::to_folder("put the photographs there, or name their folder: --set scene.images=PATH");
        let masks = Leads::to_folder("name the folder of masks, or take the key out if there are none");
        let Up(given) = keys.value("up");
        let up = given.unwrap_or(USUAL);
        let length = DVec3::from(up).length_squared();
        let rule = "must be a finite vector that is not zero, as [0, 0, 1]";
        keys.check("up", length.is_finite() && length > 0.0, rule);
        let crs = keys.optional::<Written>("crs").map(|Written(crs)| crs);
        let offset: Option<[f64; 3]> = keys.optional("offset");
        let is_finite = offset.is_none_or(|offset| DVec3::from(offset).is_finite());
        keys.check("offset", is_finite, "must be three finite numbers");
        Scene {
            mesh: keys.paths("mesh", &mesh),
            images: keys.path("images", images),
            masks: keys.optional_path("masks", masks),
            up,
            up_from: if given.is_some() { UpFrom::Given } else { UpFrom::Scene(None) },
            crs,
            offset,
            poses: Poses::read(&keys.section_or("poses", Poses::OUTLINE, "path")),
        }
    }

    fn settings(&self) -> Settings {
        let Scene { mesh, images, masks, up, up_from: _, crs, offset, poses } = self;
        Settings::of(Self::NAME)
            .with("mesh", mesh, Effect::Input)
            .with("images", images, Effect::Input)
            .optional("masks", masks.as_ref(), Effect::Input)
            // The sky is the half that is up.
            .with("up", up, Effect::Light)
            .with("up", up, Effect::Look)
            .with("up", up, Effect::Axes)
            .optional("crs", crs.map(|crs| crs.to_string()), Effect::Place)
            .optional("offset", *offset, Effect::Place)
            .and(poses.settings())
    }
}

/// The way up where nothing tells it.
pub(super) const USUAL: [f64; 3] = [0.0, 0.0, 1.0];

impl Scene {
    /// The unit vector up.
    pub(crate) fn zenith(&self) -> Vec3 {
        DVec3::from(self.up).as_vec3().normalize_or_zero()
    }

    /// Where on the earth the scene lies, if anything tells it.
    pub(crate) fn georeference(&self) -> Option<Georeference> {
        let Scene { crs, offset, .. } = *self;
        (crs.is_some() || offset.is_some()).then(|| Georeference { crs, offset: offset.unwrap_or_default() })
    }
}

impl Section for Poses {
    const NAME: &'static str = "scene.poses";
    const ABOUT: &'static str = "Where the cameras stood. poses = \"PATH\" in [scene] stands for this section, where the files tell their format.";
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
        if keys.is_short() {
            return Poses::found(keys);
        }
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

impl Poses {
    /// Poses of which only the path is given: their format is the one whose files are there.
    fn found(keys: &Keys<'_>) -> Self {
        let path =
            keys.path("path", Leads::to_file_or_folder("name the folder or file of the poses: --set scene.poses=PATH"));
        // What a run makes is a city's.
        if keys.is_made("path", &path) || !keys.is_good("path") {
            return Poses { format: &poses::COLMAP, path };
        }
        let formats = poses::formats_at(&path);
        let names: Vec<&str> = formats.iter().map(|format| format.name).collect();
        let (rule, hint) = match names[..] {
            [] => {
                let all: Vec<&str> = poses::FORMATS.iter().map(|format| format.name).collect();
                ("holds no poses that are known by their files".to_owned(), format!("one of {}", all.join(", ")))
            }
            [first, ..] => (format!("may be {}", names.join(" or ")), format!("\"{first}\"")),
        };
        let hint = format!("say which: poses = {{ format = {hint}, path = .. }}");
        keys.check("path", names.len() == 1, Problem::new(rule).got(path.display().to_string()).hint(hint));
        Poses { format: formats.first().copied().unwrap_or(&poses::COLMAP), path }
    }
}
