//! Refused requests.

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde_json::json;

/// Reason why a request is refused, as a status and a sentence.
#[derive(Debug)]
pub struct Refused(pub StatusCode, pub String);

/// Answer in JSON, or a refusal.
pub type Answer<T> = Result<Json<T>, Refused>;

impl Refused {
    /// Refuses an invalid request (400).
    pub fn bad(reason: impl Into<String>) -> Self {
        Self(StatusCode::BAD_REQUEST, reason.into())
    }

    /// Refuses a request that conflicts with the present files or results (409).
    pub fn conflict(reason: impl Into<String>) -> Self {
        Self(StatusCode::CONFLICT, reason.into())
    }

    /// Refuses a request because of an I/O error at `path`: 404 if nothing is there, otherwise 500.
    pub fn system(path: &std::path::Path, error: &std::io::Error) -> Self {
        let status = match error.kind() {
            std::io::ErrorKind::NotFound => StatusCode::NOT_FOUND,
            _ => StatusCode::INTERNAL_SERVER_ERROR,
        };
        Self(status, format!("{}: {error}", path.display()))
    }
}

impl From<tokio::task::JoinError> for Refused {
    fn from(error: tokio::task::JoinError) -> Self {
        Self(StatusCode::INTERNAL_SERVER_ERROR, format!("the answer failed: {error}"))
    }
}

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        (self.0, Json(json!({ "error": self.1 }))).into_response()
    }
}

/// Runs `work`, which reads files or computes, on a thread for blocking work, so that the threads that answer requests
/// stay free.
///
/// # Errors
/// [`Refused`] of `work`, or if it panicked.
pub async fn aside<T: Send + 'static>(work: impl FnOnce() -> Result<T, Refused> + Send + 'static) -> Answer<T> {
    Ok(Json(tokio::task::spawn_blocking(work).await??))
}
