//! Whether this process is one of several ranks, and what it has to do as such.

use super::failure::Failure;
use crate::scheduler::ranks::Command;

/// What is to be done here.
pub(super) enum Part {
    /// All of the run, with the other ranks if there are such.
    Master(Option<Command>),
    /// Nothing more: another rank was the master.
    Done,
}

#[cfg(feature = "mpi")]
pub(super) fn take_part() -> Result<Part, Failure> {
    use anyhow::Context;

    use crate::scheduler::launch::Processes;
    use crate::scheduler::ranks;
    use crate::transport::mpi::World;
    use crate::transport::ranks::{Ranks, was_launched};
    use crate::transport::shared_memory::default_base;

    if !was_launched() {
        return Ok(Part::Master(None));
    }
    let mut world = World::join().map_err(anyhow::Error::from)?;
    if world.rank() == 0 {
        return Ok(Part::Master(Some(Command::new(Box::new(world)))));
    }
    let program = std::env::current_exe().context("cannot find my own executable")?;
    ranks::serve(&mut world, &Processes { program }, &default_base()).map_err(anyhow::Error::from)?;
    Ok(Part::Done)
}

#[cfg(not(feature = "mpi"))]
pub(super) fn take_part() -> Result<Part, Failure> {
    if crate::transport::ranks::is_one_of_several() {
        return Err(Failure::usage(anyhow::anyhow!(
            "started as one of several ranks, but this bumper knows no MPI: build it with \
             --features mpi"
        )));
    }
    Ok(Part::Master(None))
}
