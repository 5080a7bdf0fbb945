//! Which addresses sources may come from: those of the public network, and networks that the service names.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};

/// A network: an address and the length of its prefix in bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Network {
    address: IpAddr,
    bits: u32,
}

impl Network {
    /// Parses `ADDRESS/BITS`, or one address.
    ///
    /// # Errors
    /// One line.
    pub fn new(text: &str) -> Result<Self, String> {
        let wrong = || format!("'{text}': expected ADDRESS/BITS");
        let (address, bits) = match text.split_once('/') {
            Some((address, bits)) => (address, Some(bits.parse::<u32>().map_err(|_| wrong())?)),
            None => (text, None),
        };
        let address: IpAddr = address.trim().parse().map_err(|_| wrong())?;
        let most = if address.is_ipv4() { 32 } else { 128 };
        let bits = bits.unwrap_or(most);
        if bits > most { Err(wrong()) } else { Ok(Self { address, bits }) }
    }

    /// True if an address is in it.
    #[must_use]
    pub fn contains(&self, address: IpAddr) -> bool {
        match (self.address, address) {
            (IpAddr::V4(own), IpAddr::V4(other)) => {
                let mask = u32::MAX.checked_shl(32 - self.bits).unwrap_or(0);
                u32::from(own) & mask == u32::from(other) & mask
            }
            (IpAddr::V6(own), IpAddr::V6(other)) => {
                let mask = u128::MAX.checked_shl(128 - self.bits).unwrap_or(0);
                u128::from(own) & mask == u128::from(other) & mask
            }
            _ => false,
        }
    }
}

/// True if a source may have this address: it is public, or in one of these networks.
#[must_use]
pub fn is_allowed(address: IpAddr, networks: &[Network]) -> bool {
    // An IPv4 address mapped into IPv6 is judged as the IPv4 address.
    let address = address.to_canonical();
    is_public(address) || networks.iter().any(|network| network.contains(address))
}

fn is_public(address: IpAddr) -> bool {
    match address {
        IpAddr::V4(address) => is_public_v4(address),
        IpAddr::V6(address) => is_public_v6(address),
    }
}

/// The special-purpose registry of IANA for IPv4.
fn is_public_v4(address: Ipv4Addr) -> bool {
    const SPECIAL: &[([u8; 4], u32)] = &[
        ([0, 0, 0, 0], 8),
        ([10, 0, 0, 0], 8),
        ([100, 64, 0, 0], 10),
        ([127, 0, 0, 0], 8),
        ([169, 254, 0, 0], 16),
        ([172, 16, 0, 0], 12),
        ([192, 0, 0, 0], 24),
        ([192, 0, 2, 0], 24),
        ([192, 31, 196, 0], 24),
        ([192, 52, 193, 0], 24),
        ([192, 88, 99, 0], 24),
        ([192, 168, 0, 0], 16),
        ([192, 175, 48, 0], 24),
        ([198, 18, 0, 0], 15),
        ([198, 51, 100, 0], 24),
        ([203, 0, 113, 0], 24),
        // Multicast, reserved, broadcast.
        ([224, 0, 0, 0], 3),
    ];
    !SPECIAL.iter().any(|&(network, bits)| {
        Network { address: IpAddr::V4(network.into()), bits }.contains(IpAddr::V4(address))
    })
}

/// Global unicast is 2000::/3; within it, the special ranges of IANA's registry, and those that carry an IPv4 address.
fn is_public_v6(address: Ipv6Addr) -> bool {
    const SPECIAL: &[([u16; 2], u32)] = &[
        // Protocol assignments with Teredo and ORCHID; documentation; 6to4; documentation; SRv6.
        ([0x2001, 0], 23),
        ([0x2001, 0xdb8], 32),
        ([0x2002, 0], 16),
        ([0x3fff, 0], 20),
        ([0x5f00, 0], 16),
    ];
    let global = u128::from(address) >> 125 == 1;
    let special = SPECIAL.iter().any(|&([a, b], bits)| {
        let network = Ipv6Addr::new(a, b, 0, 0, 0, 0, 0, 0);
        Network { address: network.into(), bits }.contains(address.into())
    });
    // ISATAP carries an IPv4 address at its end.
    let [.., a, b, _, _] = address.segments();
    let isatap = b == 0x5efe && a & !0x0200 == 0;
    global && !special && !isatap
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn private_addresses_are_refused_in_every_spelling() {
        for text in [
            "127.0.0.1",
            "0.0.0.0",
            "10.1.2.3",
            "100.64.0.1",
            "100.127.255.255",
            "169.254.169.254",
            "172.16.0.1",
            "172.31.255.255",
            "192.168.1.1",
            "192.0.0.8",
            "192.0.2.1",
            "198.18.0.1",
            "198.51.100.1",
            "203.0.113.1",
            "224.0.0.1",
            "239.255.255.255",
            "240.0.0.1",
            "255.255.255.255",
            "192.88.99.1",
            "::",
            "::1",
            "::ffff:127.0.0.1",
            "::ffff:10.0.0.1",
            "::127.0.0.1",
            "64:ff9b::7f00:1",
            "64:ff9b::808:808",
            "64:ff9b:1::1",
            "fc00::1",
            "fd12::1",
            "fe80::1",
            "fec0::1",
            "ff02::1",
            "2001:db8::1",
            "2002:7f00:1::",
            "2001::1",
            "100::1",
            "3fff::1",
            "5f00::1",
            "2a00::5efe:7f00:1",
            "2a00::200:5efe:a00:1",
        ] {
            assert!(!is_allowed(text.parse().unwrap(), &[]), "{text}");
        }
        for text in [
            "1.1.1.1",
            "8.8.8.8",
            "100.63.255.255",
            "100.128.0.0",
            "172.32.0.1",
            "192.169.0.1",
            "::ffff:8.8.8.8",
            "2606:4700:4700::1111",
            "2a00:1450::1",
        ] {
            assert!(is_allowed(text.parse().unwrap(), &[]), "{text}");
        }
    }

    #[test]
    fn named_networks_are_allowed() {
        let networks = ["127.0.0.0/8", "fd00::/8", "10.0.0.1"].map(|text| Network::new(text).unwrap());
        for text in ["127.9.9.9", "::ffff:127.0.0.1", "fd12::1", "10.0.0.1"] {
            assert!(is_allowed(text.parse().unwrap(), &networks), "{text}");
        }
        for text in ["10.0.0.2", "fc00::1", "::1"] {
            assert!(!is_allowed(text.parse().unwrap(), &networks), "{text}");
        }
        assert!(Network::new("0.0.0.0/0").unwrap().contains("9.9.9.9".parse().unwrap()));
        for wrong in ["", "x/3", "10.0.0.0/33", "::/129", "10.0.0.0/-1"] {
            assert!(Network::new(wrong).is_err(), "{wrong}");
        }
    }
}
