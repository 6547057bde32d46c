//! What a scene can ask of a scenario; one file an effect.

pub mod contacts;
pub mod crush;
pub mod response;
