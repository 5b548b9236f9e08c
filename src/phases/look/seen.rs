//! All that the frames saw of the sample.

use crate::base::Result;
use crate::base::ids::FrameId;
use crate::disk::{Ledger, Store};
use crate::light::Sighting;
use crate::phases::cast::image_in;
use crate::phases::known::Known;
use crate::stages::look::{read_sightings, sightings_bytes};

/// What the frames saw of the sample, and what they were read from.
pub(crate) struct Seen {
    /// A row for each frame and triangle, in the order of the groups.
    pub rows: Vec<Sighting>,
    /// The content of every frame's image, as recipes have it; empty where it was not read.
    pub images: Vec<String>,
}

impl Seen {
    /// Reads what the groups that are done left; every so many-th row where they are more than `most`.
    ///
    /// # Errors
    /// Sightings that cannot be read.
    pub(crate) fn read(known: &Known<'_>, store: &dyn Store, ledger: &Ledger, most: u64) -> Result<Self> {
        let surveyed = known.surveyed()?;
        let (frames, sample) = (&surveyed.scene.frames, surveyed.light.sample());
        let groups = surveyed.groups.looks();
        let done = || groups.iter().filter_map(|group| Some((group, ledger.files(&group.recipe.unit())?)));
        let all: u64 = done().map(|(_, files)| sightings_bytes(&files)).sum::<u64>() / size_of::<Sighting>() as u64;
        let every = crate::base::convert::to_usize(all.div_ceil(most.max(1)).max(1));
        let (mut rows, mut images) = (Vec::new(), vec![String::new(); frames.len()]);
        for (group, files) in done() {
            rows.extend(read_sightings(store, &files, &group.frames, sample.len())?.into_iter().step_by(every));
            let content = |id: &FrameId| (*id, image_in(&group.recipe, &frames[id.index()].name).to_owned());
            group.frames.iter().map(content).for_each(|(id, content)| images[id.index()] = content);
        }
        Ok(Seen { rows, images })
    }
}
