//! Bytes as text.

use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use base64::{DecodeError, Engine};

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// With or without padding.
pub fn decoded(text: &str) -> Result<Vec<u8>, DecodeError> {
    BASE64.decode(text)
}

/// With padding.
pub fn encoded(bytes: &[u8]) -> String {
    BASE64.encode(bytes)
}
