//! The page's files, `/scene`, `/history` and `/stream` over HTTP.

use crate::access::{PROTOCOL, is_unambiguous};
use crate::command::MAX_COMMAND;
use crate::connections::Connection;
use crate::show::Order;
use crate::viewer::{Shared, ViewerPlace, watch_source};
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Path, Request, State};
use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Extension, Router};
use std::sync::Arc;
use tokio::sync::oneshot;

pub(crate) fn router(shared: Arc<Shared>) -> Router {
    Router::new()
        .route("/", get(|| async { file("index.html") }))
        .route("/assets/{*path}", get(|Path(path): Path<String>| async move { file(&path) }))
        .route("/scene", get(scene))
        .route("/history", get(history))
        .route("/stream", get(stream))
        .layer(from_fn_with_state(Arc::clone(&shared), guard))
        .with_state(shared)
}

/// Requests by another name or from another page are refused, and those that name more than one.
async fn guard(
    State(shared): State<Arc<Shared>>,
    Extension(connection): Extension<Connection>,
    request: Request,
    next: Next,
) -> Response {
    connection.mark_asked();
    if !is_unambiguous(request.headers()) {
        let words = "A request names one Host and at most one Origin.";
        return (StatusCode::BAD_REQUEST, words).into_response();
    }
    if !shared.access.is_own(request.headers()) {
        let words = "This server answers requests for its own address from its own page only.";
        return (StatusCode::FORBIDDEN, words).into_response();
    }
    next.run(request).await
}

fn file(path: &str) -> Response {
    let Some(asset) = sinew_view::asset(path) else { return StatusCode::NOT_FOUND.into_response() };
    let headers = [
        (CONTENT_TYPE, asset.content_type),
        (CONTENT_SECURITY_POLICY, "default-src 'self'; frame-ancestors 'none'"),
        (CACHE_CONTROL, "no-cache"),
    ];
    (headers, asset.bytes).into_response()
}

async fn scene(State(shared): State<Arc<Shared>>, headers: HeaderMap) -> Response {
    if !shared.access.is_authorized(&headers) {
        return unauthorized();
    }
    let scene = Arc::clone(&shared.pictures.borrow().scene);
    ([(CONTENT_TYPE, "application/json"), (CACHE_CONTROL, "no-store")], scene.as_str().to_owned())
        .into_response()
}

/// The signals before now, where the source has them.
async fn history(State(shared): State<Arc<Shared>>, headers: HeaderMap) -> Response {
    if !shared.access.is_authorized(&headers) {
        return unauthorized();
    }
    let (sender, receiver) = oneshot::channel();
    if shared.orders.try_send(Order::History(sender)).is_err() {
        return StatusCode::SERVICE_UNAVAILABLE.into_response();
    }
    match receiver.await {
        Ok(Some(rows)) => {
            ([(CONTENT_TYPE, "application/octet-stream"), (CACHE_CONTROL, "no-store")], rows).into_response()
        }
        Ok(None) => StatusCode::NO_CONTENT.into_response(),
        Err(_) => StatusCode::SERVICE_UNAVAILABLE.into_response(),
    }
}

fn unauthorized() -> Response {
    let words = "The token is missing or wrong: open the address that the program printed, with what \
        stands behind the #.";
    (StatusCode::UNAUTHORIZED, words).into_response()
}

async fn stream(
    State(shared): State<Arc<Shared>>,
    Extension(connection): Extension<Connection>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    if !shared.access.is_authorized(&headers) {
        return unauthorized();
    }
    let Some(place) = ViewerPlace::take(&shared) else {
        return (StatusCode::SERVICE_UNAVAILABLE, "Too many pages are open.").into_response();
    };
    let upgrade = upgrade.protocols([PROTOCOL]).max_message_size(MAX_COMMAND).max_frame_size(MAX_COMMAND);
    upgrade.on_upgrade(move |socket| async move {
        connection.mark_stream();
        // A connection that ends needs no answer.
        let _ = watch_source(socket, &place.0).await;
    })
}
