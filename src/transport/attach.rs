//! From the arguments of a worker process to its end.

use std::ffi::{OsStr, OsString};
use std::os::fd::{AsRawFd, OwnedFd};

use super::shared_memory::{self, SharedMemoryWorker};
use super::stream::{StreamWorker, pipe, socket};
use super::{TransportError, WakeUp};

/// What a worker process needs for its end, which [`attach`] makes of the arguments.
#[derive(Debug)]
pub struct Attach {
    /// The first one names the transport.
    pub arguments: Vec<OsString>,
    /// The child gets these by inheritance: to be kept until it was started, and no longer.
    pub inherited: Vec<OwnedFd>,
}

impl Attach {
    pub(super) fn new<const N: usize>(
        transport: &str,
        keys: [&str; N],
        values: [OsString; N],
        inherited: Vec<OwnedFd>,
    ) -> Self {
        let pairs = keys.into_iter().zip(values).flat_map(|(key, value)| [key.into(), value]);
        Self { arguments: std::iter::once(transport.into()).chain(pairs).collect(), inherited }
    }

    /// The same for a transport that is attached alike.
    pub(super) fn over(mut self, transport: &str) -> Self {
        self.arguments[0] = transport.into();
        self
    }
}

/// As an argument, the child having it under the same number.
pub(super) fn descriptor(fd: &OwnedFd) -> String {
    fd.as_raw_fd().to_string()
}

/// The end of a worker process.
#[derive(Debug)]
pub enum Attached {
    /// Has geometry in place.
    SharedMemory(SharedMemoryWorker),
    /// Has geometry in place, which its node is sent as it is needed.
    Node(SharedMemoryWorker),
    /// Has to be sent geometry.
    Stream(StreamWorker),
}

/// `arguments` are those of [`Attach`]. To be called once: the end takes over what the process
/// inherited.
pub fn attach(arguments: &[OsString]) -> Result<Attached, TransportError> {
    let (transport, values) = arguments
        .split_first()
        .ok_or_else(|| TransportError::Arguments("there are none".to_owned()))?;
    match transport.to_str() {
        Some(shared_memory::NAME) => SharedMemoryWorker::attach(values).map(Attached::SharedMemory),
        Some(shared_memory::NODE) => SharedMemoryWorker::attach(values).map(Attached::Node),
        Some(pipe::NAME) => pipe::attach(values).map(Attached::Stream),
        Some(socket::NAME) => socket::attach(values).map(Attached::Stream),
        _ => Err(TransportError::Arguments(format!("there is no transport {transport:?}"))),
    }
}

/// The values of exactly these keys, in this order.
pub(super) fn values<'a, const N: usize>(
    arguments: &'a [OsString],
    keys: [&str; N],
) -> Result<[&'a OsStr; N], TransportError> {
    let (pairs, rest) = arguments.as_chunks::<2>();
    let is_as_expected = rest.is_empty() && pairs.iter().map(|[key, _]| key).eq(keys);
    if !is_as_expected {
        let found = format!("{arguments:?}, not {}", keys.join(" … "));
        return Err(TransportError::Arguments(found));
    }
    Ok(std::array::from_fn(|index| pairs[index][1].as_os_str()))
}

pub(super) fn number<N: std::str::FromStr>(value: &OsStr) -> Result<N, TransportError> {
    let parsed = value.to_str().and_then(|value| value.parse().ok());
    parsed.ok_or_else(|| TransportError::Arguments(format!("{value:?} is not a number here")))
}

pub(super) fn wake_up(value: &OsStr) -> Result<WakeUp, TransportError> {
    let parsed = value.to_str().and_then(WakeUp::from_name);
    parsed.ok_or_else(|| TransportError::Arguments(format!("{value:?} is no way to wake up")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_of_no_transport_are_refused_by_name() {
        let refused = |arguments: &[&str]| {
            let arguments: Vec<_> = arguments.iter().map(OsString::from).collect();
            attach(&arguments).unwrap_err().to_string()
        };
        assert!(refused(&[]).contains("none"));
        assert!(refused(&["pigeon"]).contains("pigeon"));
        for transport in [shared_memory::NAME, pipe::NAME, socket::NAME] {
            assert!(refused(&[transport, "--run"]).contains("--wake-up"));
        }
    }

    #[test]
    fn keys_come_in_order_and_all_of_them() {
        let arguments = ["--a", "1", "--b", "2"].map(OsString::from);
        assert_eq!(values(&arguments, ["--a", "--b"]).unwrap(), ["1", "2"].map(OsStr::new));
        assert!(values(&arguments, ["--b", "--a"]).is_err());
        assert!(values(&arguments, ["--a"]).is_err());
        assert!(values(&arguments[..3], ["--a"]).is_err());
    }
}
