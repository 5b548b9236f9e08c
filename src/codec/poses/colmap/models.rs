//! COLMAP's camera models: ids, names, and the order of their parameters (`src/colmap/sensor/models.h` of COLMAP). The
//! same table turns parameters into a lens and a lens into parameters.

use std::cmp::Reverse;

use glam::DVec2;

use crate::base::shown::short;
use crate::scene::camera::{Camera, Distortion, Lens, Projection, Unified};

/// A camera model. Its parameters are the focal lengths, the principal point, and then the terms.
#[derive(Debug)]
pub(super) struct Model {
    /// COLMAP's name of the model.
    pub name: &'static str,
    /// How many focal lengths the model has: 1 or 2.
    focal_lengths: usize,
    family: Family,
    terms: &'static [Term],
}

/// The projection of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Family {
    Pinhole,
    Perspective,
    Equidistant,
    /// Equidistant, with tangential and prism terms that act on the point that the radial term gives.
    Chained,
    /// The division models: the distortion says the way back.
    Inward,
    FieldOfView,
    Unified,
    /// A panorama: its pixels are angles, and what stands in place of the principal point is its size.
    Panorama,
}

/// A parameter after the principal point: a term of the distortion, by its position there, or one of the other models.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Term {
    K(usize),
    D(usize),
    P(usize),
    S(usize),
    Omega,
    Alpha,
    Beta,
}

use Term::{Alpha, Beta, D, K, Omega, P, S};

const fn model(name: &'static str, focal_lengths: usize, family: Family, terms: &'static [Term]) -> Model {
    Model { name, focal_lengths, family, terms }
}

/// The models. The position of a model is its id.
static MODELS: [Model; 18] = [
    model("SIMPLE_PINHOLE", 1, Family::Pinhole, &[]),
    model("PINHOLE", 2, Family::Pinhole, &[]),
    model("SIMPLE_RADIAL", 1, Family::Perspective, &[K(0)]),
    model("RADIAL", 1, Family::Perspective, &[K(0), K(1)]),
    model("OPENCV", 2, Family::Perspective, &[K(0), K(1), P(0), P(1)]),
    model("OPENCV_FISHEYE", 2, Family::Equidistant, &[K(0), K(1), K(2), K(3)]),
    model("FULL_OPENCV", 2, Family::Perspective, &[K(0), K(1), P(0), P(1), K(2), D(0), D(1), D(2)]),
    model("FOV", 2, Family::FieldOfView, &[Omega]),
    model("SIMPLE_RADIAL_FISHEYE", 1, Family::Equidistant, &[K(0)]),
    model("RADIAL_FISHEYE", 1, Family::Equidistant, &[K(0), K(1)]),
    model("THIN_PRISM_FISHEYE", 2, Family::Equidistant, &[K(0), K(1), P(0), P(1), K(2), K(3), S(0), S(2)]),
    // COLMAP exchanges p1 and p2 in this model.
    model(
        "RAD_TAN_THIN_PRISM_FISHEYE",
        2,
        Family::Chained,
        &[K(0), K(1), K(2), K(3), K(4), K(5), P(1), P(0), S(0), S(1), S(2), S(3)],
    ),
    model("SIMPLE_DIVISION", 1, Family::Inward, &[D(0)]),
    model("DIVISION", 2, Family::Inward, &[D(0)]),
    model("SIMPLE_FISHEYE", 1, Family::Equidistant, &[]),
    model("FISHEYE", 2, Family::Equidistant, &[]),
    model("EUCM", 2, Family::Unified, &[Alpha, Beta]),
    model(PANORAMA, 0, Family::Panorama, &[]),
];

/// The model that has no lens.
pub(super) const PANORAMA: &str = "EQUIRECTANGULAR";

/// The first model that COLMAP has only since its version 4.
const SINCE_4: usize = 12;

fn known() -> String {
    MODELS.each_ref().map(|m| m.name).join(", ")
}

/// The model of an id.
///
/// # Errors
/// In words: an id that no model has.
pub(super) fn by_id(id: i32) -> Result<&'static Model, String> {
    let found = usize::try_from(id).ok().and_then(|id| MODELS.get(id));
    found.ok_or_else(|| format!("camera model {id} is not known; 0 to {} are: {}", MODELS.len() - 1, known()))
}

/// The model of a name.
///
/// # Errors
/// In words: a name that no model has.
pub(super) fn by_name(name: &str) -> Result<&'static Model, String> {
    let found = MODELS.iter().find(|m| m.name == name);
    found.ok_or_else(|| format!("camera model {} is not known; these are: {}", short(name), known()))
}

/// What COLMAP writes of a lens.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Written {
    /// The id of the model.
    pub id: i32,
    /// The name of the model.
    pub name: &'static str,
    /// The parameters, in the model's order.
    pub parameters: Vec<f64>,
}

/// A lens by the names of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Parts {
    family: Family,
    distortion: Distortion,
    omega: f64,
    alpha: f64,
    beta: f64,
}

impl Parts {
    fn of(lens: &Lens) -> Parts {
        let of = |family, distortion| Parts { distortion, ..Parts::none(family) };
        match *lens.projection() {
            Projection::Pinhole => Parts::none(Family::Pinhole),
            Projection::Perspective(d) => of(Family::Perspective, d),
            Projection::Equidistant(d) if d.chained => of(Family::Chained, d),
            Projection::Equidistant(d) => of(Family::Equidistant, d),
            Projection::Inward(d) => of(Family::Inward, d),
            Projection::FieldOfView { omega } => Parts { omega, ..Parts::none(Family::FieldOfView) },
            Projection::Unified(Unified { alpha, beta }) => Parts { alpha, beta, ..Parts::none(Family::Unified) },
        }
    }

    fn none(family: Family) -> Parts {
        let distortion = Distortion { chained: family == Family::Chained, ..Distortion::default() };
        Parts { family, distortion, omega: 0.0, alpha: 0.0, beta: 0.0 }
    }

    fn term(&mut self, term: Term) -> &mut f64 {
        match term {
            K(at) => &mut self.distortion.radial[at],
            D(at) => &mut self.distortion.rational[at],
            P(at) => &mut self.distortion.tangential[at],
            S(at) => &mut self.distortion.prism[at],
            Omega => &mut self.omega,
            Alpha => &mut self.alpha,
            Beta => &mut self.beta,
        }
    }

    fn projection(&self) -> Projection {
        match self.family {
            // No lens is made of a panorama.
            Family::Pinhole | Family::Panorama => Projection::Pinhole,
            Family::Perspective => Projection::Perspective(self.distortion),
            Family::Equidistant | Family::Chained => Projection::Equidistant(self.distortion),
            Family::Inward => Projection::Inward(self.distortion),
            Family::FieldOfView => Projection::FieldOfView { omega: self.omega },
            Family::Unified => Projection::Unified(Unified { alpha: self.alpha, beta: self.beta }),
        }
    }

    /// The names of the terms that are not 0.
    fn named(&self) -> String {
        let Distortion { radial, rational, tangential, prism, chained } = &self.distortion;
        let lists = [("k", &radial[..]), ("d", rational), ("p", tangential), ("s", prism)];
        let set = |(name, values): (&'static str, &[f64])| -> Vec<String> {
            let set = values.iter().enumerate().filter(|(_, value)| **value != 0.0);
            set.map(|(at, _)| format!("{name}{}", at + 1)).collect()
        };
        let names = lists.into_iter().flat_map(set).collect::<Vec<_>>().join(", ");
        if *chained { format!("{names}, chained") } else { names }
    }
}

impl Model {
    /// How many parameters the model has.
    pub(super) fn count(&self) -> usize {
        self.focal_lengths + 2 + self.terms.len()
    }

    /// The camera of this model with these parameters; `None` for a panorama, which has no lens.
    ///
    /// # Errors
    /// In words: too few or too many parameters, a parameter or a size out of range.
    pub(super) fn camera(&self, width: u64, height: u64, parameters: &[f64]) -> Result<Option<Camera>, String> {
        if parameters.len() != self.count() {
            return Err(format!("{} parameters are given, and {} has {}", parameters.len(), self.name, self.count()));
        }
        if self.family == Family::Panorama {
            return Ok(None);
        }
        let (focal, rest) = parameters.split_at(self.focal_lengths);
        let focal = DVec2::new(focal[0], focal[self.focal_lengths - 1]);
        let (centre, values) = (DVec2::new(rest[0], rest[1]), &rest[2..]);
        let mut parts = Parts::none(self.family);
        self.terms.iter().zip(values).for_each(|(term, value)| *parts.term(*term) = *value);
        Camera::new(width, height, Lens::new(focal, centre, parts.projection())?).map(Some)
    }

    /// Whether the model can say everything of a lens.
    fn says(&self, focal: DVec2, mut parts: Parts) -> bool {
        self.terms.iter().for_each(|term| *parts.term(*term) = 0.0);
        parts == Parts::none(self.family) && (self.focal_lengths == 2 || focal.x == focal.y)
    }

    fn parameters(&self, focal: DVec2, centre: DVec2, mut parts: Parts) -> Vec<f64> {
        let focal = &focal.to_array()[..self.focal_lengths];
        let mut parameters = [focal, &centre.to_array()].concat();
        parameters.extend(self.terms.iter().map(|term| *parts.term(*term)));
        parameters
    }
}

/// The model with the fewest terms that says everything of a lens, with two focal lengths where there is a choice, and one
/// that every COLMAP knows where there is one. Read again, it gives the same lens to the bit.
///
/// # Errors
/// In words: a lens that no model can say.
pub(super) fn written(lens: &Lens) -> Result<Written, String> {
    let (focal, parts) = (lens.focal(), Parts::of(lens));
    let fitting = MODELS.iter().enumerate().filter(|(_, model)| model.says(focal, parts));
    let fewest = fitting.min_by_key(|(id, model)| (*id >= SINCE_4, model.terms.len(), Reverse(model.focal_lengths)));
    let Some((id, model)) = fewest.and_then(|(id, model)| Some((i32::try_from(id).ok()?, model))) else {
        let kind = match parts.family {
            Family::Perspective => "a perspective",
            Family::Inward => "an inward",
            _ => "an equidistant",
        };
        return Err(format!("no camera model of COLMAP has the terms {} of {kind} lens", parts.named()));
    };
    Ok(Written { id, name: model.name, parameters: model.parameters(focal, lens.centre(), parts) })
}
