//! Who may see and command: requests by the host's own name, from its own page, off loopback with the token.

use axum::http::HeaderMap;
use axum::http::header::{AUTHORIZATION, HOST, ORIGIN, SEC_WEBSOCKET_PROTOCOL};
use std::net::SocketAddr;

/// Protocol of the stream, and the beginning of the one that carries a token: browsers cannot set headers of
/// a WebSocket.
pub(crate) const PROTOCOL: &str = "sinew.live.1";
const TOKEN_PROTOCOL: &str = "token.";

/// The rules of one server.
#[derive(Debug, Clone)]
pub(crate) struct Access {
    address: SocketAddr,
    /// Hexadecimal; none on loopback.
    token: Option<String>,
}

impl Access {
    /// For an address; with a token of 128 random bits where it is not loopback.
    pub(crate) fn new(address: SocketAddr) -> Result<Self, getrandom::Error> {
        let token = if address.ip().is_loopback() {
            None
        } else {
            let mut bytes = [0_u8; 16];
            getrandom::fill(&mut bytes)?;
            Some(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
        };
        Ok(Self { address, token })
    }

    pub(crate) fn token(&self) -> Option<&str> {
        self.token.as_deref()
    }

    /// Whether a request names this server and comes from no other page: names of others point here by DNS
    /// rebinding.
    pub(crate) fn is_own(&self, headers: &HeaderMap) -> bool {
        let Some(host) = headers.get(HOST).and_then(|host| host.to_str().ok()) else { return false };
        let named = self.is_named(host);
        let origin = match headers.get(ORIGIN) {
            None => true,
            Some(origin) => origin.to_str().is_ok_and(|origin| origin == format!("http://{host}")),
        };
        named && origin
    }

    /// Whether a `Host` is this server: its address, or the loopback's name; bound to all addresses, any
    /// number.
    fn is_named(&self, host: &str) -> bool {
        let port = self.address.port();
        let (name, given) = match host.rsplit_once(':') {
            Some((name, given)) if !given.ends_with(']') => (name, given.parse().ok()),
            _ => (host, Some(80)),
        };
        let ip = name.trim_start_matches('[').trim_end_matches(']').parse::<std::net::IpAddr>().ok();
        let own =
            if self.address.ip().is_unspecified() { ip.is_some() } else { ip == Some(self.address.ip()) };
        let loopback = self.address.ip().is_loopback() && name == "localhost";
        given == Some(port) && (own || loopback)
    }

    /// Whether a request may see and command: on loopback any, else one with the token in a header or a
    /// protocol.
    pub(crate) fn is_authorized(&self, headers: &HeaderMap) -> bool {
        let Some(token) = &self.token else { return true };
        let text = |name| headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default();
        let bearer = text(AUTHORIZATION).strip_prefix("Bearer ");
        let protocols = text(SEC_WEBSOCKET_PROTOCOL).split(',').map(str::trim);
        let given = protocols.filter_map(|protocol| protocol.strip_prefix(TOKEN_PROTOCOL)).chain(bearer);
        given.into_iter().any(|given| equal_in_constant_time(given, token))
    }
}

/// Whether a request names one host and at most one origin: of several, another program on its way may have
/// checked another one.
pub(crate) fn is_unambiguous(headers: &HeaderMap) -> bool {
    headers.get_all(HOST).iter().count() == 1 && headers.get_all(ORIGIN).iter().count() <= 1
}

/// Takes the same time wherever two texts of the same length differ.
fn equal_in_constant_time(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |differ, (a, b)| differ | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    fn headers(list: &[(axum::http::HeaderName, &str)]) -> HeaderMap {
        list.iter().map(|(name, value)| (name.clone(), HeaderValue::from_str(value).unwrap())).collect()
    }

    #[test]
    fn only_the_own_host_and_the_own_page_are_answered() {
        let access = Access::new("127.0.0.1:8080".parse().unwrap()).unwrap();
        let own = |host: &str, origin: Option<&str>| {
            let list: Vec<_> =
                [(HOST, host)].into_iter().chain(origin.map(|origin| (ORIGIN, origin))).collect();
            access.is_own(&headers(&list))
        };
        assert!(own("127.0.0.1:8080", None) && own("localhost:8080", Some("http://localhost:8080")));
        for (host, origin) in [
            ("evil.example:8080", None),
            ("127.0.0.1:8081", None),
            ("127.0.0.1", None),
            ("localhost.evil.example:8080", None),
            ("127.0.0.1:8080", Some("http://evil.example")),
            ("127.0.0.1:8080", Some("null")),
            ("127.0.0.1:8080", Some("https://127.0.0.1:8080")),
        ] {
            assert!(!own(host, origin), "{host} {origin:?}");
        }
        assert!(!access.is_own(&HeaderMap::new()));
        assert!(access.is_authorized(&HeaderMap::new()));
    }

    #[test]
    fn off_loopback_the_token_is_asked_for() {
        let access = Access::new("192.0.2.1:8080".parse().unwrap()).unwrap();
        let token = access.token().unwrap().to_owned();
        assert_eq!(token.len(), 32);
        let with = |name, value: &str| access.is_authorized(&headers(&[(name, value)]));
        assert!(with(AUTHORIZATION, &format!("Bearer {token}")));
        assert!(with(SEC_WEBSOCKET_PROTOCOL, &format!("{PROTOCOL}, token.{token}")));
        assert!(!access.is_authorized(&HeaderMap::new()));
        assert!(!with(AUTHORIZATION, &token) && !with(AUTHORIZATION, "Bearer "));
        assert!(!with(SEC_WEBSOCKET_PROTOCOL, &format!("token.{}", "0".repeat(32))));
    }
}
