//! What a scene can ask of a scenario; one file an effect.

pub mod contacts;
pub mod inside;
pub mod penetration;
pub mod response;
pub mod volume;
