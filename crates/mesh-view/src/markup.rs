//! The page around the data: one HTML file that cannot load anything else.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

use crate::text::{escaped, visible};

const STYLE: &str = include_str!("page/style.css");
const VIEWER: &str = include_str!("page/viewer.js");

/// An element in the first kilobyte of every page, which identifies pages of this crate.
pub const GENERATOR: &str = r#"<meta name="generator" content="curvmesh">"#;

/// The complete file. Only the script and the style of this crate may run, identified by their hashes. No requests to
/// any address are allowed.
pub(crate) fn document(title: &str, description: &str, data: &str) -> String {
    let title = escaped(&visible(title));
    let [script, style] = [VIEWER, STYLE].map(hash);
    format!(
        r#"<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src '{script}'; style-src '{style}'; base-uri 'none'; form-action 'none'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="referrer" content="no-referrer">
{GENERATOR}
<title>{title}</title>
<style>{STYLE}</style>
</head>
<body>
<header><h1><bdi>{title}</bdi></h1></header>
<main>
<div id="stage">
<canvas id="canvas" tabindex="0" role="application" aria-roledescription="view of meshes" aria-label="The meshes. Arrow keys turn them, plus and minus come nearer and go farther, X reads the middle. All keys are listed under Keys." aria-describedby="live"></canvas>
<div id="names" aria-hidden="true"></div>
<div id="border" aria-hidden="true" hidden></div>
<button id="leave" type="button" hidden>Leave full screen</button>
<div id="cross" hidden></div>
<p id="loading" hidden>Loading pictures</p>
<svg id="axes" viewBox="-36 -36 72 72" aria-hidden="true"></svg>
<div id="length-of" aria-hidden="true" hidden></div>
<details id="hints"><summary>Hints</summary><ul><li>Drag: turn. With Shift: move.</li><li>Wheel or two fingers: zoom.</li><li>Click: pin values. Twice: centre there.</li><li>Click the picture, then F: show all of it.</li></ul></details>
</div>
<div id="bar" role="img" hidden><div id="quantity"></div><div id="unit"></div><div id="scale"><div id="above"></div><div id="ramp"></div><div id="below"></div><div id="ticks"></div></div><ul id="swatches" hidden></ul></div>
<div id="problem" role="alert" hidden><p>The picture needs WebGL 2, which this browser does not have or has switched off.</p></div>
<noscript><p>The picture needs JavaScript. Nothing is loaded from anywhere.</p></noscript>
</main>
<aside aria-label="Settings and report">
<details open><summary>Under the pointer</summary><div class="inside" id="values" tabindex="0" role="region" aria-label="Values under the pointer"><p id="pinned" class="note" hidden>Pinned; Esc lets go</p><dl id="picked"></dl><p id="unpicked" class="note">Point at the surface, click to pin its values, or press X to read the middle of the picture.</p></div></details>
<div id="controls"></div>
<details open><summary>Counts</summary><div class="inside scroll" id="counts" tabindex="0" role="region" aria-label="Counts"></div></details>
<div id="facts"></div>
</aside>
<p id="live" class="hidden" aria-live="polite"></p>
<script type="application/json" id="page">{description}</script>
{data}<script>{VIEWER}</script>
</body>
</html>
"#
    )
}

/// The identifier of a script or a style in a content security policy.
fn hash(text: &str) -> String {
    format!("sha256-{}", STANDARD.encode(Sha256::digest(text.as_bytes())))
}

#[cfg(test)]
mod tests {
    use super::{STYLE, VIEWER};

    /// Otherwise the element would end early, or the hash in the policy would not match.
    #[test]
    fn script_and_style_can_stand_in_a_page() {
        for text in [STYLE, VIEWER] {
            assert!(!text.contains("</") && !text.contains("<!--") && !text.contains('\r'));
            assert!(!text.contains("http:") || text.matches("http:").count() == 1);
        }
        // The only address is the namespace of SVG.
        assert!(VIEWER.contains("'http://www.w3.org/2000/svg'"));
        for forbidden in
            ["innerHTML", "outerHTML", "insertAdjacentHTML", "eval(", "fetch(", "document.write"]
        {
            assert!(!VIEWER.contains(forbidden), "{forbidden}");
        }
    }
}
