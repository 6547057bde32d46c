//! Why a command did not do what was asked, and the exit code that says so.

use std::process::ExitCode;

pub(super) enum Failure {
    /// What was asked for makes no sense: nothing was done.
    Usage(anyhow::Error),
    /// Something went wrong on the way.
    Failed(anyhow::Error),
    /// The user stopped it; says what was kept.
    Interrupted(String),
}

impl Failure {
    pub(super) fn usage(error: impl Into<anyhow::Error>) -> Self {
        Self::Usage(error.into())
    }

    /// Says what happened on stderr.
    pub(super) fn report(self) -> ExitCode {
        match self {
            Self::Usage(error) => {
                eprintln!("error: {}", with_causes(&error));
                ExitCode::from(2)
            }
            Self::Failed(error) => {
                eprintln!("error: {}", with_causes(&error));
                ExitCode::FAILURE
            }
            Self::Interrupted(kept) => {
                eprintln!("interrupted: {kept}");
                ExitCode::from(130)
            }
        }
    }
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Failed(error.into())
    }
}

/// Each cause once: many an error tells its cause in its own words already.
fn with_causes(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.ends_with(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;
    use crate::report::OutputError;

    #[test]
    fn every_cause_is_told_once() {
        let source = io::Error::other("disk on fire");
        let error = OutputError::Io { path: "out".into(), source };
        let error = anyhow::Error::new(error).context("cannot go on");
        let expected = "cannot go on: out: cannot write results here: disk on fire";
        assert_eq!(with_causes(&error), expected);
    }
}
