//! What a person sees: progress and warnings on stderr, answers on stdout.

use std::io::{self, IsTerminal, Write};
use std::sync::LazyLock;

use indicatif::{MultiProgress, ProgressBar, ProgressState, ProgressStyle};
use tracing_subscriber::filter::LevelFilter;

use super::failure::Failure;

/// All bars of this process; hidden unless stderr is a terminal.
static BARS: LazyLock<MultiProgress> = LazyLock::new(MultiProgress::new);

/// A bar that counts scenarios or cases, with their rate and the time left.
pub(super) fn scenario_bar(what: &'static str, count: usize) -> ProgressBar {
    let template = "{msg:10} {wide_bar} {pos}/{len}  {rate}  {eta} left";
    let style = ProgressStyle::with_template(template).expect("the template is valid").with_key(
        "rate",
        |state: &ProgressState, text: &mut dyn std::fmt::Write| {
            // The bar has nowhere to tell an error, and a string takes every number.
            let _ = write!(text, "{:.0}/s", state.per_sec());
        },
    );
    BARS.add(ProgressBar::new(count as u64).with_style(style).with_message(what))
}

/// A bar that counts samples, with the time left and what is measured now.
pub(super) fn point_bar(count: usize) -> ProgressBar {
    let template = "{wide_bar} {pos}/{len}  {eta} left  {msg}";
    let style = ProgressStyle::with_template(template).expect("the template is valid");
    let bar = BARS.add(ProgressBar::new(count as u64).with_style(style));
    bar.enable_steady_tick(std::time::Duration::from_millis(200));
    bar
}

/// A line that says what is being done, until it is finished.
pub(super) fn activity(what: &'static str) -> ProgressBar {
    let bar = BARS.add(ProgressBar::new_spinner().with_message(what));
    bar.enable_steady_tick(std::time::Duration::from_millis(100));
    bar
}

/// A line on stderr, above the bars.
pub(super) fn tell(line: &str) {
    BARS.suspend(|| eprintln!("{line}"));
}

/// Sends warnings and errors of the library to stderr, above the bars.
pub(super) fn log_to_stderr() -> Result<(), Failure> {
    let subscriber = tracing_subscriber::fmt()
        .with_max_level(LevelFilter::WARN)
        .with_target(false)
        .without_time()
        .with_ansi(io::stderr().is_terminal())
        .with_writer(|| AboveBars);
    subscriber.try_init().map_err(|e| anyhow::anyhow!(e).into())
}

struct AboveBars;

impl Write for AboveBars {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        BARS.suspend(|| io::stderr().write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}

/// Prints an answer. A reader that has seen enough (`| head`) is no failure.
pub(super) fn print(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        outcome => outcome,
    }
}
