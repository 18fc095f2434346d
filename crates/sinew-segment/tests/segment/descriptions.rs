//! Devices from TOML tables and ESI files: what is read, and one precise error where it cannot be.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::wire;

use proptest::prelude::*;
use sinew_segment::{
    Access, DataType, DescriptionFile, Device, DeviceDescription, DeviceSettings, Direction, ObjectCode,
    PdoMappable, Profile, builtin,
};
use wire::Wire;

/// An ESI file in the manner of drive vendors: dictionary with data types, an array, a record, PDOs.
const ESI: &str = include_str!("esi/drive.xml");

#[test]
fn an_esi_file_gives_identity_pdos_and_objects() {
    let device = DeviceDescription::from_esi("drive.xml", ESI, Some(0x1234), None).unwrap();
    assert_eq!(
        (device.identity.vendor, device.identity.product, device.identity.revision),
        (0x777, 0x1234, 0x0002_0001)
    );
    assert_eq!((device.name.as_str(), device.title.as_str()), ("DRV-9", "Nine drive"));
    assert_eq!(device.profile, Profile::Drive);
    assert_eq!(device.mailbox.map(|mailbox| (mailbox.information, mailbox.mapping)), Some((true, false)));
    assert!(device.clock.is_some_and(|clock| clock.sync));
    assert_eq!(device.default_length(Direction::Outputs), 7);
    assert_eq!(device.default_length(Direction::Inputs), 7);
    let entry = |index, subindex| device.entry(index, subindex).unwrap();
    assert_eq!((entry(0x6040, 0).data_type, entry(0x6040, 0).pdo), (DataType::U16, PdoMappable::Outputs));
    assert_eq!(entry(0x6065, 0).value, [0x10, 0x27, 0, 0]);
    assert_eq!(entry(0x1008, 0).value, b"DRV-9");
    assert_eq!((entry(0x607d, 1).data_type, entry(0x607d, 2).data_type), (DataType::I32, DataType::I32));
    assert_eq!(entry(0x607d, 2).value, [0xff, 0xff, 0xff, 0x7f]);
    assert_eq!(entry(0x60c2, 2).access, Access::WriteInPreOp);
    // Not in the dictionary, only in a PDO.
    assert_eq!((entry(0x60fd, 0).bits, entry(0x60fd, 0).pdo), (1, PdoMappable::Inputs));
    let array = device.objects.iter().find(|object| object.index == 0x607d).unwrap();
    assert_eq!(array.code, ObjectCode::Array);
}

#[test]
fn a_device_from_an_esi_file_runs() {
    let device = DeviceDescription::from_esi("drive.xml", ESI, Some(0x1234), None).unwrap();
    let mut wire = Wire::new(&[device]);
    wire.drive_to_pre_op(0);
    wire.sync_manager(0, 2, 0x1200, 7, 0x64);
    wire.sync_manager(0, 3, 0x1800, 7, 0x20);
    assert_eq!(wire.request(0, 4), (4, 0));
    wire.write(0, 0x1200, &[6, 0, 0, 0, 0, 0, 9]);
    assert_eq!(wire.request(0, 8), (8, 0));
    wire.write(0, 0x1200, &[6, 0, 0, 0, 0, 0, 9]);
    wire.wait_ms(1);
    assert_eq!(wire.read(0, 0x1800, 7)[..2], [0x31, 0x02], "ready to switch on");
    assert_eq!(wire.upload(0, 0x6065, 0), Ok(vec![0x10, 0x27, 0, 0]));
}

#[test]
fn an_esi_file_that_is_none_gives_one_error_with_its_line() {
    let broken = |from: &str, to: &str| {
        let text = ESI.replace(from, to);
        assert_ne!(text, ESI, "{from}");
        DeviceDescription::from_esi("drive.xml", &text, Some(0x1234), None).unwrap_err().to_string()
    };
    for (from, to, expected) in [
        ("</EtherCATInfo>", "", "drive.xml:"),
        ("<Id>#x777</Id>", "<Id>seven</Id>", "drive.xml:5: Id: `seven`, expected a number"),
        ("<Id>#x777</Id>", "", "expected an element <Id>"),
        (">Outputs</Sm>", ">Output</Sm>", "`Output`, expected MBoxOut, MBoxIn, Outputs or Inputs"),
        ("<Type>UDINT</Type><BitSize>32</BitSize>", "<Type>QUAD</Type>", "unknown data type `QUAD`"),
        ("<BitLen>32</BitLen>", "<BitLen>16</BitLen>", "is not mappable"),
        (
            "<DefaultData>10270000</DefaultData>",
            "<DefaultData>1027000000</DefaultData>",
            "5 octets in 32 bits",
        ),
        ("<Index>#x1600</Index>", "<Index>#x1a00</Index>", "expected an index from 0x1600"),
    ] {
        let error = broken(from, to);
        assert!(error.contains(expected), "{error}");
    }
    let whole = DeviceDescription::from_esi("x", "<robot/>", None, None).unwrap_err().to_string();
    assert!(whole.contains("x:1") && whole.contains("EtherCATInfo"), "{whole}");
    let ambiguous = DeviceDescription::from_esi("drive.xml", ESI, None, None).unwrap_err().to_string();
    assert!(ambiguous.contains("0x1234, 0x99"), "{ambiguous}");
    let older = DeviceDescription::from_esi("drive.xml", ESI, Some(0x1234), Some(0x0001_0000)).unwrap();
    assert_eq!(older.name, "DRV-9-OLD");
    assert!(DeviceDescription::from_esi("drive.xml", ESI, Some(5), None).is_err());
}

#[test]
fn a_file_of_either_kind_names_its_devices() {
    let table = DescriptionFile::read("drive.toml", builtin::DRIVE_TOML.as_bytes()).unwrap();
    assert_eq!(table.identities(), [builtin::drive().identity]);
    assert_eq!(table.describe(0, 0).unwrap(), builtin::drive());
    // As vendors write it: with a byte order mark, or with umlauts in ISO 8859-1.
    let marked = [b"\xef\xbb\xbf", ESI.as_bytes()].concat();
    let latin: Vec<u8> = ESI
        .replace("UTF-8", "ISO8859-1")
        .replace("Nine drive", "Nine dr\u{ef}ve")
        .chars()
        .map(|c| c as u8)
        .collect();
    for (content, title) in [(marked, "Nine drive"), (latin, "Nine dr\u{ef}ve")] {
        let file = DescriptionFile::read("drive.xml", &content).unwrap();
        let devices: Vec<_> =
            file.identities().iter().map(|of| (of.vendor, of.product, of.revision)).collect();
        assert_eq!(devices, [(0x777, 0x1234, 0x1_0000), (0x777, 0x99, 1), (0x777, 0x1234, 0x2_0001)]);
        assert_eq!(file.describe(0x1234, 0x2_0001).unwrap().title, title);
        assert!(file.describe(0x1234, 5).is_err());
    }
    for (content, expected) in [
        (b"<robot/>".as_slice(), "x:1: robot: expected the root element <EtherCATInfo>"),
        (b"", "x:1: "),
        (b"a = 1\n\xff", "x:2: text: not UTF-8"),
        (b"<EtherCATInfo><Vendor><Id>1</Id></Vendor></EtherCATInfo>", "at least one <Device>"),
    ] {
        let error = DescriptionFile::read("x", content).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_wrong_table_gives_one_error_with_line_and_field() {
    let read = |text: &str| DeviceDescription::from_toml("drive.toml", text).unwrap_err().to_string();
    for (from, to, line, expected) in [
        ("name = \"Controlword\"", "nam = \"Controlword\"", "nam = \"Controlword\"", "unknown field `nam`"),
        ("limits = [0, 6]", "limits = [6, 0]", "index = 0x605a", "limits 6 to 0"),
        ("[[0x6040, 0, 16], [0x6071", "[[0x6040, 0, 8], [0x6071", "index = 0x1600", "object.0x6040 of 16"),
        (
            "[[0x6040, 0, 16], [0x6071",
            "[[0x7000, 0, 16], [0x6071",
            "index = 0x1600",
            "0x7000:0 is not in the dictionary",
        ),
        (
            "value = 0x0002_0192",
            "value = 0x1_0000_0000",
            "index = 0x1000",
            "4294967296, expected 0 to 4294967295",
        ),
        ("value = 0x0002_0192", "value = \"drive\"", "index = 0x1000", "is no value of the type U32"),
        ("start = 0x1000", "start = 0x0800", "", "0x0800 + 256, expected within 0x1000..0x3000"),
        ("kind = \"mailbox-in\"", "kind = \"inputs\"", "", "0 of MailboxIn, expected 1"),
        ("vendor = 0x51e37", "vendor = -1", "vendor = -1", "-1"),
        ("index = 0x6041", "index = 0x6040", "index = 0x6040", "ascending order"),
    ] {
        let text = builtin::DRIVE_TOML.replacen(from, to, 1);
        assert_ne!(text, builtin::DRIVE_TOML, "{from}");
        let error = read(&text);
        let expected = expected.replace("object.0x6040 of 16", "object 0x6040:0 of 16 bits is not mappable");
        assert!(error.contains(&expected), "{error}\nexpected: {expected}");
        if !line.is_empty() {
            let number: usize = error.split(':').nth(1).unwrap().parse().unwrap();
            let shown: Vec<&str> = text.lines().skip(number.saturating_sub(2)).take(3).collect();
            assert!(shown.iter().any(|shown| shown.contains(line)), "{error}\nlines {shown:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Parts of a valid file in another order, repeated, left out or with other digits.
    #[test]
    fn a_damaged_file_gives_an_error_or_a_device(
        esi in any::<bool>(),
        damages in proptest::collection::vec((any::<proptest::sample::Index>(), 0..40_usize, "[0-9a-f#<>=,\\[\\]\"\n.-]{0,6}"), 1..4),
    ) {
        let mut text = if esi { ESI.to_owned() } else { builtin::DRIVE_TOML.to_owned() };
        for (place, length, other) in damages {
            let start = place.index(text.len());
            let end = (start + length).min(text.len());
            if text.is_char_boundary(start) && text.is_char_boundary(end) {
                text.replace_range(start..end, &other);
            }
        }
        let read = if esi {
            DeviceDescription::from_esi("file", &text, Some(0x1234), None)
        } else {
            DeviceDescription::from_toml("file", &text)
        };
        match read {
            Ok(description) => drop(Device::new(&description, DeviceSettings::default()).unwrap()),
            Err(error) => prop_assert!(error.line <= text.lines().count() + 1, "{error}"),
        }
    }
}

#[test]
fn settings_out_of_range_are_refused() {
    let settings = DeviceSettings { drift_ppb: 2_000_000, ..DeviceSettings::default() };
    let error = Device::new(&builtin::coupler(), settings).unwrap_err();
    assert_eq!(error.field, "settings.drift_ppb");
}
