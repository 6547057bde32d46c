//! Whether this process is one of several ranks, and what it has to do as such.

use super::failure::Failure;
use crate::scheduler::ranks::Command;

/// This process is the master, of the other ranks if there are such.
pub(super) struct Master {
    pub command: Option<Command>,
}

/// `None` if another rank is the master, and nothing is left to be done here.
#[cfg(feature = "mpi")]
pub(super) fn take_part() -> Result<Option<Master>, Failure> {
    use anyhow::Context;

    use crate::scheduler::launch::Processes;
    use crate::scheduler::ranks;
    use crate::transport::mpi::World;
    use crate::transport::ranks::{Ranks, was_launched};
    use crate::transport::shared_memory::default_base;

    if !was_launched() {
        return Ok(Some(Master { command: None }));
    }
    let mut world = World::join().map_err(anyhow::Error::from)?;
    if world.rank() == 0 {
        return Ok(Some(Master { command: Some(Command::new(Box::new(world))) }));
    }
    let program = std::env::current_exe().context("cannot find my own executable")?;
    ranks::serve(&mut world, &Processes { program }, &default_base())
        .map_err(anyhow::Error::from)?;
    Ok(None)
}

/// As above, where no other rank can be.
#[cfg(not(feature = "mpi"))]
pub(super) fn take_part() -> Result<Option<Master>, Failure> {
    if crate::transport::ranks::is_one_of_several() {
        return Err(Failure::usage(anyhow::anyhow!(
            "started as one of several ranks, but this bumper knows no MPI: build it with \
             --features mpi"
        )));
    }
    Ok(Some(Master { command: None }))
}
