//! Runs whose data are a Parquet file: the same samples as from a CSV file; or, built without the
//! feature, which feature is missing.

use homepoint::campaign::file::CampaignFile;
use homepoint::campaign::load::{Campaign, LoadOptions};
use homepoint::diagnostic::{Diagnostics, Source};
use homepoint::model::Model;

use crate::folder::Folder;

const MODEL: &str = r#"
name  = "arm"
title = "arm"
[inputs]
arm_angle = { unit = "deg", signal = true, period = "360 deg" }
[parameters]
radius = { unit = "m", scope = "rig" }
[measurands]
horizontal = { value = 'arm_angle', kind = "angle", unit = "gon", sigma = "1 mgon" }
distance   = { value = 'radius', unit = "mm", sigma = "10 um" }
"#;

/// A campaign of one run with these data.
fn campaign(folder: &Folder, data: &str) -> CampaignFile {
    let text = format!("model = \"arm\"\n[[runs]]\nname = \"one\"\ndata = \"{data}\"\n");
    CampaignFile::parse(&folder.join("campaign.toml"), &text).unwrap()
}

fn load(folder: &Folder, data: &str, options: &LoadOptions) -> Result<Campaign, Diagnostics> {
    let model = Model::parse(Source::new("arm.toml", MODEL)).unwrap();
    campaign(folder, data).load(&model, options)
}

#[cfg(not(feature = "parquet"))]
#[test]
fn the_missing_feature_is_named() {
    let folder = Folder::new("no_parquet", &[]);
    std::fs::write(folder.join("one.parquet"), "PAR1").unwrap();
    let faults = load(&folder, "one.parquet", &LoadOptions::default()).unwrap_err();
    let first = faults.0[0].to_string();
    assert!(first.contains("built without the feature `parquet`"), "{first}");
    assert!(first.contains("campaign.toml:4:8"), "{first}");
}

#[cfg(feature = "parquet")]
mod with_the_feature {
    use std::fmt::Write as _;
    use std::sync::Arc;

    use parquet::basic::{Compression, ZstdLevel};
    use parquet::data_type::{ByteArrayType, DoubleType, FloatType, Int64Type};
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;

    use super::*;

    const ROWS: usize = 10_500;
    /// Rows of one group; not a multiple of anything that reading goes by.
    const GROUP: usize = 3_001;

    fn time(row: usize) -> f64 {
        row as f64 * 0.025
    }

    fn angle(row: usize) -> f64 {
        ((row * 7) % 360) as f64
    }

    fn horizontal(row: usize) -> Option<f64> {
        (row % 5 != 3).then(|| (row as f64).sin())
    }

    fn distance(row: usize) -> f32 {
        1000.0 + (row % 13) as f32
    }

    /// Writes the columns with an odd one beside them; `bad` is a row that gets no time, if any.
    fn write(folder: &Folder, name: &str, compression: Compression, bad: Option<usize>) {
        let schema = "message run {
            optional double time; required int64 arm_angle; required double arm_angle_rate;
            optional double horizontal; required float distance; optional binary note (UTF8); }";
        let schema = Arc::new(parse_message_type(schema).unwrap());
        // The parser does not take names with units.
        let mut fields = schema.get_fields().to_vec();
        let names = [
            "time [s]",
            "arm_angle [deg]",
            "arm_angle_rate [deg/s]",
            "horizontal [gon]",
            "distance [mm]",
        ];
        for (field, name) in fields.iter_mut().zip(names) {
            let made = parquet::schema::types::Type::primitive_type_builder(
                name,
                field.get_physical_type(),
            )
            .with_repetition(field.get_basic_info().repetition());
            *field = Arc::new(made.build().unwrap());
        }
        let schema = parquet::schema::types::Type::group_type_builder("run").with_fields(fields);
        let properties = WriterProperties::builder().set_compression(compression).build();
        let file = std::fs::File::create(folder.join(name)).unwrap();
        let schema = Arc::new(schema.build().unwrap());
        let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties)).unwrap();
        for begin in (0..ROWS).step_by(GROUP) {
            let rows = begin..ROWS.min(begin + GROUP);
            let optional = |value: &dyn Fn(usize) -> Option<f64>| {
                let all: Vec<Option<f64>> = rows.clone().map(value).collect();
                let levels: Vec<i16> = all.iter().map(|v| i16::from(v.is_some())).collect();
                (all.into_iter().flatten().collect::<Vec<f64>>(), levels)
            };
            let mut group = writer.next_row_group().unwrap();
            let (values, levels) = optional(&|row| (Some(row) != bad).then(|| time(row)));
            let mut column = group.next_column().unwrap().unwrap();
            column.typed::<DoubleType>().write_batch(&values, Some(&levels), None).unwrap();
            column.close().unwrap();
            let values: Vec<i64> = rows.clone().map(|row| angle(row) as i64).collect();
            let mut column = group.next_column().unwrap().unwrap();
            column.typed::<Int64Type>().write_batch(&values, None, None).unwrap();
            column.close().unwrap();
            let values = vec![280.0; rows.len()];
            let mut column = group.next_column().unwrap().unwrap();
            column.typed::<DoubleType>().write_batch(&values, None, None).unwrap();
            column.close().unwrap();
            let (values, levels) = optional(&horizontal);
            let mut column = group.next_column().unwrap().unwrap();
            column.typed::<DoubleType>().write_batch(&values, Some(&levels), None).unwrap();
            column.close().unwrap();
            let values: Vec<f32> = rows.clone().map(distance).collect();
            let mut column = group.next_column().unwrap().unwrap();
            column.typed::<FloatType>().write_batch(&values, None, None).unwrap();
            column.close().unwrap();
            let mut column = group.next_column().unwrap().unwrap();
            let levels = vec![0; rows.len()];
            column.typed::<ByteArrayType>().write_batch(&[], Some(&levels), None).unwrap();
            column.close().unwrap();
            group.close().unwrap();
        }
        writer.close().unwrap();
    }

    fn csv() -> String {
        let mut text = String::from(
            "time [s],arm_angle [deg],arm_angle_rate [deg/s],horizontal [gon],distance [mm]\n",
        );
        for row in 0..ROWS {
            let read = horizontal(row).map_or_else(String::new, |value| format!("{value:?}"));
            let (time, angle, distance) = (time(row), angle(row), distance(row));
            writeln!(text, "{time:?},{angle},280,{read},{distance:?}").unwrap();
        }
        text
    }

    #[test]
    fn a_parquet_file_gives_the_samples_of_a_csv_file() {
        let folder = Folder::new("parquet", &[]);
        std::fs::write(folder.join("one.csv"), csv()).unwrap();
        let expected = load(&folder, "one.csv", &LoadOptions::default()).unwrap();
        let expected = expected.runs[0].held();
        let ways = [
            ("plain.parquet", Compression::UNCOMPRESSED),
            ("snappy.parquet", Compression::SNAPPY),
            ("zstd.parquet", Compression::ZSTD(ZstdLevel::default())),
        ];
        for (name, compression) in ways {
            write(&folder, name, compression, None);
            for memory in [0, u64::MAX] {
                let options = LoadOptions { memory, ..LoadOptions::default() };
                let campaign = load(&folder, name, &options).unwrap();
                assert_eq!(campaign.runs[0].record.is_spilled(), memory == 0);
                let found = campaign.runs[0].held();
                let bits =
                    |column: &Vec<f64>| column.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&found.time), bits(&expected.time));
                for (one, other) in found.readings.iter().zip(&expected.readings) {
                    assert_eq!(bits(one), bits(other));
                }
                for order in 0..2 {
                    let at = |samples: &homepoint::campaign::Samples, i: usize| {
                        samples.inputs[0].at(i, samples.time[i], 0.01_f64, order).to_bits()
                    };
                    assert!((0..ROWS).all(|i| at(found, i) == at(expected, i)));
                }
                assert_eq!((found.rows[0], found.rows[ROWS - 1]), (1, ROWS));
            }
            let warnings = load(&folder, name, &LoadOptions::default()).unwrap().warnings;
            assert!(warnings[0].message.contains("`note` is not used"), "{warnings:?}");
        }
    }

    #[test]
    fn faults_of_parquet_files_are_told() {
        let folder = Folder::new("parquet_faults", &[]);
        write(&folder, "bad.parquet", Compression::SNAPPY, Some(4_000));
        let faults = load(&folder, "bad.parquet", &LoadOptions::default()).unwrap_err();
        assert!(faults.to_string().contains("the row has no time"), "{faults}");
        assert!(faults.to_string().contains("bad.parquet:4001:1"), "{faults}");
        let skip = LoadOptions { skip_bad_rows: true, ..LoadOptions::default() };
        let campaign = load(&folder, "bad.parquet", &skip).unwrap();
        assert_eq!(campaign.skipped.iter().map(|row| row.row).collect::<Vec<_>>(), [4_001]);
        assert_eq!(campaign.runs[0].record.len(), ROWS - 1);
        std::fs::write(folder.join("none.parquet"), "not at all").unwrap();
        for (file, words) in
            [("none.parquet", "is not a Parquet file"), ("absent.parquet", "does not exist")]
        {
            let faults = load(&folder, file, &LoadOptions::default()).unwrap_err();
            assert!(faults.to_string().contains(words), "{faults}");
        }
    }
}
