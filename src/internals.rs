//! What benches, fuzz targets and tests of the command reach into. It is no part of the face, and changes without notice.

pub mod base {
    pub use crate::base::{Error, PhaseName, Result};

    pub mod ids {
        pub use crate::base::ids::{ShardId, TriangleId};
    }
    pub mod key {
        pub use crate::base::key::Key;
    }
    pub mod memory {
        pub use crate::base::memory::{anonymous, resident, return_what_is_freed, trim};
    }
}

pub mod cache {
    pub use crate::cache::{VERSION, open, write};
}

pub mod codec {
    pub mod images {
        pub use crate::codec::images::{Curve, Encoded, Size, Transfer, need, read_image, size, write_jpeg, write_png};
    }
    pub mod meshes {
        pub use crate::codec::meshes::read;

        pub mod ply {
            pub use crate::codec::meshes::ply::write_mesh;
        }
    }
    pub mod poses {
        pub use crate::codec::poses::{
            COLMAP, FORMATS, NoPhotographs, PhotographFolder, Photographs, PoseFormat, read,
        };

        pub mod colmap {
            pub use crate::codec::poses::colmap::{Encoding, write_model};
        }
    }
    pub mod tables {
        pub mod npy {
            pub use crate::codec::tables::npy::{read_rows, view};
        }
    }
}

pub mod disk {
    pub use crate::disk::{DirStore, Ledger, Lock, MemStore, Recipe, Store};

    pub mod frozen {
        pub use crate::disk::frozen::Frozen;
    }
    pub mod mark {
        pub use crate::disk::mark::foreign;
    }
}

pub mod light {
    pub use crate::light::{
        Clues, Decision, Found, Gains, Scene, Settings, Sighting, Spread, TRIANGLES, find, gains, sample,
    };
}

pub mod model {
    pub use crate::model::{
        BUILT_IN, Backend, Contract, Estimate, Estimator, Fit, MapLight, ModelSource, complete, for_rten, load,
    };
}

pub mod scene {
    pub use crate::scene::{Material, Mesh};

    pub mod camera {
        pub use crate::scene::camera::{Camera, Lens};
    }
    pub mod frame {
        pub use crate::scene::frame::Frame;
    }
    pub mod light {
        pub use crate::scene::light::LocalLight;
    }
    pub mod pose {
        pub use crate::scene::pose::Pose;
    }
    pub mod reflectance {
        pub use crate::scene::reflectance::{Bin, BinSum, FRONT_BINS, Layout, SparseMap};
    }
}

pub mod shard {
    pub use crate::shard::{Blocks, Segment, ShardRows, collect_shard};

    pub mod block {
        pub use crate::shard::block::{Columns, decode};
    }
    pub mod format {
        pub use crate::shard::format::{ENTRY, Entry, MAGIC, VERSION};
    }
    pub mod rows {
        pub use crate::shard::rows::{ROW, VERSION};
    }
}

pub mod synth {
    pub mod spheres {
        pub use crate::synth::spheres::{Camera, Layout, MAP, Sample};
    }
}

pub mod trace {
    pub use crate::trace::{Bvh, Hit, Ray};

    pub mod tile {
        pub use crate::trace::tile::{cast, order};
    }
}
