use super::*;
use sinew::random::Random;

/// Places of markers, in mm with a decimal, or not seen: `[times][markers]`.
type Seen = Vec<Vec<Option<[f64; 3]>>>;

fn seen(random: &mut Random) -> Seen {
    let markers = 1 + (random.unit() * 5.0) as usize;
    let mut place = || (random.unit() > 0.2).then(|| [0; 3].map(|_| (random.unit() * 2e4).round() / 10.0));
    (0..12).map(|_| (0..markers).map(|_| place()).collect()).collect()
}

fn name(marker: usize) -> String {
    format!("hand:m{marker}")
}

fn cells(place: &Option<[f64; 3]>, separator: char) -> String {
    let cells = place.map_or([const { String::new() }; 3], |x| x.map(|x| x.to_string()));
    cells.map(|cell| format!("{separator}{cell}")).concat()
}

fn trc(seen: &Seen) -> String {
    let (frames, markers) = (seen.len(), seen[0].len());
    let mut text = format!(
        "PathFileType\t4\t(X/Y/Z)\tseen.trc\r\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\t\
         OrigDataStartFrame\tOrigNumFrames\r\n  100.0\t\t100\t{frames}\t{markers}\tmm\t100\t1\t{frames}\r\nFrame#\tTime"
    );
    text += &(0..markers).map(|m| format!("\t{}\t\t", name(m))).collect::<String>();
    text += "\r\n\t";
    text += &(1..=markers).map(|m| format!("\tX{m}\tY{m}\tZ{m}")).collect::<String>();
    text += "\r\n\r\n";
    for (k, row) in seen.iter().enumerate() {
        let row: String = row.iter().map(|place| cells(place, '\t')).collect();
        text += &format!("{}\t{:.3}{row}\t\r\n", k + 1, 0.01 * k as f64);
    }
    text
}

fn motive(seen: &Seen) -> String {
    let markers = seen[0].len();
    let of = |cell: &dyn Fn(usize) -> String| {
        (0..markers).map(|m| format!(",{0},{0},{0}", cell(m))).collect::<String>()
    };
    let mut text = format!(
        "\u{feff}Format Version,1.23,Take Name,\"a, b\",Total Exported Frames,{},Rotation Type,Quaternion,Length Units,\
         Millimeters,Coordinate Space,Global\n\n",
        seen.len()
    );
    text += &format!(",Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body{}", of(&|_| "Marker".to_owned()));
    text += &format!("{}\n", ",Rigid Body Marker".repeat(3));
    text += &format!(",Name,plate,plate,plate,plate{},hand:m0,hand:m0,hand:m0\n", of(&name));
    text += &format!(",ID,1,1,1,1{},2,2,2\n", of(&|m| m.to_string()));
    text += &format!(",,Rotation,Rotation,Rotation,Rotation{}", of(&|_| "Position".to_owned()));
    text += &format!("{}\n", ",Position".repeat(3));
    text += &format!("Frame,Time (Seconds),X,Y,Z,W{}\n", ",X,Y,Z".repeat(markers + 1));
    for (k, row) in seen.iter().enumerate() {
        let row: String = row.iter().map(|place| cells(place, ',')).collect();
        text += &format!("{k},{:.6},0,0,0,1{row},1,2,3\n", 0.01 * k as f64);
    }
    text
}

fn table(seen: &Seen) -> String {
    let mut text = "time_s,marker,x_m,y_m,z_m\n".to_owned();
    for (m, k) in (0..seen[0].len()).flat_map(|m| (0..seen.len()).map(move |k| (m, k))) {
        if seen[k][m].is_some() {
            text += &format!("{:.4},{}{}\n", 0.01 * k as f64, name(m), cells(&seen[k][m], ','));
        }
    }
    text
}

#[test]
fn every_format_has_the_numbers_of_the_table() {
    let mut random = Random::new(1);
    for _ in 0..100 {
        let seen = seen(&mut random);
        let mut expected = of_text(&table(&seen)).unwrap().tracks;
        expected.retain(|track| !track.points.is_empty());
        for (text, unit) in [(trc(&seen), "mm"), (motive(&seen), "Millimeters")] {
            let Observed { unit: found, mut tracks } = of_text(&text).unwrap();
            tracks.retain(|track| !track.points.is_empty());
            assert_eq!(tracks, expected, "{text}");
            assert_eq!(found, Some((0.001, unit.to_owned())));
        }
    }
}

#[test]
fn damage_of_a_text_is_one_error_with_its_line_or_other_numbers_but_no_panic() {
    let mut random = Random::new(2);
    for write in [trc, motive, table] {
        let mut refused = 0;
        for _ in 0..2000 {
            let mut text = write(&seen(&mut random)).into_bytes();
            let mut place = |text: &[u8]| (random.unit() * text.len() as f64) as usize;
            for _ in 0..1 + place(&[0; 4]) {
                let at = place(&text);
                match place(&[0; 5]) {
                    0 => text[at] = place(&[0; 256]) as u8,
                    1 => text.insert(at, b"\t,\n\"x-.e"[place(&[0; 8])]),
                    2 => text.truncate(at.max(1)),
                    3 => drop(text.drain(at..(at + place(&[0; 60])).min(text.len()))),
                    _ => {
                        let copy = text[at..(at + place(&[0; 200])).min(text.len())].to_vec();
                        text.splice(at..at, copy);
                    }
                }
                if text.is_empty() {
                    break;
                }
            }
            if let Err(error) = of_text(&String::from_utf8_lossy(&text)) {
                let error = error.to_string();
                assert!(error.starts_with("line ") && error.contains("expected"), "{error}");
                refused += 1;
            }
        }
        assert!(refused > 1000, "{refused}");
    }
}

#[test]
fn what_is_wrong_is_named_with_line_value_and_expectation() {
    let seen = vec![vec![Some([1.5, 2.5, 3.5]), Some([4.0, 5.0, 6.0])]; 3];
    let cases = [
        (
            trc(&seen).replace("\tmm\t", "\tinch\t"),
            "line 3, column `Units`: expected m, cm or mm, got `inch`",
        ),
        (trc(&seen).replacen("\t3\t2\t", "\t4\t2\t", 1), "line 9: expected 4 rows by the header, got 3"),
        (trc(&seen).replacen("hand:m1", "", 1), "line 4: expected 2 markers by NumMarkers, got 1"),
        (trc(&seen).replacen("Z2", "Z3", 1), "line 5: expected Z2, got Z3"),
        (
            trc(&seen).replacen("2.5", "", 1),
            "line 7, column `hand:m0`: expected a finite number, got an empty cell",
        ),
        (
            trc(&seen).replacen("0.020", "0.010", 1),
            "line 9, column `Time`: expected increasing times, got 0.01",
        ),
        (motive(&seen).replace("1.23", "1.1"), "line 1, column `Format Version`: expected 1.2, got `1.1`"),
        (
            motive(&seen).replace("Global", "Local"),
            "line 1, column `Coordinate Space`: expected Global, got `Local`",
        ),
        (
            motive(&seen).replace("Millimeters", "Feet"),
            "line 1, column `Length Units`: expected m, cm or mm, got `Feet`",
        ),
        (motive(&seen).replacen("4,5,6", "4,5", 1), "line 8: expected 15 cells, got 14 of them"),
        (
            motive(&seen).replace(",Marker", ",Bone").replace(",Rigid Body,", ",Bone,"),
            "line 7: expected positions of type",
        ),
        (table(&seen).replacen("x_m", "x", 1), "line 1: expected a column `x_m`"),
    ];
    for (text, expected) in cases {
        let error = of_text(&text).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}\n{text}");
    }
}
