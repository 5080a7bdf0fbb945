//! Clients behind proxies: the address that a proxy tells in `X-Forwarded-For`, if the operator trusts it.

use super::address::Network;
use axum::http::{HeaderMap, HeaderName};
use std::net::{IpAddr, SocketAddr};

const FORWARDED_FOR: HeaderName = HeaderName::from_static("x-forwarded-for");

/// The client of a request that came from a peer, which has no address on a socket of this machine: of the addresses that proxies have
/// added, the last one that is no trusted proxy. Addresses before it may be anybody's invention.
#[must_use]
pub fn client(peer: Option<IpAddr>, headers: &HeaderMap, proxies: &[Network]) -> Option<IpAddr> {
    let peer = peer.map(|peer| peer.to_canonical());
    let is_proxy = |address: IpAddr| proxies.iter().any(|network| network.contains(address));
    // A peer on the socket of a file is a proxy of the operator's.
    if proxies.is_empty() || peer.is_some_and(|peer| !is_proxy(peer)) {
        return peer;
    }
    let mut nearest = peer;
    for value in headers.get_all(FORWARDED_FOR).iter().rev() {
        for text in value.to_str().unwrap_or_default().rsplit(',') {
            let Some(address) = address(text.trim()) else { return nearest };
            nearest = Some(address);
            if !is_proxy(address) {
                return nearest;
            }
        }
    }
    nearest
}

/// An address, with or without a port.
fn address(text: &str) -> Option<IpAddr> {
    let alone = || text.trim_start_matches('[').trim_end_matches(']').parse();
    let address = text.parse::<SocketAddr>().map(|address| address.ip()).or_else(|_| alone());
    address.ok().map(|address: IpAddr| address.to_canonical())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(peer: Option<&str>, values: &[&str]) -> Option<String> {
        let proxies = ["10.0.0.0/8", "fd00::/8"].map(|text| Network::new(text).unwrap());
        let mut headers = HeaderMap::new();
        for value in values {
            headers.append(FORWARDED_FOR, value.parse().unwrap());
        }
        client(peer.map(|peer| peer.parse().unwrap()), &headers, &proxies).map(|address| address.to_string())
    }

    #[test]
    fn the_last_address_that_is_no_proxy_counts() {
        for (peer, values, told) in [
            (Some("10.0.0.1"), &["1.2.3.4"][..], Some("1.2.3.4")),
            (Some("::ffff:10.0.0.1"), &["6.6.6.6, 1.2.3.4, 10.0.0.2"], Some("1.2.3.4")),
            (Some("10.0.0.1"), &["6.6.6.6", "1.2.3.4:80,10.9.9.9"], Some("1.2.3.4")),
            (Some("fd00::1"), &["[2a00:1450::1]:443"], Some("2a00:1450::1")),
            (None, &["1.2.3.4"], Some("1.2.3.4")),
            // Nobody else is believed.
            (Some("9.9.9.9"), &["1.2.3.4"], Some("9.9.9.9")),
            // Text that is no address ends the search.
            (Some("10.0.0.1"), &["1.2.3.4, unknown"], Some("10.0.0.1")),
            (Some("10.0.0.1"), &["1.2.3.4, unknown, 10.0.0.7"], Some("10.0.0.7")),
            (Some("10.0.0.1"), &[""], Some("10.0.0.1")),
            (Some("10.0.0.1"), &[], Some("10.0.0.1")),
            (Some("10.0.0.1"), &["10.0.0.3"], Some("10.0.0.3")),
            (None, &[], None),
        ] {
            assert_eq!(of(peer, values).as_deref(), told, "{peer:?} {values:?}");
        }
        let mut headers = HeaderMap::new();
        headers.append(FORWARDED_FOR, "1.2.3.4".parse().unwrap());
        assert_eq!(client(None, &headers, &[]), None);
    }
}
