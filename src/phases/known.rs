//! What is known before the costly work starts: estimator, scene, what can be read, and how long things take. It is found out
//! here, in one order, for `run`, `plan` and `explain` alike.

use std::sync::Arc;

use super::cast::{FrameGroups, Readable, pixels};
use super::facts::{Facts, Trial};
use super::infer::{TriedEstimator, load_estimator};
use super::light::{FrozenLight, Occasion, lights_of};
use super::scene::{LoadedScene, Meshes};
use crate::base::{Error, Result, memory};
use crate::config::Choice;
use crate::disk::{Ledger, Store};
use crate::flow::pool;
use crate::model::Estimator;
use crate::pipeline::Pipeline;
use crate::stages::light::Mode;
use crate::stages::scene_light::SunAndSky;

/// What a scene is looked at for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Look {
    /// To run it: the scene must be there, and a damaged cache is an error, after which the cache is made over.
    Run,
    /// To say what a run will take: a scene that is still to be made is estimated.
    Plan,
    /// To say what a run will do over: a scene that is still to be made is estimated, and memory and time do not matter.
    Explain,
}

/// What is known of a pipeline.
pub(crate) struct Known<'a> {
    /// The pipeline.
    pub pipeline: &'a Pipeline,
    /// What turns maps into materials.
    pub estimator: Box<dyn Estimator>,
    /// Whether the estimator was loaded for a light.
    lit: bool,
    /// The bytes that the process holds before it reads a scene.
    pub process: u64,
    surveyed: Option<Surveyed>,
}

/// What is known of a scene.
pub(crate) struct Surveyed {
    /// The scene.
    pub scene: LoadedScene,
    /// What is known of exposures and light.
    pub light: FrozenLight,
    /// The frame groups, each with the recipes that it has now.
    pub groups: FrameGroups,
    /// The figures of the scene and of this machine.
    pub facts: Facts,
}

impl<'a> Known<'a> {
    /// Loads the estimator: a model that does not work is found before anything costly starts.
    ///
    /// # Errors
    /// A model or a library that cannot be used.
    pub(crate) fn new(pipeline: &'a Pipeline) -> Result<Self> {
        // A light that is still to be found is reckoned with.
        let lit = pipeline.light.mode != Mode::Unknown;
        let estimator = load_estimator(pipeline, lit)?;
        Ok(Known { pipeline, estimator, lit, process: process_bytes(), surveyed: None })
    }

    /// Looks at the scene: reads mesh and poses, finds which frames can be read under the limit, and tries how long a map and,
    /// where frames are still to be cast, a pixel take. A limit that cannot work is told by `refuses` before frames are tried.
    ///
    /// # Errors
    /// Inputs that cannot be read, a mesh that does not fit under the limit, what `refuses` answers.
    pub(crate) fn look(
        &mut self,
        look: Look,
        store: &Arc<dyn Store>,
        ledger: &Ledger,
        refuses: &(dyn Fn(&Pipeline, &Facts) -> Result<()> + Sync),
    ) -> Result<&Surveyed> {
        let surveyed = pool::share(self.pipeline.run.threads(), || self.survey(look, store, ledger, refuses))??;
        Ok(self.surveyed.insert(surveyed))
    }

    /// The lights, as far as they are known by now, that of most frames first.
    pub(crate) fn lights(&self) -> Vec<SunAndSky> {
        lights_of(self.pipeline, self.surveyed.as_ref().map(|surveyed| &surveyed.light))
    }

    /// Loads the estimator that is asked for with the light as it is, if another was loaded before the light was found.
    ///
    /// # Errors
    /// A model or a library that cannot be used.
    pub(crate) fn settle_estimator(&mut self) -> Result<()> {
        self.settle_for(!self.lights().is_empty())
    }

    fn settle_for(&mut self, lit: bool) -> Result<()> {
        let method = self.pipeline.infer.estimator;
        if method.settled(lit) != method.settled(self.lit) {
            self.estimator = load_estimator(self.pipeline, lit)?;
        }
        self.lit = lit;
        Ok(())
    }

    /// Refuses an estimator that needs a light which was not found.
    ///
    /// # Errors
    /// There is none, and what to do.
    pub(crate) fn needs_light(&self) -> Result<()> {
        if !self.lights().is_empty() || !self.estimator.contract().light.wanted() {
            return Ok(());
        }
        Err(Error::invalid(format!(
            "no light was found in the photographs, and [infer] estimator = \"{}\" needs one: set estimator = \"auto\", or give \
             the sun with [light] mode = \"known\"",
            self.pipeline.infer.estimator.name()
        )))
    }

    fn survey(
        &mut self,
        look: Look,
        store: &Arc<dyn Store>,
        ledger: &Ledger,
        refuses: &dyn Fn(&Pipeline, &Facts) -> Result<()>,
    ) -> Result<Surveyed> {
        let pipeline = self.pipeline;
        let meshes = if look == Look::Explain { Meshes::Any } else { Meshes::Within { held: self.process } };
        let scene = match look {
            Look::Run => LoadedScene::of_run(pipeline, &**store, ledger, meshes)?,
            Look::Plan | Look::Explain => LoadedScene::foreseen(pipeline, &**store, ledger, meshes)?,
        };
        let readable = Readable::of(pipeline, &scene, self.process);
        let light = match look {
            Look::Run => FrozenLight::open(store, pipeline, scene.mesh_key)?,
            Look::Plan | Look::Explain => FrozenLight::read(store, pipeline, scene.mesh_key)?,
        };
        if light.state().light.is_none() && pipeline.light.mode == Mode::Ephemeris && pipeline.is_made() {
            // What is missing is told before anything is read of the frames.
            Occasion::of(pipeline, &scene.frames)?;
        }
        if light.state().light.is_some() {
            self.settle_for(!lights_of(self.pipeline, Some(&light)).is_empty())?;
        }
        let groups = match look {
            Look::Run => FrameGroups::of_run(pipeline, store, ledger, &scene, &readable, &light)?,
            Look::Plan | Look::Explain => FrameGroups::read(pipeline, store, ledger, &scene, Some(&readable), &light)?,
        };
        let tried = match look {
            Look::Explain => TriedEstimator::default(),
            Look::Run | Look::Plan => TriedEstimator::of(&*self.estimator)?,
        };
        let (too_large, too_large_needs) = readable.too_large();
        let sizes = || scene.frames.iter().map(|frame| pixels(pipeline, frame));
        let mut facts = Facts {
            frames: scene.frames.len() as u64,
            groups: groups.all().len() as u64,
            pixels: sizes().sum(),
            largest: sizes().max().unwrap_or(0),
            frame: readable.largest(),
            too_large,
            too_large_needs,
            triangles: scene.mesh.len() as u64,
            mesh: scene.bytes(),
            mapped: scene.is_mapped(),
            process: self.process,
            session: tried.session,
            seconds_per_map: tried.seconds_per_map,
            trial: None,
            threads: pipeline.run.threads(),
        };
        let fits = refuses(pipeline, &facts);
        let casts = groups.all().iter().any(|group| !ledger.is_done(&group.recipe.unit()));
        match look {
            Look::Explain => {}
            // Where nothing is cast, there is nothing to foretell.
            Look::Run => {
                fits?;
                if casts {
                    facts.trial = self.try_frames(&scene, &readable)?;
                }
            }
            Look::Plan => {
                if fits.is_ok() {
                    facts.trial = self.try_frames(&scene, &readable)?;
                }
            }
        }
        Ok(Surveyed { scene, light, groups, facts })
    }

    fn try_frames(&self, scene: &LoadedScene, readable: &Readable) -> Result<Option<Trial>> {
        Trial::of(self.pipeline, scene, self.process, readable, self.estimator.contract().light.wanted())
    }

    /// What is known of the scene.
    ///
    /// # Errors
    /// Nobody has looked at it yet.
    pub(crate) fn surveyed(&self) -> Result<&Surveyed> {
        self.surveyed.as_ref().ok_or_else(unseen)
    }

    /// What is known of the scene, to be changed.
    ///
    /// # Errors
    /// Nobody has looked at it yet.
    pub(crate) fn surveyed_mut(&mut self) -> Result<&mut Surveyed> {
        self.surveyed.as_mut().ok_or_else(unseen)
    }
}

fn unseen() -> Error {
    Error::invalid("a phase asked for the scene before the phase that loads it")
}

/// The bytes that the process holds now, and those that the allocator may keep of small blocks. To be asked once the estimator
/// is there and before a scene is.
pub(crate) fn process_bytes() -> u64 {
    memory::trim();
    memory::resident().unwrap_or(USUAL) + KEPT
}

/// The bytes of a process whose system does not say.
const USUAL: u64 = 48 << 20;

/// The bytes of small blocks that the allocator keeps, of a transfer's curves, and of the stacks of threads beside workers.
const KEPT: u64 = 24 << 20;
