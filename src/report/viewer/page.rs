//! The page around its payload.

use super::View;
use crate::mesh::base64::encoded;
use crate::mesh::gzip::compressed;

/// Built from `viewer/src` by `viewer/build.sh`.
const SCRIPT: &str = include_str!("../../../viewer/dist/viewer.js");
/// Of the script, as browsers want to have it before they run one.
const SCRIPT_HASH: &str = include_str!("../../../viewer/dist/viewer.js.sha256");
const STYLE: &str = include_str!("../../../viewer/src/page.css");
/// With a line for each of the others.
const FRAME: &str = include_str!("../../../viewer/src/page.html");

/// The whole of it. What is not ours (names of files) is in the payload, which no browser takes for
/// HTML.
pub fn page(view: &View<'_>) -> String {
    let payload = encoded(&compressed(&view.payload()));
    let mut rest = FRAME;
    let mut page = String::with_capacity(FRAME.len() + STYLE.len() + SCRIPT.len() + payload.len());
    let policy = content_security_policy();
    let parts =
        [("%POLICY%", &*policy), ("%STYLE%", STYLE), ("%PAYLOAD%", &payload), ("%SCRIPT%", SCRIPT)];
    for (mark, part) in parts {
        let (before, after) = rest.split_once(mark).expect("the frame has a mark for each part");
        page.push_str(before);
        page.push_str(part);
        rest = after;
    }
    page + rest
}

/// What the page may do: run its own script, and nothing that reaches beyond it.
pub fn content_security_policy() -> String {
    let hash = SCRIPT_HASH.trim();
    format!(
        "default-src 'none'; script-src 'sha256-{hash}'; style-src 'unsafe-inline'; \
         img-src data: blob:; base-uri 'none'; form-action 'none'"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_part_of_the_page_ends_before_its_end() {
        assert!(!SCRIPT.to_lowercase().contains("</script"));
        assert!(!SCRIPT.contains("<!--"), "which would have the script go on beyond its end");
        assert!(!STYLE.to_lowercase().contains("</style"));
    }

    #[test]
    fn the_licence_of_what_is_bundled_is_in_the_bundle() {
        assert!(SCRIPT.contains("three.js authors") && SCRIPT.contains("The MIT License"));
        assert!(SCRIPT.contains("above copyright notice and this permission notice"));
    }

    #[test]
    fn nothing_is_fetched() {
        for word in ["https://", "http://", "src=", "href=", "@import", "url("] {
            let frame = FRAME.contains(word) || STYLE.contains(word);
            assert!(!frame, "{word}");
        }
    }
}
