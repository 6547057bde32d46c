#![no_main]

bumper_fuzz::fuzz!("suite");
