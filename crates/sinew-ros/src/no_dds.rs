//! In the place of DDS where the program is built without it.

use crate::commands::Sender;
use crate::error::Error;
use crate::topics::Topic;
use sinew_link::Request;
use sinew_record::ros2::Cdr;
use std::net::IpAddr;

/// Nothing: there is no such value.
pub(crate) enum Graph {}

/// Something that another node sent.
pub(crate) struct Incoming {
    pub(crate) sender: Sender,
    pub(crate) fields: Vec<u8>,
    pub(crate) little_endian: bool,
    pub(crate) what: Asked,
}

/// What it asks for.
#[expect(dead_code, reason = "nobody asks without DDS")]
pub(crate) enum Asked {
    Trajectory,
    Setpoint,
    Mode(usize, Request),
}

impl Graph {
    pub(crate) fn new(_: u16, _: IpAddr, _: bool) -> Result<Self, Error> {
        Err(Error::NotBuilt)
    }

    pub(crate) fn publish(&self, _: Topic, _: &Cdr) -> bool {
        match *self {}
    }

    pub(crate) fn finish(&self) {
        match *self {}
    }

    pub(crate) fn next(&mut self) -> Option<Incoming> {
        match *self {}
    }

    pub(crate) fn answer(&self, _: &Incoming, _: &Cdr) {
        match *self {}
    }

    pub(crate) fn is_read(&mut self) -> bool {
        match *self {}
    }

    pub(crate) fn anyone(&self) -> bool {
        match *self {}
    }
}
