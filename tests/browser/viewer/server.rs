//! The page as `--serve` gives it.

use std::io::{BufRead, BufReader};

use super::*;

#[test]
fn a_served_page_is_the_same_and_asks_for_nothing_else() {
    let Some(mut browser) = Chromium::start() else { return };
    let place = Place::new();
    let arguments = [&["view", "--serve", "127.0.0.1:0"], &SMALL[..], &["--count", "3"]].concat();
    let mut process = place.bumper(&arguments).stdout(Stdio::piped()).spawn().unwrap();
    let mut address = String::new();
    BufReader::new(process.stdout.take().unwrap()).read_line(&mut address).unwrap();
    let address = address.trim();
    assert!(address.starts_with("http://127.0.0.1:"), "{address}");
    browser.navigate(address);
    ready(&mut browser);
    assert_eq!(text_of(&mut browser, "run-scenarios"), "3");
    let (problems, requests) = (browser.problems().to_vec(), browser.requests().to_vec());
    assert_eq!((problems, requests), (vec![], vec![address.to_owned()]));
    // SAFETY: a plain system call; the process is our own child, which is not reaped yet.
    unsafe { libc::kill(process.id() as libc::pid_t, libc::SIGINT) };
    assert_eq!(process.wait().unwrap().code(), Some(0));
}
