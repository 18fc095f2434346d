//! Process data of devices without a mailbox: the PDO categories of their EEPROM, ETG.2010.

use crate::cia402::Mapping;

/// First word of the categories.
const CATEGORIES: u16 = 0x40;
/// Categories of the inputs and the outputs, and the end.
const TX_PDO: u16 = 50;
const RX_PDO: u16 = 51;
const END: u16 = 0xffff;
/// Categories of a device, at most: the EEPROM is damaged where there are more.
const MAX_CATEGORIES: usize = 64;
/// A PDO without a sync manager is not part of the process data by default.
const NOT_ASSIGNED: u8 = 0xff;

/// Outputs and inputs from the words of an EEPROM; `read` gives octets from a word address on.
pub(super) async fn mappings<E>(
    mut read: impl AsyncFnMut(u16, &mut [u8]) -> Result<(), E>,
) -> Result<[Mapping; 2], E> {
    let mut mappings = [Mapping::default(), Mapping::default()];
    let mut word = CATEGORIES;
    for _ in 0..MAX_CATEGORIES {
        let mut header = [0_u8; 4];
        read(word, &mut header).await?;
        let [kind, words] = [[header[0], header[1]], [header[2], header[3]]].map(u16::from_le_bytes);
        let place = match kind {
            END => break,
            RX_PDO => Some(0),
            TX_PDO => Some(1),
            _ => None,
        };
        if let Some(place) = place {
            let mut data = vec![0_u8; 2 * usize::from(words)];
            read(word + 2, &mut data).await?;
            push_entries(&mut mappings[place], &data);
        }
        let Some(next) = word.checked_add(2).and_then(|next| next.checked_add(words)) else { break };
        word = next;
    }
    Ok(mappings)
}

/// The entries of all assigned PDOs of a category.
fn push_entries(mapping: &mut Mapping, mut data: &[u8]) {
    while let Some((pdo, rest)) = data.split_at_checked(8) {
        let (entries, assigned) = (usize::from(pdo[2]), pdo[3] != NOT_ASSIGNED);
        let Some((listed, behind)) = rest.split_at_checked(8 * entries) else { return };
        for entry in listed.chunks_exact(8).filter(|_| assigned) {
            let index = u32::from(u16::from_le_bytes([entry[0], entry[1]]));
            mapping.push((index << 16) | (u32::from(entry[2]) << 8) | u32::from(entry[5]));
        }
        data = behind;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cia402::ObjectAddress;
    use core::pin::pin;
    use core::task::{Context, Poll, Waker};

    fn of(words: &[u16]) -> [Mapping; 2] {
        let future = mappings(async |word: u16, buffer: &mut [u8]| {
            for (k, octet) in buffer.iter_mut().enumerate() {
                let at = usize::from(word - CATEGORIES) + k / 2;
                *octet = words.get(at).copied().unwrap_or(END).to_le_bytes()[k % 2];
            }
            Ok::<(), ()>(())
        });
        match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(Ok(mappings)) => mappings,
            _ => panic!("nothing to wait for"),
        }
    }

    #[test]
    fn the_assigned_pdos_of_both_directions_are_read_and_damage_ends_the_list() {
        // General category first, which is passed over; a TxPDO with two entries, one that is not assigned.
        let tx = [
            TX_PDO, 20, //
            0x1a00, 0x0302, 0, 0, 0x6000, 0x0001, 0x1000, 0, 0x6000, 0x0002, 0x2000,
            0, // two entries, sync manager 3
            0x1a01, 0xff01, 0, 0, 0x7000, 0x0001, 0x0800, 0, // not assigned
        ];
        let words: Vec<u16> = [30, 1, 0x1234].into_iter().chain(tx).chain([END]).collect();
        let [outputs, inputs] = of(&words);
        assert_eq!((outputs.length(), inputs.length()), (0, 6));
        let value = ObjectAddress { index: 0x6000, subindex: 2 };
        assert!(inputs.find(value, &[4]).is_some());
        // Cut anywhere, with the erased words of an EEPROM behind: at most the three entries, whose lengths
        // may be erased.
        for cut in 0..words.len() {
            let [_, inputs] = of(&words[..cut]);
            assert!(inputs.length() <= (3 * usize::from(u8::MAX)).div_ceil(8));
        }
        // Categories without an end.
        let endless: Vec<u16> = [30, 0].into_iter().cycle().take(1000).collect();
        assert_eq!(of(&endless)[1].length(), 0);
    }
}
