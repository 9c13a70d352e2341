//! Compares a log with a new simulation of its run, sample by sample while both advance, so memory does not grow with
//! the log.
//!
//! Samples are compared in order of time, every value of every column bit for bit; events are compared for each contact
//! in order of time. Topics without messages are missing data of the log and differ from the new run.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::io::{self, Read, Seek};

use serde::Serialize;

use super::messages::stamp_ns;
use super::metadata::{RunInfo, metadata};
use super::reader::{LogSink, ReadError, SecondPass, scan};
use phalanx_core::trace::{Channel, Event, RequiredData, Sample, Schema, Sink, SinkError};

/// Metadata entries that identify the program that wrote a log; they may differ.
const VERSIONS: [&str; 4] = ["phalanx_version", "mcap_version", "libm_version", "rapier_version"];

/// Range of the log to compare.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComparisonOptions {
    /// Data at and after this log time are not compared, because an interrupt ended the run there.
    pub before_ns: Option<u64>,
    /// Whether the log contains the end of its run. If it does, the new run must end at the same point.
    pub has_run_end: bool,
}

/// Result of a comparison.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Verification {
    /// Number of samples at times that both runs have.
    pub samples_compared: u64,
    pub samples_differing: u64,
    pub samples_only_in_log: u64,
    pub samples_only_in_new_run: u64,
    /// Number of samples that are not compared, at the end of an interrupted run.
    pub samples_not_compared: u64,
    pub events_compared: u64,
    pub events_differing: u64,
    pub events_only_in_log: u64,
    pub events_only_in_new_run: u64,
    /// Time of the last sample that was compared.
    pub compared_to_s: Option<f64>,
    pub first_difference: Option<Difference>,
    /// For each column that differs, the largest difference.
    pub quantities: Vec<QuantityTally>,
    /// Metadata entries that differ.
    pub metadata: Vec<EntryDifference>,
}

/// A difference of one quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    pub time_s: f64,
    /// Name of the column, or description of the event.
    pub quantity: String,
    /// Value in the log; null if absent.
    pub log: Option<f64>,
    /// Value in the new run; null if absent.
    pub new_run: Option<f64>,
    /// Absolute difference in the unit of the quantity; null if a value is absent.
    pub absolute: Option<f64>,
    /// Difference relative to the larger of the two values; null if a value is absent.
    pub relative: Option<f64>,
}

/// A column in which samples differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QuantityTally {
    /// Number of samples that differ in this column.
    pub samples: u64,
    #[serde(flatten)]
    pub largest: Difference,
}

/// A metadata entry that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EntryDifference {
    pub key: String,
    pub log: Option<String>,
    pub new_run: Option<String>,
}

impl Verification {
    /// Whether all compared data are identical, bit for bit.
    pub fn is_same(&self) -> bool {
        let differing = self.samples_differing + self.samples_only_in_log + self.samples_only_in_new_run;
        differing + self.events_differing + self.events_only_in_log + self.events_only_in_new_run == 0
            && self.metadata.iter().all(|entry| VERSIONS.contains(&entry.key.as_str()))
    }

    fn record(&mut self, difference: Difference) {
        if self.first_difference.as_ref().is_none_or(|first| difference.time_s < first.time_s) {
            self.first_difference = Some(difference);
        }
    }
}

impl Difference {
    fn new(time_s: f64, quantity: &str, log: Option<f64>, new_run: Option<f64>) -> Self {
        let [log, new_run] = [log, new_run].map(|value| value.filter(|value| value.is_finite()));
        let pair = log.zip(new_run);
        let absolute = pair.map(|(log, new_run)| (log - new_run).abs());
        let scale = pair.map_or(0.0, |(log, new_run)| log.abs().max(new_run.abs()));
        let relative = absolute.filter(|_| scale > 0.0).map(|absolute| absolute / scale);
        Difference { time_s, quantity: quantity.to_string(), log, new_run, absolute, relative }
    }
}

/// A [`Sink`] of the new run that compares its samples and events with those of a log.
pub struct LogComparison<R> {
    reader: SecondPass<R>,
    is_log_read: bool,
    options: ComparisonOptions,
    log: Contents,
    new_events: Vec<StampedEvent>,
    /// Log time that the new run has reached, ns.
    clock_ns: u64,
    /// Channels of the new run that the log has too: in the new run and in the log.
    channels: Vec<[Channel; 2]>,
    /// For each contact of the new run, its index in the log.
    contacts: Vec<Option<usize>>,
    tallies: Vec<Option<QuantityTally>>,
    result: Verification,
}

/// An event with its log time in ns. The class of a run depends on the order of samples and events, hence on both times.
type StampedEvent = (Event, u64);

/// Contents of the log that are not compared yet.
#[derive(Default)]
struct Contents {
    samples: VecDeque<Sample>,
    events: Vec<StampedEvent>,
    /// Log time of the group being read, ns.
    time_ns: u64,
}

impl LogSink for Contents {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.samples.push_back(sample.clone());
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.events.push((*event, self.time_ns));
        Ok(())
    }
}

impl<R: Read + Seek> LogComparison<R> {
    /// Opens a log to compare it with the run `new_run`.
    ///
    /// # Errors
    /// Returns [`ReadError`] if the log cannot be read.
    pub fn new(mut source: R, new_run: &RunInfo<'_>, options: ComparisonOptions) -> Result<Self, ReadError> {
        let scan = scan(&mut source, false)?;
        let (log, new) = (scan.summary.metadata.clone(), metadata(new_run));
        let mut keys: Vec<&String> = log.keys().chain(new.keys()).collect();
        keys.sort();
        keys.dedup();
        let entry = |key: &String| {
            let [log, new_run] = [&log, &new].map(|entries| entries.get(key).cloned());
            EntryDifference { key: key.clone(), log, new_run }
        };
        let differing = keys.into_iter().map(entry).filter(|entry| entry.log != entry.new_run).collect();
        let reader = SecondPass::new(source, scan)?;
        let (schema, new_schema) = (reader.assembler.schema(), Schema::from_scene(new_run.scene));
        let mut new_channels: HashMap<String, Channel> =
            new_schema.channels().into_iter().map(|channel| (channel.name.clone(), channel)).collect();
        let pair = |channel: Channel| Some([new_channels.remove(&channel.name)?, channel]);
        let channels: Vec<[Channel; 2]> = schema.channels().into_iter().filter_map(pair).collect();
        let in_log: HashMap<&str, usize> =
            schema.contacts.iter().enumerate().map(|(index, contact)| (contact.name.as_str(), index)).collect();
        let contacts = new_schema.contacts.iter().map(|contact| in_log.get(contact.name.as_str()).copied()).collect();
        Ok(LogComparison {
            contacts,
            tallies: vec![None; channels.len()],
            channels,
            reader,
            is_log_read: false,
            options,
            log: Contents::default(),
            new_events: Vec::new(),
            clock_ns: 0,
            result: Verification { metadata: differing, ..Verification::default() },
        })
    }

    /// Returns the result after the end of the new run. `log_end` and `new_end` describe how each run ended.
    ///
    /// # Errors
    /// Returns [`ReadError`] if the log cannot be read.
    pub fn finish(mut self, log_end: Option<String>, new_end: String) -> Result<Verification, ReadError> {
        while let Some(sample) = self.next_sample()? {
            self.count_extra(sample.time_s, true);
        }
        let mut pairs: BTreeMap<(usize, bool), [Vec<StampedEvent>; 2]> = BTreeMap::new();
        for (side, events) in [&self.log.events, &self.new_events].into_iter().enumerate() {
            for &(event, time_ns) in events.iter().filter(|(event, _)| self.is_compared(event.time_s)) {
                let pair = pairs.entry((event.contact, event.kind.is_friction_event())).or_default();
                pair[side].push((event, time_ns));
            }
        }
        for ((contact, _), [log, new_run]) in pairs {
            self.compare_events(contact, &log, &new_run);
        }
        if self.has_run_end() && log_end.as_ref() != Some(&new_end) {
            let key = "(end of the run)".to_string();
            self.result.metadata.push(EntryDifference { key, log: log_end, new_run: Some(new_end) });
        }
        self.result.quantities = self.tallies.into_iter().flatten().collect();
        Ok(self.result)
    }

    /// Whether the end of the run is compared.
    fn has_run_end(&self) -> bool {
        self.options.has_run_end && self.options.before_ns.is_none()
    }

    fn is_compared(&self, time_s: f64) -> bool {
        self.options.before_ns.is_none_or(|before_ns| stamp_ns(time_s) < before_ns)
    }

    /// Returns the next sample of the log to be compared; reading ends at an invalid message.
    fn next_sample(&mut self) -> Result<Option<Sample>, ReadError> {
        loop {
            match self.log.samples.pop_front() {
                Some(sample) if self.is_compared(sample.time_s) => return Ok(Some(sample)),
                Some(_) => self.result.samples_not_compared += 1,
                None if self.is_log_read => return Ok(None),
                None => {
                    self.log.time_ns = self.reader.assembler.time_ns();
                    self.is_log_read = !self.reader.read_message(&mut self.log)?;
                }
            }
        }
    }

    /// Counts a sample that only one of the runs has.
    fn count_extra(&mut self, time_s: f64, in_log: bool) {
        let time = |exists: bool| exists.then_some(time_s);
        self.result.samples_only_in_log += u64::from(in_log);
        self.result.samples_only_in_new_run += u64::from(!in_log);
        self.result.record(Difference::new(time_s, "(next sample)", time(in_log), time(!in_log)));
    }

    fn compare(&mut self, log: &Sample, new_run: &Sample) {
        self.result.samples_compared += 1;
        self.result.compared_to_s = Some(log.time_s);
        let mut differs = false;
        for ([new_channel, channel], tally) in self.channels.iter().zip(&mut self.tallies) {
            let (a, b) = (channel.value(log), new_channel.value(new_run));
            if a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan() {
                continue;
            }
            differs = true;
            let difference = Difference::new(log.time_s, &channel.name, Some(a), Some(b));
            let tally = tally.get_or_insert_with(|| QuantityTally { samples: 0, largest: difference.clone() });
            tally.samples += 1;
            if difference.absolute > tally.largest.absolute {
                tally.largest = difference.clone();
            }
            self.result.record(difference);
        }
        self.result.samples_differing += u64::from(differs);
    }

    /// Compares the events of one contact. A log without the end of its run may lack events at its end.
    fn compare_events(&mut self, contact: usize, log: &[StampedEvent], new_run: &[StampedEvent]) {
        let name = &self.reader.assembler.schema().contacts[contact].name;
        let has_run_end = self.has_run_end();
        let result = &mut self.result;
        for index in 0..log.len().max(new_run.len()) {
            let (log, new_run) = (log.get(index), new_run.get(index));
            let counter = match (log, new_run) {
                (Some(_), None) => &mut result.events_only_in_log,
                (None, _) if has_run_end => &mut result.events_only_in_new_run,
                (None, _) => return,
                (Some(log), Some(new_run)) => {
                    result.events_compared += 1;
                    if log == new_run {
                        continue;
                    }
                    &mut result.events_differing
                }
            };
            *counter += 1;
            let Some((event, _)) = log.or(new_run) else { return };
            let only_log_time = log.zip(new_run).is_some_and(|(a, b)| a.0 == b.0);
            let suffix = if only_log_time { " (log time)" } else { "" };
            let quantity = format!("{name} {}{suffix}", event.kind.name());
            // A touch-down has a speed, a lift-off an impulse.
            let is_simultaneous = log.zip(new_run).is_some_and(|(a, b)| a.0.time_s == b.0.time_s);
            let value = |(event, time_ns): &StampedEvent| match is_simultaneous {
                _ if only_log_time => *time_ns as f64 * 1e-9,
                true => event.approach_speed + event.impulse,
                false => event.time_s,
            };
            result.record(Difference::new(event.time_s, &quantity, log.map(value), new_run.map(value)));
        }
    }
}

impl<R: Read + Seek> Sink for LogComparison<R> {
    fn required_data(&self) -> RequiredData {
        RequiredData { joint_forces: self.reader.assembler.schema().has_joint_forces, ..RequiredData::ALL }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.clock_ns = self.clock_ns.max(stamp_ns(sample.time_s));
        if !self.is_compared(sample.time_s) {
            return Ok(());
        }
        let to_sink_error = |error| SinkError { target: "the comparison".to_string(), source: io::Error::other(error) };
        while let Some(log) = self.next_sample().map_err(to_sink_error)? {
            if log.time_s >= sample.time_s {
                if log.time_s == sample.time_s {
                    self.compare(&log, sample);
                } else {
                    self.log.samples.push_front(log);
                    self.count_extra(sample.time_s, false);
                }
                return Ok(());
            }
            self.count_extra(log.time_s, true);
        }
        if self.has_run_end() {
            self.count_extra(sample.time_s, false);
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.clock_ns = self.clock_ns.max(stamp_ns(event.time_s));
        let index = self.contacts[event.contact];
        self.new_events.extend(index.map(|contact| (Event { contact, ..*event }, self.clock_ns)));
        Ok(())
    }
}
