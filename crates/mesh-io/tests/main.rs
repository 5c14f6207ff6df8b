//! The tests of this crate, in one program, so that it is linked once.

mod built_scene;
mod companions;
mod compressed;
mod external;
mod faults;
mod formats;
mod loaded_elsewhere;
mod losses;
mod passing;
mod peers;
mod pictures;
mod quantized;
mod real_meshes;
mod robustness;
mod roundtrip;
mod scalar_types;
mod scan;
mod scenes;
mod serde;
mod untrusted_input;
