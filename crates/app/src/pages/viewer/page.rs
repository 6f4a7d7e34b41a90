//! The page, built by npm from `viewer/` into `crates/app/viewer` and embedded.
//!
//! The server offers it as five routes with a content security policy in each answer. As one file it contains style, script and data, and a policy that allows
//! no connection.

use super::live::{LivePage, finished_progress};
use super::server::{Route, RouteBody};
use crate::pages::base64::base64;
use std::sync::Arc;

const PAGE: &str = include_str!("../../../viewer/index.html");
const STYLE: &str = include_str!("../../../viewer/viewer.css");
const SCRIPT: &str = include_str!("../../../viewer/viewer.js");

/// Content security policy of the page as one file: only its own script and style.
const SINGLE_FILE_POLICY: &str = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; \
style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'\">";

/// The page and its data as routes of a server.
#[must_use]
pub fn routes(package: Vec<u8>) -> Vec<Route> {
    routes_with(RouteBody::Fixed(package.into()), RouteBody::Fixed(finished_progress().into()))
}

/// The page and its changing data as routes of a server.
#[must_use]
pub fn live_routes(page: &Arc<LivePage>) -> Vec<Route> {
    routes_with(page.package_body(), page.progress_body())
}

fn routes_with(package: RouteBody, progress: RouteBody) -> Vec<Route> {
    let page = assemble([
        ("POLICY", ""),
        ("STYLE", "<link rel=\"stylesheet\" href=\"viewer.css\">"),
        ("DATA", ""),
        ("SCRIPT", "<script src=\"viewer.js\"></script>"),
    ]);
    let fixed = |text: &str| RouteBody::Fixed(Arc::from(text.as_bytes()));
    let route = |target, media_type, body| Route { target, media_type, body };
    vec![
        route("/", "text/html; charset=utf-8", fixed(&page)),
        route("/viewer.css", "text/css; charset=utf-8", fixed(STYLE)),
        route("/viewer.js", "text/javascript; charset=utf-8", fixed(SCRIPT)),
        route("/scene.bin", "application/octet-stream", package),
        route("/progress.json", "application/json", progress),
    ]
}

/// The page and its data in one file.
#[must_use]
pub fn single_file(package: &[u8]) -> String {
    let style = format!("<style>{STYLE}</style>");
    let data = format!("<script id=\"data\" type=\"text/plain\">{}</script>", base64(package));
    let script = format!("<script>{SCRIPT}</script>");
    assemble([("POLICY", SINGLE_FILE_POLICY), ("STYLE", &style), ("DATA", &data), ("SCRIPT", &script)])
}

/// The page with each placeholder `<!--NAME-->` replaced, in their order in the page.
fn assemble(parts: [(&str, &str); 4]) -> String {
    let mut out = String::with_capacity(PAGE.len() + parts.iter().map(|p| p.1.len()).sum::<usize>());
    let mut rest = PAGE;
    for (name, text) in parts {
        if let Some((before, after)) = rest.split_once(&format!("<!--{name}-->")) {
            out.push_str(before);
            out.push_str(text);
            rest = after;
        }
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_file_has_every_part_and_no_external_reference() {
        let file = single_file(b"data");
        for mark in ["POLICY", "STYLE", "DATA", "SCRIPT"] {
            assert_eq!(PAGE.matches(&format!("<!--{mark}-->")).count(), 1, "{mark}");
            assert!(!file.contains(&format!("<!--{mark}-->")), "{mark}");
        }
        assert!(file.contains(">ZGF0YQ==</script>") && file.contains("default-src 'none'"));
        assert_eq!(file.matches("</script>").count(), 2);
        for text in [PAGE, STYLE, SCRIPT] {
            assert!(!text.contains("http://") && !text.contains("https://") && !text.contains("url("));
        }
    }
}
