//! Access control: only pages of this server, opened with its token, on this computer, may send requests.
//!
//! Another site in the same browser can send requests to 127.0.0.1, and a name of its own may resolve to that address. The token,
//! which such a site does not know, the `Host` and the `Origin` of every request are checked for this reason.

use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, COOKIE, HOST, LOCATION, ORIGIN, REFERRER_POLICY, SET_COOKIE,
    X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use slipgrid_io::disk::hexadecimal;

use crate::error::Refused;

/// Content security policy of the page, which may load its own scripts, styles, pictures and frames.
const PAGE_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; \
    img-src 'self' data: blob:; connect-src 'self'; frame-src 'self'; frame-ancestors 'none'; form-action 'none'; base-uri 'none'";
/// Content security policy of a file shown in a frame, which may run its own scripts without access to this server.
const FILE_POLICY: &str = "sandbox allow-scripts allow-downloads allow-popups; default-src 'none'; \
    script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: 'self'; frame-ancestors 'self'; base-uri 'none'";
/// Number of random bytes of a token, too many to guess.
const TOKEN_BYTES: usize = 24;

/// Port of a server, token that opens its page, and key in the addresses of files.
pub struct Guard {
    port: u16,
    token: String,
    files_key: String,
}

impl Guard {
    /// Draws a token and a key of files for the server at `port`.
    ///
    /// # Errors
    /// Error of the system without a source of random numbers.
    pub fn new(port: u16) -> std::io::Result<Self> {
        Ok(Self { port, token: drawn()?, files_key: drawn()? })
    }

    /// Address that opens the page, with the token.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/?token={}", self.port, self.token)
    }

    /// Beginning of the addresses of files, with their key.
    pub fn files_at(&self) -> String {
        format!("/files/{}/", self.files_key)
    }

    fn cookie_name(&self) -> String {
        // Cookies of all ports of a host are one jar.
        format!("slipgrid_{}", self.port)
    }

    fn is_own_host(&self, host: &str) -> bool {
        host == format!("127.0.0.1:{}", self.port) || host == format!("localhost:{}", self.port)
    }

    /// Refuses requests whose `Host` is not this server, and requests from pages of other sites except links that open
    /// this page.
    fn check(&self, headers: &HeaderMap) -> Result<(), Refused> {
        let refused = |reason: &str| Err(Refused(StatusCode::FORBIDDEN, reason.to_owned()));
        if !text(headers, HOST).is_some_and(|host| self.is_own_host(host)) {
            return refused("this server answers at 127.0.0.1 only");
        }
        let is_foreign = |origin: &str| !origin.strip_prefix("http://").is_some_and(|host| self.is_own_host(host));
        if text(headers, ORIGIN).is_some_and(is_foreign) {
            return refused("another site may not ask this server");
        }
        let site = text(headers, HeaderName::from_static("sec-fetch-site"));
        let mode = text(headers, HeaderName::from_static("sec-fetch-mode"));
        // A link on another page may open the address with the token; nothing else comes from outside.
        if site.is_some_and(|site| site == "cross-site" || site == "same-site") && mode != Some("navigate") {
            return refused("another site may not ask this server");
        }
        Ok(())
    }

    fn has_token(&self, headers: &HeaderMap) -> bool {
        let expected = format!("{}={}", self.cookie_name(), self.token);
        let cookies = headers.get_all(COOKIE).into_iter().filter_map(|value| value.to_str().ok());
        cookies.flat_map(|value| value.split(';')).any(|cookie| is_same(cookie.trim(), &expected))
    }
}

fn text(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    headers.get(name)?.to_str().ok()
}

fn drawn() -> std::io::Result<String> {
    let mut bytes = [0; TOKEN_BYTES];
    getrandom::fill(&mut bytes).map_err(std::io::Error::other)?;
    Ok(hexadecimal(&bytes))
}

/// Compares two texts in a time that does not depend on where they differ.
fn is_same(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |all, (a, b)| all | (a ^ b)) == 0
}

/// Passes on requests of the server's own page and refuses others; exchanges the token in the address for a cookie.
pub async fn admit(State(guard): State<Arc<Guard>>, request: Request, next: Next) -> Response {
    if let Err(refused) = guard.check(request.headers()) {
        return refused.into_response();
    }
    let given = request.uri().query().and_then(|query| query.strip_prefix("token="));
    if request.uri().path() == "/" && given.is_some_and(|given| is_same(given, &guard.token)) {
        let cookie = format!("{}={}; HttpOnly; SameSite=Strict; Path=/", guard.cookie_name(), guard.token);
        // The address without the token: it is not kept in the history, and a reload works.
        return (StatusCode::SEE_OTHER, [(SET_COOKIE, cookie), (LOCATION, "/".to_owned())]).into_response();
    }
    if !guard.has_token(request.headers()) {
        let reason = "open the address that `slipgrid studio` printed: it holds a token";
        return Refused(StatusCode::UNAUTHORIZED, reason.to_owned()).into_response();
    }
    protected(next.run(request).await, PAGE_POLICY)
}

/// Passes on requests for files whose address has the key of files, and refuses others.
pub async fn admit_reading(State(guard): State<Arc<Guard>>, request: Request, next: Next) -> Response {
    if !text(request.headers(), HOST).is_some_and(|host| guard.is_own_host(host)) {
        return Refused(StatusCode::FORBIDDEN, "this server answers at 127.0.0.1 only".to_owned()).into_response();
    }
    let key = request.uri().path().split('/').nth(2).unwrap_or_default();
    if !is_same(key, &guard.files_key) {
        return Refused(StatusCode::UNAUTHORIZED, "the address of the file has no valid key".to_owned())
            .into_response();
    }
    protected(next.run(request).await, FILE_POLICY)
}

/// Adds headers that limit the rights of a document in the browser, with the content security policy `policy`.
fn protected(mut response: Response, policy: &'static str) -> Response {
    let headers = response.headers_mut();
    headers.insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(policy));
    headers.insert(X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    headers.insert(X_FRAME_OPTIONS, HeaderValue::from_static("SAMEORIGIN"));
    headers.insert("cross-origin-resource-policy", HeaderValue::from_static("same-origin"));
    headers.entry(CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    response
}
